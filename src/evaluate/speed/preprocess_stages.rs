//! Preprocessing and storing: the pass over time, normals, one frame pruned anew, packing, the file.

use std::sync::Arc;

use rayon::prelude::*;

use super::Bench;
use super::measure::{Times, repeat};
use super::report::{Bound, Measured};
use crate::capture::Frame;
use crate::error::{Error, Result};
use crate::preprocess::batch::BATCH;
use crate::preprocess::depth_view::DepthView;
use crate::preprocess::descent::FRAME;
use crate::preprocess::frame_layers::FrameLayers;
use crate::preprocess::noise::measure_pairs;
use crate::preprocess::normals::estimate_all;
use crate::preprocess::pruning::prune;
use crate::preprocess::rig::Rig;
use crate::preprocess::split::Split;
use crate::preprocess::static_test::StaticTest;
use crate::preprocess::status::no_statuses;
use crate::preprocess::{Report, Span, Verdict, inspect_frame, pack, prepare_frame, scan};
use crate::render::CpuRenderer;
use crate::settings::{Backend, NormalEstimator, RenderSettings, Settings};
use crate::store;

/// Bytes of a pixel's color (three half floats) and depth.
const PIXEL_BYTES: u64 = 3 * 2 + DEPTH_BYTES;
const DEPTH_BYTES: u64 = 4;

/// A stage before painting.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PreprocessCase {
    /// What stays the same over all recorded frames.
    Scan,
    /// The temporal split of one camera, from frames in memory to the samples of every span.
    Split,
    /// Normals of every pixel at one frame.
    Normals(NormalEstimator),
    /// The verdicts on every pixel of one frame, from layers that are ready: all cameras against all others.
    Prune,
    /// Making one frame ready for its thresholds to be turned: for every sample, who may stand for it.
    Docket,
    /// All verdicts of one frame after a pruning threshold changed, the background's included, and what is kept, packed.
    Reprune,
    /// The same for a frame that was not made ready.
    RepruneUnprepared,
    /// From verdicts to sparse images, one frame.
    Pack,
    /// The pruned set to a file.
    StoreWrite,
    /// The pruned set from a file that the system has in memory.
    StoreRead,
    /// The foreground of one frame from such a file: what playback does.
    StoreDecode,
    /// Opening such a file and painting its first frame: the blocks that the picture needs, decoded and painted.
    StoreFirstPicture,
}

/// Frames that the temporal split is measured on.
const SPLIT_FRAMES: usize = 32;

/// Every stage before painting.
pub(super) fn cases() -> Vec<PreprocessCase> {
    let normals = NormalEstimator::ALL.iter().copied().map(PreprocessCase::Normals);
    let others = [
        PreprocessCase::Prune,
        PreprocessCase::Docket,
        PreprocessCase::Reprune,
        PreprocessCase::RepruneUnprepared,
        PreprocessCase::Pack,
        PreprocessCase::StoreWrite,
        PreprocessCase::StoreRead,
        PreprocessCase::StoreDecode,
        PreprocessCase::StoreFirstPicture,
    ];
    [PreprocessCase::Scan, PreprocessCase::Split].into_iter().chain(normals).chain(others).collect()
}

impl PreprocessCase {
    /// The stage that comes of it.
    pub(super) fn name(self) -> String {
        match self {
            Self::Scan => "preprocess/scan".to_owned(),
            Self::Split => "preprocess/split".to_owned(),
            Self::Normals(estimator) => format!("preprocess/normals/{estimator}"),
            Self::Prune => "preprocess/prune-frame".to_owned(),
            Self::Docket => "preprocess/prepare-frame".to_owned(),
            Self::Reprune => "preprocess/re-prune-frame".to_owned(),
            Self::RepruneUnprepared => "preprocess/re-prune-unprepared".to_owned(),
            Self::Pack => "preprocess/pack".to_owned(),
            Self::StoreWrite => "store/write".to_owned(),
            Self::StoreRead => "store/read".to_owned(),
            Self::StoreDecode => "store/decode-foreground".to_owned(),
            Self::StoreFirstPicture => "store/first-picture".to_owned(),
        }
    }

