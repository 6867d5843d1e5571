//! One sample as it is compared with those of other cameras, cut into parts that are read first, second and last.
//!
//! Testing whether another camera shows the same point reads one sample at an address known only then, sixteen at a time. Such reads
//! cost more than the test itself. The ranks come first: nearly always one camera's sample is the best by far, and the others need no
//! further reads. The surface's depth and normal come second, and its color last.

use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use half::f16;

use crate::capture::INVALID_INVERSE_DEPTH;
use crate::color;
use crate::preprocess::temporal::SpanLevel;

/// Steps of the colors in a [`PackedColor`] per 8-bit sRGB step.
pub(crate) const COLOR_STEPS: f32 = 32.0;

/// Set in the rank of a mixed pixel, whose color or depth is of two surfaces, where such samples yield to all others.
pub(super) const MIXED: u32 = 1 << 31;

/// Set in the rank of a sample on a surface whose normal is not known: it yields to all whose normal is.
pub(super) const UNKNOWN_NORMAL: u32 = 1 << 30;

/// Set beside [`MIXED`] in the rank of a sample at infinity whose color is blended with what is before it.
pub(super) const BLENDED_SKY: u32 = 1 << 29;

/// Whether a rank is of a sky sample whose color is blended with what is before it.
#[inline(always)]
pub(crate) fn is_blended_sky(rank: u32) -> bool {
    rank & BLENDED_SKY != 0
}

/// Whether a rank is that of a mixed pixel, which yields to all others.
#[inline(always)]
pub(crate) fn is_mixed(rank: u32) -> bool {
    rank & MIXED != 0
}

/// Whether a rank is of a surface sample without a known normal.
#[inline(always)]
pub(crate) fn has_unknown_normal(rank: u32) -> bool {
    rank & UNKNOWN_NORMAL != 0
}

/// Set where the normal is known.
const NORMAL_KNOWN: u32 = 1 << 31;

/// Set where the sample is in the air between the foreground and the background.
const FLYING: u32 = 1 << 30;

/// Where the level begins.
const LEVEL_SHIFT: u32 = 16;

/// How well a sample was sampled, by the rate model of the settings: smaller wins.
///
/// ```text
/// [ mixed pixel: 1 bit | unknown normal: 1 bit | blended sky: 1 bit | footprint: 29 bits ]     u32::MAX where there is no sample
/// ```
pub(crate) type Rank = u32;

/// No sample: it loses to all others.
pub(crate) const ABSENT_RANK: Rank = Rank::MAX;

/// Where a sample's surface is and which way it faces.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C, align(16))]
pub(crate) struct PackedGeometry {
    /// 1/z; 0 at infinity, negative where there is no sample.
    pub(crate) inverse_depth: f32,
    /// Unit, in the space of its own camera; `(0, 0, 1)` where it is unknown, so that distances count along the depth.
    pub(crate) normal_in_camera: [f32; 3],
}

impl PackedGeometry {
    /// No sample.
    pub(crate) const ABSENT: Self =
        Self { inverse_depth: INVALID_INVERSE_DEPTH, normal_in_camera: [0.0, 0.0, 1.0] };

    /// A sample on a surface; a zero normal is unknown.
    pub(crate) fn new(inverse_depth: f32, normal_in_camera: Vec3) -> Self {
        let normal = if normal_in_camera == Vec3::ZERO { Vec3::Z } else { normal_in_camera };
        Self { inverse_depth, normal_in_camera: normal.to_array() }
    }
}

/// How a sample looks, whether its normal is known, and its level.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
#[repr(C, align(8))]
pub(crate) struct PackedColor {
    red_green: u32,
    blue_level_known: u32,
}

impl PackedColor {
    /// No sample.
    pub(crate) const ABSENT: Self = Self { red_green: 0, blue_level_known: 0 };

    /// A sample of a level and of linear `color`.
    pub(crate) fn new(level: SpanLevel, color: [f16; 3], has_normal: bool) -> Self {
        let [red, green, blue] = color.map(|channel| {
            // 2048 steps are 150 times white; what is brighter than that counts as equally bright.
            (color::steps_from_linear(channel) * COLOR_STEPS + 0.5).min(65535.0) as u32
        });
        let known = if has_normal { NORMAL_KNOWN } else { 0 };
        Self {
            red_green: red | green << 16,
            blue_level_known: blue | u32::from(level) << LEVEL_SHIFT | known,
        }
    }

    /// Color in [`COLOR_STEPS`].
    #[inline(always)]
    pub(crate) fn color(self) -> [i32; 3] {
        [
            (self.red_green & 0xffff) as i32,
            (self.red_green >> 16) as i32,
            (self.blue_level_known & 0xffff) as i32,
        ]
    }

    /// The level of the sample.
    #[inline(always)]
    pub(crate) fn level(self) -> u32 {
        self.blue_level_known >> LEVEL_SHIFT & 0xff
    }

    /// The same of a sample that flies or does not.
    pub(super) fn flying(self, is_flying: bool) -> Self {
        let flying = if is_flying { FLYING } else { 0 };
        Self { blue_level_known: self.blue_level_known & !FLYING | flying, ..self }
    }

    /// Whether the sample is in the air between the foreground and the background, and the settings ask for such samples.
    pub(crate) fn is_flying(self) -> bool {
        self.blue_level_known & FLYING != 0
    }

    /// Whether the normal is known.
    #[inline(always)]
    pub(crate) fn has_normal(self) -> bool {
        self.blue_level_known & NORMAL_KNOWN != 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sample_keeps_its_color_to_a_fraction_of_a_step_and_four_share_a_cache_line() {
        assert_eq!((size_of::<Rank>(), size_of::<PackedGeometry>(), size_of::<PackedColor>()), (4, 16, 8));
        for linear in [0.0, 0.003, 0.2, 0.99, 3.0, 100.0] {
            let linear = f16::from_f32(linear);
            let look = PackedColor::new(3, [linear, f16::ZERO, linear], true);
            let steps = color::steps_from_linear(linear);
            let [red, green, blue] = look.color();
            assert!((red as f32 / COLOR_STEPS - steps).abs() <= 0.5 / COLOR_STEPS);
            assert_eq!((red, green), (blue, 0));
            assert!(look.has_normal() && look.level() == 3);
        }
        assert!(!PackedColor::new(3, [f16::ONE; 3], false).has_normal());
        let clean = PackedColor::new(3, [f16::ONE; 3], true);
        let flying = clean.flying(true);
        assert!(flying.is_flying() && flying.level() == 3 && flying.has_normal() && !clean.is_flying());
        assert_eq!((flying.color(), flying.flying(false)), (clean.color(), clean));
        assert_eq!(PackedColor::new(3, [f16::MAX; 3], true).color(), [65535; 3]);
        assert_eq!(PackedGeometry::new(0.5, Vec3::ZERO).normal_in_camera, [0.0, 0.0, 1.0]);
    }
}
