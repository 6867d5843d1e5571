//! Preprocessing (the paper, §3.2): removes what is said twice, over time and between cameras.

pub mod inspection;
pub mod report;
pub mod samples;
pub mod temporal;

use std::sync::Arc;

use crate::capture::Capture;
use crate::error::Result;
use crate::job::Job;
use crate::settings::Settings;

pub use inspection::{CameraInspection, FrameInspection, PixelClass, Rule, Verdict};
pub use report::Report;
pub use samples::{OctNormal, Sample, SampleImage, SampleSet, SampleTile, Span, TILE};
pub use temporal::TemporalScan;

/// What preprocessing gives: the kept samples, and the account of what was dropped and why.
#[derive(Clone, Debug)]
pub struct Preprocessed {
    /// The kept samples.
    pub samples: Arc<SampleSet>,
    /// The account.
    pub report: Report,
}

/// The whole method: scan over time, split into spans, prune between cameras.
///
/// # Errors
/// Whatever the capture gives (naming file and frame), and `Cancelled`.
pub fn preprocess(capture: &Capture, settings: &Settings, job: &Job) -> Result<Preprocessed> {
    let scan = scan(capture, settings, job)?;
    prune(capture, &scan, settings, job)
}

/// The pass over all frames that depends on no threshold: ranges, means and noise of every pixel over time.
///
/// # Errors
/// As [`preprocess`].
pub fn scan(capture: &Capture, settings: &Settings, job: &Job) -> Result<Arc<TemporalScan>> {
    let _ = (capture, settings, job);
    todo!()
}

/// Everything after [`scan`]: cheap enough to be repeated whenever a threshold changes.
///
/// # Errors
/// As [`preprocess`].
pub fn prune(capture: &Capture, scan: &TemporalScan, settings: &Settings, job: &Job) -> Result<Preprocessed> {
    let _ = (capture, scan, settings, job);
    todo!()
}

/// All verdicts of one frame, for the eye: what [`prune`] decides there, with reasons and witnesses.
///
/// Without a `scan` (still under way) every pixel counts as foreground.
///
/// # Errors
/// As [`preprocess`].
pub fn inspect_frame(
    capture: &Capture,
    scan: Option<&TemporalScan>,
    settings: &Settings,
    frame: usize,
    job: &Job,
) -> Result<FrameInspection> {
    let _ = (capture, scan, settings, frame, job);
    todo!()
}