    /// Measures with the threads of the current pool.
    ///
    /// # Errors
    /// `Cancelled`, and what the stage gives.
    pub(super) fn measure(self, bench: &Bench<'_>) -> Result<Measured> {
        let all_frames = bench.scene.capture.pixel_count();
        let one_frame = bench.scene.unpruned.sample_count();
        let pruned = &bench.scene.pruned;
        let (times, samples, bytes) = match self {
            Self::Scan => (scan_frames(bench)?, all_frames, all_frames * PIXEL_BYTES),
            Self::Split => {
                let pixels = bench.scene.capture.cameras[0].intrinsics.pixel_count() * SPLIT_FRAMES;
                (split_frames(bench)?, pixels as u64, pixels as u64 * PIXEL_BYTES)
            }
            Self::Normals(estimator) => {
                (estimate_normals(bench, estimator)?, one_frame, one_frame * DEPTH_BYTES)
            }
            Self::Prune => (prune_layers(bench)?, one_frame, one_frame * PIXEL_BYTES),
            Self::Docket => (prepare(bench)?, one_frame, one_frame * PIXEL_BYTES),
            Self::Reprune => (reprune(bench, true)?, one_frame, one_frame * PIXEL_BYTES),
            Self::RepruneUnprepared => (reprune(bench, false)?, one_frame, one_frame * PIXEL_BYTES),
            Self::Pack => {
                let verdicts = one_frame * size_of::<(u32, Verdict)>() as u64;
                (pack_frame(bench)?, one_frame, verdicts + pruned.sample_count() * PIXEL_BYTES)
            }
            Self::StoreWrite => (write_store(bench)?, pruned.sample_count(), pruned.bytes()),
            Self::StoreRead => (read_store(bench)?, pruned.sample_count(), pruned.bytes()),
            // What the frame stands for: all its pixels, 8-bit color and 32-bit depth.
            Self::StoreDecode => (decode_foreground(bench)?, one_frame, one_frame * (3 + DEPTH_BYTES)),
            Self::StoreFirstPicture => (first_picture(bench)?, pruned.sample_count(), pruned.bytes()),
        };
        Ok(Measured {
            name: self.name(),
            backend: Backend::Cpu,
            threads: rayon::current_num_threads(),
            samples,
            times,
            bound: Bound::Read { bytes },
        })
    }
}

fn scan_frames(bench: &Bench<'_>) -> Result<Times> {
    let settings = Settings::default();
    repeat(bench.budget, bench.job, || scan(&bench.scene.capture, &settings, bench.job))
}

fn split_frames(bench: &Bench<'_>) -> Result<Times> {
    let capture = &bench.scene.capture;
    // Each frame a copy of its own, so that it comes from memory.
    let copy = |index| Ok(Arc::new(Frame::clone(&*capture.frame(0, index % capture.frame_count())?)));
    let frames = (0..SPLIT_FRAMES).map(copy).collect::<Result<Vec<_>>>()?;
    let noise = measure_pairs(&[[&frames[0], &frames[1]]]);
    let test = StaticTest::new(&Settings::default().spans, &noise, 0.0, SPLIT_FRAMES);
    let pixels = capture.cameras[0].intrinsics.pixel_count();
    repeat(bench.budget, bench.job, || {
        let mut split = Split::new(pixels, SPLIT_FRAMES, test.clone());
        Ok(frames.chunks(BATCH).map(|frames| split.add(frames)).collect::<Vec<_>>())
    })
}

fn estimate_normals(bench: &Bench<'_>, estimator: NormalEstimator) -> Result<Times> {
    let settings = Settings::default().normals;
    let capture = &bench.scene.capture;
    let frames = (0..capture.cameras.len()).map(|camera| capture.frame(camera, 0));
    let frames = frames.collect::<Result<Vec<_>>>()?;
    repeat(bench.budget, bench.job, || {
        let views = frames.iter().zip(&capture.cameras).map(|(frame, camera)| {
            bench.job.check()?;
            let view = DepthView::new(frame.inverse_depth.as_slice(), camera, &settings);
            Ok(estimate_all(&view, estimator))
        });
        views.collect::<Result<Vec<_>>>()
    })
}

fn prune_layers(bench: &Bench<'_>) -> Result<Times> {
    let capture = &bench.scene.capture;
    let mut settings = Settings::default();
    let rig = Rig::new(&capture.cameras);
    let complete = FrameLayers::unscanned(capture, &rig, &settings, 0, bench.job)?;
    let layers = &complete.layers;
    let tolerance = settings.pruning.color_tolerance;
    let mut turn = 0_u8;
    repeat(bench.budget, bench.job, || {
        turn = turn.wrapping_add(1);
        settings.pruning.color_tolerance = tolerance + 0.01 * f32::from(turn);
        let statuses = no_statuses(layers);
        prune(&rig, layers, &statuses, FRAME, &settings, bench.job)
    })
}

