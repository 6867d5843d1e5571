//! What a store says became of every pixel: what its capture says, at no cost to any sample.

use overlook_engine::capture::Capture;
use overlook_engine::demo::{Demo, DemoSpec};
use overlook_engine::edits::EditList;
use overlook_engine::job::Job;
use overlook_engine::preprocess::inspect::FrameInspection;
use overlook_engine::preprocess::pruning::Rule;
use overlook_engine::preprocess::{PreparedScan, inspect_frame, preprocess_edited, scan};
use overlook_engine::settings::{CaptureSettings, Settings, StoreSettings};
use overlook_engine::store;
use overlook_engine::store::file::{Extras, Store, write_spooled};
use overlook_engine::store::playback::Playback;
use overlook_engine::stored_verdicts::{inspect_stored_frame, verdict_in_store};
use std::path::Path;
use std::sync::Arc;

fn capture(scene: &str) -> Capture {
    let demo = Demo::new(&DemoSpec::new(scene).cameras(4).frames(5).size((150, 100))).unwrap();
    demo.capture(&CaptureSettings::default())
}

/// Settings by which verdicts are stored whatever they take.
fn all_verdicts() -> Settings {
    let mut settings = Settings::default();
    settings.store.verdicts = 4.0;
    settings
}

/// Writes a capture's store, by so many threads.
fn written(capture: &Capture, settings: &Settings, path: &Path, threads: usize) -> Vec<u8> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    pool.install(|| {
        let job = Job::new();
        let result = preprocess_edited(capture, settings, &EditList::default(), &job).unwrap();
        let extras = Extras { verdicts: result.verdicts, ..Extras::default() };
        write_spooled(path, &result.outline, &result.images, &extras, &job).unwrap();
    });
    std::fs::read(path).unwrap()
}

#[test]
fn a_store_gives_the_verdict_of_every_pixel_as_its_capture_has_it_whatever_the_threads() {
    let folder = tempfile::tempdir().unwrap();
    for scene in ["nine-cameras", "orrery"] {
        let (capture, settings, job) = (capture(scene), all_verdicts(), Job::new());
        let path = folder.path().join("scene.ovl");
        let bytes = written(&capture, &settings, &path, 3);
        assert_eq!(written(&capture, &settings, &folder.path().join("again.ovl"), 1), bytes, "{scene}");
        let scanned: Arc<PreparedScan> = scan(&capture, &settings, &job).unwrap();
        let playback = Playback::new(Store::open(&path).unwrap(), 1 << 20);
        let mut rules = std::collections::BTreeSet::new();
        for frame in 0..capture.frame_count() {
            let inspection = inspect_frame(&capture, Some(&scanned), &settings, frame, &job).unwrap();
            for (camera, inspected) in inspection.cameras.iter().enumerate() {
                for (x, y) in (0..100).flat_map(|y| (0..150).map(move |x| (x, y))) {
                    // Each pixel in turn decodes its block: a lattice of them, and all of one camera at one frame.
                    if (frame, camera) != (2, 1) && (x % 7, y % 5) != (frame, camera) {
                        continue;
                    }
                    let expected = inspected.verdict[(x, y)];
                    let (span, found) = verdict_in_store(playback.store(), frame, camera, (x, y)).unwrap();
                    let place = format!("{scene}: camera {camera}, {x}, {y}, frame {frame}");
                    assert_eq!(
                        (found.rule, found.witness_camera),
                        (expected.rule, expected.witness_camera),
                        "{place}"
                    );
                    if found.rule != Rule::NoSample {
                        let level = inspected.level[(x, y)];
                        assert_eq!(span, inspection.path[usize::from(level)], "{place}");
                    }
                    let sample = playback.sample_at(frame, camera, (x, y), &job).unwrap();
                    assert_eq!(sample.is_some(), found.is_kept(), "{place}");
                    rules.insert(found.rule);
                }
                let mut seen = 0;
                playback
                    .store()
                    .each_verdict(frame, camera, |at, _, verdict| {
                        assert_eq!(verdict.rule, inspected.verdict[at].rule as u8);
                        seen += 1;
                    })
                    .unwrap();
                let with_depth = inspected.verdict.as_slice().iter().filter(|v| v.rule != Rule::NoSample);
                assert_eq!(seen, with_depth.count(), "{scene}: camera {camera}, frame {frame}");
            }
        }
        assert!(rules.len() > 3, "{scene}: only {rules:?}");
    }
}

