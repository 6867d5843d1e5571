//! What pruning cost: PSNR of the kept samples at vantages whose truth is known, beside that of all samples.

use std::sync::Arc;

use super::lanes::MeasureRequest;
use super::message::Accuracy;
use super::scene::Content;
use crate::capture::{Frame, View};
use crate::error::Result;
use crate::evaluate::metrics;
use crate::job::Job;
use crate::preprocess::{self, SampleSet};
use crate::render::{CpuRenderer, Vantage};
use crate::settings::{PruningMethod, Settings};

/// Vantages that are compared: enough for a figure in passing, few enough to take seconds.
const VIEWS: usize = 3;

/// Compares at up to [`VIEWS`] vantages spread over those with truth; `None` where there is no truth.
///
/// # Errors
/// Whatever loading the truth and rendering give, and `Cancelled`.
pub(super) fn measure(request: &MeasureRequest, job: &Job) -> Result<Option<Accuracy>> {
    let Content::Capture { capture, truth, .. } = &request.scene.content else { return Ok(None) };
    let known: Vec<(&View, usize)> = truth
        .iter()
        .filter(|view| view.truth.is_some())
        .filter_map(|view| Some((view, capture.frame_index(view.frame_number)?)))
        .collect();
    let step = known.len().div_ceil(VIEWS).max(1);
    let mut all_settings = request.settings.clone();
    all_settings.pruning.method = PruningMethod::Off;
    let (mut pruned_db, mut unpruned_db, mut views) = (0.0, 0.0, 0);
    job.start("Measuring accuracy", known.len().div_ceil(step));
    for (view, frame) in known.into_iter().step_by(step) {
        job.check()?;
        let Some(load) = &view.truth else { continue };
        let truth = load()?;
        let unpruned =
            preprocess::inspect_frame(capture, Some(&request.scan), &all_settings, frame, job)?.samples;
        let vantage = Vantage { camera: view.camera.clone(), frame };
        pruned_db += psnr_at(&request.samples, &vantage, &truth, &request.settings, job)?;
        unpruned_db += psnr_at(&unpruned, &vantage, &truth, &request.settings, job)?;
        views += 1;
        job.advance(1);
    }
    if views == 0 {
        return Ok(None);
    }
    let mean = |sum: f64| sum / views as f64;
    Ok(Some(Accuracy { psnr_db: mean(pruned_db), unpruned_psnr_db: mean(unpruned_db), views }))
}

fn psnr_at(
    samples: &Arc<SampleSet>,
    vantage: &Vantage,
    truth: &Frame,
    settings: &Settings,
    job: &Job,
) -> Result<f64> {
    let (picture, _) = CpuRenderer::new().render(samples, vantage, &settings.render, job)?;
    Ok(metrics::score(&picture, truth)?.psnr_db)
}
