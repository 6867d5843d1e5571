//! What is known of the last change of settings.

use std::time::{Duration, Instant};

use egui::TextureHandle;

use crate::app::model::picture::LivePicture;
use crate::app::model::same::Same;
use overlook_engine::capture::Camera;
use overlook_engine::preprocess::inspect::FrameInspection;
use overlook_engine::samples::SampleSet;
use overlook_engine::settings::Settings;

/// How long samples that went or came glow.
const GLOWS: Duration = Duration::from_millis(900);

/// What the last change of settings did.
#[derive(Default)]
pub(crate) struct SettingsChange {
    /// What was known before it.
    pub before: Option<Figures>,
    /// Two prunings of one frame whose difference is not painted yet, the earlier one first.
    pub unpainted: Option<[Same<FrameInspection>; 2]>,
    /// The samples that went or came, while they glow.
    pub glows: Vec<Glow>,
}

/// Samples of one pruning that the one before lacks, or the other way round, as the live view shows them.
pub(crate) struct Glow {
    /// Each sample in the color of its camera.
    pub texture: TextureHandle,
    /// Where the picture is seen from.
    pub camera: Camera,
    /// Whether the samples came; else they went.
    pub came: bool,
    pub since: Instant,
}

impl Glow {
    /// The share of its time that is over.
    pub(crate) fn age(&self) -> f32 {
        self.since.elapsed().as_secs_f32() / GLOWS.as_secs_f32()
    }

    /// How strongly it is drawn, 0 to 1: what went fades, what came grows until it is there.
    pub(crate) fn strength(&self) -> f32 {
        let left = (1.0 - self.age()).clamp(0.0, 1.0);
        if self.came { 1.0 - left } else { left * left }
    }
}

/// What is known under some settings.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Figures {
    pub settings: Settings,
    /// A frame, and the samples that are kept of it.
    pub frame: Option<(usize, u64)>,
    /// These samples.
    pub frame_samples: Option<Same<SampleSet>>,
    /// Samples that are kept of all frames.
    pub samples: Option<u64>,
    /// Bytes of these in memory.
    pub bytes: Option<u64>,
    /// Mean PSNR where the truth is known, dB.
    pub psnr_db: Option<f64>,
    /// Milliseconds that the last live picture at rest took.
    pub picture_ms: Option<f64>,
}

/// A figure before a change of settings and now.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Difference {
    pub name: &'static str,
    pub before: String,
    /// `None` until it is known.
    pub now: Option<String>,
    /// By how much it changed, with its sign.
    pub change: Option<String>,
}

/// Two prunings of a frame, to be compared as the live view sees them.
#[derive(Clone)]
pub(crate) struct ChangeRequest {
    pub scene: u64,
    /// The earlier one first.
    pub pair: [Same<FrameInspection>; 2],
    pub camera: Camera,
    /// The live picture and where it is seen from, by which samples behind surfaces are told.
    pub seen: Option<(Same<LivePicture>, Camera)>,
}

impl PartialEq for ChangeRequest {
    /// Which picture hides what lies behind does not count: it is painted anew at every change.
    fn eq(&self, other: &Self) -> bool {
        self.pair == other.pair && self.camera == other.camera
    }
}
