//! What charts show is measured here.

use std::sync::Arc;

use crate::app::model::{Accuracy, Content, Message, OpenScene, Same, State};
use crate::app::rooms::charts::state::{Found, StudyPlan, to_measure};
use crate::app::work::requests::StudyRequest;
use crate::app::work::worker::{Outbox, Wanted};
use overlook_engine::capture::TruthView;
use overlook_engine::error::Result;
use overlook_engine::job::Job;
use overlook_engine::preprocess::{self, PreparedScan};
use overlook_engine::render::{CpuRenderer, Vantage};
use overlook_engine::samples::SampleSet;
use overlook_engine::settings::{MixedPixels, PruningMethod, Settings, SpanLevels};
use overlook_lab::metrics;
use overlook_lab::stress::{self, StressPoint};
use overlook_lab::sweep::{self, Point};
use overlook_lab::truth::views_as_taken;
use overlook_lab::tune;

/// Vantages that are compared: enough for a figure in passing, few enough to take seconds.
const VIEWS: usize = 3;

/// Samples to compare with the truth.
#[derive(Clone, PartialEq)]
pub(crate) struct MeasureRequest {
    /// The scene, a capture.
    pub scene: Arc<OpenScene>,
    /// What was kept.
    pub samples: Same<SampleSet>,
    /// The scan with the corrections of the rig; `None` while it is under way.
    pub scan: Option<Same<PreparedScan>>,
    pub settings: Settings,
}

impl Wanted for MeasureRequest {
    fn wanted(state: &State) -> Option<Self> {
        let (scene, whole) = (state.doc.scene.as_ref()?, state.doc.whole.as_ref()?);
        (!state.is_stale() && !state.timeline.playing).then(|| Self {
            scene: scene.clone(),
            samples: Same(whole.samples.clone()),
            scan: state.doc.scan.clone().map(Same),
            settings: state.settings.clone(),
        })
    }
}

/// Compares at up to [`VIEWS`] vantages spread over those with truth; `None` without truth.
pub(crate) fn measure(request: &MeasureRequest, job: &Job) -> Result<Option<Accuracy>> {
    let Content::Capture { capture, truth, .. } = &request.scene.content else { return Ok(None) };
    let scan = request.scan.as_deref().map(|scan| &**scan);
    let capture = scan.map_or(&**capture, PreparedScan::capture);
    let truth = views_as_taken(scan.and_then(PreparedScan::alignment), truth);
    let known: Vec<(&TruthView, usize)> = truth
        .iter()
        .filter(|view| view.truth.is_some())
        .filter_map(|view| Some((view, capture.frame_index(view.frame_number)?)))
        .collect();
    let step = known.len().div_ceil(VIEWS).max(1);
    let all_settings = with_nothing_pruned(&request.settings);
    let (mut pruned_db, mut unpruned_db, mut views) = (0.0, 0.0, 0);
    job.start("Measuring accuracy", known.len().div_ceil(step));
    for (view, frame) in known.into_iter().step_by(step) {
        job.check()?;
        let Some(load) = &view.truth else { continue };
        let (truth, vantage) = (load()?, Vantage { camera: view.camera.clone(), frame });
        let psnr_db = |samples: &Arc<SampleSet>| -> Result<f64> {
            let painted = CpuRenderer::new().render(samples, &vantage, &request.settings.render, job)?;
            let (mut picture, _) = painted;
            view.expose(&mut Arc::make_mut(&mut picture).color);
            Ok(metrics::score(&picture, &truth)?.psnr_db)
        };
        let unpruned = preprocess::inspect_frame(capture, None, &all_settings, frame, job)?.samples;
        pruned_db += psnr_db(&request.samples)?;
        unpruned_db += psnr_db(&unpruned)?;
        views += 1;
        job.advance(1);
    }
    if views == 0 {
        return Ok(None);
    }
    let mean = |sum: f64| sum / views as f64;
    Ok(Some(Accuracy { psnr_db: mean(pruned_db), unpruned_psnr_db: mean(unpruned_db), views }))
}

/// Settings that keep every pixel of a frame as it was recorded.
pub(crate) fn with_nothing_pruned(settings: &Settings) -> Settings {
    let mut settings = settings.clone();
    settings.pruning.method = PruningMethod::Off;
    settings.pruning.mixed_pixels = MixedPixels::Keep;
    settings.spans.levels = SpanLevels::Off;
    settings
}

/// Measures, and sends every point as it comes.
pub(crate) fn study(request: StudyRequest, outbox: &Outbox, job: &Job) -> Result<Message> {
    let StudyRequest { scene, plan } = request;
    let (capture, truth) = to_measure(&scene)?;
    let tell = |found: Found, known| {
        outbox.send(Message::Found { scene: scene.id, found: Box::new(found), known });
    };
    let left = match plan {
        StudyPlan::Sweep(plan) => {
            let of = plan.trials.len();
            let tell = |point: &Point, known| tell(Found::Sweep(point.clone()), (known, of));
            sweep::run(capture, &plan, &truth, job, tell)?.left
        }
        StudyPlan::Stress(plan) => {
            let tell = |point: &StressPoint, known| tell(Found::Stress(point.clone()), known);
            stress::run(capture, &plan, &truth, job, tell)?.left
        }
        StudyPlan::Tuning(mut plan) => {
            let (mut count, of) = (plan.done.len(), plan.done.len() + plan.open());
            let tuned = tune::run(capture, &plan, &truth, job, |point| {
                count += 1;
                tell(Found::Tuning(point.clone()), (count, of.max(count)));
            })?;
            plan.done.clone_from(&tuned.points);
            outbox.send(Message::Tuned { scene: scene.id, tuned: Box::new(tuned) });
            plan.open()
        }
        StudyPlan::Ranking(plan) => {
            tune::rank_cameras(capture, &plan, &truth, job, |camera, known| {
                tell(Found::Ranking(camera.clone()), known);
            })?;
            0
        }
    };
    Ok(Message::Studied { scene: scene.id, left })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::model::SceneSource;
    use crate::app::rooms::charts::state::{Charts, Study};
    use overlook_engine::demo::{Demo, DemoSpec};

    #[test]
    fn a_single_camera_without_truth_is_not_measured_and_one_line_says_what_to_do() {
        let settings = Settings::default();
        let spec = DemoSpec::new("orrery").cameras(1).frames(2).size((16, 12));
        let capture = Demo::new(&spec).unwrap().capture(&settings.capture);
        let scene =
            Arc::new(OpenScene::of_capture(SceneSource::Demo("orrery".into()), capture, Vec::new(), 1.0));
        let (sender, _inbox) = std::sync::mpsc::sync_channel(8);
        let outbox = Outbox::new(sender, egui::Context::default());
        for study in [Study::Sweep, Study::Stress, Study::Tuning, Study::Ranking] {
            let plan = Charts::default().plan(study, &settings, scene.capture().unwrap());
            let request = StudyRequest { scene: scene.clone(), plan };
            let Err(error) = super::study(request, &outbox, &Job::new()) else { panic!("it was measured") };
            assert!(error.to_string().contains("record a second camera"), "{error}");
            assert!(!error.to_string().contains('\n'), "{error}");
        }
    }
}
