//! What concerns the settings.

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
    /// Take the settings of a built-in preset, by its index.
    Preset(usize),
    /// Take the settings of the person's own preset, by its index.
    OwnPreset(usize),
    /// What a new preset is named so far; `None` closes the field.
    NamePreset(Option<String>),
    SavePreset(String),
    /// Forget the person's own preset of an index.
    RemovePreset(usize),
    /// Switch to the other of settings A and B.
    Switch,
    /// Put these settings on.
    Take(Box<Settings>),
    /// Show a setting in its panel, by its path.
    Find(&'static str),
    /// It is in view.
    Found,
}
