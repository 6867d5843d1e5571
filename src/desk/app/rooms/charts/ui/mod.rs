//! What is drawn.

pub(crate) mod parts;
pub(crate) mod view;

pub(crate) use view::{stability_ui, tradeoff_ui};
