//! What tuning starts from, and what it gives.

use serde::{Deserialize, Serialize};

use crate::capture::Capture;
use crate::evaluate::sweep::Point;
use crate::settings::Settings;

/// What may be spent instead of what the scene needs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TuneBudget {
    /// Bytes of the store that `preprocess` makes of the whole capture.
    Bytes(u64),
    /// Milliseconds of painting a view, as measured on this machine: the one thing that may differ from run to run.
    Milliseconds(f64),
}

/// What is looked for, and what of it is known already.
#[derive(Clone)]
pub struct TunePlan {
    /// The settings to start from.
    pub settings: Settings,
    /// Where given, the most accurate setting within it is chosen.
    pub budget: Option<TuneBudget>,
    /// The capture with all its frames, where some of them alone are looked at: a budget of bytes is for its store.
    pub whole: Option<Capture>,
    /// Whether cameras may be dropped.
    pub drop_cameras: bool,
    /// Points of an earlier run on the same capture and truth.
    pub done: Vec<Point>,
}

/// A camera, and what its absence costs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CameraCost {
    /// Its name.
    pub name: String,
    /// Held-out accuracy without it, dB: where views come with the capture, at these; else at its own place.
    pub psnr_filled_db: f64,
    /// Whether it was dropped.
    pub dropped: bool,
}

/// What was chosen, and why.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Tuned {
    /// The settings.
    pub settings: Settings,
    /// Names of the cameras that are needed, in the capture's order.
    pub cameras: Vec<String>,
    /// What each camera that was tried without would cost, in the order of trying.
    pub camera_costs: Vec<CameraCost>,
    /// The most accurate point.
    pub best: Point,
    /// Accuracy that is good enough, dB: the best less one standard error. `None` where a budget decided.
    pub limit_db: Option<f64>,
    /// The point that was chosen, all cameras still there.
    pub chosen: Point,
    /// Bytes that the store of the whole capture takes at most, with these settings and all cameras; where a budget of bytes
    /// decided.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bytes_whole: Option<u64>,
    /// Everything that was tried, in the order of trying.
    pub points: Vec<Point>,
    /// What was chosen and what was given up, one sentence each.
    pub words: Vec<String>,
}
