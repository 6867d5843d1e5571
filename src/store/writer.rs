//! Writes a store, atomically.
//!
//! ```text
//! images ─ precision ─▶ colors that occur ─▶ palette ─▶ tokens counted ─▶ model ─▶ blocks coded ─▶ chunks
//! ```

use std::fs::File;
use std::io::{BufWriter, Seek, Write};
use std::path::Path;
use std::sync::Arc;

use rayon::prelude::*;

use super::blocks::Coding;
use super::bytes::{HEAD, IMAGE, INDEX, MODEL, PALETTE, PROVENANCE, REPORT, SETTINGS, STORE};
use super::coding::model::{Counts, Model};
use super::header::{ImageEntry, choose_references, encode_head, encode_index};
use super::iff::{ChunkId, FormWriter, IffError};
use super::palette::{Palette, Used};
use super::provenance::{PlaneBytes, Provenance};
use super::{images, precision};
use crate::error::{Error, Result};
use crate::job::Job;
use crate::preprocess::{Report, SampleImage, SampleSet, Span};
use crate::settings::{self, StoreSettings};
use crate::whole_file;

/// Images that are encoded at a time: enough for every thread, few enough to be held in memory.
const BATCH: usize = 64;

/// What is written beside the samples and their report.
#[derive(Clone, Debug, Default)]
pub struct Extras {
    /// What the store was made from.
    pub provenance: Provenance,
    /// Chunks of another store that this Overlook does not know, to be kept: id and payload as it is.
    pub unknown: Vec<(ChunkId, Vec<u8>)>,
    /// What a store held the samples to from which they were read: what the new one grants counts from the samples as they were
    /// before. `None` where they come from no store.
    pub held_to: Option<StoreSettings>,
}

/// Writes a store: to a temporary file beside `path`, which is synced and then renamed over it. Gives its size in bytes.
///
/// The same set gives the same bytes, whatever the number of threads: [`Report::seconds`] is written as 0. How much of the
/// samples is kept is said by [`settings::StoreSettings`] in the set's settings.
///
/// # Errors
/// `Io` (a full disk among them), `Invalid` where the set breaks the promises of [`SampleImage`], `Cancelled`. Whatever stood
/// at `path` is untouched then.
pub fn write(path: &Path, samples: &SampleSet, report: &Report, job: &Job) -> Result<u64> {
    write_with(path, samples, report, &Extras::default(), job)
}

/// As [`write()`], with what is to stand beside the samples.
///
/// # Errors
/// As [`write()`].
pub fn write_with(
    path: &Path,
    samples: &SampleSet,
    report: &Report,
    extras: &Extras,
    job: &Job,
) -> Result<u64> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let temporary = whole_file::beside(path, ".tmp")?;
    let size = write_to(BufWriter::new(temporary.as_file()), path, samples, (report, extras), job)?;
    temporary.as_file().sync_all().map_err(|error| Error::io(path, error))?;
    job.check()?;
    temporary.persist(path).map_err(|error| Error::io(path, error.error))?;
    // The new name is on the disk once its folder is; where folders cannot be synced the file is whole all the same.
    let _ = File::open(folder).and_then(|folder| folder.sync_all());
    Ok(size)
}

/// Writes a store to anything that can be written at any place; `path` is named in errors. Gives its size in bytes.
///
/// # Errors
/// As [`write()`].
pub fn write_to(
    target: impl Write + Seek,
    path: &Path,
    samples: &SampleSet,
    (report, extras): (&Report, &Extras),
    job: &Job,
) -> Result<u64> {
    let invalid = |what: String| Error::invalid(path.display(), format!("cannot be written: {what}"));
    let iff = |error| from_iff(path, error);
    let head = encode_head(samples).map_err(invalid)?;
    let report = encode_report(report).map_err(invalid)?;
    job.start("Writing the store", 2 * samples.images.len());
    if let Some(before) = &extras.held_to {
        let again = precision::check_again(&samples.settings.store, before, &samples.cameras);
        again.map_err(|what| Error::invalid(path.display(), what))?;
    }
    let prepared = Prepared::of(samples, extras.held_to.as_ref(), path, job)?;

    let is_plain = samples.settings.store.coding == settings::Coding::Plain;
    let planes = (!is_plain).then_some(prepared.planes);
    let provenance = Provenance { planes, ..extras.provenance.clone() };
    let provenance = serde_json::to_vec(&provenance).map_err(|error| invalid(error.to_string()))?;

    let mut form = FormWriter::new(target, STORE).map_err(iff)?;
    form.chunk(HEAD, &head).map_err(iff)?;
    form.chunk(SETTINGS, samples.settings.to_toml().as_bytes()).map_err(iff)?;
    form.chunk(REPORT, &report).map_err(iff)?;
    form.chunk(PROVENANCE, &provenance).map_err(iff)?;
    form.chunk(PALETTE, &prepared.palette.encode()).map_err(iff)?;
    form.chunk(MODEL, &prepared.model.encode()).map_err(iff)?;
    for (id, payload) in &extras.unknown {
        form.plain_chunk(*id, payload).map_err(iff)?;
    }
    // The index stands before the images, so that opening a store reads its first few kilobytes only; it has its final
    // length from the start and is filled in at the end.
    let mut entries = vec![NOWHERE; prepared.images.len()];
    let index = form.chunk(INDEX, &encode_index(&entries, 0)).map_err(iff)?;
    for start in (0..prepared.images.len()).step_by(BATCH) {
        let batch = start..(start + BATCH).min(prepared.images.len());
        let payloads: Result<Vec<_>> = batch
            .clone()
            .into_par_iter()
            .map(|index| {
                job.check()?;
                Ok(prepared.encode(samples, index))
            })
            .collect();
        for (index, (payload, head)) in batch.clone().zip(payloads?) {
            let offset = form.plain_chunk(IMAGE, &payload).map_err(iff)?;
            let image = &prepared.images[index];
            entries[index] = ImageEntry {
                camera: image.camera,
                span: image.span,
                samples: image.len() as u32,
                tiles: image.tiles.len() as u32,
                reference: prepared.references[index],
                offset,
                length: payload.len() as u32,
                head: head as u32,
            };
        }
        job.advance(batch.len());
    }
    let size = form.position();
    form.replace(index, INDEX, &encode_index(&entries, size)).map_err(iff)?;
    form.finish().map_err(iff)?;
    Ok(size)
}

