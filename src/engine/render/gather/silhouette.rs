//! The silhouette stage: where a nearer surface ends.
//!
//! A footprint reaches half a pixel of its camera beyond the last sample of a surface, whether the surface does or not, and
//! the z-buffer keeps what any camera shows: surfaces grow. So at a step in depth all cameras vote: how much of the 2×2 samples
//! around the point shows the nearer surface there, and how much shows what is behind it? The share that supports the nearer
//! surface is the pixel's blend between the two. A crack is a pixel of the farther surface between two of a nearer
//! one; the cameras vote on it alike, and on the fringe of magnified samples, which covers wider gaps.
//!
//! Source: for free space seen by one camera that overrules what another shows, Merrell et al., *Real-Time Visibility-Based
//! Fusion of Depth Maps*, ICCV 2007. What differs: votes are bilinear shares instead of counts, so that the boundary is finer
//! than a pixel and is painted as a blend.

use super::target::BLOCK;
use super::visibility_votes::VisibilityVotes;
use crate::render::splat::{CORE, TRUSTED, inverse_depth_of, key, nearness, slot_of};
use crate::simd::joined;

/// A pixel is the nearer surface's by an offset and a gain of a supporting share: 0.15 + 1.2 · s. Fitted once to how often the
/// nearer surface was truly there, on a rendered capture: shares understate it, as samples beside an edge agree less exactly.
const OWN_SHARE: (f32, f32) = (0.15, 1.2);

/// That for a sub-pixel: over half a pixel the share changes half as much. From 9/16 on, the share a quarter of a pixel from a sample
/// beside a convex corner, all is the nearer surface's: a camera's own picture stays.
const SUBPIXEL_SHARE: (f32, f32) = (0.1, 1.6);

/// Where many cameras vote, these offsets are lower by so much, for a pixel and for a sub-pixel. One camera's picture has to stay as it
/// is, so that its votes favor the nearer surface. But the z-buffer keeps what any camera shows, and surfaces grow with every camera that
/// is added: with many, half of the votes has to mean about half of the pixel.
const LESS_BY_MANY: (f32, f32) = (0.25, 0.4);

/// So many cameras of equal weight are many. Between one and these the offsets go down evenly.
const MANY: f32 = 4.0;

/// That for a crack at a sub-pixel: it is closed if more than half of what is around it shows the nearer surface.
const SUBPIXEL_CRACK_SHARE: (f32, f32) = (-1.3, 4.1);

/// Shares of less than this are none: rounding alone must not blend.
const LEAST_SHARE: f32 = 1.0 / 256.0;

/// The share, rounded to 0 or 1 where it is close to either.
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

/// An inverse depth that grows by this share over two pixels, or more, is a step and no slope.
const MAX_GROWTH: f32 = 0.25;

