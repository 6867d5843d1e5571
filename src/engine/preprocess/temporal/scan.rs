//! Temporal redundancy (the paper, §3.2): which pixels stay the same, and for how long.
//!
//! Purpose: one pass over the frames of every camera. For the tree of spans ([`split`](super::tree_split)) it gives the samples of
//! every span; for the paper's two lengths ([`ranges`](super::two_level)) the range and mean of every pixel over all frames,
//! from which the background follows.
//!
//! Thresholds multiply the noise, which the tree therefore has to know before: it is measured on three pairs of successive
//! frames (`noise/frame_pairs.rs`). These frames are kept until their turn comes, so that every frame is decoded
//! once, unless pictures are repeated.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::batch_split::BATCH;
use super::range_histogram::RangeHistogram;
use super::span_store::SpanStore;
use super::span_tree::SpanTree;
use super::staticness::StaticTest;
use super::tree_split::{OpenSums, Split};
use super::two_level::{CameraSum, SequenceRanges};
use crate::capture::{Capture, Frame, Intrinsics, ValueChannel};
use crate::error::Result;
use crate::job::Job;
use crate::preprocess::noise::{CameraNoise, NoiseFrames, measure_pairs};
use crate::preprocess::normals::{NormalErrors, compare_with_given};
use crate::samples::{Span, samples_in_memory};
use crate::settings::{Settings, SpanLevels, SpanSettings};

/// What a pass over all frames found out about one camera.
#[derive(Debug)]
pub struct CameraScan {
    /// Range and mean of every pixel over all frames; for the paper's two lengths only.
    pub ranges: Option<SequenceRanges>,
    /// How far the ranges of all pixels reach; for the tree of spans only.
    pub shares: Option<RangeHistogram>,
    /// Pixels without depth, over all frames.
    pub invalid: u64,
    /// The coarsest quantization step of depth met in any frame, relative; where a tree of spans was built, in those that were
    /// looked at before.
    pub depth_step_relative: f32,
    /// Noise of static pixels.
    pub noise: CameraNoise,
    /// Estimated against given normals on the first frame, with the settings of the scan; empty where none are given.
    pub normal_errors: Vec<NormalErrors>,
}

impl CameraScan {
    /// What the parts of a scan found out together.
    pub(crate) fn of_parts(preview: &CameraPreview, shares: RangeHistogram, invalid: u64) -> Self {
        let CameraPreview { noise, depth_step_relative, normal_errors } = preview.clone();
        Self { ranges: None, shares: Some(shares), invalid, depth_step_relative, noise, normal_errors }
    }
}

/// What a pass over all frames found out.
#[derive(Debug)]
pub struct TemporalScan {
    /// Frames that were scanned.
    pub frames: usize,
    /// Per camera, in the capture's order.
    pub cameras: Vec<CameraScan>,
    /// The samples of every span of the tree; for the tree only.
    pub spans: Option<SpanStore>,
    /// The channels of scalar values.
    values: Vec<ValueChannel>,
    /// Per camera.
    lenses: Vec<Intrinsics>,
    made_with: SpanSettings,
    /// The edge threshold that [`CameraScan::normal_errors`] goes with.
    pub(crate) edge: f32,
}

impl TemporalScan {
    /// What the parts of a scan with `settings` found out together, of the spans that are needed.
    pub(crate) fn of_parts(
        frames: usize,
        lenses: Vec<Intrinsics>,
        cameras: Vec<CameraScan>,
        spans: SpanStore,
        settings: &Settings,
    ) -> Self {
        let (made_with, edge) = (settings.spans.clone(), settings.normals.edge);
        Self { frames, cameras, spans: Some(spans), values: Vec::new(), lenses, made_with, edge }
    }

    /// Whether the scan serves these settings, or another pass over the frames is needed.
    #[must_use]
    pub fn serves(&self, settings: &SpanSettings) -> bool {
        match self.made_with.levels {
            SpanLevels::Tree => self.made_with == *settings,
            SpanLevels::Paper | SpanLevels::Off => settings.levels != SpanLevels::Tree,
        }
    }

