//! The tolerances of the same-surface test, and which samples take part in it.

use crate::preprocess::temporal::SpanLevel;
use crate::settings::Settings;

/// Tolerances of the same-surface test, converted once.
#[derive(Clone, Copy, Debug)]
pub(super) struct SurfaceTolerances {
    pub(super) depth_footprints: f32,
    pub(super) normal_cosine: f32,
    pub(super) color_steps: f32,
    /// Standard deviations of noise that are granted beside the tolerances.
    pub(super) color_sigmas: f32,
    pub(super) depth_sigmas: f32,
    /// Standard deviations of depth noise between cameras that are granted where they exceed the tolerance.
    pub(super) between_sigmas: f32,
    /// Whether the target has to show the surface all around the point.
    pub(super) overlap: bool,
    /// Whether scalar values have to agree.
    pub(super) values: bool,
}

/// Samples of deeper levels are invisible.
#[derive(Clone, Copy, Debug)]
pub(super) struct VisibleLevels {
    pub(super) deepest: u32,
    /// Whether the target may have samples of deeper levels.
    pub(super) hides_any: bool,
}

impl VisibleLevels {
    pub(super) const ALL: Self = Self { deepest: SpanLevel::MAX as u32, hides_any: true };
}

/// Two noisy colors of one surface, and two noisy depths, differ by less than this many standard deviations of their difference.
const SIGMAS: f32 = 3.0;

impl SurfaceTolerances {
    /// Those of `settings`.
    pub(super) fn of(settings: &Settings) -> Self {
        let pruning = &settings.pruning;
        Self {
            depth_footprints: pruning.depth_tolerance,
            normal_cosine: pruning.normal_tolerance.to_radians().cos(),
            color_steps: pruning.color_tolerance,
            color_sigmas: settings.spans.noise * SIGMAS,
            depth_sigmas: settings.spans.noise * SIGMAS,
            between_sigmas: settings.spans.noise * SIGMAS,
            overlap: pruning.overlap,
            values: true,
        }
    }

    /// A distance alone, whatever normals and colors are.
    pub(super) fn of_geometry(footprints: f32) -> Self {
        Self {
            depth_footprints: footprints,
            normal_cosine: f32::NEG_INFINITY,
            color_steps: f32::from(u16::MAX),
            color_sigmas: 0.0,
            depth_sigmas: 0.0,
            between_sigmas: 0.0,
            overlap: false,
            values: false,
        }
    }

    /// These, whatever normals and colors are, and at pixels alone.
    pub(super) fn geometry_alone(self) -> Self {
        let Self { depth_sigmas, between_sigmas, .. } = self;
        Self { depth_sigmas, between_sigmas, ..Self::of_geometry(self.depth_footprints) }
    }
}
