//! All that is changed about a capture: measured once, and applied wherever the capture is read.

use serde::{Deserialize, Serialize};

use super::color_lens::ColorLens;
use super::color_lens_search::LensCorrection;
use super::corrected_frames::{FrameCorrection, corrected};
use super::registered_frames::with_color_lenses;
use super::shifted_frames::shifted;
use crate::capture::{Camera, Capture, Intrinsics};

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
