//! What is known: plain data.

pub(crate) mod command;
pub(crate) mod pixel;
pub(crate) mod verdict_text;

pub(crate) use command::PixelCommand;
pub(crate) use pixel::{ProbeKey, Probed, Spot};
