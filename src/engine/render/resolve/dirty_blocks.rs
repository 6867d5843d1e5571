//! Blocks of 16×16 pixels of the z-buffer: what is repainted when a foreground moves over a still background.

use std::ops::Range;

use rayon::prelude::*;

use crate::render::gather::BLOCK;
use crate::render::geometry::TileBounds;

/// A set of blocks.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct BlockSet {
    across: usize,
    marked: Vec<bool>,
}

impl BlockSet {
    /// None of the blocks of a z-buffer.
    pub(crate) fn none(width: usize, height: usize) -> Self {
        let across = width.div_ceil(BLOCK);
        Self { across, marked: vec![false; across * height.div_ceil(BLOCK)] }
    }

    /// None of the blocks of the same z-buffer.
    pub(crate) fn emptied(&self) -> Self {
        Self { across: self.across, marked: vec![false; self.marked.len()] }
    }

    /// All of them.
    pub(crate) fn all(width: usize, height: usize) -> Self {
        let mut blocks = Self::none(width, height);
        blocks.marked.fill(true);
        blocks
    }

    /// Adds the blocks that `bounds`, widened by `reach` pixels on each side, touch.
    pub(crate) fn mark(&mut self, bounds: &[TileBounds], reach: usize) {
        let down = self.marked.len().checked_div(self.across).unwrap_or(0);
        for place in bounds.iter().filter(|place| !place.is_empty()) {
            let first = |start: u32| (start as usize).saturating_sub(reach) / BLOCK;
            let last = |end: u32, count: usize| ((end as usize - 1 + reach) / BLOCK).min(count - 1);
            for row in first(place.top)..=last(place.bottom, down) {
                let start = row * self.across;
                self.marked[start + first(place.left)..=start + last(place.right, self.across)].fill(true);
            }
        }
    }

    /// Adds the blocks of another set of the same z-buffer.
    pub(crate) fn join(&mut self, other: &Self) {
        self.marked.iter_mut().zip(&other.marked).for_each(|(mine, theirs)| *mine |= *theirs);
    }

    /// Sets the pixels of the blocks, in a layer of the z-buffer, `width` columns wide.
    pub(crate) fn clear<T: Copy + Send + Sync>(&self, width: usize, buffer: &mut [T], value: T) {
        buffer.par_chunks_mut(BLOCK * width).enumerate().for_each(|(row, strip)| {
            for columns in self.columns(row, width, BLOCK) {
                strip.chunks_mut(width).for_each(|pixels| pixels[columns.clone()].fill(value));
            }
        });
    }

    /// Counts the pixels of the blocks for which `is` holds, in a plane of the picture that is `width` columns wide. Each of its pixels has
    /// `subpixels` pixels of the z-buffer along its sides.
    pub(crate) fn count<T: Sync>(
        &self,
        plane: &[T],
        width: usize,
        subpixels: usize,
        is: impl Fn(&T) -> bool + Sync,
    ) -> u64 {
        let side = BLOCK / subpixels;
        let strips = plane.par_chunks(side * width).enumerate();
        let count_in = |pixels: &[T]| pixels.iter().map(|pixel| u64::from(is(pixel))).sum::<u64>();
        let counts = strips.map(|(row, strip)| {
            let blocks = self.columns(row, width, side);
            let rows = blocks.flat_map(|columns| strip.chunks(width).map(move |row| &row[columns.clone()]));
            rows.map(count_in).sum::<u64>()
        });
        counts.sum()
    }

    /// Columns of pixels of each block of a row that is in the set, where a block is `side` pixels wide.
    fn columns(&self, row: usize, width: usize, side: usize) -> impl Iterator<Item = Range<usize>> {
        let columns = (0..self.across).filter(move |column| self.contains(*column, row));
        columns.map(move |column| column * side..((column + 1) * side).min(width))
    }

    /// Whether a block is in the set.
    #[inline(always)]
    pub(crate) fn contains(&self, column: usize, row: usize) -> bool {
        self.marked[row * self.across + column]
    }
}
