//! The silhouette stage: where a nearer surface ends.
//!
//! A footprint reaches half a pixel of its camera beyond the last sample of a surface, whether the surface does or not, and
//! the z-buffer keeps what any camera shows: surfaces grow. So at a step in depth all cameras vote: how much of the 2×2 samples
//! around the point shows the nearer surface there, and how much shows what is behind it? The share that supports the nearer
//! surface is the pixel's blend between the two. Cracks, a pixel of the farther surface between two of a nearer one, are decided
//! in the same way, and so is the fringe of magnified samples, which covers wider gaps.
//!
//! Source: for free space seen by one camera that overrules what another shows, Merrell et al., *Real-Time Visibility-Based
//! Fusion of Depth Maps*, ICCV 2007. What differs: votes are bilinear shares instead of counts, so that the boundary is finer
//! than a pixel and is painted as a blend.

use super::target::BLOCK;
use super::visibility_votes::Votes;
use crate::render::splat::{CORE, inverse_depth_of, key, nearness, slot_of};
use crate::simd::joined;

/// A pixel is the nearer surface's by an offset and a gain of a supporting share: 0.15 + 1.2 · s. Fitted once to how often the
/// nearer surface was truly there, on a rendered capture: shares understate it, as samples beside an edge agree less exactly.
const OWN_SHARE: (f32, f32) = (0.15, 1.2);

/// The same for a sub-pixel, half as wide as a pixel, over which the share changes half as much. From 9/16 on, which is the share at
/// a quarter of a pixel from a sample beside a convex corner, it is all the nearer surface's: a camera's own picture stays.
const SUBPIXEL_SHARE: (f32, f32) = (0.1, 1.6);

/// The same for a crack at a sub-pixel, which is closed if more than half of what is around it shows the nearer surface.
const SUBPIXEL_CRACK_SHARE: (f32, f32) = (-1.3, 4.1);

/// Shares of less than this are none: rounding alone must not blend.
const LEAST_SHARE: f32 = 1.0 / 256.0;

/// A share that is none or all where it is nearly that.
#[inline(always)]
fn snapped(share: f32) -> f32 {
    if share < LEAST_SHARE {
        0.0
    } else if share > 1.0 - LEAST_SHARE {
        1.0
    } else {
        share
    }
}

/// A surface is extrapolated beyond its edge if its inverse depth changes by at most this many tolerances a pixel.
const MAX_SLOPE: f32 = 8.0;

/// Directions in which two opposite neighbors are looked for.
const CRACK_DIRECTIONS: [(isize, isize); 4] = [(1, 0), (0, 1), (1, 1), (1, -1)];

/// Steps to them; the first alone where pixels have no sub-pixels.
const CRACK_STEPS: [(isize, isize); 3] = [(1, 1), (1, 2), (2, 1)];

/// Votes that sum to less than this share of the largest camera weight decide nothing.
const MIN_VOTES: f32 = 0.02;

/// The surfaces that a pixel shows, as keys.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum PixelSurfaces {
    /// None.
    Hole,
    /// One surface.
    One(u64),
    /// A nearer surface over a farther one, and the share of the nearer.
    Two { near: u64, far: u64, share: f32 },
}

/// What is to be decided about a pixel at a step in depth.
#[derive(Clone, Copy, Debug)]
pub(super) enum EdgePixel {
    /// Nothing: no vote is needed.
    Decided(PixelSurfaces),
    /// Whether the nearer surface of two opposite neighbors continues between them, over `own`; 0 if that is a hole.
    Crack { own: u64, crack: u64 },
    /// How much of the pixel `own`'s surface covers, and how much the farther one; 0 if that is a hole.
    Rim { own: u64, far: u64 },
}

impl EdgePixel {
    /// The key of the surface that cameras vote on.
    #[inline(always)]
    pub(super) fn voted_key(&self) -> Option<u64> {
        match *self {
            Self::Decided(_) => None,
            Self::Crack { crack, .. } => Some(crack),
            Self::Rim { own, .. } => Some(own),
        }
    }

