//! Views, rendered and compared with their truth, and their scores.

use std::sync::Arc;

use serde::Serialize;

use crate::metrics::{ClassErrors, ClassMap, ErrorByClass, Pair, Scores};
use overlook_engine::capture::{Frame, TruthView};
use overlook_engine::error::{Error, Result};
use overlook_engine::job::Job;
use overlook_engine::plural::counted;
use overlook_engine::render::{Painter, Picture, RenderStats, Renderer, Vantage};
use overlook_engine::samples::SampleSet;
use overlook_engine::settings::RenderSettings;

/// How close a picture comes to the truth once the view is aligned.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct AlignedScore {
    /// See [`Scores::psnr_db`](crate::metrics::Scores::psnr_db).
    pub psnr_db: f64,
    /// See [`Scores::psnr_all_db`](crate::metrics::Scores::psnr_all_db).
    pub psnr_all_db: f64,
    /// See [`Scores::ssim`](crate::metrics::Scores::ssim).
    pub ssim: f64,
    /// Angle by which the view was turned, degrees.
    pub degrees: f64,
    /// How far it was moved, in the capture's unit.
    pub distance: f64,
    /// Red, green and blue were multiplied by two to the power of this.
    pub stops: [f64; 3],
}

/// What one view cost and, where its truth is known, how close to it the picture came.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ViewScore {
    /// The view's own name.
    pub file_path: String,
    /// Closeness to the truth; `None` where no pixel of it is known.
    #[serde(flatten)]
    pub scores: Option<Scores>,
    /// Closeness once the view is aligned by its own true picture; `None` if it was not aligned.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub aligned: Option<AlignedScore>,
    /// Error by class; `None` if the truth has no depth, or if it is unknown what the cameras saw.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error_by_class: Option<ErrorByClass>,
    /// Wall-clock milliseconds of painting, and of filling holes where the settings fill.
    pub milliseconds: f64,
    /// Samples that were projected.
    pub samples: u64,
    /// What painted.
    #[serde(flatten)]
    pub painter: Painter,
}

/// Means over views.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct MeanScore {
    /// See [`Scores::psnr_db`]; `None` where no view has truth.
    pub psnr_db: Option<f64>,
    /// See [`AlignedScore::psnr_db`]; `None` where views were not aligned.
    pub psnr_aligned_db: Option<f64>,
    /// See [`Scores::psnr_all_db`].
    pub psnr_all_db: Option<f64>,
    /// See [`Scores::ssim`].
    pub ssim: Option<f64>,
    /// See [`Scores::ms_ssim`].
    pub ms_ssim: Option<f64>,
    /// See [`Scores::flip`].
    pub flip: Option<f64>,
    /// See [`Scores::silhouette_steps`]; over the views that have silhouettes.
    pub silhouette_steps: Option<f64>,
    /// Root mean square change of error from frame to frame, 8-bit steps; `None` where no vantage is seen at two frames.
    pub flicker_steps: Option<f64>,
    /// See [`Scores::coverage`].
    pub coverage: Option<f64>,
    /// See [`ViewScore::error_by_class`]; over all pixels of all views together.
    pub error_by_class: Option<ErrorByClass>,
    /// See [`ViewScore::milliseconds`].
    pub milliseconds: f64,
    /// See [`ViewScore::samples`].
    pub samples: f64,
}

/// Scores of several views.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Evaluation {
    /// One by one, in the order of the views.
    pub views: Vec<ViewScore>,
    /// On average.
    pub mean: MeanScore,
    /// A notice if another renderer than requested was used.
    pub notice: Option<String>,
}

impl Evaluation {
    /// These scores with the views in their given order; `order` is that in which they were rendered.
    #[must_use]
    pub fn in_order_of_views(self, order: &[usize]) -> Self {
        let mut views: Vec<(usize, ViewScore)> = order.iter().copied().zip(self.views).collect();
        views.sort_unstable_by_key(|(index, _)| *index);
        Self { views: views.into_iter().map(|(_, score)| score).collect(), ..self }
    }
}

