//! What a stress test measures, and what it gives.

use std::time::Duration;

use serde::{Deserialize, Serialize};

use super::disturbance::Disturbance;
use crate::rivals::Rival;
use crate::sweep::{self, Point};
use crate::trial::{Fineness, PairedDifference, levels};
use crate::truth::Truth;
use overlook_engine::capture::Capture;
use overlook_engine::settings::Settings;

/// A method that is put under stress.
#[derive(Clone, Debug, PartialEq)]
pub struct Method {
    /// Name for legends and tables.
    pub name: String,
    /// Its settings.
    pub settings: Settings,
    /// A method of others; `settings` are then not used.
    pub rival: Option<Rival>,
}

/// Disturbances, methods, and the points that are known already.
#[derive(Clone, Debug)]
pub struct StressPlan {
    /// The disturbances, each at all values of its dial.
    pub disturbances: Vec<Disturbance>,
    /// The methods; the first is ours.
    pub methods: Vec<Method>,
    /// Number of frames to use, those with truth first; all if `None`. Frames are disturbed before they are chosen.
    pub frames: Option<usize>,
    /// Which values of each dial are measured.
    pub fineness: Fineness,
    /// Points of an earlier run on the same capture and truth.
    pub done: Vec<StressPoint>,
    /// How long may be measured; a measurement that was begun is finished, and there is always one.
    pub budget: Option<Duration>,
}

impl StressPlan {
    /// Every disturbance, for three methods: `settings`, the paper's preprocessing with the rendering of `settings`, and the
    /// paper's settings.
    #[must_use]
    pub fn standard(settings: &Settings) -> Self {
        let paper = sweep::paper(settings);
        let mut undefended = paper.clone();
        undefended.render = settings.render.clone();
        let method = |name: &str, settings| Method { name: name.to_owned(), settings, rival: None };
        Self {
            disturbances: Disturbance::ALL.to_vec(),
            methods: vec![
                method("ours", settings.clone()),
                method("without defenses", undefended),
                method("paper", paper),
            ],
            frames: None,
            fineness: Fineness::default(),
            done: Vec::new(),
            budget: None,
        }
    }

    /// The plan with methods of others beside ours: meshes, a volume, the nearest camera and a layered depth image.
    #[must_use]
    pub fn with_rivals(mut self, settings: &Settings) -> Self {
        let rivals = [Rival::TriangleMesh, Rival::Tsdf(4), Rival::NearestCamera, Rival::LayeredDepthImage];
        self.methods.extend(rivals.map(|rival| Method {
            name: rival.name().to_owned(),
            settings: settings.clone(),
            rival: Some(rival),
        }));
        self
    }

    /// The values of a disturbance's dial that are measured, and their levels.
    pub(super) fn values(
        &self,
        disturbance: Disturbance,
        capture: &Capture,
        truth: &Truth,
    ) -> impl Iterator<Item = (StressStep, usize)> {
        let (dial, fineness) = (disturbance.dial(capture, truth), self.fineness);
        let levels = levels(dial.len());
        let values = dial.into_iter().map(move |value| (disturbance, value)).zip(levels);
        values.filter(move |(_, level)| fineness.takes(*level))
    }

    /// How many measurements the plan has that are not known.
    #[must_use]
    pub fn open(&self, capture: &Capture, truth: &Truth) -> usize {
        let changing = self.disturbances.iter().filter(|disturbance| disturbance.lacks(capture).is_none());
        let steps = changing.flat_map(|disturbance| self.values(*disturbance, capture, truth));
        let open = |step| self.methods.iter().filter(|method| self.known(step, method).is_none()).count();
        steps.map(|(step, _)| open(step)).sum()
    }

    /// The point of an earlier run.
    pub(super) fn known(&self, (disturbance, dial): StressStep, method: &Method) -> Option<&StressPoint> {
        self.done.iter().find(|point| {
            point.disturbance == disturbance.name()
                && point.dial == dial
                && point.method == method.name
                && point.point.settings == method.settings
        })
    }
}

/// One method under one value of a disturbance's dial.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StressPoint {
    /// Name of the disturbance.
    pub disturbance: String,
    /// Value of the dial.
    pub dial: f64,
    /// Unit of the dial.
    pub unit: String,
    /// Name of the method.
    pub method: String,
    /// Samples kept, as a share of all recorded pixels.
    pub kept_share: f64,
    /// Drop of `psnr_filled_db` since the first value of the dial, dB, over the views scored at both; 0 if there are none.
    pub loss_db: f64,
    /// What was measured.
    #[serde(flatten)]
    pub point: Point,
}

/// A disturbance and a value of its dial.
pub(super) type StressStep = (Disturbance, f64);

impl StressPoint {
    /// Whether the other is of the same disturbance and method.
    pub(super) fn is_like(&self, other: &Self) -> bool {
        other.disturbance == self.disturbance && other.method == self.method
    }

    /// The point with its loss since the first of `points` of its disturbance and method.
    pub(super) fn with_loss<'a>(self, mut points: impl Iterator<Item = &'a Self>) -> Self {
        let first = points.find(|other| other.is_like(&self));
        let loss = first.and_then(|first| PairedDifference::between(&first.point.views, &self.point.views));
        Self { loss_db: loss.map_or(0.0, |loss| loss.db.mean), ..self }
    }
}
