//! The resolve stage: from keys and sums to a picture, block by block.
//!
//! The foreground of a frame is painted over the background by depth (the paper, §3.3). A block that no foreground reaches is
//! the background's own; where one does, both are resolved together. Which blocks those are depends on the frame and the
//! vantage alone, so that painting over a cached background gives the very picture that painting everything anew gives.

use rayon::prelude::*;

use super::blend::Sum;
use super::blocks::Blocks;
use super::frame_samples::{ColorPlace, FrameSamples, f32_from_f16_bits};
use super::gather::{BLOCK, Gather};
use super::gather_block::Scratch;
use super::keys::{inverse_depth_of, slot_of};
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

/// The nearest samples of a block of pixels.
struct Found {
    keys: [[u64; BLOCK]; BLOCK],
    places: [[ColorPlace; BLOCK]; BLOCK],
    /// Three half floats each.
    colors: [[u64; BLOCK]; BLOCK],
}

/// Sixteen rows of the three planes of a picture.
pub(super) struct Rows<'a> {
    pub(super) color: &'a mut [[f32; 3]],
    pub(super) inverse_depth: &'a mut [f32],
    pub(super) image: &'a mut [u32],
}

impl Rows<'_> {
    #[inline(always)]
    fn set(&mut self, frame: &FrameSamples<'_>, at: usize, key: u64, color: [f32; 3]) {
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
        let strip = BLOCK * self.width;
        let color = picture.color.as_mut_slice().par_chunks_mut(strip);
        let depth = picture.inverse_depth.as_mut_slice().par_chunks_mut(strip);
        let image = picture.image.as_mut_slice().par_chunks_mut(strip);
        let strips = color.zip(depth).zip(image).enumerate();
        let scratch = || Scratch::new(self.frame.set.cameras.len());
        strips.try_for_each_init(scratch, |scratch, (row, ((color, inverse_depth), image))| {
            self.job.check()?;
            let rows = Rows { color, inverse_depth, image };
            simd::run(Strip { resolve: self, scratch, which, row, rows });
            Ok(())
        })
    }
}

/// A row of blocks.
struct Strip<'a> {
    resolve: &'a Resolve<'a>,
    scratch: &'a mut Scratch,
    which: &'a Blocks,
    row: usize,
    rows: Rows<'a>,
}

impl Work for Strip<'_> {
    type Output = ();

    #[inline(always)]
    fn run(mut self) {
        let mut found = Found {
            keys: [[0; BLOCK]; BLOCK],
            places: [[ColorPlace::default(); BLOCK]; BLOCK],
            colors: [[0; BLOCK]; BLOCK],
        };
        for column in 0..self.resolve.width.div_ceil(BLOCK) {
            if !self.which.contains(column, self.row) {
                continue;
            }
            let block = Block { left: column * BLOCK, top: self.row * BLOCK };
            let foreground = self.resolve.foreground;
            let has_foreground = foreground.is_some_and(|layer| self.resolve.has_foreground(&block, layer));
            if !has_foreground && let Some(background) = self.resolve.background_picture {
                self.copy(&block, background);
            } else if let Some(gathers) = self.resolve.gather {
                let (among, frame) = (usize::from(has_foreground), self.resolve.frame);
                let patch = self.resolve.patch(&block);
                self.scratch.gather(
                    (gathers[among], among),
                    frame,
                    &patch,
                    (&mut self.rows, self.resolve.width),
                );
            } else if self.resolve.kernel == Kernel::Point && !self.resolve.frame.tiles.is_empty() {
                self.points(&block, &mut found);
            } else {
                self.blend(&block);
            }
        }
    }
}

