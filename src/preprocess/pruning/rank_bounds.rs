//! Bounds on ranks: no sample in a part of a picture is better than this.
//!
//! Purpose: a camera that holds nothing better than what was found already need not be asked.
//!
//! Source: a pyramid of extremes, as N. Greene, M. Kass and G. Miller have of depths, *Hierarchical Z-Buffer Visibility*, SIGGRAPH 1993.
//! What differs: it is asked for rectangles of any size, at the level at which few blocks cover one.

use crate::grid::Grid;
use crate::preprocess::layers::{CameraLayer, Ranks};

/// Columns and rows of a block of the finest level.
const BLOCK: usize = 8;

/// Blocks of a level beside each other in a rectangle, at most, for which this level is asked.
const MOST_BLOCKS: usize = 4;

/// A position is rounded by far less than this many pixels.
const ROUNDING_PX: f32 = 0.5;

/// The best ranks of a camera's samples, by either rate model, in blocks of pixels.
#[derive(Clone, Debug, Default)]
pub(super) struct RankBounds {
    /// Columns and rows of the picture.
    size: (usize, usize),
    /// From fine to coarse, each with half the columns and rows of the one before. None where nothing is known.
    levels: Vec<Grid<Ranks>>,
}

impl RankBounds {
    /// Of a layer.
    pub(super) fn of(layer: &CameraLayer) -> Self {
        let (width, height) = (layer.width, layer.height());
        if layer.ranks.is_empty() {
            return Self::default();
        }
        let mut finest = Grid::filled(width.div_ceil(BLOCK), height.div_ceil(BLOCK), Ranks::ABSENT);
        let across = finest.width();
        for (y, row) in layer.ranks.chunks(width).enumerate() {
            let blocks = &mut finest.as_mut_slice()[y / BLOCK * across..][..across];
            for (block, ranks) in blocks.iter_mut().zip(row.chunks(BLOCK)) {
                *block = ranks.iter().fold(*block, |best, ranks| best.best(*ranks));
            }
        }
        let mut levels = vec![finest];
        while levels[levels.len() - 1].len() > 1 {
            levels.push(halved(&levels[levels.len() - 1]));
        }
        Self { size: (width, height), levels }
    }

    /// The best ranks of samples in a rectangle, given by its least and greatest column and row in pixels; the best there can be where
    /// nothing is known.
    pub(super) fn in_rectangle(&self, rectangle: Option<[f32; 4]>) -> Ranks {
        let (Some([left, top, right, bottom]), false) = (rectangle, self.levels.is_empty()) else {
            return Ranks::BEST;
        };
        let (width, height) = self.size;
        let is_outside = right < -ROUNDING_PX
            || bottom < -ROUNDING_PX
            || left > width as f32 + ROUNDING_PX
            || top > height as f32 + ROUNDING_PX;
        if is_outside {
            return Ranks::ABSENT;
        }
        // Casts saturate, so that no position is negative.
        let first = |start: f32| (start - ROUNDING_PX) as usize / BLOCK;
        let last = |end: f32, size: usize| ((end + ROUNDING_PX) as usize).min(size - 1) / BLOCK;
        let columns = [first(left).min((width - 1) / BLOCK), last(right, width)];
        let rows = [first(top).min((height - 1) / BLOCK), last(bottom, height)];
        let is_few = |level: &usize| {
            [columns, rows].iter().all(|[first, last]| (last >> level) - (first >> level) < MOST_BLOCKS)
        };
        let level = (0..self.levels.len() - 1).find(is_few).unwrap_or(self.levels.len() - 1);
        let blocks = &self.levels[level];
        let mut best = Ranks::ABSENT;
        for row in rows[0] >> level..=rows[1] >> level {
            let row = &blocks.as_slice()[row * blocks.width()..][..blocks.width()];
            let row = &row[columns[0] >> level..=columns[1] >> level];
            best = row.iter().fold(best, |best, ranks| best.best(*ranks));
        }
        best
    }
}

/// The best of each two by two blocks.
fn halved(blocks: &Grid<Ranks>) -> Grid<Ranks> {
    let (width, height) = (blocks.width().div_ceil(2), blocks.height().div_ceil(2));
    let mut halved = Grid::filled(width, height, Ranks::ABSENT);
    for (y, row) in blocks.as_slice().chunks(blocks.width()).enumerate() {
        let halves = &mut halved.as_mut_slice()[y / 2 * width..][..width];
        for (half, two) in halves.iter_mut().zip(row.chunks(2)) {
            *half = two.iter().fold(*half, |best, ranks| best.best(*ranks));
        }
    }
    halved
}

#[cfg(test)]
mod tests {
    use super::*;

    use crate::random::mix;

    #[test]
    fn no_sample_in_a_rectangle_is_better_than_its_bound_which_one_nearby_has() {
        let mut seed = 5;
        let mut below = |limit: usize| {
            seed = mix(seed);
            (seed >> 20) as usize % limit
        };
        for (width, height) in [(1, 1), (7, 40), (61, 33), (130, 100)] {
            let mut layer = CameraLayer::empty(width, height);
            for ranks in &mut layer.ranks {
                *ranks = Ranks { rank: below(1 << 20) as u32, other_rank: below(1 << 20) as u32 };
            }
            let bounds = RankBounds::of(&layer);
            for _ in 0..200 {
                let (left, top) = (below(width), below(height));
                let (right, bottom) = (left + below(width - left), top + below(height - top));
                let within = |margin: usize| {
                    let rows = top.saturating_sub(margin)..(bottom + margin + 1).min(height);
                    let columns = left.saturating_sub(margin)..(right + margin + 1).min(width);
                    let pixels = rows.flat_map(|y| columns.clone().map(move |x| y * width + x));
                    pixels.fold(Ranks::ABSENT, |best, pixel| best.best(layer.ranks[pixel]))
                };
                let rectangle = [left, top, right, bottom].map(|position| position as f32 + 0.5);
                let bound = bounds.in_rectangle(Some(rectangle));
                assert_eq!(bound.best(within(0)), bound);
                let block = (right - left).max(bottom - top).max(BLOCK);
                assert_eq!(bound.best(within(block)), within(block));
            }
        }
    }

    #[test]
    fn beside_the_picture_there_is_nothing_and_where_nothing_is_known_anything() {
        let mut layer = CameraLayer::empty(20, 10);
        layer.ranks.fill(Ranks { rank: 7, other_rank: 9 });
        let bounds = RankBounds::of(&layer);
        for beside in [[-9.0, 1.0, -2.0, 3.0], [1.0, 12.0, 3.0, 14.0], [25.0, 1.0, 30.0, 2.0]] {
            assert_eq!(bounds.in_rectangle(Some(beside)), Ranks::ABSENT);
        }
        assert_eq!(bounds.in_rectangle(Some([-5.0, -5.0, 99.0, 99.0])), layer.ranks[0]);
        assert_eq!(bounds.in_rectangle(None), Ranks::BEST);
        assert_eq!(RankBounds::default().in_rectangle(Some([0.0, 0.0, 1.0, 1.0])), Ranks::BEST);
    }
}
