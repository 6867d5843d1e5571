//! What is drawn.

pub(crate) mod path_field;
pub(crate) mod recent;
pub(crate) mod welcome;

pub(crate) use path_field::path_field_ui;
pub(crate) use recent::recent_ui;
pub(crate) use welcome::{closing_ui, introduction_ui};
