//! Preprocessing and storing: the pass over time, normals, one frame pruned anew, packing, the file.

use std::path::PathBuf;
use std::sync::Arc;

use rayon::prelude::*;

use super::case::{Bench, Case, Measure};
use super::measure::{Times, repeat};
use super::report::MeasuredStage;
use super::scene::{SCENE, without_filling};
use overlook_engine::capture::Frame;
use overlook_engine::capture::overlap::OverlapGraph;
use overlook_engine::demo::{Demo, DemoSpec};
use overlook_engine::edits::{Region, selected};
use overlook_engine::error::{Error, Result};
use overlook_engine::job::Job;
use overlook_engine::preprocess::interactive::FrameLayers;
use overlook_engine::preprocess::noise::measure_pairs;
use overlook_engine::preprocess::normals::{DepthView, estimate_all};
use overlook_engine::preprocess::pruning::{self, FRAME, Verdict};
use overlook_engine::preprocess::temporal::{BATCH, Split, StaticTest};
use overlook_engine::preprocess::{inspect_frame, prepare_frame, prune as prune_capture, scan};
use overlook_engine::render::CpuRenderer;
use overlook_engine::samples::{SampleSet, Span};
use overlook_engine::settings::{AlignSettings, Backend, NormalEstimator, Settings};
use overlook_engine::store::file::Store;
use overlook_engine::store::playback::{DEFAULT_CACHE_BYTES, Playback};
use overlook_engine::store::{self, file};

/// Bytes of a pixel's color (three half floats) and depth.
const PIXEL_BYTES: u64 = 3 * 2 + DEPTH_BYTES;
const DEPTH_BYTES: u64 = 4;

/// Frames that the temporal split is measured on.
const SPLIT_FRAMES: usize = 32;

/// Views of the recording, and bytes of a pixel in the layer of one; layers take up to half of the memory setting.
const VIEWS: usize = 24;
const LAYER_BYTES: u64 = 43;

/// Repeats of a stage, the samples that it works on, and the bytes that it reads or writes at least.
type StageResult = (Times, u64, u64);

/// Every stage before painting.
pub(crate) fn cases() -> Vec<Case> {
    let one = |name: &str, measure: Measure<StageResult>| {
        let stage = name.to_owned();
        let measured = move |bench: &Bench<'_>| {
            let (times, samples, bytes) = measure(bench)?;
            let (backend, name) = (Backend::Cpu, stage.clone());
            Ok(vec![MeasuredStage {
                name,
                backend,
                samples,
                times,
                cpu_ms: None,
                bytes: Some(bytes),
                painting: None,
            }])
        };
        Case { names: vec![name.to_owned()], measure: Box::new(measured) }
    };
    let normals = NormalEstimator::ALL.iter().map(|&estimator| {
        let measure = move |bench: &Bench<'_>| estimate_normals(bench, estimator);
        one(&format!("preprocess/normals/{estimator}"), Box::new(measure))
    });
    let first =
        [one("preprocess/scan", Box::new(scan_frames)), one("preprocess/split", Box::new(split_frames))];
    let others = [
        one("preprocess/prune-frame", Box::new(prune_layers)),
        one("preprocess/prepare-frame", Box::new(prepare)),
        one("preprocess/re-prune-frame", Box::new(|bench| reprune(bench, true))),
        one("preprocess/re-prune-unprepared", Box::new(|bench| reprune(bench, false))),
        one("preprocess/prune-views", Box::new(prune_views)),
        one("preprocess/pack", Box::new(pack_frame)),
        one("edits/select", Box::new(select)),
        one("store/write", Box::new(write_store)),
        one("store/read", Box::new(read_store)),
        one("store/decode-foreground", Box::new(decode_foreground)),
        one("store/first-picture", Box::new(first_picture)),
    ];
    first.into_iter().chain(normals).chain(others).collect()
}

/// A stage that reads color and depth of every pixel of one frame.
fn of_one_frame(bench: &Bench<'_>, times: Times) -> StageResult {
    let pixels = bench.scene.unpruned.sample_count();
    (times, pixels, pixels * PIXEL_BYTES)
}

/// A stage that reads or writes the pruned set.
fn of_pruned_set(bench: &Bench<'_>, times: Times) -> StageResult {
    (times, bench.scene.pruned.sample_count(), bench.scene.pruned.bytes())
}

fn scan_frames(bench: &Bench<'_>) -> Result<StageResult> {
    let pixels = bench.scene.capture.pixel_count();
    let settings = Settings::default();
    let times = repeat(bench.budget, bench.job, || scan(&bench.scene.capture, &settings, bench.job))?;
    Ok((times, pixels, pixels * PIXEL_BYTES))
}

