//! Sweeps and stress tests: run on a lane, points drawn as they come.

use std::sync::Arc;

use super::super::message::Message;
use super::super::scene::{Content, Scene};
use super::super::worker::Outbox;
use crate::capture::Capture;
use crate::error::{Error, Result};
use crate::evaluate::stress::{self, StressPoint};
use crate::evaluate::sweep::{self, Point, Series};
use crate::evaluate::truth::Truth;
use crate::job::Job;
use crate::settings::Settings;

/// What is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Study {
    /// Accuracy against cost, over many settings.
    Sweep,
    /// Accuracy against the size of a disturbance.
    Stress,
}

/// A quantity along an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Quantity {
    /// Closeness to the truth, dB.
    Psnr,
    /// Structural similarity.
    Ssim,
    /// Perceived difference.
    Flip,
    /// Share of true pixels that got a sample.
    Coverage,
    /// Bytes of the store.
    Bytes,
    /// Samples kept.
    Samples,
    /// Milliseconds of painting a view.
    Milliseconds,
    /// Seconds of preprocessing.
    Seconds,
}

impl Quantity {
    /// Every quantity: name, and whether its axis is logarithmic.
    pub(crate) const ALL: [(Self, &'static str, bool); 8] = [
        (Self::Psnr, "PSNR, dB", false),
        (Self::Ssim, "SSIM", false),
        (Self::Flip, "FLIP", false),
        (Self::Coverage, "Coverage", false),
        (Self::Bytes, "Bytes", true),
        (Self::Samples, "Samples", true),
        (Self::Milliseconds, "Milliseconds", true),
        (Self::Seconds, "Seconds", true),
    ];

    /// Its name.
    pub(crate) fn name(self) -> &'static str {
        Self::ALL.iter().find(|(of, ..)| *of == self).map_or("", |(_, name, _)| name)
    }

    /// Its value, as its axis shows it.
    pub(crate) fn of(self, point: &Point) -> f64 {
        let value = match self {
            Self::Psnr => point.psnr_filled_db,
            Self::Ssim => point.ssim,
            Self::Flip => point.flip,
            Self::Coverage => point.coverage,
            Self::Bytes => point.bytes as f64,
            Self::Samples => point.samples as f64,
            Self::Milliseconds => point.milliseconds,
            Self::Seconds => point.seconds_preprocess,
        };
        if self.is_log() { value.max(1e-3).log10() } else { value }
    }

    /// Whether its axis is logarithmic.
    pub(crate) fn is_log(self) -> bool {
        Self::ALL.iter().any(|(of, _, log)| *of == self && *log)
    }
}

/// What was measured, and how it is shown.
pub(crate) struct Charts {
    /// Points of the sweep, as they came.
    pub sweep: Vec<Point>,
    /// Points of the stress test, as they came.
    pub stress: Vec<StressPoint>,
    /// The disturbance that is shown.
    pub disturbance: String,
    /// Along and up.
    pub axes: [Quantity; 2],
    /// Whether something is being measured.
    pub studying: bool,
}

impl Default for Charts {
    fn default() -> Self {
        Self {
            sweep: Vec::new(),
            stress: Vec::new(),
            disturbance: String::new(),
            axes: [Quantity::Bytes, Quantity::Psnr],
            studying: false,
        }
    }
}

impl Charts {
    /// Adds a point and marks anew which no other beats.
    pub(crate) fn add(&mut self, point: Point) {
        self.sweep.push(point);
        sweep::mark_pareto_of_stores(&mut self.sweep);
    }

    /// The point that shows what these settings give.
    pub(crate) fn of(&self, settings: &Settings) -> Option<&Point> {
        self.sweep.iter().find(|point| settings_alone(point) == Some(settings))
    }
}

/// The settings that give a point; `None` where samples were thinned or cameras left out besides, so that they do not.
pub(crate) fn settings_alone(point: &Point) -> Option<&Settings> {
    let more_was_done = matches!(
        point.series,
        Series::Random | Series::VoxelGrid | Series::FirstCameraAtCount | Series::SingleCamera
    );
    (!more_was_done).then_some(&point.settings)
}

/// What a sweep of the window starts from: the sliders, wherever they stand.
const START: &str = "settings it started from";

/// Name of a series in the window.
pub(crate) fn series_name(series: Series) -> &'static str {
    if series == Series::Reference { START } else { series.name() }
}

/// Name of a point in the window.
pub(crate) fn point_name(point: &Point) -> String {
    point
        .label
        .strip_prefix("default, ")
        .map_or_else(|| point.label.clone(), |kernel| format!("{START}, {kernel}"))
}

/// What to measure.
pub(crate) struct StudyRequest {
    /// What is open, a capture.
    pub scene: Arc<Scene>,
    /// What is measured.
    pub study: Study,
    /// The settings to start from.
    pub settings: Settings,
    /// What is known of the sweep already.
    pub known: Vec<Point>,
}

