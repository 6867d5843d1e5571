//! The resolve stage: from keys and sums to a picture, block by block.
//!
//! The foreground of a frame is painted over the background by depth (the paper, §3.3). A pixel that no foreground reaches is
//! the background's own; where one does, both are resolved together. Which pixels those are depends on the frame and the
//! vantage alone, so that painting over a cached background gives the very picture that painting everything anew gives.

mod dirty_blocks;
mod per_pixel;

pub(crate) use dirty_blocks::BlockSet;

use rayon::prelude::*;

use super::gather::{BLOCK, GatherScratch, Patch, RING, SIDE, ScratchPool, SourceViews};
use super::input::FrameSamples;
use super::splat::{LEAST_WEIGHT, Sum, inverse_depth_of, slot_of};
use super::vantage::{NO_IMAGE, Picture};
use crate::error::Result;
use crate::job::Job;
use crate::settings::Kernel;
use crate::simd::VectorLoop;
use per_pixel::{ForegroundPixel, put};

/// What was painted of some tiles.
#[derive(Clone, Debug, Default)]
pub(crate) struct PaintedLayer {
    /// See [`crate::render::splat`]; row-major.
    pub(crate) keys: Vec<u64>,
    /// Blended colors; empty for kernels that do not blend.
    pub(crate) sums: Vec<Sum>,
}

impl PaintedLayer {
    /// Nothing painted, on so many pixels.
    pub(crate) fn reset(&mut self, keys: usize, sums: usize) {
        clear(&mut self.keys, keys, 0);
        clear(&mut self.sums, sums, [0.0; 4]);
    }
}

fn clear<T: Copy + Send + Sync>(buffer: &mut Vec<T>, length: usize, value: T) {
    buffer.truncate(length);
    buffer.par_chunks_mut(1 << 16).for_each(|part| part.fill(value));
    buffer.resize(length, value);
}

/// Everything that a picture is resolved from.
pub(crate) struct Resolve<'a> {
    pub(crate) frame: &'a FrameSamples<'a>,
    pub(crate) kernel: Kernel,
    pub(crate) width: usize,
    pub(crate) surface_ratio: f32,
    pub(crate) background: &'a PaintedLayer,
    /// Left out to resolve the background alone.
    pub(crate) foreground: Option<&'a PaintedLayer>,
    /// The picture of the background alone, where there is one already.
    pub(crate) background_picture: Option<&'a Picture>,
    /// Where the kernel gathers: among the lasting samples, and among all.
    pub(crate) gather: Option<[&'a SourceViews<'a>; 2]>,
    pub(crate) scratches: &'a ScratchPool,
    pub(crate) job: &'a Job,
}

/// Sixteen rows of the three planes of a picture.
pub(crate) struct PictureRows<'a> {
    pub(crate) color: &'a mut [[f32; 3]],
    pub(crate) inverse_depth: &'a mut [f32],
    pub(crate) image: &'a mut [u32],
}

impl PictureRows<'_> {
    #[inline(always)]
    pub(crate) fn set(&mut self, frame: &FrameSamples<'_>, at: usize, key: u64, color: [f32; 3]) {
        self.color[at] = color;
        self.inverse_depth[at] = inverse_depth_of(key);
        self.image[at] = if key == 0 { NO_IMAGE } else { frame.image_of(slot_of(key)) };
    }
}

impl Resolve<'_> {
    /// Resolves the blocks of `which` into `picture`; others are left as they are.
    ///
    /// # Errors
    /// `Cancelled`.
    pub(crate) fn resolve(&self, which: &BlockSet, picture: &mut Picture) -> Result<()> {
        // Neighboring blocks look at the same tiles of the cameras, those below as well as those beside.
        let gathers = self.gather.is_some();
        let tall = if gathers && self.height() >= TALL * BLOCK * 4 * rayon::current_num_threads() {
            TALL
        } else {
            1
        };
        let strip = tall * BLOCK * self.width;
        let color = picture.color.as_mut_slice().par_chunks_mut(strip);
        let depth = picture.inverse_depth.as_mut_slice().par_chunks_mut(strip);
        let image = picture.image.as_mut_slice().par_chunks_mut(strip);
        let strips = color.zip(depth).zip(image).enumerate();
        let cameras = self.frame.set.cameras.len();
        strips.try_for_each_init(
            || self.scratches.borrow(cameras),
            |scratch, (nth, ((color, inverse_depth), image))| {
                self.job.check()?;
                let row = BLOCK * self.width;
                let rows =
                    color.chunks_mut(row).zip(inverse_depth.chunks_mut(row)).zip(image.chunks_mut(row));
                let strips = rows.enumerate().map(|(below, ((color, inverse_depth), image))| Strip {
                    resolve: self,
                    row: nth * tall + below,
                    rows: PictureRows { color, inverse_depth, image },
                });
                crate::simd::run(StripGroup { which, scratch: scratch.get(cameras), rows: strips.collect() });
                Ok(())
            },
        )
    }
}

