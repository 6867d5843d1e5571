//! What the window remembers from one run to the next.

use std::path::{Path, PathBuf};

use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::app::dock::Dock;
use crate::app::model::camera::OrbitCamera;
use crate::app::model::look::Guides;
use crate::app::model::{OpenScene, SceneSource, SettingsSlot, State};
use crate::app::rooms::files::state::RecentPicture;
use overlook_engine::settings::Settings;

const KEY: &str = "overlook";

/// Recent files kept.
const RECENT: usize = 8;

/// The memory between runs. Settings are kept as TOML, so that an unknown value of another version falls back to its default, and
/// all others stay.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(default)]
#[expect(clippy::struct_excessive_bools, reason = "switches that the window has, each by its name")]
pub(crate) struct Memory {
    dark: bool,
    recent: Vec<PathBuf>,
    /// Paths, and PNG pictures in base64.
    recent_pictures: Vec<(PathBuf, String)>,
    /// Paths, and which way was chosen to be up in them.
    chosen_ups: Vec<(PathBuf, Option<DVec3>)>,
    settings: String,
    /// The settings of the slot that is not on; empty while both are the same.
    other_settings: String,
    is_b_on: bool,
    frames_per_second: f32,
    show_cameras: bool,
    shows_changes: bool,
    guides: Guides,
    layout: String,
    introduced: bool,
    room_explained: bool,
}

impl Default for Memory {
    fn default() -> Self {
        Self::of(&State::default(), &Dock::new())
    }
}

impl Memory {
    /// What was remembered, or the defaults.
    pub(crate) fn load(storage: Option<&dyn eframe::Storage>) -> Self {
        storage.and_then(|storage| eframe::get_value(storage, KEY)).unwrap_or_default()
    }

    /// What there is to remember.
    pub(crate) fn of(state: &State, dock: &Dock) -> Self {
        let history = &state.inspector.history;
        Self {
            dark: state.dark,
            recent: state.recent.clone(),
            recent_pictures: (state.recent_pictures.iter())
                .filter(|picture| state.recent.contains(&picture.path))
                .filter_map(|picture| Some((picture.path.clone(), picture.to_text()?)))
                .collect(),
            chosen_ups: (state.chosen_ups.iter())
                .filter(|(path, _)| state.recent.contains(path))
                .cloned()
                .collect(),
            settings: state.settings.to_toml(),
            other_settings: history.other.as_ref().map_or_else(String::new, Settings::to_toml),
            is_b_on: history.slot == SettingsSlot::B,
            frames_per_second: state.timeline.frames_per_second,
            show_cameras: state.live.show_cameras,
            shows_changes: state.live.shows_changes,
            guides: state.live.guides,
            layout: dock.to_json(),
            introduced: state.inspector.introduced,
            room_explained: state.inspector.room_explained,
        }
    }

    pub(crate) fn save(&self, storage: &mut dyn eframe::Storage) {
        eframe::set_value(storage, KEY, self);
    }

    /// Puts what was remembered into a fresh state; gives the layout of the views.
    pub(crate) fn restore(self, state: &mut State, ctx: &egui::Context) -> Dock {
        state.dark = self.dark;
        state.recent = self.recent;
        state.recent_pictures = (self.recent_pictures.into_iter())
            .filter_map(|(path, text)| RecentPicture::from_text(ctx, path, &text))
            .collect();
        state.chosen_ups = self.chosen_ups;
        let settings = |text: &str| Settings::known_from_toml(text).map(|(settings, _)| settings);
        state.settings = settings(&self.settings).unwrap_or_default();
        let other = (!self.other_settings.is_empty()).then(|| settings(&self.other_settings)).flatten();
        state.inspector.history.other = other;
        state.inspector.history.slot = if self.is_b_on { SettingsSlot::B } else { SettingsSlot::A };
        state.timeline.frames_per_second = self.frames_per_second.clamp(1.0, 120.0);
        state.live.show_cameras = self.show_cameras;
        state.live.shows_changes = self.shows_changes;
        state.live.guides = self.guides;
        state.inspector.introduced = self.introduced;
        state.inspector.room_explained = self.room_explained;
        Dock::from_json(&self.layout)
    }
}

