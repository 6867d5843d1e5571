//! What is pruned, and how much memory that may take.

use rayon::prelude::*;

use crate::capture::Capture;
use crate::capture::overlap::DepthBounds;
use crate::error::Result;
use crate::job::Job;
use crate::preprocess::pruning::{Statuses, no_statuses};
use crate::preprocess::temporal::{TemporalScan, all_frames};
use crate::settings::Settings;

/// A capture, and what is known of it.
#[derive(Clone, Copy)]
pub(super) struct Recording<'a> {
    pub(super) capture: &'a Capture,
    pub(super) scan: &'a TemporalScan,
    pub(super) settings: &'a Settings,
    /// Bytes that layers and the samples that are worked on may take, unless those of a single camera take more.
    pub(super) bound: usize,
}

/// The share of the memory setting that layers take, and what is held of all cameras beside them: numerator and denominator.
const SHARE: (usize, usize) = (3, 4);

impl<'a> Recording<'a> {
    /// With layers in a share of the memory setting.
    pub(super) fn new(capture: &'a Capture, scan: &'a TemporalScan, settings: &'a Settings) -> Self {
        // Whether each sample is kept is held of all cameras.
        let statuses: usize = capture.cameras.iter().map(|camera| camera.intrinsics.pixel_count()).sum();
        let share = ((settings.capture.memory as usize) << 20) / SHARE.1 * SHARE.0;
        Self { capture, scan, settings, bound: share.saturating_sub(statuses) }
    }

    /// Whether there are samples of all frames only.
    pub(super) fn is_of_one_moment(&self) -> bool {
        self.scan.frames == 1 && self.scan.spans.is_some()
    }

    /// What each camera saw throughout, as a few boxes.
    pub(super) fn depth_bounds(&self, job: &Job) -> Result<Vec<DepthBounds>> {
        let of_camera = |camera: usize| {
            job.check()?;
            let spans = self.scan.spans.as_ref();
            let samples = spans.map(|spans| spans.get(camera, all_frames(self.scan.frames))).transpose()?;
            let samples = samples.flatten().unwrap_or_default();
            let depths = samples.pixels.iter().copied().zip(samples.inverse_depth.iter().copied());
            Ok(DepthBounds::new(self.capture.cameras[camera].intrinsics.size(), depths))
        };
        (0..self.capture.cameras.len()).into_par_iter().map(of_camera).collect()
    }

    /// Nothing is decided yet.
    pub(super) fn no_statuses(&self) -> Statuses {
        no_statuses(self.capture.cameras.iter().map(|camera| camera.intrinsics.pixel_count()))
    }
}
