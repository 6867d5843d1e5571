//! Preprocessing (the paper, §3.2): removes what is recorded twice, over time and between cameras.
//!
//! ```text
//! frames ─ temporal::scan ─▶ noise ─▶ split ─▶ samples of every span ─▶ background (once) ─▶ pruning ─┐
//!                                                      └─▶ shorter spans, down to each frame ─▶ pruning ─┴▶ pack ─▶ SampleSet + Report
//!
//! a layer = colors, depths ─▶ normals ─▶ sampling rate ─▶ rank;  pruning compares by registration who shows the same point
//! ```
//!
//! The steps, in the paper's order: [`normals`] are given or estimated; [`temporal`] redundancy is split off, over a tree of
//! spans; `layers` hold every sample with its sampling rate; [`registration`] carries samples between cameras and tests whether
//! they show the same surface point; and [`pruning`] keeps the better one. [`noise`] deals with what real renderers add. Where
//! thresholds of one frame change again and again, [`prepare_frame`] lists the candidates of every sample, so that none has to
//! be searched for. [`inspect`] explains the verdicts, [`diagnostics`] counts them.

pub mod agreement;
pub mod diagnostics;
pub mod inspect;
pub mod interactive;
mod layers;
pub mod noise;
pub mod normals;
pub mod parts;
mod prepared_scan;
pub mod pruning;
pub mod registration;
mod sample_votes;
pub mod temporal;
mod traversal;

pub(crate) use layers::{Rate, ViewingRays, footprint};
pub use prepared_scan::PreparedScan;
pub(crate) use prepared_scan::better_conventions;
pub use sample_votes::votes_on;
pub(crate) use traversal::{KeptSamples, prune_run};

use std::sync::{Arc, OnceLock};
use std::time::Instant;

use rayon::prelude::*;

use crate::alignment::Alignment;
use crate::capture::overlap::OverlapGraph;
use crate::capture::{Camera, Capture};
use crate::edits::{self, CutByHand, EditList, EditedImages};
use crate::error::{Error, Result};
use crate::grid::Grid;
use crate::job::Job;
use crate::samples::{ImageBuffer, SampleImage, SampleSet, VerdictBuffer};
use crate::settings::{AlignSettings, Settings};
use agreement::Consensus;
use diagnostics::Report;
use inspect::{CameraInspection, FrameInspection};
use interactive::{CameraPlanes, FrameLayers, FrameVerdicts};
use pruning::load_frame;
use temporal::all_frames;

/// What preprocessing gives: the kept samples, and the report of what was dropped and why.
#[derive(Clone, Debug)]
pub struct Preprocessed {
    /// The kept samples.
    pub samples: Arc<SampleSet>,
    /// What became of every pixel, as a store says it; `None` where nobody asks, and where the settings want none there.
    pub verdicts: Option<Arc<VerdictBuffer>>,
    /// What was dropped and why.
    pub report: Report,
}

/// As [`Preprocessed`], where more was kept than memory may hold.
#[derive(Debug)]
pub struct BufferedResult {
    /// All but the samples: a set without images.
    pub outline: SampleSet,
    /// The kept samples, ordered as [`SampleSet::images`].
    pub images: ImageBuffer,
    /// As [`Preprocessed::verdicts`].
    pub verdicts: Option<Arc<VerdictBuffer>>,
    /// What was dropped and why.
    pub report: Report,
}

impl BufferedResult {
    /// The same, all of it in memory.
    ///
    /// # Errors
    /// `Io` as [`ImageBuffer::into_images`].
    pub fn into_memory(self) -> Result<Preprocessed> {
        let Self { outline, images, verdicts, report } = self;
        let samples = Arc::new(SampleSet { images: images.into_images()?, ..outline });
        Ok(Preprocessed { samples, verdicts, report })
    }
}

