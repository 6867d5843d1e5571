//! Carries out what concerns sweeps and stress tests.

use super::model::{ChartCommand, Study};
use crate::app::control::overlook_app::OverlookApp;
use crate::app::rooms::frame::model::NoticeKind;
use crate::app::rooms::settings::model::setting_names;
use crate::app::work::StudyRequest;
use overlook_engine::settings::Settings;

/// Changes of settings that a message lists one by one.
const CHANGES: usize = 5;

impl OverlookApp {
    /// Carries out what concerns charts.
    pub(crate) fn apply_to_charts(&mut self, command: ChartCommand) {
        let charts = &mut self.state.doc.charts;
        match command {
            ChartCommand::Study(study) => self.study(study),
            ChartCommand::Axes(axes) => charts.set_axes(axes),
            ChartCommand::Disturbance(name) => charts.disturbance = name,
        }
    }

    /// Measures with the settings on the sliders; goes on from what is known.
    fn study(&mut self, study: Study) {
        let Some(scene) = self.state.doc.scene.clone() else { return };
        if self.state.doc.charts.studying {
            let text = "A sweep or a stress test is under way; let it finish, or stop it (Esc) first.";
            self.state.warn_of_scene("Already measuring", text);
            return;
        }
        let settings = self.state.settings.clone();
        let charts = &mut self.state.doc.charts;
        if !charts.begin(study, &settings) {
            let text = "Everything around these settings is measured; change one to measure around others.";
            self.state.notify(NoticeKind::Done, "Nothing left to measure", text);
            return;
        }
        let (known, known_stress) = (charts.sweep.clone(), charts.known_stress());
        let request = StudyRequest { scene, study, settings, known, known_stress };
        self.workers.study.submit(request);
    }

    /// Applies the settings of a chart's point, and lists what changes.
    pub(crate) fn take_point(&mut self, settings: Settings) {
        let changes = setting_names::changes(&self.state.settings, &settings);
        if changes.is_empty() {
            self.state.notify(NoticeKind::Done, "Already applied", "These are the current settings.");
            return;
        }
        let (told, others) = changes.split_at(changes.len().min(CHANGES));
        let more = if others.is_empty() { String::new() } else { format!("; and {} more", others.len()) };
        let text = format!("{}{more} (Ctrl+Z undoes)", told.join("; "));
        self.change_settings(settings);
        self.state.notify(NoticeKind::Done, "Settings applied", text);
    }

    /// Reports how far a stopped sweep or stress test came.
    pub(crate) fn notify_stopped_study(&mut self) {
        if let Some((title, text)) = self.state.doc.charts.stopped() {
            self.state.notify(NoticeKind::Done, title, text);
        }
    }
}
