//! The built-in scenes keep their promises: exact, diffuse, deterministic, still where nothing moves.

use std::sync::Arc;

use glam::{DVec2, DVec3};
use half::f16;
use overlook_engine::capture::{Camera, Capture, Frame};
use overlook_engine::color::steps_from_linear;
use overlook_engine::demo::{Demo, DemoSpec, MAX_CAMERAS, MAX_FRAMES, SCENES};
use overlook_engine::preprocess::noise::{CameraNoise, measure_pairs};
use overlook_engine::settings::CaptureSettings;
use rayon::ThreadPoolBuilder;
use rayon::prelude::*;

fn small(scene: &str, size: (u32, u32)) -> Demo {
    Demo::new(&DemoSpec::new(scene).size(size).noise(0.0)).unwrap_or_else(|error| panic!("{error}"))
}

fn capture(demo: &Demo) -> Capture {
    demo.capture(&CaptureSettings::default())
}

fn names() -> impl Iterator<Item = &'static str> {
    SCENES.iter().map(|(name, _)| *name)
}

fn center(x: usize, y: usize) -> DVec2 {
    DVec2::new(x as f64 + 0.5, y as f64 + 0.5)
}

/// What one pixel of a frame says.
fn pixel(demo: &Demo, camera: &Camera, frame: usize) -> Frame {
    assert_eq!(camera.intrinsics.pixel_count(), 1);
    demo.render(camera, frame)
}

/// `camera` cut down to the single pixel whose center is at image position `at`.
fn aimed(camera: &Camera, at: DVec2) -> Camera {
    let mut camera = camera.clone();
    let intrinsics = &mut camera.intrinsics;
    (intrinsics.width, intrinsics.height) = (1, 1);
    (intrinsics.cx, intrinsics.cy) = (intrinsics.cx - at.x + 0.5, intrinsics.cy - at.y + 0.5);
    camera
}

#[test]
fn the_papers_recordings_have_their_sizes() {
    let shape = |scene| {
        let capture = capture(&Demo::new(&DemoSpec::new(scene)).unwrap());
        (
            capture.cameras.len(),
            capture.frame_count(),
            capture.cameras[0].intrinsics.size(),
            capture.has_normals,
            capture.antialiased_color,
        )
    };
    assert_eq!(shape("orrery"), (5, 48, (480, 360), true, false));
    assert_eq!(shape("nine-cameras"), (9, 60, (640, 480), false, true));
    assert_eq!(shape("four-cameras"), (4, 300, (320, 240), true, false));
    assert_eq!(shape("crystal"), (6, 60, (640, 480), true, true));
    assert_eq!(SCENES[0].0, "orrery");
}

#[test]
fn every_scene_takes_any_size_and_any_number_of_cameras() {
    for scene in names() {
        for (cameras, size) in [(1, (1, 1)), (1, (7, 5)), (MAX_CAMERAS, (7, 5))] {
            let demo = Demo::new(&DemoSpec::new(scene).cameras(cameras).frames(2).size(size)).unwrap();
            let capture = capture(&demo);
            assert_eq!(capture.cameras.len(), cameras);
            for camera in 0..cameras {
                let frame = capture.frame(camera, 1).unwrap();
                assert_eq!(frame.invalid_pixels(), 0);
                assert!(frame.color.as_slice().iter().flatten().all(|value| value.is_finite()));
                assert_eq!(frame.normal_in_world.is_some(), capture.has_normals);
            }
            let mut camera_names: Vec<_> = capture.cameras.iter().map(|camera| &camera.name).collect();
            camera_names.sort();
            camera_names.dedup();
            assert_eq!(camera_names.len(), cameras, "names are unique");
        }
    }
}

#[test]
fn absurd_recordings_are_refused_in_one_line() {
    let refused = [
        DemoSpec::new("orery"),
        DemoSpec::new("orrery").cameras(0),
        DemoSpec::new("orrery").cameras(MAX_CAMERAS + 1),
        DemoSpec::new("orrery").frames(0),
        DemoSpec::new("orrery").frames(MAX_FRAMES + 1),
        DemoSpec::new("orrery").size((0, 10)),
        DemoSpec::new("orrery").size((10, 20_000)),
        DemoSpec::new("orrery").noise(-0.1),
        DemoSpec::new("orrery").noise(f32::NAN),
    ];
    for spec in refused {
        let message = Demo::new(&spec).unwrap_err().to_string();
        assert!(!message.contains('\n') && message.contains("demo"), "{message}");
    }
}

