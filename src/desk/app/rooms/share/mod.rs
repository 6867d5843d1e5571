//! Everything that leaves the window: pages, splats, points, films and figures.

pub(crate) mod control;
pub(crate) mod model;
pub(crate) mod ui;
pub(crate) mod work;
