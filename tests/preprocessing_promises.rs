//! The promises that preprocessing gives, on scenes whose right answer is known.

mod scene;

use std::sync::Arc;

use glam::{DVec2, DVec3};
use overlook::capture::{Camera, Capture, Intrinsics};
use overlook::error::Error;
use overlook::job::Job;
use overlook::preprocess::{
    FrameInspection, PixelClass, Preprocessed, Rule, Verdict, inspect_frame, preprocess, scan,
};
use overlook::settings::{MixedPixels, PruningMethod, RateModel, Settings, SpanLevels};
use proptest::prelude::*;
use scene::{Scene, Sphere, arc, camera};

fn run(capture: &Capture, settings: &Settings) -> Preprocessed {
    preprocess(capture, settings, &Job::new()).unwrap()
}

fn inspect(capture: &Capture, settings: &Settings, frame: usize) -> FrameInspection {
    let scan = scan(capture, settings, &Job::new()).unwrap();
    inspect_frame(capture, Some(&scan), settings, frame, &Job::new()).unwrap()
}

fn verdicts(inspection: &FrameInspection, camera: usize) -> &[Verdict] {
    inspection.cameras[camera].verdict.as_slice()
}

fn count(inspection: &FrameInspection, camera: usize, rule: Rule) -> usize {
    verdicts(inspection, camera).iter().filter(|verdict| verdict.rule == rule).count()
}

