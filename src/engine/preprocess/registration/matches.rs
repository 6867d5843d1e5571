//! What one camera shows of the samples of another: the conditions that each lane of a block meets, as bits, and the outcome.

use crate::simd::LANES;

/// What another camera shows where a sample's point is in its picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Outcome {
    /// The point is behind the camera.
    Behind,
    /// The point is outside the picture.
    OutsideView,
    /// The camera recorded no depth at that pixel.
    NoDepth,
    /// The camera saw the same surface point, but for a shorter span only: its sample is decided later, and is no
    /// witness of longer ones.
    ShorterSpan,
    /// The camera sees something nearer at that pixel.
    Occluded,
    /// The camera sees something farther at that pixel: it looks past the point.
    SeesPast,
    /// Same depth, but the normals differ.
    NormalDiffers,
    /// Same depth, but the colors differ.
    ColorDiffers,
    /// Same depth, but some scalar value differs.
    ValueDiffers,
    /// The camera shows the surface only on one side of the point: there it cannot be interpolated.
    Seam,
    /// The camera saw the same surface point, at this pixel (`y * width + x`).
    Same(u32),
}

/// What the target shows of the samples of a block: for each a set of bits, and where in the target its point lies.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SurfaceMatches<const N: usize = LANES> {
    pub(crate) bits: [u32; N],
    /// Pixels of the target, `y * width + x`; 0 where the point is outside.
    pub(crate) pixel: [u32; N],
    /// Levels of the samples found.
    pub(crate) level: [u32; N],
}

pub(crate) const IN_FRONT: u32 = 1;
pub(crate) const IN_VIEW: u32 = 1 << 1;
pub(crate) const HAS_DEPTH: u32 = 1 << 2;
pub(crate) const ON_SURFACE: u32 = 1 << 3;
pub(crate) const NORMAL_AGREES: u32 = 1 << 4;
pub(crate) const COLOR_AGREES: u32 = 1 << 5;
pub(crate) const VALUES_AGREE: u32 = 1 << 6;
pub(crate) const SURROUNDED: u32 = 1 << 7;
pub(crate) const SAME: u32 = (1 << 8) - 1;
/// The target sees something nearer than the point: no condition, but part of the outcome.
pub(crate) const NEARER: u32 = 1 << 8;

/// For the samples of a block, the smallest tolerances at which each shows the same surface point as the target does, up to
/// rounding; anything where no tolerance makes it so.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RequiredTolerances<const N: usize = LANES> {
    /// In footprints, of the point itself and, where overlap is tested, of the pixels around it.
    pub(crate) depth: [f32; N],
    /// One less the cosine between the normals.
    pub(crate) turn: [f32; N],
    /// In 8-bit sRGB steps; where they are fewer than [`RequiredTolerances::negligible_steps`], noise is not counted.
    pub(crate) color: [f32; N],
    /// Colors that differ by no more than this agree at every tolerance in question.
    pub(crate) negligible_steps: f32,
}

impl<const N: usize> RequiredTolerances<N> {
    pub(crate) fn new(negligible_steps: f32) -> Self {
        Self { depth: [0.0; N], turn: [0.0; N], color: [0.0; N], negligible_steps }
    }
}

impl<const N: usize> SurfaceMatches<N> {
    /// Whether the target shows the same surface point as the sample in `lane`.
    #[inline(always)]
    pub(crate) fn is_same(&self, lane: usize) -> bool {
        self.bits[lane] & SAME == SAME
    }

    /// Whether any of the `relevant` samples meets a condition.
    #[inline(always)]
    pub(super) fn any(&self, relevant: [u32; N], condition: u32) -> bool {
        let mut any = 0;
        for i in 0..N {
            any |= if relevant[i] == 0 { 0 } else { self.bits[i] & condition };
        }
        any != 0
    }

    /// The first condition that is not met.
    pub(crate) fn outcome(&self, lane: usize) -> Outcome {
        let bits = self.bits[lane];
        let first_missing = (!bits & SAME).trailing_zeros();
        match 1_u32.checked_shl(first_missing).unwrap_or(0) {
            IN_FRONT => Outcome::Behind,
            IN_VIEW => Outcome::OutsideView,
            HAS_DEPTH => Outcome::NoDepth,
            ON_SURFACE if bits & NEARER != 0 => Outcome::Occluded,
            ON_SURFACE => Outcome::SeesPast,
            NORMAL_AGREES => Outcome::NormalDiffers,
            COLOR_AGREES => Outcome::ColorDiffers,
            VALUES_AGREE => Outcome::ValueDiffers,
            SURROUNDED => Outcome::Seam,
            _ => Outcome::Same(self.pixel[lane]),
        }
    }
}
