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

use super::chunks::{EMPTY, encode_doubtful, from_iff, packed};
use super::header::{
    ImageEntry, PlaneBytes, Provenance, check_held_once, choose_references, encode_head, encode_index,
};
use super::value_chunks::ValueTable;
use super::verdict_chunk::VerdictTable;
use crate::error::{Error, Result};
use crate::job::Job;
use crate::samples::{ImageBuffer, ImageFacts, SampleImage, SampleSet, Span, VerdictBuffer};
use crate::settings::StoreSettings;
use crate::store::codec::{Counts, FrequencyTables};
use crate::store::container::{
    ChunkId, DOUBTFUL, FormWriter, HEAD, IMAGE, IMAGE_VALUES, INDEX, LONG_REPORT, MODEL, PALETTE, PROVENANCE,
    REPORT, SETTINGS, STORE, VALUES, VERDICTS,
};
use crate::store::image::{self, BlockCoding, ColorRanks, DoubtfulRuns, UsedColors};
use crate::whole_file;

/// Images that are encoded at a time: enough for every thread, few enough to be held in memory.
const BATCH: usize = 64;

/// What is written beside the samples.
#[derive(Clone, Debug)]
pub struct Extras {
    /// What preprocessing reports, as JSON: written as it is.
    pub report: String,
    /// What the store was made from.
    pub provenance: Provenance,
    /// Chunks of another store that this Overlook does not know, to be kept: id and payload as it is.
    pub unknown: Vec<(ChunkId, Vec<u8>)>,
    /// What became of every pixel; `None` where nobody knows, or where it is among the `unknown` as another store has it.
    pub verdicts: Option<Arc<VerdictBuffer>>,
    /// What a store held the samples to from which they were read: what the new one grants counts from the samples as they were
    /// before. `None` where they come from no store.
    pub held_to: Option<StoreSettings>,
}

impl Default for Extras {
    /// An empty report, and nothing else.
    fn default() -> Self {
        let (provenance, unknown) = (Provenance::default(), Vec::new());
        Self { report: "{}".to_owned(), provenance, unknown, verdicts: None, held_to: None }
    }
}

/// Writes a store: to a temporary file beside `path`, which is synced and then renamed over it. Gives its size in bytes.
///
/// The same set and report (JSON) give the same bytes, whatever the number of threads. How much of the samples is kept is said by
/// [`StoreSettings`] in the set's settings.
///
/// # Errors
/// `Io` (a full disk among them), `Invalid` where the set breaks the promises of [`SampleImage`], `Cancelled`. Whatever stood
/// at `path` is untouched then.
pub fn write(path: &Path, samples: &SampleSet, report: &str, job: &Job) -> Result<u64> {
    write_with(path, samples, &Extras { report: report.to_owned(), ..Extras::default() }, job)
}

/// As [`write()`], with what is stored beside the samples.
///
/// # Errors
/// As [`write()`].
pub fn write_with(path: &Path, samples: &SampleSet, extras: &Extras, job: &Job) -> Result<u64> {
    write_spooled(path, samples, &ImageBuffer::of(&samples.images), extras, job)
}

/// As [`write_with`], of images that may be in a file; those of the set itself are ignored.
///
/// # Errors
/// As [`write()`].
pub fn write_spooled(
    path: &Path,
    samples: &SampleSet,
    images: &ImageBuffer,
    extras: &Extras,
    job: &Job,
) -> Result<u64> {
    let temporary = whole_file::beside(path, ".tmp")?;
    let input = Input { path, samples, images, extras, job };
    let size = input.write_to(BufWriter::new(temporary.as_file()))?;
    temporary.as_file().sync_all().map_err(|error| Error::io(path, error))?;
    job.check()?;
    whole_file::persist(temporary.into_temp_path(), path)?;
    // The new name is on the disk once its folder is; where folders cannot be synced the file is whole all the same.
    let place = whole_file::place_of(path);
    let _ = File::open(whole_file::folder_of(&place)).and_then(|folder| folder.sync_all());
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
    extras: &Extras,
    job: &Job,
) -> Result<u64> {
    Input { path, samples, images: &ImageBuffer::of(&samples.images), extras, job }.write_to(target)
}

/// What is written, and the path that errors name.
struct Input<'a> {
    path: &'a Path,
    /// Everything but the images.
    samples: &'a SampleSet,
    images: &'a ImageBuffer,
    extras: &'a Extras,
    job: &'a Job,
}

