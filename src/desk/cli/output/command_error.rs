//! Why a command fails.

use overlook_engine::error::Error;

/// Why a command ends early.
#[derive(Debug)]
pub(crate) enum CommandError {
    /// The command line makes no sense: exit code 2.
    Usage(String),
    /// The input is bad, or the work failed: exit code 1.
    Work(Error),
}

impl From<Error> for CommandError {
    fn from(error: Error) -> Self {
        Self::Work(error)
    }
}
