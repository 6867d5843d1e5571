//! One tile of a frame's samples, where the images hold it.

use half::f16;

use crate::color::widened;
use crate::samples::{SampleImage, TILE, TileDepths};
use crate::simd;

/// A tile of the frame, with everything that its samples are read from.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FrameTile<'a> {
    /// One mask per pixel row, as in [`SampleTile`](crate::samples::SampleTile).
    pub(crate) rows: [u16; TILE],
    /// Samples in the rows above each row.
    before: [u8; TILE],
    /// One color per sample.
    pub(crate) color: &'a [[f16; 3]],
    /// One inverse depth per sample.
    pub(crate) depths: TileDepths<'a>,
    /// Column and row of the tile's first pixel in the camera.
    pub(crate) origin: (u32, u32),
    /// Index of the camera.
    pub(crate) camera: u16,
    /// Where it holds doubtful samples, as [`FrameTile::rows`]; `None` where it holds none.
    doubtful: Option<&'a [u16; TILE]>,
}

impl<'a> FrameTile<'a> {
    /// The tile of an image with an index.
    #[inline(always)]
    pub(crate) fn new(image: &'a SampleImage, index: usize) -> Self {
        let tile = &image.tiles[index];
        let before = samples_above(&tile.rows);
        let count = usize::from(before[TILE - 1]) + tile.rows[TILE - 1].count_ones() as usize;
        let samples = tile.first as usize..tile.first as usize + count;
        Self {
            rows: tile.rows,
            before,
            depths: image.depth.tile(index, tile.first, samples.len()),
            color: &image.color[samples],
            origin: (u32::from(tile.tile_x) * TILE as u32, u32::from(tile.tile_y) * TILE as u32),
            camera: image.camera as u16,
            doubtful: image.doubtful_rows(index),
        }
    }

    /// Which pixels of a row hold doubtful samples: a mask of columns.
    #[inline(always)]
    pub(crate) fn doubtful_columns(&self, row: usize) -> u16 {
        self.doubtful.map_or(0, |rows| rows[row])
    }

    /// Samples before a pixel of the tile.
    #[inline(always)]
    pub(crate) fn rank(&self, column: usize, row: usize) -> usize {
        self.before[row] as usize + (self.rows[row] & ((1 << column) - 1)).count_ones() as usize
    }

    /// The color of a sample, linear.
    #[inline(always)]
    pub(crate) fn color(&self, nth: usize) -> [f32; 3] {
        linear(self.color[nth])
    }

    /// Prefetches the depths.
    #[inline(always)]
    pub(crate) fn prefetch_depths(&self) {
        let (low, high) = self.depths.planes();
        (0..low.len()).step_by(32).for_each(|at| simd::prefetch(low, at));
        (0..high.len()).step_by(64).for_each(|at| simd::prefetch(high, at));
    }

    /// Prefetches depths and colors.
    #[inline(always)]
    pub(crate) fn prefetch(&self) {
        self.prefetch_depths();
        // Ten colors to a cache line.
        (0..self.color.len()).step_by(10).for_each(|at| simd::prefetch(self.color, at));
    }

    /// The three half floats of a color, red lowest.
    #[inline(always)]
    pub(crate) fn bits_of(color: [f16; 3]) -> u64 {
        let [red, green, blue] = color.map(|half| u64::from(half.to_bits()));
        red | green << 16 | blue << 32
    }
}

/// A color as it is stored, widened.
#[inline(always)]
pub(crate) fn linear(color: [f16; 3]) -> [f32; 3] {
    color.map(|half| widened(half.to_bits().cast_signed()))
}

/// The number of samples in the rows above each row of a tile.
#[inline(always)]
pub(crate) fn samples_above(rows: &[u16; TILE]) -> [u8; TILE] {
    let mut count = 0;
    rows.map(|row| {
        let above = count as u8;
        count += row.count_ones();
        above
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_above_a_row_are_counted() {
        let mut rows = [0; TILE];
        (rows[0], rows[2], rows[15]) = (0b101, 0xffff, 1);
        let above = samples_above(&rows);
        assert_eq!([0, 1, 2, 3, 15].map(|row| above[row]), [0, 2, 2, 18, 18]);
    }
}
