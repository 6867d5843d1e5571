//! Edits: what is selected, deleted and brought back by hand.

pub(crate) mod control;
pub(crate) mod model;
pub(crate) mod ui;
pub(crate) mod work;
