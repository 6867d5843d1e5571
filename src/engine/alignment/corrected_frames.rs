//! A capture as it would have been recorded without what was found wrong.

use glam::{DMat3, Mat3, Vec3};
use half::f16;

use crate::capture::{Camera, Capture, Frame, with_changed_frames};

/// What is changed about the frames of one camera.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
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
