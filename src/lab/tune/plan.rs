//! Input and result of tuning.

use std::collections::BTreeSet;
use std::time::Duration;

use serde::{Deserialize, Serialize};

use crate::sweep::{Point, SweepPlan, picture_variations, variations};
use crate::trial::{Fineness, Trial};
use overlook_engine::capture::Capture;
use overlook_engine::edits::EditList;
use overlook_engine::settings::{PruningMethod, Settings};

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
    /// Settings that are not varied, by their paths.
    pub left_out: BTreeSet<String>,
    /// How many values of each setting are tried.
    pub fineness: Fineness,
    /// How long settings may be varied one by one; what was tried until then is combined. `None` until all of them are tried.
    pub time: Option<Duration>,
    /// Points of an earlier run on the same capture and truth.
    pub done: Vec<Point>,
}

impl TunePlan {
    /// To find what the scene needs, starting from these settings, with all cameras kept: every setting is varied.
    #[must_use]
    pub fn of(settings: Settings) -> Self {
        Self {
            settings,
            budget: None,
            whole: None,
            at_most_db: AT_MOST_DB,
            drop_cameras: false,
            left_out: BTreeSet::new(),
            fineness: Fineness::Fine,
            time: None,
            done: Vec::new(),
        }
    }

    /// The trials that a search begins with: the start, no pruning, and every variation of one setting; of the renderer's where time
    /// is what is scarce.
    #[must_use]
    pub fn first_trials(&self) -> Vec<Trial> {
        let start = &self.settings;
        let mut everything = start.clone();
        everything.pruning.method = PruningMethod::Off;
        let mut trials = vec![Trial::new("start", start.clone()), Trial::new("no pruning", everything)];
        let mut varied = variations(start);
        if matches!(self.budget, Some(TuneBudget::Milliseconds(_))) {
            varied.extend(picture_variations(start));
        }
        let mut plan = SweepPlan::varying(start, varied);
        plan.choose(self.fineness, |planned| !planned.dials().any(|(path, _)| self.left_out.contains(path)));
        trials.extend(plan.trials.into_iter().map(|planned| planned.trial));
        trials
    }

    /// How many of these are not known.
    #[must_use]
    pub fn open(&self) -> usize {
        let is_open = |trial: &&Trial| !self.done.iter().any(|point| point.is_of(trial));
        self.first_trials().iter().filter(is_open).count()
    }
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

/// What cameras to rank, and those that are known already.
#[derive(Clone, Debug)]
pub struct RankPlan {
    /// The settings of all models.
    pub settings: Settings,
    /// What they leave out and delete before pruning is not there.
    pub edits: EditList,
    /// Cameras of an earlier run on the same capture and truth.
    pub done: Vec<CameraWorth>,
}

/// What the model would be without one camera.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraWorth {
    /// Its name.
    pub name: String,
    /// The share of all seen surfaces that no other camera shows, 0 to 1.
    pub seen_alone: f64,
    /// Accuracy without it, dB: at the true viewpoints, or else at its own place, as the others show it.
    pub psnr_filled_db: f64,
    /// What that is less than with all cameras, dB; `None` where the accuracy is that at its own place.
    pub loss_db: Option<f64>,
    /// Samples fewer than with all cameras; below 0 where its samples stood for more of others.
    pub samples_less: i64,
    /// Bytes of the store fewer than with all cameras; below 0 as there.
    pub bytes_less: i64,
}

impl CameraWorth {
    /// Puts the most needless first: those without which accuracy stays highest, of equals those that show least alone, then those
    /// that take most bytes.
    pub fn sort(cameras: &mut [Self]) {
        cameras.sort_by(|a, b| {
            let by_accuracy = b.psnr_filled_db.total_cmp(&a.psnr_filled_db);
            by_accuracy.then(a.seen_alone.total_cmp(&b.seen_alone)).then(b.bytes_less.cmp(&a.bytes_less))
        });
    }
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
