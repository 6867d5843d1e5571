//! The promises that the renderer gives, on scenes whose right answer is known.

use crate::samples as by_hand;
use std::sync::Arc;

use crate::moving::moving_capture;
use crate::scene::{SKY, Scene, arc, camera};
use glam::{DVec2, DVec3};
use overlook_engine::capture::{Camera, Capture, Frame, Intrinsics};
use overlook_engine::job::Job;
use overlook_engine::preprocess::preprocess;
use overlook_engine::render::{CpuRenderer, Picture, Vantage};
use overlook_engine::samples::{SampleSet, TileMask};
use overlook_engine::settings::{Fill, Kernel, PruningMethod, RenderSettings, Settings};

fn samples(capture: &Capture, settings: &Settings) -> Arc<SampleSet> {
    preprocess(capture, settings, &Job::new()).unwrap().samples
}

/// What samples alone show: holes stay.
fn unfilled(kernel: Kernel) -> RenderSettings {
    RenderSettings { kernel, fill: Fill::None, ..RenderSettings::default() }
}

fn paint(samples: &Arc<SampleSet>, camera: &Camera, frame: usize, kernel: Kernel) -> Arc<Picture> {
    let settings = unfilled(kernel);
    let vantage = Vantage { camera: camera.clone(), frame };
    CpuRenderer::new().render(samples, &vantage, &settings, &Job::new()).unwrap().0
}

#[test]
fn a_camera_that_kept_everything_is_painted_back_exactly() {
    let capture = Scene::still_life().record(arc(1, 64), 1);
    let samples = samples(&capture, &Settings::default());
    for kernel in Kernel::ALL {
        let picture = paint(&samples, &capture.cameras[0], 0, *kernel);
        let frame = capture.frame(0, 0).unwrap();
        assert_eq!(picture.holes(), 0);
        let (mut worst, mut sum) = (0.0_f32, 0.0);
        for (painted, recorded) in picture.color.as_slice().iter().zip(frame.color.as_slice()) {
            for channel in 0..3 {
                let difference = (painted[channel] - recorded[channel].to_f32()).abs();
                worst = worst.max(difference);
                sum += difference;
            }
        }
        let mean = sum / (3 * picture.color.len()) as f32;
        let (most, usual) = match kernel {
            // A surfel's filter reaches a little into its neighbors, which differ most towards the horizon.
            Kernel::Surfel => (0.1, 3e-3),
            // Where a silhouette turns away from the camera, a sub-pixel may be taken for what lies behind: six pixels here.
            Kernel::Gather => (0.05, 1e-4),
            Kernel::Point | Kernel::Block => (1e-3, 1e-3),
        };
        assert!(worst < most && mean < usual, "{kernel}: off by {worst} at worst, by {mean} on average");
    }
}

/// Pixels whose true surface point no camera sees: another surface stands before it, or it lies outside the picture.
fn unseen_pixels(capture: &Capture, vantage: &Camera, truth: &Frame) -> usize {
    let is_seen = |pixel: usize, inverse_depth: f32| {
        let center = DVec2::new((pixel % 96) as f64 + 0.5, (pixel / 96) as f64 + 0.5);
        let point = vantage.unproject(center, f64::from(inverse_depth).recip());
        capture.cameras.iter().enumerate().any(|(index, camera)| {
            let Some((at, z)) = camera.project(point) else { return false };
            let frame = capture.frame(index, 0).unwrap();
            let there = frame.inverse_depth.get(at.x.max(-1.0) as usize, at.y as usize);
            at.min_element() >= 0.0 && there.is_some_and(|there| f64::from(*there) * z < 1.05)
        })
    };
    let pixels = truth.inverse_depth.as_slice().iter().enumerate();
    pixels.filter(|(pixel, w)| **w > 0.0 && !is_seen(*pixel, **w)).count()
}

