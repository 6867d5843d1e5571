//! The rows of the picture that a thread paints, and the pixels in them that samples touch.

use std::ops::Range;

use crate::simd::whole;

/// Columns of a large footprint that are painted at once: as many keys as the widest vector holds.
const WIDE: usize = 8;

/// The rows of the picture that are being painted.
#[derive(Clone, Copy)]
pub(super) struct BandRows {
    width: u32,
    right: f32,
    top: f32,
    bottom: f32,
    /// The last pixel of the band.
    last: u32,
}

impl BandRows {
    pub(super) fn of(width: usize, rows: &Range<usize>) -> Self {
        Self {
            width: width as u32,
            right: (width - 1) as f32,
            top: rows.start as f32,
            bottom: (rows.end - 1) as f32,
            last: (width * rows.len() - 1) as u32,
        }
    }

    /// The pixel of the band at column `x` and row `y` (whole numbers), and whether it is in the band. If it is not, or is
    /// NaN, the pixel is any in the band: a different one for each lane `i`, as writing to the same again and again is slow.
    #[inline(always)]
    pub(super) fn pixel(&self, x: f32, y: f32, i: usize) -> (u32, bool) {
        let inside = (x >= 0.0) & (x <= self.right) & (y >= self.top) & (y <= self.bottom);
        // What is outside may wrap: it is not used.
        let pixel = whole(y - self.top).wrapping_mul(self.width).wrapping_add(whole(x));
        (if inside { pixel } else { (i as u32).min(self.last) }, inside)
    }

    /// Whether the middle of a row of the band lies between two positions of the picture.
    #[inline(always)]
    pub(super) fn has_row_between(&self, above: f32, below: f32) -> bool {
        (below >= self.top) & (above <= self.bottom + 1.0)
    }

    /// Raises the keys of the pixels from the first to the last column and row of `edges` to what `key_at` gives, [`WIDE`] columns at a
    /// time.
    #[inline(always)]
    pub(super) fn raise(&self, keys: &mut [u64], edges: [f32; 4], key_at: impl Fn(f32, f32) -> u64) {
        let clamp = |value: f32, low: f32, end: f32| value.max(low).min(end) as usize;
        let [left, right, top, bottom] = edges;
        let (end, below) = (self.right + 1.0, self.bottom + 1.0);
        let columns = clamp(left, 0.0, end)..clamp(right + 1.0, 0.0, end);
        for y in clamp(top, self.top, below)..clamp(bottom + 1.0, self.top, below) {
            let row = &mut keys[(y - self.top as usize) * self.width as usize..];
            for first in columns.clone().step_by(WIDE) {
                let mut new = [0; WIDE];
                for i in 0..WIDE {
                    let key = key_at((first + i) as f32, y as f32);
                    new[i] = if first + i < columns.end { key } else { 0 };
                }
                // A key of 0 changes nothing, so that the pixels beyond the last column may be those of the next row.
                if let Some(there) = row[first..].first_chunk_mut::<WIDE>() {
                    for i in 0..WIDE {
                        there[i] = there[i].max(new[i]);
                    }
                } else {
                    row[first..].iter_mut().zip(new).for_each(|(there, new)| *there = (*there).max(new));
                }
            }
        }
    }
}
