//! What is known of a store without its images.

use std::collections::BTreeSet;
use std::path::Path;

use glam::DVec3;

use super::chunks::{InfoChunks, decode_settings, in_chunk, unpacked};
use super::header::{HeadChunk, ImageEntry, Provenance, decode_head, decode_index};
use super::value_chunks::StoredValues;
use crate::capture::Camera;
use crate::error::Result;
use crate::settings::Settings;
use crate::store::container::{HEAD, INDEX, LONG_REPORT, PROVENANCE, REPORT, SETTINGS};

/// What is known of a store before any image is read.
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
    /// What was dropped and why, as JSON, which the store does not interpret.
    pub report: String,
    /// What it was made from.
    pub provenance: Provenance,
    /// The images, in the order they are painted in.
    pub images: Vec<ImageEntry>,
    /// Size of the file, bytes.
    pub bytes: u64,
    /// Bytes of the record of its making: settings, report and provenance. Their number does not depend on the samples.
    pub record_bytes: u64,
    /// The channels of scalar values; none as a rule.
    pub values: Vec<StoredValues>,
}

impl StoreInfo {
    /// Takes it from the chunks of a store of `bytes` bytes.
    pub(super) fn decode(chunks: &InfoChunks, bytes: u64, path: &Path) -> Result<Self> {
        let HeadChunk { name, up_in_world, cameras, frame_numbers } =
            decode_head(chunks.get(HEAD)).map_err(|what| in_chunk(path, HEAD, what))?;
        let (settings, warnings) =
            decode_settings(chunks.get(SETTINGS)).map_err(|what| in_chunk(path, SETTINGS, what))?;
        let json = |id| move |error: serde_json::Error| in_chunk(path, id, error);
        let report = report_in(chunks, path)?;
        let provenance = serde_json::from_slice(chunks.get(PROVENANCE)).map_err(json(PROVENANCE))?;
        let images = decode_index(chunks.get(INDEX), bytes, cameras.len(), frame_numbers.len())
            .map_err(|what| in_chunk(path, INDEX, what))?;
        Ok(Self {
            version: chunks.version,
            name,
            cameras,
            frame_numbers,
            up_in_world,
            settings,
            warnings,
            report,
            provenance,
            images,
            bytes,
            values: Vec::new(),
            record_bytes: chunks.bytes(&[SETTINGS, REPORT, LONG_REPORT, PROVENANCE]),
        })
    }

    /// Samples in all images.
    #[must_use]
    pub fn sample_count(&self) -> u64 {
        self.images.iter().map(|image| u64::from(image.samples)).sum()
    }

    /// Distinct spans.
    #[must_use]
    pub fn span_count(&self) -> usize {
        self.images.iter().map(|image| image.span).collect::<BTreeSet<_>>().len()
    }
}

/// The report: in its own chunk where it is long.
fn report_in(chunks: &InfoChunks, path: &Path) -> Result<String> {
    let long = chunks.get(LONG_REPORT);
    let (id, report) = if long.is_empty() {
        let report = std::str::from_utf8(chunks.get(REPORT)).map_err(|what| in_chunk(path, REPORT, what))?;
        (REPORT, report.to_owned())
    } else {
        (LONG_REPORT, unpacked(long).map_err(|what| in_chunk(path, LONG_REPORT, what))?)
    };
    serde_json::from_str::<serde::de::IgnoredAny>(&report).map_err(|error| in_chunk(path, id, error))?;
    Ok(report)
}
