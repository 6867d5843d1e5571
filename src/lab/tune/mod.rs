//! The smallest model that is good enough: the simplest setting that surely gives up next to nothing of the best one's accuracy
//! (`choice`), without cameras whose absence costs as little.
//!
//! *Simplest* means fewest bytes, then least work to render, counted in samples and kernels instead of time, so that the same
//! capture gives the same answer.
//!
//! ```text
//! every variation of one setting ─▶ best ─▶ good enough by paired differences ─▶ combine what saves bytes ─▶ cheaper kernel ─▶ cameras
//! ```
//!
//! Apart from that, [`choose_views`] chooses the fewest views that show everything, and [`rank_cameras`] measures what each camera is worth.

mod cameras;
mod choice;
mod plan;
mod search;
mod views;
mod words;

pub use cameras::rank_cameras;
pub use plan::{AT_MOST_DB, CameraCost, CameraWorth, RankPlan, TuneBudget, TunePlan, Tuned};
pub use views::{AddedView, ChosenViews, SHOWN_AT_LEAST, ViewCount, choose_views};

use super::sweep::Point;
use super::truth::Truth;
use overlook_engine::capture::Capture;
use overlook_engine::error::Result;
use overlook_engine::job::Job;
use search::SettingSearch;

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
    let mut search = SettingSearch::new(capture, plan, truth, job, Box::new(on_point))?;
    let chosen = search.choose()?;
    let best = search.best().clone();
    let at_most_db = plan.budget.is_none().then_some(plan.at_most_db);
    let cannot_tell = at_most_db.is_some() && search.cannot_tell();
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
        at_most_db,
        cannot_tell,
        chosen,
        bytes_whole,
        points,
        words: Vec::new(),
    };
    tuned.words = words::of(&tuned, plan, capture.frame_count());
    Ok(tuned)
}
