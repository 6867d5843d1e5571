//! Which share of a hole shows the sky, where no camera has seen all of its line of sight free.
//!
//! Surfaces are taken to be met in hidden space as if they lay there at random: along a hidden share `h` of the line of sight, of what
//! lies between the nearest and the farthest surface around, none is met with probability exp(−density · h). A hole shows the sky and
//! the surface behind it by that share, which errs least in the mean.
//!
//! Source: the exponential transmittance of random media (Blinn, *Light Reflection Functions for Simulation of Clouds and Dusty
//! Surfaces*, SIGGRAPH 1982), here of what was not seen. The densities were chosen by hand where traced scenes have their truth: leaves,
//! heaps, spheres, an orrery and a room.

/// The density between parts of a surface on both sides, and where no sky is seen across the hole.
const FACING_DENSITY: f32 = 16.0;

/// The density within nearer surfaces.
const ENCLOSED_DENSITY: f32 = 24.0;

/// Within nearer surfaces a surface may be met where hardly anything is hidden.
const ENCLOSED_SKY: f32 = 0.9;

/// What is around a hole whose line of sight is hidden in part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum HolePlace {
    /// The sky is seen across the hole, and parts of a surface do not face each other.
    Open,
    /// Parts of a surface face each other, or no sky is seen.
    Facing,
    /// Nearer surfaces enclose it.
    Enclosed,
}

/// The share of a hole that shows the sky, 0 to 1, by the share of its line of sight that is hidden.
pub(crate) fn sky_share(place: HolePlace, hidden_share: f32) -> f32 {
    match place {
        HolePlace::Open => 1.0,
        HolePlace::Facing => (-FACING_DENSITY * hidden_share).exp(),
        HolePlace::Enclosed => ENCLOSED_SKY * (-ENCLOSED_DENSITY * hidden_share).exp(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_more_is_hidden_the_less_of_the_sky_is_shown_and_least_within_nearer_surfaces() {
        for hidden in [1.0 / 64.0, 0.1, 0.5, 1.0] {
            let share = |place| sky_share(place, hidden);
            assert!(share(HolePlace::Enclosed) < share(HolePlace::Facing));
            assert!(share(HolePlace::Facing) < share(HolePlace::Open));
            assert!(sky_share(HolePlace::Facing, 2.0 * hidden) < share(HolePlace::Facing));
        }
        assert_eq!(sky_share(HolePlace::Enclosed, f32::INFINITY), 0.0);
    }
}
