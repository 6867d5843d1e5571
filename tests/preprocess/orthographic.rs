//! Orthographic cameras in captures: their samples lie where they were seen, redundancy between them and with cameras in perspective is
//! found, nothing is lost, and pictures of them are as they should be.

use std::sync::Arc;

use crate::coverage::assert_covered;
use crate::scene::{Scene, Sphere, camera};
use glam::{DVec2, DVec3};
use overlook_engine::capture::{Camera, Intrinsics, PixelSide};
use overlook_engine::job::Job;
use overlook_engine::preprocess::{Preprocessed, inspect_frame, preprocess, scan};
use overlook_engine::render::{Renderer, Vantage};
use overlook_engine::samples::SampleSet;
use overlook_engine::settings::{Backend, Kernel, Precision, RateModel, RenderSettings, Settings};
use overlook_engine::store;

const MIDDLE: DVec3 = DVec3::new(0.3, 0.2, 0.3);

/// A camera with parallel lines of sight, so far from the middle of the scene, that shows this many world units across.
fn parallel(name: &str, toward: DVec3, distance: f64, size: u32, width: f64) -> Camera {
    let eye = MIDDLE - toward.normalize_or_zero() * distance;
    Camera::look_at(name, Intrinsics::orthographic(size, size, width), eye, MIDDLE, DVec3::Z)
}

/// Two views from the front, one finer than the other, and one from the side.
fn three(distance: f64) -> Vec<Camera> {
    let (front, side) = (DVec3::new(0.1, 1.0, -0.7), DVec3::new(-0.9, 0.7, -0.8));
    vec![
        parallel("fine", front, distance, 96, 3.4),
        parallel("coarse", front, distance + 1.0, 64, 3.4),
        parallel("side", side, distance, 96, 3.4),
    ]
}

/// The same with one in perspective.
fn mixed(distance: f64) -> Vec<Camera> {
    let mut cameras = three(distance);
    cameras.push(camera("pinhole", DVec3::new(1.5, -4.0, 3.0), MIDDLE, 96));
    cameras
}

fn prepared(scene: &Scene, cameras: Vec<Camera>, settings: &Settings) -> Arc<SampleSet> {
    preprocess(&scene.record(cameras, 1), settings, &Job::new()).unwrap().samples
}

/// How far a point is from the surfaces of [`Scene::still_life`].
fn off_surface(point: DVec3) -> f64 {
    let sphere = |center: DVec3, radius: f64| (point.distance(center) - radius).abs();
    let spheres = sphere(DVec3::new(0.0, 0.0, 0.6), 0.6).min(sphere(DVec3::new(1.2, 0.5, 0.4), 0.4));
    spheres.min(point.z.abs())
}

/// Kept samples of each camera at frame 0.
fn kept(samples: &SampleSet) -> Vec<usize> {
    let of = |camera: usize| {
        let images = samples.images_at(0).filter(|image| image.camera as usize == camera);
        images.map(|image| image.len()).sum()
    };
    (0..samples.cameras.len()).map(of).collect()
}

#[test]
fn kept_samples_lie_within_a_tenth_of_a_footprint_of_the_surface_that_was_seen() {
    for distance in [4.0, 40.0, 4000.0] {
        let samples = prepared(&Scene::still_life(), mixed(distance), &Settings::default());
        let mut all = 0;
        for image in samples.images_at(0) {
            let seen_by = &samples.cameras[image.camera as usize];
            for placed in image.placed(seen_by) {
                let footprint = seen_by.intrinsics.pixel_width(placed.depth, PixelSide::Longer);
                let off = off_surface(placed.point_in_world) / footprint;
                assert!(off < 0.1, "{off} footprints at {distance}");
                all += 1;
            }
        }
        assert!(all > 10_000, "{all}");
    }
}

#[test]
fn every_dropped_sample_has_a_kept_one_that_shows_its_point() {
    for (cameras, normals) in
        [(three(4.0), true), (mixed(4.0), true), (mixed(5.0), false), (mixed(300.0), true)]
    {
        let scene = Scene { normals, ..Scene::still_life() };
        for rate in [RateModel::Auto, RateModel::Footprint, RateModel::Paper] {
            let mut settings = Settings::default();
            settings.pruning.rate = rate;
            let capture = scene.record(cameras.clone(), 1);
            let scan = scan(&capture, &settings, &Job::new()).unwrap();
            let inspection = inspect_frame(&capture, Some(&scan), &settings, 0, &Job::new()).unwrap();
            let beyond = assert_covered(&scene, &capture, &inspection, &settings);
            assert!(beyond == 0 || (!normals && beyond < 20), "{beyond}");
        }
    }
}

#[test]
fn of_two_views_in_one_direction_the_finer_one_stays_wherever_their_planes_are() {
    let expected = kept(&prepared(&Scene::still_life(), three(4.0), &Settings::default()));
    assert!(expected[0] > 96 * 96 * 4 / 10, "{expected:?}");
    assert!(expected[1] * 20 < 64 * 64, "{expected:?}");
    for distance in [6.0, 900.0] {
        let found = kept(&prepared(&Scene::still_life(), three(distance), &Settings::default()));
        for (expected, found) in expected.iter().zip(&found) {
            assert!(expected.abs_diff(*found) <= 60, "{found} of {expected} at {distance}");
        }
    }
}

#[test]
fn a_pinhole_camera_and_an_orthographic_one_represent_each_other() {
    let scene = Scene::still_life();
    let alone = kept(&prepared(&scene, mixed(4.0)[3..].to_vec(), &Settings::default()))[0];
    let beside = kept(&prepared(&scene, mixed(4.0), &Settings::default()));
    assert!(beside[3] * 10 < alone * 8, "{beside:?} of {alone}");
    let without = kept(&prepared(&scene, three(4.0), &Settings::default()));
    assert!(beside[..3].iter().sum::<usize>() < without.iter().sum::<usize>(), "{beside:?}, {without:?}");
}

