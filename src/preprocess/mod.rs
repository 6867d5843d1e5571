//! Preprocessing (the paper, §3.2): removes what is said twice, over time and between cameras.
//!
//! ```text
//! frames ─ temporal::scan ─▶ ranges, means, noise ─ split ─▶ background (once)  ─┐
//!    │                                                                         ├─ pruning ─▶ pack ─▶ SampleSet + Report
//!    └──────────────────────── overlay ─────────────────────▶ foreground (each frame) ─┘
//!
//! a layer = colors, depths ─▶ normals ─▶ sampling rate ─▶ rank;  pruning asks registration who shows the same point
//! ```
//!
//! The steps, in the paper's order: [`normals`] are given or estimated; [`temporal`] redundancy is split off as
//! background; [`registration`] carries samples between cameras; [`sampling_rate`] tells which of two is better; and
//! [`pruning`] keeps the better one. [`mixed_pixels`] and [`noise`] deal with what real renderers add.

pub mod background;
mod contest;
pub mod depth_plane;
pub mod facet;
pub mod foreground;
pub mod inspection;
pub mod layer;
pub mod mixed_pixels;
pub mod noise;
pub mod normal_errors;
pub mod normals;
mod octahedral;
pub mod pack;
pub mod pruning;
pub mod registration;
pub mod report;
mod rig;
pub mod same_surface;
pub mod samples;
pub mod sampling_rate;
mod settle;
pub mod temporal;

use std::sync::Arc;
use std::time::Instant;

use crate::capture::Capture;
use crate::error::{Error, Result};
use crate::grid::Grid;
use crate::job::Job;
use crate::settings::Settings;

use background::Background;
use foreground::{PrunedFrame, prune_frame};
use layer::{Layer, Level, NO_SAMPLE, ROOT};
use pruning::{Decided, Rig};
use report::Tally;

pub use depth_plane::{DepthPlane, DepthTile, TILE_SAMPLES, TileDepths};
pub use inspection::{CameraInspection, FrameInspection, PairArgument, PixelClass, Rule, Verdict};
pub use report::Report;
pub use samples::{OctNormal, Sample, SampleImage, SampleSet, SampleTile, Span, TILE};
pub use temporal::TemporalScan;

/// What preprocessing gives: the kept samples, and the account of what was dropped and why.
#[derive(Clone, Debug)]
pub struct Preprocessed {
    /// The kept samples.
    pub samples: Arc<SampleSet>,
    /// The account.
    pub report: Report,
}

/// The whole method: scan over time, split into background and foreground, prune between cameras.
///
/// # Errors
/// Whatever the capture gives (naming file and frame), and `Cancelled`.
pub fn preprocess(capture: &Capture, settings: &Settings, job: &Job) -> Result<Preprocessed> {
    let started = Instant::now();
    let scan = scan(capture, settings, job)?;
    let mut preprocessed = prune(capture, &scan, settings, job)?;
    preprocessed.report.seconds = started.elapsed().as_secs_f64();
    Ok(preprocessed)
}

/// The pass over all frames that depends on no threshold: ranges, means and noise of every pixel over time.
///
/// # Errors
/// As [`preprocess`].
pub fn scan(capture: &Capture, settings: &Settings, job: &Job) -> Result<Arc<TemporalScan>> {
    settings.validate("settings")?;
    Ok(Arc::new(temporal::scan(capture, &settings.normals, job)?))
}

/// Everything after [`scan`]: cheap enough to be repeated whenever a threshold changes.
///
/// # Errors
/// As [`preprocess`].
pub fn prune(capture: &Capture, scan: &TemporalScan, settings: &Settings, job: &Job) -> Result<Preprocessed> {
    settings.validate("settings")?;
    let started = Instant::now();
    let frames = capture.frame_count();
    job.start("Pruning the background", 1);
    let background = scan.background(capture, settings, job)?;
    let rig = Rig::new(&capture.cameras);
    let mut tally = Tally::new(capture, scan);
    let mut images = Vec::new();
    tally.add_background(&background);
    images.extend(pack_background(&background, frames, settings));
    job.start("Pruning frames", frames);
    for frame in 0..frames {
        let pruned = prune_frame(capture, &rig, &background, settings, frame, job)?;
        tally.add_foreground(&pruned.decided);
        images.extend(pack_foreground(&pruned, frame, settings));
        job.advance(1);
    }
    let samples = Arc::new(sample_set(capture, settings, images));
    let mut report = tally.finish(&samples);
    report.seconds = started.elapsed().as_secs_f64();
    Ok(Preprocessed { samples, report })
}

