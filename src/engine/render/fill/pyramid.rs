//! The pyramid: means of ever larger blocks of painted pixels, each of one surface alone.
//!
//! ```text
//! pull    level 1: 2×2 pixels a cell    level 2: 4×4    …    top: the whole picture
//! push    a hole pixel blends the four cells around it at level 1, covers what they leave open from level 2, and so on
//! ```
//!
//! A cell covers less where little of its block was painted. Pushing reads bilinearly at every level, so that neither the cells'
//! borders nor the change from one level to the next is seen.

use rayon::prelude::*;

use super::surface::{HoleSurface, SurfaceTolerance, WeightedMean};
use crate::render::vantage::{NO_IMAGE, Picture};

#[derive(Debug, Default)]
struct PyramidLevel {
    width: usize,
    height: usize,
    cells: Vec<WeightedMean>,
    /// For each cell the finest level, from its own up, at which a cell around it is painted.
    first_painted: Vec<u8>,
}

/// All levels above the picture itself, finest first; none before they are pulled.
#[derive(Debug, Default)]
pub(super) struct Pyramid {
    levels: Vec<PyramidLevel>,
}

/// A block counts fully if at least this share of it is painted; with less, the painted part may lie to one side. From 0.12 to 1,
/// one half is nearest to a smooth surface, and costs the real captures nothing.
const FULL_SHARE: f32 = 0.5;

/// Blocks up to this many times as wide as the distance to the surface count; wider ones show other parts of the picture.
const MAX_BLOCK_RATIO: f32 = 8.0;

/// Filling a pixel ends when less than this share of it is open: one more level would not be visible.
const MAX_OPEN_SHARE: f32 = 1.0 / 64.0;

impl Pyramid {
    /// Builds the levels from the pixels of a picture whose `sources` are not [`NO_IMAGE`]: every cell is the mean of the farthest
    /// surface in its block.
    pub(super) fn pull(&mut self, picture: &Picture, sources: &[u32], tolerance: SurfaceTolerance) {
        let (width, height) = picture.image.size();
        let (colors, depths) = (picture.color.as_slice(), picture.inverse_depth.as_slice());
        let pixel = |x: usize, y: usize| {
            let pixel = y * width + x;
            let weight = if sources[pixel] == NO_IMAGE { 0.0 } else { 1.0 };
            WeightedMean { color: colors[pixel], inverse_depth: depths[pixel], weight }
        };
        // A level halves its size, until one cell is left.
        let count = (width.max(height).max(2) - 1).ilog2() as usize + 1;
        self.levels.resize_with(count, PyramidLevel::default);
        self.levels[0].halve((width, height), tolerance.factor(2.0), pixel);
        for index in 1..count {
            let factor = tolerance.factor((2 << index) as f32);
            let (finer, coarser) = self.levels.split_at_mut(index);
            let PyramidLevel { width, height, cells, .. } = &finer[index - 1];
            coarser[0].halve((*width, *height), factor, |x, y| cells[y * width + x]);
        }
        for index in (0..count).rev() {
            let (finer, coarser) = self.levels.split_at_mut(index + 1);
            finer[index].set_first_painted(index, coarser.first());
        }
    }

    /// The color and inverse depth for a hole pixel, from cells of `surface`; without a surface any cell counts. `None` if no such cell
    /// is painted.
    pub(super) fn push(
        &self,
        (x, y): (usize, usize),
        surface: Option<&HoleSurface>,
        tolerance: SurfaceTolerance,
    ) -> Option<WeightedMean> {
        let largest_px = surface.map_or(f32::INFINITY, |surface| MAX_BLOCK_RATIO * surface.reach_px);
        let mut sum = WeightedMean::EMPTY;
        let first = self.levels[0].first_painted[y / 2 * self.levels[0].width + x / 2] as usize;
        for (index, level) in self.levels.iter().enumerate().skip(first) {
            let block_px = (2 << index) as f32;
            if block_px > largest_px || sum.weight > 1.0 - MAX_OPEN_SHARE {
                break;
            }
            let factor = tolerance.factor(block_px);
            let [farthest, nearest] = surface.map_or([0.0, f32::INFINITY], |surface| {
                [surface.range[0] / factor, surface.range[1] * factor]
            });
            let open = 1.0 - sum.weight;
            for (cell, share) in level.around((x, y), index + 1) {
                let counts =
                    (cell.weight > 0.0) & (farthest <= cell.inverse_depth) & (cell.inverse_depth <= nearest);
                let weight = open * share * (cell.weight / FULL_SHARE).min(1.0);
                // Adding nothing is faster than a branch that is hard to foresee.
                sum.add(if counts { weight } else { 0.0 }, cell.color, cell.inverse_depth);
            }
        }
        (sum.weight > 0.0).then(|| sum.normalized())
    }
}

