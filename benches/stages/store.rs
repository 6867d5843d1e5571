//! Writing and reading stores. Rates are of samples, or of bytes of the input where a frame is decoded.

use std::path::PathBuf;

use divan::Bencher;
use divan::counter::{BytesCount, ItemsCount};
use rayon::prelude::*;

use crate::scene::{CAMERA_SIZE, MEASURED, without_filling};
use overlook_engine::job::Job;
use overlook_engine::render::CpuRenderer;
use overlook_engine::samples::SampleSet;
use overlook_engine::store::file::Store;
use overlook_engine::store::playback::{DEFAULT_CACHE_BYTES, Playback};
use overlook_engine::store::{self, file};

/// What preprocessing reports, as JSON: of no weight among the samples.
const EMPTY_REPORT: &str = "{}";

/// Bytes of a pixel of the input: 8-bit color and 32-bit depth.
const INPUT_BYTES: u64 = 3 + 4;

/// A store of the set in a folder that is removed with what is given, and its path.
fn stored(set: &SampleSet) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("speed.ovl");
    file::write(&path, set, EMPTY_REPORT, &Job::new()).unwrap();
    (folder, path)
}

fn pruned_samples() -> ItemsCount {
    ItemsCount::new(MEASURED.pruned.sample_count())
}

#[divan::bench]
fn write(bencher: Bencher) {
    let (_folder, path) = stored(&MEASURED.pruned);
    let bencher = bencher.counter(pruned_samples());
    bencher.bench(|| file::write(&path, &MEASURED.pruned, EMPTY_REPORT, &Job::new()).unwrap());
}

#[divan::bench]
fn read(bencher: Bencher) {
    let (_folder, path) = stored(&MEASURED.pruned);
    bencher.counter(pruned_samples()).bench(|| store::read(&path, &Job::new()).unwrap());
}

/// Decodes what moves at a frame, without a reference image: the slowest case of playback.
#[divan::bench]
fn decode_foreground(bencher: Bencher) {
    let (_folder, path) = stored(&MEASURED.split);
    let store = Store::open(&path).unwrap();
    let images = store.info().images.iter().enumerate();
    let moving = images.filter(|(_, image)| image.span.start == 0 && image.span.len() == 1);
    let moving: Vec<usize> = moving.map(|(index, _)| index).collect();
    let bencher = bencher.counter(BytesCount::new(MEASURED.unpruned.sample_count() * INPUT_BYTES));
    bencher.bench(|| moving.par_iter().map(|&index| store.image(index).unwrap()).collect::<Vec<_>>());
}

#[divan::bench]
fn first_picture(bencher: Bencher) {
    let (_folder, path) = stored(&MEASURED.pruned);
    let [vantage, _] = MEASURED.vantages(CAMERA_SIZE, 0);
    bencher.counter(pruned_samples()).bench(|| {
        let playback = Playback::new(Store::open(&path).unwrap(), DEFAULT_CACHE_BYTES);
        let samples = playback.seen_from(&vantage.camera, vantage.frame, &Job::new()).unwrap();
        CpuRenderer::new().render(&samples, &vantage, &without_filling(), &Job::new()).unwrap()
    });
}
