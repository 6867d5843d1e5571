//! Two painted layers, background and foreground, and what they show together.

use std::ops::Range;

use rayon::prelude::*;

use crate::render::gather::{BLOCK, BlockOrigin, Patch, RING, SIDE, ScratchPool, SourceViews};
use crate::render::geometry::TileBounds;
use crate::render::splat::{BlendSum, LEAST_WEIGHT, StageInput, inverse_depth_of, slot_of};
use crate::render::vantage::Picture;

/// The z-buffer and the blended colors of some tiles, row-major.
#[derive(Clone, Debug, Default)]
pub(crate) struct PaintedLayer {
    /// Z-buffer keys; 0 where nothing was painted.
    pub(crate) keys: Vec<u64>,
    /// Blended colors; empty for kernels that do not blend.
    pub(crate) sums: Vec<BlendSum>,
}

impl PaintedLayer {
    /// Clears the layer and gives it this many keys and sums.
    pub(crate) fn reset(&mut self, keys: usize, sums: usize) {
        clear(&mut self.keys, keys, 0);
        clear(&mut self.sums, sums, [0.0; 4]);
    }

    /// Gives the layer this many keys and sums; those that are new are empty.
    pub(crate) fn resize(&mut self, keys: usize, sums: usize) {
        self.keys.resize(keys, 0);
        self.sums.resize(sums, [0.0; 4]);
    }

    /// Clears some blocks of the layer, whose z-buffer has `width` columns.
    pub(crate) fn clear(&mut self, blocks: &BlockSet, width: usize) {
        blocks.clear(width, &mut self.keys, 0);
        blocks.clear(width, &mut self.sums, [0.0; 4]);
    }
}

/// Every other column of a block, from the first on.
const EVEN_COLUMNS: u16 = 0x5555;

fn clear<T: Copy + Send + Sync>(buffer: &mut Vec<T>, length: usize, value: T) {
    buffer.truncate(length);
    buffer.par_chunks_mut(1 << 16).for_each(|part| part.fill(value));
    buffer.resize(length, value);
}

/// Everything that a picture is resolved from.
pub(crate) struct ResolveInput<'a> {
    pub(crate) stage: &'a StageInput<'a>,
    pub(crate) background: &'a PaintedLayer,
    /// `None` to resolve the background alone.
    pub(crate) foreground: Option<&'a PaintedLayer>,
    /// The picture of the background alone, if it exists already.
    pub(crate) background_picture: Option<&'a Picture>,
    /// For the gather kernel: the cameras' samples of the background, and those of both layers.
    pub(crate) views: Option<[&'a SourceViews<'a>; 2]>,
    pub(crate) scratches: &'a ScratchPool,
    /// Pixels of the z-buffer along each side of a pixel of the picture: 1, or 2 for the gather kernel.
    pub(crate) subpixels: usize,
}

