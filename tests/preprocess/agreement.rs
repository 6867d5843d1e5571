//! What other cameras contradict is dropped; what they may have missed, hide, or saw at another time is not.

use std::sync::Arc;

use crate::scene::{Scene, Sphere, arc, camera};
use glam::{DVec2, DVec3};
use overlook_engine::capture::{Camera, Capture, CaptureParts, Frame, FrameSource};
use overlook_engine::error::Result;
use overlook_engine::job::Job;
use overlook_engine::preprocess::agreement::SampleAgreement;
use overlook_engine::preprocess::inspect::{FrameInspection, explain_pixel};
use overlook_engine::preprocess::pruning::Rule;
use overlook_engine::preprocess::{inspect_frame, preprocess, scan};
use overlook_engine::samples::Vote;
use overlook_engine::settings::{AgreementRule, MixedPixels, Settings};
use overlook_lab::stress::Disturbance;

fn inspect(capture: &Capture, frame: usize, settings: &Settings) -> FrameInspection {
    let scan = scan(capture, settings, &Job::new()).unwrap();
    inspect_frame(capture, Some(&scan), settings, frame, &Job::new()).unwrap()
}

fn contradicted(inspection: &FrameInspection, camera: usize) -> Vec<usize> {
    let verdicts = inspection.cameras[camera].verdict.as_slice().iter().enumerate();
    verdicts.filter(|(_, verdict)| verdict.rule == Rule::Contradicted).map(|(pixel, _)| pixel).collect()
}

fn is_any_contradicted(inspection: &FrameInspection) -> bool {
    (0..inspection.cameras.len()).any(|camera| !contradicted(inspection, camera).is_empty())
}

/// How many other cameras have what one of them saw at a pixel in their pictures.
fn others_that_look_there(cameras: &[Camera], own: usize, pixel: usize, inverse_depth: f32) -> usize {
    let (width, _) = cameras[own].intrinsics.size();
    let center = DVec2::new((pixel % width) as f64, (pixel / width) as f64) + 0.5;
    let point = cameras[own].unproject(center, 1.0 / f64::from(inverse_depth));
    let holds = |camera: &Camera| {
        let (width, height) = camera.intrinsics.size();
        camera
            .project(point)
            .is_some_and(|(at, _)| at.min_element() >= 0.0 && at.x < width as f64 && at.y < height as f64)
    };
    cameras.iter().enumerate().filter(|(other, camera)| *other != own && holds(camera)).count()
}

#[test]
fn stray_samples_where_two_other_cameras_look_are_dropped_and_no_true_one_is_contradicted() {
    let clean = Scene::still_life();
    let scene = Scene { strays: 0.01, ..clean.clone() };
    let (cameras, settings) = (arc(5, 96), Settings::default());
    let [recorded, truth] =
        [&scene, &clean].map(|scene| inspect(&scene.record(cameras.clone(), 1), 0, &settings));
    let (mut strays, mut looked_at, mut kept) = (0, 0, 0);
    for camera in 0..cameras.len() {
        let [found, true_depths] =
            [&recorded, &truth].map(|inspection| inspection.cameras[camera].frame.inverse_depth.as_slice());
        for pixel in 0..found.len() {
            let verdict = recorded.cameras[camera].verdict.as_slice()[pixel];
            let is_stray = found[pixel] != true_depths[pixel];
            strays += usize::from(is_stray);
            // What lies near to one camera, as strays do, is outside of the pictures of many others.
            if is_stray && others_that_look_there(&cameras, camera, pixel, found[pixel]) >= 2 {
                looked_at += 1;
                kept += usize::from(verdict.is_kept());
            }
            assert!(is_stray || verdict.rule != Rule::Contradicted, "camera {camera}, pixel {pixel}");
        }
    }
    assert!(strays > 300 && looked_at * 2 > strays, "{looked_at} of {strays}");
    assert!(kept * 10 < looked_at, "{kept} of {looked_at}");
    let mut off = settings;
    off.pruning.agreement = AgreementRule::Off;
    assert!(!is_any_contradicted(&inspect(&scene.record(cameras, 1), 0, &off)));
}

