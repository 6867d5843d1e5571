//! The cameras that are needed.
//!
//! - With given views, accuracy is measured at these, without the camera. The camera is dropped if the loss surely stays within the
//!   bound of the plan.
//! - Otherwise the camera's own frames are the truth, in full: surfaces that no other camera saw count against dropping it. The camera is
//!   dropped if the others show its frames at most the bound worse than they show held-out cameras on average.
//!
//! Cameras with the fewest samples are tried first. For two cameras alike that is the one whose samples were pruned in favor of the other.

use super::plan::CameraCost;
use super::search::SettingSearch;
use crate::metrics::MAX_PSNR_DB;
use crate::sweep::Point;
use crate::trial::{MeanEstimate, Trial, Workbench};
use crate::truth::{self, Fold, Truth};
use overlook_engine::capture::Capture;
use overlook_engine::error::Result;
use overlook_engine::preprocess;
use overlook_engine::settings::Settings;

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
                let own_db = at_its_own_place(search, capture, &without, &name, &chosen.settings)?;
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

/// Accuracy of what the other cameras make of this one's frames.
fn at_its_own_place(
    search: &SettingSearch<'_>,
    capture: &Capture,
    without: &[String],
    name: &str,
    settings: &Settings,
) -> Result<f64> {
    let (_, views) = truth::split(capture, &[name.to_owned()])?;
    let rest = capture.with_cameras(|_, camera| without.contains(&camera.name));
    let fold =
        Fold { held_out: Some(name.to_owned()), capture: rest, classes: vec![None; views.len()], views };
    let trial = Trial::new(format!("without {name}"), settings.clone());
    let result = Workbench::on(vec![fold], settings).measure(&trial, search.job)?;
    let accuracy: Vec<f64> = result.vantages.iter().flatten().map(|(_, scores)| scores.psnr_all_db).collect();
    // It recorded nothing: dropping it costs nothing.
    Ok(if accuracy.is_empty() { MAX_PSNR_DB } else { MeanEstimate::of(&accuracy).mean })
}
