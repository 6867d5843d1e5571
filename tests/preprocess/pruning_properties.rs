//! Properties of pruning on any capture and any settings.

use crate::scene;
use std::sync::Arc;

use crate::coverage::assert_covered;
use crate::scene::{Scene, Sphere, arc};
use glam::DVec3;
use overlook_engine::capture::{Camera, Capture, CaptureParts, Frame, FrameSource, Intrinsics};
use overlook_engine::error::Result;
use overlook_engine::job::Job;
use overlook_engine::preprocess::inspect::FrameInspection;
use overlook_engine::preprocess::{Preprocessed, inspect_frame, preprocess, scan};
use overlook_engine::settings::{MixedPixels, PruningMethod, RateModel, Settings, SpanLevels};
use proptest::prelude::*;

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

/// A red ball before the sky, whose silhouette is blended; how many kept samples show neither red nor sky, and the report.
fn fringe(mixed_pixels: MixedPixels) -> (usize, Preprocessed) {
    let ball = Sphere::resting(DVec3::new(0.0, 0.0, 0.6), 0.8, [0.7, 0.2, 0.1]);
    let scene = Scene { spheres: vec![ball], normals: true, color_rays: 4, ..Scene::default() };
    let capture = scene.record(arc(3, 64), 1);
    let mut settings = Settings::default();
    settings.pruning.mixed_pixels = mixed_pixels;
    let result = run(&capture, &settings);
    let is_clean = |color: &[half::f16; 3]| {
        let near = |pure: [f32; 3]| (0..3).all(|c| (color[c].to_f32() - pure[c]).abs() < 0.1);
        near([0.7, 0.2, 0.1]) || near(scene::SKY)
    };
    let colors = result.samples.images.iter().flat_map(|image| &image.color);
    (colors.filter(|color| !is_clean(color)).count(), result)
}

#[test]
fn blended_silhouettes_yield_to_clean_samples_and_can_be_dropped() {
    let [(kept, _), (yielded, yields), (dropped, drops)] =
        [MixedPixels::Keep, MixedPixels::Yield, MixedPixels::Drop].map(fringe);
    assert!(kept > 40, "{kept}");
    assert!(yielded < kept, "{yielded} of {kept}");
    assert!(dropped < kept / 2, "{dropped} of {kept}");
    let outcomes = |report: &overlook_engine::preprocess::diagnostics::Report| {
        ["found", "yielded", "dropped", "outranked", "kept"].map(|outcome| report.mixed_pixels[outcome])
    };
    for result in [&yields, &drops] {
        let [found, yielded, dropped, outranked, kept] = outcomes(&result.report);
        assert!(found > 40 && found == yielded + dropped + outranked + kept);
    }
    assert_eq!(outcomes(&drops.report)[0], outcomes(&drops.report)[2]);
}

#[test]
fn of_two_equal_cameras_half_of_what_is_blended_on_surfaces_is_kept_and_the_first_yields_nothing_at_all() {
    let ball = Sphere::resting(DVec3::new(0.0, 0.0, 0.6), 0.8, [0.7, 0.2, 0.1]);
    let scene = Scene { spheres: vec![ball], ground: true, normals: true, color_rays: 4, ..Scene::default() };
    let first = arc(3, 64);
    let twins = scene.record(vec![first[0].clone(), first[0].clone()], 1);
    let report = run(&twins, &Settings::default()).report;
    let [found, kept, dropped] = ["found", "kept", "dropped"].map(|outcome| report.mixed_pixels[outcome]);
    assert!(kept > 20 && dropped > 20, "{kept} kept, {dropped} of the sky dropped");
    assert_eq!(2 * kept + dropped, found);
    let mut settings = Settings::default();
    settings.pruning.method = PruningMethod::FirstCamera;
    let report = run(&scene.record(first, 1), &settings).report;
    assert!(
        report.witnesses.row(0).map(|(_, count)| *count).eq([0, 0, 0]),
        "the first camera's samples are dropped for none"
    );
    assert!(*report.witnesses.get(1, 0).unwrap() > 100);
}

/// Frames of a capture, one of which is rounded coarsely, as whole-number depth is where something is near.
struct OneIsCoarse(Capture);

const COARSE: usize = 2;

impl FrameSource for OneIsCoarse {
    fn load(&self, camera: usize, frame: usize) -> Result<Frame> {
        let frame_of = self.0.frame(camera, frame)?;
        Ok(Frame { depth_step_relative: if frame == COARSE { 0.1 } else { 1e-5 }, ..(*frame_of).clone() })
    }

    fn place(&self, camera: usize, frame: usize) -> String {
        format!("camera {camera}, frame {frame}")
    }
}

#[test]
fn what_is_decided_at_a_frame_does_not_depend_on_how_coarsely_those_before_it_were_rounded() {
    let light: Arc<dyn Fn(usize, DVec3) -> f32 + Send + Sync> = Arc::new(|frame, _| 0.2 * (frame % 2) as f32);
    let scene = Scene { ground_light: Some(light), ..Scene::still_life() };
    let recorded = scene.record(arc(3, 40), 8);
    let parts = CaptureParts {
        name: "coarse".to_owned(),
        cameras: recorded.cameras.clone(),
        frame_numbers: (0..8).collect(),
        up_in_world: DVec3::Z,
        has_normals: true,
        antialiased_color: false,
        warnings: Vec::new(),
        source: Arc::new(OneIsCoarse(recorded)),
    };
    let capture = Capture::new(parts, 256 << 20);
    for levels in [SpanLevels::Paper, SpanLevels::Off] {
        let mut settings = Settings::default();
        settings.spans.levels = levels;
        settings.pruning.depth_tolerance = 0.05;
        let whole = run(&capture, &settings);
        let kept = &whole.report.foreground_per_frame;
        assert!(kept[0] > 1000 && kept[1] > 1000, "{kept:?}");
        for frame in 2..8 {
            assert_eq!(kept[frame], kept[frame % 2], "{levels:?}: {kept:?}");
        }
        let shown = inspect(&capture, &settings, 6);
        let at_frame: Vec<_> = whole.samples.images_at(6).cloned().collect();
        assert_eq!(at_frame, shown.samples.images, "{levels:?}");
    }
}