#[test]
fn every_camera_stands_in_the_open_and_sees_the_scene() {
    for scene in names() {
        let demo = Demo::new(&DemoSpec::new(scene).cameras(MAX_CAMERAS).size((16, 12)).noise(0.0)).unwrap();
        for camera in capture(&demo).cameras.clone() {
            let frame = demo.render(&camera, 0);
            let depths = frame.inverse_depth.as_slice();
            let hits = depths.iter().filter(|depth| **depth > 0.0).count();
            assert!(2 * hits > depths.len(), "{scene}: '{}' looks past the scene", camera.name);
            assert!(depths.iter().all(|depth| *depth < 1.0 / 0.12), "{scene}: '{}' is blocked", camera.name);
        }
    }
}

#[test]
fn two_cameras_see_the_same_color_at_the_same_point() {
    for scene in names() {
        let demo = small(scene, (14, 10));
        let cameras = capture(&demo).cameras.clone();
        let mut seen_by_both = 0;
        for (first, second) in [(0, 1), (1, 2), (0, 3)] {
            let (first, second) = (&cameras[first], &cameras[second]);
            for (x, y) in (0..10).flat_map(|y| (0..14).map(move |x| (x, y))) {
                let here = pixel(&demo, &aimed(first, center(x, y)), 3);
                let depth = here.inverse_depth[(0, 0)];
                if depth <= 0.0 {
                    continue;
                }
                let point = first.unproject(center(x, y), 1.0 / f64::from(depth));
                let Some((at, expected_z)) = second.project(point) else { continue };
                let there = pixel(&demo, &aimed(second, at), 3);
                let z = 1.0 / f64::from(there.inverse_depth[(0, 0)]);
                if (z - expected_z).abs() > 1e-5 * expected_z {
                    continue;
                }
                seen_by_both += 1;
                for (a, b) in here.color[(0, 0)].into_iter().zip(there.color[(0, 0)]) {
                    let steps = (steps_from_linear(a) - steps_from_linear(b)).abs();
                    assert!(steps < 1.0, "{scene}: {steps} steps apart at {point}");
                }
            }
        }
        assert!(seen_by_both > 100, "{scene}: only {seen_by_both} points compared");
    }
}

#[test]
fn depth_is_the_distance_to_the_surface() {
    // The floor of every scene is the plane z = 0 in the corner that the high cameras see: look straight down at it.
    for (scene, eye) in
        [("orrery", [2.2, -2.2]), ("nine-cameras", [2.2, -2.2]), ("four-cameras", [1.9, -1.9])]
    {
        let demo = small(scene, (9, 9));
        let template = &capture(&demo).cameras[0];
        let eye = DVec3::new(eye[0], eye[1], 2.5);
        let camera = Camera::look_at("down", template.intrinsics, eye, eye - DVec3::Z, DVec3::Y);
        let frame = demo.render(&camera, 0);
        assert_eq!(frame.inverse_depth[(4, 4)], (1.0 / 2.5) as f32);
        if let Some(normals) = frame.normal_in_world {
            assert_eq!(normals[(4, 4)], [0.0, 0.0, 1.0]);
        }
    }
}

#[test]
fn around_the_crystal_is_pure_white() {
    let demo = small("crystal", (60, 45));
    for camera in capture(&demo).cameras.clone() {
        let frame = demo.render(&camera, 59);
        let mut sky = 0;
        for (x, y) in (1..44).flat_map(|y| (1..59).map(move |x| (x, y))) {
            let beside = |x: usize, y: usize| frame.inverse_depth[(x, y)] == 0.0;
            // A pixel at an edge holds some of the solid beside it.
            if (y - 1..=y + 1).all(|y| (x - 1..=x + 1).all(|x| beside(x, y))) {
                assert_eq!(frame.color[(x, y)], [f16::ONE; 3]);
                sky += 1;
            }
        }
        assert!(sky > 0 || camera.name == "seed", "'{}' sees nothing but atoms", camera.name);
    }
}