/// Which solid a pixel shows: the red of the spheres, which have one color each and the ground does not reach; 0 for the ground, and
/// -1 for the sky.
fn solid(truth: &Frame, at: (usize, usize)) -> f32 {
    let red = truth.color[at][0].to_f32();
    let is_sphere = [0.7, 0.1].iter().any(|sphere| (red - sphere).abs() < 1e-3);
    if truth.inverse_depth[at] == 0.0 {
        -1.0
    } else if is_sphere {
        red
    } else {
        0.0
    }
}

/// Whether a pixel or one of those around it shows another solid than the rest.
fn is_at_edge(truth: &Frame, pixel: usize) -> bool {
    let (width, height) = truth.size();
    let (x, y) = (pixel % width, pixel / width);
    let columns = x.saturating_sub(1)..(x + 2).min(width);
    let mut around = columns.flat_map(|x| (y.saturating_sub(1)..(y + 2).min(height)).map(move |y| (x, y)));
    around.any(|at| solid(truth, at) != solid(truth, (x, y)))
}

#[test]
fn a_place_where_no_camera_stood_shows_the_true_surfaces() {
    let scene = Scene::still_life();
    let capture = scene.record(arc(4, 128), 1);
    let vantage = camera("novel", DVec3::new(0.4, -4.6, 2.6), DVec3::new(0.3, 0.2, 0.3), 96);
    let truth = scene.trace(&vantage, 0, 9);
    let samples = samples(&capture, &Settings::default());
    let unseen = unseen_pixels(&capture, &vantage, &truth) as u64;
    let edge = (0..96 * 96).filter(|pixel| is_at_edge(&truth, *pixel)).count();
    for kernel in Kernel::ALL {
        let picture = paint(&samples, &vantage, 0, *kernel);
        let mut wrong = 0;
        for (pixel, &inverse_depth) in picture.inverse_depth.as_slice().iter().enumerate() {
            if inverse_depth > 0.0 && truth.inverse_depth.as_slice()[pixel] > 0.0 {
                let center = DVec2::new((pixel % 96) as f64 + 0.5, (pixel / 96) as f64 + 0.5);
                let found = vantage.unproject(center, f64::from(inverse_depth).recip());
                let z = f64::from(truth.inverse_depth.as_slice()[pixel]).recip();
                // Off the true surface, along its normal, by more than three pixels.
                let normal = truth.normal_in_world.as_ref().unwrap().as_slice()[pixel];
                let off = DVec3::from(normal.map(f64::from)).dot(found - vantage.unproject(center, z)).abs();
                let is_wrong = off > 3.0 * z / vantage.intrinsics.fx;
                wrong += usize::from(is_wrong);
                if is_wrong {
                    assert!(is_at_edge(&truth, pixel), "{kernel}: pixel {pixel} shows another surface");
                }
            }
        }
        // Where a silhouette falls within a pixel is not known: up to 93 of the 308 pixels beside one were found to show the other
        // side with blocks, which are the widest, and 40 with the others.
        let share = if *kernel == Kernel::Block { 3 } else { 6 };
        assert!(
            wrong * share < edge,
            "{kernel}: {wrong} of {edge} pixels at silhouettes show another surface"
        );
        // At most 12 holes were found: footprints cover most of the slivers that no camera sees, 64 pixels.
        assert!(picture.holes() < unseen / 2, "{kernel}: {} holes, {unseen} unseen", picture.holes());
    }
}

#[test]
fn painting_over_a_cached_background_gives_the_same_picture() {
    let capture = moving_capture();
    let samples = samples(&capture, &Settings::default());
    let camera = camera("novel", DVec3::new(0.4, -4.6, 2.6), DVec3::new(0.3, 0.2, 0.3), 80);
    for &kernel in Kernel::ALL {
        let settings = RenderSettings { kernel, ..RenderSettings::default() };
        let mut still = CpuRenderer::new();
        // Whoever looks at a picture holds it while the next is painted.
        let mut looked_at = None;
        for frame in [0, 1, 4, 2, 3, 1] {
            let vantage = Vantage { camera: camera.clone(), frame };
            let (cached, stats) = still.render(&samples, &vantage, &settings, &Job::new()).unwrap();
            assert_eq!(stats.background_reused, frame != 0);
            let (fresh, all) = CpuRenderer::new().render(&samples, &vantage, &settings, &Job::new()).unwrap();
            assert!(cached == fresh, "{kernel}, frame {frame}");
            assert!(!all.background_reused && (frame == 0 || stats.samples * 5 < all.samples));
            if let Some((before, shown)) = looked_at.replace((fresh, cached)) {
                assert!(before == shown, "{kernel}: a picture that is looked at has changed");
            }
        }
    }
}

