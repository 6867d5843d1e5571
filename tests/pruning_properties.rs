//! Properties of pruning on any capture and any settings.

mod coverage;
mod scene;

use std::sync::Arc;

use coverage::assert_covered;
use glam::DVec3;
use overlook::capture::{Camera, Capture, Intrinsics};
use overlook::job::Job;
use overlook::preprocess::{FrameInspection, Preprocessed, inspect_frame, preprocess, scan};
use overlook::settings::{PruningMethod, RateModel, Settings, SpanLevels};
use proptest::prelude::*;
use scene::{Scene, Sphere, arc};

fn run(capture: &Capture, settings: &Settings) -> Preprocessed {
    preprocess(capture, settings, &Job::new()).unwrap()
}

fn inspect(capture: &Capture, settings: &Settings, frame: usize) -> FrameInspection {
    let scan = scan(capture, settings, &Job::new()).unwrap();
    inspect_frame(capture, Some(&scan), settings, frame, &Job::new()).unwrap()
}

fn any_capture() -> impl Strategy<Value = (Scene, Capture)> {
    let eye = || prop::array::uniform3(-6.0..6.0_f64);
    let one_camera =
        (eye(), eye(), 1..40_u32, 1..40_u32, 0.3..2.0_f64).prop_map(|(eye, target, width, height, angle)| {
            Camera::look_at(
                "any",
                Intrinsics::from_horizontal_angle(width, height, angle),
                DVec3::from(eye),
                DVec3::from(target) * 0.2,
                DVec3::Z,
            )
        });
    (
        prop::collection::vec(one_camera, 1..6),
        any::<bool>(),
        any::<bool>(),
        any::<bool>(),
        prop::sample::select(vec![0.0, 0.02]),
    )
        .prop_map(|(cameras, twin, normals, half_depth, color_noise)| {
            let mut cameras = cameras;
            if twin {
                cameras.push(arc(1, 20).remove(0));
                cameras.push(cameras[0].clone());
            }
            let moving = Sphere {
                center: Arc::new(|frame| Some(DVec3::new(-1.5 + 0.8 * frame as f64, -0.5, 0.5))),
                radius: 0.5,
                color: [0.6, 0.6, 0.1],
            };
            let mut scene = Scene { color_noise, half_depth, normals, ..Scene::still_life() };
            scene.spheres.push(moving);
            let capture = scene.record(cameras, 3);
            (scene, capture)
        })
}

fn any_settings() -> impl Strategy<Value = Settings> {
    (
        prop::sample::select(PruningMethod::ALL),
        prop::sample::select(RateModel::ALL),
        prop::sample::select(SpanLevels::ALL),
        0.1..8.0_f32,
        1.0..90.0_f32,
        1.0..255.0_f32,
        any::<bool>(),
    )
        .prop_map(|(method, rate, levels, depth, normal, color, across_spans)| {
            let mut settings = Settings::default();
            settings.spans.levels = levels;
            let pruning = &mut settings.pruning;
            (pruning.method, pruning.rate, pruning.across_spans) = (method, rate, across_spans);
            (pruning.depth_tolerance, pruning.normal_tolerance, pruning.color_tolerance) =
                (depth, normal, color);
            settings
        })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 96, ..ProptestConfig::default() })]

    #[test]
    fn every_dropped_sample_has_a_kept_witness_that_shows_its_point((scene, capture) in any_capture(), settings in any_settings()) {
        for frame in [0, 2] {
            assert_covered(&scene, &capture, &inspect(&capture, &settings, frame), &settings);
        }
    }

    #[test]
    fn every_pixel_is_kept_or_accounted_for((_, capture) in any_capture(), settings in any_settings()) {
        let report = run(&capture, &settings).report;
        let invalid: u64 = report.cameras.iter().map(|camera| camera.invalid).sum();
        let pruned: u64 = report.pruned.values().sum();
        prop_assert_eq!(report.samples_in, report.samples_kept + pruned + invalid);
        let spans: u64 = report.spans.iter().map(|span| span.samples).sum();
        prop_assert_eq!(spans, report.samples_kept);
    }

    #[test]
    fn the_result_is_the_same_with_one_thread_and_with_many((_, capture) in any_capture(), settings in any_settings()) {
        let with = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| run(&capture, &settings))
        };
        let (one, many) = (with(1), with(3));
        prop_assert_eq!(&one.samples.images, &many.samples.images);
        prop_assert_eq!(one.report.pruned, many.report.pruned);
    }

    #[test]
    fn inspecting_a_frame_shows_what_preprocessing_does((_, capture) in any_capture(), settings in any_settings()) {
        let whole = run(&capture, &settings);
        let shown = inspect(&capture, &settings, 1);
        let at_frame: Vec<_> = whole.samples.images_at(1).cloned().collect();
        prop_assert_eq!(&at_frame, &shown.samples.images);
    }
}
