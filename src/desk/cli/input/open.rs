//! Opening captures and stores; warnings about them go to stderr.

use std::path::{Path, PathBuf};

use clap::Args;

use crate::cli::output;
use overlook_engine::capture::{self, Capture};
use overlook_engine::edited_store::write_edited_store;
use overlook_engine::edits::EditList;
use overlook_engine::error::{Error, Result};
use overlook_engine::settings::CaptureSettings;
use overlook_engine::store::file::Store;
use overlook_engine::store::playback::{DEFAULT_CACHE_BYTES, Playback};

/// Opens a capture and prints its warnings.
pub(crate) fn open_capture(path: &Path, settings: &CaptureSettings) -> Result<Capture> {
    let capture = capture::open(path, settings)?;
    output::warn(&capture.warnings);
    Ok(capture)
}

/// Edits that are applied to a store before anything else.
#[derive(Debug, Args)]
pub(crate) struct EditsArgs {
    /// Apply this edit list first (TOML, as the window saves it): what it deletes is not there.
    #[arg(long, value_name = "FILE")]
    edits: Option<PathBuf>,
}

impl EditsArgs {
    /// Opens a store for playing it from disk: the store itself, or a temporary one of what the edits leave.
    pub(crate) fn open_store(&self, path: &Path) -> Result<Playback> {
        let mut store = Store::open(path)?;
        output::warn(&store.info().warnings);
        if let Some(file) = &self.edits {
            let edits = EditList::load(file)?;
            let edited =
                tempfile::NamedTempFile::new().map_err(|error| Error::io(std::env::temp_dir(), error))?;
            let edited = edited.into_temp_path();
            output::watched(|job| write_edited_store(&edited, &store, &edits, None, job))?;
            store = Store::open(&edited)?;
        }
        Ok(Playback::new(store, DEFAULT_CACHE_BYTES))
    }

    /// Refuses edits where a recorded picture is asked for: they act on stores.
    pub(crate) fn refuse_for_capture(&self) -> Result<()> {
        let what = "edits act on a store; give the one that was made of the capture";
        if self.edits.is_some() { Err(Error::invalid("--edits", what)) } else { Ok(()) }
    }

    /// Refuses to write over the list.
    pub(crate) fn refuse_inputs(&self, out: &Path) -> Result<()> {
        self.edits.as_ref().map_or(Ok(()), |edits| output::refuse_input(edits, out))
    }
}