/// Copies as many as both have. Nearly always they are sixteen, which takes no call and no loop.
#[inline(always)]
fn put<T: Copy>(to: &mut [T], from: &[T]) {
    if let (Some(to), Some(from)) = (to.first_chunk_mut::<BLOCK>(), from.first_chunk::<BLOCK>()) {
        *to = *from;
    } else {
        to.iter_mut().zip(from).for_each(|(to, from)| *to = *from);
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
            pairs.into_iter().any(|(&front, &back)| {
                // A core sample wins over a fringe sample that lies before it.
                front > back
                    || front != 0 && inverse_depth_of(front) >= inverse_depth_of(back) * self.surface_ratio
            })
        })
    }

    /// The nearer of both layers.
    #[inline(always)]
    fn key(&self, pixel: usize) -> u64 {
        let back = self.background.keys[pixel];
        self.foreground.map_or(back, |front| back.max(front.keys[pixel]))
    }

    /// The blended color of both layers where they show the surface that `key` stands for.
    #[inline(always)]
    fn blended(&self, pixel: usize, key: u64) -> [f32; 3] {
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
    fn extent(&self, block: &Block) -> (usize, usize) {
        let rows = self.rows.image.len() / self.resolve.width;
        (BLOCK.min(self.resolve.width - block.left), rows)
    }

    fn copy(&mut self, block: &Block, from: &Picture) {
        let (columns, rows) = self.extent(block);
        for row in 0..rows {
            let to = row * self.resolve.width + block.left..row * self.resolve.width + block.left + columns;
            let start = (block.top + row) * self.resolve.width + block.left;
            let source = start..start + columns;
            self.rows.color[to.clone()].copy_from_slice(&from.color.as_slice()[source.clone()]);
            self.rows.inverse_depth[to.clone()]
                .copy_from_slice(&from.inverse_depth.as_slice()[source.clone()]);
            self.rows.image[to].copy_from_slice(&from.image.as_slice()[source]);
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

    /// Every pixel shows its nearest sample. Samples of neighboring pixels lie far apart in memory: those of a block are all
    /// found before the first is read, so that the processor waits for many of them at once.
    #[inline(always)]
    fn points(&mut self, block: &Block, found: &mut Found) {
        let frame = self.resolve.frame;
        let (columns, rows) = self.extent(block);
        for row in 0..rows {
            let first = (block.top + row) * self.resolve.width + block.left;
            let keys = &mut found.keys[row];
            put(keys, &self.resolve.background.keys[first..first + columns]);
            if let Some(foreground) = self.resolve.foreground {
                let front = &foreground.keys[first..first + columns];
                keys.iter_mut().zip(front).for_each(|(key, front)| *key = (*key).max(*front));
            }
            // What will be written is not in the cache either.
            let at = row * self.resolve.width + block.left;
            for part in 0..3 {
                simd::prefetch(self.rows.color, at + part * BLOCK / 3);
            }
            simd::prefetch(self.rows.inverse_depth, at);
            simd::prefetch(self.rows.image, at);
            for (place, &key) in found.places[row].iter_mut().zip(&keys[..columns]) {
                // A hole looks at the first sample there is, and forgets it.
                *place = frame.color_place(if key == 0 { 0 } else { slot_of(key) });
                simd::prefetch(frame.colors(place.image), place.nth as usize);
            }
        }
        for row in 0..rows {
            for (color, place) in found.colors[row].iter_mut().zip(&found.places[row]).take(columns) {
                let [red, green, blue] =
                    frame.colors(place.image)[place.nth as usize].map(|half| u64::from(half.to_bits()));
                *color = red | green << 16 | blue << 32;
            }
        }
        for row in 0..rows {
            self.show(block, row, found);
        }
    }

    /// Sets a row of pixels to what was found.
    #[inline(always)]
    fn show(&mut self, block: &Block, row: usize, found: &Found) {
        let (columns, _) = self.extent(block);
        let at = row * self.resolve.width + block.left;
        let (mut planes, mut depths, mut images) = ([[0.0; BLOCK]; 3], [0.0; BLOCK], [NO_IMAGE; BLOCK]);
        for column in 0..BLOCK {
            let (key, color) = (found.keys[row][column], found.colors[row][column]);
            let color = if key == 0 { 0 } else { color };
            for channel in 0..3 {
                planes[channel][column] = f32_from_f16_bits((color >> (16 * channel)) as u32 & 0xffff);
            }
            depths[column] = inverse_depth_of(key);
        }
        for (image, (key, place)) in
            images.iter_mut().zip(found.keys[row].iter().zip(&found.places[row])).take(columns)
        {
            let shown = self.resolve.frame.images[place.image as usize] as u32;
            *image = if *key == 0 { NO_IMAGE } else { shown };
        }
        for (column, color) in self.rows.color[at..at + columns].iter_mut().enumerate() {
            *color = [planes[0][column & 15], planes[1][column & 15], planes[2][column & 15]];
        }
        put(&mut self.rows.inverse_depth[at..at + columns], &depths);
        put(&mut self.rows.image[at..at + columns], &images);
    }
}
