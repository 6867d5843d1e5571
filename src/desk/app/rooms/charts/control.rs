//! Carries out what concerns charts, and what is measured for them.

use crate::app::control::OverlookApp;
use crate::app::model;
use crate::app::model::Command;
use crate::app::model::command::{ChartCommand, WindowCommand};
use crate::app::model::window::NoticeKind;
use crate::app::rooms::charts::sheet;
use crate::app::rooms::charts::state::{Study, StudyQuestion, to_measure};
use crate::app::work::StudyRequest;
use overlook_engine::settings::Settings;

/// Changes of settings that a message lists one by one.
const CHANGES: usize = 5;

impl OverlookApp {
    pub(crate) fn apply_to_charts(&mut self, command: ChartCommand) {
        let charts = &mut self.state.doc.charts;
        match command {
            ChartCommand::Ask(study) => {
                charts.question = None;
                if let Some(study) = study {
                    self.ask_what_to_measure(study);
                }
            }
            ChartCommand::Choose(study, choice) => {
                charts.choose(study, *choice);
                self.ask_what_to_measure(study);
            }
            ChartCommand::Study(study) => self.study(study),
            ChartCommand::Axes(axes) => charts.set_axes(axes),
            ChartCommand::Disturbance(name) => charts.disturbance = name,
            ChartCommand::Toggle(study, series) => charts.toggle(study, series),
            ChartCommand::DialScale(scale) => charts.dial_scale = scale,
            ChartCommand::Copy(study) => match sheet(study, &self.state) {
                Some(chart) => self.draw_chart(study.chart_name(), chart),
                None => self.state.warn_of_scene("Nothing to copy", study.no_chart()),
            },
            ChartCommand::CloseRanking => charts.hides_ranking = true,
        }
    }

    /// Asks what to measure, and says how much that is.
    fn ask_what_to_measure(&mut self, study: Study) {
        let Some(scene) = self.state.doc.scene.clone() else { return };
        let (capture, truth) = match to_measure(&scene) {
            Ok(measured) => measured,
            Err(error) => return self.state.warn_of_scene("Nothing to measure", error.to_string()),
        };
        let (charts, settings) = (&mut self.state.doc.charts, &self.state.settings);
        let measurements = charts.plan(study, settings, capture).open(capture, &truth);
        let groups = study.groups(settings, capture);
        charts.question = Some(StudyQuestion { study, groups, measurements });
    }

    /// Measures what is chosen with the settings on the sliders; goes on from what is known.
    fn study(&mut self, study: Study) {
        let Some(scene) = self.state.doc.scene.clone() else { return };
        if matches!(study, Study::Tuning | Study::Ranking) {
            // What it finds is no point of a chart that is looked for by itself.
            self.apply(Command::Window(WindowCommand::OpenView(study.view())));
        }
        self.state.doc.charts.hides_ranking &= study != Study::Ranking;
        let capture = match to_measure(&scene) {
            Ok((capture, _)) => capture,
            Err(error) => return self.state.warn_of_scene("Nothing to measure", error.to_string()),
        };
        if self.state.doc.charts.studying {
            let text = "Another measurement is under way; let it finish, or stop it (Esc) first.";
            self.state.warn_of_scene("Already measuring", text);
            return;
        }
        let (doc, settings) = (&mut self.state.doc, &self.state.settings);
        if study == Study::Ranking {
            doc.charts.rank_with(&doc.edits.list);
        }
        if !doc.charts.begin(study, settings) {
            if study == Study::Ranking {
                return;
            }
            let text =
                "Everything that is chosen is measured around these settings; choose more, or change one.";
            self.state.notify(NoticeKind::Done, "Nothing left to measure", text);
            return;
        }
        let plan = doc.charts.plan(study, settings, capture);
        self.workers.study.submit(StudyRequest { scene: scene.clone(), plan });
    }

    /// Applies the settings of a chart's point, and lists what changes.
    pub(crate) fn take_point(&mut self, settings: Settings) {
        let changes = model::setting_names::changes(&self.state.settings, &settings);
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

    /// Takes in that a study is done, or that its time is over with so many measurements left.
    pub(crate) fn studied(&mut self, left: usize) {
        if left == 0 {
            self.state.doc.charts.complete();
        }
        self.refresh_busy();
        if left > 0 {
            self.notify_stopped_study();
        }
    }

    /// Reports how far a stopped study came.
    pub(crate) fn notify_stopped_study(&mut self) {
        if let Some((title, text)) = self.state.doc.charts.stopped() {
            self.state.notify(NoticeKind::Done, title, text);
        }
    }
}