/// Directions to the neighbors of a pixel.
const NEIGHBORS: [(isize, isize); 8] = [(-1, 0), (1, 0), (0, -1), (0, 1), (-1, -1), (1, -1), (-1, 1), (1, 1)];

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
    /// A nearer surface over a farther one, and the share of the nearer. The farther one is a hole if its key is 0.
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

    /// The surfaces of the pixel, by the votes on [`EdgePixel::voted_key`]. A pixel of the picture has `subpixels` such pixels along each
    /// side.
    #[inline(always)]
    pub(super) fn decide(&self, votes: VisibilityVotes, subpixels: usize) -> PixelSurfaces {
        let decides = votes.total > MIN_VOTES * votes.max_weight;
        let more_than_one = if decides { votes.total / votes.max_weight - 1.0 } else { 0.0 };
        let many = (more_than_one / (MANY - 1.0)).clamp(0.0, 1.0);
        let (offset, gain) = match self {
            _ if subpixels == 1 => (OWN_SHARE.0 - LESS_BY_MANY.0 * many, OWN_SHARE.1),
            Self::Crack { .. } => SUBPIXEL_CRACK_SHARE,
            _ => (SUBPIXEL_SHARE.0 - LESS_BY_MANY.1 * many, SUBPIXEL_SHARE.1),
        };
        let share = decides.then(|| snapped(offset + gain * votes.agree / votes.total));
        let blend = |near, far, share| match far {
            // A whole pixel keeps no share.
            0 if subpixels == 1 && share < 0.5 || share <= 0.0 => PixelSurfaces::Hole,
            0 if subpixels == 1 || share >= 1.0 => PixelSurfaces::One(near),
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
    /// Inverse depths of the core samples; negative where there is none.
    pub(super) w: [[f32; SIDE]; SIDE],
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
        let (keys, w) = ([[0; SIDE]; SIDE], [[-1.0; SIDE]; SIDE]);
        Self { keys, w, left: 0, top: 0, surface_ratio: 1.0, subpixels: 1 }
    }

    /// Sets the inverse depths from the keys.
    #[inline(always)]
    pub(crate) fn set_depths(&mut self) {
        for (w, keys) in self.w.iter_mut().zip(&self.keys) {
            for x in 0..SIDE {
                w[x] = inverse_depth_of(core_of(keys[x]));
            }
        }
    }

    /// The key of a pixel of the block.
    #[inline(always)]
    fn key(&self, x: usize, y: usize) -> u64 {
        core_of(self.keys[y + RING][x + RING])
    }

    /// Growth of the inverse depth by column and by row around the middle of the four pixels from column `x` and row `y` of the block
    /// on, at most the last but one: the smaller growth toward the two sides, 0 where these disagree or a step in depth is.
    #[inline(always)]
    pub(super) fn slope(&self, x: usize, y: usize) -> [f32; 2] {
        let (x, y) = (x.min(BLOCK - 2) + RING, y.min(BLOCK - 2) + RING);
        let sum = |x: usize, y: usize| {
            let [above, below] = [&self.w[y], &self.w[y + 1]];
            (above[x] + above[x + 1]) + (below[x] + below[x + 1])
        };
        let here = sum(x, y);
        let growth = |before: f32, after: f32| {
            let (back, on) = (here - before, after - here);
            let least = if back.abs() < on.abs() { back } else { on };
            let is_slope = (back * on > 0.0) & (least.abs() < MAX_GROWTH * here);
            // Four values together, over two pixels.
            if is_slope { 0.125 * least } else { 0.0 }
        };
        [growth(sum(x - 2, y), sum(x + 2, y)), growth(sum(x, y - 2), sum(x, y + 2))]
    }

    /// For every pixel of the block whether something is to be decided about it: it shows no core sample, a farther surface or a hole
    /// is beside it, or a crack may run over it. A mask of columns per row.
    #[inline(always)]
    pub(super) fn edges(&self) -> [u16; BLOCK] {
        let w = &self.w;
        let mut far = [[0.0_f32; BLOCK]; SIDE];
        for (w, far) in w.iter().zip(&mut far) {
            for x in 0..BLOCK {
                far[x] = w[x + 1].min(w[x + 2]).min(w[x + 3]);
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
            // Two opposite neighbors in front of a crack; the farther one is near enough.
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
    /// the neighbors may be two steps away.
    #[inline(always)]
    fn crack_widths(&self) -> usize {
        if self.subpixels == 2 { CRACK_STEPS.len() } else { 1 }
    }

    /// What surfaces are around the pixels of a row of the block, sixteen at a time.
    #[inline(always)]
    pub(super) fn edge_row(&self, y: usize) -> EdgeRow {
        let flat = self.w[y..=y + 2 * RING].as_flattened();
        let middle = RING * SIDE + RING;
        let own = beside(flat, middle, 0);
        let mut row = EdgeRow {
            crack_w: [-1.0; BLOCK],
            crack_step: [0; BLOCK],
            far_w: [f32::INFINITY; BLOCK],
            far_step: [0; BLOCK],
            beside_hole: 0,
        };
        for (ahead, back) in &CRACK_STEPS[..self.crack_widths()] {
            for (dx, dy) in CRACK_DIRECTIONS {
                let step = dx + dy * SIDE as isize;
                let (a, b) = (beside(flat, middle, ahead * step), beside(flat, middle, -back * step));
                for x in 0..BLOCK {
                    let mean = 0.5 * (a[x] + b[x]);
                    let (near, far) = (a[x].max(b[x]), a[x].min(b[x]));
                    let is_found = (far >= 0.0)
                        & (far >= near * self.surface_ratio)
                        & (own[x] < mean * self.surface_ratio)
                        & (mean > row.crack_w[x]);
                    row.crack_w[x] = if is_found { mean } else { row.crack_w[x] };
                    row.crack_step[x] = if is_found { (ahead * step) as i32 } else { row.crack_step[x] };
                }
            }
        }
        let mut beside_hole = [0_u32; BLOCK];
        for (dx, dy) in NEIGHBORS {
            let step = dx + dy * SIDE as isize;
            let (neighbor, beyond) = (beside(flat, middle, step), beside(flat, middle, 2 * step));
            for x in 0..BLOCK {
                let limit = own[x] * self.surface_ratio;
                let w = extrapolated(neighbor[x], beyond[x], self.surface_ratio);
                let is_farther =
                    (neighbor[x] >= 0.0) & (neighbor[x] < limit) & (w < limit) & (w < row.far_w[x]);
                row.far_w[x] = if is_farther { w } else { row.far_w[x] };
                row.far_step[x] = if is_farther { step as i32 } else { row.far_step[x] };
                beside_hole[x] |= u32::from(neighbor[x] < 0.0) << x;
            }
        }
        row.beside_hole = joined(&beside_hole);
        row
    }

    /// What is to be decided about pixel `(x, y)` of the block, given what is around the pixels of its row.
    #[inline(always)]
    pub(super) fn edge_pixel(&self, x: usize, y: usize, row: &EdgeRow) -> EdgePixel {
        let own = self.key(x, y);
        let at = (y + RING) * SIDE + x + RING;
        let slot_at = |step: i32| slot_of(self.keys.as_flattened()[at.wrapping_add_signed(step as isize)]);
        let key_of = |w: f32, step: i32| key(nearness(w, CORE | TRUSTED), slot_at(step));
        if row.crack_w[x] >= 0.0 {
            return EdgePixel::Crack { own, crack: key_of(row.crack_w[x], row.crack_step[x]) };
        }
        if own == 0 {
            // A fringe is voted on like a crack.
            return match self.keys[y + RING][x + RING] {
                0 => EdgePixel::Decided(PixelSurfaces::Hole),
                fringe => EdgePixel::Crack { own, crack: fringe | u64::from(CORE) << 32 },
            };
        }
        if row.far_w[x] < f32::INFINITY {
            return EdgePixel::Rim { own, far: key_of(row.far_w[x], row.far_step[x]) };
        }
        // Beside nothing but holes.
        if row.beside_hole >> x & 1 == 1 {
            return EdgePixel::Rim { own, far: 0 };
        }
        EdgePixel::Decided(PixelSurfaces::One(own))
    }
}

/// What surfaces are around the pixels of a row of a block. Steps lead to a neighbor in the keys of a [`Patch`].
pub(super) struct EdgeRow {
    /// Inverse depth of the nearest surface that two opposite neighbors show in front of the pixel; negative without such a surface.
    crack_w: [f32; BLOCK],
    /// To one of these neighbors.
    crack_step: [i32; BLOCK],
    /// Inverse depth of the farthest surface behind the pixel's that a neighbor shows, extrapolated to the pixel; infinite if there
    /// is none.
    far_w: [f32; BLOCK],
    /// To this neighbor.
    far_step: [i32; BLOCK],
    /// Whether a neighbor is a hole: a mask of columns.
    beside_hole: u32,
}

/// The inverse depths of a block's row, moved by a step.
#[inline(always)]
fn beside(flat: &[f32], first: usize, step: isize) -> [f32; BLOCK] {
    flat[first.wrapping_add_signed(step)..].first_chunk::<BLOCK>().copied().unwrap_or_default()
}

/// Inverse depth beside a pixel of inverse depth `w`, extrapolated from the one `beyond` it.
#[inline(always)]
fn extrapolated(w: f32, beyond: f32, surface_ratio: f32) -> f32 {
    let step = w - beyond;
    let largest = MAX_SLOPE * (1.0 - surface_ratio) * w;
    if (beyond >= 0.0) & (step.abs() <= largest) { (w + step).max(0.0) } else { w }
}
