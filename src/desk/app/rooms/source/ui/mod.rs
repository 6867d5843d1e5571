//! What is drawn.

pub(crate) mod legend;
pub(crate) mod view;

pub(crate) use view::{cameras_ui, source_view_ui};
