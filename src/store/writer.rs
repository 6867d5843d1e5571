//! Writes a store, atomically.

use std::fs::File;
use std::io::BufWriter;
use std::path::Path;
use std::sync::Arc;

use rayon::prelude::*;
use tempfile::NamedTempFile;

use super::bytes::{HEAD, IMAGE, INDEX, REPORT, SETTINGS, STORE};
use super::header::{ImageEntry, encode_head, encode_index};
use super::iff::{FormWriter, IffError};
use super::tiles;
use crate::error::{Error, Result};
use crate::job::Job;
use crate::preprocess::{Report, SampleImage, SampleSet, Span};

/// Images that are encoded at a time: enough for every thread, few enough to be held in memory.
const BATCH: usize = 64;

/// Writes a store: to a temporary file beside `path`, which is synced and then renamed over it. Gives its size in bytes.
///
/// The same set gives the same bytes, whatever the number of threads: [`Report::seconds`] is written as 0.
///
/// # Errors
/// `Io`, `Invalid` where the set breaks the promises of [`SampleImage`], `Unsupported` where the store would be larger
/// than 4 GiB, `Cancelled`. Whatever stood at `path` is untouched then.
pub fn write(path: &Path, samples: &SampleSet, report: &Report, job: &Job) -> Result<u64> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let temporary = temporary_file(folder).map_err(|error| Error::io(path, error))?;
    let form = FormWriter::new(BufWriter::new(temporary.as_file()), STORE);
    let form = form.map_err(|error| from_iff(path, error))?;
    let size = write_chunks(form, path, samples, report, job)?;
    temporary.as_file().sync_all().map_err(|error| Error::io(path, error))?;
    job.check()?;
    temporary.persist(path).map_err(|error| Error::io(path, error.error))?;
    Ok(size)
}

/// A temporary file is private by default; this one becomes the store, so it gets the permissions of any new file.
fn temporary_file(folder: &Path) -> std::io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".overlook-").suffix(".tmp");
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder.tempfile_in(folder)
}

fn write_chunks(
    mut form: FormWriter<BufWriter<&File>>,
    path: &Path,
    samples: &SampleSet,
    report: &Report,
    job: &Job,
) -> Result<u64> {
    let invalid = |what: String| Error::invalid(path.display(), format!("cannot be written: {what}"));
    let iff = |error| from_iff(path, error);
    form.chunk(HEAD, &encode_head(samples).map_err(invalid)?).map_err(iff)?;
    form.chunk(SETTINGS, samples.settings.to_toml().as_bytes()).map_err(iff)?;
    form.chunk(REPORT, &encode_report(report).map_err(invalid)?).map_err(iff)?;

    // The index stands before the images, so that opening a store reads its first few kilobytes only; it has its final
    // length from the start and is filled in at the end.
    let mut entries = vec![NOWHERE; samples.images.len()];
    let index = form.chunk(INDEX, &encode_index(&entries)).map_err(iff)?;

    job.start("Writing the store", samples.images.len());
    for (images, entries) in samples.images.chunks(BATCH).zip(entries.chunks_mut(BATCH)) {
        let payloads: Result<Vec<_>> =
            images.par_iter().map(|image| encode_image(image, samples, path, job)).collect();
        for ((image, payload), entry) in images.iter().zip(payloads?).zip(entries) {
            let offset = form.chunk(IMAGE, &payload).map_err(iff)?;
            *entry = ImageEntry {
                camera: image.camera,
                span: image.span,
                samples: image.len() as u32,
                tiles: image.tiles.len() as u32,
                offset,
                length: payload.len() as u32,
            };
        }
        job.advance(images.len());
    }
    form.replace(index, INDEX, &encode_index(&entries)).map_err(iff)?;
    let (_, size) = form.finish().map_err(iff)?;
    Ok(size)
}

const NOWHERE: ImageEntry =
    ImageEntry { camera: 0, span: Span { start: 0, end: 0 }, samples: 0, tiles: 0, offset: 0, length: 0 };

fn encode_image(image: &Arc<SampleImage>, samples: &SampleSet, path: &Path, job: &Job) -> Result<Vec<u8>> {
    job.check()?;
    tiles::check(image, &samples.cameras, samples.frame_count()).map_err(|what| {
        let SampleImage { camera, span, .. } = &**image;
        Error::invalid(
            path.display(),
            format!(
                "the image of camera {camera} for frames {}..{} cannot be written: {what}",
                span.start, span.end
            ),
        )
    })?;
    Ok(tiles::encode(image, &samples.cameras[image.camera as usize]))
}

/// How long the work took is no property of its result: without it, the same input gives the same bytes.
///
/// JSON knows no NaN: a report that would not come back as it is must not be written.
fn encode_report(report: &Report) -> Result<Vec<u8>, String> {
    let timeless = Report { seconds: 0.0, ..report.clone() };
    let json = serde_json::to_vec(&timeless).map_err(|error| error.to_string())?;
    match serde_json::from_slice::<Report>(&json) {
        Ok(read) if read == timeless => Ok(json),
        _ => Err("the report holds a number that is not finite".to_owned()),
    }
}

fn from_iff(path: &Path, error: IffError) -> Error {
    match error {
        IffError::Io(error) => Error::io(path, error),
        IffError::TooLarge { .. } => Error::unsupported(
            path.display(),
            "the store would be larger than 4 GiB; preprocess fewer frames or cameras at a time",
        ),
        IffError::Malformed { .. } => Error::invalid(path.display(), error.to_string()),
    }
}
