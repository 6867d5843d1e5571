//! Evaluation: how close to the truth the pictures are, and what they cost.
//!
//! ```text
//! SampleSet ─ render at each view ─▶ Picture ─┐
//! View ─────────────────── truth ─▶ Frame ────┴ metrics ─▶ ViewScore … ─▶ Evaluation
//! ```
//!
//! [`sweep`] measures many settings that way, [`stress`] disturbs the capture, [`tune`] picks the simplest setting that is
//! good enough; all hold [`trial`]s against a [`truth`]. [`speed`] measures the stages for themselves, beside the machine's own
//! limits.

pub mod bench;
pub mod chart;
pub mod metrics;
pub mod stress;
pub mod sweep;
pub mod trial;
pub mod truth;
pub mod tune;

use std::sync::Arc;

use serde::Serialize;

use crate::capture::{Camera, Capture, TruthView};
use crate::error::{Error, Result};
use crate::job::Job;
use crate::preprocess;
use crate::render::{Painter, Picture, RenderStats, Renderer, Vantage};
use crate::samples::SampleSet;
use crate::settings::{PruningMethod, RenderSettings, Settings};
use metrics::{FlickerMeter, Pair, Scores};

/// What one view cost and, where its truth is known, how close to it the picture came.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ViewScore {
    /// The view's own name.
    pub file_path: String,
    /// Closeness to the truth; `None` where no pixel of it is known.
    #[serde(flatten)]
    pub scores: Option<Scores>,
    /// Wall-clock milliseconds of painting.
    pub milliseconds: f64,
    /// Samples that were projected.
    pub samples: u64,
    /// What painted.
    #[serde(flatten)]
    pub painter: Painter,
}

/// Means over views.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct MeanScore {
    /// See [`Scores::psnr_db`]; `None` where no view has truth.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub psnr_db: Option<f64>,
    /// See [`Scores::psnr_all_db`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub psnr_all_db: Option<f64>,
    /// See [`Scores::ssim`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ssim: Option<f64>,
    /// See [`Scores::ms_ssim`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ms_ssim: Option<f64>,
    /// See [`Scores::flip`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub flip: Option<f64>,
    /// See [`Scores::silhouette_steps`]; over the views that have silhouettes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub silhouette_steps: Option<f64>,
    /// See [`FlickerMeter::steps`]; `None` where no vantage is seen at two frames.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub flicker_steps: Option<f64>,
    /// See [`Scores::coverage`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub coverage: Option<f64>,
    /// See [`ViewScore::milliseconds`].
    pub milliseconds: f64,
    /// See [`ViewScore::samples`].
    pub samples: f64,
}

/// Scores of several views.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Evaluation {
    /// One by one, in the order of the views.
    pub views: Vec<ViewScore>,
    /// On average.
    pub mean: MeanScore,
    /// Why something else painted than was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub notice: Option<String>,
}

/// Gathers views as they are painted.
#[derive(Debug, Default)]
pub struct Scoreboard {
    views: Vec<ViewScore>,
    flicker: FlickerMeter,
    notice: Option<String>,
}

impl Scoreboard {
    /// Adds what was painted of `view`. Views of one vantage must follow each other for flicker to be seen; see
    /// [`vantage_order`].
    pub fn add(&mut self, view: &TruthView, painted: PaintedView) {
        if let Some(pair) = &painted.pair {
            self.flicker.add(&view.camera, pair);
        }
        self.views.push(painted.score);
        self.notice = self.notice.take().or(painted.notice);
    }

    /// Scores and means of what was painted, and the first notice.
    #[must_use]
    pub fn finish(self) -> Evaluation {
        let views = self.views;
        let mean_score = |value: &dyn Fn(&Scores) -> Option<f64>| {
            mean(views.iter().filter_map(|view| value(view.scores.as_ref()?)))
        };
        let mean = MeanScore {
            psnr_db: mean_score(&|scores| Some(scores.psnr_db)),
            psnr_all_db: mean_score(&|scores| Some(scores.psnr_all_db)),
            ssim: mean_score(&|scores| Some(scores.ssim)),
            ms_ssim: mean_score(&|scores| Some(scores.ms_ssim)),
            flip: mean_score(&|scores| Some(scores.flip)),
            silhouette_steps: mean_score(&|scores| scores.silhouette_steps),
            flicker_steps: self.flicker.steps(),
            coverage: mean_score(&|scores| Some(scores.coverage)),
            milliseconds: mean(views.iter().map(|view| view.milliseconds)).unwrap_or_default(),
            samples: mean(views.iter().map(|view| view.samples as f64)).unwrap_or_default(),
        };
        Evaluation { views, mean, notice: self.notice }
    }
}

