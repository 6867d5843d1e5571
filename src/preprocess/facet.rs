//! One sample as other cameras test it: everything a comparison reads, in half a cache line.
//!
//! Asking whether another camera shows the same point reads one sample at a place known only then, sixteen such places at a
//! time. Kept apart, its depth, normal, color and rank would be six reads from six places in memory.

use glam::Vec3;
use half::f16;

use super::layer::Level;
use crate::capture::INVALID_INVERSE_DEPTH;
use crate::color;

/// Steps of the colors in a [`Facet`] per 8-bit sRGB step.
pub const COLOR_STEPS: f32 = 32.0;

/// Set in the rank of a mixed sample that yields: it loses against every clean one.
pub const MIXED: u32 = 1 << 31;

/// Set in the rank of a sample on a surface whose normal is not known: it loses against all whose normal is.
pub const UNSURE: u32 = 1 << 30;

/// Set where the normal is known.
const NORMAL_KNOWN: u32 = 1 << 31;

/// Where the level begins.
const LEVEL_SHIFT: u32 = 16;

/// One sample: where its surface is, which way it faces, how it looks, and how well it was sampled.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(32))]
pub struct Facet {
    /// 1/z; 0 at infinity, negative where there is no sample.
    pub inverse_depth: f32,
    /// Unit, in the space of its own camera; `(0, 0, 1)` where it is unknown, so that distances count along the depth.
    pub normal_in_camera: [f32; 3],
    /// Smaller wins; see [`MIXED`] and [`UNSURE`].
    pub rank: u32,
    /// The rank by the rate model that does not decide, to see where the two disagree.
    pub other_rank: u32,
    red_green: u32,
    blue_level_known: u32,
}

impl Facet {
    /// No sample.
    pub const ABSENT: Self = Self {
        inverse_depth: INVALID_INVERSE_DEPTH,
        normal_in_camera: [0.0, 0.0, 1.0],
        rank: u32::MAX,
        other_rank: u32::MAX,
        red_green: 0,
        blue_level_known: 0,
    };

    /// A sample of a level and of linear `color`; a zero normal is unknown. `ranks` by the model that decides and by the other.
    #[must_use]
    pub fn new(
        level: Level,
        inverse_depth: f32,
        normal_in_camera: Vec3,
        color: [f16; 3],
        ranks: [u32; 2],
    ) -> Self {
        let known = normal_in_camera != Vec3::ZERO;
        let normal = if known { normal_in_camera } else { Vec3::Z };
        let [red, green, blue] = color.map(|channel| {
            // 2048 steps are 150 times white; what is brighter than that counts as equally bright.
            (color::steps_from_linear(channel) * COLOR_STEPS + 0.5).min(65535.0) as u32
        });
        Self {
            inverse_depth,
            normal_in_camera: normal.to_array(),
            rank: ranks[0],
            other_rank: ranks[1],
            red_green: red | green << 16,
            blue_level_known: blue | u32::from(level) << LEVEL_SHIFT | if known { NORMAL_KNOWN } else { 0 },
        }
    }

    /// Color in [`COLOR_STEPS`].
    #[inline(always)]
    #[must_use]
    pub fn color(&self) -> [i32; 3] {
        [
            (self.red_green & 0xffff) as i32,
            (self.red_green >> 16) as i32,
            (self.blue_level_known & 0xffff) as i32,
        ]
    }

    /// The level of the sample.
    #[inline(always)]
    #[must_use]
    pub fn level(&self) -> u32 {
        self.blue_level_known >> LEVEL_SHIFT & 0xff
    }

    /// Whether the normal is known.
    #[inline(always)]
    #[must_use]
    pub fn has_normal(&self) -> bool {
        self.blue_level_known & NORMAL_KNOWN != 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_facet_keeps_its_color_to_a_fraction_of_a_step_and_fills_half_a_cache_line() {
        assert_eq!(size_of::<Facet>(), 32);
        for linear in [0.0, 0.003, 0.2, 0.99, 3.0, 100.0] {
            let linear = f16::from_f32(linear);
            let facet = Facet::new(3, 0.5, Vec3::Z, [linear, f16::ZERO, linear], [1, 2]);
            let steps = color::steps_from_linear(linear);
            let [red, green, blue] = facet.color();
            assert!((red as f32 / COLOR_STEPS - steps).abs() <= 0.5 / COLOR_STEPS);
            assert_eq!((red, green), (blue, 0));
            assert!(facet.has_normal() && facet.level() == 3);
        }
        assert!(!Facet::new(3, 0.5, Vec3::ZERO, [f16::ONE; 3], [1, 2]).has_normal());
        let blinding = Facet::new(3, 0.5, Vec3::Z, [f16::MAX; 3], [1, 2]);
        assert_eq!(blinding.color(), [65535; 3]);
    }
}