/// All verdicts of one frame, for the eye: what [`prune`] decides there, with reasons and witnesses.
///
/// Without a `scan` (still under way) every pixel counts as foreground.
///
/// # Errors
/// As [`preprocess`], and `Invalid` where there is no such frame.
pub fn inspect_frame(
    capture: &Capture,
    scan: Option<&TemporalScan>,
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
    let background = match scan {
        Some(scan) => scan.background(capture, settings, job)?,
        None => Arc::new(Background::none(capture)),
    };
    let rig = Rig::new(&capture.cameras);
    let pruned = prune_frame(capture, &rig, &background, settings, frame, job)?;
    let mut images = pack_background(&background, capture.frame_count(), settings);
    images.extend(pack_foreground(&pruned, frame, settings));
    let cameras =
        (0..capture.cameras.len()).map(|camera| inspect_camera(&background, &pruned, camera)).collect();
    Ok(FrameInspection {
        frame,
        path: vec![all_frames(capture.frame_count()), one_frame(frame)],
        cameras,
        samples: Arc::new(sample_set(capture, settings, images)),
        layers: Arc::new(pruned.layers),
        settings: settings.clone(),
    })
}

fn inspect_camera(background: &Background, pruned: &PrunedFrame, camera: usize) -> CameraInspection {
    let layer = &pruned.layers[camera];
    let (width, height) = (layer.width, layer.height());
    let mut verdicts = vec![Verdict::without_witness(Rule::NoSample); layer.level.len()];
    for decided in [&background.decided[camera], &pruned.decided[camera]] {
        for (&pixel, &verdict) in decided.pixels.iter().zip(&decided.verdicts) {
            verdicts[pixel as usize] = verdict;
        }
    }
    CameraInspection {
        frame: pruned.frames[camera].clone(),
        class: Grid::from_vec(width, height, layer.level.iter().map(|&level| class_of(level)).collect()),
        level: Grid::from_vec(width, height, layer.level.clone()),
        verdict: Grid::from_vec(width, height, verdicts),
        normal_in_world: Grid::from_vec(
            width,
            height,
            layer.normal.iter().map(glam::Vec3::to_array).collect(),
        ),
        footprint: Grid::from_vec(width, height, layer.footprint.clone()),
    }
}

fn class_of(level: Level) -> PixelClass {
    match level {
        NO_SAMPLE => PixelClass::Invalid,
        ROOT => PixelClass::Background,
        _ => PixelClass::Foreground,
    }
}

fn all_frames(frames: usize) -> Span {
    Span { start: 0, end: frames as u32 }
}

fn one_frame(frame: usize) -> Span {
    Span { start: frame as u32, end: frame as u32 + 1 }
}

/// The kept samples of every camera over one span.
fn pack_all(span: Span, layers: &[Layer], decided: &[Decided], settings: &Settings) -> Vec<SampleImage> {
    let cameras = layers.iter().zip(decided).enumerate();
    cameras
        .filter_map(|(camera, (layer, decided))| {
            pack::pack(camera, span, layer, decided, settings.store.normals)
        })
        .collect()
}

fn pack_background(background: &Background, frames: usize, settings: &Settings) -> Vec<SampleImage> {
    pack_all(all_frames(frames), &background.layers, &background.decided, settings)
}

fn pack_foreground(pruned: &PrunedFrame, frame: usize, settings: &Settings) -> Vec<SampleImage> {
    pack_all(one_frame(frame), &pruned.layers, &pruned.decided, settings)
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