impl Input<'_> {
    fn write_to(&self, target: impl Write + Seek) -> Result<u64> {
        let Self { path, samples, images, extras, job } = *self;
        let invalid = |what: String| Error::invalid(path.display(), format!("cannot be written: {what}"));
        let iff = |error| from_iff(path, error);
        // A version that has values has doubtful samples, if only none.
        let has_doubtful = !samples.values.is_empty() || images.facts().any(|image| image.doubtful > 0);
        let head = encode_head(samples, has_doubtful).map_err(invalid)?;
        job.start("Writing the store", 2 * images.len());
        if let Some(before) = &extras.held_to {
            let again = image::check_again(&samples.settings.store, before, &samples.cameras);
            again.map_err(|what| Error::invalid(path.display(), what))?;
        }
        let palette = self.palette()?;
        let reduced = self.reduced(&palette)?;
        let prepared = self.prepare(reduced.as_ref().unwrap_or(images), palette)?;

        let is_plain = samples.settings.store.coding == crate::settings::Coding::Plain;
        let planes = (!is_plain).then_some(prepared.planes);
        let provenance = Provenance { planes, ..extras.provenance.clone() };
        let provenance = serde_json::to_vec(&provenance).map_err(|error| invalid(error.to_string()))?;

        let mut form = FormWriter::new(target, STORE).map_err(iff)?;
        form.chunk(HEAD, &head).map_err(iff)?;
        form.chunk(SETTINGS, samples.settings.to_toml().as_bytes()).map_err(iff)?;
        let long_report = packed(&extras.report);
        let report = if long_report.is_some() { EMPTY } else { &extras.report };
        form.chunk(REPORT, report.as_bytes()).map_err(iff)?;
        if let Some(payload) = long_report {
            form.chunk(LONG_REPORT, &payload).map_err(iff)?;
        }
        form.chunk(PROVENANCE, &provenance).map_err(iff)?;
        form.chunk(PALETTE, &prepared.palette.encode()).map_err(iff)?;
        form.chunk(MODEL, &prepared.model.encode()).map_err(iff)?;
        if has_doubtful {
            form.chunk(DOUBTFUL, &self.doubtful(&prepared)?).map_err(iff)?;
        }
        let mut values = prepared.values.clone();
        let value_table = values.as_ref().map(|table| form.chunk(VALUES, &table.encode())).transpose();
        let value_table = value_table.map_err(iff)?;
        let share = f64::from(samples.settings.store.verdicts);
        let has_verdicts = share > 0.0;
        for (id, payload) in extras.unknown.iter().filter(|(id, _)| has_verdicts || *id != VERDICTS) {
            form.plain_chunk(*id, payload).map_err(iff)?;
        }
        if let Some(verdicts) = extras.verdicts.as_ref().filter(|_| has_verdicts) {
            let most_bytes = share * prepared.sample_bytes() as f64;
            VerdictTable::write(&mut form, verdicts, &samples.cameras, most_bytes, job, iff)?;
        }
        // The index comes before the images, so that opening a store reads its first few kilobytes only; it has its final
        // length from the start and is filled in at the end.
        let mut entries: Vec<ImageEntry> =
            (0..prepared.images.len()).map(|index| prepared.entry(index)).collect();
        check_held_once(&entries).map_err(invalid)?;
        let index = form.chunk(INDEX, &encode_index(&entries, 0)).map_err(iff)?;
        for start in (0..entries.len()).step_by(BATCH) {
            let batch = start..entries.len().min(start + BATCH);
            let encode = |index| {
                job.check()?;
                Ok((prepared.encode(samples, index)?, prepared.encode_values(index)?))
            };
            let payloads: Result<Vec<_>> = batch.clone().into_par_iter().map(encode).collect();
            for (index, ((payload, head), of_values)) in batch.clone().zip(payloads?) {
                let offset = form.plain_chunk(IMAGE, &payload).map_err(iff)?;
                let (length, head) = (payload.len() as u32, head as u32);
                entries[index] = ImageEntry { offset, length, head, ..entries[index] };
                if let Some(table) = &mut values {
                    let offset = form.plain_chunk(IMAGE_VALUES, &of_values).map_err(iff)?;
                    table.places[index] = (offset, of_values.len() as u32);
                }
            }
            job.advance(batch.len());
        }
        let size = form.position();
        form.replace(index, INDEX, &encode_index(&entries, size)).map_err(iff)?;
        if let (Some(table), Some(place)) = (&values, value_table) {
            form.replace(place, VALUES, &table.encode()).map_err(iff)?;
        }
        form.finish().map_err(iff)?;
        Ok(size)
    }

    /// Which samples are doubtful, as the payload of their chunk.
    fn doubtful(&self, prepared: &Prepared<'_>) -> Result<Vec<u8>> {
        let images = (0..prepared.images.len()).into_par_iter();
        let images = images.filter(|index| prepared.images.facts_of(*index).doubtful > 0);
        let runs = images.map(|index| {
            self.job.check()?;
            let image = prepared.images.get(index)?;
            let camera = &self.samples.cameras[image.camera as usize];
            Ok((index, DoubtfulRuns::of(&image, camera.intrinsics.size().0)))
        });
        Ok(encode_doubtful(&runs.collect::<Result<Vec<_>>>()?))
    }

    /// The colors that occur, as far as the settings leave them apart; checks every image.
    fn palette(&self) -> Result<ColorRanks> {
        let cameras = &self.samples.cameras;
        let used = (0..self.images.len()).into_par_iter().try_fold(UsedColors::new, |mut used, index| {
            self.job.check()?;
            let image = &*self.images.get(index)?;
            image::check(image, cameras, self.samples.frame_count()).map_err(|what| {
                Error::invalid(place_of(image, self.path), format!("cannot be written: {what}"))
            })?;
            used.add(image);
            Ok(used)
        });
        let used = used.try_reduce(UsedColors::new, |used, more| Ok::<_, Error>(used.plus(&more)))?;
        Ok(ColorRanks::within(&used, self.color_room()))
    }

    /// By how much a color may be moved, 8-bit steps.
    fn color_room(&self) -> f32 {
        image::color_room(&self.samples.settings.store, self.extras.held_to.as_ref())
    }

    /// The images as they are stored, where the settings ask for less than all of them.
    fn reduced(&self, palette: &ColorRanks) -> Result<Option<ImageBuffer>> {
        let settings = &self.samples.settings.store;
        if settings.precision == crate::settings::Precision::Lossless {
            return Ok(None);
        }
        let color_room = self.color_room();
        let reduce = |image: &SampleImage| {
            let camera = &self.samples.cameras[image.camera as usize];
            image::reduce(image, camera, palette, color_room, settings)
                .map_err(|what| Error::invalid(place_of(image, self.path), what))
        };
        self.images.map(reduce).map(Some)
    }

    /// Chooses references and fits a model to `images`, whose colors are those of the palette.
    fn prepare<'a>(&self, images: &'a ImageBuffer, palette: ColorRanks) -> Result<Prepared<'a>> {
        let fit = |counts: &Counts| {
            FrequencyTables::fit(counts).map_err(|what| Error::invalid(self.path.display(), what))
        };
        let mut prepared = Prepared {
            references: choose_references(&images.facts().collect::<Vec<_>>()),
            images,
            palette,
            model: fit(&Counts::default())?,
            planes: PlaneBytes::default(),
            values: None,
        };
        let count = images.facts().map(|image| image.samples as u64).sum();
        prepared.values = ValueTable::fitted(self.samples, (images.len(), count), |index| {
            self.job.check()?;
            prepared.with_reference(index)
        })?;
        let counted = (0..images.len()).into_par_iter().try_fold(Counts::default, |mut counts, index| {
            self.job.check()?;
            let (image, reference) = prepared.with_reference(index)?;
            let coding = prepared.coding(self.samples, &image);
            image::count(&image, reference.as_deref(), &coding, &mut counts);
            self.job.advance(1);
            Ok(counts)
        });
        let counted =
            counted.try_reduce(Counts::default, |counts, more| Ok::<_, Error>(counts.plus(&more)))?;
        prepared.model = fit(&counted)?;
        prepared.planes = PlaneBytes::of_bits(prepared.model.bits(&counted));
        Ok(prepared)
    }
}

