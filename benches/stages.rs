//! Speed of each stage on built-in scenes. `cargo bench` prints medians; compare two runs of one machine only.

use std::hint::black_box;
use std::sync::Arc;
use std::time::Duration;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use overlook::evaluate::speed::scene::recorded;
use overlook::job::Job;
use overlook::preprocess::batch::BATCH;
use overlook::preprocess::noise::measure_pairs;
use overlook::preprocess::rig::Rig;
use overlook::preprocess::split::Split;
use overlook::preprocess::static_test::StaticTest;
use overlook::preprocess::{inspect_frame, preprocess, scan};
use overlook::render::{CpuRenderer, Vantage};
use overlook::settings::{Kernel, RenderSettings, Settings};
use overlook::store;

fn preprocessing(c: &mut Criterion) {
    let job = Job::new();
    let (_, capture) = recorded("nine-cameras", 3, (640, 480), &job).expect("a recorded scene");
    let settings = Settings::default();
    let mut group = c.benchmark_group("nine 640×480 cameras");
    group.sample_size(10).measurement_time(Duration::from_secs(8));
    group.throughput(Throughput::Elements(capture.pixel_count()));
    group.bench_function("scan of three frames", |b| {
        b.iter(|| scan(&capture, &settings, &job).expect("a scan"));
    });
    let frames: Vec<_> = (0..32).map(|frame| capture.frame(0, frame % 3).expect("a frame")).collect();
    let noise = measure_pairs(&[[&frames[0], &frames[1]]]);
    let test = StaticTest::new(&settings.spans, &noise, 0.0, frames.len());
    let pixels = capture.cameras[0].intrinsics.pixel_count();
    group.throughput(Throughput::Elements((pixels * frames.len()) as u64));
    group.bench_function("temporal split of one camera, 32 frames", |b| {
        b.iter(|| {
            let mut split = Split::new(pixels, frames.len(), test.clone());
            frames.chunks(BATCH).map(|frames| split.add(frames)).collect::<Vec<_>>()
        });
    });
    let scanned = scan(&capture, &settings, &job).expect("a scan");
    group.throughput(Throughput::Elements(capture.pixel_count() / 3));
    let rig = Rig::new(&capture.cameras);
    let layers = scanned.frame_layers(&capture, &rig, &settings, 1, &job).expect("layers");
    layers.prepare(&rig, &settings, &job).expect("a docket").expect("one that fits into memory");
    let mut changed = settings.clone();
    group.bench_function("one prepared frame after a threshold change", |b| {
        b.iter(|| {
            // Another value each time, within what the frame was prepared for.
            let tolerance = &mut changed.pruning.color_tolerance;
            *tolerance = if *tolerance > 30.0 { 24.0 } else { *tolerance + 0.01 };
            layers.prune(&rig, &changed, &job).expect("verdicts")
        });
    });
    let mut frame = 0;
    group.bench_function("one frame more", |b| {
        b.iter(|| {
            // The one before is remembered, with what it was prepared for.
            frame = 2 - frame;
            inspect_frame(&capture, Some(&scanned), &settings, frame, &job).expect("an inspection")
        });
    });
    group.finish();
}

fn rendering(c: &mut Criterion) {
    let job = Job::new();
    let (demo, capture) = recorded("nine-cameras", 2, (640, 480), &job).expect("a recorded scene");
    let samples = preprocess(&capture, &Settings::default(), &job).expect("preprocessed").samples;
    let home = demo.home();
    let mut group = c.benchmark_group("rendering 640×480");
    group.sample_size(20).measurement_time(Duration::from_secs(6));
    for kernel in Kernel::ALL {
        let settings = RenderSettings { kernel: *kernel, ..RenderSettings::default() };
        let vantage = |frame| Vantage { camera: home.clone(), frame };
        group.bench_function(format!("{kernel}, everything"), |b| {
            b.iter(|| CpuRenderer::new().render(&samples, &vantage(0), &settings, &job).expect("a picture"));
        });
        let mut still = CpuRenderer::new();
        group.bench_function(format!("{kernel}, over the cached background"), |b| {
            b.iter(|| still.render(&samples, &vantage(0), &settings, &job).expect("a picture"));
        });
    }
    group.finish();
}

fn storing(c: &mut Criterion) {
    let job = Job::new();
    let (_, capture) = recorded("orrery", 4, (480, 360), &job).expect("a recorded scene");
    let preprocessed = preprocess(&capture, &Settings::default(), &job).expect("preprocessed");
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("bench.ovl");
    let mut group = c.benchmark_group("store");
    group.sample_size(10).throughput(Throughput::Bytes(preprocessed.samples.bytes()));
    group.bench_function("write", |b| {
        b.iter(|| store::write(&path, &preprocessed.samples, &preprocessed.report, &job).expect("written"));
    });
    group.bench_function("read", |b| b.iter(|| black_box(Arc::new(store::read(&path, &job).expect("read")))));
    group.finish();
}

criterion_group!(stages, preprocessing, rendering, storing);
criterion_main!(stages);
