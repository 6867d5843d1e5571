//! The pass over time, normals, one frame pruned anew, packing, selecting. Rates are of pixels of the recording.

use std::sync::Arc;

use divan::Bencher;
use divan::counter::ItemsCount;
use rayon::prelude::*;

use crate::scene::{CAMERA_SIZE, MEASURED, SCENE};
use overlook_engine::capture::Frame;
use overlook_engine::capture::overlap::OverlapGraph;
use overlook_engine::demo::{Demo, DemoSpec};
use overlook_engine::edits::{Region, selected};
use overlook_engine::job::Job;
use overlook_engine::preprocess::interactive::FrameLayers;
use overlook_engine::preprocess::noise::measure_pairs;
use overlook_engine::preprocess::normals::{DepthView, estimate_all};
use overlook_engine::preprocess::pruning::{self, FRAME};
use overlook_engine::preprocess::temporal::{BATCH, Split, StaticTest};
use overlook_engine::preprocess::{inspect_frame, prepare_frame, prune, scan};
use overlook_engine::samples::Span;
use overlook_engine::settings::{AlignSettings, NormalEstimator, Settings};

/// Frames that the temporal split is measured on.
const SPLIT_FRAMES: usize = 32;

/// Views of a recording of one moment, and bytes of a pixel in the layer of one; layers take up to half of the memory setting.
const VIEWS: usize = 24;
const LAYER_BYTES: u64 = 43;

/// Pixels of one frame of all cameras.
fn frame_pixels() -> ItemsCount {
    ItemsCount::new(MEASURED.unpruned.sample_count())
}

/// Default settings with another color tolerance each time, so that nothing is taken from an earlier run.
fn new_tolerance() -> impl FnMut() -> Settings {
    let mut turn = 0_u8;
    move || {
        turn = turn.wrapping_add(1);
        let mut settings = Settings::default();
        settings.pruning.color_tolerance += 0.01 * f32::from(turn);
        settings
    }
}

#[divan::bench]
fn scan_frames(bencher: Bencher) {
    let capture = &MEASURED.capture;
    let bencher = bencher.counter(ItemsCount::new(capture.pixel_count()));
    bencher.bench(|| scan(capture, &Settings::default(), &Job::new()).unwrap());
}

#[divan::bench]
fn split(bencher: Bencher) {
    let capture = &MEASURED.capture;
    // Each frame a copy of its own, so that it comes from memory.
    let copy = |index| Arc::new(Frame::clone(&*capture.frame(0, index % capture.frame_count()).unwrap()));
    let frames: Vec<_> = (0..SPLIT_FRAMES).map(copy).collect();
    let noise = measure_pairs(&[[&frames[0], &frames[1]]]);
    let test = StaticTest::new(&Settings::default().spans, &noise, 0.0, SPLIT_FRAMES);
    let pixels = capture.cameras[0].intrinsics.pixel_count();
    bencher.counter(ItemsCount::new(pixels * SPLIT_FRAMES)).bench(|| {
        let mut split = Split::new(pixels, SPLIT_FRAMES, test.clone());
        frames.chunks(BATCH).map(|frames| split.add(frames)).collect::<Vec<_>>()
    });
}

#[divan::bench(args = NormalEstimator::ALL)]
fn normals(bencher: Bencher, estimator: NormalEstimator) {
    let settings = Settings::default().normals;
    let capture = &MEASURED.capture;
    let frames: Vec<_> = (0..capture.cameras.len()).map(|camera| capture.frame(camera, 0).unwrap()).collect();
    bencher.counter(frame_pixels()).bench(|| {
        let views = frames.iter().zip(&capture.cameras).map(|(frame, camera)| {
            estimate_all(&DepthView::new(frame.inverse_depth.as_slice(), camera, &settings), estimator)
        });
        views.collect::<Vec<_>>()
    });
}

#[divan::bench]
fn prune_frame(bencher: Bencher) {
    let capture = &MEASURED.capture;
    let rig = OverlapGraph::complete(&capture.cameras);
    let layers = FrameLayers::unscanned(capture, &Settings::default(), 0, &Job::new()).unwrap();
    let bencher = bencher.counter(frame_pixels()).with_inputs(new_tolerance());
    bencher.bench_local_refs(|settings| layers.prune(&rig, settings, &Job::new()).unwrap());
}

