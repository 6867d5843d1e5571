//! The origin of a manifest.

use std::path::{Path, PathBuf};

/// The origin of a manifest.
#[derive(Clone, Debug)]
pub(crate) struct ManifestOrigin {
    /// The file that lists the pictures and their poses, for messages.
    pub path: PathBuf,
    /// The folder that the paths in it are relative to.
    pub folder: PathBuf,
}

impl ManifestOrigin {
    /// A manifest whose paths are relative to its own folder.
    pub(crate) fn of_file(path: &Path) -> Self {
        Self { path: path.to_path_buf(), folder: path.parent().unwrap_or(Path::new("")).to_path_buf() }
    }
}
