//! A capture whose frames are changed as they are asked for, and that tells all else as the original does.

use std::path::PathBuf;
use std::sync::Arc;

use crate::capture::conventions::{DepthClaim, PoseConvention};
use crate::capture::{Camera, Capture, CaptureParts, Frame, FrameSource};
use crate::error::Result;

/// Frames of a capture, each made by `change`, which is given the capture, the camera and the index of the frame.
struct DerivedFrames<F> {
    original: Capture,
    change: F,
}

impl<F: Fn(&Capture, usize, usize) -> Result<Frame> + Send + Sync> FrameSource for DerivedFrames<F> {
    fn load(&self, camera: usize, frame: usize) -> Result<Frame> {
        (self.change)(&self.original, camera, frame)
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

/// The capture with these cameras in place of its own, and its frames changed. Of the changed frames `cache_bytes` are kept; the
/// decoded ones are kept by the capture below.
pub(super) fn derived(
    capture: &Capture,
    cameras: Vec<Camera>,
    cache_bytes: usize,
    change: impl Fn(usize, &Frame) -> Frame + Send + Sync + 'static,
) -> Capture {
    derived_over_time(capture, cameras, cache_bytes, move |original, camera, frame| {
        Ok(change(camera, &*original.frame(camera, frame)?))
    })
}

/// As [`derived`], with frames made of any frames of the capture.
pub(super) fn derived_over_time(
    capture: &Capture,
    cameras: Vec<Camera>,
    cache_bytes: usize,
    change: impl Fn(&Capture, usize, usize) -> Result<Frame> + Send + Sync + 'static,
) -> Capture {
    let source = Arc::new(DerivedFrames { original: capture.clone(), change });
    let original: &CaptureParts = capture;
    Capture::new(CaptureParts { cameras, source, ..original.clone() }, cache_bytes)
}
