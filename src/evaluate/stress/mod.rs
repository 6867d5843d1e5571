//! Robustness: disturbances of growing size, applied to any capture, and what they cost our settings and the paper's.
//!
//! ```text
//! capture ─ Disturbance::apply(dial) ─▶ Recorded ─ Workbench ─▶ StressPoint …─ failures ─▶ the dial at which 1 dB is lost
//! ```
//!
//! Frames are disturbed as they are loaded. Loss is relative to the same method at the first value of the dial, which disturbs
//! nothing, over the views scored at both. There are no points for a value at which no camera sees any true pixel, or for a
//! disturbance that cannot change the capture.

mod depth_sensor;
mod disturbance;
mod light;
mod recording_edits;
mod shapes;

pub use disturbance::Disturbance;

use serde::{Deserialize, Serialize};

use super::scoring::nothing_to_compare;
use super::sweep::{self, Point, Series};
use super::trial::{PairedDifference, ShownView, TimeLeft, Trial, ViewAccuracy, Workbench};
use super::truth::{self, Recorded, Truth};
use crate::capture::Capture;
use crate::error::{Error, Result};
use crate::job::Job;
use crate::rivals::Rival;
use crate::settings::Settings;

/// A method that is put under stress.
#[derive(Clone, Debug, PartialEq)]
pub struct Method {
    /// Name for legends and tables.
    pub name: String,
    /// Its settings.
    pub settings: Settings,
    /// The method of others that it is instead; its settings then say nothing.
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
    fn known(&self, (disturbance, dial): StressStep, method: &Method) -> Option<&StressPoint> {
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

/// Where a method fails.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BreakingPoint {
    /// Name of the disturbance.
    pub disturbance: String,
    /// Unit of its dial.
    pub unit: String,
    /// Name of the method.
    pub method: String,
    /// Value of the dial at a loss of [`LOST_DB`], interpolated; `None` if it is never reached.
    pub dial: Option<f64>,
    /// The largest loss anywhere, dB.
    pub worst_loss_db: f64,
    /// The last value of the dial.
    pub last_dial: f64,
}

/// A method fails where it has lost this much, dB.
pub const LOST_DB: f64 = 1.0;

/// Measures every disturbance of the plan at every value of its dial with every method. `on_point` receives each new point, the
/// number of known points and their total. Disturbances that cannot change the capture, and values that leave no true pixel, are
/// skipped with a warning.
///
/// # Errors
/// Those of preprocessing, rendering and truth; `Invalid` if nothing can be disturbed or compared; `Cancelled`: put the points
/// received so far into [`StressPlan::done`] to continue.
pub fn run(
    capture: &Capture,
    plan: &StressPlan,
    truth: &Truth,
    job: &Job,
    mut on_point: impl FnMut(&StressPoint, (usize, usize)),
) -> Result<Vec<StressPoint>> {
    let steps = steps(capture, plan, truth, job)?;
    let mut total = steps.len() * plan.methods.len();
    let open_at = |step| plan.methods.iter().filter(|method| plan.known(step, method).is_none()).count();
    let mut open: usize = steps.iter().map(|step| open_at(*step)).sum();
    let (mut time_left, mut points, mut passed_over) =
        (TimeLeft::start(), Vec::with_capacity(total), Vec::new());
    for step in steps {
        let mut disturbed = None;
        for method in &plan.methods {
            if let Some(known) = plan.known(step, method) {
                points.push(known.clone().with_loss(&points));
                continue;
            }
            time_left.next(job, (points.len() + 1, total), open - time_left.measured());
            if disturbed.is_none() {
                disturbed = Disturbed::new(capture, plan, truth, step, job)?;
            }
            let Some(disturbed) = &mut disturbed else {
                // `time_left` counts one point as begun.
                (total, open) = (total - open_at(step), open + 1 - open_at(step));
                passed_over.push(step);
                break;
            };
            let point = disturbed.measure(method, job)?.with_loss(&points);
            on_point(&point, (points.len() + 1, total));
            points.push(point);
        }
    }
    job.set_context("");
    if points.is_empty() && !passed_over.is_empty() {
        return Err(nothing_to_compare(&capture.name));
    }
    for step in passed_over {
        job.warn(no_points_warning(step));
    }
    for methods in points.chunk_by_mut(|a, b| a.disturbance == b.disturbance && a.dial == b.dial) {
        sweep::mark_behind_best(methods.iter_mut().map(|method| &mut method.point));
        sweep::mark_pareto_of_stores(methods.iter_mut().map(|method| &mut method.point));
    }
    Ok(points)
}

/// Every value of the dial of every disturbance that can change the capture.
fn steps(capture: &Capture, plan: &StressPlan, truth: &Truth, job: &Job) -> Result<Vec<StressStep>> {
    let mut steps = Vec::new();
    for &disturbance in &plan.disturbances {
        match disturbance.lacks(capture) {
            None => {
                let dial = disturbance.dial(capture, truth).into_iter();
                steps.extend(dial.map(|dial| (disturbance, dial)));
            }
            Some(lacks) => {
                let name = disturbance.name();
                job.warn(format!("'{name}' is left out: it changes nothing, as there {lacks}"));
            }
        }
    }
    if steps.is_empty() && !plan.disturbances.is_empty() {
        return Err(Error::invalid(
            &capture.name,
            "is changed by no disturbance that was asked for; ask for others",
        ));
    }
    Ok(steps)
}

/// A disturbance and a value of its dial.
type StressStep = (Disturbance, f64);

/// The warning that a step has no points.
fn no_points_warning((disturbance, dial): StressStep) -> String {
    let (name, unit) = (disturbance.name(), disturbance.unit());
    format!("'{name}' at {dial} {unit} is left out: no camera sees anything of the true pictures then")
}

impl StressPoint {
    /// Whether the other is of the same disturbance and method.
    fn is_like(&self, other: &Self) -> bool {
        other.disturbance == self.disturbance && other.method == self.method
    }

