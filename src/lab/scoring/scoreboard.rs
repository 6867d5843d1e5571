//! Many views, painted in an order that shows flicker.

use std::collections::HashMap;
use std::sync::Arc;

use super::view::{Evaluation, MeanScore, PaintedView, ViewScore, painted, render_view};
use crate::metrics::{ClassErrors, ClassMap, FlickerMeter, Scores};
use overlook_engine::capture::{Camera, TruthView};
use overlook_engine::error::{Error, Result};
use overlook_engine::job::Job;
use overlook_engine::plural::{counted, either};
use overlook_engine::render::{Picture, Renderer};
use overlook_engine::samples::SampleSet;
use overlook_engine::settings::RenderSettings;

/// Gathers views as they are painted.
#[derive(Debug, Default)]
pub struct Scoreboard {
    views: Vec<ViewScore>,
    flicker: FlickerMeter,
    class_errors: ClassErrors,
    notice: Option<String>,
}

impl Scoreboard {
    /// Adds a view. Flicker is measured between consecutive views of one vantage; see [`vantage_order`].
    pub fn add(&mut self, view: &TruthView, painted: PaintedView) {
        if let Some(pair) = &painted.pair {
            self.flicker.add(&view.camera, pair);
        }
        if let Some(errors) = &painted.class_errors {
            self.class_errors.add(errors);
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
            psnr_aligned_db: None,
            psnr_all_db: mean_score(&|scores| Some(scores.psnr_all_db)),
            ssim: mean_score(&|scores| Some(scores.ssim)),
            ms_ssim: mean_score(&|scores| Some(scores.ms_ssim)),
            flip: mean_score(&|scores| Some(scores.flip)),
            silhouette_steps: mean_score(&|scores| scores.silhouette_steps),
            flicker_steps: self.flicker.steps(),
            coverage: mean_score(&|scores| Some(scores.coverage)),
            error_by_class: self.class_errors.scores(),
            milliseconds: mean(views.iter().map(|view| view.milliseconds)).unwrap_or_default(),
            samples: mean(views.iter().map(|view| view.samples as f64)).unwrap_or_default(),
        };
        Evaluation { views, mean, notice: self.notice }
    }
}

/// Indices of the views, those of one vantage together and by frame, so that flicker needs one earlier picture in memory.
/// Vantages are in the order of their first view.
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

/// The views with a true picture; a warning names the others.
pub(crate) fn with_truth<'a>(views: &'a [TruthView], job: &Job) -> Vec<&'a TruthView> {
    let (known, others): (Vec<_>, Vec<_>) = views.iter().partition(|view| view.truth.is_some());
    if let Some(first) = others.first() {
        let (missing, all, first) = (others.len(), views.len(), &first.file_path);
        job.warn(format!(
            "{missing} of {} {} passed over, '{first}' first: the true picture is missing; put it where the manifest of the views \
             names it",
            counted(all, "view"),
            either(missing, "is", "are")
        ));
    }
    known
}

/// That nothing can be measured on what is called `name`.
pub(crate) fn nothing_to_compare(name: &str) -> Error {
    Error::invalid(
        name,
        "no view has a true picture to be compared with; name others with --views, or leave cameras out",
    )
}

/// Scores the views whose truth is known.
///
/// # Errors
/// `Invalid` if no view has truth, a frame is missing or a size differs; `Gpu` if the settings need a GPU and there is none;
/// `Cancelled`; those of loading the truth.
pub fn evaluate(
    samples: &Arc<SampleSet>,
    views: &[TruthView],
    settings: &RenderSettings,
    job: &Job,
) -> Result<Evaluation> {
    let mut renderer = Renderer::strict(settings.backend)?;
    evaluate_each(&mut renderer, samples, views, &[], settings, job, &mut |_, _, _| Ok(()))
}

/// Takes each rendered view, its picture, and the classes of its error where they are known.
pub(crate) type OnPicture<'a> = dyn FnMut(&TruthView, &Picture, Option<&ClassMap>) -> Result<()> + 'a;

/// As [`evaluate()`], also by class of error. `classes` has the classes of each view, in the order of the views, and is empty if none are
/// known; `on_picture` receives each picture.
pub(crate) fn evaluate_each(
    renderer: &mut Renderer,
    samples: &Arc<SampleSet>,
    views: &[TruthView],
    classes: &[Option<Arc<ClassMap>>],
    settings: &RenderSettings,
    job: &Job,
    on_picture: &mut OnPicture<'_>,
) -> Result<Evaluation> {
    let classes: HashMap<&str, &ClassMap> = views
        .iter()
        .zip(classes)
        .filter_map(|(view, classes)| Some((view.file_path.as_str(), classes.as_deref()?)))
        .collect();
    let views = with_truth(views, job);
    if views.is_empty() {
        return Err(nothing_to_compare(&samples.name));
    }
    job.start("Scoring views", views.len());
    let mut scores = Scoreboard::default();
    let order = vantage_order(&views);
    // An uncounted run first: setup is not part of the first time.
    painted(renderer, samples, views[order[0]], settings, job)?;
    for &index in &order {
        job.check()?;
        let view = views[index];
        let classes = classes.get(view.file_path.as_str()).copied();
        let painted = render_view(renderer, samples, view, classes, settings, job)?;
        on_picture(view, &painted.picture, classes)?;
        scores.add(view, painted);
        job.advance(1);
    }
    Ok(scores.finish().in_order_of_views(&order))
}

#[cfg(test)]
mod tests {
    use super::*;
    use overlook_engine::demo::{Demo, DemoSpec};
    use overlook_engine::settings::{Backend, CaptureSettings, Settings};

    #[test]
    fn flicker_is_seen_whatever_the_order_of_the_views_and_they_keep_theirs() {
        let spec = DemoSpec::new("orrery").cameras(2).frames(3).size((32, 24));
        let demo = Demo::new(&spec).unwrap();
        let (capture, settings) = (demo.capture(&CaptureSettings::default()), Settings::default());
        let samples =
            overlook_engine::preprocess::preprocess(&capture, &settings, &Job::new()).unwrap().samples;
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
