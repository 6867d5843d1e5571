//! The camera path.

pub(crate) mod model;
pub(crate) mod ui;
