//! Settings: the sliders, their histograms, presets, and settings as they were.

pub(crate) mod control;
pub(crate) mod model;
pub(crate) mod ui;
pub(crate) mod work;
