//! Carries out commands and takes in answers: the only place where the state changes.

mod inspect;
mod keyboard;
mod paths;
mod picture_file;
mod receive;
mod remembered;
mod update;

pub(crate) use keyboard::{HELP, commands, gave_up_number};
pub(crate) use paths::Destination;
pub(crate) use picture_file::write_picture;
pub(crate) use remembered::Memory;
