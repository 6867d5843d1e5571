//! Messages to the person.

use std::time::Instant;

use crate::app::model::command::Command;
use crate::app::model::window::NoticeKind;

/// A button of a message that leads to what it speaks of: its name, and what it does.
pub(crate) type NoticeLink = (&'static str, Command);

/// A message to the person.
#[derive(Clone, Debug)]
pub(crate) struct Notice {
    pub id: u64,
    pub kind: NoticeKind,
    /// What was tried.
    pub title: String,
    /// What happened, and what to do.
    pub text: String,
    pub since: Instant,
    /// The scene of the notice, which ends with it; `None` for a notice about no scene.
    pub scene: Option<u64>,
    pub link: Option<NoticeLink>,
}
