//! The promises that preprocessing gives, on scenes whose right answer is known.

use std::sync::Arc;

use crate::coverage::assert_covered;
use crate::scene::{Scene, Sphere, arc, camera};
use glam::{DVec2, DVec3};
use overlook_engine::capture::{Camera, Capture, Frame, Intrinsics};
use overlook_engine::error::Error;
use overlook_engine::job::Job;
use overlook_engine::preprocess::inspect::FrameInspection;
use overlook_engine::preprocess::pruning::{Rule, Verdict};
use overlook_engine::preprocess::temporal::PixelClass;
use overlook_engine::preprocess::{Preprocessed, inspect_frame, preprocess, scan};
use overlook_engine::settings::{MixedPixels, PruningMethod, RateModel, Settings};

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
    let mut changes = 0;
    for (index, seen) in inspection.cameras.iter().enumerate() {
        let lit = Scene::still_life().trace(&capture.cameras[index], 0, index);
        let frames: Vec<_> = (0..6).map(|frame| capture.frame(index, frame).unwrap()).collect();
        for (pixel, class) in seen.class.as_slice().iter().enumerate() {
            let is_shaded = |frame: &Frame| frame.color.as_slice()[pixel] != lit.color.as_slice()[pixel];
            let shaded = frames.iter().filter(|frame| is_shaded(frame)).count();
            assert_eq!(*class != PixelClass::Background, (1..6).contains(&shaded), "pixel {pixel}");
            changes += usize::from(shaded > 0);
        }
    }
    assert!(changes > 2 * 80, "{changes}");
    for image in &inspection.samples.images {
        let recorded = capture.frame(image.camera as usize, 3).unwrap();
        let depths = image.inverse_depths();
        for sample in image.samples() {
            assert_eq!(depths[sample.index], recorded.inverse_depth[(sample.x, sample.y)], "geometry stays");
        }
    }
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

/// Three cameras beside each other that look down at the ground through lenses of so many radians.
fn through_lens(radians: f64) -> Vec<Camera> {
    let beside = |east: f64| DVec3::new(east - 0.9, -1.5, 4.4 + 0.3 * east);
    let names = [("left", -0.3), ("middle", 0.0), ("right", 0.4)];
    let cameras = names.map(|(name, east)| camera(name, beside(east), DVec3::new(-0.9, -1.0, 0.0), 64));
    let lens = Intrinsics::from_horizontal_angle(64, 64, radians);
    cameras.into_iter().map(|camera| Camera { intrinsics: lens, ..camera }).collect()
}

#[test]
fn half_float_depth_prunes_as_well_as_exact_depth_through_any_lens() {
    for radians in [0.9, 0.03, 0.015] {
        let kept = |half_depth| {
            let scene = Scene { half_depth, ..Scene::still_life() };
            run(&scene.record(through_lens(radians), 2), &Settings::default()).report.samples_kept as f64
        };
        let (half, exact) = (kept(true), kept(false));
        assert!(half < 1.01 * exact, "{radians}: {half} against {exact}");
    }
}

#[test]
fn depth_that_is_noisy_is_pruned_within_its_measured_noise() {
    let kept = |depth_noise, frames| {
        let scene = Scene { depth_noise, ..Scene::still_life() };
        run(&scene.record(through_lens(0.1), frames), &Settings::default()).report.samples_kept as f64
    };
    for frames in [2, 6] {
        let (noisy, exact) = (kept(0.003, frames), kept(0.0, frames));
        assert!(noisy < 1.1 * exact, "{frames} frames: {noisy} against {exact}");
    }
}

