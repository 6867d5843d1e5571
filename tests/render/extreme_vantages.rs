//! Vantages where renderers break: inside things, on top of samples, of absurd size, without anything to see. Every kernel,
//! with holes filled and not.

use std::sync::Arc;

use crate::samples::{plain_camera, samples};
use glam::{DAffine3, DMat3, DVec3};
use half::f16;
use overlook_engine::capture::{Camera, Frame, Intrinsics, Values};
use overlook_engine::error::Result;
use overlook_engine::grid::Grid;
use overlook_engine::job::Job;
use overlook_engine::render::{CpuRenderer, MAX_PIXELS, NO_IMAGE, Picture, RenderStats, Vantage};
use overlook_engine::samples::SampleSet;
use overlook_engine::settings::{Fill, Kernel, RenderSettings};
use overlook_lab::metrics;

const WIDTH: u32 = 64;
const HEIGHT: u32 = 48;

const RED: [f32; 3] = [0.75, 0.125, 0.0625];
const BLUE: [f32; 3] = [0.125, 0.25, 0.75];

fn front() -> Camera {
    plain_camera("front", DVec3::ZERO, WIDTH, HEIGHT)
}

/// The camera of every capture here, moved.
fn moved(eye: DVec3) -> Camera {
    plain_camera("moved", eye, WIDTH, HEIGHT)
}

/// Every kernel with every way to fill holes.
fn all_settings() -> impl Iterator<Item = RenderSettings> {
    Kernel::ALL.iter().flat_map(|kernel| {
        Fill::ALL.iter().map(|fill| RenderSettings {
            kernel: *kernel,
            fill: *fill,
            ..RenderSettings::default()
        })
    })
}

fn name(settings: &RenderSettings) -> String {
    format!("{} with fill {}", settings.kernel, settings.fill)
}

fn render(
    set: &Arc<SampleSet>,
    camera: &Camera,
    settings: &RenderSettings,
) -> Result<(Arc<Picture>, RenderStats)> {
    let vantage = Vantage { camera: camera.clone(), frame: 0 };
    CpuRenderer::new().render(set, &vantage, settings, &Job::new())
}

/// The picture, with everything checked that is true of any picture.
fn paint(set: &Arc<SampleSet>, camera: &Camera, settings: &RenderSettings) -> Arc<Picture> {
    let (picture, stats) = render(set, camera, settings).unwrap();
    assert_eq!(picture.image.size(), camera.intrinsics.size());
    assert_eq!(stats.holes, picture.holes());
    let anything = picture.holes() < picture.image.len() as u64;
    let filled = settings.fill != Fill::None && anything;
    for (pixel, image) in picture.image.as_slice().iter().enumerate() {
        let (color, inverse_depth) =
            (picture.color.as_slice()[pixel], picture.inverse_depth.as_slice()[pixel]);
        assert!(color.iter().all(|channel| channel.is_finite() && *channel >= 0.0), "{}", name(settings));
        assert!(inverse_depth.is_finite(), "{}: {inverse_depth}", name(settings));
        let shown = filled || *image != NO_IMAGE;
        assert!((inverse_depth >= 0.0) == shown, "{}: {inverse_depth}", name(settings));
        let is_covered_in_part = picture.coverage.get(pixel).is_some_and(|share| *share > 0.0);
        assert!(
            shown || is_covered_in_part || color == [0.0; 3],
            "{}: a hole shows {color:?}",
            name(settings)
        );
    }
    picture
}

fn painted(picture: &Picture) -> impl Iterator<Item = (usize, [f32; 3], f32)> + '_ {
    let pixels = (0..picture.image.len()).filter(|&pixel| picture.image.as_slice()[pixel] != NO_IMAGE);
    pixels.map(|pixel| (pixel, picture.color.as_slice()[pixel], picture.inverse_depth.as_slice()[pixel]))
}

fn assert_color(found: [f32; 3], expected: [f32; 3], tolerance: f32, what: &str) {
    let off = (0..3).map(|c| (found[c] - expected[c]).abs()).fold(0.0, f32::max);
    assert!(off <= tolerance, "{what}: {found:?} instead of {expected:?}");
}

