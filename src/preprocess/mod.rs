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
pub(crate) mod interactive;
mod layers;
pub mod noise;
pub mod normals;
mod prepared_scan;
pub mod pruning;
pub mod registration;
pub mod temporal;

pub use prepared_scan::PreparedScan;

use std::sync::{Arc, OnceLock};
use std::time::Instant;

use rayon::prelude::*;

use crate::capture::Capture;
use crate::error::{Error, Result};
use crate::grid::Grid;
use crate::job::Job;
use crate::samples::{ImageBuffer, SampleImage, SampleSet, Span, samples_in_memory};
use crate::settings::{AlignSettings, Settings};
use agreement::Consensus;
use diagnostics::{Report, Residuals, Tally};
use inspect::{CameraInspection, FrameInspection};
use interactive::{CameraPlanes, FrameLayers, FrameVerdicts};
use layers::CameraLayer;
use pruning::{Decided, Masks, PrunedBackground, SpanStack, load_frame};
use registration::CameraPairs;
use temporal::{ROOT, SpanLevel, SpanTree, all_frames};

/// What preprocessing gives: the kept samples, and the report of what was dropped and why.
#[derive(Clone, Debug)]
pub struct Preprocessed {
    /// The kept samples.
    pub samples: Arc<SampleSet>,
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
    /// What was dropped and why.
    pub report: Report,
}

impl BufferedResult {
    fn into_memory(self) -> Result<Preprocessed> {
        let Self { outline, images, report } = self;
        let samples = Arc::new(SampleSet { images: images.into_images()?, ..outline });
        Ok(Preprocessed { samples, report })
    }
}

/// The whole method: scan over time, split into spans, prune between cameras.
///
/// # Errors
/// Whatever the capture gives (naming file and frame), `Io` where a temporary file cannot be used, and `Cancelled`.
pub fn preprocess(capture: &Capture, settings: &Settings, job: &Job) -> Result<Preprocessed> {
    preprocess_into(ImageBuffer::new(usize::MAX), capture, settings, job)?.into_memory()
}

/// The same for a sequence of any length: what is kept waits in a temporary file where it takes more than a share of the memory
/// setting.
///
/// # Errors
/// As [`preprocess`].
pub fn preprocess_buffered(capture: &Capture, settings: &Settings, job: &Job) -> Result<BufferedResult> {
    preprocess_into(ImageBuffer::new(samples_in_memory(settings)), capture, settings, job)
}

fn preprocess_into(
    images: ImageBuffer,
    capture: &Capture,
    settings: &Settings,
    job: &Job,
) -> Result<BufferedResult> {
    let started = Instant::now();
    let scan = scan(capture, settings, job)?;
    let mut spooled = prune_into(images, (capture, &scan), settings, job)?;
    spooled.report.seconds = started.elapsed().as_secs_f64();
    Ok(spooled)
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
    prune_into(ImageBuffer::new(usize::MAX), (capture, scan), settings, job)?.into_memory()
}

fn prune_into(
    mut images: ImageBuffer,
    (capture, scan): (&Capture, &PreparedScan),
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
    job.start("Pruning the background", 1);
    let background = PrunedBackground::of(capture, scan, settings, job)?;
    let normal_errors = scan.normal_errors(&settings.normals, job)?;
    let mut tally = Tally::new((capture, scan), &normal_errors, settings);
    tally.add_noise_between(&capture.cameras, &background.layers);
    tally.add(scan.tree(&settings.spans).root(), &background.decided);
    let pairs = CameraPairs::new(&capture.cameras);
    let packing = Packing { pairs: &pairs, settings };
    packing.pack_all(
        (all_frames(scan.frames), ROOT),
        &background.layers,
        &background.decided,
        &mut images,
    )?;
    let mut residuals = Residuals::new(&pairs, scan.frames);
    residuals.add_lasting(&background.layers, job)?;
    let stack = SpanStack::new(capture, Some(scan), &pairs, settings, background);
    job.start("Pruning frames", scan.frames);
    let mut traversal = SpanTraversal { tree: stack.tree(), stack, tally, residuals, images, packing, job };
    traversal.below(all_frames(scan.frames), ROOT)?;
    let SpanTraversal { tally, residuals, mut images, .. } = traversal;
    images.sort();
    let mut report = tally.finish(images.facts());
    report.residuals = residuals.finish();
    report.alignment = scan.alignment().cloned();
    report.seconds = started.elapsed().as_secs_f64();
    // What changed nothing leaves no trace: a capture that is right gives the same store whatever is looked for.
    let align = if scan.alignment().is_some() { settings.align.clone() } else { AlignSettings::default() };
    let settings = &Settings { align, ..settings.clone() };
    Ok(BufferedResult { outline: sample_set(capture, settings, Vec::new()), images, report })
}