/// The whole method: scan over time, split into spans, prune between cameras.
///
/// # Errors
/// Whatever the capture gives (naming file and frame), `Io` where a temporary file cannot be used, and `Cancelled`.
pub fn preprocess(capture: &Capture, settings: &Settings, job: &Job) -> Result<Preprocessed> {
    let edits = EditList::default();
    preprocess_into(KeptSamples::in_memory(), capture, None, settings, &edits, job)?.into_memory()
}

/// The same for a sequence of any length: what is kept waits in a temporary file where it takes more than a share of the memory
/// setting.
///
/// # Errors
/// As [`preprocess`].
pub fn preprocess_buffered(capture: &Capture, settings: &Settings, job: &Job) -> Result<BufferedResult> {
    preprocess_edited(capture, settings, &EditList::default(), job)
}

/// The same with edits: cameras that are left out take part in nothing, removed pixels count as pixels without depth, and the rest of the
/// list acts on what is kept. The report says what was cut.
///
/// # Errors
/// As [`preprocess`], and as [`edits::cut`].
pub fn preprocess_edited(
    capture: &Capture,
    settings: &Settings,
    edits: &EditList,
    job: &Job,
) -> Result<BufferedResult> {
    preprocess_into(KeptSamples::for_store(settings), capture, None, settings, edits, job)
}

/// What [`preprocess_edited`] gives of a capture that was scanned and pruned with these settings before, without edits: what the list
/// does not change is taken from there.
///
/// # Errors
/// As [`preprocess_edited`].
pub fn preprocess_again(
    capture: &Capture,
    scan: &PreparedScan,
    pruned: &Preprocessed,
    settings: &Settings,
    edits: &EditList,
    job: &Job,
) -> Result<BufferedResult> {
    if edits.changes_input() {
        return preprocess_into(KeptSamples::for_store(settings), capture, Some(scan), settings, edits, job);
    }
    checked(capture, edits, job)?;
    let Preprocessed { samples, verdicts, report } = pruned.clone();
    let images = ImageBuffer::of(&samples.images);
    let outline = sample_set(scan.capture(), &aligned_settings(settings, scan.alignment()), Vec::new());
    let pruned = BufferedResult { outline, images, verdicts, report };
    cut_by_hand(pruned, scan.capture(), &[], edits, &capture.cameras, job)
}

/// The capture without the cameras that edits leave out, after it was said what of the list has no effect.
fn checked(capture: &Capture, edits: &EditList, job: &Job) -> Result<Capture> {
    let left = edits::with_cameras_left(capture, edits)?;
    for warning in edits.without_effect(&capture.frame_numbers, "edits") {
        job.warn(warning);
    }
    Ok(left)
}

fn preprocess_into(
    kept: KeptSamples,
    capture: &Capture,
    known: Option<&PreparedScan>,
    settings: &Settings,
    edits: &EditList,
    job: &Job,
) -> Result<BufferedResult> {
    let started = Instant::now();
    settings.validate("settings")?;
    let left = checked(capture, edits, job)?;
    let known = known
        .filter(|known| edits.cameras_left_out().is_empty() && *known.align_settings() == settings.align);
    let scan = match known {
        Some(known) => known.edited_again(settings, edits, job)?,
        None => PreparedScan::edited(&left, settings, edits, job)?,
    };
    let pruned = prune_into(kept, &left, &scan, settings, job)?;
    let (removed, cameras) = (scan.removed_pixels(), &capture.cameras);
    let mut spooled = cut_by_hand(pruned, scan.capture(), removed, edits, cameras, job)?;
    spooled.report.seconds = started.elapsed().as_secs_f64();
    Ok(spooled)
}