#[test]
fn a_frame_of_a_store_is_inspected_as_that_of_its_capture_and_dropped_pixels_look_as_they_did() {
    let folder = tempfile::tempdir().unwrap();
    let (capture, settings, job) = (capture("nine-cameras"), all_verdicts(), Job::new());
    let path = folder.path().join("scene.ovl");
    written(&capture, &settings, &path, 2);
    let scanned = scan(&capture, &settings, &job).unwrap();
    let playback = Playback::new(Store::open(&path).unwrap(), 1 << 24);
    let expected = inspect_frame(&capture, Some(&scanned), &settings, 3, &job).unwrap();
    let found = inspect_stored_frame(&playback, 3, &job).unwrap().expect("the store says why");
    assert!(found.is_of_store() && !expected.is_of_store());
    assert_eq!(found.samples.sample_count(), expected.samples.sample_count());
    for (camera, (found_in, expected_in)) in found.cameras.iter().zip(&expected.cameras).enumerate() {
        assert_eq!(found_in.class, expected_in.class);
        let (mut error, mut dropped) = (0.0, 0.0);
        for (x, y) in (0..100).flat_map(|y| (0..150).map(move |x| (x, y))) {
            let (verdict, true_verdict) = (found_in.verdict[(x, y)], expected_in.verdict[(x, y)]);
            assert_eq!(
                (verdict.rule, verdict.witness_camera),
                (true_verdict.rule, true_verdict.witness_camera)
            );
            let colors = [found_in, expected_in].map(|camera| camera.frame.color[(x, y)]);
            let inverse_depth = found_in.frame.inverse_depth[(x, y)];
            if verdict.rule == Rule::NoSample {
                assert!(inverse_depth < 0.0);
            } else {
                let span = |of: &FrameInspection, level: u8| of.path[usize::from(level)];
                let levels = [found_in, expected_in].map(|camera| camera.level[(x, y)]);
                assert_eq!(span(&found, levels[0]), span(&expected, levels[1]));
                dropped += f32::from(!verdict.is_kept());
            }
            if verdict.is_kept() {
                let mut images = found.samples.images.iter().filter(|image| image.camera as usize == camera);
                let sample = images.find_map(|image| {
                    image.sample_at(x, y).map(|(nth, inverse_depth)| (image.color[nth], inverse_depth))
                });
                assert_eq!(Some((colors[0], inverse_depth)), sample);
            } else if verdict.rule != Rule::NoSample {
                let [own, recorded] = colors.map(|color| color.map(f32::from));
                error += own.iter().zip(recorded).map(|(a, b)| (a - b).powi(2)).sum::<f32>() / 3.0;
            }
        }
        assert!(
            dropped > 1000.0 && error / dropped < 0.002,
            "camera {camera}: {} of {dropped}",
            error / dropped
        );
    }
    assert!(found.log2_sampling_ratio(0, None).as_slice().iter().all(|ratio| ratio.is_nan()));
    assert!(found.agreement(0).as_slice().iter().all(Option::is_none));
    let bare = folder.path().join("bare.ovl");
    let without = Settings { store: StoreSettings { verdicts: 0.0, ..settings.store.clone() }, ..settings };
    written(&capture, &without, &bare, 2);
    let playback = Playback::new(Store::open(&bare).unwrap(), 1 << 24);
    assert!(inspect_stored_frame(&playback, 3, &job).unwrap().is_none());
}

#[test]
fn verdicts_change_no_sample_are_kept_by_whoever_copies_them_and_go_where_they_are_not_wanted() {
    let folder = tempfile::tempdir().unwrap();
    let (capture, job) = (capture("nine-cameras"), Job::new());
    let [with, without, again] = ["with", "without", "again"].map(|name| folder.path().join(name));
    let settings = all_verdicts();
    let bytes = written(&capture, &settings, &with, 2);
    let mut bare = settings.clone();
    bare.store.verdicts = 0.0;
    written(&capture, &bare, &without, 2);
    let read = |path: &Path| store::read(path, &job).unwrap().0.images;
    assert_eq!(read(&with), read(&without));
    assert!(!Store::open(&without).unwrap().has_verdicts());
    let mut tight = settings.clone();
    tight.store.verdicts = 0.001;
    written(&capture, &tight, &without, 2);
    assert!(!Store::open(&without).unwrap().has_verdicts(), "they take more than that");
    let store = Store::open(&with).unwrap();
    store::write_again(&again, &store, None, &job).unwrap();
    assert_eq!(std::fs::read(&again).unwrap(), bytes);
    store::write_again(&again, &store, Some(&bare.store), &job).unwrap();
    assert!(!Store::open(&again).unwrap().has_verdicts());
}

#[test]
fn damaged_verdicts_are_an_error_and_leave_the_samples_whole() {
    let folder = tempfile::tempdir().unwrap();
    let (capture, job) = (capture("nine-cameras"), Job::new());
    let path = folder.path().join("scene.ovl");
    let bytes = written(&capture, &all_verdicts(), &path, 2);
    let start = bytes.windows(4).position(|four| four == b"VERD").unwrap();
    let length = u32::from_be_bytes(bytes[start + 4..start + 8].try_into().unwrap()) as usize;
    let samples = store::read(&path, &job).unwrap().0.images;
    for nth in 0..150 {
        let mut damaged = bytes.clone();
        let at = start + 8 + length - 1 - nth * (length - 1) / 149;
        damaged[at] ^= 1 << (nth % 8);
        std::fs::write(&path, &damaged).unwrap();
        let store = Store::open(&path).unwrap();
        let asked = (0..4).flat_map(|camera| (0..5).map(move |frame| (camera, frame)));
        let errors: Vec<_> = asked
            .filter_map(|(camera, frame)| store.each_verdict(frame, camera, |_, _, _| {}).err())
            .collect();
        assert!(!errors.is_empty(), "byte {at} of {start} + {length}");
        assert!(errors[0].to_string().contains("chunk 'VERD'"), "{}", errors[0]);
        assert_eq!(store::read(&path, &job).unwrap().0.images, samples);
        let told = store::playback::verify(&path, &job).unwrap().damage;
        assert!(told.iter().any(|line| line.contains("chunk 'VERD'")), "{told:?}");
    }
}
