//! The viewpoints at which a sweep's default is worst, to be looked at.

use super::plan::SweepPlan;
use super::point::{Point, Series};
use crate::trial::{ShownView, Trial, ViewAccuracy, Workbench};
use crate::truth::{Recorded, Truth};
use overlook_engine::capture::Capture;
use overlook_engine::error::Result;
use overlook_engine::job::Job;

/// The default at its worst view of each of the `count` worst vantages of a sweep's `points`, the worst first.
///
/// # Errors
/// As [`run`](super::run).
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
