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

/// Compression that tells about how large a page becomes, in a small part of the time.
pub(super) const QUICK: i32 = 4;

/// Chunks that are compressed both ways to tell how much smaller the best are, at most.
const PROBES: usize = 8;

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

/// Images in the order of a page: those of the first frame come first.
fn ordered(images: &[LeveledImage]) -> Vec<&LeveledImage> {
    let mut order: Vec<&LeveledImage> = images.iter().collect();
    order.sort_by_key(|image| {
        let span = image.samples.span;
        (span.start, u32::MAX - span.end, image.level, image.samples.camera)
    });
    order
}

/// For each camera, the lowest bits of inverse depth that are left off.
fn shifts_of(set: &SampleSet) -> Vec<u32> {
    // Color is 8-bit here, whatever the store holds it to.
    let settings = StoreSettings { precision: Precision::Bits8, ..set.settings.store.clone() };
    set.cameras.iter().map(|camera| depth_shift(camera, &settings)).collect()
}

/// Bytes of some images by the best compression for each byte by the quick one, from some of their chunks.
pub(super) fn best_to_quick(set: &SampleSet, images: &[LeveledImage]) -> Result<f64> {
    let (order, shifts) = (ordered(images), shifts_of(set));
    let ranges = chunk_ranges(&order);
    let every = ranges.len().div_ceil(PROBES).max(1);
    let probes: Vec<Range<usize>> = ranges.into_iter().step_by(every).collect();
    let bytes = |effort: i32| -> Result<usize> {
        let chunks = probes.par_iter().map(|range| chunk(set, &order[range.clone()], &shifts, effort));
        chunks.map(|chunk| Ok(chunk?.bytes.len())).sum()
    };
    Ok(bytes(BEST)? as f64 / bytes(QUICK)?.max(1) as f64)
}

/// Packs images, by a level of effort.
pub(super) fn pack(set: &SampleSet, images: &[LeveledImage], effort: i32, job: &Job) -> Result<Packed> {
    let (order, shifts) = (ordered(images), shifts_of(set));
    let ranges = chunk_ranges(&order);
    job.start(if effort == BEST { "Packing samples" } else { "Estimating sizes" }, ranges.len());
    let chunks: Result<Vec<Chunk>> = ranges
        .into_par_iter()
        .map(|range| {
            job.check()?;
            let chunk = chunk(set, &order[range], &shifts, effort)?;
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

fn chunk(set: &SampleSet, images: &[&LeveledImage], shifts: &[u32], effort: i32) -> Result<Chunk> {
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
    Ok(Chunk { images: headers, bytes: gzipped(&raw, effort, &set.name)? })
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