const NOWHERE: ImageEntry = ImageEntry {
    camera: 0,
    span: Span { start: 0, end: 0 },
    samples: 0,
    tiles: 0,
    reference: None,
    offset: 0,
    length: 0,
    head: 0,
};

/// All that is decided before the first sample is written.
struct Prepared {
    images: Vec<Arc<SampleImage>>,
    references: Vec<Option<u32>>,
    palette: Palette,
    model: Model,
    planes: PlaneBytes,
}

impl Prepared {
    fn of(samples: &SampleSet, held_to: Option<&StoreSettings>, path: &Path, job: &Job) -> Result<Self> {
        let place = |image: &SampleImage| {
            let SampleImage { camera, span: Span { start, end }, .. } = image;
            format!("{}: the image of camera {camera} for frames {start}..{end}", path.display())
        };
        let used = samples.images.par_iter().try_fold(Used::new, |mut used, image| {
            job.check()?;
            images::check(image, &samples.cameras, samples.frame_count())
                .map_err(|what| Error::invalid(place(image), format!("cannot be written: {what}")))?;
            used.add(image);
            Ok(used)
        });
        let used = used.try_reduce(Used::new, |used, more| Ok::<_, Error>(used.plus(&more)))?;
        let settings = &samples.settings.store;
        let color_room = precision::color_room(settings, held_to);
        let palette = Palette::within(&used, color_room);
        let images = if settings.precision == settings::Precision::Lossless {
            samples.images.clone()
        } else {
            let reduce = |image: &Arc<SampleImage>| {
                let camera = &samples.cameras[image.camera as usize];
                let reduced = precision::reduce(image, camera, (&palette, color_room), settings);
                reduced.map(Arc::new).map_err(|what| Error::invalid(place(image), what))
            };
            samples.images.par_iter().map(reduce).collect::<Result<_>>()?
        };
        let mut prepared = Self {
            references: choose_references(&images),
            images,
            palette,
            model: Model::fit(&Counts::default()).map_err(|what| Error::invalid(path.display(), what))?,
            planes: PlaneBytes::default(),
        };
        let counted =
            (0..prepared.images.len()).into_par_iter().try_fold(Counts::default, |mut counts, index| {
                job.check()?;
                let image = &prepared.images[index];
                images::count(
                    image,
                    prepared.reference(index),
                    &prepared.coding(samples, image),
                    &mut counts,
                );
                job.advance(1);
                Ok(counts)
            });
        let counted =
            counted.try_reduce(Counts::default, |counts, more| Ok::<_, Error>(counts.plus(&more)))?;
        prepared.model = Model::fit(&counted).map_err(|what| Error::invalid(path.display(), what))?;
        prepared.planes = PlaneBytes::of_bits(prepared.model.bits(&counted));
        Ok(prepared)
    }

    fn reference(&self, index: usize) -> Option<&SampleImage> {
        self.references[index].map(|reference| &*self.images[reference as usize])
    }

    fn coding(&self, samples: &SampleSet, image: &SampleImage) -> Coding<'_> {
        let camera = &samples.cameras[image.camera as usize];
        let settings = &samples.settings.store;
        Coding {
            model: &self.model,
            palette: &self.palette,
            depth_shift: precision::depth_shift(camera, settings),
            normals: image.normal.is_some(),
            plain: settings.coding == settings::Coding::Plain,
            size: camera.intrinsics.size(),
        }
    }

    fn encode(&self, samples: &SampleSet, index: usize) -> (Vec<u8>, usize) {
        let image = &self.images[index];
        let camera = &samples.cameras[image.camera as usize];
        images::encode(image, self.reference(index), camera, &self.coding(samples, image))
    }
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
            "one image would take more than 4 GiB; preprocess smaller pictures",
        ),
        IffError::Malformed { .. } => Error::invalid(path.display(), error.to_string()),
    }
}
