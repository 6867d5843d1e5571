//! What is known: plain data.

pub(crate) mod command;
pub(crate) mod histogram;
pub(crate) mod presets;
pub(crate) mod setting_names;

pub(crate) use command::SettingsCommand;
pub(crate) use histogram::{BARS, CUT, ThresholdAxis, ThresholdHistogram};
pub(crate) use presets::{PRESETS, changed, keep};
pub(crate) use setting_names::{SECTIONS, SettingPairs};