#[test]
fn what_one_camera_misreads_is_dropped_and_its_pixel_says_who_looks_past() {
    let scene = Scene { misreading: Some(2), ..Scene::still_life() };
    let capture = scene.record(arc(5, 64), 1);
    let inspection = inspect(&capture, 0, &Settings::default());
    let dropped = contradicted(&inspection, 2);
    assert!(dropped.len() > 500, "{}", dropped.len());
    for camera in [0, 1, 3, 4] {
        assert!(contradicted(&inspection, camera).is_empty(), "camera {camera}");
    }
    let explanation = explain_pixel(&inspection, 2, dropped[0] % 64, dropped[0] / 64).unwrap();
    assert_eq!(explanation.verdict.rule, Rule::Contradicted);
    assert!(explanation.votes.look_past >= 2 && explanation.votes.confirm == 0);
    let past = explanation.evidence.iter().filter(|row| row.vote == Some(Vote::LooksPast)).count();
    assert_eq!(past as u32, explanation.votes.look_past);
    // What is contradicted is dropped, for a witness or for that alone; most of the rest is confirmed.
    let agreement = inspection.agreement(2);
    for (pixel, found) in agreement.as_slice().iter().enumerate() {
        let verdict = inspection.cameras[2].verdict.as_slice()[pixel];
        assert!(*found != Some(SampleAgreement::Contradicted) || !verdict.is_kept(), "pixel {pixel}");
        assert!(verdict.rule != Rule::Contradicted || *found == Some(SampleAgreement::Contradicted));
        let votes = explain_pixel(&inspection, 2, pixel % 64, pixel / 64).unwrap().votes;
        let expected = (verdict.rule != Rule::NoSample).then(|| SampleAgreement::of(votes, 1, false));
        assert_eq!(*found, expected, "pixel {pixel}");
    }
    let confirmed = |camera| {
        let agreement = inspection.agreement(camera);
        agreement.as_slice().iter().filter(|found| **found == Some(SampleAgreement::Confirmed)).count()
    };
    assert!(confirmed(3) > 64 * 64 / 2, "{}", confirmed(3));
    let report = preprocess(&capture, &Settings::default(), &Job::new()).unwrap().report;
    assert_eq!(report.pruned["contradicted"], dropped.len() as u64);
}

#[test]
fn most_flying_pixels_are_dropped_and_hardly_any_true_sample() {
    // A ball before a wall, which is the side of a ball as large as a hill.
    let ball = Sphere::resting(DVec3::new(0.0, 0.0, 0.6), 0.6, [0.7, 0.2, 0.1]);
    let wall = Sphere::resting(DVec3::new(0.0, 60.0, 0.0), 50.0, [0.4, 0.4, 0.5]);
    let scene = Scene { spheres: vec![ball, wall], normals: true, ..Scene::default() };
    let clean = scene.record(arc(5, 96), 1);
    let flying = Disturbance::FlyingPixels.apply(&clean, 30.0).unwrap().capture;
    let with = |mixed_pixels| {
        let mut settings = Settings::default();
        settings.pruning.mixed_pixels = mixed_pixels;
        inspect(&flying, 0, &settings)
    };
    let [kept, yielding] = [MixedPixels::Keep, MixedPixels::Yield].map(with);
    let (mut planted, mut kept_before, mut kept_after, mut lost) = (0, 0, 0, 0);
    for camera in 0..5 {
        let truth = clean.frame(camera, 0).unwrap();
        for (pixel, verdict) in yielding.cameras[camera].verdict.as_slice().iter().enumerate() {
            let recorded = yielding.cameras[camera].frame.inverse_depth.as_slice()[pixel];
            let true_depth = truth.inverse_depth.as_slice()[pixel];
            let is_true = recorded == true_depth;
            // On slopes seen at a grazing angle samples fly no farther than their neighbors are.
            let is_far_off = (recorded - true_depth).abs() > 0.15 * recorded.max(true_depth);
            let before = kept.cameras[camera].verdict.as_slice()[pixel];
            planted += usize::from(is_far_off);
            kept_before += usize::from(is_far_off && before.is_kept());
            kept_after += usize::from(is_far_off && verdict.is_kept());
            lost += usize::from(is_true && verdict.rule == Rule::Contradicted);
        }
    }
    assert!(planted > 150 && kept_after * 2 < kept_before, "of {planted}: {kept_before}, {kept_after}");
    assert!(lost * 100 < planted * 4, "{lost} true samples beside {planted}");
}

