use std::sync::Arc;

use glam::{DVec2, DVec3};
use half::f16;

use super::*;
use crate::capture::{CaptureParts, Frame, FrameSource, Values};
use crate::grid::Grid;
use crate::settings::AlignSettings;

/// A parallelogram from a corner along two sides, seen from both of its sides.
#[derive(Clone, Copy)]
struct Sheet {
    corner: DVec3,
    sides: [DVec3; 2],
}

impl Sheet {
    /// Where a ray meets it, in lengths of the ray.
    fn hit(&self, eye: DVec3, ray: DVec3) -> Option<f64> {
        let [first, second] = self.sides;
        let normal = first.cross(second);
        let along = (self.corner - eye).dot(normal) / ray.dot(normal);
        let at = eye + ray * along - self.corner;
        let inside = |side: DVec3| (0.0..=1.0).contains(&(at.dot(side) / side.length_squared()));
        (along > 1e-9 && inside(first) && inside(second)).then_some(along)
    }
}

/// The six sides of a box, or the four upright ones.
fn sides_of_box(low: DVec3, high: DVec3, is_closed: bool) -> Vec<Sheet> {
    let [x, y, z] = [0, 1, 2].map(|axis| DVec3::AXES[axis] * (high - low)[axis]);
    let pairs: &[[DVec3; 3]] =
        if is_closed { &[[x, z, y], [y, z, x], [x, y, z]] } else { &[[x, z, y], [y, z, x]] };
    let both = |[first, second, across]: &[DVec3; 3]| {
        [low, low + *across].map(|corner| Sheet { corner, sides: [*first, *second] })
    };
    pairs.iter().flat_map(both).collect()
}

struct Scene {
    sheets: Vec<Sheet>,
    cameras: Vec<Camera>,
}

const LENS: Intrinsics = Intrinsics::centered(64, 48, 56.0);

impl FrameSource for Scene {
    fn load(&self, camera: usize, _frame: usize) -> Result<Frame> {
        let camera = &self.cameras[camera];
        let depth = |x: usize, y: usize| {
            let ray = LENS.ray_in_camera(DVec2::new(x as f64 + 0.5, y as f64 + 0.5));
            let ray = camera.world_from_camera.matrix3 * ray;
            let hits = self.sheets.iter().filter_map(|sheet| sheet.hit(camera.position_in_world(), ray));
            hits.fold(f64::INFINITY, f64::min)
        };
        let inverse_depth = Grid::from_fn(64, 48, |x, y| (1.0 / depth(x, y)) as f32);
        Ok(Frame {
            color: Grid::filled(64, 48, [f16::from_f32(0.4); 3]),
            inverse_depth,
            normal_in_world: None,
            depth_step_relative: 0.0,
            values: Values::default(),
        })
    }

    fn place(&self, camera: usize, _frame: usize) -> String {
        self.cameras[camera].name.clone()
    }
}

fn capture(sheets: Vec<Sheet>, eyes: &[DVec3], target: DVec3) -> Capture {
    let camera =
        |(nth, eye): (usize, &DVec3)| Camera::look_at(format!("c{nth}"), LENS, *eye, target, DVec3::Z);
    let cameras: Vec<Camera> = eyes.iter().enumerate().map(camera).collect();
    let parts = CaptureParts {
        name: "scene".to_owned(),
        cameras: cameras.clone(),
        frame_numbers: vec![3],
        up_in_world: DVec3::Z,
        has_normals: false,
        antialiased_color: false,
        warnings: Vec::new(),
        source: Arc::new(Scene { sheets, cameras }),
    };
    Capture::new(parts, 1 << 24)
}

/// A box seen from all of its corners.
fn boxed() -> Capture {
    let sheets = sides_of_box(DVec3::splat(-1.0), DVec3::ONE, true);
    let eyes: Vec<DVec3> =
        (0..8).map(|nth| DVec3::from([0, 1, 2].map(|bit| [-3.0, 3.0][nth >> bit & 1]))).collect();
    capture(sheets, &eyes, DVec3::ZERO)
}

/// A shaft on a floor, open above, seen from around and from straight above.
fn shaft() -> Capture {
    let mut sheets = sides_of_box(DVec3::new(-0.5, -0.5, 0.0), DVec3::new(0.5, 0.5, 1.0), false);
    sheets.push(Sheet { corner: DVec3::new(-2.0, -2.0, 0.0), sides: [DVec3::X * 4.0, DVec3::Y * 4.0] });
    let eyes = [[4.0, 0.0, 1.5], [0.0, 4.0, 1.5], [-4.0, 0.0, 1.5], [0.0, -4.0, 1.5], [0.01, 0.0, 4.0]];
    capture(sheets, &eyes.map(DVec3::from), DVec3::new(0.0, 0.0, 0.3))
}

fn settings() -> Settings {
    Settings { align: AlignSettings::OFF, ..Settings::default() }
}

fn asked(cameras: usize, stand: Stand) -> PlaceOptions {
    PlaceOptions { cameras, stand, size: None, rate: None }
}

fn placed(capture: &Capture, options: &PlaceOptions) -> Placement {
    place(capture, options, &settings(), &Job::new()).unwrap()
}

