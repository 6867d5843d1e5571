//! Carries out what concerns settings: changes, presets, and settings as they were.

use std::path::Path;
use std::time::Instant;

use crate::app::control::OverlookApp;
use crate::app::model::command::SettingsCommand;
use crate::app::model::window::{DockView, NoticeKind};
use crate::app::work::worker::AnySlot;

use crate::app::model::{Part, Undoable, method_of};
use overlook_engine::settings::Settings;

impl OverlookApp {
    /// Carries out what concerns settings.
    pub(crate) fn apply_to_settings(&mut self, command: SettingsCommand) {
        match command {
            SettingsCommand::Set { path, value } => self.set(path, value),
            SettingsCommand::ResetAll => self.change_settings(Settings::default()),
            SettingsCommand::Switch => {
                let settings = self.state.inspector.history.switch(&self.state.settings);
                self.put_settings(settings);
            }
            SettingsCommand::Preset(settings) => self.take_preset(*settings),
            SettingsCommand::Take(settings) => self.take_point(*settings),
            SettingsCommand::Find(path) => {
                self.state.inspector.find_setting = path;
                if path.is_some() {
                    self.dock.open(DockView::Thresholds);
                }
            }
        }
    }

    /// Takes back the last change of edits, of the camera path or of settings, whichever it was; or makes it again.
    pub(crate) fn undo_or_redo(&mut self, undo: bool) {
        let mut history = std::mem::take(&mut self.state.inspector.history);
        let step = history.step(undo, |step| self.state.now(step));
        self.state.inspector.history = history;
        match step {
            Some(Undoable::Settings(_, settings)) => self.put_settings(*settings),
            Some(Undoable::Edits(list)) => self.state.doc.edits.list = list,
            Some(Undoable::Path(shape)) => self.state.doc.path.take_shape(shape),
            None => {}
        }
    }

    fn set(&mut self, path: &'static str, value: toml::Value) {
        let mut settings = self.state.settings.clone();
        let number = matches!(value, toml::Value::Integer(_) | toml::Value::Float(_)).then_some(path);
        match settings.set(path, value) {
            Ok(()) => self.change_settings_by(number, settings),
            Err(error) => self.state.notify(NoticeKind::Error, "Setting not changed", error.to_string()),
        }
    }

    /// Changes settings in one step of undo.
    pub(crate) fn change_settings(&mut self, settings: Settings) {
        self.change_settings_by(None, settings);
    }

    /// Changes settings. Changes of the same `number` in quick succession are one step of undo; without one, each is.
    fn change_settings_by(&mut self, number: Option<&'static str>, settings: Settings) {
        if settings != self.state.settings {
            let before = self.state.undoable_settings();
            self.put_settings(settings);
            self.state.note_change(before, number.map(Part::Setting));
        }
    }

    pub(crate) fn put_settings(&mut self, settings: Settings) {
        if method_of(&settings) != method_of(&self.state.settings) {
            self.note_figures_before(&settings);
            self.state.doc.changed_at = Some(Instant::now());
            self.state.doc.stopped = false;
            self.state.doc.failed_frame = None;
        }
        if settings.render != self.state.settings.render {
            // It was that of pictures painted otherwise.
            self.state.doc.accuracy = None;
        }
        if self.state.doc.accuracy.is_none() {
            self.workers.measure.forget();
        }
        self.state.settings = settings;
    }

    /// Takes the settings of a preset. How frames are read and what renders depend on the machine, and stay.
    fn take_preset(&mut self, preset: Settings) {
        let now = &self.state.settings;
        let mut settings = Settings { capture: now.capture.clone(), ..preset };
        settings.render.backend = now.render.backend;
        self.change_settings(settings);
    }

    /// Takes in settings that were read.
    pub(crate) fn settings_loaded(&mut self, path: &Path, settings: Settings) {
        self.change_settings(settings);
        let text = if self.state.has_thresholds() {
            path.display().to_string()
        } else {
            "Rendering settings were applied; the others apply to captures opened from now on.".to_owned()
        };
        self.state.notify(NoticeKind::Done, "Settings loaded", text);
    }
}