impl ResolveInput<'_> {
    /// Rows of the z-buffer.
    pub(super) fn height(&self) -> usize {
        self.background.keys.len() / self.stage.width
    }

    /// The pixels of a block within [`RING`] pixels of a visible foreground sample, and those that share a pixel of the picture with
    /// one: a mask of columns per row.
    #[inline(always)]
    pub(super) fn near_foreground(&self, block: BlockOrigin, foreground: &PaintedLayer) -> [u16; BLOCK] {
        let mut seen = [0_u32; SIDE];
        let (mut front, mut back) = ([0; SIDE], [0; SIDE]);
        for (row, seen) in seen.iter_mut().enumerate() {
            let front = self.patch_row(&foreground.keys, block, row, &mut front);
            if front.iter().fold(0, |all, key| all | key) == 0 {
                continue;
            }
            let back = self.patch_row(&self.background.keys, block, row, &mut back);
            for column in 0..SIDE {
                *seen |= u32::from(self.shows(front[column], back[column])) << column;
            }
        }
        let mut near = [0; BLOCK];
        if seen == [0; SIDE] {
            return near;
        }
        for seen in &mut seen {
            *seen = (0..=2 * RING).fold(0, |near, step| near | *seen >> step);
        }
        for (row, near) in near.iter_mut().enumerate() {
            *near = seen[row..=row + 2 * RING].iter().fold(0, |near, seen| near | seen) as u16;
        }
        if self.subpixels == 2 {
            for rows in near.as_chunks_mut::<2>().0 {
                let either = rows[0] | rows[1];
                let pairs = (either | either >> 1) & EVEN_COLUMNS;
                rows.fill(pairs | pairs << 1);
            }
        }
        near
    }

    /// Whether the foreground sample of key `front` is visible over the background's key `back`.
    #[inline(always)]
    pub(super) fn shows(&self, front: u64, back: u64) -> bool {
        // A core sample wins over a fringe sample that lies before it.
        front > back
            || front != 0 && inverse_depth_of(front) >= inverse_depth_of(back) * self.stage.surface_ratio
    }

    /// The nearer key of both layers.
    #[inline(always)]
    pub(super) fn key(&self, pixel: usize) -> u64 {
        let back = self.background.keys[pixel];
        self.foreground.map_or(back, |front| back.max(front.keys[pixel]))
    }

    /// The blended color of both layers where they show the surface of `key`, else the color of that sample.
    #[inline(always)]
    pub(super) fn blended(&self, pixel: usize, key: u64) -> [f32; 3] {
        let limit = inverse_depth_of(key) * self.stage.surface_ratio;
        let mut sum: BlendSum = [0.0; 4];
        for layer in [Some(self.background), self.foreground].into_iter().flatten() {
            if let Some(part) = layer.sums.get(pixel)
                && inverse_depth_of(layer.keys[pixel]) >= limit
            {
                (0..4).for_each(|channel| sum[channel] += part[channel]);
            }
        }
        if sum[3] >= LEAST_WEIGHT {
            [sum[0] / sum[3], sum[1] / sum[3], sum[2] / sum[3]]
        } else {
            self.stage.frame.color_of(slot_of(key))
        }
    }

    /// Loads a block and its ring: the nearer keys of the background and of a foreground.
    #[inline(always)]
    pub(super) fn load(&self, block: BlockOrigin, foreground: Option<&PaintedLayer>, patch: &mut Patch) {
        (patch.left, patch.top) = (block.left, block.top);
        (patch.surface_ratio, patch.subpixels) = (self.stage.surface_ratio, self.subpixels);
        let mut border = [0; SIDE];
        for (row, keys) in patch.keys.iter_mut().enumerate() {
            *keys = *self.patch_row(&self.background.keys, block, row, &mut border);
            if let Some(foreground) = foreground {
                let front = self.patch_row(&foreground.keys, block, row, &mut border);
                keys.iter_mut().zip(front).for_each(|(key, front)| *key = (*key).max(*front));
            }
        }
        patch.set_depths();
    }

    /// A row of a block with its ring out of a layer's keys. Beyond the picture the outermost pixels repeat; such a row is put
    /// together in `border`.
    #[inline(always)]
    fn patch_row<'b>(
        &self,
        keys: &'b [u64],
        block: BlockOrigin,
        row: usize,
        border: &'b mut [u64; SIDE],
    ) -> &'b [u64; SIDE] {
        let y = (block.top + row).saturating_sub(RING).min(self.height() - 1);
        let keys = &keys[y * self.stage.width..][..self.stage.width];
        if let Some(left) = block.left.checked_sub(RING)
            && let Some(keys) = keys[left..].first_chunk::<SIDE>()
        {
            return keys;
        }
        for (column, key) in border.iter_mut().enumerate() {
            *key = keys[(block.left + column).saturating_sub(RING).min(self.stage.width - 1)];
        }
        border
    }
}

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
    fn clear<T: Copy + Send + Sync>(&self, width: usize, buffer: &mut [T], value: T) {
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
