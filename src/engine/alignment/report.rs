//! What alignment found, for people and for JSON.

use std::fmt::Write;

use glam::{DAffine3, DQuat};
use serde::{Deserialize, Serialize};

use super::capture_correction::{CameraCorrection, CameraCorrections};
use super::clock::ClockCorrection;
use super::color_lens::ColorLens;
use super::color_lens_search::LensCorrection;
use super::exposure::{GainCorrection, kept_gain};
use super::poses::{self, PoseCorrection};
use super::registered_frames::color_camera;
use super::solver::Problem;
use crate::capture::conventions::Finding;
use crate::capture::{Camera, Capture, Intrinsics};

/// What was wrong with a capture, and how much better cameras agree without it.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Alignment {
    /// Per camera, in the capture's order.
    pub cameras: Vec<AlignedCamera>,
    /// The color lenses that differ from the claimed lens of color and depth, each of all cameras that claim it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub lenses: Vec<AlignedLens>,
    /// The pairs of cameras that were compared.
    pub pairs: Vec<AlignedPair>,
    /// What was corrected of each camera, with every bit; `None` where no pose and no exposure changed.
    #[serde(alias = "views")]
    pub corrections: Option<CameraCorrections>,
    /// What would make cameras agree better but is not corrected, one sentence each: it is farther off than rigs are.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub refused: Vec<String>,
    /// What was measured of a capture that a program rendered, and is left as it is, one sentence each.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub measured: Vec<String>,
    /// The reading of poses and depth under which views agree far better than as the capture is read. Nothing is corrected then.
    pub misread: Option<Finding>,
}

/// What was corrected of one camera.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct AlignedCamera {
    /// The camera's name.
    pub name: String,
    /// How its pose was changed; `None` where it stays.
    pub pose: Option<AlignedPose>,
    /// How its colors were changed; `None` where they stay.
    pub exposure: Option<AlignedExposure>,
    /// How late its pictures were taken; `None` where no delay shows.
    pub clock: Option<AlignedClock>,
    /// Whether its pose may be wrong, but the pictures do not determine it in some direction.
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
    /// The loss with the change.
    pub loss_after: f64,
    /// Standard error of the difference.
    pub loss_se: f64,
}

/// The color lens of all cameras that claim one lens, and its place beside the depth lens.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct AlignedLens {
    /// The lens that the capture claims for color and depth, which depth has.
    pub claimed: Intrinsics,
    /// The lens of color.
    pub color: Intrinsics,
    /// Standard error of its focal length, pixels.
    pub focal_se: f64,
    /// Standard errors of its principal point, pixels; `None` where it was taken as claimed.
    pub principal_point_se: Option<[f64; 2]>,
    /// From the space of the depth camera into that of the color camera: rigid, in the capture's unit.
    pub color_from_depth: DAffine3,
    /// Angle between both cameras.
    pub degrees: f64,
    /// Its standard error about the worst-known axis; `None` where color was taken to be seen from the depth camera.
    pub degrees_se: Option<f64>,
    /// Distance of both cameras, in the capture's unit.
    pub distance: f64,
    /// Its standard error along the worst-known axis; as `degrees_se`.
    pub distance_se: Option<f64>,
    /// How far colors moved, root mean square, pixels.
    pub moved_px: f64,
    /// Mean loss of pairs with cameras that took no part, as claimed; 0 where cameras agree.
    pub loss_before: f64,
    /// The loss through the color lens.
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

/// How late a camera's pictures were taken.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct AlignedClock {
    /// How many frames later than those of most cameras; negative: earlier.
    pub frames: f64,
    /// Its standard error.
    pub frames_se: f64,
    /// Whole frames by which the pictures were moved; 0 where they stay.
    pub shifted: i64,
    /// See [`AlignedPose::loss_before`]; 0 where nothing was moved.
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

/// Everything that was found, whether or not it is kept. Lists of cameras are empty where nothing was looked for.
pub(super) struct FoundCorrections<'a> {
    pub(super) lenses: &'a [LensCorrection],
    /// One a camera, as the lists below.
    pub(super) poses: &'a [PoseCorrection],
    pub(super) gains: &'a [GainCorrection],
    pub(super) clocks: &'a [ClockCorrection],
}