/// Of the pixels of a wire before the still life: how many stand clear of all that is behind them, and how many of these were
/// dropped for something else than the wire. By color and normal alone, all that is seen is one surface.
fn wire_pixels_dropped_for_what_is_behind(depth_tolerance: f32) -> (usize, usize) {
    let bare = Scene::still_life();
    let mut scene = bare.clone();
    for i in 0..56 {
        let center = DVec3::new(0.3, -1.2, 0.03 + 0.03 * f64::from(i));
        scene.spheres.push(Sphere::resting(center, 0.015, [0.9, 0.9, 0.1]));
    }
    let mut cameras = arc(4, 64);
    // So near that it samples what is behind the wire better than others sample the wire, which it misses here and there.
    cameras.push(camera("near", DVec3::new(0.3, -3.2, 1.0), DVec3::new(0.3, 0.2, 0.6), 64));
    let behind: Vec<_> = cameras.iter().map(|camera| bare.trace(camera, 0, 0)).collect();
    let mut settings = Settings::default();
    (settings.pruning.color_tolerance, settings.pruning.normal_tolerance) = (255.0, 90.0);
    settings.pruning.depth_tolerance = depth_tolerance;
    let inspection = inspect(&scene.record(cameras.clone(), 1), &settings, 0);

    let center = |pixel: usize| DVec2::new((pixel % 64) as f64 + 0.5, (pixel / 64) as f64 + 0.5);
    let is_wire = |camera: usize, pixel: usize| {
        let color = inspection.cameras[camera].frame.color.as_slice()[pixel];
        color[0].to_f32() > 0.85 && color[2].to_f32() < 0.2
    };
    // More than half as far again from what another camera sees behind the point as one footprint, the larger of the two.
    let is_clear_in = |point: DVec3, depth: f64, other: usize| {
        let Some((found, _)) = cameras[other].project(point) else { return true };
        let inside = |at: f64| (0.0..64.0).contains(&at);
        if !inside(found.x) || !inside(found.y) {
            return true;
        }
        let pixel = found.y as usize * 64 + found.x as usize;
        let inverse_depth = f64::from(behind[other].inverse_depth.as_slice()[pixel]);
        if inverse_depth == 0.0 {
            return true;
        }
        let surface = cameras[other].unproject(center(pixel), 1.0 / inverse_depth);
        let normal = behind[other].normal_in_world.as_ref().unwrap().as_slice()[pixel];
        let footprint = depth.max(1.0 / inverse_depth) / cameras[other].intrinsics.fx;
        DVec3::from(normal.map(f64::from)).dot(point - surface).abs() > 1.5 * footprint
    };
    let (mut clear, mut dropped) = (0, 0);
    for camera in 0..cameras.len() {
        for (pixel, verdict) in verdicts(&inspection, camera).iter().enumerate() {
            let depth = 1.0 / f64::from(inspection.cameras[camera].frame.inverse_depth.as_slice()[pixel]);
            if !is_wire(camera, pixel) {
                continue;
            }
            let point = cameras[camera].unproject(center(pixel), depth);
            if (0..cameras.len()).all(|other| other == camera || is_clear_in(point, depth, other)) {
                clear += 1;
                let stays = verdict.is_kept()
                    || is_wire(verdict.witness_camera as usize, verdict.witness_pixel as usize);
                dropped += usize::from(!stays);
            }
        }
    }
    (clear, dropped)
}