    /// The surfaces of the pixel, by the votes on [`EdgePixel::voted_key`]; it is one of so many along a side of a pixel of the
    /// picture.
    #[inline(always)]
    pub(super) fn decide(&self, votes: Votes, subpixels: usize) -> PixelSurfaces {
        let (offset, gain) = match self {
            _ if subpixels == 1 => OWN_SHARE,
            Self::Crack { .. } => SUBPIXEL_CRACK_SHARE,
            _ => SUBPIXEL_SHARE,
        };
        let decides = votes.total > MIN_VOTES * votes.max_weight;
        let share = decides.then(|| snapped(offset + gain * votes.agree / votes.total));
        let blend = |near, far, share| match far {
            0 if share < 0.5 => PixelSurfaces::Hole,
            0 => PixelSurfaces::One(near),
            far => PixelSurfaces::Two { near, far, share },
        };
        match *self {
            Self::Decided(pixel) => pixel,
            Self::Crack { own, crack } => match share.unwrap_or(1.0) {
                // Without the votes' support there is no crack to close but a real gap.
                share if share < 0.5 && own != 0 => PixelSurfaces::One(own),
                share => blend(crack, own, share),
            },
            Self::Rim { own, far } => share.map_or(PixelSurfaces::One(own), |share| blend(own, far, share)),
        }
    }
}

/// A key of a core sample; 0, as for a hole, if it is of a fringe.
#[inline(always)]
fn core_of(key: u64) -> u64 {
    if key >> 63 == 1 { key } else { 0 }
}

/// Pixels around a block that decisions in it read.
pub(crate) const RING: usize = 2;

/// Columns and rows of a block with its ring.
pub(crate) const SIDE: usize = BLOCK + 2 * RING;

/// The z-buffer of a block of pixels and a ring around it; beyond the picture its outermost pixels repeat.
#[derive(Debug)]
pub(crate) struct Patch {
    pub(crate) keys: [[u64; SIDE]; SIDE],
    /// Column and row in the picture of the block's first pixel.
    pub(crate) left: usize,
    pub(crate) top: usize,
    /// Inverse depths from this share of the nearest one on belong to the same surface.
    pub(crate) surface_ratio: f32,
    /// Pixels of the z-buffer along each side of a pixel of the picture.
    pub(crate) subpixels: usize,
}

impl Patch {
    /// A patch of holes.
    pub(super) fn empty() -> Self {
        Self { keys: [[0; SIDE]; SIDE], left: 0, top: 0, surface_ratio: 1.0, subpixels: 1 }
    }

    #[inline(always)]
    fn key(&self, x: usize, y: usize, (dx, dy): (isize, isize)) -> u64 {
        core_of(self.keys[(y + RING).wrapping_add_signed(dy)][(x + RING).wrapping_add_signed(dx)])
    }

    /// For every pixel of the block whether something is to be decided about it: it shows no core sample, a farther surface or a hole
    /// is beside it, or a crack may run over it. A mask of columns per row.
    #[inline(always)]
    pub(super) fn edges(&self) -> [u16; BLOCK] {
        let (mut w, mut far) = ([[0.0_f32; SIDE]; SIDE], [[0.0_f32; BLOCK]; SIDE]);
        for (row, keys) in self.keys.iter().enumerate() {
            let w = &mut w[row];
            for x in 0..SIDE {
                w[x] = inverse_depth_of(core_of(keys[x]));
            }
            for x in 0..BLOCK {
                far[row][x] = w[x + 1].min(w[x + 2]).min(w[x + 3]);
            }
        }
        let mut edges = [0; BLOCK];
        for y in 0..BLOCK {
            let (mut bits, mut near) = ([0_u32; BLOCK], [0.0_f32; BLOCK]);
            for x in 0..BLOCK {
                let own = w[y + RING][x + RING];
                let far = far[y + 1][x].min(far[y + 2][x]).min(far[y + 3][x]);
                bits[x] = u32::from((far < own * self.surface_ratio) | (own < 0.0)) << x;
            }
            // In front of a crack lie two opposite neighbors, of which the farther one is near enough.
            let flat = w.as_flattened();
            let middle = (y + RING) * SIDE + RING;
            for (ahead, back) in &CRACK_STEPS[..self.crack_widths()] {
                for (dx, dy) in CRACK_DIRECTIONS {
                    let step = dx + dy * SIDE as isize;
                    let a = flat[middle.wrapping_add_signed(ahead * step)..].first_chunk::<BLOCK>();
                    let b = flat[middle.wrapping_add_signed(-back * step)..].first_chunk::<BLOCK>();
                    let (Some(a), Some(b)) = (a, b) else { continue };
                    for x in 0..BLOCK {
                        near[x] = near[x].max(a[x].min(b[x]));
                    }
                }
            }
            for x in 0..BLOCK {
                bits[x] |= u32::from(w[y + RING][x + RING] < near[x] * self.surface_ratio) << x;
            }
            edges[y] = joined(&bits) as u16;
        }
        edges
    }

