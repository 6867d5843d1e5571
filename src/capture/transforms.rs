//! The manifest.

use std::path::Path;

use super::{Capture, View};
use crate::error::Result;
use crate::settings::CaptureSettings;

/// Opens a capture: a `transforms.json`, or a folder that holds one.
///
/// # Errors
/// `Io`, `Invalid`, `Unsupported`: what, where, what to do.
pub fn open(path: &Path, settings: &CaptureSettings) -> Result<Capture> {
    let _ = (path, settings);
    todo!()
}

/// Reads vantages, and where the pictures exist their truth, from a manifest of the same form.
///
/// # Errors
/// As [`open`].
pub fn open_views(path: &Path) -> Result<Vec<View>> {
    let _ = path;
    todo!()
}
