//! What is drawn.

pub(crate) mod parts;
pub(crate) mod question;
pub(crate) mod view;

pub(crate) use parts::chart_commands;
pub(crate) use question::question_ui;
pub(crate) use view::{stability_ui, tradeoff_ui};
