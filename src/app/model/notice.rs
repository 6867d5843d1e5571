//! Messages to the person, and the log.

use std::time::Instant;

/// How loud a message is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum NoticeKind {
    /// Something failed.
    Error,
    /// Something is odd.
    Warning,
    /// Something worked.
    Done,
}

/// A message to the person.
#[derive(Clone, Debug)]
pub(crate) struct Notice {
    /// Identity.
    pub id: u64,
    /// How loud.
    pub kind: NoticeKind,
    /// What was tried.
    pub title: String,
    /// What happened, and what to do.
    pub text: String,
    /// When it came up.
    pub since: Instant,
    /// The scene it speaks of, with which it ends; `None` where it holds whatever is open.
    pub scene: Option<u64>,
}

/// A line of the log.
pub(crate) struct LogLine {
    /// When.
    pub at: Instant,
    /// How loud.
    pub kind: NoticeKind,
    /// What.
    pub text: String,
}

/// One line for many.
pub(crate) fn and_others(first: &str, others: usize) -> String {
    match others {
        0 => first.to_owned(),
        others => format!("{first} (and {others} more places: see the Log view)"),
    }
}
