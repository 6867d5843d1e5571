//! Opening captures and stores; warnings about them go to stderr.

use std::path::{Path, PathBuf};

use clap::Args;

use crate::cli::output;
use overlook_engine::capture::{self, Capture};
use overlook_engine::edited_store::open_edited;
use overlook_engine::edits::{EditList, edited_capture};
use overlook_engine::error::Result;
use overlook_engine::settings::CaptureSettings;
use overlook_engine::store::playback::{DEFAULT_CACHE_BYTES, Playback};

/// Opens a capture and prints its warnings.
pub(crate) fn open_capture(path: &Path, settings: &CaptureSettings) -> Result<Capture> {
    let capture = capture::open(path, settings)?;
    output::warn(&capture.warnings);
    Ok(capture)
}

/// Edits that are applied to a store or a capture before anything else.
#[derive(Debug, Args)]
pub(crate) struct EditsArgs {
    /// Apply this edit list first (TOML, as the window saves it): what it deletes is not there. From a capture it deletes cameras and
    /// recorded pixels; edits that act on what pruning keeps are refused.
    #[arg(long, value_name = "FILE")]
    edits: Option<PathBuf>,
}

impl EditsArgs {
    /// The list, empty where none is named.
    fn list(&self) -> Result<EditList> {
        self.edits.as_ref().map_or_else(|| Ok(EditList::default()), |file| EditList::load(file))
    }

    /// Opens a store for playing it from disk: the store itself, or a temporary one of what the edits leave.
    pub(crate) fn open_store(&self, path: &Path) -> Result<Playback> {
        let edits = self.list()?;
        let store = output::watched(|job| open_edited(path, &edits, job))?;
        output::warn(&store.info().warnings);
        Ok(Playback::new(store, DEFAULT_CACHE_BYTES))
    }

    /// Opens a capture without the cameras and pixels that the edits delete.
    pub(crate) fn open_capture(&self, path: &Path, settings: &CaptureSettings) -> Result<Capture> {
        let edits = self.list()?;
        let capture = open_capture(path, settings)?;
        edited_capture(&capture, &edits, settings.memory as usize * (1 << 20) / 4)
    }

    /// Refuses to write over the list.
    pub(crate) fn refuse_inputs(&self, out: &Path) -> Result<()> {
        self.edits.as_ref().map_or(Ok(()), |edits| output::refuse_input(edits, out))
    }
}