#[test]
fn one_camera_against_another_is_no_majority() {
    let scene = Scene { misreading: Some(1), ..Scene::still_life() };
    assert!(!is_any_contradicted(&inspect(&scene.record(arc(2, 64), 1), 0, &Settings::default())));
}

#[test]
fn silhouettes_and_things_that_move_are_not_contradicted() {
    let mut scene = Scene::still_life();
    let center = |frame: usize| Some(DVec3::new(-1.6 + 0.3 * frame as f64, -0.6, 0.5));
    scene.spheres.push(Sphere { center: Arc::new(center), radius: 0.3, color: [0.2, 0.3, 0.7] });
    let capture = scene.record(arc(6, 80), 6);
    for frame in [0, 3, 5] {
        assert!(!is_any_contradicted(&inspect(&capture, frame, &Settings::default())), "frame {frame}");
    }
}

#[test]
fn what_a_camera_close_by_saw_of_a_thing_too_thin_for_all_others_is_not_contradicted() {
    // Beads of a third of a pixel for the camera close by, and of a tenth for all others.
    let mut scene = Scene::still_life();
    for bead in 0..60 {
        let place = DVec3::new(-0.6 + 0.02 * f64::from(bead), -1.2, 0.5 + 0.003 * f64::from(bead));
        scene.spheres.push(Sphere::resting(place, 0.004, [0.9, 0.9, 0.1]));
    }
    let mut cameras = arc(5, 64);
    cameras.push(camera("close", DVec3::new(0.0, -2.6, 0.6), DVec3::new(0.0, -1.2, 0.55), 160));
    let inspection = inspect(&scene.record(cameras, 1), 0, &Settings::default());
    let close = &inspection.cameras[5];
    let beads = close.frame.color.as_slice().iter().filter(|color| color[0].to_f32() > 0.85).count();
    assert!(beads > 20, "{beads}");
    // A camera farther away that meets a bead sees it in one pixel, as it sees a stray sample.
    assert!(contradicted(&inspection, 5).is_empty());
}

/// The scene as recorded by cameras, some of which are late, each by its own number of frames.
struct Unsynchronized {
    scene: Scene,
    cameras: Vec<Camera>,
    late: [usize; 4],
}

impl FrameSource for Unsynchronized {
    fn load(&self, camera: usize, frame: usize) -> Result<Frame> {
        Ok(self.scene.trace(&self.cameras[camera], frame + self.late[camera], camera))
    }

    fn place(&self, camera: usize, frame: usize) -> String {
        format!("unsynchronized scene, camera {camera}, frame {frame}")
    }
}

#[test]
fn what_cameras_out_of_sync_saw_elsewhere_is_not_contradicted() {
    let mut scene = Scene::still_life();
    let center = |frame: usize| Some(DVec3::new(-1.8 + 0.35 * frame as f64, -0.6, 0.5));
    scene.spheres.push(Sphere { center: Arc::new(center), radius: 0.4, color: [0.2, 0.3, 0.7] });
    let cameras = arc(4, 80);
    let capture = Capture::new(
        CaptureParts {
            name: "unsynchronized".to_owned(),
            frame_numbers: (0..8).collect(),
            up_in_world: DVec3::Z,
            has_normals: true,
            antialiased_color: false,
            warnings: Vec::new(),
            source: Arc::new(Unsynchronized { scene, cameras: cameras.clone(), late: [0, 1, 2, 1] }),
            cameras,
        },
        256 << 20,
    );
    let inspection = inspect(&capture, 4, &Settings::default());
    for camera in 0..4 {
        let seen = &inspection.cameras[camera];
        // What passes outside of where the others ever see it pass is told from nothing.
        let passing = seen.frame.color.as_slice().iter().filter(|color| color[2].to_f32() > 0.65).count();
        let dropped = contradicted(&inspection, camera).len();
        assert!(passing > 100 && dropped * 50 < passing, "camera {camera}: {dropped} of {passing}");
    }
}