    /// How many of [`CRACK_STEPS`] are looked at. Cracks are as wide as a pixel of the picture: where that has two sub-pixels, one of
    /// the neighbors may lie two steps away.
    #[inline(always)]
    fn crack_widths(&self) -> usize {
        if self.subpixels == 2 { CRACK_STEPS.len() } else { 1 }
    }

    /// What is to be decided about pixel `(x, y)` of the block.
    #[inline(always)]
    pub(super) fn edge_pixel(&self, x: usize, y: usize) -> EdgePixel {
        let own = self.key(x, y, (0, 0));
        let own_w = inverse_depth_of(own);
        if let Some(crack) = self.crack(own_w, x, y) {
            return EdgePixel::Crack { own, crack };
        }
        if own == 0 {
            // A fringe is voted on like a crack.
            return match self.keys[y + RING][x + RING] {
                0 => EdgePixel::Decided(PixelSurfaces::Hole),
                fringe => EdgePixel::Crack { own, crack: fringe | u64::from(CORE) << 32 },
            };
        }
        match self.farther(own_w, x, y) {
            None => EdgePixel::Decided(PixelSurfaces::One(own)),
            Some(far) => EdgePixel::Rim { own, far },
        }
    }

    /// The farthest surface behind `own_w` that a neighbor shows, extrapolated to `(x, y)`; 0 if the only other neighbors are
    /// holes, `None` if there are no others.
    #[inline(always)]
    fn farther(&self, own_w: f32, x: usize, y: usize) -> Option<u64> {
        let limit = own_w * self.surface_ratio;
        let mut farthest: Option<(f32, u64)> = None;
        let mut beside_hole = false;
        for step in [(-1, 0), (1, 0), (0, -1), (0, 1), (-1, -1), (1, -1), (-1, 1), (1, 1)] {
            let neighbor = self.key(x, y, step);
            beside_hole |= neighbor == 0;
            if neighbor == 0 || inverse_depth_of(neighbor) >= limit {
                continue;
            }
            let w = self.extrapolated(neighbor, (x, y), step);
            if w < limit && farthest.is_none_or(|(farthest, _)| w < farthest) {
                farthest = Some((w, key(nearness(w, CORE), slot_of(neighbor))));
            }
        }
        farthest.map(|(_, key)| key).or(beside_hole.then_some(0))
    }

    /// Inverse depth at `(x, y)` of the surface that the neighbor in direction `(dx, dy)` shows, extrapolated from the pixel beyond
    /// that neighbor.
    #[inline(always)]
    fn extrapolated(&self, neighbor: u64, (x, y): (usize, usize), (dx, dy): (isize, isize)) -> f32 {
        let w = inverse_depth_of(neighbor);
        let beyond = self.key(x, y, (2 * dx, 2 * dy));
        let step = w - inverse_depth_of(beyond);
        let largest = MAX_SLOPE * (1.0 - self.surface_ratio) * w;
        if beyond != 0 && step.abs() <= largest { (w + step).max(0.0) } else { w }
    }

    /// The nearest surface in front of `own_w` that two opposite neighbors show.
    #[inline(always)]
    fn crack(&self, own_w: f32, x: usize, y: usize) -> Option<u64> {
        let mut nearest: Option<(f32, u64)> = None;
        let steps = CRACK_STEPS[..self.crack_widths()].iter();
        let steps = steps.flat_map(|steps| CRACK_DIRECTIONS.map(|direction| (direction, *steps)));
        for ((dx, dy), (ahead, back)) in steps {
            let (a, b) = (self.key(x, y, (ahead * dx, ahead * dy)), self.key(x, y, (-back * dx, -back * dy)));
            let (wa, wb) = (inverse_depth_of(a), inverse_depth_of(b));
            let mean = 0.5 * (wa + wb);
            let alike = a != 0 && b != 0 && wa.min(wb) >= wa.max(wb) * self.surface_ratio;
            if alike && own_w < mean * self.surface_ratio && nearest.is_none_or(|(w, _)| mean > w) {
                nearest = Some((mean, key(nearness(mean, CORE), slot_of(a))));
            }
        }
        nearest.map(|(_, key)| key)
    }
}
