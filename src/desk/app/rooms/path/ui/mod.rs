//! What is drawn.

mod keys;
pub(crate) mod panel;
mod way;

pub(crate) use panel::{length_ui, path_ui, size_ui, still_ui};