#[test]
fn what_moved_at_another_vantage_is_gone_though_nothing_moved_when_this_one_was_first_painted() {
    let mut set = (*samples(&moving_capture(), &Settings::default())).clone();
    let frames = set.frame_count();
    set.images.retain(|image| image.span.len() == frames || !image.span.contains(2));
    let set = Arc::new(set);
    let eye = |x| camera("novel", DVec3::new(x, -4.6, 2.6), DVec3::new(0.3, 0.2, 0.3), 80);
    for &kernel in Kernel::ALL {
        let settings = unfilled(kernel);
        let mut renderer = CpuRenderer::new();
        for (x, frame) in [(0.9, 1), (0.4, 2), (0.4, 3), (0.4, 2), (0.4, 4)] {
            let vantage = Vantage { camera: eye(x), frame };
            let (picture, stats) = renderer.render(&set, &vantage, &settings, &Job::new()).unwrap();
            assert!(!stats.background_reused || (stats.samples > 0) == (frame != 2));
            assert!(picture == paint(&set, &vantage.camera, frame, kernel), "{kernel}, frame {frame}");
        }
    }
}

#[test]
fn the_picture_is_the_same_with_one_thread_and_with_many() {
    let capture = moving_capture();
    let samples = samples(&capture, &Settings::default());
    let camera = camera("novel", DVec3::new(-0.6, -4.2, 1.6), DVec3::new(0.3, 0.2, 0.3), 80);
    for kernel in Kernel::ALL {
        let with = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| paint(&samples, &camera, 3, *kernel))
        };
        assert_eq!(with(1), with(3));
    }
}

#[test]
fn the_sky_turns_with_the_view_and_never_hides_anything() {
    let capture = Scene::still_life().record(arc(3, 96), 1);
    let samples = samples(&capture, &Settings::default());
    let up = camera("up", DVec3::new(0.0, -5.0, 2.0), DVec3::new(0.0, 0.0, 1.8), 64);
    let picture = paint(&samples, &up, 0, Kernel::Block);
    let sky =
        picture.inverse_depth.as_slice().iter().zip(picture.color.as_slice()).filter(|(w, _)| **w == 0.0);
    let mut count = 0;
    for (_, color) in sky {
        count += 1;
        assert!((0..3).all(|channel| (color[channel] - SKY[channel]).abs() < 1e-2));
    }
    assert!(count > 200, "{count}");
}

#[test]
fn a_vantage_behind_all_cameras_or_with_no_sample_shows_holes_and_counts_them() {
    let capture = Scene { ground: false, ..Scene::still_life() }.record(arc(2, 48), 1);
    let mut samples = (*samples(&capture, &Settings::default())).clone();
    let away = camera("away", DVec3::new(0.0, -8.0, 1.0), DVec3::new(0.0, -9.0, 1.0), 32);
    let picture = paint(&Arc::new(samples.clone()), &away, 0, Kernel::Block);
    assert_eq!(picture.holes(), 32 * 32);
    assert!(picture.color.as_slice().iter().all(|color| *color == [0.0; 3]));
    samples.images.clear();
    assert_eq!(paint(&Arc::new(samples), &capture.cameras[0], 0, Kernel::Point).holes(), 48 * 48);
}

#[test]
fn an_absurd_picture_or_frame_is_refused_in_one_line() {
    let capture = Scene::still_life().record(arc(1, 16), 1);
    let samples = samples(&capture, &Settings::default());
    for (width, height, frame) in [(0, 10, 0), (10, 0, 0), (u32::MAX, u32::MAX, 0), (8, 8, 1)] {
        let mut camera = capture.cameras[0].clone();
        camera.intrinsics = Intrinsics { width, height, ..camera.intrinsics };
        let result = CpuRenderer::new().render(
            &samples,
            &Vantage { camera, frame },
            &RenderSettings::default(),
            &Job::new(),
        );
        let message = result.unwrap_err().to_string();
        assert!(!message.contains('\n') && message.contains("arc0"), "{message}");
    }
}

