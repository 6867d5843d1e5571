//! A capture as it would have been recorded without what was found wrong.

use std::path::PathBuf;
use std::sync::Arc;

use glam::{DMat3, Mat3, Vec3};
use half::f16;

use crate::capture::conventions::{DepthClaim, PoseConvention};
use crate::capture::{Camera, Capture, CaptureParts, Frame, FrameSource};
use crate::error::Result;

/// What is changed about the frames of one camera.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct FrameCorrection {
    /// What colors are multiplied with, per channel.
    pub(crate) gain: [f32; 3],
    /// How normals turn with the camera.
    pub(crate) normal_turn: DMat3,
}

impl FrameCorrection {
    /// Nothing.
    pub(crate) const NONE: Self = Self { gain: [1.0; 3], normal_turn: DMat3::IDENTITY };
}

/// Frames of a capture, corrected as they are asked for.
struct CorrectedFrames {
    original: Capture,
    corrections: Vec<FrameCorrection>,
}

impl FrameSource for CorrectedFrames {
    fn load(&self, camera: usize, frame: usize) -> Result<Frame> {
        let frame = self.original.frame(camera, frame)?;
        let mut frame = Frame::clone(&frame);
        let correction = &self.corrections[camera];
        if correction.gain != [1.0; 3] {
            for color in frame.color.as_mut_slice() {
                *color = std::array::from_fn(|channel| {
                    let brighter = f32::from(color[channel]) * correction.gain[channel];
                    f16::from_f32(brighter.min(f16::MAX.to_f32()))
                });
            }
        }
        if correction.normal_turn != DMat3::IDENTITY
            && let Some(normals) = &mut frame.normal_in_world
        {
            let turn: Mat3 = correction.normal_turn.as_mat3();
            for normal in normals.as_mut_slice() {
                *normal = (turn * Vec3::from_array(*normal)).to_array();
            }
        }
        Ok(frame)
    }

    fn place(&self, camera: usize, frame: usize) -> String {
        self.original.place(camera, frame)
    }

    fn frames_are_ranked(&self) -> bool {
        self.original.frames_are_ranked()
    }

    fn depth_claim(&self) -> DepthClaim {
        self.original.source.depth_claim()
    }

    fn pose_convention(&self) -> PoseConvention {
        self.original.source.pose_convention()
    }

    fn files(&self, camera: usize, frame: usize) -> Vec<PathBuf> {
        self.original.files_of(camera, frame)
    }
}

/// Decoded frames are kept by the capture below; those that were corrected are made again.
const CACHE_BYTES: usize = 64 << 20;

/// The capture with these cameras in place of its own, and frames corrected.
pub(crate) fn corrected(
    capture: &Capture,
    cameras: Vec<Camera>,
    corrections: Vec<FrameCorrection>,
) -> Capture {
    if corrections.iter().all(|correction| *correction == FrameCorrection::NONE) {
        let mut moved = capture.clone();
        moved.cameras = cameras;
        return moved;
    }
    let source = Arc::new(CorrectedFrames { original: capture.clone(), corrections });
    let original: &CaptureParts = capture;
    Capture::new(CaptureParts { cameras, source, ..original.clone() }, CACHE_BYTES)
}
