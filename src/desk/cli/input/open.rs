//! Opening captures and stores; warnings about them go to stderr.

use std::path::Path;

use crate::cli::output;
use overlook_engine::capture::{self, Capture};
use overlook_engine::error::Result;
use overlook_engine::settings::CaptureSettings;
use overlook_engine::store::file::Store;
use overlook_engine::store::playback::{DEFAULT_CACHE_BYTES, Playback};

/// Opens a capture and prints its warnings.
pub(crate) fn open_capture(path: &Path, settings: &CaptureSettings) -> Result<Capture> {
    let capture = capture::open(path, settings)?;
    output::warn(&capture.warnings);
    Ok(capture)
}

/// Opens a store for playing it from disk.
pub(crate) fn open_store(path: &Path) -> Result<Playback> {
    let store = Store::open(path)?;
    output::warn(&store.info().warnings);
    Ok(Playback::new(store, DEFAULT_CACHE_BYTES))
}
