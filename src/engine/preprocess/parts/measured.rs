//! What is measured once, and used by all parts.

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::runs::run_of_part;
use crate::alignment::{self, Aligned, Alignment, CaptureCorrection};
use crate::capture::conventions::Finding;
use crate::capture::{Capture, with_changed_frames};
use crate::edits::{self, EditList};
use crate::error::Result;
use crate::job::Job;
use crate::part::Part;
use crate::preprocess::temporal::{self, CameraPreview};
use crate::preprocess::{better_conventions, edited_cache_bytes};
use crate::settings::Settings;

/// What the rig got wrong, and the noise of each camera: as JSON it keeps every bit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Measured {
    correction: CaptureCorrection,
    alignment: Option<Alignment>,
    /// How poses and depth would fit far better between cameras than as the capture says, where they would.
    #[serde(default)]
    pub(super) conventions: Option<Finding>,
    pub(super) cameras: Vec<CameraPreview>,
    /// Cameras and frames that were read.
    frames_read: BTreeSet<(usize, usize)>,
}

/// A capture with what was measured of it, and the settings that all parts are made with.
#[derive(Clone, Copy, Debug)]
pub struct MeasuredCapture<'a> {
    /// The capture as it was recorded, without the cameras that edits leave out ([`edits::with_cameras_left`]).
    pub capture: &'a Capture,
    /// What was measured of this capture.
    pub measured: &'a Measured,
    /// The settings that it was measured with.
    pub settings: &'a Settings,
    /// The edits that it was measured with.
    pub edits: &'a EditList,
}

impl MeasuredCapture<'_> {
    /// The capture without what the rig got wrong.
    #[must_use]
    pub fn aligned(&self) -> Aligned {
        Aligned {
            capture: self.measured.correction.applied(self.capture),
            alignment: self.measured.alignment.clone(),
            correction: self.measured.correction.clone(),
        }
    }

    /// The same without the pixels that edits remove.
    pub(super) fn edited(&self) -> Aligned {
        let aligned = self.aligned();
        let capture =
            edits::without_removed_pixels(&aligned.capture, self.edits, edited_cache_bytes(self.settings));
        Aligned { capture, ..aligned }
    }

    /// For each camera the pixels with depth that edits remove from the frames of a part.
    ///
    /// # Errors
    /// Whatever the capture gives (naming file and frame), and `Cancelled`.
    pub fn removed_pixels(&self, part: Part, job: &Job) -> Result<Vec<u64>> {
        let run = run_of_part(self.capture.frame_count(), part);
        let frames = run.start as usize..run.end as usize;
        edits::count_removed_pixels(&self.aligned().capture, self.edits, frames, job)
    }
}

impl Measured {
    /// Measures a capture without the cameras that edits leave out: reads a few of its frames.
    ///
    /// # Errors
    /// Whatever the capture gives (naming file and frame), `Invalid` for settings out of range, and `Cancelled`.
    pub fn of(capture: &Capture, settings: &Settings, edits: &EditList, job: &Job) -> Result<Self> {
        settings.validate("settings")?;
        let frames_read = Arc::new(Mutex::new(BTreeSet::new()));
        let noted = noting_frames_read(capture, frames_read.clone());
        let conventions = better_conventions(&noted)?;
        let Aligned { capture, alignment, correction } = alignment::align(&noted, &settings.align, job)?;
        let capture = edits::without_removed_pixels(&capture, edits, edited_cache_bytes(settings));
        job.start("Measuring noise", capture.cameras.len());
        let preview = |camera| {
            let preview = temporal::preview(&capture, camera, settings, job);
            job.advance(1);
            preview
        };
        let cameras = (0..capture.cameras.len()).into_par_iter().map(preview).collect::<Result<_>>()?;
        let frames_read = frames_read.lock().unwrap_or_else(PoisonError::into_inner).clone();
        Ok(Self { correction, alignment, conventions, cameras, frames_read })
    }

    /// The files that it was measured on.
    #[must_use]
    pub fn files_read(&self, capture: &Capture) -> Vec<PathBuf> {
        let is_there = |(camera, frame): &&(usize, usize)| {
            *camera < capture.cameras.len() && *frame < capture.frame_count()
        };
        let frames = self.frames_read.iter().filter(is_there);
        frames.flat_map(|&(camera, frame)| capture.files_of(camera, frame)).collect()
    }
}

/// Frames that are kept while a capture is measured, bytes.
const CACHE_BYTES: usize = 256 << 20;

/// The same capture, which notes camera and index of each frame that is read.
fn noting_frames_read(capture: &Capture, read: Arc<Mutex<BTreeSet<(usize, usize)>>>) -> Capture {
    with_changed_frames(capture, CACHE_BYTES, move |camera, frame, recorded| {
        read.lock().unwrap_or_else(PoisonError::into_inner).insert((camera, frame));
        recorded.clone()
    })
}