fn split_frames(bench: &Bench<'_>) -> Result<StageResult> {
    let capture = &bench.scene.capture;
    // Each frame a copy of its own, so that it comes from memory.
    let copy = |index| Ok(Arc::new(Frame::clone(&*capture.frame(0, index % capture.frame_count())?)));
    let frames = (0..SPLIT_FRAMES).map(copy).collect::<Result<Vec<_>>>()?;
    let noise = measure_pairs(&[[&frames[0], &frames[1]]]);
    let test = StaticTest::new(&Settings::default().spans, &noise, 0.0, SPLIT_FRAMES);
    let pixels = capture.cameras[0].intrinsics.pixel_count();
    let worked_on = (pixels * SPLIT_FRAMES) as u64;
    let times = repeat(bench.budget, bench.job, || {
        let mut split = Split::new(pixels, SPLIT_FRAMES, test.clone());
        Ok(frames.chunks(BATCH).map(|frames| split.add(frames)).collect::<Vec<_>>())
    })?;
    Ok((times, worked_on, worked_on * PIXEL_BYTES))
}

fn estimate_normals(bench: &Bench<'_>, estimator: NormalEstimator) -> Result<StageResult> {
    let settings = Settings::default().normals;
    let capture = &bench.scene.capture;
    let frames = (0..capture.cameras.len()).map(|camera| capture.frame(camera, 0));
    let frames = frames.collect::<Result<Vec<_>>>()?;
    let times = repeat(bench.budget, bench.job, || {
        let views = frames.iter().zip(&capture.cameras).map(|(frame, camera)| {
            bench.job.check()?;
            let view = DepthView::new(frame.inverse_depth.as_slice(), camera, &settings);
            Ok(estimate_all(&view, estimator))
        });
        views.collect::<Result<Vec<_>>>()
    })?;
    Ok((times, bench.scene.unpruned.sample_count(), bench.scene.unpruned.sample_count() * DEPTH_BYTES))
}

/// Marks what the first camera shows in a square in the middle of its picture, among all samples of all cameras.
fn select(bench: &Bench<'_>) -> Result<StageResult> {
    let set = &bench.scene.unpruned;
    let lens = set.cameras[0].intrinsics;
    let (x, y) = (f64::from(lens.width) / 2.0, f64::from(lens.height) / 2.0);
    let half = y / 4.0;
    let outline = [(-half, -half), (half, -half), (half, half), (-half, half)];
    let region = Region::Pixels {
        camera: set.cameras[0].name.clone(),
        frame: set.frame_numbers.first().copied(),
        outline: outline.map(|(across, down)| [x + across, y + down]).to_vec(),
        strokes: Vec::new(),
    };
    let times = repeat(bench.budget, bench.job, || selected(set, &region, [1.0, 0.5, 0.0], None, "samples"))?;
    Ok((times, set.sample_count(), set.sample_count() * DEPTH_BYTES))
}

/// Repeats with default settings but a new color tolerance each time, so that nothing is taken from an earlier repeat.
fn repeat_with_new_tolerance<T>(bench: &Bench<'_>, work: impl Fn(&Settings) -> Result<T>) -> Result<Times> {
    let mut settings = Settings::default();
    let tolerance = settings.pruning.color_tolerance;
    let mut turn = 0_u8;
    repeat(bench.budget, bench.job, || {
        turn = turn.wrapping_add(1);
        settings.pruning.color_tolerance = tolerance + 0.01 * f32::from(turn);
        work(&settings)
    })
}

fn prune_layers(bench: &Bench<'_>) -> Result<StageResult> {
    let capture = &bench.scene.capture;
    let settings = Settings::default();
    let rig = OverlapGraph::complete(&capture.cameras);
    let complete = FrameLayers::unscanned(capture, &settings, 0, bench.job)?;
    let times = repeat_with_new_tolerance(bench, |settings| complete.prune(&rig, settings, bench.job))?;
    Ok(of_one_frame(bench, times))
}

fn prepare(bench: &Bench<'_>) -> Result<StageResult> {
    let capture = &bench.scene.capture;
    let mut settings = Settings::default();
    let scanned = scan(capture, &settings, bench.job)?;
    // Each time from beyond the reach of the time before.
    let tolerance = [settings.pruning.depth_tolerance, settings.pruning.depth_tolerance * 4.01];
    let mut turn = 0;
    let times = repeat(bench.budget, bench.job, || {
        turn += 1;
        settings.pruning.depth_tolerance = tolerance[turn % 2];
        prepare_frame(capture, &scanned, &settings, 1, bench.job)
    })?;
    Ok(of_one_frame(bench, times))
}

fn reprune(bench: &Bench<'_>, prepared: bool) -> Result<StageResult> {
    let capture = &bench.scene.capture;
    let settings = Settings::default();
    let scanned = scan(capture, &settings, bench.job)?;
    if prepared {
        prepare_frame(capture, &scanned, &settings, 1, bench.job)?;
    }
    let times = repeat_with_new_tolerance(bench, |settings| {
        inspect_frame(capture, Some(&scanned), settings, 1, bench.job)
    })?;
    Ok(of_one_frame(bench, times))
}