#[test]
fn exact_depth_is_not_noisy_between_cameras_and_that_of_noise_is_told_within_a_factor_of_two() {
    let (cameras, job) = (arc(5, 128), Job::new());
    let report = |scene: &Scene| {
        preprocess(&scene.record(cameras.clone(), 1), &Settings::default(), &job).unwrap().report
    };
    let exact = Scene { normals: false, ..Scene::still_life() };
    assert!(report(&exact).cameras.iter().all(|camera| camera.depth_noise_between.is_empty()));
    for sigma in [0.01, 0.02] {
        let noisy = report(&Scene { depth_noise: sigma, ..exact.clone() });
        for camera in &noisy.cameras {
            assert!(!camera.depth_noise_between.is_empty(), "{sigma}");
            // Farther away the ground is seen at grazing angles.
            for noise in camera.depth_noise_between.iter().filter(|noise| noise.depth < 8.0) {
                let ratio = noise.relative / sigma;
                assert!((0.5..1.6).contains(&ratio), "{sigma}: {noise:?}");
            }
        }
        assert_eq!(noisy.warnings(), Vec::<String>::new(), "noise is no reason to doubt what depth means");
    }
}

#[test]
fn consensus_depth_lies_nearer_to_the_truth_than_what_was_recorded() {
    let exact = Scene { normals: false, ..Scene::still_life() };
    let noisy = Scene { depth_noise: 0.02, ..exact.clone() };
    let cameras = arc(7, 128);
    let truth = cameras.iter().map(|camera| exact.trace(camera, 0, 0)).collect::<Vec<_>>();
    let recorded = cameras.iter().enumerate().map(|(seed, camera)| noisy.trace(camera, 0, seed));
    let recorded = recorded.collect::<Vec<_>>();
    let kept = preprocess(&noisy.record(cameras, 1), &Settings::default(), &Job::new()).unwrap().samples;
    let (mut before, mut after) = (0.0, 0.0);
    for image in &kept.images {
        let kept_depths = image.inverse_depths();
        for sample in image.samples() {
            let of = |frames: &[Frame]| frames[image.camera as usize].inverse_depth[(sample.x, sample.y)];
            let expected = of(&truth);
            if expected > 0.0 {
                let error = |inverse_depth: f32| f64::from((inverse_depth / expected - 1.0).powi(2));
                before += error(of(&recorded));
                after += error(kept_depths[sample.index]);
            }
        }
    }
    assert!(after < 0.6 * before, "squared errors of {after} beside {before}");
}

/// Squared errors of the kept colors of a ground that noisy cameras saw, as they were recorded and as they were kept.
fn color_errors(depth_noise: f32) -> [f32; 2] {
    let exact = Scene { normals: false, spheres: Vec::new(), ..Scene::still_life() };
    let noisy = Scene { depth_noise, color_noise: 0.05, ..exact.clone() };
    let cameras = arc(7, 128);
    let truth = cameras.iter().map(|camera| exact.trace(camera, 0, 0)).collect::<Vec<_>>();
    let recorded = cameras.iter().enumerate().map(|(seed, camera)| noisy.trace(camera, 0, seed));
    let recorded = recorded.collect::<Vec<_>>();
    let kept = preprocess(&noisy.record(cameras, 1), &Settings::default(), &Job::new()).unwrap().samples;
    let mut errors = [0.0; 2];
    for image in &kept.images {
        for sample in image.samples() {
            let of = |frames: &[Frame]| frames[image.camera as usize].color[(sample.x, sample.y)];
            for (error, color) in errors.iter_mut().zip([of(&recorded), image.color[sample.index]]) {
                // Toward the horizon pixels are too coarse for the ground's pattern.
                let is_near = truth[image.camera as usize].inverse_depth[(sample.x, sample.y)] > 0.15;
                for channel in (0..3).filter(|_| is_near) {
                    *error += (color[channel].to_f32() - of(&truth)[channel].to_f32()).powi(2);
                }
            }
        }
    }
    errors
}

#[test]
fn cameras_whose_depth_is_noisy_average_their_colors_and_others_keep_them_as_recorded() {
    let [recorded, kept] = color_errors(0.02);
    // The mean of two cameras would halve it, but some samples are confirmed by nobody and stay.
    assert!(kept < 0.7 * recorded, "squared errors of {kept} beside {recorded}");
    let [recorded, kept] = color_errors(0.0);
    assert!(kept == recorded, "squared errors of {kept} beside {recorded}");
}

/// The doubtful samples of a camera, as pixels.
fn doubtful(inspection: &FrameInspection, camera: usize) -> Vec<usize> {
    let width = inspection.cameras[camera].verdict.size().0;
    let images = inspection.samples.images.iter().filter(|image| image.camera as usize == camera);
    let pixels = images.flat_map(|image| {
        let samples = image.samples().filter(|sample| image.is_doubtful(sample.x, sample.y));
        samples.map(|sample| sample.y * width + sample.x).collect::<Vec<_>>()
    });
    pixels.collect()
}