/// Rows of blocks that are gathered together, a column of them at a time.
const TALL: usize = 2;

struct StripGroup<'a> {
    which: &'a BlockSet,
    scratch: &'a mut GatherScratch,
    rows: Vec<Strip<'a>>,
}

/// A row of blocks.
pub(crate) struct Strip<'a> {
    pub(crate) resolve: &'a Resolve<'a>,
    /// Of blocks.
    pub(crate) row: usize,
    pub(crate) rows: PictureRows<'a>,
}

impl VectorLoop for StripGroup<'_> {
    type Output = ();

    #[inline(always)]
    fn run(mut self) {
        let Some(resolve) = self.rows.first().map(|strip| strip.resolve) else { return };
        let blocks = resolve.width.div_ceil(BLOCK);
        if resolve.kernel == Kernel::Point
            && resolve.background_picture.is_none()
            && resolve.frame.tile_count() > 0
        {
            for strip in &mut self.rows {
                strip.points_of(self.which);
            }
            return;
        }
        let mut shown = Vec::new();
        for column in 0..blocks {
            for strip in self.rows.iter_mut().filter(|strip| self.which.contains(column, strip.row)) {
                strip.block(column, self.scratch, &mut shown);
            }
        }
    }
}

impl Strip<'_> {
    /// Resolves one block.
    #[inline(always)]
    fn block(&mut self, column: usize, scratch: &mut GatherScratch, shown: &mut Vec<ForegroundPixel>) {
        let resolve = self.resolve;
        let block = BlockOrigin { left: column * BLOCK, top: self.row * BLOCK };
        if resolve.gather.is_some() {
            self.gather(&block, scratch);
        } else if let (Some(foreground), Some(background)) = (resolve.foreground, resolve.background_picture)
        {
            self.copy(&block, background);
            self.paint_over(&block, foreground, shown);
        } else {
            self.blend(&block);
        }
    }

    /// Gathers one block: pixels beside which a foreground is seen among all samples, others among those of the background
    /// alone, which is what the background's picture shows there.
    #[inline(always)]
    fn gather(&mut self, block: &BlockOrigin, scratch: &mut GatherScratch) {
        let resolve = self.resolve;
        let Some([among_lasting, among_all]) = resolve.gather else { return };
        let near = resolve.foreground.map_or([0; BLOCK], |layer| resolve.near_foreground(block, layer));
        // One loop for both, so that the code, which is all inlined, is there once.
        for (nth, gather) in [among_lasting, among_all].into_iter().enumerate() {
            let among_all = nth == 1;
            let which = if among_all { near } else { near.map(|near| !near) };
            if which == [0; BLOCK] {
                continue;
            }
            if !among_all && let Some(background) = resolve.background_picture {
                self.copy(block, background);
                continue;
            }
            resolve.load(block, resolve.foreground.filter(|_| among_all), &mut scratch.patch);
            scratch.gather((gather, nth), resolve.frame, &which, (&mut self.rows, resolve.width));
        }
    }
}

/// Column and row of the first pixel of a block.
pub(crate) struct BlockOrigin {
    pub(crate) left: usize,
    pub(crate) top: usize,
}

