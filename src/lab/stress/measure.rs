//! Every disturbance of a plan at every value of its dial, measured with every method.

use super::plan::{Method, StressPlan, StressPoint, StressStep};
use crate::scoring::nothing_to_compare;
use crate::sweep::{self, Point, Series};
use crate::trial::{Fineness, Measured, TimeLeft, Trial, Workbench, coarse_to_fine};
use crate::truth::{self, Recorded, Truth};
use overlook_engine::capture::Capture;
use overlook_engine::error::{Error, Result};
use overlook_engine::job::Job;

/// Measures every disturbance of the plan at the values of its dial with every method, the first method's ends and middles first, then
/// all from coarse to fine until the budget is spent, and compares the methods at each value. `on_point` receives each new point, the number of known points and their total.
/// Disturbances that cannot change the capture, and values that leave no true pixel, are skipped with a warning.
///
/// # Errors
/// Those of preprocessing, rendering and truth; `Invalid` if nothing can be disturbed or compared; `Cancelled`: put the points
/// received so far into [`StressPlan::done`] to continue.
pub fn run(
    capture: &Capture,
    plan: &StressPlan,
    truth: &Truth,
    job: &Job,
    on_point: impl FnMut(&StressPoint, (usize, usize)),
) -> Result<Measured<StressPoint>> {
    let Measured { mut points, left } = measure(capture, plan, truth, job, on_point)?;
    for index in 0..points.len() {
        points[index] = points[index].clone().with_loss(points[..index].iter());
    }
    for methods in points.chunk_by_mut(|a, b| a.disturbance == b.disturbance && a.dial == b.dial) {
        sweep::mark_behind_best(methods.iter_mut().map(|method| &mut method.point));
        sweep::mark_pareto_of_stores(methods.iter_mut().map(|method| &mut method.point));
    }
    Ok(Measured { points, left })
}

/// All points of the plan, known and new; no method is compared with another yet. The loss of each is since the first that is known.
fn measure(
    capture: &Capture,
    plan: &StressPlan,
    truth: &Truth,
    job: &Job,
    mut on_point: impl FnMut(&StressPoint, (usize, usize)),
) -> Result<Measured<StressPoint>> {
    let (steps, levels) = steps(capture, plan, truth, job)?;
    let of_step = |step| move |method| plan.known(step, method).cloned();
    let known = |step: &StressStep| plan.methods.iter().map(of_step(*step)).collect();
    let mut points: Vec<Vec<Option<StressPoint>>> = steps.iter().map(known).collect();
    let mut total = steps.len() * plan.methods.len();
    let mut open = points.iter().flatten().filter(|point| point.is_none()).count();
    let (mut time_left, mut passed_over) = (TimeLeft::start(plan.budget), Vec::new());
    let order = coarse_to_fine(&levels);
    // The curves of the first method come first.
    let first = order.iter().filter(|index| Fineness::Medium.takes(levels[**index])).map(|index| (*index, 1));
    for (index, methods) in first.chain(order.iter().map(|index| (*index, plan.methods.len()))) {
        let mut disturbed = None;
        for (nth, method) in plan.methods.iter().take(methods).enumerate() {
            if passed_over.contains(&index) {
                break;
            }
            if points[index][nth].is_some() || time_left.is_spent() {
                continue;
            }
            let number = total - open + 1;
            time_left.next(job, number, total, open);
            if disturbed.is_none() {
                disturbed = Disturbed::new(capture, plan, truth, steps[index], job)?;
            }
            let Some(disturbed) = &mut disturbed else {
                let never = points[index].iter().filter(|point| point.is_none()).count();
                (total, open) = (total - never, open - never);
                passed_over.push(index);
                break;
            };
            let point = disturbed.measure(method, job)?.with_loss(points.iter().flatten().flatten());
            on_point(&point, (number, total));
            points[index][nth] = Some(point);
            open -= 1;
        }
    }
    job.set_context("");
    let points: Vec<_> = points.into_iter().flatten().flatten().collect();
    if points.is_empty() && !passed_over.is_empty() {
        return Err(nothing_to_compare(&capture.name));
    }
    passed_over.sort_unstable();
    for index in passed_over {
        job.warn(no_points_warning(steps[index]));
    }
    Ok(Measured { points, left: open })
}

/// The values of the dial of every disturbance that can change the capture, and their levels.
fn steps(
    capture: &Capture,
    plan: &StressPlan,
    truth: &Truth,
    job: &Job,
) -> Result<(Vec<StressStep>, Vec<usize>)> {
    let mut steps = Vec::new();
    for &disturbance in &plan.disturbances {
        match disturbance.lacks(capture) {
            None => steps.extend(plan.values(disturbance, capture, truth)),
            Some(lacks) => {
                let name = disturbance.name();
                job.warn(format!("'{name}' is left out: it changes nothing, as there {lacks}"));
            }
        }
    }
    if steps.is_empty() && !plan.disturbances.is_empty() {
        return Err(Error::invalid(
            &capture.name,
            "is not changed by any of the chosen disturbances; choose others",
        ));
    }
    Ok(steps.into_iter().unzip())
}

/// The warning that a step has no points.
fn no_points_warning((disturbance, dial): StressStep) -> String {
    let (name, unit) = (disturbance.name(), disturbance.unit());
    format!("'{name}' at {dial} {unit} is left out: no camera sees anything of the true pictures then")
}

/// The disturbed capture ready to be measured, and the pixels it has.
pub(super) struct Disturbed {
    step: StressStep,
    pub(super) workbench: Workbench,
    pixels: u64,
}

impl Disturbed {
    /// `None` where nothing of the truth is left.
    pub(super) fn new(
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
