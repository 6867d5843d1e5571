//! What is drawn.

pub(crate) mod panel;
mod value_histogram;
pub(crate) mod value_panel;

pub(crate) use panel::color_panel_ui;