/// Each time from beyond the reach of the time before.
#[divan::bench]
fn prepare(bencher: Bencher) {
    let capture = &MEASURED.capture;
    let scanned = scan(capture, &Settings::default(), &Job::new()).unwrap();
    let mut is_wide = false;
    let settings = move || {
        let mut settings = Settings::default();
        is_wide = !is_wide;
        if is_wide {
            settings.pruning.depth_tolerance *= 4.01;
        }
        settings
    };
    let bencher = bencher.counter(frame_pixels()).with_inputs(settings);
    bencher.bench_local_refs(|settings| prepare_frame(capture, &scanned, settings, 1, &Job::new()).unwrap());
}

#[divan::bench(args = [true, false])]
fn prune_again_if_prepared(bencher: Bencher, is_prepared: bool) {
    let capture = &MEASURED.capture;
    let scanned = scan(capture, &Settings::default(), &Job::new()).unwrap();
    if is_prepared {
        prepare_frame(capture, &scanned, &Settings::default(), 1, &Job::new()).unwrap();
    }
    let bencher = bencher.counter(frame_pixels()).with_inputs(new_tolerance());
    bencher.bench_local_refs(|settings| {
        inspect_frame(capture, Some(&scanned), settings, 1, &Job::new()).unwrap()
    });
}

/// A recording of many views of one moment, half of whose layers fit into memory at a time.
#[divan::bench]
fn prune_views(bencher: Bencher) {
    let size = (CAMERA_SIZE.0 / 2, CAMERA_SIZE.1 / 2);
    let mut settings = Settings { align: AlignSettings::OFF, ..Settings::default() };
    let demo = Demo::new(&DemoSpec::new(SCENE).cameras(VIEWS).frames(1).size(size)).unwrap();
    let capture = demo.capture(&settings.capture);
    let pixels = capture.pixel_count();
    settings.capture.memory = ((pixels * LAYER_BYTES) >> 20).max(16) as u32;
    let scanned = scan(&capture, &settings, &Job::new()).unwrap();
    let bencher = bencher.counter(ItemsCount::new(pixels));
    bencher.bench(|| prune(&capture, &scanned, &settings, &Job::new()).unwrap());
}

#[divan::bench]
fn pack(bencher: Bencher) {
    let capture = &MEASURED.capture;
    let settings = Settings::default();
    let rig = OverlapGraph::complete(&capture.cameras);
    let frame = FrameLayers::unscanned(capture, &settings, 0, &Job::new()).unwrap();
    let pruned = frame.prune(&rig, &settings, &Job::new()).unwrap();
    let span = Span { start: 0, end: 1 };
    bencher.counter(frame_pixels()).bench(|| {
        let images = frame.layers.par_iter().enumerate().map(|(camera, layer)| {
            let masks = pruned.masks(camera, layer, FRAME);
            pruning::pack(camera, span, layer, masks, None, settings.store.normals)
        });
        images.collect::<Vec<_>>()
    });
}

/// Marks what the first camera shows in a square in the middle of its picture, among all samples of all cameras.
#[divan::bench]
fn select(bencher: Bencher) {
    let set = &MEASURED.unpruned;
    let (x, y) = (f64::from(CAMERA_SIZE.0) / 2.0, f64::from(CAMERA_SIZE.1) / 2.0);
    let half = y / 4.0;
    let outline = [(-half, -half), (half, -half), (half, half), (-half, half)];
    let region = Region::Pixels {
        camera: set.cameras[0].name.clone(),
        frame: set.frame_numbers.first().copied(),
        outline: outline.map(|(across, down)| [x + across, y + down]).to_vec(),
        strokes: Vec::new(),
    };
    let bencher = bencher.counter(frame_pixels());
    bencher.bench(|| selected(set, &region, [1.0, 0.5, 0.0], None, "samples", &Job::new()).unwrap());
}