/// What edits leave of what was kept of a capture, with a report that says so. `removed` are the pixels that they removed before, for
/// each camera; `cameras` are all, those that are left out among them.
pub(crate) fn cut_by_hand(
    pruned: BufferedResult,
    capture: &Capture,
    removed: &[u64],
    edits: &EditList,
    cameras: &[Camera],
    job: &Job,
) -> Result<BufferedResult> {
    if edits.is_idle() {
        return Ok(pruned);
    }
    let BufferedResult { outline, images, verdicts, mut report } = pruned;
    let left_out = edits.cameras_left_out();
    let was_there =
        removed.iter().any(|removed| *removed > 0) || images.facts().any(|facts| facts.samples > 0);
    let votes =
        if edits.asks_for_votes() { Some(votes_on(&images, &outline.cameras, capture, job)?) } else { None };
    let cut = edits.with_views_of_left_out(cameras);
    let EditedImages { images, dropped, dropped_pixels, .. } =
        edits::cut(&images, None, &outline, &cut, votes.as_ref(), "edits", job)?;
    edits::refuse_nothing(was_there, &images, "edits")?;
    for (camera, removed) in report.cameras.iter_mut().zip(removed) {
        camera.invalid = camera.invalid.saturating_sub(*removed);
    }
    let cut = CutByHand {
        edits: edits.to_toml(),
        cameras: left_out.into_iter().map(str::to_owned).collect(),
        pixels: removed.iter().sum(),
        samples: dropped,
        sample_pixels: dropped_pixels,
    };
    report.note_cut(cut, images.facts());
    Ok(BufferedResult { outline, images, verdicts, report })
}

/// The pass over all frames: the samples of every span, before any pruning. No pruning threshold touches it.
///
/// # Errors
/// As [`preprocess`].
pub fn scan(capture: &Capture, settings: &Settings, job: &Job) -> Result<Arc<PreparedScan>> {
    settings.validate("settings")?;
    Ok(Arc::new(PreparedScan::new(capture, settings, job)?))
}

/// Everything after [`scan`]: cheap enough to be repeated whenever a threshold of pruning changes. Where the scan does not
/// serve the settings of the spans, the frames are scanned again.
///
/// # Errors
/// As [`preprocess`].
pub fn prune(capture: &Capture, scan: &PreparedScan, settings: &Settings, job: &Job) -> Result<Preprocessed> {
    prune_into(KeptSamples::in_memory(), capture, scan, settings, job)?.into_memory()
}

/// As [`prune`], with what became of every pixel where `store.verdicts` wants it in a store.
///
/// # Errors
/// As [`preprocess`].
pub fn prune_for_store(
    capture: &Capture,
    scan: &PreparedScan,
    settings: &Settings,
    job: &Job,
) -> Result<Preprocessed> {
    let kept =
        KeptSamples { verdicts: KeptSamples::for_store(settings).verdicts, ..KeptSamples::in_memory() };
    prune_into(kept, capture, scan, settings, job)?.into_memory()
}

fn prune_into(
    kept: KeptSamples,
    capture: &Capture,
    scan: &PreparedScan,
    settings: &Settings,
    job: &Job,
) -> Result<BufferedResult> {
    settings.validate("settings")?;
    let started = Instant::now();
    let other;
    let scan = if scan.serves(settings) {
        scan
    } else {
        other = PreparedScan::new(capture, settings, job)?;
        &other
    };
    let capture = scan.capture();
    let (kept, counts) = prune_run(kept, scan, settings, all_frames(scan.frames), job)?;
    let KeptSamples { images, verdicts } = kept;
    let mut report = counts.finish(capture.cameras.len(), images.facts());
    report.alignment = scan.alignment().cloned();
    report.note_conventions(scan.conventions());
    report.seconds = started.elapsed().as_secs_f64();
    let settings = aligned_settings(settings, scan.alignment());
    let outline = sample_set(capture, &settings, Vec::new());
    Ok(BufferedResult { outline, images, verdicts: verdicts.map(Arc::new), report })
}

/// Settings as a result names them: what changed nothing leaves no trace, so that a capture that is right gives the same store
/// whatever is looked for.
pub(crate) fn aligned_settings(settings: &Settings, alignment: Option<&Alignment>) -> Settings {
    let align = if alignment.is_some_and(Alignment::is_of_cameras) {
        settings.align.clone()
    } else {
        AlignSettings::default()
    };
    Settings { align, ..settings.clone() }
}

