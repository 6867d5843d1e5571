//! Opening captures and stores; warnings about them go to stderr.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;

use super::options::{PaintingArgs, SettingsArgs};
use crate::cli::output::{self, CommandError};
use overlook_engine::capture::{self, Capture};
use overlook_engine::edited_store::open_edited;
use overlook_engine::edits::{EditList, edited_capture};
use overlook_engine::error::{Error, Result};
use overlook_engine::settings::{CaptureSettings, RenderSettings};
use overlook_engine::store::file::StoreInfo;
use overlook_engine::store::playback::{DEFAULT_CACHE_BYTES, Playback};

/// Opens a capture and prints its warnings.
pub(crate) fn open_capture(path: &Path, settings: &CaptureSettings) -> Result<Capture> {
    let capture = capture::open(path, settings)?;
    output::warn(&capture.warnings);
    Ok(capture)
}

/// The index of the frame that bears a number in the capture of a store; `store` is named where there is none.
pub(crate) fn frame_index(playback: &Playback, number: i64, store: &Path) -> Result<usize> {
    let numbers = &playback.store().info().frame_numbers;
    numbers
        .binary_search(&number)
        .map_err(|_| Error::invalid(store.display(), format!("there is no frame {number} in it")))
}

/// A store, and what is deleted of it before anything else.
#[derive(Debug, Args)]
pub(crate) struct StoreArgs {
    /// The store.
    pub(crate) store: PathBuf,
    #[command(flatten)]
    pub(crate) edits: EditsArgs,
}

impl StoreArgs {
    /// Opens it as the edits leave it.
    pub(crate) fn open(&self) -> Result<Arc<Playback>> {
        self.edits.open_store(&self.store).map(Arc::new)
    }

    /// Its frame of a number; `None` for none.
    pub(crate) fn frame(&self, playback: &Playback, number: Option<i64>) -> Result<Option<usize>> {
        number.map(|number| frame_index(playback, number, &self.store)).transpose()
    }

    /// Refuses a destination that cannot be made, that is read, or that is a store. `example` is a good name for a file; `None` where
    /// a folder is written.
    pub(crate) fn check_out(&self, out: &Path, example: Option<&str>) -> Result<()> {
        match example {
            Some(example) => output::check_file(out, example)?,
            None => output::check_folder(out)?,
        }
        output::refuse_input(&self.store, out)?;
        self.edits.refuse_inputs(out)?;
        output::refuse_store(out)
    }
}

/// How pictures of a store are rendered: as the store says, where no option says otherwise.
#[derive(Debug, Args)]
pub(crate) struct RenderingArgs {
    #[command(flatten)]
    painting: PaintingArgs,
    #[command(flatten)]
    pub(crate) settings: SettingsArgs,
}

impl RenderingArgs {
    /// The settings for a store. `settings.only("render")` has refused others before the store was opened.
    pub(crate) fn of_store(&self, info: &StoreInfo) -> Result<RenderSettings, CommandError> {
        let mut settings = self.settings.over(info.settings.clone())?.render;
        self.painting.apply(&mut settings);
        Ok(settings)
    }
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
        edited_capture(&capture, &edits, settings.edited_cache_bytes())
    }

    /// Refuses to write over the list.
    pub(crate) fn refuse_inputs(&self, out: &Path) -> Result<()> {
        self.edits.as_ref().map_or(Ok(()), |edits| output::refuse_input(edits, out))
    }
}
