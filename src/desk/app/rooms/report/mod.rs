//! The report: what was dropped and why, by rule, pair of cameras and memory.

pub(crate) mod control;
pub(crate) mod model;
pub(crate) mod ui;
pub(crate) mod work;
