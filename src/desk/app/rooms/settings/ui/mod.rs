//! What is drawn.

pub(crate) mod histogram;
pub(crate) mod panel;
pub(crate) mod undo_button;

pub(crate) use panel::{naming_ui, settings_ui};