/// The smooth paint of a wall: color by direction of sight from the origin.
fn paint_of(ray_x: f64, ray_y: f64) -> [f32; 3] {
    [0.5 + 0.4 * ray_x as f32, 0.5 + 0.4 * ray_y as f32, 0.5 - 0.3 * (ray_x + ray_y) as f32]
}

/// A painted wall at depth 4 that fills the picture.
fn wall() -> Arc<SampleSet> {
    samples(front(), |x, y| {
        let ray = front().intrinsics.ray_in_camera(glam::DVec2::new(x as f64 + 0.5, y as f64 + 0.5));
        Some((paint_of(ray.x, ray.y), 0.25))
    })
}

/// A red wall at depth 4 on the left, a blue one at depth 8 on the right.
fn two_walls() -> Arc<SampleSet> {
    samples(front(), |x, _| Some(if x < 32 { (RED, 0.25) } else { (BLUE, 0.125) }))
}

#[test]
fn on_top_of_a_source_camera_its_picture_comes_back() {
    let set = wall();
    for settings in all_settings() {
        let picture = paint(&set, &front(), &settings);
        assert_eq!(picture.holes(), 0, "{}", name(&settings));
        for (pixel, color, inverse_depth) in painted(&picture) {
            let own = set.images[0].color[set.images[0]
                .samples()
                .find(|sample| sample.y * WIDTH as usize + sample.x == pixel)
                .unwrap()
                .index];
            assert_color(color, own.map(f16::to_f32), 2e-3, &name(&settings));
            assert!((inverse_depth - 0.25).abs() < 1e-6);
        }
    }
}

#[test]
fn inside_a_thing_only_what_lies_ahead_is_seen() {
    // One unit behind the red wall and three before the blue one.
    let inside = moved(DVec3::new(0.0, 0.0, 5.0));
    for settings in all_settings() {
        let picture = paint(&two_walls(), &inside, &settings);
        assert!(picture.holes() < u64::from(WIDTH * HEIGHT), "{}", name(&settings));
        for (_, color, inverse_depth) in painted(&picture) {
            assert_color(color, BLUE, 1e-3, &name(&settings));
            assert!((inverse_depth - 1.0 / 3.0).abs() < 1e-6);
        }
    }
}

#[test]
fn what_lies_behind_is_never_painted() {
    let turned = Camera {
        world_from_camera: DAffine3::from_mat3_translation(
            DMat3::from_rotation_y(std::f64::consts::PI),
            DVec3::new(0.0, 0.0, -1.0),
        ),
        ..front()
    };
    let truth = Frame {
        color: Grid::filled(WIDTH as usize, HEIGHT as usize, [f16::ONE; 3]),
        inverse_depth: Grid::filled(WIDTH as usize, HEIGHT as usize, 0.5),
        normal_in_world: None,
        depth_step_relative: 0.0,
        values: Values::default(),
    };
    // Behind the camera and looking away; past everything and looking ahead.
    for camera in [turned, moved(DVec3::new(0.3, -0.2, 20.0))] {
        for settings in all_settings() {
            let picture = paint(&two_walls(), &camera, &settings);
            assert_eq!(picture.holes(), u64::from(WIDTH * HEIGHT), "{}", name(&settings));
            assert_eq!(metrics::score(&picture, &truth).unwrap().coverage, 0.0);
        }
    }
}

#[test]
fn a_sample_in_the_very_center_of_projection_is_left_out() {
    // The eye lies on the red wall, on one of its samples; all of the wall has depth 0 there.
    let eye = DVec3::new(-1.0 / 32.0, 1.0 / 32.0, 4.0);
    for settings in all_settings() {
        let picture = paint(&two_walls(), &moved(eye), &settings);
        for (_, color, inverse_depth) in painted(&picture) {
            assert_color(color, BLUE, 1e-3, &name(&settings));
            assert!((inverse_depth - 0.25).abs() < 1e-6);
        }
        assert!(picture.holes() < u64::from(WIDTH * HEIGHT));
        // A hair before and behind: whatever is seen is finite, which `paint` checks.
        for hair in [1e-3, 1e-7, 1e-12] {
            paint(&two_walls(), &moved(eye - DVec3::Z * hair), &settings);
            paint(&two_walls(), &moved(eye + DVec3::Z * hair), &settings);
        }
    }
}

