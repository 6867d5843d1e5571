//! The file of a manifest: its path, and files that are taken for one by mistake.

use std::io::Read;
use std::path::{Path, PathBuf};

use crate::error::Result;
use crate::whole_file;

/// Name of the manifest in a capture's folder.
pub const MANIFEST_NAME: &str = "transforms.json";

/// The manifest of a capture or of views: itself, or the one in the folder.
#[must_use]
pub fn manifest_path(path: &Path) -> PathBuf {
    if path.is_dir() { path.join(MANIFEST_NAME) } else { path.to_path_buf() }
}

/// The manifest of truth vantages beside a capture (a folder, or its manifest); `None` if there is no such file.
#[must_use]
pub fn truth_beside(capture: &Path) -> Option<PathBuf> {
    let folder = if capture.is_dir() { capture } else { capture.parent()? };
    let views = folder.join("novel").join(MANIFEST_NAME);
    views.is_file().then_some(views)
}

/// The advice on a file that is a store or a picture by its first bytes.
pub(crate) fn other_file(path: &Path) -> Result<Option<&'static str>> {
    let mut start = [0; 4];
    let mut file = whole_file::open(path)?;
    if file.read_exact(&mut start).is_err() {
        return Ok(None);
    }
    Ok(match &start {
        b"FORM" => {
            Some("is a store; name the capture that it was made from: a folder, or its transforms.json")
        }
        b"\x76\x2F\x31\x01" | b"\x89PNG" | [0xFF, 0xD8, ..] => {
            Some("is a picture; name the capture that it is of: the folder that holds its transforms.json")
        }
        _ => None,
    })
}