fn place_of(image: &SampleImage, path: &Path) -> String {
    let SampleImage { camera, span: Span { start, end }, .. } = image;
    format!("{}: the image of camera {camera} for frames {start}..{end}", path.display())
}

/// All that is decided before the first sample is written.
struct Prepared<'a> {
    images: &'a ImageBuffer,
    references: Vec<Option<u32>>,
    palette: ColorRanks,
    model: FrequencyTables,
    planes: PlaneBytes,
    values: Option<ValueTable>,
}

impl Prepared<'_> {
    /// Bytes of all samples, about; values not counted.
    fn sample_bytes(&self) -> u64 {
        let PlaneBytes { mask, depth, green, red, blue, normals } = self.planes;
        mask + depth + green + red + blue + normals
    }

    /// The index entry of an image that is not written yet.
    fn entry(&self, index: usize) -> ImageEntry {
        let ImageFacts { camera, span, samples, tiles, .. } = *self.images.facts_of(index);
        let reference = self.references[index];
        let (samples, tiles) = (samples as u32, tiles as u32);
        ImageEntry { camera, span, samples, tiles, reference, offset: 0, length: 0, head: 0 }
    }

    /// An image, and the one that it is predicted from.
    fn with_reference(&self, index: usize) -> Result<(Arc<SampleImage>, Option<Arc<SampleImage>>)> {
        let reference = self.references[index].map(|reference| self.images.get(reference as usize));
        Ok((self.images.get(index)?, reference.transpose()?))
    }

    fn coding(&self, samples: &SampleSet, image: &SampleImage) -> BlockCoding<'_> {
        let camera = &samples.cameras[image.camera as usize];
        let settings = &samples.settings.store;
        BlockCoding {
            model: &self.model,
            palette: &self.palette,
            depth_shift: image::depth_shift(camera, settings),
            normals: image.normal.is_some(),
            plain: settings.coding == crate::settings::Coding::Plain,
            size: camera.intrinsics.size(),
        }
    }

    /// The payload of an image's scalar values; empty where there are none.
    fn encode_values(&self, index: usize) -> Result<Vec<u8>> {
        let Some(table) = &self.values else { return Ok(Vec::new()) };
        let (image, reference) = self.with_reference(index)?;
        Ok(image::encode_values(&image, reference.as_deref(), &table.coding))
    }

    fn encode(&self, samples: &SampleSet, index: usize) -> Result<(Vec<u8>, usize)> {
        let (image, reference) = self.with_reference(index)?;
        let camera = &samples.cameras[image.camera as usize];
        Ok(image::encode(&image, reference.as_deref(), camera, &self.coding(samples, &image)))
    }
}