#[test]
fn without_samples_all_is_a_hole_and_one_sample_is_one_place() {
    for settings in all_settings() {
        let nothing = samples(front(), |_, _| None);
        assert_eq!(paint(&nothing, &front(), &settings).holes(), u64::from(WIDTH * HEIGHT));

        let one = samples(front(), |x, y| ((x, y) == (40, 30)).then_some((RED, 0.25)));
        let picture = paint(&one, &front(), &settings);
        let at: Vec<_> = painted(&picture).map(|(pixel, ..)| pixel).collect();
        assert!(at.contains(&(30 * WIDTH as usize + 40)) && at.len() <= 9, "{}: {at:?}", name(&settings));
        for (pixel, color) in picture.color.as_slice().iter().enumerate() {
            if settings.fill == Fill::PushPull || at.contains(&pixel) {
                assert_color(*color, RED, 1e-5, &name(&settings));
            }
        }
    }
}

#[test]
fn what_is_at_infinity_turns_with_the_view_and_never_shifts() {
    let sky = samples(front(), |x, y| Some(([x as f32 / 64.0, y as f32 / 64.0, 0.5], 0.0)));
    // Rolled by half a turn: the picture upside down, pixel for pixel.
    let mut rolled = front();
    rolled.world_from_camera.matrix3 = DMat3::from_diagonal(DVec3::new(-1.0, -1.0, 1.0));
    for settings in all_settings() {
        let here = paint(&sky, &front(), &settings);
        assert!(here.inverse_depth.as_slice().iter().all(|inverse_depth| *inverse_depth == 0.0));
        for eye in [DVec3::new(3.0, -2.0, 5.0), DVec3::splat(1e9)] {
            let there = paint(&sky, &moved(eye), &settings);
            assert_eq!((&there.color, &there.image), (&here.color, &here.image), "{}", name(&settings));
        }
        let upside_down = paint(&sky, &rolled, &settings);
        for (pixel, color) in upside_down.color.as_slice().iter().rev().enumerate() {
            let upright = here.color.as_slice()[pixel];
            assert_color(*color, upright, 2e-3, &format!("{}, pixel {pixel}", name(&settings)));
        }
    }
}

#[test]
fn pixels_may_be_oblong_and_the_principal_point_anywhere() {
    let mut camera = front();
    camera.intrinsics = Intrinsics { fx: 40.0, fy: 30.0, cx: 20.25, cy: 37.5, ..camera.intrinsics };
    // The wall is seen in part: rays of up to a half to each side, and three eighths up and down.
    let seen = |ray: DVec3| ray.x.abs() < 0.46 && ray.y.abs() < 0.33;
    for settings in all_settings() {
        let picture = paint(&wall(), &camera, &settings);
        let mut count = 0;
        for (pixel, color, inverse_depth) in painted(&picture) {
            let center = glam::DVec2::new((pixel % 64) as f64 + 0.5, (pixel / 64) as f64 + 0.5);
            let ray = camera.intrinsics.ray_in_camera(center);
            if seen(ray) {
                // A pixel here is 1/30 high, over which the paint changes by less than 0.02.
                assert_color(color, paint_of(ray.x, ray.y), 0.02, &name(&settings));
                assert!((inverse_depth - 0.25).abs() < 1e-6);
                count += 1;
            }
        }
        let all = (0..64 * 48)
            .map(|i| glam::DVec2::new(f64::from(i % 64) + 0.5, f64::from(i / 64) + 0.5))
            .filter(|center| seen(camera.intrinsics.ray_in_camera(*center)))
            .count();
        assert!(count == all && all > 500, "{}: {count} of {all}", name(&settings));
    }
}