#[test]
fn normals_are_unit_and_face_the_camera() {
    let demo = small("orrery", (60, 45));
    for camera in capture(&demo).cameras.clone() {
        let frame = demo.render(&camera, 5);
        let normals = frame.normal_in_world.as_ref().unwrap();
        for (x, y) in (0..45).flat_map(|y| (0..60).map(move |x| (x, y))) {
            let normal = DVec3::from(normals[(x, y)].map(f64::from));
            if frame.inverse_depth[(x, y)] > 0.0 {
                let ray = camera.unproject(center(x, y), 1.0) - camera.position_in_world();
                assert!((normal.length() - 1.0).abs() < 1e-5 && normal.dot(ray) <= 1e-6);
            } else {
                assert_eq!(normal, DVec3::ZERO);
            }
        }
    }
}

#[test]
fn a_frame_is_the_same_bytes_for_any_number_of_threads() {
    for scene in names() {
        let demo = Demo::new(&DemoSpec::new(scene).size((40, 30))).unwrap();
        let camera = capture(&demo).cameras[0].clone();
        let many = (demo.render(&camera, 7), capture(&demo).frame(0, 7).unwrap());
        for threads in [1, 2] {
            let pool = ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let few = pool.install(|| (demo.render(&camera, 7), capture(&demo).frame(0, 7).unwrap()));
            assert_eq!(many.0, few.0);
            assert_eq!(many.1, few.1);
        }
    }
}