fn prepare(bench: &Bench<'_>) -> Result<Times> {
    let capture = &bench.scene.capture;
    let mut settings = Settings::default();
    let scanned = scan(capture, &settings, bench.job)?;
    // Each time from beyond the reach of the time before.
    let tolerance = [settings.pruning.depth_tolerance, settings.pruning.depth_tolerance * 4.01];
    let mut turn = 0;
    repeat(bench.budget, bench.job, || {
        turn += 1;
        settings.pruning.depth_tolerance = tolerance[turn % 2];
        prepare_frame(capture, &scanned, &settings, 1, bench.job)
    })
}

fn reprune(bench: &Bench<'_>, prepared: bool) -> Result<Times> {
    let capture = &bench.scene.capture;
    let mut settings = Settings::default();
    let scanned = scan(capture, &settings, bench.job)?;
    if prepared {
        prepare_frame(capture, &scanned, &settings, 1, bench.job)?;
    }
    let tolerance = settings.pruning.color_tolerance;
    let mut turn = 0_u8;
    repeat(bench.budget, bench.job, || {
        // Another value each time, so that nothing is taken from an earlier run.
        turn = turn.wrapping_add(1);
        settings.pruning.color_tolerance = tolerance + 0.01 * f32::from(turn);
        inspect_frame(capture, Some(&scanned), &settings, 1, bench.job)
    })
}

fn pack_frame(bench: &Bench<'_>) -> Result<Times> {
    let capture = &bench.scene.capture;
    let settings = Settings::default();
    let rig = Rig::new(&capture.cameras);
    let complete = FrameLayers::unscanned(capture, &rig, &settings, 0, bench.job)?;
    let all = complete.prune(&rig, &settings, bench.job)?;
    let span = Span { start: 0, end: 1 };
    repeat(bench.budget, bench.job, || {
        let cameras = complete.layers.par_iter().enumerate();
        let images = cameras.map(|(camera, layer)| {
            let masks = all.masks(camera, layer, FRAME);
            pack::pack(camera, span, layer, masks, settings.store.normals)
        });
        Ok(images.collect::<Vec<_>>())
    })
}

/// A folder that vanishes with what is in it.
fn folder() -> Result<tempfile::TempDir> {
    tempfile::tempdir().map_err(|error| Error::io(std::env::temp_dir(), error))
}

fn write_store(bench: &Bench<'_>) -> Result<Times> {
    let folder = folder()?;
    let path = folder.path().join("speed.ovl");
    let report = Report::default();
    repeat(bench.budget, bench.job, || store::write(&path, &bench.scene.pruned, &report, bench.job))
}

/// Decodes the foreground of a frame, block by block and predicted from nothing but itself: what playback does for every frame, at
/// its slowest.
fn decode_foreground(bench: &Bench<'_>) -> Result<Times> {
    let folder = folder()?;
    let path = folder.path().join("speed.ovl");
    store::write(&path, &bench.scene.split, &Report::default(), bench.job)?;
    let store = store::Store::open(&path)?;
    let images = store.info().images.iter().enumerate();
    let is_first = |span: Span| span.start == 0 && span.len() == 1;
    let passing: Vec<usize> =
        images.filter(|(_, image)| is_first(image.span)).map(|(index, _)| index).collect();
    repeat(bench.budget, bench.job, || {
        passing.par_iter().map(|&index| store.image(index)).collect::<Result<Vec<_>>>()
    })
}

fn read_store(bench: &Bench<'_>) -> Result<Times> {
    let folder = folder()?;
    let path = folder.path().join("speed.ovl");
    store::write(&path, &bench.scene.pruned, &Report::default(), bench.job)?;
    repeat(bench.budget, bench.job, || store::read(&path, bench.job))
}

fn first_picture(bench: &Bench<'_>) -> Result<Times> {
    let folder = folder()?;
    let path = folder.path().join("speed.ovl");
    store::write(&path, &bench.scene.pruned, &Report::default(), bench.job)?;
    let size = bench.scene.capture.cameras[0].intrinsics;
    let [vantage, _] = bench.scene.vantages((size.width, size.height), 0);
    repeat(bench.budget, bench.job, || {
        let playback = store::Playback::new(store::Store::open(&path)?, store::DEFAULT_CACHE_BYTES);
        let samples = playback.seen_from(&vantage.camera, vantage.frame, bench.job)?;
        CpuRenderer::new().render(&samples, &vantage, &RenderSettings::default(), bench.job)
    })
}