#[test]
fn six_placed_cameras_see_all_sides_of_a_box_and_what_each_adds_falls_and_sums_up() {
    let found = placed(&boxed(), &asked(6, Stand::Between));
    assert_eq!(found.cameras.len(), 6);
    assert!(found.unseen < 0.01, "{found:?}");
    let adds: Vec<f64> = found.cameras.iter().map(|one| one.adds).collect();
    assert!(adds.windows(2).all(|pair| pair[1] <= pair[0]), "{adds:?}");
    let last = found.cameras[5].seen;
    assert!((adds.iter().sum::<f64>() - last).abs() < 1e-9 && last > 0.85, "{adds:?}");
    // By the outward sides of the box: each is faced by a camera.
    for axis in [DVec3::X, DVec3::Y, DVec3::Z].into_iter().flat_map(|axis| [axis, -axis]) {
        let is_faced = found.cameras.iter().any(|one| one.camera.position_in_world().dot(axis) > 1.5);
        assert!(is_faced, "{axis}");
    }
    for one in &found.cameras {
        let lens = one.camera.intrinsics;
        assert_eq!((lens.width, lens.height, lens.cx, lens.cy), (64, 48, 32.0, 24.0));
        let axes = one.camera.world_from_camera.matrix3;
        assert!((axes.determinant() - 1.0).abs() < 1e-9 && axes.x_axis.z.abs() < 1e-6, "upright");
    }
    assert_eq!((found.cameras[0].camera.name.as_str(), found.frame_number), ("placed1", 3));
}

#[test]
fn the_inside_of_a_shaft_is_named_as_unseen_by_cameras_that_may_not_stand_above_it() {
    let is_inside = |point: DVec3| point.x.abs() < 0.4 && point.y.abs() < 0.4 && point.z < 0.05;
    // Beside it, and below its rim.
    let low = Stand::Within([DVec3::new(1.5, -4.0, 0.3), DVec3::new(4.0, 4.0, 0.9)]);
    let from_aside = placed(&shaft(), &asked(6, low));
    let unseen = from_aside.unseen_surfels.iter().filter(|surfel| is_inside(surfel.point_in_world)).count();
    assert!(unseen > 20 && from_aside.unseen > 0.01, "{unseen} {}", from_aside.unseen);
    let from_above = placed(&shaft(), &asked(6, Stand::Between));
    let unseen = from_above.unseen_surfels.iter().filter(|surfel| is_inside(surfel.point_in_world)).count();
    assert!(unseen == 0 && from_above.unseen < 0.05, "{unseen} {}", from_above.unseen);
    assert!(from_above.coarse_cameras_see > 0.9, "{}", from_above.coarse_cameras_see);
}

#[test]
fn a_placement_is_the_same_every_time_whatever_the_number_of_threads() {
    let options = asked(3, Stand::Ring);
    let first = placed(&shaft(), &options);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    assert_eq!(pool.install(|| placed(&shaft(), &options)), first);
    let heights: Vec<f64> = first.cameras.iter().map(|one| one.camera.position_in_world().z).collect();
    assert!(heights.iter().all(|height| (1.4..4.5).contains(height)), "{heights:?}");
}

#[test]
fn cameras_that_may_stand_all_around_too_see_no_less() {
    for capture in [boxed(), shaft()] {
        let [between, around] =
            [Stand::Between, Stand::Ring].map(|stand| placed(&capture, &asked(4, stand)).unseen);
        assert!(around <= between + 0.01, "{around} unseen, {between} from between the cameras alone");
    }
}

#[test]
fn a_surface_counts_by_the_rate_that_is_asked_for() {
    let wall = Sheet { corner: DVec3::new(-9.0, 0.0, -9.0), sides: [DVec3::X * 18.0, DVec3::Z * 18.0] };
    let wall = capture(vec![wall], &[DVec3::new(0.0, -4.0, 0.0)], DVec3::ZERO);
    // From 4 before it, 56 pixels of focal length are 14 a unit; towards the edges of the picture fewer.
    let seen = |rate: f64, size: Option<(u32, u32)>| {
        let options = PlaceOptions { rate: Some(rate), size, ..asked(1, Stand::Between) };
        placed(&wall, &options).cameras[0].seen
    };
    assert!(seen(7.0, None) > 0.99);
    let (half, whole) = (seen(28.0, None), seen(28.0, Some((128, 96))));
    assert!((0.4..0.5).contains(&half) && (whole / half - 2.0).abs() < 0.05, "{half} {whole}");
    // Without a rate, as finely as the coarse picture, whatever the size.
    let coarse = placed(&wall, &PlaceOptions { size: Some((128, 96)), ..asked(1, Stand::Between) });
    assert!(coarse.cameras[0].seen > 0.98 && coarse.coarse_cameras_see > 0.98, "{coarse:?}");
}

#[test]
fn what_cannot_be_placed_is_refused_in_one_line() {
    let refused = |capture: &Capture, options: &PlaceOptions| {
        let said = place(capture, options, &settings(), &Job::new()).unwrap_err().to_string();
        assert!(!said.contains('\n'), "{said}");
        said
    };
    let boxed = boxed();
    assert!(refused(&boxed, &asked(0, Stand::Ring)).contains("no camera"));
    assert!(refused(&boxed, &PlaceOptions { rate: Some(0.0), ..asked(1, Stand::Ring) }).contains("rate"));
    assert!(refused(&boxed, &PlaceOptions { size: Some((0, 9)), ..asked(1, Stand::Ring) }).contains("size"));
    let turned_over = Stand::Within([DVec3::ONE, DVec3::ZERO]);
    assert!(refused(&boxed, &asked(1, turned_over)).contains("box"));
    let empty = capture(Vec::new(), &[DVec3::X], DVec3::ZERO);
    assert!(refused(&empty, &asked(1, Stand::Between)).contains("shows no surface"));
}