/// A recording of many views of one moment, half of whose layers fit into memory at a time.
fn prune_views(bench: &Bench<'_>) -> Result<StageResult> {
    let lens = bench.scene.capture.cameras[0].intrinsics;
    let spec = DemoSpec::new(SCENE).cameras(VIEWS).frames(1).size((lens.width / 2, lens.height / 2));
    let mut settings = Settings { align: AlignSettings::OFF, ..Settings::default() };
    let capture = Demo::new(&spec)?.capture(&settings.capture);
    let pixels = capture.pixel_count();
    settings.capture.memory = ((pixels * LAYER_BYTES) >> 20).max(16) as u32;
    let scanned = scan(&capture, &settings, bench.job)?;
    let times = repeat(bench.budget, bench.job, || prune_capture(&capture, &scanned, &settings, bench.job))?;
    Ok((times, pixels, pixels * PIXEL_BYTES))
}

fn pack_frame(bench: &Bench<'_>) -> Result<StageResult> {
    let capture = &bench.scene.capture;
    let settings = Settings::default();
    let rig = OverlapGraph::complete(&capture.cameras);
    let complete = FrameLayers::unscanned(capture, &settings, 0, bench.job)?;
    let all = complete.prune(&rig, &settings, bench.job)?;
    let span = Span { start: 0, end: 1 };
    let pixels = bench.scene.unpruned.sample_count();
    let verdict_bytes = pixels * size_of::<(u32, Verdict)>() as u64;
    let times = repeat(bench.budget, bench.job, || {
        let cameras = complete.layers.par_iter().enumerate();
        let images = cameras.map(|(camera, layer)| {
            let masks = all.masks(camera, layer, FRAME);
            pruning::pack(camera, span, layer, masks, None, settings.store.normals)
        });
        Ok(images.collect::<Vec<_>>())
    })?;
    Ok((times, pixels, verdict_bytes + bench.scene.pruned.sample_count() * PIXEL_BYTES))
}

/// What preprocessing reports, as JSON: of no weight among the samples.
const EMPTY_REPORT: &str = "{}";

/// A store of the set in a folder that vanishes with what is given, and its path.
fn stored(set: &SampleSet, job: &Job) -> Result<(tempfile::TempDir, PathBuf)> {
    let folder = tempfile::tempdir().map_err(|error| Error::io(std::env::temp_dir(), error))?;
    let path = folder.path().join("speed.ovl");
    file::write(&path, set, EMPTY_REPORT, job)?;
    Ok((folder, path))
}

fn write_store(bench: &Bench<'_>) -> Result<StageResult> {
    let (_folder, path) = stored(&bench.scene.pruned, bench.job)?;
    let set = &bench.scene.pruned;
    let times = repeat(bench.budget, bench.job, || file::write(&path, set, EMPTY_REPORT, bench.job))?;
    Ok(of_pruned_set(bench, times))
}

/// Decodes the foreground of a frame without a reference image: the slowest case of playback.
fn decode_foreground(bench: &Bench<'_>) -> Result<StageResult> {
    let (_folder, path) = stored(&bench.scene.split, bench.job)?;
    let store = Store::open(&path)?;
    let images = store.info().images.iter().enumerate();
    let is_first = |span: Span| span.start == 0 && span.len() == 1;
    let passing: Vec<usize> =
        images.filter(|(_, image)| is_first(image.span)).map(|(index, _)| index).collect();
    // The size of a frame: all its pixels, 8-bit color and 32-bit depth.
    let pixels = bench.scene.unpruned.sample_count();
    let times = repeat(bench.budget, bench.job, || {
        passing.par_iter().map(|&index| store.image(index)).collect::<Result<Vec<_>>>()
    })?;
    Ok((times, pixels, pixels * (3 + DEPTH_BYTES)))
}

fn read_store(bench: &Bench<'_>) -> Result<StageResult> {
    let (_folder, path) = stored(&bench.scene.pruned, bench.job)?;
    let times = repeat(bench.budget, bench.job, || store::read(&path, bench.job))?;
    Ok(of_pruned_set(bench, times))
}

fn first_picture(bench: &Bench<'_>) -> Result<StageResult> {
    let (_folder, path) = stored(&bench.scene.pruned, bench.job)?;
    let size = bench.scene.capture.cameras[0].intrinsics;
    let [vantage, _] = bench.scene.vantages((size.width, size.height), 0);
    let times = repeat(bench.budget, bench.job, || {
        let playback = Playback::new(Store::open(&path)?, DEFAULT_CACHE_BYTES);
        let samples = playback.seen_from(&vantage.camera, vantage.frame, bench.job)?;
        CpuRenderer::new().render(&samples, &vantage, &without_filling(), bench.job)
    })?;
    Ok(of_pruned_set(bench, times))
}
