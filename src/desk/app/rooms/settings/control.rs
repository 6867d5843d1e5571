//! Carries out what concerns settings: changes, presets, and settings as they were.

use std::time::Instant;

use super::model::PRESETS;
use crate::app::control::overlook_app::OverlookApp;

use crate::app::model::{Command, method_of};
use crate::app::rooms::frame::model::NoticeKind;
use crate::app::rooms::settings::model::keep;
use overlook_engine::settings::Settings;

impl OverlookApp {
    /// Carries out what concerns settings; gives back what does not.
    pub(crate) fn apply_to_settings(&mut self, command: Command) -> Option<Command> {
        // The last change is taken back first, whatever it was.
        match command {
            Command::Undo if self.state.inspector.path.step(true) => return None,
            Command::Redo if self.state.inspector.path.step(false) => return None,
            _ => {}
        }
        let now = &self.state.settings;
        let history = &mut self.state.inspector.history;
        let own = &mut self.state.inspector.presets;
        match command {
            Command::Set { path, value } => self.set(path, value),
            Command::Reset(path) => {
                if let Some(value) = Settings::default().get(path) {
                    self.set(path, value);
                }
            }
            Command::ResetAll => self.change_settings(Settings::default()),
            Command::Undo => {
                let settings = history.undo(now)?;
                self.put_settings(settings);
            }
            Command::Redo => {
                let settings = history.redo(now)?;
                self.put_settings(settings);
            }
            Command::SwitchSettings => {
                let settings = history.switch(now);
                self.put_settings(settings);
            }
            Command::Preset(index) => {
                let mut settings = Settings::default();
                let (_, _, change) = PRESETS.get(index)?;
                change(&mut settings);
                self.take_preset(settings);
            }
            Command::OwnPreset(index) => {
                if let Some((_, settings)) = own.get(index).cloned() {
                    self.take_preset(settings);
                }
            }
            Command::NamePreset(name) => self.state.inspector.naming = name,
            Command::SavePreset(name) => {
                self.state.inspector.naming = None;
                let shown = self.state.shown_settings();
                keep(&mut self.state.inspector.presets, name.trim(), &shown);
            }
            Command::RemovePreset(index) => {
                if index < own.len() {
                    own.remove(index);
                }
            }
            other => return Some(other),
        }
        None
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
            self.state.inspector.history.record(&self.state.settings, number, Instant::now());
            self.state.edits.is_latest = false;
            self.state.inspector.path.changes.is_latest = false;
            self.put_settings(settings);
        }
    }

    pub(crate) fn put_settings(&mut self, settings: Settings) {
        if method_of(&settings) != method_of(&self.state.settings) {
            self.scheduler.changed_at = Some(Instant::now());
            self.state.stopped = false;
            self.state.failed_frame = None;
        }
        if settings.render != self.state.settings.render {
            // It was that of pictures painted otherwise.
            self.state.accuracy = None;
        }
        if self.state.accuracy.is_none() {
            self.scheduler.measure = None;
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
}
