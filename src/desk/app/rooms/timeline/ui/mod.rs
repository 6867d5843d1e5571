//! What is drawn.

pub(crate) mod panel;
pub(crate) mod time;
pub(crate) mod timeline_keys;

pub(crate) use panel::timeline_ui;
pub(crate) use time::time_ui;