#[test]
fn noise_differs_from_frame_to_frame_around_the_true_color() {
    let demo = Demo::new(&DemoSpec::new("nine-cameras").size((64, 48))).unwrap();
    let noisy = capture(&demo);
    let truth = demo.render(&noisy.cameras[1], 0);
    let relative = |frame: &Arc<Frame>| -> Vec<f64> {
        let pairs = frame.color.as_slice().iter().zip(truth.color.as_slice());
        pairs.map(|(a, b)| f64::from(a[1].to_f32()) / f64::from(b[1].to_f32()) - 1.0).collect()
    };
    let errors = relative(&noisy.frame(1, 0).unwrap());
    let mean = errors.iter().sum::<f64>() / errors.len() as f64;
    let deviation = (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt();
    assert!(mean.abs() < 0.003, "biased by {mean}");
    assert!((0.028..0.045).contains(&deviation), "standard deviation {deviation}");
    let (first, again) = (noisy.frame(1, 0).unwrap(), capture(&demo).frame(1, 0).unwrap());
    assert_eq!(first, again, "noise is a function of camera, frame and pixel");
    let next = noisy.frame(1, 1).unwrap();
    let same = first.color.as_slice().iter().zip(next.color.as_slice()).filter(|(a, b)| a == b).count();
    assert!(10 * same < first.color.len(), "{same} pixels keep their noise");
    assert_eq!(first.inverse_depth[(2, 2)], next.inverse_depth[(2, 2)], "depth has no noise");
}

/// Share of the pixels of a camera that change at all over the given frames.
fn moving_share(demo: &Demo, camera: &Camera, frames: impl Iterator<Item = usize>) -> f64 {
    let first = demo.render(camera, 0);
    let mut moving = vec![false; first.color.len()];
    for frame in frames {
        let now = demo.render(camera, frame);
        for (index, moving) in moving.iter_mut().enumerate() {
            *moving |= now.color.as_slice()[index] != first.color.as_slice()[index]
                || now.inverse_depth.as_slice()[index] != first.inverse_depth.as_slice()[index];
        }
    }
    moving.iter().filter(|moving| **moving).count() as f64 / moving.len() as f64
}

#[test]
fn few_pixels_of_four_cameras_ever_change() {
    let demo = small("four-cameras", (80, 60));
    let cameras = capture(&demo).cameras.clone();
    let shares: Vec<f64> = cameras
        .iter()
        // 13 does not divide the beat of the ball: the frames catch it at many heights.
        .map(|camera| moving_share(&demo, camera, (0..300).step_by(13).chain([299])))
        .collect();
    let mean = shares.iter().sum::<f64>() / shares.len() as f64;
    assert!(mean > 0.005 && mean < 0.055, "changing shares {shares:?}");
    assert!(shares.iter().all(|share| *share < 0.12), "changing shares {shares:?}");
}

#[test]
fn most_of_every_scene_is_bit_identical_from_frame_to_frame() {
    for (scene, most) in [("orrery", 0.75), ("nine-cameras", 0.5)] {
        let demo = small(scene, (60, 45));
        for camera in capture(&demo).cameras.clone() {
            let share = moving_share(&demo, &camera, (0..48).step_by(5));
            assert!(share < most, "{scene}: {share} of '{}' changes", camera.name);
        }
    }
}

#[test]
fn the_default_scenes_loop_and_move() {
    for scene in ["orrery", "nine-cameras"] {
        let demo = small(scene, (60, 45));
        let capture = capture(&demo);
        let camera = &capture.cameras[0];
        let color = |frame| demo.render(camera, frame).color;
        assert_ne!(color(0), color(1));
        let differing = |a, b| {
            let (a, b) = (demo.render(camera, a), demo.render(camera, b));
            let pairs = a.inverse_depth.as_slice().iter().zip(b.inverse_depth.as_slice());
            pairs.filter(|(a, b)| (*a - *b).abs() > 1e-4 * a.abs()).count()
        };
        assert!(differing(0, capture.frame_count()) <= 2, "{scene} closes its loop");
    }
}

#[test]
fn truth_views_lie_between_the_cameras_and_come_with_their_pictures() {
    for scene in names() {
        let demo = Demo::new(&DemoSpec::new(scene).size((32, 24))).unwrap();
        let views = demo.truth_views();
        let capture = capture(&demo);
        let mut paths: Vec<_> = views.iter().map(|view| view.file_path.clone()).collect();
        paths.dedup();
        assert!(paths.len() >= 15 && paths[0] == "novel0/0000.exr");
        for view in &views {
            assert!(capture.frame_index(view.frame_number).is_some());
            let eye = view.camera.position_in_world();
            assert!(capture.cameras.iter().all(|camera| camera.position_in_world().distance(eye) > 0.1));
        }
        let truth = views[6].truth.as_ref().unwrap()().unwrap();
        assert_eq!(truth, demo.render(&views[6].camera, views[6].frame_number as usize));
        assert_eq!(demo.home().intrinsics.size(), (32, 24));
    }
}

#[test]
fn many_workers_may_ask_for_frames_of_one_camera_at_once() {
    for scene in names() {
        let demo = small(scene, (30, 22));
        let capture = capture(&demo);
        let ask = || (0..24_usize).into_par_iter().map(|frame| capture.frame(0, frame).unwrap()).collect();
        let pool = ThreadPoolBuilder::new().num_threads(4).build().unwrap();
        // A crowd in the shared pool and one in its own, on the same frames.
        let (here, there): (Vec<_>, Vec<_>) = std::thread::scope(|scope| {
            let here = scope.spawn(ask);
            let there = pool.install(ask);
            (here.join().unwrap(), there)
        });
        for (frame, (here, there)) in here.iter().zip(&there).enumerate() {
            assert_eq!(**here, demo.render(&capture.cameras[0], frame));
            assert_eq!(here, there);
        }
    }
}

/// Two cameras of a scene as it is recorded, over 48 frames.
fn recorded(scene: &str) -> Demo {
    Demo::new(&DemoSpec::new(scene).cameras(2).frames(48).size((200, 150))).unwrap()
}

/// What [`measure_pairs`] says of some frames and those after them.
fn measured(demo: &Demo, camera: usize, frames: [usize; 3]) -> CameraNoise {
    let capture = capture(demo);
    let pairs = frames.map(|first| [first, first + 1].map(|frame| capture.frame(camera, frame).unwrap()));
    let pairs: Vec<[&Frame; 2]> = pairs.iter().map(|[before, after]| [&**before, &**after]).collect();
    measure_pairs(&pairs)
}

#[test]
fn the_noise_of_a_scene_is_that_which_was_put_in() {
    let noise = measured(&recorded("nine-cameras"), 0, [0, 20, 40]);
    let steps = |linear: f32| steps_from_linear(f16::from_f32(linear));
    for linear in [0.1_f32, 0.2, 0.3] {
        // See `demo::tracer::camera_noise`: a relative deviation of 0.03.
        let sigma = 0.03 * (linear * (linear + 0.02)).sqrt();
        let expected = 0.5 * (steps(linear + sigma) - steps(linear - sigma));
        let ratio = noise.color_at(steps(linear)) / expected;
        assert!((0.85..1.15).contains(&ratio), "{linear}: {ratio}");
    }
}

#[test]
fn shadows_that_sweep_over_a_scene_are_no_noise() {
    let demo = recorded("orrery");
    for camera in 0..2 {
        let steps = measured(&demo, camera, [0, 23, 46]).color_steps_overall;
        assert!(steps < 0.15, "camera {camera}: {steps}");
    }
}
