//! What is known: plain data.

pub(crate) mod command;
pub(crate) mod notice;
pub(crate) mod notify;
pub(crate) mod view;
pub(crate) mod workspace;

pub(crate) use command::WindowCommand;
pub(crate) use notice::{Notice, NoticeKind, NoticeLink, and_others};
pub(crate) use view::{Area, DockView};
pub(crate) use workspace::Workspace;
