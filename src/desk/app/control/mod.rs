//! Carries out commands and takes in answers: the only place where the state changes.

pub(crate) mod keyboard;
pub(crate) mod observed;
pub(crate) mod overlook_app;
pub(crate) mod receive;
pub(crate) mod update;

pub(crate) use keyboard::gave_up_number;
pub use observed::Observed;
pub use overlook_app::{OverlookApp, Start};
