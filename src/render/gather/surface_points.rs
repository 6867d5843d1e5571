//! The surface points of a block of pixels: what the gather stage finds colors for.

use super::view_weights::{BLOCK, ENOUGH, OWN_SHARE};
use crate::render::input::LANES;
use crate::render::splat::inverse_depth_of;
use crate::simd::mask;

/// Surface points that a block has at most: two in each pixel.
pub(crate) const MOST: usize = 2 * BLOCK * BLOCK;

/// The surface points of a block that are to be colored, and what is known of their colors so far.
#[derive(Debug)]
pub(crate) struct SurfacePoints {
    count: usize,
    /// Columns of their pixels.
    pub(crate) x: [f32; MOST],
    /// Rows of their pixels.
    pub(crate) y: [f32; MOST],
    /// Inverse depths.
    pub(crate) w: [f32; MOST],
    /// Keys of the nearest samples.
    key: [u64; MOST],
    /// Their cameras.
    pub(crate) own: [u16; MOST],
    /// How much each counts in its pixel.
    share: [f32; MOST],
    /// The pixels, as indices in the strip.
    pixel: [u32; MOST],
    /// Red, green and blue, weighted by `weight`.
    pub(crate) color: [[f32; MOST]; 3],
    pub(crate) weight: [f32; MOST],
    /// Pixels' worth of samples.
    pub(crate) known: [f32; MOST],
    /// Points that want one camera.
    pub(crate) wanting: Vec<u16>,
}

impl SurfacePoints {
    pub(crate) fn new() -> Self {
        let zero = [0.0; MOST];
        Self {
            count: 0,
            x: zero,
            y: zero,
            w: zero,
            key: [0; MOST],
            own: [0; MOST],
            share: zero,
            pixel: [0; MOST],
            color: [zero; 3],
            weight: zero,
            known: zero,
            wanting: Vec::with_capacity(MOST),
        }
    }

    pub(crate) fn clear(&mut self) {
        self.count = 0;
    }

    /// Adds the surface of a key, a sample of camera `own`, in pixel `(x, y)` of the picture: at `pixel` in the strip it counts
    /// `share`.
    #[inline(always)]
    pub(crate) fn push(&mut self, key: u64, (x, y): (f32, f32), (pixel, share): (u32, f32), own: u16) {
        let at = self.count % MOST;
        self.count = at + 1;
        self.x[at] = x;
        self.y[at] = y;
        self.w[at] = inverse_depth_of(key);
        self.key[at] = key;
        self.own[at] = own;
        self.share[at] = share;
        self.pixel[at] = pixel;
    }

    /// Adds the surfaces of a row of pixels from `(x, y)` on, `pixel` in the strip, each alone in its pixel. Sets their inverse
    /// depths.
    #[inline(always)]
    pub(crate) fn push_row(
        &mut self,
        keys: &[u64; BLOCK],
        (x, y): (f32, f32),
        (pixel, cameras): (u32, &[u16; BLOCK]),
        depths: &mut [f32; BLOCK],
    ) {
        let at = self.count.min(MOST - BLOCK);
        self.count = at + BLOCK;
        for i in 0..BLOCK {
            depths[i] = inverse_depth_of(keys[i]);
        }
        let (mut columns, mut pixels) = ([0.0; BLOCK], [0; BLOCK]);
        for i in 0..BLOCK {
            columns[i] = x + i as f32;
            pixels[i] = pixel + i as u32;
        }
        self.x[at..at + BLOCK].copy_from_slice(&columns);
        self.y[at..at + BLOCK].fill(y);
        self.w[at..at + BLOCK].copy_from_slice(depths);
        self.key[at..at + BLOCK].copy_from_slice(keys);
        self.own[at..at + BLOCK].copy_from_slice(cameras);
        self.share[at..at + BLOCK].fill(1.0);
        self.pixel[at..at + BLOCK].copy_from_slice(&pixels);
    }

    /// How many there are.
    #[inline(always)]
    pub(crate) fn count(&self) -> usize {
        self.count
    }

    /// Key, share and pixel of a point.
    #[inline(always)]
    pub(crate) fn layer(&self, at: usize) -> (u64, f32, u32) {
        let at = at % MOST;
        (self.key[at], self.share[at], self.pixel[at])
    }

    /// The color of a point; `own`, that of the nearest sample, stands in where too little is known.
    #[inline(always)]
    pub(crate) fn color(&self, at: usize, own: impl FnOnce() -> [f32; 3]) -> [f32; 3] {
        let at = at % MOST;
        let (mut sum, mut total) = ([0, 1, 2].map(|channel: usize| self.color[channel][at]), self.weight[at]);
        let known = self.known[at];
        if known < ENOUGH {
            let lack = if known > 0.0 { (ENOUGH - known) * OWN_SHARE * total / known } else { 1.0 };
            let own = own();
            (0..3).for_each(|channel| sum[channel] += own[channel] * lack);
            total += lack;
        }
        sum.map(|channel| channel / total)
    }

    /// Lists the points that are in the mask of sixteen which `wants` gives from each sixteenth point on; false where there is
    /// none.
    #[inline(always)]
    fn list(&mut self, wants: impl Fn(&Self, usize) -> u32) -> bool {
        self.wanting.clear();
        for first in (0..self.count).step_by(LANES) {
            let there = u32::MAX >> (32 - LANES.min(self.count - first));
            let mut which = there & wants(self, first.min(MOST - LANES));
            if which == u32::MAX >> (32 - LANES) {
                self.wanting.extend_from_slice(&std::array::from_fn::<u16, LANES, _>(|i| (first + i) as u16));
                continue;
            }
            while which != 0 {
                self.wanting.push((first as u32 + which.trailing_zeros()) as u16);
                which &= which - 1;
            }
        }
        !self.wanting.is_empty()
    }

    /// Lists the points whose nearest sample is a camera's; false where there is none.
    #[inline(always)]
    pub(crate) fn list_own(&mut self, camera: u16) -> bool {
        self.list(|points, first| {
            let own = sixteen(&points.own, first);
            mask(|i| own[i] == camera)
        })
    }

    /// Lists the points of which less is known than `many`, but for those of a camera; false where there is none.
    #[inline(always)]
    pub(crate) fn list_open(&mut self, many: f32, except: Option<u16>) -> bool {
        self.list(|points, first| {
            let known = sixteen(&points.known, first);
            let open = mask(|i| known[i] < many);
            let Some(camera) = except.filter(|_| open != 0) else { return open };
            let own = sixteen(&points.own, first);
            open & mask(|i| own[i] != camera)
        })
    }
}

/// Sixteen numbers out of many.
#[inline(always)]
fn sixteen<T: Copy + Default>(numbers: &[T; MOST], first: usize) -> [T; LANES] {
    numbers[first..].first_chunk::<LANES>().copied().unwrap_or_default()
}