impl Resolve<'_> {
    fn height(&self) -> usize {
        self.background.keys.len() / self.width
    }

    /// The pixels of a block beside which, as far as decisions at an edge look, a foreground sample is seen: a mask of columns
    /// per row.
    #[inline(always)]
    fn near_foreground(&self, block: &BlockOrigin, foreground: &PaintedLayer) -> [u16; BLOCK] {
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
        near
    }

    /// Whether the key of a foreground sample is seen where the background has the key `back`.
    #[inline(always)]
    pub(crate) fn shows(&self, front: u64, back: u64) -> bool {
        // A core sample wins over a fringe sample that lies before it.
        front > back || front != 0 && inverse_depth_of(front) >= inverse_depth_of(back) * self.surface_ratio
    }

    /// The nearer of both layers.
    #[inline(always)]
    fn key(&self, pixel: usize) -> u64 {
        let back = self.background.keys[pixel];
        self.foreground.map_or(back, |front| back.max(front.keys[pixel]))
    }

    /// The blended color of both layers where they show the surface that `key` stands for.
    #[inline(always)]
    pub(crate) fn blended(&self, pixel: usize, key: u64) -> [f32; 3] {
        let limit = inverse_depth_of(key) * self.surface_ratio;
        let mut sum: Sum = [0.0; 4];
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
            self.frame.color_of(slot_of(key))
        }
    }

    /// Loads a block and its ring: the nearer keys of the background and of a foreground.
    #[inline(always)]
    fn load(&self, block: &BlockOrigin, foreground: Option<&PaintedLayer>, patch: &mut Patch) {
        (patch.left, patch.top, patch.surface_ratio) = (block.left, block.top, self.surface_ratio);
        let mut border = [0; SIDE];
        for (row, keys) in patch.keys.iter_mut().enumerate() {
            *keys = *self.patch_row(&self.background.keys, block, row, &mut border);
            if let Some(foreground) = foreground {
                let front = self.patch_row(&foreground.keys, block, row, &mut border);
                keys.iter_mut().zip(front).for_each(|(key, front)| *key = (*key).max(*front));
            }
        }
    }

    /// A row of a block with its ring, out of a layer's keys; beyond the picture its border goes on, in keys of its own.
    #[inline(always)]
    fn patch_row<'b>(
        &self,
        keys: &'b [u64],
        block: &BlockOrigin,
        row: usize,
        border: &'b mut [u64; SIDE],
    ) -> &'b [u64; SIDE] {
        let y = (block.top + row).saturating_sub(RING).min(self.height() - 1);
        let keys = &keys[y * self.width..][..self.width];
        if let Some(left) = block.left.checked_sub(RING)
            && let Some(keys) = keys[left..].first_chunk::<SIDE>()
        {
            return keys;
        }
        for (column, key) in border.iter_mut().enumerate() {
            *key = keys[(block.left + column).saturating_sub(RING).min(self.width - 1)];
        }
        border
    }
}

impl Strip<'_> {
    /// Positions in the strip of a row of a block, and how many rows the block has.
    #[inline(always)]
    pub(crate) fn extent(&self, block: &BlockOrigin) -> (usize, usize) {
        let rows = self.rows.image.len() / self.resolve.width;
        (BLOCK.min(self.resolve.width - block.left), rows)
    }

    #[inline(always)]
    fn copy(&mut self, block: &BlockOrigin, from: &Picture) {
        let (columns, rows) = self.extent(block);
        for row in 0..rows {
            let to = row * self.resolve.width + block.left..row * self.resolve.width + block.left + columns;
            let start = (block.top + row) * self.resolve.width + block.left;
            let source = start..start + columns;
            put(&mut self.rows.color[to.clone()], &from.color.as_slice()[source.clone()]);
            put(&mut self.rows.inverse_depth[to.clone()], &from.inverse_depth.as_slice()[source.clone()]);
            put(&mut self.rows.image[to], &from.image.as_slice()[source]);
        }
    }

    #[inline(always)]
    fn blend(&mut self, block: &BlockOrigin) {
        let (columns, rows) = self.extent(block);
        for row in 0..rows {
            for column in 0..columns {
                let pixel = (block.top + row) * self.resolve.width + block.left + column;
                let key = self.resolve.key(pixel);
                let color = if key == 0 { [0.0; 3] } else { self.resolve.blended(pixel, key) };
                self.rows.set(self.resolve.frame, row * self.resolve.width + block.left + column, key, color);
            }
        }
    }
}
