//! The cameras: how they are named, listed and drawn.

pub(crate) mod model;
pub(crate) mod ui;
