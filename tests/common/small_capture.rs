//! The small capture of a renderer's pictures that the repository carries: four cameras, four frames, given normals.

use std::path::{Path, PathBuf};

use overlook_engine::capture::transforms::{open, open_views};
use overlook_engine::capture::{Capture, TruthView};
use overlook_engine::settings::CaptureSettings;

/// Where it lies: tests of several packages have it, each with a folder of its own for its manifest.
pub(crate) fn folder() -> PathBuf {
    let folders = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors();
    folders.map(|folder| folder.join("assets/small_capture")).find(|folder| folder.is_dir()).unwrap()
}

pub(crate) fn capture() -> Capture {
    open(&folder(), &CaptureSettings::default()).unwrap()
}

/// Views from where no camera stood, each with its true picture.
pub(crate) fn views() -> Vec<TruthView> {
    open_views(&folder().join("novel")).unwrap()
}
