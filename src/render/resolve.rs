//! The resolve stage: from keys and sums to a picture, block by block.
//!
//! The foreground of a frame is painted over the background by depth (the paper, §3.3). A block that no foreground reaches is
//! the background's own; where one does, both are resolved together. Which blocks those are depends on the frame and the
//! vantage alone, so that painting over a cached background gives the very picture that painting everything anew gives.

use rayon::prelude::*;

use super::blend::Sum;
use super::blocks::Blocks;
use super::frame_samples::FrameSamples;
use super::gather::{BLOCK, Gather};
use super::gather_block::Scratch;
use super::keys::{inverse_depth_of, slot_of};
use super::resolve_points::{Shown, put};
use super::silhouette::{Patch, RING, SIDE};
use super::vantage::{NO_IMAGE, Picture};
use crate::error::Result;
use crate::job::Job;
use crate::settings::Kernel;
use crate::simd::{self, Work};

/// What was painted of some tiles.
#[derive(Clone, Debug, Default)]
pub(super) struct Layer {
    /// See [`super::keys`]; row-major.
    pub(super) keys: Vec<u64>,
    /// Blended colors; empty for kernels that do not blend.
    pub(super) sums: Vec<Sum>,
}

impl Layer {
    /// Nothing painted, on so many pixels.
    pub(super) fn reset(&mut self, keys: usize, sums: usize) {
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
pub(super) struct Resolve<'a> {
    pub(super) frame: &'a FrameSamples<'a>,
    pub(super) kernel: Kernel,
    pub(super) width: usize,
    pub(super) surface_ratio: f32,
    pub(super) background: &'a Layer,
    /// Left out to resolve the background alone.
    pub(super) foreground: Option<&'a Layer>,
    /// The picture of the background alone, where there is one already.
    pub(super) background_picture: Option<&'a Picture>,
    /// Where the kernel gathers: among the lasting samples, and among all.
    pub(super) gather: Option<[&'a Gather<'a>; 2]>,
    pub(super) job: &'a Job,
}

/// Sixteen rows of the three planes of a picture.
pub(super) struct Rows<'a> {
    pub(super) color: &'a mut [[f32; 3]],
    pub(super) inverse_depth: &'a mut [f32],
    pub(super) image: &'a mut [u32],
}

impl Rows<'_> {
    #[inline(always)]
    pub(super) fn set(&mut self, frame: &FrameSamples<'_>, at: usize, key: u64, color: [f32; 3]) {
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
    pub(super) fn resolve(&self, which: &Blocks, picture: &mut Picture) -> Result<()> {
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
        let scratch = || Scratch::new(self.frame.set.cameras.len());
        strips.try_for_each_init(scratch, |scratch, (nth, ((color, inverse_depth), image))| {
            self.job.check()?;
            let row = BLOCK * self.width;
            let rows = color.chunks_mut(row).zip(inverse_depth.chunks_mut(row)).zip(image.chunks_mut(row));
            let strips = rows.enumerate().map(|(below, ((color, inverse_depth), image))| Strip {
                resolve: self,
                row: nth * tall + below,
                rows: Rows { color, inverse_depth, image },
            });
            simd::run(Strips { which, scratch, rows: strips.collect() });
            Ok(())
        })
    }
}

/// Rows of blocks that are gathered together, a column of them at a time.
const TALL: usize = 2;

struct Strips<'a> {
    which: &'a Blocks,
    scratch: &'a mut Scratch,
    rows: Vec<Strip<'a>>,
}

/// A row of blocks.
pub(super) struct Strip<'a> {
    pub(super) resolve: &'a Resolve<'a>,
    /// Of blocks.
    pub(super) row: usize,
    pub(super) rows: Rows<'a>,
}