impl State {
    /// The file or folder that is open; `None` for what comes with the program.
    pub(crate) fn opened_path(&self) -> Option<&PathBuf> {
        match &self.doc.scene.as_ref()?.origin {
            SceneSource::Path(path) => Some(path),
            SceneSource::Demo(_) | SceneSource::Room => None,
        }
    }

    /// Remembers which way was chosen to be up in what is open.
    pub(crate) fn remember_up(&mut self, up: Option<DVec3>) {
        let Some(path) = self.opened_path().cloned() else { return };
        self.chosen_ups.retain(|(known, _)| *known != path);
        self.chosen_ups.push((path, up));
    }

    /// Lets be up what was chosen when the scene was open before.
    pub(crate) fn take_chosen_up(&mut self, scene: &OpenScene) {
        let SceneSource::Path(path) = &scene.origin else { return };
        let chosen = self.chosen_ups.iter().find(|(known, _)| known == path);
        if let Some(up) = chosen.and_then(|(_, up)| up.and_then(DVec3::try_normalize)) {
            self.live.up = Some(up);
            self.live.orbit = OrbitCamera::home(scene, up);
        }
    }
}

/// Puts `path` at the head of the recent files.
pub(crate) fn remember_recent(recent: &mut Vec<PathBuf>, path: &Path) {
    recent.retain(|known| known != path);
    recent.insert(0, path.to_path_buf());
    recent.truncate(RECENT);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn restored(memory: Memory) -> State {
        let mut state = State::default();
        memory.restore(&mut state, &egui::Context::default());
        state
    }

    #[test]
    fn both_settings_are_remembered_and_which_of_them_is_on() {
        let mut state = State::default();
        state.settings.pruning.depth_tolerance = 2.0;
        let a = state.settings.clone();
        state.settings = state.inspector.history.switch(&a);
        state.settings.pruning.depth_tolerance = 3.0;
        let b = state.settings.clone();
        let next = restored(Memory::of(&state, &Dock::new()));
        assert_eq!((next.inspector.history.slot, &next.settings), (SettingsSlot::B, &b));
        assert_eq!(next.inspector.history.of(SettingsSlot::A, &next.settings), &a);
        let first = restored(Memory::default());
        assert_eq!((first.inspector.history.slot, &first.inspector.history.other), (SettingsSlot::A, &None));
    }

    #[test]
    fn a_remembered_value_that_is_not_known_takes_no_other_setting_with_it() {
        let text = "[render]\nfill = \"texture\"\nviews = 3\n".to_owned();
        let mut expected = Settings::default();
        expected.render.views = 3;
        assert_eq!(restored(Memory { settings: text, ..Memory::default() }).settings, expected);
    }

    #[test]
    fn which_way_is_up_is_remembered_of_recent_captures() {
        let mut state = State::default();
        state.recent.push("/kitchen".into());
        let ups = [("/kitchen", Some(DVec3::NEG_Y)), ("/cellar", None)];
        state.chosen_ups = ups.map(|(path, up)| (path.into(), up)).into();
        let next = restored(Memory::of(&state, &Dock::new()));
        assert_eq!(next.chosen_ups, [("/kitchen".into(), Some(DVec3::NEG_Y))]);
    }

    #[test]
    fn recent_files_are_unique_and_few() {
        let mut recent = Vec::new();
        for i in 0..20 {
            remember_recent(&mut recent, Path::new(&format!("/{}", i % 12)));
        }
        remember_recent(&mut recent, Path::new("/3"));
        assert_eq!(recent.len(), RECENT);
        assert_eq!(recent[0], Path::new("/3"));
        assert_eq!(recent.iter().filter(|path| path.as_path() == Path::new("/3")).count(), 1);
    }
}
