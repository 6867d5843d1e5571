//! What commands read, and the options that several of them share.

mod fingerprint;
mod hold_out;
mod open;
mod painting_args;
mod settings_args;
mod truth;

pub(crate) use fingerprint::input_files;
pub(crate) use hold_out::HoldOutArgs;
pub(crate) use open::{open_capture, open_store};
pub(crate) use painting_args::{PaintingArgs, choice};
pub(crate) use settings_args::SettingsArgs;
pub(crate) use truth::TruthArgs;
