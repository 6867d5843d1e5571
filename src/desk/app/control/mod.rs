//! Carries out commands and takes in answers: the only place where the state changes.

mod address;
mod comparison;
mod edits;
mod inspect;
mod keyboard;
mod observed;
mod overlook_app;
mod path_names;
mod paths;
mod readings;
mod receive;
mod remembered;
mod session;
mod settings;
mod share;
mod update;
mod view;
mod window;

pub(crate) use keyboard::{HELP, commands, gave_up_number};
pub use observed::Observed;
#[cfg(test)]
pub(crate) use overlook_app::secs_left;
pub use overlook_app::{OverlookApp, Start};
pub(crate) use paths::what_is_missing;
