//! Which cameras are needed: one is dropped if the others reproduce what it saw as accurately as any held-out view.
//!
//! With given views, accuracy is measured there, without the camera. Otherwise the camera's own frames are the truth, in full:
//! what no other camera saw counts against dropping it. Cameras with the fewest samples are tried first: of two alike, that is
//! the one whose samples were pruned in favor of the other.

use super::plan::CameraCost;
use super::search::Search;
use crate::capture::Capture;
use crate::error::Result;
use crate::evaluate::metrics::{MAX_PSNR_DB, Scores};
use crate::evaluate::scoring::evaluate;
use crate::evaluate::sweep::Point;
use crate::evaluate::trial::{MeanEstimate, Trial, stored};
use crate::evaluate::truth::{self, Truth};
use crate::preprocess;
use crate::settings::{Fill, RenderSettings, Settings};

/// Names of the cameras to keep, and the cost of each that was left out on trial.
pub(super) fn drop_needless(
    search: &mut Search<'_>,
    capture: &Capture,
    chosen: &Point,
) -> Result<(Vec<String>, Vec<CameraCost>)> {
    let mut kept: Vec<String> = capture.cameras.iter().map(|camera| camera.name.clone()).collect();
    let mut costs = Vec::new();
    let limit_db = search.limit_db();
    for name in by_samples(search, capture, &chosen.settings)? {
        if kept.len() == 1 {
            break;
        }
        let without: Vec<String> = kept.iter().filter(|other| **other != name).cloned().collect();
        let psnr_filled_db = match search.truth {
            Truth::Views(_) => {
                let trial = Trial {
                    cameras: Some(without.clone()),
                    ..Trial::new(
                        format!("without {}", dropped_from(capture, &without)),
                        chosen.settings.clone(),
                    )
                };
                search.measure(&trial)?.psnr_filled_db
            }
            Truth::HoldOut => at_its_own_place(search, capture, &without, &name, &chosen.settings)?,
        };
        let dropped = psnr_filled_db >= limit_db;
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
fn by_samples(search: &Search<'_>, capture: &Capture, settings: &Settings) -> Result<Vec<String>> {
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
    search: &Search<'_>,
    capture: &Capture,
    without: &[String],
    name: &str,
    settings: &Settings,
) -> Result<f64> {
    let (_, views) = truth::split(capture, &[name.to_owned()])?;
    let rest = capture.with_cameras(|_, camera| without.contains(&camera.name));
    let pruned = preprocess::preprocess(&rest, settings, search.job)?;
    let samples = stored(&pruned.samples, &pruned.report, search.job)?.samples;
    let filling = RenderSettings { fill: Fill::PushPull, ..settings.render.clone() };
    let evaluation = evaluate(&samples, &views, &filling, search.job)?;
    let scores: Vec<Scores> = evaluation.views.iter().filter_map(|view| view.scores).collect();
    if scores.is_empty() {
        // It recorded nothing: dropping it costs nothing.
        return Ok(MAX_PSNR_DB);
    }
    Ok(MeanEstimate::of(&scores.iter().map(|scores| scores.psnr_all_db).collect::<Vec<_>>()).mean)
}