impl Work for Strips<'_> {
    type Output = ();

    #[inline(always)]
    fn run(mut self) {
        let Some(resolve) = self.rows.first().map(|strip| strip.resolve) else { return };
        let blocks = resolve.width.div_ceil(BLOCK);
        if resolve.kernel == Kernel::Point
            && resolve.background_picture.is_none()
            && !resolve.frame.tiles.is_empty()
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
    fn block(&mut self, column: usize, scratch: &mut Scratch, shown: &mut Vec<Shown>) {
        let resolve = self.resolve;
        let block = Block { left: column * BLOCK, top: self.row * BLOCK };
        let (foreground, background) = (resolve.foreground, resolve.background_picture);
        if let (Some(foreground), Some(background), None) = (foreground, background, resolve.gather) {
            self.copy(&block, background);
            self.paint_over(&block, foreground, shown);
            return;
        }
        let has_foreground = foreground.is_some_and(|layer| resolve.has_foreground(&block, layer));
        if !has_foreground && let Some(background) = background {
            self.copy(&block, background);
        } else if let Some(gathers) = resolve.gather {
            let among = usize::from(has_foreground);
            let patch = resolve.patch(&block);
            let rows = (&mut self.rows, resolve.width);
            scratch.gather((gathers[among], among), resolve.frame, &patch, rows);
        } else {
            self.blend(&block);
        }
    }
}

/// Column and row of the first pixel of a block.
pub(super) struct Block {
    pub(super) left: usize,
    pub(super) top: usize,
}

impl Resolve<'_> {
    fn height(&self) -> usize {
        self.background.keys.len() / self.width
    }

    /// Whether a foreground sample is seen in the block or beside it.
    #[inline(always)]
    fn has_foreground(&self, block: &Block, foreground: &Layer) -> bool {
        let columns = block.left.saturating_sub(RING)..(block.left + BLOCK + RING).min(self.width);
        let rows = block.top.saturating_sub(RING)..(block.top + BLOCK + RING).min(self.height());
        rows.into_iter().any(|y| {
            let (start, end) = (y * self.width + columns.start, y * self.width + columns.end);
            let pairs = foreground.keys[start..end].iter().zip(&self.background.keys[start..end]);
            pairs.into_iter().any(|(&front, &back)| self.shows(front, back))
        })
    }

    /// Whether the key of a foreground sample is seen where the background has the key `back`.
    #[inline(always)]
    pub(super) fn shows(&self, front: u64, back: u64) -> bool {
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
    pub(super) fn blended(&self, pixel: usize, key: u64) -> [f32; 3] {
        let limit = inverse_depth_of(key) * self.surface_ratio;
        let mut sum: Sum = [0.0; 4];
        for layer in [Some(self.background), self.foreground].into_iter().flatten() {
            if let Some(part) = layer.sums.get(pixel)
                && inverse_depth_of(layer.keys[pixel]) >= limit
            {
                (0..4).for_each(|channel| sum[channel] += part[channel]);
            }
        }
        if sum[3] > 0.0 {
            [sum[0] / sum[3], sum[1] / sum[3], sum[2] / sum[3]]
        } else {
            self.frame.color_of(slot_of(key))
        }
    }

    #[inline(always)]
    fn patch(&self, block: &Block) -> Patch {
        let mut keys = [[0; SIDE]; SIDE];
        for (row, keys) in keys.iter_mut().enumerate() {
            let y = (block.top + row).saturating_sub(RING).min(self.height() - 1);
            for (column, key) in keys.iter_mut().enumerate() {
                let x = (block.left + column).saturating_sub(RING).min(self.width - 1);
                *key = self.key(y * self.width + x);
            }
        }
        Patch { keys, left: block.left, top: block.top, surface_ratio: self.surface_ratio }
    }
}

impl Strip<'_> {
    /// Positions in the strip of a row of a block, and how many rows the block has.
    #[inline(always)]
    pub(super) fn extent(&self, block: &Block) -> (usize, usize) {
        let rows = self.rows.image.len() / self.resolve.width;
        (BLOCK.min(self.resolve.width - block.left), rows)
    }

    #[inline(always)]
    fn copy(&mut self, block: &Block, from: &Picture) {
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
    fn blend(&mut self, block: &Block) {
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
