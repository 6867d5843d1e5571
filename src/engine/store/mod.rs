//! The store: tiles of samples, predicted and entropy-coded, in a chunked IFF file. FORMAT.md describes it byte by byte.
//!
//! ```text
//! SampleSet ─ precision ─▶ images ─ blocks ─▶ numbers ─ codec ─▶ bytes ─ iff ─▶ file
//! ```
//!
//! Source: the paper, §3.2: tiles (empty ones are skipped), "simple run-length encoding", a "customized IFF
//! format". What differs: prediction and entropy coding in place of runs, which are rare in half floats; checksums, a version,
//! an index for random access. The file holds exactly what the set holds, unless the settings name a precision.

mod codec;
mod container;
pub mod file;
mod image;
pub mod playback;

use std::path::Path;
use std::sync::Arc;

use crate::error::{Error, Result};
use crate::job::Job;
use crate::samples::{SampleImage, SampleSet};
use crate::settings::StoreSettings;

pub(crate) use container::push_varint;
use file::{Extras, Store, StoreInfo, write_with};
pub(crate) use image::depth_shift;

/// Writes an open store again, as this Overlook writes it, with what it carries beside the samples; `storage` says how, if it is
/// not to be as before. Gives its size in bytes. `path` may be the store's own.
///
/// # Errors
/// As [`file::write`]; `Invalid` where some of it is damaged, since the copy would not show that, where it has less precision than
/// `storage` demands, and where it lacks demanded normals.
pub fn write_again(path: &Path, store: &Store, storage: Option<&StoreSettings>, job: &Job) -> Result<u64> {
    let mut samples = store.read_all(job)?;
    if let Some(damage) = store.damage().first() {
        let what = format!("is not written, since there is damage: {damage}");
        return Err(Error::invalid(path.display(), what));
    }
    let held_to = Some(samples.settings.store.clone());
    if let Some(storage) = storage {
        samples.settings.store = storage.clone();
        set_normals(&mut samples, storage.normals).map_err(|what| Error::invalid(path.display(), what))?;
    }
    let StoreInfo { report, provenance, .. } = store.info().clone();
    let extras =
        Extras { report, provenance, unknown: store.unknown_chunks()?, held_to, ..Extras::default() };
    write_with(path, &samples, &extras, job)
}

/// Leaves normals out unless they are kept.
fn set_normals(samples: &mut SampleSet, are_kept: bool) -> std::result::Result<(), String> {
    if are_kept && samples.images.iter().any(|image| image.normal.is_none()) {
        return Err("cannot have normals: the store holds none; preprocess the capture again, or set store.normals=false".to_owned());
    }
    for image in samples.images.iter_mut().filter(|image| !are_kept && image.normal.is_some()) {
        *image = Arc::new(SampleImage { normal: None, ..SampleImage::clone(image) });
    }
    Ok(())
}

/// Reads a whole store, in which nothing may be damaged ([`Store::read_all`] makes do with what is whole): its samples, and its
/// report as JSON.
///
/// # Errors
/// `Io`, `Invalid` (naming file, chunk and byte offset), `Unsupported` (a newer version), `Cancelled`.
pub fn read(path: &Path, job: &Job) -> Result<(SampleSet, String)> {
    let store = Store::open(path)?;
    Ok((store.read_undamaged(job)?, store.info().report.clone()))
}
