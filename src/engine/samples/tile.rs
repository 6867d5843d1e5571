//! Tiles of a sample image.

/// Columns and rows of a tile.
pub const TILE: usize = 16;

/// A tile of a [`SampleImage`](super::sample_set::SampleImage) that holds at least one sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct SampleTile {
    /// Column of the tile, in tiles from the left.
    pub tile_x: u16,
    /// Row of the tile, in tiles from the top.
    pub tile_y: u16,
    /// Index of the tile's first sample in the planes of its image.
    pub first: u32,
    /// One mask per pixel row, bit `x` for column `x` of the tile.
    pub rows: [u16; TILE],
}

impl SampleTile {
    /// Samples in the tile.
    #[must_use]
    pub fn count(&self) -> usize {
        self.rows.iter().map(|row| row.count_ones() as usize).sum()
    }

    /// Every sample with its pixel, in storage order.
    pub fn samples(&self) -> impl Iterator<Item = Sample> {
        let mut index = self.first as usize;
        self.rows.iter().enumerate().flat_map(move |(row, &mask)| {
            let first = index;
            index += mask.count_ones() as usize;
            (0..TILE).filter(move |column| mask >> column & 1 == 1).enumerate().map(move |(nth, column)| {
                Sample {
                    x: self.tile_x as usize * TILE + column,
                    y: self.tile_y as usize * TILE + row,
                    index: first + nth,
                }
            })
        })
    }
}

/// One sample, as [`SampleTile::samples`] gives them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Column of the pixel.
    pub x: usize,
    /// Row of the pixel.
    pub y: usize,
    /// Index into the planes.
    pub index: usize,
}

/// Some samples of a tile of a [`SampleImage`](super::sample_set::SampleImage).
#[derive(Clone, Copy, Debug, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct TileMask {
    /// Index of the tile in its image.
    pub tile: u32,
    /// One mask per pixel row, as [`SampleTile::rows`]; only bits of samples are set, and at least one is.
    pub rows: [u16; TILE],
}
