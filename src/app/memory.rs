//! What the window remembers from one run to the next.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::dock::Dock;
use super::state::State;
use crate::settings::Settings;

const KEY: &str = "overlook";

/// Recent files kept.
const RECENT: usize = 8;

/// What is remembered. Settings travel as TOML, so that one that no longer exists falls back to defaults instead of
/// taking everything else with it.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(default)]
pub(super) struct Memory {
    dark: bool,
    recent: Vec<PathBuf>,
    settings: String,
    frames_per_second: f32,
    show_cameras: bool,
    layout: String,
    callout: usize,
    presets: Vec<(String, String)>,
}

impl Default for Memory {
    fn default() -> Self {
        Self {
            dark: true,
            recent: Vec::new(),
            settings: String::new(),
            frames_per_second: 24.0,
            show_cameras: true,
            layout: String::new(),
            callout: 0,
            presets: Vec::new(),
        }
    }
}

impl Memory {
    /// What was remembered, or the defaults.
    pub(super) fn load(storage: Option<&dyn eframe::Storage>) -> Self {
        storage.and_then(|storage| eframe::get_value(storage, KEY)).unwrap_or_default()
    }

    /// What there is to remember.
    pub(super) fn of(state: &State, dock: &Dock) -> Self {
        Self {
            dark: state.dark,
            recent: state.recent.clone(),
            settings: state.settings.to_toml(),
            frames_per_second: state.timeline.frames_per_second,
            show_cameras: state.live.show_cameras,
            layout: dock.to_json(),
            callout: state.inspector.callout,
            presets: (state.inspector.presets.iter())
                .map(|(name, settings)| (name.clone(), settings.to_toml()))
                .collect(),
        }
    }

    /// Remembers.
    pub(super) fn save(&self, storage: &mut dyn eframe::Storage) {
        eframe::set_value(storage, KEY, self);
    }

    /// Puts what was remembered into a fresh state; gives the layout of the views.
    pub(super) fn restore(self, state: &mut State) -> Dock {
        state.dark = self.dark;
        state.recent = self.recent;
        state.settings = Settings::from_toml(&self.settings, "remembered settings").unwrap_or_default();
        state.timeline.frames_per_second = self.frames_per_second.clamp(1.0, 120.0);
        state.live.show_cameras = self.show_cameras;
        state.inspector.callout = self.callout;
        state.inspector.presets = (self.presets.into_iter())
            .filter_map(|(name, text)| Some((name, Settings::from_toml(&text, "preset").ok()?)))
            .collect();
        Dock::from_json(&self.layout)
    }
}

/// Puts `path` at the head of the recent files.
pub(super) fn remember_recent(recent: &mut Vec<PathBuf>, path: &Path) {
    recent.retain(|known| known != path);
    recent.insert(0, path.to_path_buf());
    recent.truncate(RECENT);
}

#[cfg(test)]
mod tests {
    use super::*;

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
