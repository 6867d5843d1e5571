//! What concerns the settings.

use super::presets::OwnPreset;
use overlook_engine::settings::Settings;

/// What concerns the settings.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum SettingsCommand {
    Set {
        path: &'static str,
        value: toml::Value,
    },
    Reset(&'static str),
    ResetAll,
    /// Take the settings of a preset.
    Preset(Box<Settings>),
    /// What a new preset is named so far; `None` closes the field.
    NamePreset(Option<String>),
    /// Put other presets in the place of the person's own, and close the field.
    OwnPresets(Vec<OwnPreset>),
    /// Switch to the other of settings A and B.
    Switch,
    /// Put these settings on.
    Take(Box<Settings>),
    /// Show a setting in its panel, by its path; `None` once it is in view.
    Find(Option<&'static str>),
}