    /// The settings closest to `settings` that the scan serves.
    pub(crate) fn served(&self, settings: &SpanSettings) -> SpanSettings {
        if self.serves(settings) { settings.clone() } else { self.made_with.clone() }
    }

    /// The spans under `settings`.
    #[must_use]
    pub fn tree(&self, settings: &SpanSettings) -> SpanTree {
        SpanTree::new(self.frames, settings.levels)
    }

    /// When a pixel of `camera` counts as static under `settings`.
    pub fn static_test(&self, camera: usize, settings: &SpanSettings) -> StaticTest {
        let scan = &self.cameras[camera];
        StaticTest::new(settings, &scan.noise, scan.depth_step_relative, self.frames)
            .with_lens(&self.lenses[camera])
            .with_values(&self.values)
    }
}

/// One pass over all frames of all cameras. Deterministic whatever the thread count.
///
/// # Errors
/// Whatever the capture gives (naming file and frame), `Io` where a temporary file cannot be written, and `Cancelled`.
pub fn scan(capture: &Capture, settings: &Settings, job: &Job) -> Result<TemporalScan> {
    let frames = capture.frame_count();
    job.start("Reading frames", frames * capture.cameras.len());
    let (cameras, spans) = if settings.spans.levels == SpanLevels::Tree {
        let store = Mutex::new(SpanStore::new(samples_in_memory(settings)));
        let cameras = scan_cameras(capture, |camera| scan_spans(capture, camera, settings, &store, job))?;
        (cameras, Some(store.into_inner().unwrap_or_else(PoisonError::into_inner)))
    } else {
        (scan_cameras(capture, |camera| scan_ranges(capture, camera, settings, job))?, None)
    };
    let (made_with, edge) = (settings.spans.clone(), settings.normals.edge);
    let values = capture.value_channels().to_vec();
    let lenses = capture.cameras.iter().map(|camera| camera.intrinsics).collect();
    Ok(TemporalScan { frames, cameras, spans, values, lenses, made_with, edge })
}

/// Cameras that are scanned side by side: while one waits for the last frame of a batch, the other has work.
pub(crate) const SIDE_BY_SIDE: usize = 2;

fn scan_cameras(
    capture: &Capture,
    scan: impl Fn(usize) -> Result<CameraScan> + Sync,
) -> Result<Vec<CameraScan>> {
    let mut cameras = Vec::with_capacity(capture.cameras.len());
    let indices: Vec<usize> = (0..capture.cameras.len()).collect();
    for indices in indices.chunks(SIDE_BY_SIDE) {
        let scanned: Vec<Result<CameraScan>> = indices.par_iter().map(|&camera| scan(camera)).collect();
        // One after the other, so that of two errors the first camera's is reported.
        for scan in scanned {
            cameras.push(scan?);
        }
    }
    Ok(cameras)
}

/// Frames of this camera that are held at a time: a power of two that takes a moderate share of the memory, since the next
/// batch is decoded while one is split.
fn batch_size(capture: &Capture, camera: usize, settings: &Settings) -> usize {
    let pixel_bytes = if capture.has_normals { 22 } else { 10 } + 4 * capture.value_channels().len();
    let frame_bytes = capture.cameras[camera].intrinsics.pixel_count().max(1) * pixel_bytes;
    let affordable = settings.capture.memory_bytes() / 4 / SIDE_BY_SIDE / (2 * frame_bytes);
    BATCH.min(1 << affordable.max(1).ilog2())
}

/// What is known of a camera before the pass over its frames.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct CameraPreview {
    pub(crate) noise: CameraNoise,
    pub(crate) depth_step_relative: f32,
    pub(crate) normal_errors: Vec<NormalErrors>,
}