/// Indices of the views such that those of one vantage follow each other, each by frame; vantages in the order in which they
/// first come. So flicker is seen with one picture kept, however many vantages there are.
#[must_use]
pub fn vantage_order(views: &[&TruthView]) -> Vec<usize> {
    let mut vantages: Vec<&Camera> = Vec::new();
    let mut order: Vec<(usize, i64, usize)> = Vec::with_capacity(views.len());
    for (index, view) in views.iter().enumerate() {
        let known = vantages.iter().position(|camera| **camera == view.camera);
        let vantage = known.unwrap_or_else(|| {
            vantages.push(&view.camera);
            vantages.len() - 1
        });
        order.push((vantage, view.frame_number, index));
    }
    order.sort_unstable();
    order.into_iter().map(|(.., index)| index).collect()
}

fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (count, sum) = values.fold((0_u32, 0.0), |(count, sum), value| (count + 1, sum + value));
    (count > 0).then(|| sum / f64::from(count))
}

/// A painted view.
#[derive(Debug)]
pub struct PaintedView {
    /// What was painted.
    pub picture: Arc<Picture>,
    /// What it cost, and how close to the truth it came.
    pub score: ViewScore,
    /// The picture beside its truth, where that is known.
    pub pair: Option<Pair>,
    /// The part of [`ViewScore::milliseconds`] that filling holes took.
    pub fill_ms: f64,
    /// Why something else painted it than was asked for.
    pub notice: Option<String>,
}

/// Where the frame of a view is among `frame_numbers`, those of what is called `name`.
///
/// # Errors
/// `Invalid` naming the view where it is not.
pub fn frame_of(view: &TruthView, name: &str, frame_numbers: &[i64]) -> Result<usize> {
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

/// That a view takes no part in the scores.
fn says_nothing(view: &TruthView) -> String {
    format!(
        "view '{}' is left out of the scores: no pixel of its true picture is known, or was seen by a camera",
        view.file_path
    )
}

/// The views whose true picture is there; that others are passed over is told.
fn with_truth<'a>(views: &'a [TruthView], job: &Job) -> Vec<&'a TruthView> {
    let (known, others): (Vec<_>, Vec<_>) = views.iter().partition(|view| view.truth.is_some());
    if let Some(first) = others.first() {
        job.warn(format!(
            "{} of {} views are passed over, '{}' first: their true pictures are missing; put them where the manifest \
             of the views names them",
            others.len(),
            views.len(),
            first.file_path
        ));
    }
    known
}

