//! What can go wrong, said once: what, where, and what to do about it.

use std::path::{Path, PathBuf};

/// The result of every fallible call in Overlook.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// Every error the engine gives. Each message fits on one line and names the place (file, frame, channel).
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The operating system refused to read or write `path`.
    #[error("{}: {source}", path.display())]
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
    /// The person asked for the job to stop; nothing was changed.
    #[error("cancelled")]
    Cancelled,
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
