//! The images of a page in the order in which they are shown, in chunks that are decompressed one by one.

use std::ops::Range;

use libdeflater::{CompressionLvl, Compressor};
use rayon::prelude::*;

use super::budget::LeveledImage;
use super::image_code::{Streams, encode};
use crate::error::{Error, Result};
use crate::job::Job;
use crate::samples::{SampleSet, TILE};
use crate::settings::{Precision, StoreSettings};
use crate::store::depth_shift;

/// Samples that a chunk has about: fewer compress worse, more keep the first picture waiting.
const CHUNK_SAMPLES: usize = 150_000;

/// The best compression that there is: a page is written once, and read often.
pub(super) const BEST: i32 = 12;

/// What the header says of an image.
#[derive(Clone, Copy, Debug, serde::Serialize)]
pub(super) struct ImageHeader {
    pub(super) camera: u32,
    /// First frame, by its index.
    pub(super) start: u32,
    /// One past the last frame.
    pub(super) end: u32,
    pub(super) level: usize,
    pub(super) tiles: usize,
    pub(super) samples: usize,
    /// How its colors are predicted.
    pub(super) predictor: u8,
    /// Whether it has doubtful samples.
    pub(super) doubtful: bool,
}

/// Images whose streams are compressed together.
pub(super) struct Chunk {
    pub(super) images: Vec<ImageHeader>,
    /// Gzip of `for each stream: u32 length, little-endian; for each stream: its bytes`.
    pub(super) bytes: Vec<u8>,
}

/// All chunks, and what is needed to read them.
pub(super) struct Packed {
    pub(super) chunks: Vec<Chunk>,
    /// For each camera, the lowest bits of inverse depth that are left off.
    pub(super) shifts: Vec<u32>,
}

/// Packs images. Those of the first frame come first.
pub(super) fn pack(set: &SampleSet, images: &[LeveledImage], job: &Job) -> Result<Packed> {
    let mut order: Vec<&LeveledImage> = images.iter().collect();
    order.sort_by_key(|image| {
        let span = image.samples.span;
        (span.start, u32::MAX - span.end, image.level, image.samples.camera)
    });
    // Color is 8-bit here, whatever the store holds it to.
    let settings = StoreSettings { precision: Precision::Bits8, ..set.settings.store.clone() };
    let shifts: Vec<u32> = set.cameras.iter().map(|camera| depth_shift(camera, &settings)).collect();
    let ranges = chunk_ranges(&order);
    job.start("Packing samples", ranges.len());
    let chunks: Result<Vec<Chunk>> = ranges
        .into_par_iter()
        .map(|range| {
            job.check()?;
            let chunk = chunk(set, &order[range], &shifts)?;
            job.advance(1);
            Ok(chunk)
        })
        .collect();
    Ok(Packed { chunks: chunks?, shifts })
}

/// Runs of images of about [`CHUNK_SAMPLES`].
fn chunk_ranges(order: &[&LeveledImage]) -> Vec<Range<usize>> {
    let (mut ranges, mut first, mut samples) = (Vec::new(), 0, 0);
    for (index, image) in order.iter().enumerate() {
        samples += image.samples.len();
        if samples >= CHUNK_SAMPLES || index + 1 == order.len() {
            ranges.push(first..index + 1);
            (first, samples) = (index + 1, 0);
        }
    }
    ranges
}

fn chunk(set: &SampleSet, images: &[&LeveledImage], shifts: &[u32]) -> Result<Chunk> {
    let mut streams = Streams::default();
    let mut headers = Vec::with_capacity(images.len());
    for LeveledImage { samples, level } in images {
        let width = set.cameras[samples.camera as usize].intrinsics.width as usize;
        let columns = width.div_ceil(TILE << level);
        let predictor = encode(&mut streams, samples, columns, shifts[samples.camera as usize]);
        headers.push(ImageHeader {
            camera: samples.camera,
            start: samples.span.start,
            end: samples.span.end,
            level: *level,
            tiles: samples.tiles.len(),
            samples: samples.len(),
            predictor,
            doubtful: !samples.doubtful.is_empty(),
        });
    }
    let lengths = streams.0.iter().flat_map(|stream| (stream.len() as u32).to_le_bytes());
    let raw: Vec<u8> = lengths.chain(streams.0.iter().flatten().copied()).collect();
    Ok(Chunk { images: headers, bytes: gzipped(&raw, BEST, &set.name)? })
}

/// Deflate with a checksum, as browsers read it, by a level of effort from 1 to 12.
///
/// # Errors
/// `Invalid` naming `name` where there is no such level.
pub(crate) fn gzipped(raw: &[u8], level: i32, name: &str) -> Result<Vec<u8>> {
    let failed = || Error::invalid(name, "its samples cannot be compressed");
    let mut compressor = Compressor::new(CompressionLvl::new(level).map_err(|_| failed())?);
    let mut bytes = vec![0; compressor.gzip_compress_bound(raw.len())];
    let length = compressor.gzip_compress(raw, &mut bytes).map_err(|_| failed())?;
    bytes.truncate(length);
    Ok(bytes)
}
