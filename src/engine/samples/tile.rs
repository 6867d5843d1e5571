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
