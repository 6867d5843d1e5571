//! Reads a store: as a whole, or image by image.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use glam::DVec3;
use rayon::prelude::*;

use super::bytes::{HEAD, IMAGE, INDEX, REPORT, SETTINGS, STORE};
use super::header::{Head, ImageEntry, VERSION, decode_head, decode_index, decode_version};
use super::iff::{ChunkId, FORM_HEADER, FormReader, IffError};
use super::tiles;
use crate::capture::Camera;
use crate::error::{Error, Result};
use crate::job::Job;
use crate::preprocess::{Report, SampleImage, SampleSet};
use crate::settings::Settings;

/// What a store says of itself before any image is read.
#[derive(Clone, Debug)]
pub struct StoreInfo {
    /// Major and minor version of the format.
    pub version: (u16, u16),
    /// Name of the capture.
    pub name: String,
    /// The cameras.
    pub cameras: Vec<Camera>,
    /// The number each frame bears in the capture, ascending.
    pub frame_numbers: Vec<i64>,
    /// Up in world space, unit length.
    pub up_in_world: DVec3,
    /// How the store was made.
    pub settings: Settings,
    /// Settings that the store was made with and this Overlook does not have, one line each.
    pub warnings: Vec<String>,
    /// What was dropped and why.
    pub report: Report,
    /// The images, in the order they are painted in.
    pub images: Vec<ImageEntry>,
    /// Size of the file, bytes.
    pub bytes: u64,
}

impl StoreInfo {
    /// Samples in all images.
    #[must_use]
    pub fn sample_count(&self) -> u64 {
        self.images.iter().map(|image| u64::from(image.samples)).sum()
    }

    /// Distinct spans.
    #[must_use]
    pub fn span_count(&self) -> usize {
        self.images.iter().map(|image| image.span).collect::<std::collections::BTreeSet<_>>().len()
    }
}

/// An open store, from which images are read one by one. Reading from several threads is fine.
#[derive(Debug)]
pub struct Store {
    path: PathBuf,
    info: StoreInfo,
    form: Mutex<FormReader<File>>,
}

impl Store {
    /// Whether the file at `path` is an IFF file, as every store is: told by its first four bytes, whatever its name.
    ///
    /// # Errors
    /// `Io` where it cannot be read.
    pub fn is_store(path: &Path) -> Result<bool> {
        if path.is_dir() {
            return Ok(false);
        }
        let mut start = [0; 4];
        let mut file = File::open(path).map_err(|error| Error::io(path, error))?;
        Ok(file.read_exact(&mut start).is_ok() && start == *b"FORM")
    }

    /// Reads what the store says of itself, and no image.
    ///
    /// # Errors
    /// `Io`, `Invalid` (naming file, byte offset and chunk), `Unsupported` (a newer version).
    pub fn open(path: &Path) -> Result<Self> {
        let file = File::open(path).map_err(|error| Error::io(path, error))?;
        let is_folder = file.metadata().is_ok_and(|metadata| metadata.is_dir());
        if is_folder {
            return Err(Error::invalid(path.display(), "is a folder, not a store"));
        }
        let iff = |error| from_iff(path, error);
        let mut form = FormReader::open(file, STORE).map_err(iff)?;
        let chunks = Chunks::collect(&mut form, path)?;
        let Head { name, up_in_world, cameras, frame_numbers } =
            decode_head(&chunks.head).map_err(|what| in_chunk(path, HEAD, what))?;
        let (settings, warnings) =
            decode_settings(&chunks.settings).map_err(|what| in_chunk(path, SETTINGS, what))?;
        let report = serde_json::from_slice(&chunks.report).map_err(|error| in_chunk(path, REPORT, error))?;
        let images = decode_index(&chunks.index).map_err(|what| in_chunk(path, INDEX, what))?;
        let info = StoreInfo {
            version: chunks.version,
            name,
            cameras,
            frame_numbers,
            up_in_world,
            settings,
            warnings,
            report,
            images,
            bytes: form.size(),
        };
        Ok(Self { path: path.to_path_buf(), info, form: Mutex::new(form) })
    }

    /// What the store says of itself.
    #[must_use]
    pub fn info(&self) -> &StoreInfo {
        &self.info
    }

    /// Reads one image, by its place in [`StoreInfo::images`]; the others are not touched.
    ///
    /// # Errors
    /// `Io`; `Invalid` where there is no such image, and where its chunk is damaged or contradicts index or header.
    pub fn image(&self, index: usize) -> Result<SampleImage> {
        let entry = self.info.images.get(index).ok_or_else(|| {
            let count = self.info.images.len();
            Error::invalid(self.path.display(), format!("there is no image {index}; there are {count}"))
        })?;
        let payload = self.payload(entry)?;
        let image = tiles::decode(&payload, &self.info.cameras, self.info.frame_numbers.len());
        let image = image.map_err(|what| self.damaged(entry, &what))?;
        let stated = (entry.camera, entry.span, entry.samples as usize, entry.tiles as usize);
        if stated != (image.camera, image.span, image.len(), image.tiles.len()) {
            return Err(self.damaged(entry, "the index says something else"));
        }
        Ok(image)
    }

