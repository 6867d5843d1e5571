//! What alignment found, for people and for JSON.

use glam::DQuat;
use serde::{Deserialize, Serialize};

use super::exposure::GainCorrection;
use super::median::MEDIAN_PER_SIGMA;
use super::poses::PoseCorrection;
use super::solver::Problem;
use crate::capture::Capture;

/// What was wrong with a capture, and how much better cameras agree without it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Alignment {
    /// Per camera, in the capture's order.
    pub cameras: Vec<AlignedCamera>,
    /// The pairs of cameras that were compared.
    pub pairs: Vec<AlignedPair>,
}

/// What was corrected of one camera.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct AlignedCamera {
    /// The camera's name.
    pub name: String,
    /// How its pose was changed; `None` where it stays.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pose: Option<AlignedPose>,
    /// How its colors were changed; `None` where they stay.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub exposure: Option<AlignedExposure>,
    /// Whether its pose may be wrong, but what the cameras see does not tell in some direction.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub pose_is_weak: bool,
}

/// How a camera's pose was changed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct AlignedPose {
    /// Angle of the rotation.
    pub degrees: f64,
    /// Its standard error about the worst-known axis.
    pub degrees_se: f64,
    /// How far the center of projection moved, in the capture's unit.
    pub distance: f64,
    /// Its standard error along the worst-known axis.
    pub distance_se: f64,
    /// How far its samples moved, root mean square, footprints.
    pub footprints: f64,
    /// Mean loss of samples that judged, without the change; 0 where cameras agree.
    pub loss_before: f64,
    /// The same with the change.
    pub loss_after: f64,
    /// Standard error of the difference.
    pub loss_se: f64,
}

/// How a camera's colors were changed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct AlignedExposure {
    /// Red, green and blue are multiplied by two to the power of this.
    pub stops: [f64; 3],
    /// Standard errors.
    pub stops_se: [f64; 3],
    /// See [`AlignedPose::loss_before`].
    pub loss_before: f64,
    /// See [`AlignedPose::loss_after`].
    pub loss_after: f64,
    /// See [`AlignedPose::loss_se`].
    pub loss_se: f64,
}

/// How far two cameras are apart about what both see, by the median.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct AlignedPair {
    /// Index of the camera whose samples were looked for.
    pub source: usize,
    /// Index of the camera they were looked for in.
    pub target: usize,
    /// Distance from the surface, footprints, before and after.
    pub footprints: [f64; 2],
    /// Difference of brightness (the square root of luminance), before and after.
    pub brightness: [f64; 2],
}

impl Alignment {
    pub(super) fn new(
        (capture, problem): (&Capture, &Problem),
        poses: &[PoseCorrection],
        gains: &[GainCorrection],
        before: Vec<[f64; 2]>,
    ) -> Self {
        let of_camera = |camera: usize| {
            let now = problem.views[camera].camera.world_from_camera;
            let then = capture.cameras[camera].world_from_camera;
            let turn = DQuat::from_mat3(&(now.matrix3 * then.matrix3.transpose())).to_scaled_axis();
            let pose = poses.get(camera).filter(|pose| pose.kept).map(|pose| AlignedPose {
                degrees: turn.length().to_degrees(),
                degrees_se: pose.standard_errors[0].to_degrees(),
                distance: now.translation.distance(then.translation),
                distance_se: pose.standard_errors[1],
                footprints: pose.footprints,
                loss_before: pose.judgment.before,
                loss_after: pose.judgment.after,
                loss_se: pose.judgment.standard_error,
            });
            let exposure = gains.get(camera).filter(|gain| gain.kept).map(|gain| AlignedExposure {
                stops: gain.log_gain.map(|gain| gain / std::f64::consts::LN_2),
                stops_se: gain.standard_error.map(|error| error / std::f64::consts::LN_2),
                loss_before: gain.judgment.before,
                loss_after: gain.judgment.after,
                loss_se: gain.judgment.standard_error,
            });
            let pose_is_weak = poses.get(camera).is_some_and(|pose| pose.is_weak);
            AlignedCamera { name: capture.cameras[camera].name.clone(), pose, exposure, pose_is_weak }
        };
        let after = problem.pair_medians();
        let pairs = problem.pairs.iter().zip(before.into_iter().zip(after));
        let pairs = pairs.map(|([source, target], (before, after))| AlignedPair {
            source: *source,
            target: *target,
            footprints: [before[0], after[0]],
            brightness: [before[1], after[1]],
        });
        Self { cameras: (0..problem.views.len()).map(of_camera).collect(), pairs: pairs.collect() }
    }

    /// What was corrected, one line a camera.
    #[must_use]
    pub fn sentences(&self) -> Vec<String> {
        self.cameras.iter().filter_map(AlignedCamera::sentence).collect()
    }
}

impl AlignedCamera {
    /// What was corrected; `None` where nothing was.
    #[must_use]
    pub fn sentence(&self) -> Option<String> {
        let mut parts = Vec::new();
        if let Some(pose) = &self.pose {
            parts.push(format!(
                "turned by {:.3} ± {:.3}° and moved by {:.4} ± {:.4}, which is {:.2} footprints",
                pose.degrees, pose.degrees_se, pose.distance, pose.distance_se, pose.footprints
            ));
        }
        if let Some(AlignedExposure { stops: [r, g, b], stops_se, .. }) = &self.exposure {
            let error = stops_se.iter().fold(0.0_f64, |most, error| most.max(*error));
            parts.push(format!("red {r:+.2}, green {g:+.2}, blue {b:+.2} stops, ± {error:.2}"));
        }
        if self.pose_is_weak {
            parts.push("pose left as it is: what the cameras see does not tell it".to_owned());
        }
        (!parts.is_empty()).then(|| format!("{}: {}", self.name, parts.join("; ")))
    }
}

impl Problem {
    /// The median distance (footprints) and difference of brightness of each pair.
    pub(super) fn pair_medians(&self) -> Vec<[f64; 2]> {
        self.finest_weighing()
            .pairs
            .iter()
            .map(|pair| pair.sigmas.map(|sigma| MEDIAN_PER_SIGMA * sigma))
            .collect()
    }
}