/// Measures; every point is told as it comes.
///
/// # Errors
/// `Invalid` for a store; whatever measuring gives; `Cancelled`.
pub(crate) fn study(request: StudyRequest, outbox: &Outbox, job: &Job) -> Result<Message> {
    let scene = request.scene.clone();
    let Content::Capture { capture, truth } = &scene.content else {
        return Err(Error::invalid(
            &scene.name,
            "a store holds no source frames to measure against; open its capture",
        ));
    };
    let known = truth.iter().any(|view| view.truth.is_some());
    if !known && capture.cameras.len() < 2 {
        return Err(Error::invalid(
            &scene.name,
            "there is no truth to measure against, and its only camera cannot be left out; record a second camera, or \
             true pictures with a novel/transforms.json beside it",
        ));
    }
    let truth = if known { Truth::Views(truth.clone()) } else { Truth::HoldOut };
    match request.study {
        Study::Sweep => run_sweep(&scene, capture, &truth, request, outbox, job)?,
        Study::Stress => run_stress(&scene, capture, &truth, &request, outbox, job)?,
    }
    Ok(Message::Studied)
}

fn run_sweep(
    scene: &Scene,
    capture: &Capture,
    truth: &Truth,
    request: StudyRequest,
    outbox: &Outbox,
    job: &Job,
) -> Result<()> {
    let mut plan = sweep::Plan::standard(&request.settings, capture);
    plan.done = request.known;
    sweep::run(capture, &plan, truth, job, |point, _| {
        outbox.send(Message::Swept { scene: scene.id, point: Box::new(point.clone()) });
    })?;
    Ok(())
}

fn run_stress(
    scene: &Scene,
    capture: &Capture,
    truth: &Truth,
    request: &StudyRequest,
    outbox: &Outbox,
    job: &Job,
) -> Result<()> {
    let mut plan = stress::Plan::standard(&request.settings);
    plan.frames = Some(FRAMES);
    stress::run(capture, &plan, truth, job, |point, _| {
        outbox.send(Message::Stressed { scene: scene.id, point: Box::new(point.clone()) });
    })?;
    Ok(())
}

/// Frames that a stress test in the window looks at: enough for what moves to move.
const FRAMES: usize = 8;

#[cfg(test)]
mod tests {
    use super::super::super::scene::Origin;
    use super::*;
    use crate::capture::demo::{Demo, DemoSpec};
    use crate::evaluate::trial::{Measured, Trial};

    fn spec(cameras: usize) -> DemoSpec {
        DemoSpec {
            scene: "orrery".into(),
            cameras: Some(cameras),
            frames: Some(2),
            size: Some((16, 12)),
            noise: None,
        }
    }

    #[test]
    fn what_a_sweep_starts_from_is_not_called_the_defaults() {
        let mut settings = Settings::default();
        settings.pruning.depth_tolerance = 2.0;
        let capture = Demo::new(&spec(2)).unwrap().capture(&settings.capture);
        for planned in sweep::Plan::standard(&settings, &capture).trials {
            let point = Point::new(&planned.trial, planned.series, &Measured::default());
            assert!(!series_name(point.series).contains("default"), "{:?}", point.series);
            assert!(!point_name(&point).contains("default"), "{}", point.label);
        }
    }

    #[test]
    fn samples_that_were_thinned_are_not_what_their_settings_give() {
        let settings = Settings::default();
        let mut charts = Charts::default();
        for series in [Series::Random, Series::SingleCamera, Series::NoPruning, Series::VoxelGrid] {
            charts.add(Point::new(
                &Trial::new(series.name(), settings.clone()),
                series,
                &Measured::default(),
            ));
        }
        assert_eq!(charts.of(&settings).map(|point| point.series), Some(Series::NoPruning));
    }

    #[test]
    fn a_single_camera_without_truth_is_not_measured_and_one_line_says_what_to_do() {
        let settings = Settings::default();
        let capture = Demo::new(&spec(1)).unwrap().capture(&settings.capture);
        let scene = Arc::new(Scene::of_capture(Origin::Demo("orrery".into()), capture, Vec::new(), 1.0));
        let (sender, _inbox) = std::sync::mpsc::sync_channel(8);
        let outbox = Outbox::new(sender, egui::Context::default());
        for study in [Study::Sweep, Study::Stress] {
            let request =
                StudyRequest { scene: scene.clone(), study, settings: settings.clone(), known: Vec::new() };
            let Err(error) = super::study(request, &outbox, &Job::new()) else { panic!("it was measured") };
            assert!(error.to_string().contains("record a second camera"), "{error}");
            assert!(!error.to_string().contains('\n'), "{error}");
        }
    }
}
