//! What is known: plain data.

pub(crate) mod command;
pub(crate) mod picture_folder;
pub(crate) mod purpose;
pub(crate) mod recent;
pub(crate) mod session;
pub(crate) mod session_look;

pub(crate) use command::{FileCommand, Opening};
pub(crate) use picture_folder::PictureFolder;
pub(crate) use purpose::{Destination, Purpose, TypedPath};
pub(crate) use recent::{RECENT_SIDES, RecentPicture, smaller};
pub(crate) use session::{SESSION_ENDING, Session};
pub(crate) use session_look::SessionLook;