/// What is known of a camera before the pass over all its frames.
///
/// # Errors
/// Whatever the capture gives (naming file and frame), and `Cancelled`.
pub(crate) fn preview(
    capture: &Capture,
    camera: usize,
    settings: &Settings,
    job: &Job,
) -> Result<CameraPreview> {
    Ok(Preview::of(capture, camera, settings, job)?.found)
}

/// A scan with the frames that were looked at.
struct Preview {
    found: CameraPreview,
    /// By their index.
    held: BTreeMap<usize, Arc<Frame>>,
}

impl Preview {
    fn of(capture: &Capture, camera: usize, settings: &Settings, job: &Job) -> Result<Self> {
        let frames = NoiseFrames::of(capture.frame_count(), |frame| {
            job.check()?;
            capture.frame(camera, frame)
        })?;
        // Small things that move are not told from noise where there may be some.
        let noise =
            if capture.is_noise_free() { CameraNoise::default() } else { measure_pairs(&frames.pairs()) };
        let held = frames.held;
        let found = CameraPreview {
            noise,
            // Where depth is whole numbers, the step grows with the nearest thing. A tree of spans is built as frames come, and
            // knows the earlier ones.
            depth_step_relative: held.values().map(|frame| frame.depth_step_relative).fold(0.0, f32::max),
            normal_errors: held.get(&0).map_or_else(Vec::new, |first| {
                compare_with_given(first, &capture.cameras[camera], &settings.normals)
            }),
        };
        Ok(Self { found, held })
    }

    /// With what the pass over the frames found.
    fn with(
        self,
        ranges: Option<SequenceRanges>,
        shares: Option<RangeHistogram>,
        invalid: u64,
    ) -> CameraScan {
        let CameraPreview { noise, depth_step_relative, normal_errors } = self.found;
        CameraScan { ranges, shares, invalid, depth_step_relative, noise, normal_errors }
    }
}

fn scan_ranges(capture: &Capture, camera: usize, settings: &Settings, job: &Job) -> Result<CameraScan> {
    let preview = Preview::of(capture, camera, settings, job)?;
    let (width, height) = capture.cameras[camera].intrinsics.size();
    let mut sum = CameraSum::new(width, height);
    let mut coarsest = 0.0_f32;
    let batches = Batches::of_all(capture, camera, settings);
    pass_over(capture, camera, batches, &preview.held, job, |frames| {
        for frame in frames {
            coarsest = coarsest.max(frame.depth_step_relative);
            sum.add(frame);
        }
        Ok(())
    })?;
    let (ranges, invalid) = sum.finish(capture.frame_count());
    Ok(CameraScan { depth_step_relative: coarsest, ..preview.with(Some(ranges), None, invalid) })
}

fn scan_spans(
    capture: &Capture,
    camera: usize,
    settings: &Settings,
    store: &Mutex<SpanStore>,
    job: &Job,
) -> Result<CameraScan> {
    let preview = Preview::of(capture, camera, settings, job)?;
    let frames = capture.frame_count();
    let CameraPreview { noise, depth_step_relative, .. } = &preview.found;
    let test = StaticTest::new(&settings.spans, noise, *depth_step_relative, frames)
        .with_lens(&capture.cameras[camera].intrinsics)
        .with_values(capture.value_channels());
    let mut split = Split::new(capture.cameras[camera].intrinsics.pixel_count(), frames, test);
    let batches = Batches::of_all(capture, camera, settings);
    pass_over(capture, camera, batches, &preview.held, job, |frames| {
        let given = split.add(frames);
        let mut store = store.lock().unwrap_or_else(PoisonError::into_inner);
        given.into_iter().try_for_each(|(span, samples)| store.insert(camera, span, samples))
    })?;
    Ok(preview.with(None, Some(split.shares()), split.invalid()))
}

