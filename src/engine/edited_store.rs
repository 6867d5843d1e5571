//! Stores after edits: what a store holds, without what a list deletes.

use std::path::Path;

use crate::capture::Capture;
use crate::edits::{self, CutByHand, EditList};
use crate::error::{Error, Result};
use crate::job::Job;
use crate::preprocess::diagnostics::Report;
use crate::preprocess::votes_on;
use crate::samples::{ImageBuffer, SampleSet};
use crate::store::file::{Extras, Store, StoreInfo, write_with};

/// What a list leaves of a store.
#[derive(Clone, Debug)]
pub struct EditedStore {
    /// Its samples.
    pub samples: SampleSet,
    /// Its report, as JSON, with what was cut; as it was where nothing was.
    pub report: String,
    /// Samples that are gone.
    pub dropped: u64,
}

/// Opens a store, or a temporary one of what edits leave of it.
///
/// # Errors
/// As [`Store::open`] and [`write_edited_store`].
pub fn open_edited(path: &Path, edits: &EditList, job: &Job) -> Result<Store> {
    let store = Store::open(path)?;
    if edits.is_idle() {
        return Ok(store);
    }
    let file = tempfile::NamedTempFile::new().map_err(|error| Error::io(std::env::temp_dir(), error))?;
    let file = file.into_temp_path();
    write_edited_store(&file, &store, edits, None, job)?;
    Store::open(&file)
}

/// Applies edits to all samples of a store, but for those that it has behind it ([`CutByHand::left_to_do`]). Edits that ask which cameras confirm samples need the capture that it was made from: its
/// frames as recorded, seen by the store's cameras.
///
/// # Errors
/// `Io`, `Invalid` where some of the store is damaged, as [`EditList::check`] and as [`edits::cut`]; `Cancelled`.
pub fn edit_store(
    store: &Store,
    edits: &EditList,
    capture: Option<&Capture>,
    job: &Job,
) -> Result<EditedStore> {
    let place = store.path().display().to_string();
    let values: Vec<_> = store.info().values.iter().map(|stored| stored.channel.clone()).collect();
    let mut report = store.info().report.clone();
    let mut counted = Report::from_json(&report, &place)?;
    let gone: Vec<String> = counted.cut.iter().flat_map(|cut| cut.cameras.clone()).collect();
    edits.check(&store.info().cameras, &gone, &values, &place)?;
    for warning in edits.without_effect(&store.info().frame_numbers, &place) {
        job.warn(warning);
    }
    let edits = &CutByHand::left_to_do(&counted.cut, edits);
    let set = store.read_undamaged(job)?;
    let images = ImageBuffer::of(&set.images);
    let votes = match capture.filter(|_| edits.asks_for_votes()) {
        Some(capture) => Some(votes_on(&images, &set.cameras, capture, job)?),
        None => None,
    };
    let left = edits::cut(&images, None, &set, edits, votes.as_ref(), &place, job)?;
    edits::refuse_nothing(set.sample_count() > 0, &left.images, &place)?;
    if left.is_changed {
        let cut = CutByHand {
            edits: edits.to_toml(),
            samples: left.dropped,
            sample_pixels: left.dropped_pixels,
            ..CutByHand::default()
        };
        counted.note_cut(cut, left.images.facts());
        report = counted.to_json()?;
    }
    // The images before the edits go before those after them come.
    let outline = SampleSet { images: Vec::new(), ..set };
    let samples = SampleSet { images: left.images.into_images()?, ..outline };
    Ok(EditedStore { samples, report, dropped: left.dropped })
}

/// Writes what a list leaves of a store, in the precision of the store. Gives its size in bytes, and the samples that are gone. A list
/// that deletes nothing gives the bytes of the store written again.
///
/// # Errors
/// As [`edit_store`], and as [`crate::store::file::write`].
pub fn write_edited_store(
    path: &Path,
    store: &Store,
    edits: &EditList,
    capture: Option<&Capture>,
    job: &Job,
) -> Result<(u64, u64)> {
    let EditedStore { samples, report, dropped } = edit_store(store, edits, capture, job)?;
    let StoreInfo { provenance, .. } = store.info().clone();
    let held_to = Some(samples.settings.store.clone());
    let extras =
        Extras { report, provenance, unknown: store.unknown_chunks()?, held_to, ..Extras::default() };
    Ok((write_with(path, &samples, &extras, job)?, dropped))
}
