//! Input and result of tuning.

use serde::{Deserialize, Serialize};

use crate::sweep::Point;
use overlook_engine::capture::Capture;
use overlook_engine::settings::Settings;

/// A limit, instead of what the scene needs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TuneBudget {
    /// Bytes of the store that `preprocess` makes of the whole capture.
    Bytes(u64),
    /// Milliseconds of painting a view, as measured on this machine: the one thing that may differ from run to run.
    Milliseconds(f64),
}

/// What may be given up by default, dB.
pub const AT_MOST_DB: f64 = 0.1;

/// What to tune, and the points that are known already.
#[derive(Clone)]
pub struct TunePlan {
    /// The settings to start from.
    pub settings: Settings,
    /// If given, the most accurate setting within it is chosen.
    pub budget: Option<TuneBudget>,
    /// The capture with all its frames if only some are used: a budget of bytes is for its store.
    pub whole: Option<Capture>,
    /// What may be given up of the most accurate setting, dB, whatever the uncertainty.
    pub at_most_db: f64,
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
    /// Accuracy without it, dB: at the capture's views, or else at the camera's own position.
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
    /// The cameras that were left out on trial, in order.
    pub camera_costs: Vec<CameraCost>,
    /// The most accurate point.
    pub best: Point,
    /// What may be given up of the best, dB. `None` where a budget decided.
    pub at_most_db: Option<f64>,
    /// Whether the first settings of the search stay because there are too few vantages to choose by.
    pub cannot_tell: bool,
    /// The point that was chosen, all cameras still there.
    pub chosen: Point,
    /// Upper bound of the bytes of the whole capture's store with all cameras, for a budget of bytes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bytes_whole: Option<u64>,
    /// Everything that was tried, in the order of trying.
    pub points: Vec<Point>,
    /// What was chosen and what was given up, one sentence each.
    pub words: Vec<String>,
}