    fn payload(&self, entry: &ImageEntry) -> Result<Vec<u8>> {
        let iff = |error| from_iff(&self.path, error);
        let mut form = self.form.lock().unwrap_or_else(PoisonError::into_inner);
        let header = form.header_at(u64::from(entry.offset)).map_err(iff)?;
        let header = header.filter(|header| header.id == IMAGE);
        let header = header.ok_or_else(|| self.damaged(entry, "there is no image"))?;
        let payload = form.payload(&header).map_err(iff)?;
        if payload.len() != entry.length as usize {
            return Err(self.damaged(entry, "the index says another length"));
        }
        Ok(payload)
    }

    fn damaged(&self, entry: &ImageEntry, what: &str) -> Error {
        Error::invalid(
            format!("{}: at byte {}: chunk 'IMAG'", self.path.display(), entry.offset),
            format!("{what}; preprocess the capture again"),
        )
    }

    /// Reads every image.
    ///
    /// # Errors
    /// As [`Store::image`], and `Cancelled`.
    pub fn read_all(&self, job: &Job) -> Result<(SampleSet, Report)> {
        job.start("Reading the store", self.info.images.len());
        let images: Result<Vec<_>> = (0..self.info.images.len())
            .into_par_iter()
            .map(|index| {
                job.check()?;
                let image = self.image(index)?;
                job.advance(1);
                Ok(Arc::new(image))
            })
            .collect();
        let samples = SampleSet {
            name: self.info.name.clone(),
            cameras: self.info.cameras.clone(),
            frame_numbers: self.info.frame_numbers.clone(),
            up_in_world: self.info.up_in_world,
            settings: self.info.settings.clone(),
            images: images?,
        };
        Ok((samples, self.info.report.clone()))
    }
}

/// The payloads of the chunks that say what a store holds.
struct Chunks {
    version: (u16, u16),
    head: Vec<u8>,
    settings: Vec<u8>,
    report: Vec<u8>,
    index: Vec<u8>,
}

impl Chunks {
    /// Walks over the file until all four are found, skipping images and unknown chunks.
    fn collect(form: &mut FormReader<File>, path: &Path) -> Result<Self> {
        let iff = |error| from_iff(path, error);
        let mut version = None;
        let mut found: [(ChunkId, Option<Vec<u8>>); 4] =
            [(HEAD, None), (SETTINGS, None), (REPORT, None), (INDEX, None)];
        let mut offset = FORM_HEADER;
        while let Some(header) = form.header_at(offset).map_err(iff)? {
            if version.is_none() && header.id != HEAD {
                return Err(in_chunk(path, HEAD, "it must be the first chunk"));
            }
            if let Some((id, payload)) = found.iter_mut().find(|(id, _)| *id == header.id) {
                if payload.is_some() {
                    return Err(in_chunk(path, *id, "there are two of them"));
                }
                let bytes = form.payload(&header).map_err(iff)?;
                if *id == HEAD {
                    version = Some(checked_version(&bytes, path)?);
                }
                *payload = Some(bytes);
            }
            if found.iter().all(|(_, payload)| payload.is_some()) {
                break;
            }
            offset = header.end();
        }
        let mut take = |wanted: usize| {
            let (id, payload) = &mut found[wanted];
            payload.take().ok_or_else(|| in_chunk(path, *id, "it is missing"))
        };
        let (head, settings, report, index) = (take(0)?, take(1)?, take(2)?, take(3)?);
        let version = version.ok_or_else(|| in_chunk(path, HEAD, "it is missing"))?;
        Ok(Self { version, head, settings, report, index })
    }
}

/// Settings come and go between versions; the samples are none the worse. What this Overlook does not know is left out
/// and told.
fn decode_settings(toml: &[u8]) -> Result<(Settings, Vec<String>), String> {
    let text = std::str::from_utf8(toml).map_err(|error| error.to_string())?;
    let table: toml::Table = text.parse().map_err(|_| "it is not TOML".to_owned())?;
    let mut settings = Settings::default();
    let mut warnings = Vec::new();
    for (section, values) in table {
        for (name, value) in values.as_table().cloned().unwrap_or_default() {
            let stated = format!("{section}.{name} = {value}");
            if settings.set(&format!("{section}.{name}"), value).is_err() {
                warnings.push(format!("made with {stated}, which this Overlook does not know"));
            }
        }
    }
    Ok((settings, warnings))
}

fn checked_version(head: &[u8], path: &Path) -> Result<(u16, u16)> {
    let version = decode_version(head).map_err(|what| in_chunk(path, HEAD, what))?;
    if version.0 != VERSION.0 {
        return Err(Error::unsupported(
            path.display(),
            format!(
                "the store has version {}.{}, this Overlook reads {}.x; use the Overlook that wrote it or preprocess again",
                version.0, version.1, VERSION.0
            ),
        ));
    }
    Ok(version)
}

fn in_chunk(path: &Path, id: ChunkId, what: impl std::fmt::Display) -> Error {
    Error::invalid(format!("{}: chunk '{}'", path.display(), id.escape_ascii()), what.to_string())
}

fn from_iff(path: &Path, error: IffError) -> Error {
    match error {
        IffError::Io(error) => Error::io(path, error),
        error => Error::invalid(path.display(), error.to_string()),
    }
}
