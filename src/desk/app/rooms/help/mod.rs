//! Help, and the palette that finds every command.

pub(crate) mod model;
pub(crate) mod ui;
