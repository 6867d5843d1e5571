//! Messages to the person, and the log.

use std::path::PathBuf;
use std::time::Instant;

use super::view::DockView;

/// How loud a message is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum NoticeKind {
    Error,
    Warning,
    Done,
}

/// Where a message leads.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum NoticeLink {
    /// A view that shows what it speaks of.
    View(DockView),
    /// The dialog that compares two readings of the capture.
    Readings,
    /// Where it is chosen which way is up.
    Up,
    /// What a capture is known by.
    Sources,
    /// The folder of a file that was written.
    Folder(PathBuf),
}

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
    /// What shows what it speaks of.
    pub link: Option<NoticeLink>,
}

/// A line of the log.
pub(crate) struct LogLine {
    pub at: Instant,
    pub kind: NoticeKind,
    pub text: String,
}

/// One line for many.
pub(crate) fn and_others(first: &str, others: usize) -> String {
    match others {
        0 => first.to_owned(),
        others => format!("{first} (and {others} more places: see the Log view)"),
    }
}
