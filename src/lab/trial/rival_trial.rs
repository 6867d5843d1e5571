//! A method of others, measured at the views of a fold as ours are.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Instant;

use super::paired::MeanEstimate;
use super::trial_result::{TrialResult, scores_by_vantage};
use crate::metrics::ClassErrors;
use crate::rivals::Rival;
use crate::scoring::{Scoreboard, ViewCost, frame_of, scored};
use crate::truth::{Fold, seen_at};
use overlook_engine::error::{Error, Result};
use overlook_engine::job::Job;
use overlook_engine::median::median;
use overlook_engine::render::fill::fill;
use overlook_engine::render::{Painter, Picture, RenderStats};
use overlook_engine::settings::{Fill, RenderSettings};

/// The measurements of a fold, and the bytes that the method needs for all frames; `None` if it keeps all pictures.
pub(super) struct RivalResult {
    pub(super) result: TrialResult,
    pub(super) bytes: Option<u64>,
}

/// The views of a fold as a method renders them.
struct RenderedViews {
    /// The picture of each view and the milliseconds that it took; `None` for a view that was not rendered.
    pictures: Vec<Option<(Picture, f64)>>,
    /// Frames that have a view; a model was built for each.
    frames: usize,
    /// Bytes of these models; `None` if the method keeps all pictures.
    bytes: Option<u64>,
    /// Seconds that building them took.
    seconds: f64,
}

/// Measures a method at all views of a fold. The size for all frames is estimated from the models of the frames that have a view.
pub(super) fn measure(
    rival: Rival,
    fold: &Fold,
    settings: &RenderSettings,
    job: &Job,
) -> Result<RivalResult> {
    let capture = &fold.capture;
    let RenderedViews { pictures, frames, bytes, seconds } = rendered_views(rival, fold, settings, job)?;
    let (mut scores, mut class_errors, mut times) =
        (Scoreboard::default(), ClassErrors::default(), Vec::new());
    let pixels = capture.pixel_count();
    for ((view, classes), rendered) in fold.views.iter().zip(&fold.classes).zip(pictures) {
        let Some((picture, milliseconds)) = rendered else {
            return Err(Error::invalid(&view.file_path, "was not rendered"));
        };
        times.push(milliseconds);
        let samples = pixels / capture.frame_count().max(1) as u64;
        let stats = RenderStats { samples, milliseconds, ..RenderStats::default() };
        let cost = ViewCost { stats, painter: Painter::cpu(), notice: None };
        let view_score = scored(view, Arc::new(picture), classes.as_deref(), cost, job)?;
        class_errors.add(&view_score.class_errors.unwrap_or_default());
        scores.add(view, view_score);
    }
    let evaluation = scores.finish();
    let per_frame = |sum: u64| sum * capture.frame_count() as u64 / frames.max(1) as u64;
    let bytes = bytes.map(per_frame);
    let result = TrialResult {
        vantages: scores_by_vantage(&fold.views, &evaluation),
        class_errors,
        flicker_steps: evaluation.mean.flicker_steps,
        samples: pixels,
        bytes_memory: bytes.unwrap_or_default(),
        spans: capture.frame_count() as u64,
        milliseconds: median(&mut times).unwrap_or_default(),
        samples_painted: evaluation.mean.samples,
        seconds_preprocess: seconds,
        ..TrialResult::default()
    };
    Ok(RivalResult { result, bytes })
}

/// Builds a model for each frame that has a view, and renders the views of that frame. Only one model is in memory at a time.
fn rendered_views(rival: Rival, fold: &Fold, settings: &RenderSettings, job: &Job) -> Result<RenderedViews> {
    let filling = RenderSettings { fill: Fill::PushPull, ..settings.clone() };
    let capture = &fold.capture;
    let mut by_frame: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (index, view) in fold.views.iter().enumerate() {
        by_frame.entry(frame_of(view, &capture.name, &capture.frame_numbers)?).or_default().push(index);
    }
    job.start(format!("Rendering {}", rival.name()), fold.views.len());
    let mut pictures: Vec<Option<(Picture, f64)>> = vec![None; fold.views.len()];
    let (mut bytes, mut seconds, frames) = (Some(0), 0.0, by_frame.len());
    for (frame, views) in by_frame {
        job.check()?;
        let building = Instant::now();
        let model = rival.build(&seen_at(capture, frame)?)?;
        seconds += building.elapsed().as_secs_f64();
        bytes = bytes.zip(model.bytes()).map(|(sum, bytes): (u64, u64)| sum + bytes);
        for index in views {
            job.check()?;
            let view = &fold.views[index];
            let (camera, started) = (&view.camera, Instant::now());
            let mut picture = model.render(camera);
            let unfilled = started.elapsed();
            fill(&mut picture, camera, &filling);
            let taken = if settings.fill == Fill::None { unfilled } else { started.elapsed() };
            let milliseconds = taken.as_secs_f64() * 1e3;
            view.expose(&mut picture.color);
            pictures[index] = Some((picture, milliseconds));
            job.advance(1);
        }
    }
    Ok(RenderedViews { pictures, frames, bytes, seconds })
}

/// What several folds gave together: means, medians over views, and all vantages.
pub(super) fn over_folds(parts: Vec<TrialResult>) -> TrialResult {
    let mean = |value: &dyn Fn(&TrialResult) -> f64| {
        parts.iter().map(value).sum::<f64>() / parts.len().max(1) as f64
    };
    let mut times: Vec<f64> = parts.iter().map(|part| part.milliseconds).collect();
    let flicker: Vec<f64> = parts.iter().filter_map(|part| part.flicker_steps).collect();
    let mut class_errors = ClassErrors::default();
    for part in &parts {
        class_errors.add(&part.class_errors);
    }
    TrialResult {
        class_errors,
        flicker_steps: (!flicker.is_empty()).then(|| MeanEstimate::of(&flicker).mean),
        samples: mean(&|part| part.samples as f64).round() as u64,
        bytes: mean(&|part| part.bytes as f64).round() as u64,
        bytes_record: mean(&|part| part.bytes_record as f64).round() as u64,
        bytes_memory: mean(&|part| part.bytes_memory as f64).round() as u64,
        spans: parts.first().map_or(0, |part| part.spans),
        milliseconds: median(&mut times).unwrap_or_default(),
        load_of_others: None,
        samples_painted: mean(&|part| part.samples_painted),
        seconds_preprocess: mean(&|part| part.seconds_preprocess),
        samples_shared: 0,
        vantages: parts.into_iter().flat_map(|part| part.vantages).collect(),
    }
}
