//! What pruning and measuring gave.

use std::sync::Arc;
use std::time::Instant;

use overlook_engine::preprocess::diagnostics::{PixelAccount, Report};
use overlook_engine::preprocess::inspect::FrameInspection;
use overlook_engine::samples::SampleSet;
use overlook_engine::settings::{CaptureSettings, RenderSettings, Settings};

/// The whole capture, pruned.
pub(crate) struct Whole {
    pub samples: Arc<SampleSet>,
    pub report: Arc<Report>,
    pub settings: Settings,
}

/// One frame, pruned, with reasons.
pub(crate) struct Inspected {
    pub inspection: Arc<FrameInspection>,
    pub settings: Settings,
    /// Whether it was known what is the same over all frames.
    pub with_scan: bool,
    /// Pixels of each camera that represent themselves.
    pub kept: Vec<u64>,
    /// What became of all pixels of the frame.
    pub account: PixelAccount,
    /// When it was done.
    pub at: Instant,
}

/// How accurate the kept samples are where the truth is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Accuracy {
    /// Mean PSNR of the kept samples, dB.
    pub psnr_db: f64,
    /// Mean PSNR of all samples, nothing pruned, dB.
    pub unpruned_psnr_db: f64,
    pub views: usize,
}

/// Memory of one camera's samples.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct CameraMemory {
    pub samples: u64,
    /// Bytes of samples that are stored for several frames.
    pub lasting_bytes: u64,
    /// Bytes of samples that are stored for one frame.
    pub frame_bytes: u64,
}

/// Settings that are equal where they decide on the same samples.
#[derive(Clone)]
pub(crate) struct Method(pub Settings);

impl PartialEq for Method {
    fn eq(&self, other: &Self) -> bool {
        method_of(&self.0) == method_of(&other.0)
    }
}

/// The settings that decide which samples stay: those of painting and caching set to their defaults.
pub(crate) fn method_of(settings: &Settings) -> Settings {
    Settings { capture: CaptureSettings::default(), render: RenderSettings::default(), ..settings.clone() }
}
