//! What commands read, and the options that several of them share.

mod fingerprint;
mod open;
mod options;
mod truth;

pub(crate) use fingerprint::input_files;
pub(crate) use open::{open_capture, open_store};
pub(crate) use options::{HoldOutArgs, PaintingArgs, SettingsArgs, choice};
pub(crate) use truth::TruthArgs;
