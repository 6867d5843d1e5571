//! The small capture of a renderer's pictures that the repository carries: four cameras, four frames, given normals.

use std::path::{Path, PathBuf};

use overlook_engine::capture::transforms::{open, open_views};
use overlook_engine::capture::{Capture, TruthView};
use overlook_engine::settings::CaptureSettings;

/// Where it lies.
pub(crate) fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/small_capture")
}

pub(crate) fn capture() -> Capture {
    open(&folder(), &CaptureSettings::default()).unwrap()
}

/// Views from where no camera stood, each with its true picture.
pub(crate) fn views() -> Vec<TruthView> {
    open_views(&folder().join("novel")).unwrap()
}