    /// The point with its loss since the first of `points` of its disturbance and method.
    fn with_loss(self, points: &[Self]) -> Self {
        let first = points.iter().find(|other| other.is_like(&self));
        let loss = first.and_then(|first| PairedDifference::between(&first.point.views, &self.point.views));
        Self { loss_db: loss.map_or(0.0, |loss| loss.db.mean), ..self }
    }
}

/// The disturbed capture ready to be measured, and the pixels it has.
struct Disturbed {
    step: StressStep,
    workbench: Workbench,
    pixels: u64,
}

impl Disturbed {
    /// `None` where nothing of the truth is left.
    fn new(
        capture: &Capture,
        plan: &StressPlan,
        truth: &Truth,
        step: StressStep,
        job: &Job,
    ) -> Result<Option<Self>> {
        let mut recorded = step.0.apply(capture, step.1)?;
        let mut truth = truth.clone();
        if let Some(count) = plan.frames {
            let frames = truth::choose(capture, &truth, count)?;
            truth = truth::truth_at(capture, truth, &frames);
            recorded = Recorded {
                capture: truth::only(&recorded.capture, &frames),
                clean: truth::only(&recorded.clean, &frames),
                all_cameras: truth::only(&recorded.all_cameras, &frames),
                edit_truth: recorded.edit_truth,
            };
        }
        let pixels = recorded.capture.pixel_count();
        let (folds, unseen) = truth.folds_left(&recorded, job)?;
        if folds.is_empty() {
            return Ok(None);
        }
        for view in unseen {
            job.warn(format!("'{}' at {} {}: {view}", step.0.name(), step.1, step.0.unit()));
        }
        let workbench = Workbench::on(folds, &plan.methods[0].settings);
        Ok(Some(Self { step, workbench, pixels }))
    }

