//! The surface points of some blocks of pixels, and their colors as far as they were found.

use std::ops::Range;

use super::target::{BLOCK, TOGETHER};
use crate::render::vantage::FrontColor;
use crate::simd::{LANES, mask};

/// Where less than this share of a pixel is covered by interpolated samples, the nearest sample's own color is mixed in.
const MIN_COVERAGE: f32 = 0.25;

/// The weight of the nearest sample's own color for each share of the pixel below [`MIN_COVERAGE`].
const OWN_SHARE: f32 = 0.2;

/// Most surface points of the blocks that are gathered together: two in each pixel.
pub(super) const MOST: usize = 2 * BLOCK * BLOCK * TOGETHER;

/// A place in a pixel: column and row in the z-buffer, the pixel's position in the strip of the picture, and the cameras that can tell
/// something of it: a mask as in [`NearCameras`](super::near_cameras::NearCameras).
#[derive(Clone, Copy)]
pub(super) struct StripPixel {
    pub(super) x: f32,
    pub(super) y: f32,
    pub(super) at: u32,
    pub(super) near: u32,
}

/// Inverse depth of a surface in the middle of a pixel, and its growth by column and by row of the z-buffer; 0 where it is not known.
#[derive(Clone, Copy)]
pub(super) struct SurfaceDepth {
    pub(super) w: f32,
    pub(super) slope: [f32; 2],
}

/// How much of a pixel a surface takes, 0 to 1.
#[derive(Clone, Copy)]
pub(super) struct PixelShares {
    /// For the whole pixel.
    pub(super) pixel: f32,
    /// For what the pixel shows in front of its farthest surface.
    pub(super) front: f32,
}

impl PixelShares {
    /// All of a pixel without a front.
    pub(super) const WHOLE: Self = Self { pixel: 1.0, front: 0.0 };
}

/// The surface points of some blocks, and the sums of their colors.
#[derive(Debug)]
pub(super) struct SurfacePoints {
    count: usize,
    /// Columns of their pixels.
    pub(super) x: [f32; MOST],
    /// Rows of their pixels.
    pub(super) y: [f32; MOST],
    /// Inverse depths.
    pub(super) w: [f32; MOST],
    /// Growth of the inverse depth by column and by row; 0 where it is not known.
    pub(super) slope: [[f32; MOST]; 2],
    /// Keys of the nearest samples.
    key: [u64; MOST],
    /// The cameras of these samples.
    own: [u16; MOST],
    /// As in [`StripPixel`].
    near: [u32; MOST],
    /// Share of the pixel that shows the point.
    share: [f32; MOST],
    /// Share of what the pixel shows in front of its farthest surface.
    front_share: [f32; MOST],
    /// The pixels, as positions in the strip.
    pixel: [u32; MOST],
    /// Red, green and blue, weighted by `weight`, and a zero.
    pub(super) color: [[f32; 4]; MOST],
    pub(super) weight: [f32; MOST],
    /// Pixels' worth of samples that were added up.
    pub(super) coverage: [f32; MOST],
    /// The points that one camera is read for.
    pub(super) selected: Vec<u16>,
}

impl SurfacePoints {
    #[expect(clippy::large_stack_arrays, reason = "on their way to the heap, once per thread")]
    pub(super) fn new() -> Box<Self> {
        let zero = [0.0; MOST];
        Box::new(Self {
            count: 0,
            x: zero,
            y: zero,
            w: zero,
            slope: [zero; 2],
            key: [0; MOST],
            own: [0; MOST],
            near: [0; MOST],
            share: zero,
            front_share: zero,
            pixel: [0; MOST],
            color: [[0.0; 4]; MOST],
            weight: zero,
            coverage: zero,
            selected: Vec::with_capacity(MOST),
        })
    }

    pub(super) fn clear(&mut self) {
        self.count = 0;
    }

    /// Where the points of the next block begin: at a multiple of sixteen.
    pub(super) fn begin_block(&mut self) -> usize {
        self.count = self.count.next_multiple_of(LANES);
        self.count
    }

    /// Where the points end.
    pub(super) fn end(&self) -> usize {
        self.count
    }

    /// Sets the colors of all points to none.
    #[inline(always)]
    pub(super) fn reset_colors(&mut self) {
        let count = self.count;
        self.color[..count].fill([0.0; 4]);
        self.weight[..count].fill(0.0);
        self.coverage[..count].fill(0.0);
    }

    /// Adds the surface of a key, a sample of camera `own`, which takes `shares` of a pixel.
    #[inline(always)]
    pub(super) fn push(
        &mut self,
        key: u64,
        depth: SurfaceDepth,
        own: u16,
        pixel: StripPixel,
        shares: PixelShares,
    ) {
        let at = self.count % MOST;
        self.count = at + 1;
        self.x[at] = pixel.x;
        self.y[at] = pixel.y;
        self.w[at] = depth.w;
        (self.slope[0][at], self.slope[1][at]) = (depth.slope[0], depth.slope[1]);
        self.key[at] = key;
        self.own[at] = own;
        self.near[at] = pixel.near;
        self.share[at] = shares.pixel;
        self.front_share[at] = shares.front;
        self.pixel[at] = pixel.at;
    }

