//! Sweeps and stress tests.

use crate::app::model::Message;
use crate::app::rooms::charts::model::{Study, to_measure};
use crate::app::work::outbox::Outbox;
use crate::app::work::requests::StudyRequest;
use overlook_engine::error::Result;
use overlook_engine::job::Job;
use overlook_lab::stress::{self, StressPoint};
use overlook_lab::sweep::{self, Point};

/// Measures, and sends every point as it comes.
pub(crate) fn study(request: StudyRequest, outbox: &Outbox, job: &Job) -> Result<Message> {
    let StudyRequest { scene, study, settings, choice, known, known_stress } = request;
    let (capture, truth) = to_measure(&scene)?;
    let left = match study {
        Study::Sweep => {
            let mut plan = choice.sweep_plan(&settings, capture);
            plan.done = known;
            let of = plan.trials.len();
            let tell = |point: &Point, known| {
                let point = Box::new(point.clone());
                outbox.send(Message::Swept { scene: scene.id, point, known: (known, of) });
            };
            sweep::run(capture, &plan, &truth, job, tell)?.left
        }
        Study::Stress => {
            let mut plan = choice.stress_plan(&settings);
            plan.done = known_stress;
            let tell = |point: &StressPoint, known| {
                let point = Box::new(point.clone());
                outbox.send(Message::Stressed { scene: scene.id, point, known });
            };
            stress::run(capture, &plan, &truth, job, tell)?.left
        }
    };
    Ok(Message::Studied { scene: scene.id, left })
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::app::model::{OpenScene, SceneSource};
    use crate::app::rooms::charts::model::StudyChoice;
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
                choice: StudyChoice::default(),
                known: Vec::new(),
                known_stress: Vec::new(),
            };
            let Err(error) = super::study(request, &outbox, &Job::new()) else { panic!("it was measured") };
            assert!(error.to_string().contains("record a second camera"), "{error}");
            assert!(!error.to_string().contains('\n'), "{error}");
        }
    }
}
