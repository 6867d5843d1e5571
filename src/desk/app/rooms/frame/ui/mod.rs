//! What is drawn.

pub(crate) mod notices;
pub(crate) mod status;
pub(crate) mod top_bar;
pub(crate) mod workspaces;

pub(crate) use notices::{log_ui, notices_ui};
pub(crate) use status::status_ui;
pub(crate) use top_bar::top_bar_ui;