#[test]
fn slow_motion_is_seen_however_far_away_the_camera_plane_is() {
    // Per frame a twentieth of a footprint toward the camera: over eight frames more than depth may range.
    let rising = Arc::new(|frame: usize| Some(DVec3::new(0.0, 0.0, 0.6 + 0.002 * frame as f64)));
    let scene = Scene {
        spheres: vec![Sphere { center: rising, radius: 0.6, color: [0.7, 0.2, 0.1] }],
        ..Scene::still_life()
    };
    for distance in [4.0, 2000.0] {
        let cameras = vec![parallel("top", DVec3::new(0.0, 0.1, -1.0), distance, 64, 3.4)];
        let samples =
            preprocess(&scene.record(cameras, 8), &Settings::default(), &Job::new()).unwrap().samples;
        let still = samples.images.iter().filter(|image| image.span.len() == 8);
        let still: usize = still.map(|image| image.len()).sum();
        // The ground around stays, the sphere does not.
        assert!((64 * 64 / 2..64 * 64 * 95 / 100).contains(&still), "{still} at {distance}");
    }
}

/// A new viewpoint in perspective, of what the cameras saw; its horizontal angle of view in radians.
fn pinhole(angle_rad: f64) -> Camera {
    let (eye, target) = (DVec3::new(-0.6, -3.6, 2.6), DVec3::new(0.2, 0.1, 0.4));
    Camera::look_at("new", Intrinsics::from_horizontal_angle(80, 80, angle_rad), eye, target, DVec3::Z)
}

/// PSNR of a picture of the samples against what the camera would have recorded, linear colors.
fn psnr(scene: &Scene, samples: &Arc<SampleSet>, own: &Camera, settings: &RenderSettings) -> f64 {
    let vantage = Vantage { camera: own.clone(), frame: 0 };
    let (picture, _) = Renderer::new().render(samples, &vantage, settings, &Job::new()).unwrap();
    let truth = scene.trace(own, 0, 0);
    let (mut sum, mut count) = (0.0, 0.0);
    for (found, truth) in picture.color.as_slice().iter().zip(truth.color.as_slice()) {
        for channel in 0..3 {
            sum += f64::from(found[channel] - truth[channel].to_f32()).powi(2);
            count += 1.0;
        }
    }
    -10.0 * (sum / count).log10()
}

#[test]
fn pictures_from_other_viewpoints_show_the_scene() {
    let scene = Scene { color_rays: 3, ..Scene::still_life() };
    let settings = RenderSettings { backend: Backend::Cpu, ..RenderSettings::default() };
    let pinhole = pinhole(0.5);
    let parallel = parallel("new", DVec3::new(-0.25, 1.0, -0.75), 5.0, 80, 2.4);
    for (name, cameras) in [("orthographic", three(4.0)), ("mixed", mixed(4.0)), ("far", mixed(400.0))] {
        for own in [&pinhole, &parallel] {
            let samples = prepared(&scene, cameras.clone(), &Settings::default());
            let found = psnr(&scene, &samples, own, &settings);
            assert!(found > 28.0, "{name}: {found} dB");
        }
    }
}

#[test]
fn every_kernel_paints_what_orthographic_cameras_saw() {
    let scene = Scene::still_life();
    // The pixels of the view are no smaller than those of the cameras, so that single points leave no gaps.
    let pinhole = pinhole(0.9);
    for kernel in [Kernel::Point, Kernel::Block, Kernel::Surfel, Kernel::Gather] {
        let settings = RenderSettings { backend: Backend::Cpu, kernel, ..RenderSettings::default() };
        let samples = prepared(&scene, mixed(4.0), &Settings::default());
        let found = psnr(&scene, &samples, &pinhole, &settings);
        assert!(found > 22.0, "{kernel}: {found} dB");
    }
}

#[test]
fn stores_keep_every_bit_and_those_without_orthographic_cameras_their_version() {
    let folder = tempfile::tempdir().unwrap();
    let scene = Scene::still_life();
    for (cameras, major) in [(mixed(4.0), 4), (mixed(4.0)[3..].to_vec(), 3)] {
        let path = folder.path().join("scene.ovl");
        let mut settings = Settings::default();
        settings.store.precision = Precision::Lossless;
        let Preprocessed { samples, report, .. } =
            preprocess(&scene.record(cameras, 1), &settings, &Job::new()).unwrap();
        store::file::write(&path, &samples, &serde_json::to_string(&report).unwrap(), &Job::new()).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        let head = bytes.windows(4).position(|id| id == b"HEAD").unwrap();
        assert_eq!(bytes[head + 8..head + 10], u16::to_be_bytes(major));
        let read = store::read(&path, &Job::new()).unwrap().0;
        assert_eq!(read.cameras, samples.cameras);
        assert_eq!(read.images.len(), samples.images.len());
        for (a, b) in read.images.iter().zip(&samples.images) {
            assert!(a.color == b.color && a.inverse_depths() == b.inverse_depths() && a.tiles == b.tiles);
        }
    }
}

#[test]
fn a_pixel_is_where_parallel_lines_of_sight_put_it() {
    let own = parallel("own", DVec3::new(0.1, 1.0, -0.7), 4.0, 96, 3.4);
    let frame = Scene::still_life().trace(&own, 0, 0);
    let at = DVec2::new(48.5, 60.5);
    let point = own.unproject(at, 1.0 / f64::from(frame.inverse_depth[(48, 60)]));
    assert!(off_surface(point) < 1e-6);
}
