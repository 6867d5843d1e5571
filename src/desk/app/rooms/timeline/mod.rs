//! Time: the frame that is shown, playback, and when samples last.

pub(crate) mod control;
pub(crate) mod model;
pub(crate) mod ui;