impl<'a> FoundCorrections<'a> {
    /// Nothing but lenses.
    pub(super) fn of_lenses(lenses: &'a [LensCorrection]) -> Self {
        Self { lenses, poses: &[], gains: &[], clocks: &[] }
    }
}

impl Alignment {
    /// Reports what was found; `before` has the medians of each pair in the capture as it is claimed.
    pub(super) fn new(
        capture: &Capture,
        problem: &Problem,
        found: &FoundCorrections<'_>,
        before: Vec<[f64; 2]>,
    ) -> Self {
        let FoundCorrections { lenses, poses, gains, clocks } = *found;
        let of_camera = |camera: usize| {
            let pose = poses.get(camera).filter(|pose| pose.kept).map(|pose| {
                let now = problem.views[camera].camera.world_from_camera;
                let then = capture.cameras[camera].world_from_camera;
                AlignedPose::new(pose, now, then)
            });
            let exposure = kept_gain(gains, camera).map(|gain| AlignedExposure {
                stops: gain.log_gain.map(|gain| gain / std::f64::consts::LN_2),
                stops_se: gain.standard_error.map(|error| error / std::f64::consts::LN_2),
                loss_before: gain.judgment.before,
                loss_after: gain.judgment.after,
                loss_se: gain.judgment.standard_error,
            });
            let pose_is_weak = poses.get(camera).is_some_and(|pose| pose.is_weak);
            let clock = clocks.get(camera).and_then(AlignedClock::new);
            AlignedCamera { name: capture.cameras[camera].name.clone(), pose, exposure, clock, pose_is_weak }
        };
        let after = problem.pair_medians();
        let pairs = problem.pairs.iter().zip(before.into_iter().zip(after));
        let pairs = pairs.map(|([source, target], (before, after))| AlignedPair {
            source: *source,
            target: *target,
            footprints: [before[0], after[0]],
            brightness: [before[1], after[1]],
        });
        Self {
            cameras: (0..capture.cameras.len()).map(of_camera).collect(),
            lenses: lenses.iter().map(AlignedLens::new).collect(),
            pairs: pairs.collect(),
            corrections: camera_corrections(capture, problem, gains),
            refused: poses::refusals(capture, poses),
            measured: Vec::new(),
            misread: None,
        }
    }

    /// Whether anything is corrected or left as it is for want of evidence, rather than nothing for some reason.
    #[must_use]
    pub fn is_of_cameras(&self) -> bool {
        !self.cameras.is_empty()
    }

    /// What is not corrected, and why, one line each.
    #[must_use]
    pub fn refusals(&self) -> Vec<String> {
        let misread = self.misread.as_ref().and_then(Finding::warning);
        let misread = misread.map(|warning| format!("cameras are left as they are: {warning}"));
        misread.into_iter().chain(self.refused.iter().cloned()).collect()
    }

    /// What was corrected, one line a lens and one a camera.
    #[must_use]
    pub fn sentences(&self) -> Vec<String> {
        let lenses = self.lenses.iter().map(AlignedLens::sentence);
        let cameras = self.cameras.iter().filter_map(AlignedCamera::sentence);
        lenses.chain(cameras).collect()
    }
}

/// The corrections that were kept.
fn camera_corrections(
    capture: &Capture,
    problem: &Problem,
    gains: &[GainCorrection],
) -> Option<CameraCorrections> {
    // A problem that only looked for lenses may hold a part of the cameras; none of them moved.
    if problem.views.len() != capture.cameras.len() {
        return None;
    }
    let of_camera = |(index, then): (usize, &Camera)| {
        let log_gain = kept_gain(gains, index).map_or([0.0; 3], |gain| gain.log_gain);
        let picture = capture.picture_stem(index, 0);
        CameraCorrection::new(picture, then, &problem.views[index].camera, log_gain)
    };
    let cameras = capture.cameras.iter().enumerate().map(of_camera).collect();
    CameraCorrections::new(cameras, 1.0 / problem.scale.inverse_depth)
}

impl AlignedPose {
    fn new(pose: &PoseCorrection, now: DAffine3, then: DAffine3) -> Self {
        let turn = DQuat::from_mat3(&(now.matrix3 * then.matrix3.transpose())).to_scaled_axis();
        Self {
            degrees: turn.length().to_degrees(),
            degrees_se: pose.standard_errors[0].to_degrees(),
            distance: now.translation.distance(then.translation),
            distance_se: pose.standard_errors[1],
            footprints: pose.footprints,
            loss_before: pose.judgment.before,
            loss_after: pose.judgment.after,
            loss_se: pose.judgment.standard_error,
        }
    }
}