/// Visits all spans, parents before children, and decides the samples of each.
struct SpanTraversal<'a> {
    tree: SpanTree,
    stack: SpanStack<'a>,
    tally: Tally,
    residuals: Residuals<'a>,
    images: ImageBuffer,
    packing: Packing<'a>,
    job: &'a Job,
}

impl SpanTraversal<'_> {
    /// Everything that lives in shorter spans within `span`, which lies at `level`.
    fn below(&mut self, span: Span, level: SpanLevel) -> Result<()> {
        for child in self.tree.children(span) {
            let step = self.stack.enter(child, level + 1, self.job)?;
            self.tally.add(child, &step.decided);
            let layers = &self.stack.layers;
            self.packing.pack_all((child, level + 1), layers, &step.decided, &mut self.images)?;
            // Of a single frame the paper's two levels are as long as each other.
            if child.len() < span.len() {
                self.below(child, level + 1)?;
            }
            if child.len() == 1 {
                self.residuals.add_moving(child.start as usize, &self.stack.layers, self.job)?;
                self.job.advance(1);
            }
            self.stack.leave(&step);
        }
        Ok(())
    }
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
    let pairs = CameraPairs::new(&capture.cameras);
    let frames = load_frame(capture, frame, job)?;
    let complete = match scan {
        Some(scan) => scan.frame_layers(&pairs, settings, frame, job)?,
        None => Arc::new(FrameLayers::unscanned(capture, &pairs, settings, frame, job)?),
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
    let FrameVerdicts { verdicts, disputes, .. } = all;
    let cameras = complete.planes.iter().zip(frames).zip(verdicts.into_iter().zip(disputes));
    let cameras = cameras.map(|((planes, frame), (verdicts, disputes))| {
        let CameraPlanes { class, level, normal_in_world } = planes.clone();
        let (width, height) = level.size();
        let verdict = Grid::from_vec(width, height, verdicts);
        CameraInspection { frame, class, level, verdict, disputes, normal_in_world }
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
    let pairs = CameraPairs::new(&scan.capture().cameras);
    scan.frame_layers(&pairs, settings, frame, job)?.prepare(&pairs, settings, job)
}

/// Packs kept samples.
struct Packing<'a> {
    pairs: &'a CameraPairs<'a>,
    settings: &'a Settings,
}

impl Packing<'_> {
    /// Adds the kept samples of every camera over one span, which lies at `level`.
    fn pack_all(
        &self,
        (span, level): (Span, SpanLevel),
        layers: &[CameraLayer],
        decided: &[Decided],
        images: &mut ImageBuffer,
    ) -> Result<()> {
        let consensus = Consensus::new(self.pairs, layers, level, self.settings);
        let cameras = layers.par_iter().zip(decided).enumerate();
        let packed = cameras.filter_map(|(camera, (layer, decided))| {
            let masks = Masks::decided(layer, decided);
            pruning::pack(camera, span, layer, masks, consensus.as_ref(), self.settings.store.normals)
        });
        packed.collect::<Vec<_>>().into_iter().try_for_each(|image| images.push(image))
    }
}

fn sample_set(capture: &Capture, settings: &Settings, images: Vec<SampleImage>) -> SampleSet {
    SampleSet {
        name: capture.name.clone(),
        cameras: capture.cameras.clone(),
        frame_numbers: capture.frame_numbers.clone(),
        up_in_world: capture.up_in_world,
        settings: settings.clone(),
        images: images.into_iter().map(Arc::new).collect(),
    }
}
