//! Splatting: samples painted into the pixels that they cover.
//!
//! Z-buffer keys: numbers whose maximum is the nearest sample of a pixel.
//!
//! ```text
//! key of a pixel = [ core: 1 bit | trusted: 1 bit | nearness: 30 bits | u32::MAX − slot: 32 bits ]     0: nothing there
//! ```
//! Nearness is the bits of the inverse depth less those of 2⁻⁶⁴, plus one (positive floats order like integers): what is farther than
//! 2⁶⁴ units is infinitely far. The larger key is the nearer
//! sample and, of two equally near ones, that of the smaller slot. A maximum does not depend on the order of its operands, so
//! neither does the picture.

mod blend;
mod surface;

use std::ops::Range;

use glam::Vec3;

use super::geometry::{Projector, RowBand, rays_in_world};
use super::input::{FrameSamples, RelativeWidth, focal};
use crate::capture::Camera;
use crate::job::Job;
use crate::settings::{Kernel, RenderSettings};
use crate::simd::whole;
pub(crate) use blend::{BLEND_REACH, BlendSum, LEAST_WEIGHT, blend};
pub(crate) use surface::surface;

/// What the stages of one picture share.
pub(crate) struct StageInput<'a> {
    pub(crate) frame: &'a FrameSamples<'a>,
    /// Carries each camera into the target.
    pub(crate) projectors: Vec<Projector>,
    /// The size of the footprints of each camera, relative to the distance.
    per_footprint: Vec<RelativeWidth>,
    /// World-space ray of the target's corner, and its growth by column and row.
    rays_in_world: [Vec3; 3],
    /// Columns of the target.
    pub(crate) width: usize,
    /// Inverse depths from this share of the nearest one on belong to the same surface.
    pub(crate) surface_ratio: f32,
    pub(crate) kernel: Kernel,
    pub(crate) job: &'a Job,
}

impl<'a> StageInput<'a> {
    /// For the samples of `frame`, seen by `target`.
    pub(crate) fn new(
        frame: &'a FrameSamples<'a>,
        target: &Camera,
        settings: &RenderSettings,
        job: &'a Job,
    ) -> Self {
        let cameras = &frame.set.cameras;
        Self {
            frame,
            projectors: cameras.iter().map(|camera| Projector::new(camera, target)).collect(),
            per_footprint: cameras.iter().map(|camera| RelativeWidth::of(1.0, camera)).collect(),
            rays_in_world: rays_in_world(target, 0.0),
            width: target.intrinsics.size().0,
            surface_ratio: 1.0 / (1.0 + settings.depth_tolerance / focal(target)),
            kernel: settings.kernel,
            job,
        }
    }

    /// Whether the kernel blends the samples of a surface.
    pub(crate) fn blends(&self) -> bool {
        matches!(self.kernel, Kernel::Block | Kernel::Surfel)
    }
}

/// Cuts a buffer of `width` columns into the rows of each band; bands ascend.
fn split_at_bands<'a, 'b, T>(
    bands: &'a [RowBand],
    width: usize,
    buffer: &'b mut [T],
) -> Vec<(&'a RowBand, &'b mut [T])> {
    let (mut rest, mut row) = (buffer, 0);
    let mut parts = Vec::with_capacity(bands.len());
    for band in bands {
        let (_, from) = rest.split_at_mut((band.rows.start - row) * width);
        let (part, after) = from.split_at_mut(band.rows.len() * width);
        parts.push((band, part));
        (rest, row) = (after, band.rows.end);
    }
    parts
}

/// Columns of a large footprint that are painted at once: as many keys as the widest vector holds.
const WIDE: usize = 8;

/// The rows of the picture that are being painted.
#[derive(Clone, Copy)]
struct BandRows {
    width: u32,
    right: f32,
    top: f32,
    bottom: f32,
    /// The last pixel of the band.
    last: u32,
}

