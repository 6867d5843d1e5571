//! All that is changed about a capture: measured once, and applied wherever the capture is read.
//!
//! A capture whose cameras' frames are moved in time by whole frames.
//!
//! A camera that is moved lacks frames at one end. Still pixels are taken there from the nearest frame that it has; moving ones
//! get no sample, as nobody knows where they were.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DQuat, DVec3, Mat3, Vec3};
use half::f16;
use serde::{Deserialize, Serialize};

use super::color_lens::ColorLens;
use super::color_lens_search::LensCorrection;
use super::reference_view::still_pixels;
use super::registered_frames::with_color_lenses;
use crate::capture::{
    Camera, Capture, Frame, INVALID_INVERSE_DEPTH, Intrinsics, with_changed_frames, with_frames_made_of,
};

/// What [`align`](super::align) changes about a capture; by default nothing. As JSON it keeps every bit.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CaptureCorrection {
    /// Lenses that are claimed for color and depth, and the color lenses that were found in their place.
    pub(super) lenses: Vec<(Intrinsics, ColorLens)>,
    /// The cameras, once they have these lenses; empty where they stay.
    pub(super) cameras: Vec<Camera>,
    /// Per camera, what its frames become; empty where they stay.
    pub(super) frames: Vec<FrameCorrection>,
    /// Per camera, by how many frames its pictures were taken too late; empty where they stay.
    #[serde(default)]
    pub(super) late_frames: Vec<i64>,
}

impl CaptureCorrection {
    /// That cameras have these color lenses; nothing else.
    pub(super) fn of_lenses(lenses: &[LensCorrection]) -> Self {
        Self { lenses: lenses.iter().map(|lens| (lens.claimed, lens.found)).collect(), ..Self::default() }
    }

    /// Whether a color lens is corrected.
    pub(crate) fn is_of_a_lens(&self) -> bool {
        !self.lenses.is_empty()
    }

    /// The capture without what was wrong. It must be the one that was measured.
    #[must_use]
    pub fn applied(&self, capture: &Capture) -> Capture {
        self.applied_to_seen(&self.seen_through_lenses(capture))
    }

    /// The same for a capture that is seen through the lenses already.
    pub(super) fn applied_to_seen(&self, seen: &Capture) -> Capture {
        let moved = if self.cameras.is_empty() {
            seen.clone()
        } else {
            corrected(seen, &self.cameras, self.frames.clone())
        };
        if self.late_frames.is_empty() { moved } else { shifted(&moved, self.late_frames.clone()) }
    }

    /// The capture as seen through the color lenses that were found; itself where none was.
    pub(super) fn seen_through_lenses(&self, capture: &Capture) -> Capture {
        if self.lenses.is_empty() {
            return capture.clone();
        }
        let of_camera = |camera: &Camera| {
            let found = self.lenses.iter().find(|(claimed, _)| *claimed == camera.intrinsics);
            found.map(|(_, lens)| *lens)
        };
        with_color_lenses(capture, capture.cameras.iter().map(of_camera).collect())
    }
}

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

/// What is changed about the frames of one camera.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct FrameCorrection {
    /// What colors are multiplied with, per channel.
    pub(crate) gain: [f32; 3],
    /// How normals turn with the camera.
    pub(crate) normal_turn: DMat3,
}

impl FrameCorrection {
    /// Nothing.
    pub(crate) const NONE: Self = Self { gain: [1.0; 3], normal_turn: DMat3::IDENTITY };

    /// A frame as it would have been recorded.
    fn applied(&self, frame: &Frame) -> Frame {
        let mut frame = frame.clone();
        if self.gain != [1.0; 3] {
            for color in frame.color.as_mut_slice() {
                *color = std::array::from_fn(|channel| {
                    let brighter = f32::from(color[channel]) * self.gain[channel];
                    f16::from_f32(brighter.min(f16::MAX.to_f32()))
                });
            }
        }
        if self.normal_turn != DMat3::IDENTITY
            && let Some(normals) = &mut frame.normal_in_world
        {
            let turn: Mat3 = self.normal_turn.as_mat3();
            for normal in normals.as_mut_slice() {
                *normal = (turn * Vec3::from_array(*normal)).to_array();
            }
        }
        frame
    }
}

/// Corrected frames that are kept, bytes: few, since they are soon made again.
const CACHE_BYTES: usize = 64 << 20;

/// The capture with these cameras in place of its own, and frames corrected.
pub(crate) fn corrected(capture: &Capture, cameras: &[Camera], corrections: Vec<FrameCorrection>) -> Capture {
    let corrected = if corrections.iter().all(|correction| *correction == FrameCorrection::NONE) {
        capture.clone()
    } else {
        with_changed_frames(capture, CACHE_BYTES, move |camera, _, frame| corrections[camera].applied(frame))
    };
    corrected.with_changed_cameras(|index, camera| {
        if let Some(found) = cameras.get(index) {
            camera.clone_from(found);
        }
    })
}

/// The capture with each camera's frames moved `late` frames later in time, per camera.
pub(crate) fn shifted(capture: &Capture, late: Vec<i64>) -> Capture {
    if late.iter().all(|late| *late == 0) {
        return capture.clone();
    }
    let last = capture.frame_count() as i64 - 1;
    // The wanted frame. Where the camera lacks it: the nearest one, and one as far inside, which shows what moves there.
    let read = move |camera: usize, frame: usize| {
        let wanted = frame as i64 - late[camera];
        let nearest = wanted.clamp(0, last);
        let inner = (2 * nearest - wanted).clamp(0, last);
        if nearest == wanted { vec![nearest as usize] } else { vec![nearest as usize, inner as usize] }
    };
    with_frames_made_of(capture, CACHE_BYTES, read, |_, _, read: &[Arc<Frame>]| match read {
        [nearest, inner] => still_part(nearest, inner),
        _ => Frame::clone(&read[0]),
    })
}

/// A frame without what is elsewhere in another one.
fn still_part(frame: &Frame, other: &Frame) -> Frame {
    let mut still = frame.clone();
    let is_still = still_pixels(frame, other);
    for (depth, is_still) in still.inverse_depth.as_mut_slice().iter_mut().zip(is_still.as_slice()) {
        if !is_still {
            *depth = INVALID_INVERSE_DEPTH;
        }
    }
    still
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::alignment::Alignment;

    #[test]
    fn corrections_keep_every_bit_as_json_and_those_of_a_store_that_calls_them_views_are_read() {
        let lens = Intrinsics::from_horizontal_angle(8, 6, 1.0);
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