/// Paints one view and, where its truth is known, scores it. Nothing is kept from one view to the next, so that neither
/// milliseconds nor samples depend on the view before; save for the samples themselves, which a GPU is sent once.
///
/// # Errors
/// `Invalid` naming the view where the set has no such frame or the truth has another size; whatever the truth's
/// file gives; `Cancelled`.
pub fn render_view(
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
        job.warn(says_nothing(view));
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
fn painted(
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

/// Scores the views whose truth is known.
///
/// # Errors
/// As [`render_view`]; `Invalid` where no view has truth; `Gpu` where the settings ask for a GPU and there is none.
pub fn evaluate(
    samples: &Arc<SampleSet>,
    views: &[TruthView],
    settings: &RenderSettings,
    job: &Job,
) -> Result<Evaluation> {
    evaluate_with(&mut Renderer::strict(settings.backend)?, samples, views, settings, job)
}

fn evaluate_with(
    renderer: &mut Renderer,
    samples: &Arc<SampleSet>,
    views: &[TruthView],
    settings: &RenderSettings,
    job: &Job,
) -> Result<Evaluation> {
    let views = with_truth(views, job);
    if views.is_empty() {
        return Err(Error::invalid(
            &samples.name,
            "no view has a true picture to be compared with; name others with --views or hold out a camera",
        ));
    }
    job.start("Scoring views", views.len());
    let mut scores = Scoreboard::default();
    let order = vantage_order(&views);
    // What is set up once is not the first picture's to pay for.
    painted(renderer, samples, views[order[0]], settings, job)?;
    for &index in &order {
        job.check()?;
        scores.add(views[index], render_view(renderer, samples, views[index], settings, job)?);
        job.advance(1);
    }
    Ok(scores.finish().given_back(&order))
}

impl Evaluation {
    /// The same with views where `order`, that in which they were painted, found them.
    #[must_use]
    pub fn given_back(self, order: &[usize]) -> Self {
        let mut views: Vec<(usize, ViewScore)> = order.iter().copied().zip(self.views).collect();
        views.sort_unstable_by_key(|(index, _)| *index);
        Self { views: views.into_iter().map(|(_, score)| score).collect(), ..self }
    }
}

/// One way to prune: what it costs and how close to the truth it stays.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MethodScore {
    /// Name of the pruning method.
    pub method: PruningMethod,
    /// Samples kept.
    pub samples_kept: u64,
    /// Bytes of the kept samples in memory.
    pub bytes_memory: u64,
    /// Bytes of the store.
    pub bytes_store: u64,
    /// How close to the truth.
    #[serde(flatten)]
    pub evaluation: Evaluation,
}

/// The given settings beside the two ends they must be held against.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MethodComparison {
    /// As the settings say.
    pub as_set: MethodScore,
    /// Every sample kept: the most accurate, and the largest.
    pub no_pruning: MethodScore,
    /// The first camera that saw a point keeps it, whatever its sampling rate: what a layered depth image does.
    pub first_camera: MethodScore,
}

/// Scores the given settings, no pruning, and first camera wins. The frames are scanned once. What is painted has been through
/// the file, so that precision given up there shows in the scores.
///
/// # Errors
/// As [`preprocess::preprocess`], [`crate::store::file::write`] and [`evaluate`]; a view at a frame that the capture lacks is told before
/// anything is scanned.
pub fn compare(
    capture: &Capture,
    views: &[TruthView],
    settings: &Settings,
    job: &Job,
) -> Result<MethodComparison> {
    let mut renderer = Renderer::strict(settings.render.backend)?;
    for view in with_truth(views, job) {
        frame_of(view, &capture.name, &capture.frame_numbers)?;
    }
    let scan = preprocess::scan(capture, settings, job)?;
    let mut compared = |method| {
        let mut settings = settings.clone();
        settings.pruning.method = method;
        let pruned = preprocess::prune(capture, &scan, &settings, job)?;
        let trial::FoldSamples { samples, bytes: bytes_store, .. } =
            trial::stored(&pruned.samples, &pruned.report, job)?;
        let evaluation = evaluate_with(&mut renderer, &samples, views, &settings.render, job)?;
        let (samples_kept, bytes_memory) = (samples.sample_count(), samples.bytes());
        Ok(MethodScore { method, samples_kept, bytes_memory, bytes_store, evaluation })
    };
    Ok(MethodComparison {
        as_set: compared(settings.pruning.method)?,
        no_pruning: compared(PruningMethod::Off)?,
        first_camera: compared(PruningMethod::FirstCamera)?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::demo::{Demo, DemoSpec};
    use crate::settings::{Backend, CaptureSettings};

    #[test]
    fn flicker_is_seen_whatever_the_order_of_the_views_and_they_keep_theirs() {
        let spec = DemoSpec::new("orrery").cameras(2).frames(3).size((32, 24));
        let demo = Demo::new(&spec).unwrap();
        let (capture, settings) = (demo.capture(&CaptureSettings::default()), Settings::default());
        let samples = preprocess::preprocess(&capture, &settings, &Job::new()).unwrap().samples;
        let render = RenderSettings { backend: Backend::Cpu, ..settings.render };
        let by_vantage = demo.truth_views();
        let mut by_frame = by_vantage.clone();
        by_frame.sort_by_key(|view| view.frame_number);
        let of = |views: &[TruthView]| evaluate(&samples, views, &render, &Job::new()).unwrap();
        let scored = of(&by_frame);
        assert!(scored.mean.flicker_steps.is_some());
        assert_eq!(scored.mean.flicker_steps, of(&by_vantage).mean.flicker_steps);
        for (view, score) in by_frame.iter().zip(&scored.views) {
            assert_eq!(score.file_path, view.file_path);
        }
    }
}
