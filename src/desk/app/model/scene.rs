//! The open scene: a capture (with frames) or a store (without), and its cameras.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use glam::DVec3;

use overlook_engine::capture::{Camera, Capture, TruthView, pivot};
use overlook_engine::error::{Error, Result};
use overlook_engine::job::Job;
use overlook_engine::median::median_f32;
use overlook_engine::preprocess::diagnostics::{PixelAccount, Report};
use overlook_engine::preprocess::inspect::FrameInspection;
use overlook_engine::samples::{SampleSet, VerdictBuffer};
use overlook_engine::settings::{CaptureSettings, RenderSettings, Settings};
use overlook_engine::store::playback::Playback;

static NEXT_ID: AtomicU64 = AtomicU64::new(1);

/// Where a scene came from.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum SceneSource {
    /// A built-in scene, traced as it is read.
    Demo(String),
    /// The room that comes with the program, pruned already.
    Room,
    Path(PathBuf),
}

/// Where frames or samples come from.
pub(crate) enum Content {
    /// Source frames, to be pruned here.
    Capture {
        capture: Box<Capture>,
        /// Vantages whose truth is known.
        truth: Vec<TruthView>,
    },
    /// Samples that were pruned before; there are no source frames.
    Store {
        /// All but the samples.
        samples: Arc<SampleSet>,
        /// The samples, frame by frame from the file.
        playback: Arc<Playback>,
        /// How they came about.
        report: Arc<Report>,
        /// Size of the file.
        bytes: u64,
    },
}

/// What is open.
pub(crate) struct OpenScene {
    /// Differs between any two scenes that were ever open, so that late answers are recognized.
    pub id: u64,
    pub origin: SceneSource,
    /// Name for titles.
    pub name: String,
    pub content: Content,
    pub cameras: Vec<Camera>,
    /// Number of each frame.
    pub frame_numbers: Vec<i64>,
    /// Up, unit length.
    pub up_in_world: DVec3,
    /// Whether nothing said which way is up, so that it was taken from the cameras.
    pub up_is_estimated: bool,
    /// What the cameras look at.
    pub pivot_in_world: DVec3,
    /// The manifest that defines how a capture is read; `None` if the layout of its folder does.
    pub manifest: Option<PathBuf>,
    /// Whether a capture is open under another reading than that of its files.
    pub is_reread: bool,
}

impl PartialEq for OpenScene {
    fn eq(&self, other: &Self) -> bool {
        self.id == other.id
    }
}

impl OpenScene {
    /// A scene of a capture. `typical_depth` (planar z of camera 0's middle) serves where the lines of sight do not meet.
    pub(crate) fn of_capture(
        origin: SceneSource,
        capture: Capture,
        truth: Vec<TruthView>,
        typical_depth: f64,
    ) -> Self {
        Self {
            id: NEXT_ID.fetch_add(1, Ordering::Relaxed),
            origin,
            name: capture.name.clone(),
            cameras: capture.cameras.clone(),
            frame_numbers: capture.frame_numbers.clone(),
            up_in_world: capture.up_in_world,
            up_is_estimated: false,
            pivot_in_world: pivot(&capture.cameras, typical_depth),
            content: Content::Capture { capture: Box::new(capture), truth },
            manifest: None,
            is_reread: false,
        }
    }

    /// A scene of a store; only its first frame is read.
    ///
    /// # Errors
    /// `Io` and `Cancelled`, and where the store has no frame.
    pub(crate) fn of_store(origin: SceneSource, playback: Playback, job: &Job) -> Result<Self> {
        let pivot_in_world = pivot_of_store(&playback, job)?;
        let samples = playback.outline().clone();
        let info = playback.store().info();
        let (report, bytes) = (Report::from_json(&info.report, &samples.name)?, info.bytes);
        Ok(Self {
            id: NEXT_ID.fetch_add(1, Ordering::Relaxed),
            origin,
            name: samples.name.clone(),
            cameras: samples.cameras.clone(),
            frame_numbers: samples.frame_numbers.clone(),
            up_in_world: samples.up_in_world,
            up_is_estimated: false,
            pivot_in_world,
            content: Content::Store {
                samples,
                playback: Arc::new(playback),
                report: Arc::new(report),
                bytes,
            },
            manifest: None,
            is_reread: false,
        })
    }

    /// The capture, or `None` where a store is open.
    pub(crate) fn capture(&self) -> Option<&Capture> {
        match &self.content {
            Content::Capture { capture, .. } => Some(capture),
            Content::Store { .. } => None,
        }
    }

    /// The capture; `Invalid` where a store is open.
    pub(crate) fn source(&self) -> Result<&Capture> {
        self.capture().ok_or_else(|| Error::invalid(&self.name, "a store holds no source frames"))
    }

    /// What reads samples from the file, where a store is open.
    pub(crate) fn playback(&self) -> Option<&Arc<Playback>> {
        match &self.content {
            Content::Capture { .. } => None,
            Content::Store { playback, .. } => Some(playback),
        }
    }

    /// Frames per camera.
    pub(crate) fn frame_count(&self) -> usize {
        self.frame_numbers.len()
    }
}

/// The point that the cameras of a store look at, in world space: where their lines of sight come nearest to each other, or as far as the
/// first samples lie. Only the first frame is read.
///
/// # Errors
/// `Io` and `Cancelled`, and where the store has no frame.
pub(crate) fn pivot_of_store(playback: &Playback, job: &Job) -> Result<DVec3> {
    let first = playback.at(0, job)?;
    let first = first.images.iter().find(|image| !image.is_empty());
    let typical_depth = first.map_or(1.0, |image| median_depth(&image.inverse_depths()));
    Ok(pivot(&playback.outline().cameras, typical_depth))
}

/// Median planar depth of samples with depth; 1 without any.
pub(crate) fn median_depth(inverse_depth: &[f32]) -> f64 {
    let mut finite: Vec<f32> = inverse_depth.iter().copied().filter(|w| *w > 0.0).collect();
    median_f32(&mut finite).map_or(1.0, |inverse_depth| 1.0 / f64::from(inverse_depth))
}

/// The whole capture, pruned.
pub(crate) struct Whole {
    pub samples: Arc<SampleSet>,
    pub report: Arc<Report>,
    /// What becomes of every pixel, for a store.
    pub verdicts: Option<Arc<VerdictBuffer>>,
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_depth_is_found_among_sky_and_nothing() {
        assert_eq!(median_depth(&[0.0, -1.0, 0.5, 0.5, 0.25]), 2.0);
        assert_eq!(median_depth(&[0.0, -1.0]), 1.0);
    }
}
