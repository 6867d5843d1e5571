//! The camera path.

pub(crate) mod control;
pub(crate) mod model;
pub(crate) mod ui;
