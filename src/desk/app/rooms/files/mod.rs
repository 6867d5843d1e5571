//! Files: what is opened, saved and remembered, and the paths that a person chooses for that.

pub(crate) mod control;
pub(crate) mod model;
pub(crate) mod ui;
pub(crate) mod work;
