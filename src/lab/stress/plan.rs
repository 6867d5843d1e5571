//! What a stress test measures, and what it gives.

use serde::{Deserialize, Serialize};

use super::disturbance::Disturbance;
use crate::rivals::Rival;
use crate::sweep::{self, Point};
use crate::trial::PairedDifference;
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
    /// Points of an earlier run on the same capture and truth.
    pub done: Vec<StressPoint>,
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
            done: Vec::new(),
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
    pub(super) fn with_loss(self, points: &[Self]) -> Self {
        let first = points.iter().find(|other| other.is_like(&self));
        let loss = first.and_then(|first| PairedDifference::between(&first.point.views, &self.point.views));
        Self { loss_db: loss.map_or(0.0, |loss| loss.db.mean), ..self }
    }
}
