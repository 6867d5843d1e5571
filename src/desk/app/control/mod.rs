//! Carries out commands and takes in answers: the only place where the state changes.

mod comparison;
mod inspect;
mod keyboard;
mod paths;
mod readings;
mod receive;
mod remembered;
mod settings;
mod update;
mod view;
mod window;

pub(crate) use keyboard::{HELP, commands, gave_up_number};
pub(crate) use remembered::Memory;
