//! Errors: what is wrong, where, and what to do about it.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// The result of every fallible call in Overlook.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// Every error the engine gives. Each message fits on one line and names the place (file, frame, channel).
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The operating system refused to read or write `path`.
    #[error("{}: {}", path.display(), said(source))]
    Io {
        /// The file or folder that was touched.
        path: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// Input that contradicts itself or its format.
    #[error("{place}: {what}")]
    Invalid {
        /// The file, and where it helps the frame, channel or byte offset.
        place: String,
        /// What is wrong and what to do about it.
        what: String,
    },
    /// Input that is well formed but that Overlook cannot read.
    #[error("{place}: {what}")]
    Unsupported {
        /// The file, and where it helps the frame or channel.
        place: String,
        /// What is not supported and what to use instead.
        what: String,
    },
    /// The graphics adapter failed or is missing.
    #[error("graphics: {what}")]
    Gpu {
        /// What failed and what to use instead.
        what: String,
    },
    /// The job was cancelled; nothing was changed.
    #[error("cancelled")]
    Cancelled,
}

/// What the operating system said, and what to do about it; what a library said, as it is.
fn said(error: &std::io::Error) -> String {
    let is_bare_kind = error.to_string() == error.kind().to_string();
    if error.raw_os_error().is_none() && !is_bare_kind {
        return error.to_string();
    }
    let advice = match error.kind() {
        ErrorKind::NotFound => "there is no such file or folder; check the path",
        ErrorKind::PermissionDenied => "this user has no permission; allow it, or choose another place",
        ErrorKind::IsADirectory => "is a folder where a file is expected; name a file",
        ErrorKind::NotADirectory => "a file is in place of a folder; check the path",
        ErrorKind::ReadOnlyFilesystem => "the disk can only be read; choose another place",
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded => {
            "the disk is full; free some space, or choose another place"
        }
        ErrorKind::OutOfMemory => "there is not enough memory; close something else and try again",
        _ => {
            let text = error.to_string();
            let words = text.split(" (os error").next().unwrap_or_default();
            return format!("the system reports \"{words}\"; try again, or choose another place");
        }
    };
    advice.to_owned()
}

impl Error {
    /// Wraps an operating system error with the path it concerns.
    pub fn io(path: impl AsRef<Path>, source: std::io::Error) -> Self {
        Self::Io { path: path.as_ref().to_path_buf(), source }
    }

    /// Input at `place` that contradicts itself or its format.
    pub fn invalid(place: impl std::fmt::Display, what: impl Into<String>) -> Self {
        Self::Invalid { place: place.to_string(), what: what.into() }
    }

    /// Well-formed input at `place` that Overlook cannot read.
    pub fn unsupported(place: impl std::fmt::Display, what: impl Into<String>) -> Self {
        Self::Unsupported { place: place.to_string(), what: what.into() }
    }
}

/// A message of a library as one line.
pub(crate) fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_the_system_refuses_is_said_with_what_to_do() {
        let missing = std::fs::read("/no/such/file").unwrap_err();
        let text = Error::io("/no/such/file", missing).to_string();
        assert_eq!(text, "/no/such/file: there is no such file or folder; check the path");
        let full = Error::io("film.mp4", std::io::Error::from_raw_os_error(28)).to_string();
        assert!(full.contains("free some space") && !full.contains("os error"), "{full}");
        let odd = Error::io("film.mp4", std::io::Error::from_raw_os_error(75)).to_string();
        assert!(odd.contains("try again") && !odd.contains("os error"), "{odd}");
        let own = Error::io("x.exr", std::io::Error::other("channel Z is missing; render it too"));
        assert_eq!(own.to_string(), "x.exr: channel Z is missing; render it too");
    }
}
