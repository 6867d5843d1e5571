//! Accuracy against time and bytes: many settings and all baselines on one capture, and the Pareto front among them.
//!
//! Points are delivered one by one, so that a run can be shown and resumed.

mod external;
mod plan;
mod point;

use crate::trial::{Measured, ShownView, TimeLeft, Trial, ViewAccuracy, Workbench, coarse_to_fine};
use crate::truth::{Recorded, Truth};
pub use external::ExternalPoint;
use overlook_engine::capture::Capture;
use overlook_engine::error::Result;
use overlook_engine::job::Job;
pub use plan::{Planned, SweepPlan, paper, picture_variations, variations};
pub use point::{Point, Series, mark_behind_best, mark_pareto, mark_pareto_of_stores};

/// Measures the unknown points of the plan, the reference and other methods first, then settings from coarse to fine until its budget is spent, and compares all points with each other; a
/// single camera is skipped if no view can be scored for it. `on_point` receives each new point and the number of known ones.
///
/// # Errors
/// Those of preprocessing, rendering and truth; `Cancelled`: put the points received so far into [`SweepPlan::done`] to continue.
pub fn run(
    capture: &Capture,
    plan: &SweepPlan,
    truth: &Truth,
    job: &Job,
    on_point: impl FnMut(&Point, usize),
) -> Result<Measured<Point>> {
    let Measured { mut points, left } = measure(capture, plan, truth, job, on_point)?;
    only_the_best_single_camera(&mut points);
    let vantages = points.iter().map(|point| point.vantages).max().unwrap_or_default();
    points.extend(plan.external.iter().map(|external| external.point(&plan.reference, vantages)));
    mark_behind_best(&mut points);
    mark_pareto_of_stores(&mut points);
    Ok(Measured { points, left })
}

/// All points of the plan, known and new, not compared with each other yet.
fn measure(
    capture: &Capture,
    plan: &SweepPlan,
    truth: &Truth,
    job: &Job,
    mut on_point: impl FnMut(&Point, usize),
) -> Result<Measured<Point>> {
    let mut points: Vec<Option<Point>> = plan.trials.iter().map(|planned| plan.known(planned)).collect();
    let open = points.iter().filter(|point| point.is_none()).count();
    let mut left = 0;
    if open > 0 {
        let mut workbench = Workbench::new(&Recorded::undisturbed(capture), truth, &plan.reference, job)?;
        let to_measure = plan.trials.iter().zip(&points).filter(|(_, point)| point.is_none());
        workbench.open(to_measure.map(|(planned, _)| &planned.trial))?;
        let (known, mut time_left) = (plan.trials.len() - open, TimeLeft::start(plan.budget));
        for index in coarse_to_fine(&plan.rounds()) {
            let (planned, slot) = (&plan.trials[index], &mut points[index]);
            if slot.is_some() || !workbench.can_measure(&planned.trial) {
                continue;
            }
            if time_left.is_spent() {
                left += 1;
                continue;
            }
            let number = known + time_left.measured() + 1;
            time_left.next(job, number, plan.trials.len(), open - time_left.measured());
            let point = Point::new(&planned.trial, planned.series, &workbench.measure(&planned.trial, job)?);
            on_point(&point, number);
            *slot = Some(point);
        }
        job.set_context("");
    }
    Ok(Measured { points: points.into_iter().flatten().collect(), left })
}

/// Keeps only the most accurate of the single cameras.
fn only_the_best_single_camera(points: &mut Vec<Point>) {
    let is_single = |point: &Point| point.series == Series::SingleCamera;
    let best = points
        .iter()
        .filter(|point| is_single(point))
        .max_by(|a, b| a.psnr_filled_db.total_cmp(&b.psnr_filled_db))
        .map(|point| point.label.clone());
    points.retain(|point| !is_single(point) || Some(&point.label) == best.as_ref());
}

/// The default at its worst view of each of the `count` worst vantages of a sweep's `points`, the worst first.
///
/// # Errors
/// As [`run`].
pub fn worst_views(
    capture: &Capture,
    plan: &SweepPlan,
    truth: &Truth,
    points: &[Point],
    count: usize,
    job: &Job,
) -> Result<Vec<ShownView>> {
    let Some(default) = points.iter().find(|point| point.series == Series::Reference) else {
        return Ok(Vec::new());
    };
    let worst_of_vantage = |views: &[ViewAccuracy]| {
        views.iter().min_by(|a, b| a.psnr_filled_db.total_cmp(&b.psnr_filled_db)).cloned()
    };
    let vantages = default.views.chunk_by(|before, after| before.vantage == after.vantage);
    let mut worst: Vec<_> = vantages.filter_map(worst_of_vantage).collect();
    worst.sort_by(|a, b| a.psnr_filled_db.total_cmp(&b.psnr_filled_db));
    worst.truncate(count);
    let mut workbench = Workbench::new(&Recorded::undisturbed(capture), truth, &plan.reference, job)?;
    let trial = Trial::new(default.label.clone(), default.settings.clone());
    let shown = worst.iter().map(|view| workbench.show(&trial, &view.file_path, job));
    Ok(shown.collect::<Result<Vec<_>>>()?.into_iter().flatten().collect())
}
