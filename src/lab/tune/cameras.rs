//! The cameras that are needed, and what the model would be without each.
//!
//! - With given views, accuracy is measured at these, without the camera. The camera is dropped if the loss surely stays within the
//!   bound of the plan.
//! - Otherwise the camera's own frames are the truth, in full: surfaces that no other camera saw count against dropping it. The camera is
//!   dropped if the others show its frames at most the bound worse than they show held-out cameras on average.
//!
//! Cameras with the fewest samples are tried first. For two cameras alike that is the one whose samples were pruned in favor of the other.

use super::plan::{CameraCost, CameraWorth, RankPlan};
use super::search::SettingSearch;
use super::views::shown_alone;
use crate::metrics::{MAX_PSNR_DB, Scores};
use crate::sweep::Point;
use crate::trial::{MeanEstimate, TimeLeft, Trial, TrialResult, Workbench};
use crate::truth::{self, Fold, Recorded, Truth};
use overlook_engine::alignment::{self, Alignment};
use overlook_engine::capture::Capture;
use overlook_engine::edits;
use overlook_engine::error::{Error, Result};
use overlook_engine::job::Job;
use overlook_engine::preprocess;
use overlook_engine::settings::{AlignSettings, Settings};

/// Measures what the model would be without each camera; `on_camera` receives each that is not known, in the capture's order, and how
/// many are known, of how many.
///
/// # Errors
/// Those of edits, preprocessing, rendering and truth; `Invalid` for a single camera; `Cancelled`: put the cameras received so far into
/// [`RankPlan::done`] to continue.
pub fn rank_cameras(
    capture: &Capture,
    plan: &RankPlan,
    truth: &Truth,
    job: &Job,
    mut on_camera: impl FnMut(&CameraWorth, (usize, usize)),
) -> Result<()> {
    let left = edits::with_cameras_left(capture, &plan.edits)?;
    if left.cameras.len() < 2 {
        return Err(Error::invalid(&capture.name, "its only camera cannot be left out"));
    }
    let aligned = alignment::align(&left, &plan.settings.align, job)?;
    let capture = &edits::without_removed_pixels(
        &aligned.capture,
        &plan.edits,
        plan.settings.capture.edited_cache_bytes(),
    );
    // All cameras together corrected the rig; fewer must not correct it again.
    let settings = Settings { align: AlignSettings::OFF, ..plan.settings.clone() };
    let alone = shown_alone(capture, job)?;
    let mut all = with_all_cameras(capture, aligned.alignment.as_ref(), truth, &settings, job)?;
    let whole = all.measure(&Trial::new("all cameras", settings.clone()), job)?;
    let (total, mut known, mut time_left) = (capture.cameras.len(), plan.done.len(), TimeLeft::start(None));
    for (camera, seen_alone) in capture.cameras.iter().zip(alone) {
        if plan.done.iter().any(|known| known.name == camera.name) {
            continue;
        }
        time_left.next(job, known + 1, total, total - known);
        known += 1;
        let others = capture.cameras.iter().map(|other| other.name.clone());
        let without: Vec<String> = others.filter(|other| *other != camera.name).collect();
        let (result, loss_db) = match truth {
            Truth::Views(_) => {
                let cameras = Some(without);
                let trial = Trial { cameras, ..Trial::new("without a camera", settings.clone()) };
                let result = all.measure(&trial, job)?;
                let loss_db = accuracy(&whole) - accuracy(&result);
                (result, Some(loss_db))
            }
            Truth::HoldOut => {
                let own = at_its_own_place(capture, &without, &camera.name, &settings, job)?;
                (own, None)
            }
        };
        let worth = CameraWorth {
            name: camera.name.clone(),
            seen_alone,
            psnr_filled_db: accuracy(&result),
            loss_db,
            samples_less: whole.samples as i64 - result.samples as i64,
            bytes_less: whole.bytes as i64 - result.bytes as i64,
        };
        on_camera(&worth, (known, total));
    }
    job.set_context("");
    Ok(())
}