    /// Adds the surfaces of pixels in a row, each alone in its pixel, from the first pixel on and `step` columns of the z-buffer apart:
    /// their keys, inverse depths and cameras; `near` as in [`StripPixel`].
    #[inline(always)]
    pub(super) fn push_row<const N: usize>(
        &mut self,
        keys: &[u64; N],
        depths: &[f32; N],
        slopes: &[[f32; N]; 2],
        (cameras, near): (&[u16; N], &[u32; N]),
        first: StripPixel,
        step: f32,
    ) {
        let at = self.count.min(MOST - N);
        self.count = at + N;
        let (mut columns, mut pixels) = ([0.0; N], [0; N]);
        for i in 0..N {
            columns[i] = first.x + i as f32 * step;
            pixels[i] = first.at + i as u32;
        }
        self.x[at..at + N].copy_from_slice(&columns);
        self.y[at..at + N].fill(first.y);
        self.w[at..at + N].copy_from_slice(depths);
        self.slope[0][at..at + N].copy_from_slice(&slopes[0]);
        self.slope[1][at..at + N].copy_from_slice(&slopes[1]);
        self.key[at..at + N].copy_from_slice(keys);
        self.own[at..at + N].copy_from_slice(cameras);
        self.near[at..at + N].copy_from_slice(near);
        self.share[at..at + N].fill(1.0);
        self.front_share[at..at + N].fill(0.0);
        self.pixel[at..at + N].copy_from_slice(&pixels);
    }

    /// Adds the color of each point of a block to its pixel, by its share. Where coverage is low, the color of the nearest sample, which
    /// `own_color` gives by its key, is mixed in.
    #[inline(always)]
    pub(super) fn add_colors(
        &self,
        block: Range<usize>,
        pixels: &mut [[f32; 3]],
        fronts: &mut [FrontColor],
        own_color: impl Fn(u64) -> [f32; 3],
    ) {
        for at in block.map(|at| at % MOST) {
            let mut sum = self.color[at];
            let (mut weight, coverage) = (self.weight[at], self.coverage[at]);
            if coverage < MIN_COVERAGE {
                let lack = if coverage > 0.0 {
                    (MIN_COVERAGE - coverage) * OWN_SHARE * weight / coverage
                } else {
                    1.0
                };
                let own = own_color(self.key[at]);
                (0..3).for_each(|channel| sum[channel] += own[channel] * lack);
                weight += lack;
            }
            let pixel = &mut pixels[self.pixel[at] as usize];
            (0..3).for_each(|channel| pixel[channel] += self.share[at] * (sum[channel] / weight));
            if self.front_share[at] > 0.0
                && let Some(front) = fronts.get_mut(self.pixel[at] as usize)
            {
                (0..3).for_each(|channel| front[channel] += self.front_share[at] * (sum[channel] / weight));
            }
        }
    }

    /// Selects the points of a block, beside those that are selected, whose nearest sample is a camera's.
    #[inline(always)]
    pub(super) fn select_own(&mut self, block: Range<usize>, camera: u16) {
        for first in block.clone().step_by(LANES) {
            let own = sixteen(&self.own, first);
            self.select(first, block.end, mask(|i| own[i] == camera));
        }
    }

    /// Selects those points of a block, beside those that are selected, of which the camera of a bit can tell something and whose coverage is
    /// below `full`, except those of one camera.
    #[inline(always)]
    pub(super) fn select_uncovered(&mut self, block: Range<usize>, bit: u32, full: f32, except: Option<u16>) {
        for first in block.clone().step_by(LANES) {
            let (coverage, near) = (sixteen(&self.coverage, first), sixteen(&self.near, first));
            let mut which = mask(|i| (coverage[i] < full) & (near[i] & bit != 0));
            if let Some(camera) = except
                && which != 0
            {
                let own = sixteen(&self.own, first);
                which &= mask(|i| own[i] != camera);
            }
            self.select(first, block.end, which);
        }
    }

    /// Selects the points of a mask of the sixteen from `first` on, as far as they lie before `end`.
    #[inline(always)]
    fn select(&mut self, first: usize, end: usize, which: u32) {
        let mut which = which & u32::MAX >> (32 - LANES.min(end - first));
        if which == u32::MAX >> (32 - LANES) {
            let mut all = [0; LANES];
            for i in 0..LANES {
                all[i] = (first + i) as u16;
            }
            self.selected.extend_from_slice(&all);
            return;
        }
        while which != 0 {
            self.selected.push((first as u32 + which.trailing_zeros()) as u16);
            which &= which - 1;
        }
    }
}

/// Sixteen values from `first` on, which is a multiple of sixteen.
#[inline(always)]
fn sixteen<T: Copy + Default>(numbers: &[T; MOST], first: usize) -> [T; LANES] {
    numbers[first..].first_chunk::<LANES>().copied().unwrap_or_default()
}
