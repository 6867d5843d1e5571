//! Whether the files of a capture are read as they are meant, and another reading beside it.

pub(crate) mod control;
pub(crate) mod model;
pub(crate) mod ui;
pub(crate) mod work;