/// What is known of one camera over a run of frames.
#[derive(Debug)]
pub(crate) struct ScannedRun {
    /// The samples of spans that ended within the run.
    pub(crate) short: SpanStore,
    /// The spans that are open at its end, in order.
    pub(crate) open: Vec<(Span, OpenSums)>,
    /// Pixels without depth, over its frames.
    pub(crate) invalid: u64,
}

/// One pass over the frames of a run, which is made of whole spans of the tree.
///
/// # Errors
/// As [`scan`].
pub(crate) fn scan_run(
    capture: &Capture,
    camera: usize,
    run: Span,
    preview: &CameraPreview,
    settings: &Settings,
    job: &Job,
) -> Result<ScannedRun> {
    let CameraPreview { noise, depth_step_relative, .. } = preview;
    let frames = capture.frame_count();
    let test = StaticTest::new(&settings.spans, noise, *depth_step_relative, frames)
        .with_lens(&capture.cameras[camera].intrinsics)
        .with_values(capture.value_channels());
    let pixels = capture.cameras[camera].intrinsics.pixel_count();
    let mut split = Split::of_run(pixels, frames, run.start, test);
    let mut short = SpanStore::new(samples_in_memory(settings) / SIDE_BY_SIDE);
    let batch = batch_size(capture, camera, settings);
    let batches = Batches { first: run.start as usize, end: run.end as usize, size: batch, is_aligned: true };
    pass_over(capture, camera, batches, &BTreeMap::new(), job, |frames| {
        split.add(frames).into_iter().try_for_each(|(span, samples)| short.insert(camera, span, samples))
    })?;
    let invalid = split.invalid();
    Ok(ScannedRun { short, open: split.into_open(), invalid })
}

/// How frames are taken together.
#[derive(Clone, Copy)]
struct Batches {
    first: usize,
    /// One past the last frame.
    end: usize,
    /// Frames of a batch, at most: a power of two.
    size: usize,
    /// Whether every batch is a span that begins at a multiple of its length; else only the last one may be none.
    is_aligned: bool,
}

impl Batches {
    /// Those of all frames.
    fn of_all(capture: &Capture, camera: usize, settings: &Settings) -> Self {
        Self {
            first: 0,
            end: capture.frame_count(),
            size: batch_size(capture, camera, settings),
            is_aligned: false,
        }
    }

    /// The batch that begins with a frame.
    fn from(self, start: usize) -> std::ops::Range<usize> {
        let left = self.end.saturating_sub(start);
        let mut size = self.size.min(left);
        if self.is_aligned && size > 0 {
            let aligned = if start == 0 { size } else { 1 << start.trailing_zeros() };
            size = 1 << size.min(aligned).ilog2();
        }
        start..start + size
    }
}

/// Gives the frames of a camera to `take`, a batch at a time; meanwhile the next batch is decoded.
fn pass_over(
    capture: &Capture,
    camera: usize,
    batches: Batches,
    held: &BTreeMap<usize, Arc<Frame>>,
    job: &Job,
    mut take: impl FnMut(&[Arc<Frame>]) -> Result<()> + Send,
) -> Result<()> {
    let mut done = batches.first;
    let mut current = decode(capture, camera, batches.from(done), held, job)?;
    while done < batches.end {
        done += current.len();
        let (taken, decoded) =
            rayon::join(|| take(&current), || decode(capture, camera, batches.from(done), held, job));
        taken?;
        current = decoded?;
    }
    Ok(())
}

/// Frames of a camera, those that are `held` already from there.
fn decode(
    capture: &Capture,
    camera: usize,
    frames: std::ops::Range<usize>,
    held: &BTreeMap<usize, Arc<Frame>>,
    job: &Job,
) -> Result<Vec<Arc<Frame>>> {
    frames
        .into_par_iter()
        .map(|frame| {
            job.check()?;
            let decoded = match held.get(&frame) {
                Some(frame) => Ok(frame.clone()),
                None => capture.frame(camera, frame),
            };
            job.advance(1);
            decoded
        })
        .collect()
}
