//! Takes in what pruning and measuring gave, and copies tables.

use std::sync::Arc;

use crate::app::control::OverlookApp;
use crate::app::model::command::WindowCommand;
use crate::app::model::purpose::{Table, TableForm};
use crate::app::model::window::{DockView, NoticeKind};
use crate::app::model::{self, Accuracy, Command, Whole, method_of};
use crate::app::rooms::report::table_text;
use overlook_engine::preprocess::diagnostics::Suspect;
use overlook_engine::preprocess::{PreparedScan, Preprocessed};
use overlook_engine::settings::Settings;

impl OverlookApp {
    /// Takes in a pass over all frames.
    pub(crate) fn scanned(&mut self, scan: Arc<PreparedScan>) {
        let settings = &self.state.settings;
        // Its settings were taken back, and the scan for the settings on the sliders is here already.
        let late =
            !scan.serves(settings) && self.state.doc.scan.as_ref().is_some_and(|scan| scan.serves(settings));
        if !late {
            self.state.doc.scan = Some(scan);
        }
    }

    /// Takes in the samples of the whole capture.
    pub(crate) fn pruned(&mut self, settings: Settings, result: &Preprocessed, read_seconds: Option<f64>) {
        let state = &mut self.state;
        state.doc.read_seconds = read_seconds.or(state.doc.read_seconds);
        // Taken back meanwhile, as in `scanned`.
        if state.is_whole_ready() && method_of(&settings) != method_of(&state.settings) {
            return;
        }
        let report = &result.report;
        for (suspect, warning) in report.suspects() {
            // A notice of its own reports that another reading fits better.
            let is_told = suspect == Suspect::Depth && report.conventions.is_some();
            if is_told && state.why_no_readings().is_none() {
                continue;
            }
            let title = format!("Check the capture: {}", suspect.name().to_lowercase());
            let link = ("Show in Report", Command::Window(WindowCommand::OpenView(DockView::Report)));
            state.notify_with_link(NoticeKind::Warning, &title, model::sentence(&warning), link);
        }
        let line = format!(
            "Pruned the capture: {} of {} kept. {}",
            model::count(report.samples_kept),
            model::count_of(report.samples_in, "sample"),
            model::took(read_seconds, report.seconds)
        );
        state.inspector.log(NoticeKind::Done, line);
        state.doc.accuracy = None;
        let Preprocessed { samples, verdicts, report } = result.clone();
        state.doc.whole = Some(Whole { samples, report: report.into(), verdicts, settings });
    }

    /// Takes in how accurate what is kept is.
    pub(crate) fn measured(&mut self, settings: &Settings, accuracy: Option<Accuracy>) {
        if *settings == self.state.settings {
            self.state.doc.accuracy = accuracy;
        }
    }

    /// Copies a table as text.
    pub(crate) fn copy_table(&mut self, table: Table, form: TableForm) {
        let Some(text) = table_text(table, form, &self.state) else {
            let text = format!("There is no {} yet.", table.name());
            return self.state.warn_of_scene("Nothing to copy", text);
        };
        self.ctx.copy_text(text);
        let text = format!("The {} is on the clipboard as {}.", table.name(), form.name());
        self.state.notify(NoticeKind::Done, "Copied", text);
    }
}