    /// Measures a method; the loss is still 0.
    fn measure(&mut self, method: &Method, job: &Job) -> Result<StressPoint> {
        let (disturbance, dial) = self.step;
        let (name, unit) = (disturbance.name(), disturbance.unit());
        let label = format!("{name} {dial} {unit}, {}", method.name);
        let trial = Trial { rival: method.rival, ..Trial::new(label, method.settings.clone()) };
        let measured = self.workbench.measure(&trial, job)?;
        let series = method.rival.map_or(Series::Variation, Series::of);
        let point = Point::new(&trial, series, &measured);
        Ok(StressPoint {
            disturbance: name.to_owned(),
            dial,
            unit: unit.to_owned(),
            method: method.name.clone(),
            kept_share: point.samples as f64 / self.pixels as f64,
            loss_db: 0.0,
            point,
        })
    }
}

/// Where each method fails under each disturbance, in the order of the points.
#[must_use]
pub fn failures(points: &[StressPoint]) -> Vec<BreakingPoint> {
    let mut dials: Vec<Vec<&StressPoint>> = Vec::new();
    for point in points {
        match dials.iter_mut().find(|dial| dial[0].is_like(point)) {
            Some(dial) => dial.push(point),
            None => dials.push(vec![point]),
        }
    }
    let failure = |dial: Vec<&StressPoint>| {
        let (first, last) = (dial[0], dial[dial.len() - 1]);
        let lost_at = dial.windows(2).find(|pair| pair[1].loss_db >= LOST_DB).map(|pair| {
            let (before, after) = (pair[0], pair[1]);
            let share = (LOST_DB - before.loss_db) / (after.loss_db - before.loss_db);
            before.dial + share * (after.dial - before.dial)
        });
        BreakingPoint {
            disturbance: first.disturbance.clone(),
            unit: first.unit.clone(),
            method: first.method.clone(),
            dial: lost_at,
            worst_loss_db: dial.iter().map(|point| point.loss_db).fold(first.loss_db, f64::max),
            last_dial: last.dial,
        }
    };
    dials.into_iter().map(failure).collect()
}

/// What a method shows where a disturbance breaks it.
pub(crate) struct BreakingView {
    pub(crate) disturbance: String,
    /// The first value of the dial at which 1 dB is lost, or the last one.
    pub(crate) dial: f64,
    pub(crate) unit: String,
    /// Over all views.
    pub(crate) loss_db: f64,
    /// At the view that loses most.
    pub(crate) shown: ShownView,
}

/// The first method of a plan at the breaking point of each disturbance.
///
/// # Errors
/// As [`run`].
pub(crate) fn breaking_views(
    capture: &Capture,
    plan: &StressPlan,
    truth: &Truth,
    points: &[StressPoint],
    job: &Job,
) -> Result<Vec<BreakingView>> {
    let mut views = Vec::new();
    let Some(method) = plan.methods.first() else { return Ok(views) };
    for &disturbance in &plan.disturbances {
        let is_of =
            |point: &&StressPoint| point.disturbance == disturbance.name() && point.method == method.name;
        let dial: Vec<&StressPoint> = points.iter().filter(is_of).collect();
        let broken = dial.iter().find(|point| point.loss_db >= LOST_DB).or(dial.last());
        let (Some(clean), Some(broken)) = (dial.first(), broken) else { continue };
        let loss = |view: &ViewAccuracy| {
            let before = clean.point.views.iter().find(|before| before.file_path == view.file_path);
            before.map_or(0.0, |before| before.psnr_filled_db - view.psnr_filled_db)
        };
        let worst = broken.point.views.iter().max_by(|a, b| loss(a).total_cmp(&loss(b)));
        let disturbed = Disturbed::new(capture, plan, truth, (disturbance, broken.dial), job)?;
        let (Some(worst), Some(mut disturbed)) = (worst, disturbed) else { continue };
        let trial = Trial::new(method.name.clone(), method.settings.clone());
        if let Some(shown) = disturbed.workbench.show(&trial, &worst.file_path, job)? {
            let (dial, loss_db) = (broken.dial, broken.loss_db);
            let (disturbance, unit) = (broken.disturbance.clone(), broken.unit.clone());
            views.push(BreakingView { disturbance, dial, unit, loss_db, shown });
        }
    }
    Ok(views)
}

/// The values without repetitions, in the order in which they first come.
pub(crate) fn distinct<T: PartialEq>(values: impl Iterator<Item = T>) -> Vec<T> {
    values.fold(Vec::new(), |mut distinct, value| {
        if !distinct.contains(&value) {
            distinct.push(value);
        }
        distinct
    })
}