#[test]
fn what_noisy_cameras_had_a_free_view_of_and_do_not_confirm_is_doubtful() {
    let exact = Scene { normals: false, ..Scene::still_life() };
    let noisy = Scene { depth_noise: 0.01, ..exact.clone() };
    // Strays that too few look past: a margin of so many cameras contradicts nothing.
    let scene = Scene { strays: 0.01, ..noisy.clone() };
    let mut settings = Settings::default();
    settings.pruning.agreement_margin = 5;
    let cameras = arc(5, 96);
    let truth = inspect(&exact.record(cameras.clone(), 1), 0, &settings);
    let recorded = inspect(&scene.record(cameras.clone(), 1), 0, &settings);
    let (mut strays, mut doubtful_strays, mut others) = (0, 0, 0);
    for camera in 0..cameras.len() {
        let depths = |inspection: &FrameInspection| inspection.cameras[camera].frame.inverse_depth.clone();
        let (found, expected) = (depths(&recorded), depths(&truth));
        let is_stray = |pixel: usize| {
            let (found, expected) = (found.as_slice()[pixel], expected.as_slice()[pixel]);
            expected > 0.0 && (found / expected - 1.0).abs() > 0.2
        };
        let verdicts = recorded.cameras[camera].verdict.as_slice();
        strays += (0..verdicts.len()).filter(|pixel| is_stray(*pixel) && verdicts[*pixel].is_kept()).count();
        let doubtful = doubtful(&recorded, camera);
        doubtful_strays += doubtful.iter().filter(|pixel| is_stray(**pixel)).count();
        others += doubtful.iter().filter(|pixel| !is_stray(**pixel)).count();
        for &pixel in &doubtful {
            let explanation = explain_pixel(&recorded, camera, pixel % 96, pixel / 96).unwrap();
            assert!(
                explanation.is_doubtful && explanation.verdict.is_kept(),
                "camera {camera}, pixel {pixel}"
            );
        }
    }
    assert!(strays > 100 && doubtful_strays * 2 > strays, "{doubtful_strays} of {strays}");
    assert!(others < strays, "{others} samples that are none beside {strays} strays");
    // Nothing is doubted where depth is exact, nor with agreement off.
    assert!((0..5).all(|camera| doubtful(&truth, camera).is_empty()));
    settings.pruning.agreement = AgreementRule::Off;
    let off = inspect(&scene.record(cameras, 1), 0, &settings);
    assert!((0..5).all(|camera| doubtful(&off, camera).is_empty()));
}

#[test]
fn a_thin_thing_and_one_that_no_other_camera_looks_at_are_not_doubtful() {
    let mut scene = Scene { depth_noise: 0.01, normals: false, ..Scene::still_life() };
    // Beads of a third of a pixel for the camera close by, and of a tenth for all others.
    for bead in 0..60 {
        let place = DVec3::new(-0.6 + 0.02 * f64::from(bead), -1.2, 0.5 + 0.003 * f64::from(bead));
        scene.spheres.push(Sphere::resting(place, 0.004, [0.9, 0.9, 0.1]));
    }
    let mut cameras = arc(5, 96);
    cameras.push(camera("close", DVec3::new(0.0, -2.6, 0.6), DVec3::new(0.0, -1.2, 0.55), 160));
    // It looks to where no other camera does.
    cameras.push(camera("away", DVec3::new(0.0, -3.0, 1.0), DVec3::new(0.0, -9.0, 0.0), 96));
    let inspection = inspect(&scene.record(cameras, 1), 0, &Settings::default());
    let beads = inspection.cameras[5].frame.color.as_slice().iter().enumerate();
    let beads: Vec<usize> =
        beads.filter(|(_, color)| color[0].to_f32() > 0.85).map(|(pixel, _)| pixel).collect();
    let doubted = doubtful(&inspection, 5);
    let doubted_beads = beads.iter().filter(|pixel| doubted.contains(pixel)).count();
    assert!(beads.len() > 20 && doubted_beads * 20 < beads.len(), "{doubted_beads} of {}", beads.len());
    assert_eq!(doubtful(&inspection, 6), [0; 0]);
}
