//! What is drawn.

pub(crate) mod options;
pub(crate) mod panel;
pub(crate) mod picture_menu;

pub(crate) use panel::share_ui;
