//! Sweeps and stress tests.

use crate::app::model::{Content, Message};
use crate::app::rooms::charts::model::Study;
use crate::app::work::requests::StudyRequest;
use crate::app::work::worker::Outbox;
use overlook_engine::error::{Error, Result};
use overlook_engine::job::Job;
use overlook_lab::stress;
use overlook_lab::sweep;
use overlook_lab::truth::Truth;

/// Measures, and sends every point as it comes.
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
        Study::Sweep => {
            let mut plan = sweep::SweepPlan::standard(&request.settings, capture);
            plan.done = request.known;
            let of = plan.trials.len();
            sweep::run(capture, &plan, &truth, job, |point, known| {
                let point = Box::new(point.clone());
                outbox.send(Message::Swept { scene: scene.id, point, known: (known, of) });
            })?;
        }
        Study::Stress => {
            let mut plan = stress::StressPlan::standard(&request.settings).with_rivals(&request.settings);
            plan.frames = Some(FRAMES);
            plan.done = request.known_stress;
            stress::run(capture, &plan, &truth, job, |point, known| {
                outbox.send(Message::Stressed { scene: scene.id, point: Box::new(point.clone()), known });
            })?;
        }
    }
    Ok(Message::Studied)
}

/// Frames that a stress test in the window looks at: enough for what moves to move.
const FRAMES: usize = 8;

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::app::model::{OpenScene, SceneSource};
    use overlook_engine::demo::{Demo, DemoSpec};
    use overlook_engine::settings::Settings;

    #[test]
    fn a_single_camera_without_truth_is_not_measured_and_one_line_says_what_to_do() {
        let settings = Settings::default();
        let spec = DemoSpec::new("orrery").cameras(1).frames(2).size((16, 12));
        let capture = Demo::new(&spec).unwrap().capture(&settings.capture);
        let scene =
            Arc::new(OpenScene::of_capture(SceneSource::Demo("orrery".into()), capture, Vec::new(), 1.0));
        let (sender, _inbox) = std::sync::mpsc::sync_channel(8);
        let outbox = Outbox::new(sender, egui::Context::default());
        for study in [Study::Sweep, Study::Stress] {
            let request = StudyRequest {
                scene: scene.clone(),
                study,
                settings: settings.clone(),
                known: Vec::new(),
                known_stress: Vec::new(),
            };
            let Err(error) = super::study(request, &outbox, &Job::new()) else { panic!("it was measured") };
            assert!(error.to_string().contains("record a second camera"), "{error}");
            assert!(!error.to_string().contains('\n'), "{error}");
        }
    }
}
