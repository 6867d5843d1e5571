//! Carries out commands, and takes in the answers of the workers. Here and in the rooms are the only places where the state changes.

use egui::TextureOptions;

use crate::app::control::OverlookApp;
use crate::app::model::command::{FileCommand, PixelCommand, WindowCommand};
use crate::app::model::{Command, Message, WorkKind};
use crate::app::rooms::timeline::TimeCommand;
use crate::app::work::Workers;
use crate::app::work::worker::AnySlot;
use overlook_engine::error::Error;

impl OverlookApp {
    /// Carries out one command.
    pub(crate) fn apply(&mut self, command: Command) {
        self.state.timeline.plays_once_open &= only_looks(&command);
        let left = command.is_jump().then(|| self.state.live.orbit.clone()).flatten();
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
        }
        if let Some(left) = left.filter(|left| self.state.live.orbit.as_ref() != Some(left)) {
            self.state.doc.views.left(left);
        }
        // Whichever camera or key the view was taken to, what is up stays.
        let up = self.state.up_in_world();
        if let Some(orbit) = &mut self.state.live.orbit {
            orbit.up_in_world = up;
        }
    }

    /// Stops the work that the line at the bottom names, and nothing beside it.
    fn cancel(&mut self) {
        let Some(work) = self.state.busy.first().map(|busy| busy.work) else { return };
        let workers = &self.workers;
        match work {
            WorkKind::Open => workers.open.cancel(),
            WorkKind::Prune => {
                workers.whole.stop();
                self.state.doc.stopped |= !self.state.is_whole_ready();
            }
            WorkKind::File => workers.file.cancel(),
            WorkKind::Export => workers.export.cancel(),
            WorkKind::Study => workers.study.cancel(),
            WorkKind::Compare => {
                workers.compare.worker.cancel();
                let text = "It was stopped; choose what to compare again.";
                self.state.doc.compare_error = Some(text.to_owned());
            }
            WorkKind::MeasureAccuracy => workers.measure.worker.cancel(),
            _ => {}
        }
        self.refresh_busy();
    }

    fn escape(&mut self) {
        let inspector = &mut self.state.inspector;
        let was_open = inspector.palette.take().is_some()
            | inspector.help.take().is_some()
            | std::mem::take(&mut inspector.closing.asks)
            | std::mem::take(&mut self.state.doc.readings.is_open)
            | self.state.doc.charts.question.take().is_some()
            | self.state.open_after_question.take().is_some();
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

    /// Takes in one answer, unless it is about a scene that is no longer open.
    pub(crate) fn receive(&mut self, message: Message) {
        let current = self.state.doc.scene.as_ref().map(|scene| scene.id);
        if message.scene().is_some_and(|scene| Some(scene) != current) {
            return;
        }
        let Self { state, ctx, .. } = self;
        match message {
            Message::Opened { scene, session } => self.opened(&scene, session.as_deref()),
            Message::Scanned { scan, .. } => self.scanned(scan),
            Message::Pruned { settings, result, read_seconds, .. } => {
                self.pruned(settings, &result, read_seconds);
            }
            Message::Inspected { inspected, .. } => self.inspected(inspected),
            Message::ChangePainted { request, pictures } => self.change_painted(&request, pictures),
            Message::SourcePainted { key, picture } => self.source_painted(key, picture),
            Message::LivePainted { key, picture } => self.live_painted(key, picture),
            Message::LiveCarried { carried, key } => self.live_carried(&key.to, carried),
            Message::Measured { settings, accuracy, .. } => self.measured(&settings, accuracy),
            Message::Probed { spot, probed, is_hole, .. } => self.probed(spot, probed, is_hole),
            Message::Thumbnails { pictures, .. } => {
                let textures =
                    pictures.into_iter().map(|it| ctx.load_texture("thumbnail", it, TextureOptions::LINEAR));
                state.doc.thumbs = textures.collect();
            }
            Message::Histograms { histograms, .. } => state.doc.histograms = histograms,
            Message::ValuesCounted { values, .. } => state.doc.values = Some(values),
            Message::Compared { key, outcome } => self.compared(&key, outcome),
            Message::MemoryMapped { cameras, .. } => state.doc.memory = Some(cameras),
            Message::Saved { path, bytes, holds } => self.saved(&path, bytes, holds),
            Message::Found { found, known, .. } => state.doc.charts.add(*found, known),
            Message::Tuned { tuned, .. } => state.doc.charts.tuned = Some(tuned),
            Message::Studied { left, .. } => self.studied(left),
            Message::Drawn { image, name, width_mm } => self.drawn(image, &name, width_mm),
            Message::Exported { path, exported } => self.exported(&path, &exported),
            Message::PathSaved { path, saved } => self.path_saved(&path, saved),
            Message::PathLoaded { path, file, .. } => self.path_loaded(&path, &file),
            Message::PicturesOpened { folder, .. } => self.pictures_opened(folder),
            Message::Edited { key, edited } => self.edited(*key, edited),
            Message::SessionSaved { path, keys, list } => self.session_saved(&path, keys, list),
            Message::EditsSaved { path, list } => self.edits_saved(&path, list),
            Message::EditsLoaded { path, list, .. } => self.edits_loaded(&path, list),
            Message::SettingsLoaded { path, settings } => self.settings_loaded(&path, settings),
            Message::PathChosen { purpose, path } => self.path_chosen(purpose, path),
            Message::PathChecked { purpose, path, taken } => self.path_checked(purpose, path, taken),
            Message::ReadingsChecked { finding, .. } => self.readings_checked(finding),
            Message::ReadingsShown { images, .. } => self.readings_shown(images),
            Message::Stopped { title, text } => self.stopped_writing(title, text),
            Message::SizesMeasured { facts, .. } => state.share.facts = Some(facts),
            Message::SharePreviewed { key, preview } => self.share_previewed(key, preview),
            Message::Failed { work, error } => self.failed(work, &error),
            // Nobody sees it, or the system shows it.
            Message::Prepared | Message::FolderShown => {}
        }
    }

    /// Updates whether something is being opened or measured: superseded work sends no message of its end.
    pub(crate) fn refresh_busy(&mut self) {
        if self.workers.open.is_idle() {
            self.state.opening = None;
        }
        self.state.doc.charts.studying = !self.workers.study.is_idle();
    }

    fn failed(&mut self, work: WorkKind, error: &Error) {
        if matches!(work, WorkKind::Open | WorkKind::Study) {
            self.refresh_busy();
        }
        if matches!(error, Error::Cancelled) {
            if work == WorkKind::Study {
                self.notify_stopped_study();
            }
            return;
        }
        match work {
            WorkKind::Prune if self.workers.whole.worker.is_idle() => self.state.doc.stopped = true,
            WorkKind::InspectFrame if self.workers.inspect.worker.is_idle() => {
                self.state.doc.failed_frame = self.workers.inspect.asked().map(|request| request.frame);
                // Nothing goes on from here by itself.
                self.state.doc.stopped |= self.state.doc.inspected.is_none();
            }
            _ => {}
        }
        if !self.failed_in_dialog(work, error) {
            self.state.notify_of_failure(work.failure(), error);
        }
        self.type_again(work, error);
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