#[test]
fn a_picture_of_one_pixel_shows_what_lies_in_its_middle() {
    let set = samples(front(), |_, _| Some((BLUE, 0.25)));
    for settings in all_settings() {
        let picture = paint(&set, &plain_camera("dot", DVec3::ZERO, 1, 1), &settings);
        assert_eq!(picture.holes(), 0);
        assert_color(picture.color[(0, 0)], BLUE, 1e-3, &name(&settings));
        assert!((picture.inverse_depth[(0, 0)] - 0.25).abs() < 1e-6);
        // Far off to the side of all there is.
        let aside = paint(&set, &plain_camera("dot", DVec3::new(100.0, 0.0, 0.0), 1, 1), &settings);
        assert_eq!(aside.holes(), 1);
    }
}

#[test]
fn a_place_absurdly_far_away_sees_a_dot_or_nothing() {
    for settings in all_settings() {
        for distance in [1e3, 1e9, 1e30, 1e200] {
            let picture = paint(&wall(), &moved(DVec3::new(0.0, 0.0, -distance)), &settings);
            assert!(painted(&picture).count() <= 16, "{} from {distance}", name(&settings));
        }
    }
}

#[test]
fn a_large_picture_holds_a_few_samples_at_their_places() {
    // One kernel: they differ in what they do with a sample, not with a picture's size.
    let settings = RenderSettings { kernel: Kernel::Point, ..RenderSettings::default() };
    let set = samples(front(), |x, y| (x % 16 == 8 && y % 16 == 8).then_some((RED, 0.25)));
    let picture = render(&set, &plain_camera("8K", DVec3::ZERO, 7680, 4320), &settings).unwrap().0;
    assert_eq!(picture.holes(), 7680 * 4320 - 12);
    // 120 pixels here for one there, the centers of both pictures being the same.
    for (pixel, ..) in painted(&picture) {
        let (x, y) = (pixel % 7680, pixel / 7680);
        let off = ((x % 1920).abs_diff(1020), (y % 1920).abs_diff(300));
        assert!(off.0 <= 1 && off.1 <= 1, "({x}, {y})");
    }
    // Twelve samples fill half a million pixels.
    let settings = RenderSettings { fill: Fill::PushPull, ..settings };
    let picture = paint(&set, &plain_camera("wide", DVec3::ZERO, 768, 576), &settings);
    assert_eq!(picture.holes(), 768 * 576 - 12);
    assert!(picture.inverse_depth.as_slice().iter().all(|w| (w - 0.25).abs() < 1e-6));
}

/// Asserts that every kernel refuses `camera` in one line that names it and says `what`.
fn assert_refused(camera: &Camera, what: &str) {
    for settings in all_settings() {
        let message = render(&wall(), camera, &settings).unwrap_err().to_string();
        let in_one_line =
            !message.contains('\n') && message.contains(&format!("viewpoint '{}'", camera.name));
        assert!(in_one_line && message.contains(what), "{message}");
    }
}

#[test]
fn a_picture_without_pixels_or_with_absurdly_many_is_refused() {
    // The last two could not even be allocated: getting an error at all means that nothing was.
    let too_many = (MAX_PIXELS as u32 / 1024 + 1, 1024);
    for (width, height) in [(0, 10), (10, 0), (0, 0), too_many, (u32::MAX, 1 << 20), (u32::MAX, u32::MAX)] {
        let mut camera = plain_camera("absurd", DVec3::ZERO, 8, 8);
        (camera.intrinsics.width, camera.intrinsics.height) = (width, height);
        assert_refused(&camera, "cannot be rendered");
    }
}

#[test]
fn a_camera_that_cannot_project_is_refused() {
    for broken in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert_refused(&moved(DVec3::new(0.0, broken, 0.0)), "pose");
        let mut camera = front();
        camera.world_from_camera.matrix3.y_axis.z = broken;
        assert_refused(&camera, "pose");
        let mut camera = front();
        camera.intrinsics.cx = broken;
        assert_refused(&camera, "principal point");
    }
    for focal in [0.0, -50.0, f64::NAN, f64::INFINITY] {
        let mut camera = front();
        camera.intrinsics.fy = focal;
        assert_refused(&camera, "focal");
    }
    let mut flat = front();
    flat.world_from_camera.matrix3.x_axis = DVec3::ZERO;
    assert_refused(&flat, "pose");
}
