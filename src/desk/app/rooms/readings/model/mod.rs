//! What is known: plain data.

pub(crate) mod command;
pub(crate) mod comparable;
pub(crate) mod readings;

pub(crate) use command::ReadingCommand;
pub(crate) use readings::{ReadingCheck, ReadingImages, ShownReadings};