#[test]
fn pruning_by_rate_keeps_the_picture_and_first_camera_wins_does_not() {
    let mut scene = Scene::still_life();
    // Fine detail that only the close-up resolves.
    scene.ground_light =
        Some(Arc::new(|_, point| 0.15 * ((point.x * 25.0).sin() * (point.y * 25.0).sin()) as f32));
    let mut cameras = arc(3, 96);
    cameras.push(camera("close", DVec3::new(0.2, -2.2, 1.2), DVec3::new(0.3, -0.4, 0.0), 96));
    let capture = scene.record(cameras, 1);
    // A vantage as near as the close-up, narrow enough to see only what the close-up saw.
    let vantage = Camera::look_at(
        "novel",
        Intrinsics::from_horizontal_angle(48, 48, 0.45),
        DVec3::new(0.4, -2.3, 1.25),
        DVec3::new(0.3, -0.4, 0.0),
        DVec3::Z,
    );
    let truth = scene.trace(&vantage, 0, 9);
    let error = |method| {
        let mut settings = Settings::default();
        settings.pruning.method = method;
        let picture = paint(&samples(&capture, &settings), &vantage, 0, Kernel::Block);
        let pairs = picture.color.as_slice().iter().zip(truth.color.as_slice());
        pairs.map(|(a, b)| (a[0] - b[0].to_f32()).powi(2)).sum::<f32>() / (48.0 * 48.0)
    };
    let (off, rate, first) =
        (error(PruningMethod::Off), error(PruningMethod::HighestRate), error(PruningMethod::FirstCamera));
    assert!(rate < 1.1 * off, "by rate {rate}, unpruned {off}");
    assert!(first > 1.3 * rate, "first camera wins {first}, by rate {rate}");
}

#[test]
fn a_doubtful_sample_is_shown_where_nothing_else_is_and_hides_nothing() {
    let eye = |name: &str| by_hand::plain_camera(name, DVec3::ZERO, 32, 32);
    // A wall at 4 that fills the left half, and before it, from side to side, what another camera saw at 2.
    let wall = by_hand::samples(eye("wall"), |x, _| (x < 16).then_some(([0.5; 3], 0.25)));
    let strip = by_hand::samples(eye("strip"), |_, y| (8..24).contains(&y).then_some(([0.9, 0.1, 0.1], 0.5)));
    let both = |is_doubtful: bool| {
        let mut near = (*strip.images[0]).clone();
        near.camera = 1;
        if is_doubtful {
            let all = near.tiles.iter().enumerate();
            near.doubtful =
                all.map(|(tile, found)| TileMask { tile: tile as u32, rows: found.rows }).collect();
        }
        Arc::new(SampleSet {
            cameras: vec![eye("wall"), eye("strip")],
            images: vec![wall.images[0].clone(), Arc::new(near)],
            ..(*wall).clone()
        })
    };
    let (trusted, doubtful) = (both(false), both(true));
    for kernel in Kernel::ALL {
        let depth = |samples: &Arc<SampleSet>, at| paint(samples, &eye("here"), 0, *kernel).inverse_depth[at];
        let near = |w: f32, expected: f32| (w - expected).abs() < 1e-3;
        assert!(near(depth(&trusted, (7, 15)), 0.5), "{kernel}: the nearer of two surfaces");
        assert!(near(depth(&doubtful, (7, 15)), 0.25), "{kernel}: the one that is not doubtful");
        assert!(near(depth(&doubtful, (24, 15)), 0.5), "{kernel}: the only one");
        assert!(near(depth(&doubtful, (7, 3)), 0.25) && depth(&doubtful, (24, 3)) < 0.0, "{kernel}");
    }
}
