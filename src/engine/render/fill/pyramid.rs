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

struct PyramidLevel {
    width: usize,
    height: usize,
    cells: Vec<WeightedMean>,
    /// For each cell the finest level, from its own up, at which a cell around it is painted.
    first_painted: Vec<u8>,
}

/// All levels above the picture itself, finest first.
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
    pub(super) fn pull(picture: &Picture, sources: &[u32], tolerance: SurfaceTolerance) -> Self {
        let (width, height) = picture.image.size();
        let pixel = |x: usize, y: usize| {
            let pixel = y * width + x;
            let painted = sources[pixel] != NO_IMAGE;
            WeightedMean {
                color: picture.color.as_slice()[pixel],
                inverse_depth: picture.inverse_depth.as_slice()[pixel],
                weight: f32::from(u8::from(painted)),
            }
        };
        let mut levels = vec![halve((width, height), tolerance.factor(2.0), pixel)];
        while let Some(finer) = levels.last()
            && finer.cells.len() > 1
        {
            let factor = tolerance.factor((2 << levels.len()) as f32);
            levels.push(halve((finer.width, finer.height), factor, |x, y| finer.cells[y * finer.width + x]));
        }
        for index in (0..levels.len()).rev() {
            let (finer, coarser) = levels.split_at_mut(index + 1);
            finer[index].set_first_painted(index, coarser.first());
        }
        Self { levels }
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
    /// Sets [`PyramidLevel::first_painted`] of the level with this index.
    fn set_first_painted(&mut self, index: usize, coarser: Option<&Self>) {
        let (width, height, cells) = (self.width, self.height, &self.cells);
        self.first_painted = vec![index as u8; cells.len()];
        let Some(coarser) = coarser else { return };
        self.first_painted.par_chunks_mut(width).enumerate().with_min_len(16).for_each(|(row, first)| {
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

/// The next coarser level; inverse depths of one surface differ at most by `factor`.
fn halve(
    (width, height): (usize, usize),
    factor: f32,
    finer: impl Fn(usize, usize) -> WeightedMean + Sync,
) -> PyramidLevel {
    let (columns, rows) = (width.div_ceil(2), height.div_ceil(2));
    let mut cells = vec![WeightedMean::EMPTY; columns * rows];
    cells.par_chunks_mut(columns).enumerate().with_min_len(16).for_each(|(row, cells)| {
        for (column, cell) in cells.iter_mut().enumerate() {
            // The last block of an odd picture is smaller: its pixels count twice.
            let (right, below) = ((2 * column + 1).min(width - 1), (2 * row + 1).min(height - 1));
            let block = [(2 * column, 2 * row), (right, 2 * row), (2 * column, below), (right, below)]
                .map(|(x, y)| finer(x, y));
            let depths = block.map(|part| part.inverse_depth);
            let nearest = depths.iter().fold(0.0_f32, |all, w| all.max(*w));
            let least = depths.iter().fold(f32::INFINITY, |all, w| all.min(*w));
            // Nearly everywhere, and many times as fast as picking parts out.
            let is_one_surface =
                block.iter().fold(true, |all, part| all & (part.weight > 0.0)) & (nearest <= least * factor);
            if is_one_surface {
                let mut sum = WeightedMean::EMPTY;
                for part in &block {
                    sum.add(part.weight, part.color, part.inverse_depth);
                }
                *cell = sum.normalized();
                cell.weight /= 4.0;
                continue;
            }
            let painted = || block.iter().filter(|part| part.weight > 0.0);
            let farthest = painted().map(|part| part.inverse_depth).fold(f32::INFINITY, f32::min);
            let mut sum = WeightedMean::EMPTY;
            for part in painted().filter(|part| part.inverse_depth <= farthest * factor) {
                sum.add(part.weight, part.color, part.inverse_depth);
            }
            if sum.weight > 0.0 {
                *cell = sum.normalized();
                cell.weight /= 4.0;
            }
        }
    });
    PyramidLevel { width: columns, height: rows, cells, first_painted: Vec::new() }
}