impl AlignedClock {
    /// `None` where no delay shows.
    fn new(clock: &ClockCorrection) -> Option<Self> {
        let ClockCorrection { delay, standard_error, shift, judgment } = clock;
        clock.shows().then_some(Self {
            frames: *delay,
            frames_se: *standard_error,
            shifted: *shift,
            loss_before: judgment.before,
            loss_after: judgment.after,
            loss_se: judgment.standard_error,
        })
    }
}

impl AlignedLens {
    pub(super) fn new(correction: &LensCorrection) -> Self {
        let LensCorrection { claimed, found, free, standard_errors, moved_px, judgment } = correction;
        let largest = |range: std::ops::Range<usize>| {
            let is_free = range.clone().all(|unknown| free.contains(&unknown));
            is_free.then(|| standard_errors[range].iter().fold(0.0_f64, |most, error| most.max(*error)))
        };
        let is_centered = free.contains(&7);
        Self {
            claimed: *claimed,
            color: found.intrinsics,
            focal_se: standard_errors[0] * found.intrinsics.fx,
            principal_point_se: is_centered.then_some([standard_errors[7], standard_errors[8]]),
            color_from_depth: found.color_from_depth,
            degrees: DQuat::from_mat3(&found.color_from_depth.matrix3).to_scaled_axis().length().to_degrees(),
            degrees_se: largest(1..4).map(f64::to_degrees),
            distance: found.color_from_depth.translation.length(),
            distance_se: largest(4..7),
            moved_px: *moved_px,
            loss_before: judgment.before,
            loss_after: judgment.after,
            loss_se: judgment.standard_error,
        }
    }

    /// The color camera of a sensor whose depth camera is `depth`: one that claims this lens.
    #[must_use]
    pub fn color_camera(&self, depth: &Camera) -> Camera {
        let lens = ColorLens { intrinsics: self.color, color_from_depth: self.color_from_depth };
        color_camera(depth, &lens)
    }

    /// That no device has this lens, so that it is not corrected.
    pub(super) fn refusal(&self) -> String {
        format!(
            "color lens left as it is: a focal length of {:.0} px where {:.0} px is claimed, {:.3} from the depth lens, is farther off than two sensors of one device are; check how poses and depth are read",
            self.color.fx, self.claimed.fx, self.distance
        )
    }

    /// What was found.
    #[must_use]
    pub fn sentence(&self) -> String {
        let mut text = format!(
            "color lens: focal length {:.2} ± {:.2} px where {:.2} px is claimed for color and depth",
            self.color.fx, self.focal_se, self.claimed.fx
        );
        if let (Some(degrees_se), Some(distance_se)) = (self.degrees_se, self.distance_se) {
            let at = self.color_from_depth.inverse().translation;
            let _ = write!(
                text,
                ", at ({:.4}, {:.4}, {:.4}) ± {distance_se:.4} from the depth lens, turned by {:.3} ± {degrees_se:.3}°",
                at.x, at.y, at.z, self.degrees
            );
        }
        if let Some([x_se, y_se]) = self.principal_point_se {
            let Intrinsics { cx, cy, .. } = self.color;
            let _ = write!(text, ", principal point ({cx:.2} ± {x_se:.2}, {cy:.2} ± {y_se:.2}) px");
        }
        text + &format!("; colors move by {:.2} px", self.moved_px)
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
        if let Some(AlignedClock { frames, frames_se, shifted, .. }) = &self.clock {
            let (size, when) = (frames.abs(), if *frames > 0.0 { "late" } else { "early" });
            let moved =
                if *shifted == 0 { "left as it is".to_owned() } else { format!("moved by {}", -shifted) };
            parts.push(format!("{size:.2} ± {frames_se:.2} frames {when}, {moved}"));
        }
        if self.pose_is_weak {
            parts.push("pose left as it is: what the cameras see does not tell it".to_owned());
        }
        (!parts.is_empty()).then(|| format!("{}: {}", self.name, parts.join("; ")))
    }
}
