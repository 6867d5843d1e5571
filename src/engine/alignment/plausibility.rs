//! What is farther off than rigs are is evidence of something else, and is said rather than corrected.

use glam::{DAffine3, DQuat};

use super::color_lens::UNKNOWNS;
use super::color_lens_search::LensCorrection;
use super::poses::PoseCorrection;
use crate::capture::{Camera, Capture};

/// The poses of rigs are off by no more: radians, and typical depths. What is farther off is misread.
const MOST_TURN: f64 = 0.15;
const MOST_SHIFT: f64 = 0.15;

/// Two sensors of one device differ by less: the unknowns, in their order. What differs by more is evidence of something else.
const MOST: [f64; UNKNOWNS] = [0.18, 0.15, 0.15, 0.15, 0.12, 0.12, 0.12, 0.1, 0.1];
/// Whether the pose of a rig may be off by this change; `inverse_depth` is of a typical depth.
pub(super) fn is_of_a_rig(change: &DAffine3, inverse_depth: f64) -> bool {
    let turn = DQuat::from_mat3(&change.matrix3).to_scaled_axis().length();
    turn < MOST_TURN && change.translation.length() * inverse_depth < MOST_SHIFT
}

impl LensCorrection {
    /// Whether two sensors of one device may be like that; `distance` is a typical depth.
    pub(super) fn is_plausible(&self, distance: f64) -> bool {
        let unknowns = self.found.unknowns(&self.claimed, distance);
        unknowns.iter().zip(MOST).all(|(value, most)| value.abs() < most)
    }

    pub(super) fn refusal(&self) -> String {
        let [found, claimed] = [self.found.intrinsics.fx, self.claimed.fx];
        let at = self.found.color_from_depth.translation.length();
        format!(
            "color lens left as it is: a focal length of {found:.0} px where {claimed:.0} px is claimed, {at:.3} from the depth lens, is farther off than two sensors of one device are; check how poses and depth are read"
        )
    }
}

/// The poses that were found but are farther off than those of rigs.
pub(super) fn refusals(capture: &Capture, poses: &[PoseCorrection]) -> Vec<String> {
    let refused = capture.cameras.iter().zip(poses).filter(|(_, pose)| pose.is_implausible);
    let sentence = |(camera, pose): (&Camera, &PoseCorrection)| {
        format!(
            "{}: pose left as it is: it would be {:.0} footprints off, more than rigs are; check how poses and depth are read",
            camera.name, pose.footprints
        )
    };
    refused.map(sentence).collect()
}