/// A rendered view.
#[derive(Debug)]
pub struct PaintedView {
    pub picture: Arc<Picture>,
    /// What it cost, and how close to the truth it came.
    pub score: ViewScore,
    /// The picture beside its truth, where that is known.
    pub(crate) pair: Option<Pair>,
    /// Error by class.
    pub(crate) class_errors: Option<ClassErrors>,
    /// The part of [`ViewScore::milliseconds`] that filling holes took.
    pub(crate) fill_ms: f64,
    /// A notice if another renderer than requested was used.
    pub notice: Option<String>,
}

/// Index of the frame of a view among `frame_numbers`, which belong to the capture or store `name`.
///
/// # Errors
///
/// `Invalid` where the view's frame is not among them.
pub fn frame_of(view: &TruthView, name: &str, frame_numbers: &[i64]) -> Result<usize> {
    frame_numbers.binary_search(&view.frame_number).map_err(|_| {
        let frames = match frame_numbers {
            [] => "none".to_owned(),
            [first, .., last] => format!("{} from {first} to {last}", counted(frame_numbers.len(), "frame")),
            [only] => format!("frame {only} alone"),
        };
        Error::invalid(
            format!("view '{}'", view.file_path),
            format!("there is no frame {}; '{name}' has {frames}", view.frame_number),
        )
    })
}

/// The warning that a view is not scored.
pub(crate) fn unknown_truth_warning(view: &TruthView) -> String {
    format!(
        "view '{}' is left out of the scores: no pixel of its true picture is known, or was seen by a camera",
        view.file_path
    )
}

/// Renders one view and, where its truth is known, scores it, by class of error where `classes` are known. No background is kept
/// from the view before, so that milliseconds and samples do not depend on it; only the samples stay on a GPU.
///
/// # Errors
///
/// `Gpu` if the requested graphics card fails; those of reading the truth's files; `Cancelled`.
pub fn render_view(
    renderer: &mut Renderer,
    samples: &Arc<SampleSet>,
    view: &TruthView,
    classes: Option<&ClassMap>,
    settings: &RenderSettings,
    job: &Job,
) -> Result<PaintedView> {
    let (picture, stats) = painted(renderer, samples, view, settings, job)?;
    let cost = ViewCost {
        stats,
        painter: renderer.painter().cloned().unwrap_or_else(Painter::cpu),
        notice: renderer.notice().map(str::to_owned),
    };
    scored(view, picture, classes, cost, job)
}

/// What painting a view took.
pub(crate) struct ViewCost {
    pub(crate) stats: RenderStats,
    pub(crate) painter: Painter,
    /// See [`PaintedView::notice`].
    pub(crate) notice: Option<String>,
}

/// Scores the picture of a view where its truth is known.
pub(crate) fn scored(
    view: &TruthView,
    picture: Arc<Picture>,
    classes: Option<&ClassMap>,
    cost: ViewCost,
    job: &Job,
) -> Result<PaintedView> {
    let truth = view.truth.as_ref().map(|load| load()).transpose()?;
    let beside = |truth: &Frame| {
        Pair::new(&picture, truth).map_err(|error| match error {
            Error::Invalid { what, .. } => Error::invalid(format!("view '{}'", view.file_path), what),
            error => error,
        })
    };
    let pair = truth.as_ref().map(beside).transpose()?;
    let class_errors = truth.zip(classes).map(|(truth, classes)| ClassErrors::of(&picture, &truth, classes));
    if pair.as_ref().is_some_and(|pair| !pair.has_truth()) {
        job.warn(unknown_truth_warning(view));
    }
    let score = ViewScore {
        file_path: view.file_path.clone(),
        scores: pair.as_ref().filter(|pair| pair.has_truth()).map(Pair::scores),
        aligned: None,
        error_by_class: class_errors.as_ref().and_then(ClassErrors::scores),
        milliseconds: cost.stats.milliseconds,
        samples: cost.stats.samples,
        painter: cost.painter,
    };
    let (fill_ms, notice) = (cost.stats.stages.fill_ms, cost.notice);
    Ok(PaintedView { picture, score, pair, class_errors, fill_ms, notice })
}

/// The picture of a view, exposed as the view was, with nothing kept from the view before.
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
    let (mut picture, stats) = renderer.render(samples, &vantage, settings, job)?;
    if view.gain != [1.0; 3] {
        view.expose(&mut Arc::make_mut(&mut picture).color);
    }
    Ok((picture, stats))
}