/// All verdicts of one frame, for display: what [`prune`] decides there, with reasons and witnesses.
///
/// Without a `scan` (still under way) every pixel counts as one of this frame alone. Where the scan does not serve the
/// settings of the spans, the frame is shown with those it was made with.
///
/// # Errors
/// As [`preprocess`], and `Invalid` where there is no such frame.
pub fn inspect_frame(
    capture: &Capture,
    scan: Option<&PreparedScan>,
    settings: &Settings,
    frame: usize,
    job: &Job,
) -> Result<FrameInspection> {
    settings.validate("settings")?;
    if frame >= capture.frame_count() {
        return Err(Error::invalid(
            &capture.name,
            format!("there is no frame {frame}; there are {}", capture.frame_count()),
        ));
    }
    let settings = &scan.map_or_else(|| settings.clone(), |scan| scan.served(settings));
    let capture = scan.map_or(capture, PreparedScan::capture);
    let pairs = OverlapGraph::complete(&capture.cameras);
    let frames = load_frame(capture, frame, job)?;
    let complete = match scan {
        Some(scan) => scan.frame_layers(settings, frame, job)?,
        None => Arc::new(FrameLayers::unscanned(capture, settings, frame, job)?),
    };
    let all = complete.prune(&pairs, settings, job)?;
    let levels = complete.path.iter().zip(0..);
    let packed = levels.flat_map(|(&span, level)| {
        let consensus = Consensus::new(&pairs, &complete.layers, level, settings);
        let cameras = complete.layers.par_iter().enumerate();
        let packed = cameras.filter_map(|(camera, layer)| {
            let masks = all.masks(camera, layer, level);
            pruning::pack(camera, span, layer, masks, consensus.as_ref(), settings.store.normals)
        });
        packed.collect::<Vec<_>>()
    });
    let images = packed.collect();
    let FrameVerdicts { verdicts, .. } = all;
    let cameras = complete.planes.iter().zip(frames).zip(verdicts);
    let cameras = cameras.map(|((planes, frame), verdicts)| {
        let CameraPlanes { class, level, normal_in_world } = planes.clone();
        let (width, height) = level.size();
        let verdict = Grid::from_vec(width, height, verdicts);
        CameraInspection { frame, class, level, verdict, normal_in_world }
    });
    Ok(FrameInspection {
        frame,
        path: complete.path.clone(),
        cameras: cameras.collect(),
        samples: Arc::new(sample_set(capture, settings, images)),
        layers: complete.layers.clone(),
        settings: settings.clone(),
        agreement: Arc::new(vec![OnceLock::new(); capture.cameras.len()]),
    })
}

/// Prepares a frame for changing thresholds of pruning: [`inspect_frame`] is then several times as fast there, for
/// tolerances up to four times as large or small. Gives the bytes that this takes in memory; `None` where it takes more than
/// half of the memory setting, or where the scan does not serve the settings, and all stays as it is.
///
/// # Errors
/// As [`inspect_frame`].
pub fn prepare_frame(
    capture: &Capture,
    scan: &PreparedScan,
    settings: &Settings,
    frame: usize,
    job: &Job,
) -> Result<Option<usize>> {
    settings.validate("settings")?;
    if frame >= capture.frame_count() || !scan.serves(settings) {
        return Ok(None);
    }
    let pairs = OverlapGraph::complete(&scan.capture().cameras);
    scan.frame_layers(settings, frame, job)?.prepare(&pairs, settings, job)
}

pub(crate) fn sample_set(capture: &Capture, settings: &Settings, images: Vec<SampleImage>) -> SampleSet {
    SampleSet {
        name: capture.name.clone(),
        cameras: capture.cameras.clone(),
        frame_numbers: capture.frame_numbers.clone(),
        up_in_world: capture.up_in_world,
        settings: settings.clone(),
        values: capture.value_channels().to_vec(),
        images: images.into_iter().map(Arc::new).collect(),
    }
}
