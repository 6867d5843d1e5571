//! The resolve stage where each pixel is decided by itself, as all kernels but `gather` do: the `point` kernel, and a foreground
//! painted over a background that exists already.

use super::layers::{BlockSet, PaintedLayer};
use super::strip::{Strip, put};
use crate::color::widened;
use crate::render::gather::{BLOCK, BlockOrigin};
use crate::render::input::{ColorIndex, FrameTile, linear};
use crate::render::splat::{inverse_depth_of, slot_of};
use crate::render::vantage::NO_IMAGE;
use crate::settings::Kernel;
use crate::simd;

/// A foreground sample that is visible: pixel of the strip, key and where its color is.
pub(super) type ForegroundPixel = (usize, u64, ColorIndex);

/// The nearest samples of a block of pixels. Aligned, so that no row of a vector's width crosses cache lines.
#[derive(Default)]
#[repr(align(64))]
struct NearestSamples {
    keys: [[u64; BLOCK]; BLOCK],
    indices: [[ColorIndex; BLOCK]; BLOCK],
    /// Three half floats each.
    colors: [[u64; BLOCK]; BLOCK],
}

/// Shows the nearest sample of each pixel in the blocks of a set. Samples of neighboring pixels lie far apart in memory: while
/// those of a block are being fetched, the block before is shown.
#[inline(always)]
pub(super) fn show_nearest(strip: &mut Strip<'_>, which: &BlockSet) {
    let (mut first, mut second) = (NearestSamples::default(), NearestSamples::default());
    let (mut found, mut next) = (&mut first, &mut second);
    let mut before: Option<BlockOrigin> = None;
    for column in 0..strip.input.stage.width.div_ceil(BLOCK) {
        if !which.contains(column, strip.row) {
            continue;
        }
        let block = strip.block(column);
        next.find(strip, block);
        if let Some(before) = before.replace(block) {
            found.show(strip, before);
        }
        std::mem::swap(&mut found, &mut next);
    }
    if let Some(last) = before {
        found.show(strip, last);
    }
}

/// Paints the foreground into a block that shows the background. `shown` is scratch memory.
#[inline(always)]
pub(super) fn paint_over(
    strip: &mut Strip<'_>,
    block: BlockOrigin,
    foreground: &PaintedLayer,
    shown: &mut Vec<ForegroundPixel>,
) {
    let (input, frame) = (strip.input, strip.input.stage.frame);
    let (columns, rows) = strip.rows.extent(block.left);
    let is_point = input.stage.kernel == Kernel::Point;
    shown.clear();
    for row in 0..rows {
        let first = (block.top + row) * input.stage.width + block.left;
        let front = &foreground.keys[first..first + columns];
        if front.iter().fold(0, |all, key| all | key) == 0 {
            continue;
        }
        let at = row * input.stage.width + block.left;
        let back = &input.background.keys[first..first + columns];
        for (column, (&front, &back)) in front.iter().zip(back).enumerate() {
            let key = front.max(back);
            if is_point && front > back {
                let index = frame.color_index(slot_of(key));
                simd::prefetch(frame.colors(index.image), index.nth as usize);
                shown.push((at + column, key, index));
            } else if !is_point && input.shows(front, back) {
                strip.rows.set(frame, at + column, key, input.blended(first + column, key));
            }
        }
    }
    for &(at, key, index) in shown.iter() {
        strip.rows.set(frame, at, key, linear(frame.colors(index.image)[index.nth as usize]));
    }
}

impl NearestSamples {
    /// Finds the nearest samples of a block and prefetches their colors.
    #[inline(always)]
    fn find(&mut self, strip: &Strip<'_>, block: BlockOrigin) {
        let (input, frame) = (strip.input, strip.input.stage.frame);
        let (columns, rows) = strip.rows.extent(block.left);
        for row in 0..rows {
            let first = (block.top + row) * input.stage.width + block.left;
            let keys = &mut self.keys[row];
            put(keys, &input.background.keys[first..first + columns]);
            if let Some(foreground) = input.foreground {
                let front = &foreground.keys[first..first + columns];
                keys.iter_mut().zip(front).for_each(|(key, front)| *key = (*key).max(*front));
            }
            // What will be written is not in the cache either.
            let at = row * input.stage.width + block.left;
            for part in 0..3 {
                simd::prefetch(strip.rows.color, at + part * BLOCK / 3);
            }
            simd::prefetch(strip.rows.inverse_depth, at);
            simd::prefetch(strip.rows.image, at);
            for (index, &key) in self.indices[row].iter_mut().zip(&keys[..columns]) {
                // A hole reads the color of the first sample, which `show_row` drops.
                *index = frame.color_index(if key == 0 { 0 } else { slot_of(key) });
                simd::prefetch(frame.colors(index.image), index.nth as usize);
            }
        }
    }

    /// Sets the pixels of a block to these samples.
    #[inline(always)]
    fn show(&mut self, strip: &mut Strip<'_>, block: BlockOrigin) {
        let frame = strip.input.stage.frame;
        let (columns, rows) = strip.rows.extent(block.left);
        for row in 0..rows {
            for (color, index) in self.colors[row].iter_mut().zip(&self.indices[row]).take(columns) {
                *color = FrameTile::bits_of(frame.colors(index.image)[index.nth as usize]);
            }
        }
        for row in 0..rows {
            self.show_row(strip, block, row, columns);
        }
    }

    #[inline(always)]
    fn show_row(&self, strip: &mut Strip<'_>, block: BlockOrigin, row: usize, columns: usize) {
        let at = row * strip.input.stage.width + block.left;
        let (mut planes, mut depths, mut images) = ([[0.0; BLOCK]; 3], [0.0; BLOCK], [NO_IMAGE; BLOCK]);
        for column in 0..BLOCK {
            let (key, color) = (self.keys[row][column], self.colors[row][column]);
            let color = if key == 0 { 0 } else { color };
            for channel in 0..3 {
                planes[channel][column] = widened((color >> (16 * channel)) as i16);
            }
            depths[column] = inverse_depth_of(key);
        }
        let samples = self.keys[row].iter().zip(&self.indices[row]);
        for (image, (key, index)) in images.iter_mut().zip(samples).take(columns) {
            let shown = strip.input.stage.frame.images[index.image as usize] as u32;
            *image = if *key == 0 { NO_IMAGE } else { shown };
        }
        for (column, color) in strip.rows.color[at..at + columns].iter_mut().enumerate() {
            *color = [planes[0][column & 15], planes[1][column & 15], planes[2][column & 15]];
        }
        put(&mut strip.rows.inverse_depth[at..at + columns], &depths);
        put(&mut strip.rows.image[at..at + columns], &images);
    }
}
