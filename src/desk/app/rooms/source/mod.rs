//! The source view: what a camera recorded, with what was decided about its pixels.

pub(crate) mod control;
pub(crate) mod model;
pub(crate) mod ui;
pub(crate) mod work;
