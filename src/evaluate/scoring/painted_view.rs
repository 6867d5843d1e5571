//! One view, painted and compared with its truth.

use std::sync::Arc;

use super::evaluation::ViewScore;
use crate::capture::TruthView;
use crate::error::{Error, Result};
use crate::evaluate::metrics::Pair;
use crate::job::Job;
use crate::render::{Painter, Picture, RenderStats, Renderer, Vantage};
use crate::samples::SampleSet;
use crate::settings::RenderSettings;

/// A painted view.
#[derive(Debug)]
pub(crate) struct PaintedView {
    /// What was painted.
    pub(crate) picture: Arc<Picture>,
    /// What it cost, and how close to the truth it came.
    pub(crate) score: ViewScore,
    /// The picture beside its truth, where that is known.
    pub(crate) pair: Option<Pair>,
    /// The part of [`ViewScore::milliseconds`] that filling holes took.
    pub(crate) fill_ms: f64,
    /// A notice if another renderer than requested was used.
    pub(crate) notice: Option<String>,
}

/// Index of the frame of a view among `frame_numbers`, which belong to the capture or store `name`.
pub(crate) fn frame_of(view: &TruthView, name: &str, frame_numbers: &[i64]) -> Result<usize> {
    frame_numbers.binary_search(&view.frame_number).map_err(|_| {
        let frames = match frame_numbers {
            [] => "none".to_owned(),
            [first, .., last] => format!("{} frames from {first} to {last}", frame_numbers.len()),
            [only] => format!("frame {only} alone"),
        };
        Error::invalid(
            format!("view '{}'", view.file_path),
            format!("there is no frame {}; '{name}' has {frames}", view.frame_number),
        )
    })
}

/// The warning that a view is not scored.
pub(crate) fn no_known_pixel(view: &TruthView) -> String {
    format!(
        "view '{}' is left out of the scores: no pixel of its true picture is known, or was seen by a camera",
        view.file_path
    )
}

/// Renders one view and, where its truth is known, scores it. No background is kept from the view before, so milliseconds and
/// samples do not depend on it; only the samples stay on a GPU.
pub(crate) fn render_view(
    renderer: &mut Renderer,
    samples: &Arc<SampleSet>,
    view: &TruthView,
    settings: &RenderSettings,
    job: &Job,
) -> Result<PaintedView> {
    let place = || format!("view '{}'", view.file_path);
    let (picture, stats) = painted(renderer, samples, view, settings, job)?;
    let pair = match &view.truth {
        None => None,
        Some(truth) => Some(Pair::new(&picture, &truth()?).map_err(|error| match error {
            Error::Invalid { what, .. } => Error::invalid(place(), what),
            error => error,
        })?),
    };
    if pair.as_ref().is_some_and(|pair| !pair.has_truth()) {
        job.warn(no_known_pixel(view));
    }
    let score = ViewScore {
        file_path: view.file_path.clone(),
        scores: pair.as_ref().filter(|pair| pair.has_truth()).map(Pair::scores),
        milliseconds: stats.milliseconds,
        samples: stats.samples,
        painter: renderer.painter().cloned().unwrap_or_else(Painter::cpu),
    };
    let notice = renderer.notice().map(str::to_owned);
    Ok(PaintedView { picture, score, pair, fill_ms: stats.fill_ms, notice })
}

/// The picture of a view, with nothing kept from the view before.
pub(super) fn painted(
    renderer: &mut Renderer,
    samples: &Arc<SampleSet>,
    view: &TruthView,
    settings: &RenderSettings,
    job: &Job,
) -> Result<(Arc<Picture>, RenderStats)> {
    let frame = frame_of(view, &samples.name, &samples.frame_numbers)?;
    let vantage = Vantage { camera: view.camera.clone(), frame };
    renderer.forget_background();
    renderer.render(samples, &vantage, settings, job)
}