/// What measures a corrected capture with all its cameras, at the true views as the correction moves them.
fn with_all_cameras(
    capture: &Capture,
    alignment: Option<&Alignment>,
    truth: &Truth,
    settings: &Settings,
    job: &Job,
) -> Result<Workbench> {
    if let Truth::Views(views) = truth {
        let views = Truth::Views(truth::views_as_taken(alignment, views));
        return Workbench::new(&Recorded::undisturbed(capture), &views, settings, job);
    }
    let of = Fold { held_out: None, capture: capture.clone(), classes: Vec::new(), views: Vec::new() };
    Ok(Workbench::on(vec![of], settings))
}

/// Mean accuracy over all vantages, dB. Where nothing was recorded, nothing is lost.
fn accuracy(result: &TrialResult) -> f64 {
    let of_vantage = |views: &Vec<_>| views.iter().map(psnr_all_db).collect();
    let vantages: Vec<Vec<f64>> = result.vantages.iter().map(of_vantage).collect();
    if vantages.iter().all(Vec::is_empty) { MAX_PSNR_DB } else { MeanEstimate::over_vantages(&vantages).mean }
}

fn psnr_all_db((_, scores): &(String, Scores)) -> f64 {
    scores.psnr_all_db
}

/// Names of the cameras to keep, and the cost of each that was left out on trial.
pub(super) fn drop_needless(
    search: &mut SettingSearch<'_>,
    capture: &Capture,
    chosen: &Point,
) -> Result<(Vec<String>, Vec<CameraCost>)> {
    let mut kept: Vec<String> = capture.cameras.iter().map(|camera| camera.name.clone()).collect();
    let mut costs = Vec::new();
    let limit_db = search.best().psnr_filled_db - search.at_most_db();
    for name in by_samples(search, capture, &chosen.settings)? {
        if kept.len() == 1 {
            break;
        }
        let without: Vec<String> = kept.iter().filter(|other| **other != name).cloned().collect();
        let (psnr_filled_db, dropped) = match search.truth {
            Truth::Views(_) => {
                let trial = Trial {
                    cameras: Some(without.clone()),
                    ..Trial::new(
                        format!("without {}", dropped_from(capture, &without)),
                        chosen.settings.clone(),
                    )
                };
                let point = search.measure(&trial)?;
                (point.psnr_filled_db, search.is_good_enough(&point))
            }
            Truth::HoldOut => {
                let own = at_its_own_place(capture, &without, &name, &chosen.settings, search.job)?;
                let own: Vec<f64> = own.vantages.iter().flatten().map(psnr_all_db).collect();
                // It recorded nothing: dropping it costs nothing.
                let own_db = if own.is_empty() { MAX_PSNR_DB } else { MeanEstimate::of(&own).mean };
                (own_db, own_db >= limit_db)
            }
        };
        if dropped {
            kept = without;
        }
        costs.push(CameraCost { name, psnr_filled_db, dropped });
    }
    Ok((kept, costs))
}

fn dropped_from(capture: &Capture, without: &[String]) -> String {
    let gone = capture.cameras.iter().map(|camera| &camera.name).filter(|name| !without.contains(name));
    gone.cloned().collect::<Vec<_>>().join(" and ")
}

/// Names of the cameras, those that keep the fewest samples first; of equals the last first.
fn by_samples(search: &SettingSearch<'_>, capture: &Capture, settings: &Settings) -> Result<Vec<String>> {
    let samples = preprocess::preprocess(capture, settings, search.job)?.samples;
    let mut counts = vec![0; capture.cameras.len()];
    for image in &samples.images {
        counts[image.camera as usize] += image.len();
    }
    let mut order: Vec<usize> = (0..counts.len()).collect();
    order.sort_by_key(|&camera| (counts[camera], std::cmp::Reverse(camera)));
    Ok(order.into_iter().map(|camera| capture.cameras[camera].name.clone()).collect())
}

/// What the other cameras make of this one's frames.
fn at_its_own_place(
    capture: &Capture,
    without: &[String],
    name: &str,
    settings: &Settings,
    job: &Job,
) -> Result<TrialResult> {
    let (_, views) = truth::split(capture, &[name.to_owned()])?;
    let rest = capture.with_cameras(|_, camera| without.contains(&camera.name));
    let fold =
        Fold { held_out: Some(name.to_owned()), capture: rest, classes: vec![None; views.len()], views };
    Workbench::on(vec![fold], settings).measure(&Trial::new(format!("without {name}"), settings.clone()), job)
}
