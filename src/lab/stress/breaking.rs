//! Where each method fails under each disturbance, and what it shows there.

use serde::{Deserialize, Serialize};

use super::measure::Disturbed;
use super::plan::{StressPlan, StressPoint};
use crate::trial::{ShownView, Trial, ViewAccuracy};
use crate::truth::Truth;
use overlook_engine::capture::Capture;
use overlook_engine::error::Result;
use overlook_engine::job::Job;

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
pub struct BreakingView {
    pub disturbance: String,
    /// The first value of the dial at which 1 dB is lost, or the last one.
    pub dial: f64,
    pub unit: String,
    /// Over all views.
    pub loss_db: f64,
    /// At the view that loses most.
    pub shown: ShownView,
}

/// The first method of a plan at the breaking point of each disturbance.
///
/// # Errors
/// As [`run`](super::run).
pub fn breaking_views(
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
pub fn distinct<T: PartialEq>(values: impl Iterator<Item = T>) -> Vec<T> {
    values.fold(Vec::new(), |mut distinct, value| {
        if !distinct.contains(&value) {
            distinct.push(value);
        }
        distinct
    })
}