#[test]
fn a_thing_one_pixel_wide_is_never_dropped_for_what_stands_behind_it() {
    let (clear, dropped) = wire_pixels_dropped_for_what_is_behind(1.0);
    assert!(clear > 40, "{clear} pixels of the wire stand clear of what is behind them");
    assert_eq!(dropped, 0, "of {clear} pixels");
    let (_, dropped) = wire_pixels_dropped_for_what_is_behind(16.0);
    assert!(dropped > 4, "depth alone keeps them: {dropped} of {clear} without it");
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
fn a_clean_silhouette_is_not_taken_for_a_blended_one() {
    let scene = Scene { normals: false, ..Scene::still_life() };
    let capture = scene.record(arc(2, 64), 1).with_antialiased_color(true);
    let mut settings = Settings::default();
    settings.pruning.mixed_pixels = MixedPixels::Drop;
    let inspection = inspect(&capture, &settings, 0);
    let dropped: usize = (0..2).map(|camera| count(&inspection, camera, Rule::MixedDropped)).sum();
    assert!(dropped < 64 * 64 * 2 / 100, "{dropped}");
}

#[test]
fn samples_of_the_sky_are_dropped_where_they_are_blended_and_those_of_surfaces_yield() {
    let scene = Scene { color_rays: 4, ..Scene::still_life() };
    let capture = scene.record(arc(3, 64), 1).with_antialiased_color(true);
    let settings = Settings::default();
    let inspection = inspect(&capture, &settings, 0);
    let mut dropped = 0;
    for (camera, inspected) in inspection.cameras.iter().enumerate() {
        let frame = capture.frame(camera, 0).unwrap();
        for (pixel, verdict) in inspected.verdict.as_slice().iter().enumerate() {
            if verdict.rule == Rule::MixedDropped {
                dropped += 1;
                assert_eq!(frame.inverse_depth.as_slice()[pixel], 0.0, "camera {camera}, pixel {pixel}");
            }
        }
    }
    assert!(dropped > 20, "{dropped}");
    let mut unpruned = settings;
    unpruned.pruning.method = PruningMethod::Off;
    let inspection = inspect(&capture, &unpruned, 0);
    assert_eq!((0..3).map(|camera| count(&inspection, camera, Rule::MixedDropped)).sum::<usize>(), 0);
}

#[test]
fn at_grazing_incidence_the_floor_of_the_cosine_decides_and_the_nearer_camera_wins() {
    // Both see the ground at a few degrees; without a floor, rounding of the cosine would outweigh the distance.
    let near = camera("near", DVec3::new(0.0, -3.0, 0.12), DVec3::new(0.0, 0.0, 0.0), 48);
    let far = camera("far", DVec3::new(0.0, -4.0, 0.30), DVec3::new(0.0, 0.0, 0.0), 48);
    let scene = Scene { ground: true, normals: true, ..Scene::default() };
    let capture = scene.record(vec![far, near], 1);
    let winners = |floor: f32| {
        let mut settings = Settings::default();
        settings.pruning.cosine_floor = floor;
        settings.pruning.depth_tolerance = 4.0;
        // Pixels are long there: only what lies at one spot of the pattern is compared.
        settings.pruning.color_tolerance = 24.0;
        let inspection = inspect(&capture, &settings, 0);
        (count(&inspection, 0, Rule::LowerRate), count(&inspection, 1, Rule::LowerRate))
    };
    let (far_lost, near_lost) = winners(0.5);
    assert!(far_lost > 50 && near_lost * 10 < far_lost, "with a floor: {far_lost} {near_lost}");
    let (_, near_lost) = winners(0.01);
    assert!(near_lost > 50, "without one the steeper view wins: {near_lost}");
}

#[test]
fn of_two_resolutions_in_one_place_the_finer_wins_by_the_footprint_and_the_earlier_by_the_papers_r() {
    let coarse = camera("coarse", DVec3::new(0.0, -5.0, 2.0), DVec3::ZERO, 32);
    let fine = camera("fine", DVec3::new(0.0, -5.0, 2.0), DVec3::ZERO, 96);
    let capture = Scene::still_life().record(vec![coarse, fine], 1);
    let inspection = inspect(&capture, &Settings::default(), 0);
    assert_eq!(count(&inspection, 1, Rule::LowerRate), 0);
    assert!(count(&inspection, 0, Rule::LowerRate) > 500);
    let mut paper = Settings::default();
    paper.pruning.rate = RateModel::Paper;
    // By the paper's r both sample a point equally well.
    assert!(count(&inspect(&capture, &paper, 0), 0, Rule::BestRate) > 500);
}

#[test]
fn a_cancelled_job_ends_with_cancelled_and_nothing_else() {
    let capture = Scene::still_life().record(arc(2, 32), 4);
    let job = Job::new();
    job.cancel();
    assert!(matches!(preprocess(&capture, &Settings::default(), &job), Err(Error::Cancelled)));
}
