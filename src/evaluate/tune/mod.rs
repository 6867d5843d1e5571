//! The smallest model that is good enough: the simplest setting whose held-out accuracy is within one standard error of the best,
//! without cameras whose absence costs nothing by the same rule.
//!
//! Source: the one-standard-error rule of Breiman, Friedman, Olshen and Stone, *Classification and Regression Trees*, 1984.
//! *Simplest* means fewest bytes, then least work to render, counted in samples and kernels instead of time, so that the same
//! capture gives the same answer.
//!
//! ```text
//! every variation of one setting ─▶ best, limit = best − 1 SE ─▶ combine what saves bytes ─▶ cheaper kernel ─▶ cameras
//! ```

mod cameras;
mod plan;
mod search;
mod whole;
mod words;

pub use plan::{CameraCost, TuneBudget, TunePlan, Tuned};

use super::sweep::Point;
use super::truth::Truth;
use crate::capture::Capture;
use crate::error::Result;
use crate::job::Job;
use search::Search;

/// Tunes; `on_point` receives each new point.
///
/// # Errors
/// Those of preprocessing, rendering and truth; `Invalid` if no setting meets the budget; `Cancelled`: put the points received so
/// far into [`TunePlan::done`] to continue.
pub fn run(
    capture: &Capture,
    plan: &TunePlan,
    truth: &Truth,
    job: &Job,
    on_point: impl FnMut(&Point),
) -> Result<Tuned> {
    let mut search = Search::new(capture, plan, truth, job, Box::new(on_point))?;
    let chosen = search.choose()?;
    let best = search.best().clone();
    let limit_db = plan.budget.is_none().then(|| search.limit_db());
    let (kept, camera_costs) = if plan.drop_cameras && plan.budget.is_none() {
        cameras::drop_needless(&mut search, capture, &chosen)?
    } else {
        (capture.cameras.iter().map(|camera| camera.name.clone()).collect(), Vec::new())
    };
    let bytes_whole = match plan.budget {
        Some(TuneBudget::Bytes(_)) => Some(search.bytes_whole(&chosen.settings)?),
        _ => None,
    };
    let points = search.finish();
    job.set_context("");
    let mut tuned = Tuned {
        settings: chosen.settings.clone(),
        cameras: kept,
        camera_costs,
        best,
        limit_db,
        chosen,
        bytes_whole,
        points,
        words: Vec::new(),
    };
    tuned.words = words::of(&tuned, plan, capture.frame_count());
    Ok(tuned)
}
