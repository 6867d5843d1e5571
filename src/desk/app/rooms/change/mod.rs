//! What the last change of settings did: figures before it and now, and the samples that went or came, seen in the live view.

mod control;
pub(crate) mod state;
pub(crate) mod ui;
pub(crate) mod work;
