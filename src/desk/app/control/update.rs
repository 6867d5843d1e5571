//! Carries out commands. Here, in the rooms and where answers are taken in are the only places where the state changes.

use crate::app::control::overlook_app::OverlookApp;
use crate::app::model::{Command, StoppableWork};
use crate::app::rooms::files::model::FileCommand;
use crate::app::rooms::frame::model::WindowCommand;
use crate::app::rooms::live::model::ViewHistory;
use crate::app::rooms::pixel::model::PixelCommand;
use crate::app::rooms::timeline::model::TimeCommand;
use crate::app::work::Workers;
use crate::app::work::slot::AnySlot;

impl OverlookApp {
    /// Carries out one command.
    pub(crate) fn apply(&mut self, command: Command) {
        self.state.timeline.plays_once_open &= only_looks(&command);
        let left = ViewHistory::is_jump(&command).then(|| self.state.live.orbit.clone()).flatten();
        match command {
            Command::File(command) => self.apply_to_files(command),
            Command::Settings(command) => self.apply_to_settings(command),
            Command::Time(command) => self.apply_to_time(command),
            Command::Source(command) => self.apply_to_source(command),
            Command::View(command) => self.apply_to_view(command),
            Command::Pixel(command) => self.apply_to_pixel(command),
            Command::Path(command) => self.apply_to_path(command),
            Command::Compare(command) => self.apply_to_comparison(command),
            Command::Chart(command) => self.apply_to_charts(command),
            Command::Reading(command) => self.apply_to_readings(command),
            Command::Edit(command) => self.apply_to_edits(command),
            Command::Share(command) => self.apply_to_share(command),
            Command::Window(command) => self.apply_to_window(command),
            Command::Display(display) => self.state.display = display,
            Command::CopyTable(table, form) => self.copy_table(table, form),
            Command::Undo => self.undo_or_redo(true),
            Command::Redo => self.undo_or_redo(false),
            Command::Recompute => {
                self.state.doc.stopped = false;
                self.state.doc.failed_frame = None;
                self.state.doc.changed_at = None;
                let Workers { inspect, whole, source, measure, .. } = &self.workers;
                [inspect as &dyn AnySlot, whole, source, measure].into_iter().for_each(AnySlot::forget);
            }
            Command::Cancel => self.cancel(),
            Command::Escape => self.escape(),
            Command::LogFrameTimes => {
                if let Some(times) = std::mem::take(&mut self.state.inspector.meter).summary() {
                    log::info!("frame times, {times}");
                }
            }
        }
        if let Some(left) = left.filter(|left| self.state.live.orbit.as_ref() != Some(left)) {
            self.state.doc.views.left(left);
        }
        // Whichever camera or key the view was taken to, what is up stays.
        let up = self.state.up_in_world();
        if let Some(orbit) = &mut self.state.live.orbit {
            orbit.set_up(up);
        }
    }

    /// Stops the work that the line at the bottom names, and nothing beside it.
    fn cancel(&mut self) {
        let Some(work) = self.state.busy.first().map(|busy| busy.work) else { return };
        let workers = &self.workers;
        match work {
            StoppableWork::Open => workers.open.cancel(),
            StoppableWork::Whole => {
                workers.whole.stop();
                self.state.doc.stopped |= !self.state.is_whole_ready();
            }
            StoppableWork::File => workers.file.cancel(),
            StoppableWork::Export => workers.export.cancel(),
            StoppableWork::Study => workers.study.cancel(),
            StoppableWork::Compare => {
                workers.compare.worker.cancel();
                let text = "It was stopped; choose what to compare again.";
                self.state.doc.compare_error = Some(text.to_owned());
            }
            StoppableWork::Measure => workers.measure.worker.cancel(),
        }
        self.refresh_busy();
    }

    fn escape(&mut self) {
        let inspector = &mut self.state.inspector;
        let was_open = inspector.palette.take().is_some()
            | inspector.naming.take().is_some()
            | inspector.help.take().is_some()
            | inspector.closing.asks
            | self.state.doc.readings.is_open
            | self.state.doc.charts.question.take().is_some()
            | self.state.open_after_question.take().is_some();
        inspector.closing.asks = false;
        self.state.doc.readings.is_open = false;
        if was_open
            || self.state.typed_path.take().is_some()
            || std::mem::take(&mut self.state.share.is_open)
            || self.state.notices.pop().is_some()
        {
            return;
        }
        self.state.doc.edits.draft = None;
        if self.state.doc.edits.tools.tool.take().is_some() || self.state.doc.edits.selection.take().is_some()
        {
            return;
        }
        if self.state.live.ruler.active {
            self.state.live.ruler.measure(false);
            return;
        }
        if self.state.doc.path.playing.take().is_some() || self.state.look.maximized.take().is_some() {
            return;
        }
        let is_cancellable = self.state.busy.iter().any(|busy| busy.cancellable);
        if self.state.doc.probe.pinned && !is_cancellable {
            self.apply(Command::Pixel(PixelCommand::Pin(false)));
        } else {
            self.cancel();
        }
    }
}

/// Whether a command only looks around, so that a scene that was about to move still may.
fn only_looks(command: &Command) -> bool {
    match command {
        Command::View(_) | Command::Display(_) | Command::Pixel(PixelCommand::Probe(_)) => true,
        Command::Time(command) => matches!(command, TimeCommand::Change(_)),
        Command::Window(command) => !matches!(
            command,
            WindowCommand::InterfaceSize(_)
                | WindowCommand::Dismiss(_)
                | WindowCommand::Palette(_)
                | WindowCommand::Help(_)
        ),
        Command::File(command) => matches!(command, FileCommand::Introduced | FileCommand::RoomExplained),
        _ => false,
    }
}
