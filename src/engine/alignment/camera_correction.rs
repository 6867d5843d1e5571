//! The correction of each camera, with every bit. It also corrects a picture that was taken beside the cameras.

use glam::{DAffine3, DQuat, DVec3};
use serde::{Deserialize, Serialize};

use crate::capture::Camera;

/// What was corrected of all cameras.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct CameraCorrections {
    /// Per camera, in the capture's order.
    pub cameras: Vec<CameraCorrection>,
    /// How far away surfaces typically are, in the capture's unit: an angle times this is a distance.
    pub typical_depth: f64,
}

/// What was corrected of one camera; zeros where nothing was.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct CameraCorrection {
    /// Name of its picture's file without folder and extension; `None` where it has no file.
    pub picture: Option<String>,
    /// Its pose before the correction, through the color lens where one was found.
    pub world_from_camera: DAffine3,
    /// Rotation about its center: a rotation vector in world space, radians.
    pub turn: DVec3,
    /// Shift of its center in world space, in the capture's unit.
    pub shift: DVec3,
    /// Natural logarithms of what its red, green and blue were multiplied with.
    pub log_gain: [f64; 3],
}

impl CameraCorrections {
    /// The corrections of `cameras`; `None` where no pose and no exposure changed.
    pub(super) fn new(cameras: Vec<CameraCorrection>, typical_depth: f64) -> Option<Self> {
        cameras.iter().any(CameraCorrection::is_any).then_some(Self { cameras, typical_depth })
    }
}

impl CameraCorrection {
    pub(super) fn new(picture: Option<String>, then: &Camera, now: &Camera, log_gain: [f64; 3]) -> Self {
        let [before, after] = [then, now].map(|camera| camera.world_from_camera);
        let is_moved = before != after;
        let turn = DQuat::from_mat3(&(after.matrix3 * before.matrix3.transpose())).to_scaled_axis();
        Self {
            picture,
            world_from_camera: before,
            turn: if is_moved { turn } else { DVec3::ZERO },
            shift: if is_moved { after.translation - before.translation } else { DVec3::ZERO },
            log_gain,
        }
    }

    fn is_any(&self) -> bool {
        self.turn != DVec3::ZERO || self.shift != DVec3::ZERO || self.log_gain != [0.0; 3]
    }
}

#[cfg(test)]
mod tests {
    use super::super::Alignment;
    use super::*;

    #[test]
    fn corrections_keep_every_bit_as_json_and_those_of_a_store_that_calls_them_views_are_read() {
        let lens = crate::capture::Intrinsics::from_horizontal_angle(8, 6, 1.0);
        let then = Camera::look_at("c", lens, DVec3::new(0.1, 0.7, 0.3), DVec3::X, DVec3::Z);
        let mut now = then.clone();
        now.world_from_camera *= DAffine3::from_rotation_z(0.1);
        let moved = CameraCorrection::new(Some("frame-1".to_owned()), &then, &now, [0.1, 0.2, 0.3]);
        let stays = CameraCorrection::new(None, &then, &then, [0.0; 3]);
        assert_eq!(CameraCorrections::new(vec![stays.clone()], 2.0), None);
        let corrections = CameraCorrections::new(vec![moved, stays], 2.0 / 3.0);
        let alignment = Alignment { corrections, ..Alignment::default() };
        let json = serde_json::to_string(&alignment).unwrap();
        let older = json.replace("\"corrections\":{", "\"views\":{\"poses\":{},\"exposures\":{},");
        assert_ne!(older, json);
        for json in [json, older] {
            assert_eq!(serde_json::from_str::<Alignment>(&json).unwrap(), alignment);
        }
    }
}