impl PyramidLevel {
    /// Sets the cells from the next finer level, of `width` columns and `height` rows; inverse depths of one surface differ at most by
    /// `factor`.
    fn halve(
        &mut self,
        (width, height): (usize, usize),
        factor: f32,
        finer: impl Fn(usize, usize) -> WeightedMean + Sync,
    ) {
        let (columns, rows) = (width.div_ceil(2), height.div_ceil(2));
        (self.width, self.height) = (columns, rows);
        self.cells.resize(columns * rows, WeightedMean::EMPTY);
        self.cells.par_chunks_mut(columns).enumerate().with_min_len(16).for_each(|(row, cells)| {
            for (column, cell) in cells.iter_mut().enumerate() {
                // The last block of an odd picture is smaller: its pixels count twice.
                let (left, top) = (2 * column, 2 * row);
                let (right, below) = ((left + 1).min(width - 1), (top + 1).min(height - 1));
                let block = [finer(left, top), finer(right, top), finer(left, below), finer(right, below)];
                *cell = mean_of_farthest(&block, factor);
            }
        });
    }

    /// Sets [`PyramidLevel::first_painted`] of the level with this index.
    fn set_first_painted(&mut self, index: usize, coarser: Option<&Self>) {
        let (width, height, cells) = (self.width, self.height, &self.cells);
        self.first_painted.resize(cells.len(), 0);
        self.first_painted.par_chunks_mut(width).enumerate().with_min_len(16).for_each(|(row, first)| {
            first.fill(index as u8);
            let Some(coarser) = coarser else { return };
            let rows = row.saturating_sub(1)..(row + 2).min(height);
            for (column, first) in first.iter_mut().enumerate() {
                let columns = column.saturating_sub(1)..(column + 2).min(width);
                let mut around = rows.clone().map(|row| &cells[row * width..][columns.clone()]);
                if around.all(|cells| cells.iter().all(|cell| cell.weight == 0.0)) {
                    *first = coarser.first_painted[row / 2 * coarser.width + column / 2];
                }
            }
        });
    }

    /// The four cells around a pixel's center with their bilinear shares; at the picture's edge the outermost cells repeat.
    /// Blocks are `1 << log2_block` pixels wide.
    #[inline(always)]
    fn around(&self, (x, y): (usize, usize), log2_block: usize) -> [(&WeightedMean, f32); 4] {
        // In whole halves of a pixel, because rounding down is slow in floats.
        let ends = |pixel: usize, count: usize| {
            let past_center = (2 * pixel + 1) as isize - (1_isize << log2_block);
            let first = past_center >> (log2_block + 1);
            let rest = past_center - (first << (log2_block + 1));
            let share = rest as f32 / (2_usize << log2_block) as f32;
            let inside = |index: isize| (index.max(0) as usize).min(count - 1);
            [(inside(first), 1.0 - share), (inside(first + 1), share)]
        };
        let (columns, rows) = (ends(x, self.width), ends(y, self.height));
        [(0, 0), (0, 1), (1, 0), (1, 1)].map(|(row, column)| {
            let ((row, share_y), (column, share_x)) = (rows[row], columns[column]);
            (&self.cells[row * self.width + column], share_x * share_y)
        })
    }
}

/// The mean of the farthest surface of a block of four; inverse depths of one surface differ at most by `factor`.
#[inline]
fn mean_of_farthest(block: &[WeightedMean; 4], factor: f32) -> WeightedMean {
    let [a, b, c, d] = block.each_ref().map(|part| part.inverse_depth);
    let nearest = a.max(b).max(c.max(d));
    let least = a.min(b).min(c.min(d));
    let mut sum = WeightedMean::EMPTY;
    // Nearly everywhere, and many times as fast as picking parts out.
    let is_painted =
        (block[0].weight > 0.0) & (block[1].weight > 0.0) & (block[2].weight > 0.0) & (block[3].weight > 0.0);
    if is_painted & (nearest <= least * factor) {
        for part in block {
            sum.add(part.weight, part.color, part.inverse_depth);
        }
    } else {
        let mut farthest = f32::INFINITY;
        for part in block {
            farthest = farthest.min(if part.weight > 0.0 { part.inverse_depth } else { f32::INFINITY });
        }
        for part in block {
            if part.weight > 0.0 && part.inverse_depth <= farthest * factor {
                sum.add(part.weight, part.color, part.inverse_depth);
            }
        }
        if sum.weight == 0.0 {
            return WeightedMean::EMPTY;
        }
    }
    let mean = sum.normalized();
    WeightedMean { weight: mean.weight / 4.0, ..mean }
}