/// Checks, in double precision and from cameras and frames alone, that every dropped sample has a kept witness that shows
/// its surface point.
fn assert_covered(scene: &Scene, capture: &Capture, inspection: &FrameInspection, settings: &Settings) {
    let exact = Scene { normals: true, ..scene.clone() };
    let true_normals: Vec<_> = capture
        .cameras
        .iter()
        .map(|camera| exact.trace(camera, inspection.frame, 0).normal_in_world.unwrap())
        .collect();
    for (index, seen) in inspection.cameras.iter().enumerate() {
        let camera = &capture.cameras[index];
        for (pixel, verdict) in seen.verdict.as_slice().iter().enumerate() {
            if verdict.is_kept() || verdict.rule == Rule::NoSample {
                continue;
            }
            let witness = &inspection.cameras[verdict.witness_camera as usize];
            let witness_verdict = witness.verdict.as_slice()[verdict.witness_pixel as usize];
            assert!(witness_verdict.is_kept(), "dropped for {verdict:?}, which is {witness_verdict:?}");
            assert_ne!(verdict.witness_camera as usize, index);
            let (width, _) = seen.verdict.size();
            let center = DVec2::new((pixel % width) as f64 + 0.5, (pixel / width) as f64 + 0.5);
            let inverse_depth = f64::from(seen.frame.inverse_depth.as_slice()[pixel]);
            let witness_camera = &capture.cameras[verdict.witness_camera as usize];
            if inverse_depth == 0.0 {
                let w = witness.frame.inverse_depth.as_slice()[verdict.witness_pixel as usize];
                assert_eq!(w, 0.0);
                continue;
            }
            let point = camera.unproject(center, 1.0 / inverse_depth);
            let (found, z) = witness_camera.project(point).expect("the witness has the point before it");
            let k = witness_camera.intrinsics;
            let at = (f64::from(verdict.witness_pixel % k.width), f64::from(verdict.witness_pixel / k.width));
            assert!(
                (found.x - at.0 - 0.5).abs() < 0.51 && (found.y - at.1 - 0.5).abs() < 0.51,
                "{found} is not in {at:?}"
            );
            let seen_z =
                1.0 / f64::from(witness.frame.inverse_depth.as_slice()[verdict.witness_pixel as usize]);
            let seen = witness_camera.unproject(DVec2::new(at.0 + 0.5, at.1 + 0.5), seen_z);
            let normal =
                true_normals[verdict.witness_camera as usize].as_slice()[verdict.witness_pixel as usize];
            let distance = DVec3::from(normal.map(f64::from)).dot(point - seen).abs();
            let footprint = (seen_z / (k.fx * k.fy).sqrt()).max(1.0 / inverse_depth / camera.intrinsics.fx);
            // Rounding, and depth as half floats.
            let rounding = 2e-3 * (z + seen_z);
            // Estimated normals are off by some degrees, and a pixel without any is compared along its depth.
            let estimated = if scene.normals { 0.0 } else { footprint + 0.8 * (point - seen).length() };
            let slack = f64::from(settings.pruning.depth_tolerance) * footprint + rounding + estimated;
            assert!(distance < slack, "the point lies {distance} off the witness's surface, {slack} at most");
        }
    }
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

#[test]
fn of_two_equal_cameras_the_earlier_keeps_everything_and_the_later_nothing() {
    for normals in [true, false] {
        let twin = arc(1, 48).remove(0);
        let scene = Scene { normals, ..Scene::still_life() };
        let capture = scene.record(vec![twin.clone(), twin], 2);
        let inspection = inspect(&capture, &Settings::default(), 0);
        assert!(verdicts(&inspection, 0).iter().all(|verdict| verdict.is_kept()));
        assert!(verdicts(&inspection, 1).iter().all(|verdict| verdict.rule == Rule::Tie));
    }
}

#[test]
fn pruning_keeps_the_sample_with_the_higher_rate() {
    let far = camera("far", DVec3::new(0.0, -6.0, 2.0), DVec3::new(0.0, 0.0, 0.6), 64);
    let near = camera("near", DVec3::new(0.0, -2.5, 1.2), DVec3::new(0.0, 0.0, 0.6), 64);
    let capture = Scene::still_life().record(vec![far, near], 2);
    let inspection = inspect(&capture, &Settings::default(), 0);
    let on_sphere = |camera: usize, pixel: usize| {
        let frame = &inspection.cameras[camera].frame;
        frame.color.as_slice()[pixel][0].to_f32() > 0.6
    };
    let near_sphere: Vec<_> = (0..64 * 64).filter(|&pixel| on_sphere(1, pixel)).collect();
    assert!(near_sphere.len() > 600);
    let kept = near_sphere.iter().filter(|&&pixel| verdicts(&inspection, 1)[pixel].is_kept()).count();
    assert!(
        kept * 20 > near_sphere.len() * 19,
        "the close-up keeps all but the limb: {kept} of {}",
        near_sphere.len()
    );
    let far_sphere: Vec<_> = (0..64 * 64).filter(|&pixel| on_sphere(0, pixel)).collect();
    let dropped =
        far_sphere.iter().filter(|&&pixel| verdicts(&inspection, 0)[pixel].rule == Rule::LowerRate).count();
    assert!(dropped * 10 > far_sphere.len() * 8, "the far view yields: {dropped} of {}", far_sphere.len());
    let ratio = inspection.log2_sampling_ratio(1, Some(0));
    let denser = near_sphere.iter().filter(|&&pixel| ratio.as_slice()[pixel] < 0.0).count();
    assert!(denser * 20 > near_sphere.len() * 15, "the map says so too: {denser}");

    let mut first_wins = Settings::default();
    first_wins.pruning.method = PruningMethod::FirstCamera;
    let inspection = inspect(&capture, &first_wins, 0);
    assert_eq!(verdicts(&inspection, 0).iter().filter(|verdict| !verdict.is_kept()).count(), 0);
    assert!(
        near_sphere
            .iter()
            .filter(|&&pixel| verdicts(&inspection, 1)[pixel].rule == Rule::LaterCamera)
            .count()
            > 400
    );
}

#[test]
fn a_sample_whose_winner_was_dropped_for_one_that_does_not_see_it_is_kept() {
    let mut cameras = arc(3, 64);
    cameras.push(camera("near", DVec3::new(0.8, -2.4, 1.5), DVec3::new(0.6, 0.2, 0.4), 64));
    cameras.push(camera("side", DVec3::new(3.0, 1.0, 1.5), DVec3::new(0.6, 0.2, 0.4), 64));
    let scene = Scene::still_life();
    let capture = scene.record(cameras, 1);
    let settings = Settings::default();
    let inspection = inspect(&capture, &settings, 0);
    let rescued: usize = (0..5).map(|index| count(&inspection, index, Rule::Coverage)).sum();
    assert!(rescued > 0, "the scene has witness chains");
    assert_covered(&scene, &capture, &inspection, &settings);
}

#[test]
fn an_object_that_rests_for_most_of_the_shot_and_leaves_is_no_ghost() {
    let frames = 8;
    let mut scene = Scene::still_life();
    scene.spheres[0].center =
        Arc::new(move |frame| (frame + 1 < frames).then_some(DVec3::new(0.0, 0.0, 0.6)));
    let capture = scene.record(arc(3, 48), frames);
    let samples = run(&capture, &Settings::default()).samples;
    for frame in 0..frames {
        let red = samples
            .images_at(frame)
            .flat_map(|image| image.color.iter())
            .filter(|color| color[0].to_f32() > 0.6 && color[1].to_f32() < 0.25)
            .count();
        assert_eq!(red > 0, frame + 1 < frames, "frame {frame}: {red} samples of the sphere");
    }
}

#[test]
fn slow_drift_below_any_step_between_frames_is_not_static() {
    let mut scene = Scene::still_life();
    // 0.2 of an 8-bit step each frame, 8 steps over the shot.
    scene.ground_light = Some(Arc::new(|frame, _| 0.0012 * frame as f32));
    let capture = scene.record(arc(1, 32), 40);
    let inspection = inspect(&capture, &Settings::default(), 0);
    let classes = inspection.cameras[0].class.as_slice();
    let colors = inspection.cameras[0].frame.color.as_slice();
    for (class, color) in classes.iter().zip(colors) {
        let [red, _, blue] = color.map(half::f16::to_f32);
        let is_ground = red < 0.45 && blue < 0.5 && red > 0.15;
        assert_eq!(*class != PixelClass::Background, is_ground, "{color:?}");
    }
}

#[test]
fn a_moving_shadow_takes_the_wall_it_crosses_out_of_the_background_and_nothing_else() {
    let mut scene = Scene::still_life();
    scene.ground_light = Some(Arc::new(|frame, point| {
        if (point.x - 0.4 * frame as f64 + 1.0).abs() < 0.3 && point.y < -0.8 { -0.1 } else { 0.0 }
    }));
    let capture = scene.record(arc(2, 64), 6);
    let inspection = inspect(&capture, &Settings::default(), 3);
    let classes = inspection.cameras[0].class.as_slice();
    let changes = classes.iter().filter(|class| **class != PixelClass::Background).count() as f64 / 4096.0;
    assert!(changes > 0.02 && changes < 0.3, "{changes}");
}

#[test]
fn noise_that_differs_from_frame_to_frame_leaves_a_still_scene_background() {
    let scene = Scene { color_noise: 0.02, ..Scene::still_life() };
    let capture = scene.record(arc(2, 64), 24);
    let share = |settings: &Settings| {
        let report = run(&capture, settings).report;
        report.cameras[0].background_pixels as f64 / 4096.0
    };
    assert!(share(&Settings::default()) > 0.99, "{}", share(&Settings::default()));
    let mut trusting = Settings::default();
    trusting.spans.noise = 0.0;
    assert!(share(&trusting) < 0.2, "without the measured noise the split fails: {}", share(&trusting));
}

#[test]
fn averaging_over_the_span_takes_the_noise_out_of_the_background() {
    let scene = Scene { color_noise: 0.03, ..Scene::still_life() };
    let clean = Scene::still_life().trace(&arc(1, 48)[0], 0, 0);
    let capture = scene.record(arc(1, 48), 32);
    let error = |color: &[[half::f16; 3]]| {
        let pairs = color.iter().zip(clean.color.as_slice()).filter(|(a, _)| a[0].to_f32() > 0.0);
        let sum: f32 = pairs.map(|(a, b)| (a[0].to_f32() / b[0].to_f32() - 1.0).powi(2)).sum();
        (sum / color.len() as f32).sqrt()
    };
    let samples = run(&capture, &Settings::default()).samples;
    let background = &samples.images[0];
    assert!(background.span.len() == 32 && background.len() > 48 * 48 * 99 / 100);
    let mut averaged = vec![[half::f16::ZERO; 3]; 48 * 48];
    background
        .samples()
        .for_each(|sample| averaged[sample.y * 48 + sample.x] = background.color[sample.index]);
    assert!(error(&averaged) < 0.25 * error(capture.frame(0, 0).unwrap().color.as_slice()));
}

#[test]
fn half_float_depth_prunes_nearly_as_well_as_exact_depth() {
    let kept = |half_depth| {
        let scene = Scene { half_depth, ..Scene::still_life() };
        run(&scene.record(arc(3, 64), 2), &Settings::default()).report.samples_kept as f64
    };
    assert!(kept(true) < 1.15 * kept(false), "{} against {}", kept(true), kept(false));
}

#[test]
fn a_thing_one_pixel_wide_is_never_dropped_for_what_stands_behind_it() {
    let mut scene = Scene::still_life();
    for i in 0..40 {
        scene.spheres.push(Sphere::resting(
            DVec3::new(0.3, -1.2, 0.03 + 0.04 * f64::from(i)),
            0.02,
            [0.9, 0.9, 0.1],
        ));
    }
    let capture = scene.record(arc(4, 64), 1);
    let inspection = inspect(&capture, &Settings::default(), 0);
    let is_wire = |camera: usize, pixel: usize| {
        let color = inspection.cameras[camera].frame.color.as_slice()[pixel];
        color[0].to_f32() > 0.85 && color[2].to_f32() < 0.2
    };
    let mut wires = 0;
    for camera in 0..4 {
        for (pixel, verdict) in verdicts(&inspection, camera).iter().enumerate() {
            if is_wire(camera, pixel) {
                wires += 1;
                assert!(
                    verdict.is_kept()
                        || is_wire(verdict.witness_camera as usize, verdict.witness_pixel as usize)
                );
            }
        }
    }
    assert!(wires > 40);
}

#[test]
fn cameras_that_see_nothing_in_common_drop_nothing() {
    let apart = vec![
        camera("east", DVec3::new(20.0, 0.0, 2.0), DVec3::new(30.0, 0.0, 0.0), 32),
        camera("west", DVec3::new(-20.0, 0.0, 2.0), DVec3::new(-30.0, 0.0, 0.0), 32),
    ];
    let inside = vec![camera("inside", DVec3::new(0.0, 0.0, 0.6), DVec3::X, 32), arc(1, 32).remove(0)];
    for cameras in [apart, inside] {
        let inspection = inspect(&Scene::still_life().record(cameras, 2), &Settings::default(), 1);
        for camera in 0..2 {
            let finite = inspection.cameras[camera]
                .frame
                .inverse_depth
                .as_slice()
                .iter()
                .zip(verdicts(&inspection, camera));
            assert!(finite.filter(|(w, _)| **w > 0.0).all(|(_, verdict)| verdict.is_kept()));
        }
    }
}

#[test]
fn the_footprint_knows_the_zoom_lens_and_the_papers_r_does_not() {
    let wide = camera("wide", DVec3::new(0.0, -5.0, 2.0), DVec3::ZERO, 64);
    let zoom = Camera::look_at(
        "zoom",
        Intrinsics::from_horizontal_angle(64, 64, 0.2),
        DVec3::new(0.0, -6.0, 2.4),
        DVec3::ZERO,
        DVec3::Z,
    );
    let capture = Scene::still_life().record(vec![wide, zoom], 1);
    let dropped = |rate| {
        let mut settings = Settings::default();
        settings.pruning.rate = rate;
        count(&inspect(&capture, &settings, 0), 1, Rule::LowerRate)
    };
    assert_eq!(dropped(RateModel::Auto), 0, "the zoom lens shows everything better");
    assert!(dropped(RateModel::Paper) > 1000, "bare depth prefers the nearer camera");
}

#[test]
fn blended_silhouettes_yield_to_clean_samples_and_can_be_dropped() {
    let mut scene = Scene::still_life();
    scene.normals = false;
    let mut capture = scene.record(arc(2, 64), 1);
    capture.antialiased_color = true;
    // Nothing is blended in this scene, so nothing may be taken for it.
    let mut settings = Settings::default();
    settings.pruning.mixed_pixels = MixedPixels::Drop;
    let inspection = inspect(&capture, &settings, 0);
    let dropped: usize = (0..2).map(|camera| count(&inspection, camera, Rule::MixedDropped)).sum();
    assert!(dropped < 64 * 64 * 2 / 100, "{dropped}");
}

#[test]
fn a_cancelled_job_ends_with_cancelled_and_nothing_else() {
    let capture = Scene::still_life().record(arc(2, 32), 4);
    let job = Job::new();
    job.cancel();
    assert!(matches!(preprocess(&capture, &Settings::default(), &job), Err(Error::Cancelled)));
}