impl BandRows {
    fn of(width: usize, rows: &Range<usize>) -> Self {
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
    fn pixel(&self, x: f32, y: f32, i: usize) -> (u32, bool) {
        let inside = (x >= 0.0) & (x <= self.right) & (y >= self.top) & (y <= self.bottom);
        // What is outside may wrap: it is not used.
        let pixel = whole(y - self.top).wrapping_mul(self.width).wrapping_add(whole(x));
        (if inside { pixel } else { (i as u32).min(self.last) }, inside)
    }

    /// Raises the keys of the pixels from the first to the last column and row of `edges` to what `key_at` gives, [`WIDE`] columns at a
    /// time.
    #[inline(always)]
    fn raise(&self, keys: &mut [u64], edges: [f32; 4], key_at: impl Fn(f32, f32) -> u64) {
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

/// The bit of a key that marks a core sample: it wins over every fringe sample.
pub(crate) const CORE: u32 = 1 << 31;

/// The bit of a key that marks a sample that is not doubtful: of two core samples, or two of a fringe, it wins over a doubtful one.
pub(crate) const TRUSTED: u32 = 1 << 30;

/// Both bits.
const TIERS: u32 = CORE | TRUSTED;

/// The bits of 2⁻⁶⁴: what is farther counts as infinitely far. From here on nearness has room for 128 octaves.
const FARTHEST: i32 = (127 - 64) << 23;

/// The nearest that a key can say, just below 2⁶⁴.
const NEAREST: i32 = FARTHEST + TRUSTED as i32 - 2;

/// The upper half of a key. Its bits are compared as a signed number, so that −0 is infinitely far too.
#[inline(always)]
pub(crate) fn nearness(inverse_depth: f32, tier: u32) -> u32 {
    let bits = (inverse_depth.to_bits() as i32).clamp(FARTHEST, NEAREST);
    (bits - (FARTHEST - 1)) as u32 | tier
}

/// A key from its upper half and the slot.
#[inline(always)]
pub(crate) fn key(nearness: u32, slot: u32) -> u64 {
    u64::from(nearness) << 32 | u64::from(!slot)
}

/// The inverse depth of a key; negative for 0.
#[inline(always)]
pub(crate) fn inverse_depth_of(key: u64) -> f32 {
    match (key >> 32) as u32 & !TIERS {
        0 => -1.0,
        1 => 0.0,
        nearness => f32::from_bits(nearness + (FARTHEST - 1) as u32),
    }
}

/// The slot of a key.
#[inline(always)]
pub(crate) fn slot_of(key: u64) -> u32 {
    !(key as u32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_gives_back_its_inverse_depth_bit_for_bit_in_every_tier() {
        for tier in [0, CORE, TRUSTED, TIERS] {
            for inverse_depth in [0.0, 1e-19, 1e-3, 0.7, 1.0, 2.0, 1.000_000_1, 3e9, 1.8e19] {
                let key = key(nearness(inverse_depth, tier), 77);
                assert_eq!((inverse_depth_of(key), slot_of(key)), (inverse_depth, 77), "{tier:x}");
            }
            for far in [1e-30, -0.0] {
                assert_eq!(inverse_depth_of(key(nearness(far, tier), 0)), 0.0, "farther than keys can say");
            }
            let nearest = inverse_depth_of(key(nearness(f32::MAX, tier), 0));
            assert!(nearest > 1.8e19 && nearest < 1.9e19, "{nearest}");
        }
        assert_eq!(inverse_depth_of(0), -1.0);
    }

    #[test]
    fn core_wins_over_fringe_then_trusted_over_doubtful_then_the_nearer() {
        let ascending =
            [(9.0, 0), (0.0, TRUSTED), (9.0, TRUSTED), (0.0, CORE), (9.0, CORE), (0.0, TIERS), (9.0, TIERS)];
        assert!(ascending.map(|(inverse_depth, tier)| key(nearness(inverse_depth, tier), 0)).is_sorted());
    }
}
