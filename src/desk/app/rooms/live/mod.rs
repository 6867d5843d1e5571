//! The live view: the scene from any viewpoint, and how one looks around.

pub(crate) mod control;
pub(crate) mod model;
pub(crate) mod ui;
pub(crate) mod work;
