//! A recording before it is pruned: what its views saw, read as it is needed.

use std::sync::Arc;
use std::sync::atomic::AtomicU8;

use rayon::prelude::*;

use crate::capture::Capture;
use crate::error::Result;
use crate::job::Job;
use crate::preprocess::pruning::{ABSENT, Statuses};
use crate::preprocess::registration::Sight;
use crate::preprocess::temporal::{SpanSamples, TemporalScan, all_frames};
use crate::settings::Settings;

/// A recording, and what is known of it.
#[derive(Clone, Copy)]
pub(crate) struct Views<'a> {
    pub(crate) capture: &'a Capture,
    pub(crate) scan: &'a TemporalScan,
    pub(crate) settings: &'a Settings,
    /// Bytes that layers may take, unless those of a single view and all that may see it take more.
    pub(crate) bound: usize,
}

/// The share of the memory setting that layers take, and what is held of all views beside them.
const SHARE: usize = 2;
/// Bytes held for four pixels of every view: whether each sample is kept, and whether it is mixed.
const OF_FOUR_PIXELS: usize = 5;

impl<'a> Views<'a> {
    /// With layers in a share of the memory setting.
    pub(crate) fn new(capture: &'a Capture, scan: &'a TemporalScan, settings: &'a Settings) -> Self {
        let pixels: usize = capture.cameras.iter().map(|camera| camera.intrinsics.pixel_count()).sum();
        let share = ((settings.capture.cache as usize) << 20) / SHARE;
        Self { capture, scan, settings, bound: share.saturating_sub(OF_FOUR_PIXELS * pixels / 4) }
    }

    /// What each view saw, as a few boxes.
    pub(super) fn sights(&self, job: &Job) -> Result<Vec<Sight>> {
        let of_camera = |camera: usize| {
            job.check()?;
            let samples = self.samples(camera)?;
            let depths = samples.pixels.iter().copied().zip(samples.inverse_depth.iter().copied());
            Ok(Sight::new(self.capture.cameras[camera].intrinsics.size(), depths))
        };
        (0..self.capture.cameras.len()).into_par_iter().map(of_camera).collect()
    }

    fn samples(&self, camera: usize) -> Result<Arc<SpanSamples>> {
        let spans = self.scan.spans.as_ref();
        let samples = spans.map(|spans| spans.get(camera, all_frames(self.scan.frames))).transpose()?;
        Ok(samples.flatten().unwrap_or_default())
    }

    /// Nothing is decided yet.
    pub(super) fn no_statuses(&self) -> Statuses {
        let counts = self.capture.cameras.iter().map(|camera| camera.intrinsics.pixel_count());
        counts.map(|count| (0..count).map(|_| AtomicU8::new(ABSENT)).collect()).collect()
    }
}
