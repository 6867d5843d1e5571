//! The resolve stage where every pixel is decided alone, which kernels that gather do not: the `point` kernel, and a foreground
//! over a background that is there already.

use super::dirty_blocks::BlockSet;
use super::{BlockOrigin, PaintedLayer, Strip};
use crate::color::widened;
use crate::render::gather::BLOCK;
use crate::render::input::ColorIndex;
use crate::render::splat::{inverse_depth_of, slot_of};
use crate::render::vantage::NO_IMAGE;
use crate::settings::Kernel;
use crate::simd;

/// The nearest samples of a block of pixels. Aligned, so that no row of a vector's width lies across cache lines.
#[repr(align(64))]
struct NearestSamples {
    keys: [[u64; BLOCK]; BLOCK],
    places: [[ColorIndex; BLOCK]; BLOCK],
    /// Three half floats each.
    colors: [[u64; BLOCK]; BLOCK],
}

/// A foreground sample that is seen: pixel of the strip, key and place.
pub(crate) type ForegroundPixel = (usize, u64, ColorIndex);

impl Strip<'_> {
    /// Resolves the blocks of a set, each of whose pixels shows its nearest sample. Samples of neighboring pixels lie far apart
    /// in memory: while those of a block are on their way, the block before is shown.
    #[inline(always)]
    pub(crate) fn points_of(&mut self, which: &BlockSet) {
        let empty = || NearestSamples {
            keys: [[0; BLOCK]; BLOCK],
            places: [[ColorIndex::default(); BLOCK]; BLOCK],
            colors: [[0; BLOCK]; BLOCK],
        };
        let (mut first, mut second) = (empty(), empty());
        let (mut found, mut next) = (&mut first, &mut second);
        let mut before: Option<BlockOrigin> = None;
        for column in 0..self.resolve.width.div_ceil(BLOCK) {
            if !which.contains(column, self.row) {
                continue;
            }
            let block = BlockOrigin { left: column * BLOCK, top: self.row * BLOCK };
            self.find_points(&block, next);
            if let Some(before) = before.replace(block) {
                self.show_points(&before, found);
            }
            std::mem::swap(&mut found, &mut next);
        }
        if let Some(last) = before {
            self.show_points(&last, found);
        }
    }

    /// Paints the foreground into a block that shows the background, for kernels that decide about each pixel alone.
    #[inline(always)]
    pub(crate) fn paint_over(
        &mut self,
        block: &BlockOrigin,
        foreground: &PaintedLayer,
        shown: &mut Vec<ForegroundPixel>,
    ) {
        let (resolve, frame) = (self.resolve, self.resolve.frame);
        let (columns, rows) = self.extent(block);
        let is_point = resolve.kernel == Kernel::Point;
        shown.clear();
        for row in 0..rows {
            let first = (block.top + row) * resolve.width + block.left;
            let front = &foreground.keys[first..first + columns];
            if front.iter().fold(0, |all, key| all | key) == 0 {
                continue;
            }
            let at = row * resolve.width + block.left;
            let back = &resolve.background.keys[first..first + columns];
            for (column, (&front, &back)) in front.iter().zip(back).enumerate() {
                let key = front.max(back);
                if is_point && front > back {
                    let place = frame.color_index(slot_of(key));
                    simd::prefetch(frame.colors(place.image), place.nth as usize);
                    shown.push((at + column, key, place));
                } else if !is_point && resolve.shows(front, back) {
                    self.rows.set(frame, at + column, key, resolve.blended(first + column, key));
                }
            }
        }
        for &(at, key, place) in shown.iter() {
            let color = frame.colors(place.image)[place.nth as usize];
            self.rows.set(frame, at, key, color.map(|half| widened(half.to_bits().cast_signed())));
        }
    }

    /// Finds the nearest samples of a block, and asks for them.
    #[inline(always)]
    fn find_points(&mut self, block: &BlockOrigin, found: &mut NearestSamples) {
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
                *place = frame.color_index(if key == 0 { 0 } else { slot_of(key) });
                simd::prefetch(frame.colors(place.image), place.nth as usize);
            }
        }
    }

    /// Sets a block to what was found.
    #[inline(always)]
    fn show_points(&mut self, block: &BlockOrigin, found: &mut NearestSamples) {
        let frame = self.resolve.frame;
        let (columns, rows) = self.extent(block);
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
    fn show(&mut self, block: &BlockOrigin, row: usize, found: &NearestSamples) {
        let (columns, _) = self.extent(block);
        let at = row * self.resolve.width + block.left;
        let (mut planes, mut depths, mut images) = ([[0.0; BLOCK]; 3], [0.0; BLOCK], [NO_IMAGE; BLOCK]);
        for column in 0..BLOCK {
            let (key, color) = (found.keys[row][column], found.colors[row][column]);
            let color = if key == 0 { 0 } else { color };
            for channel in 0..3 {
                planes[channel][column] = widened((color >> (16 * channel)) as i16);
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

/// Copies as many as both have. Nearly always they are sixteen, which takes no call and no loop.
#[inline(always)]
pub(crate) fn put<T: Copy>(to: &mut [T], from: &[T]) {
    if let (Some(to), Some(from)) = (to.first_chunk_mut::<BLOCK>(), from.first_chunk::<BLOCK>()) {
        *to = *from;
    } else {
        to.iter_mut().zip(from).for_each(|(to, from)| *to = *from);
    }
}
