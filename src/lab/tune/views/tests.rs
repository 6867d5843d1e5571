use std::sync::Arc;

use glam::DVec3;
use half::f16;

use super::*;
use overlook_engine::capture::{Camera, CaptureParts, Frame, FrameSource, Intrinsics, TruthView, Values};
use overlook_engine::grid::Grid;

/// Cameras before a wall, each at its own x and distance.
struct Wall(Vec<Camera>);

/// Each sees a stretch of the wall that is 2 wide and 1 high.
const LENS: Intrinsics = Intrinsics::centered(64, 32, 64.0);

impl Wall {
    fn camera(name: &str, x: f64, distance: f64) -> Camera {
        let eye = DVec3::new(x, -distance, 0.0);
        Camera::look_at(name, LENS, eye, eye + DVec3::Y, DVec3::Z)
    }

    fn frame(camera: &Camera) -> Frame {
        let distance = -camera.position_in_world().y;
        let color = |x: usize, y: usize| {
            let center = glam::DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
            let point = camera.unproject(center, distance);
            [point.x, point.z, point.x + point.z].map(|at| f16::from_f64(0.4 + 0.2 * (3.0 * at).sin()))
        };
        Frame {
            color: Grid::from_fn(64, 32, color),
            inverse_depth: Grid::filled(64, 32, (1.0 / distance) as f32),
            normal_in_world: None,
            depth_step_relative: 0.0,
            values: Values::default(),
        }
    }
}

impl FrameSource for Wall {
    fn load(&self, camera: usize, _frame: usize) -> Result<Frame> {
        Ok(Self::frame(&self.0[camera]))
    }

    fn place(&self, camera: usize, _frame: usize) -> String {
        format!("view {camera}")
    }
}

fn capture(views: &[(&str, f64, f64)]) -> Capture {
    let cameras: Vec<Camera> = views.iter().map(|(name, x, far)| Wall::camera(name, *x, *far)).collect();
    let parts = CaptureParts {
        name: "wall".to_owned(),
        cameras: cameras.clone(),
        frame_numbers: vec![0],
        up_in_world: DVec3::Z,
        has_normals: false,
        antialiased_color: false,
        warnings: Vec::new(),
        source: Arc::new(Wall(cameras)),
    };
    Capture::new(parts, 1 << 20)
}

fn chosen(views: &[(&str, f64, f64)], shown_at_least: f64, truth: &Truth) -> ChosenViews {
    let settings = Settings::default();
    choose_views(&capture(views), &settings, shown_at_least, truth, &Job::new()).unwrap()
}

fn names(chosen: &ChosenViews) -> Vec<&str> {
    chosen.names().collect()
}

/// Two stretches of a wall, and three views that lie between and within them.
const WALK: [(&str, f64, f64); 5] = [
    ("between", 1.0, 2.0),
    ("left", 0.0, 2.0),
    ("left again", 0.0, 2.0),
    ("right", 2.0, 2.0),
    ("most of right", 1.75, 2.0),
];

#[test]
fn two_views_that_show_a_wall_are_chosen_of_five_and_their_shares_add_up_to_all() {
    let found = chosen(&WALK, 1.0, &Truth::HoldOut);
    assert_eq!(names(&found), ["left", "right"], "{found:?}");
    let adds: Vec<f64> = found.order.iter().map(|view| view.adds).collect();
    // Both stretches are as wide. What the views hold is spread over 4 of wall.
    assert!(adds.iter().all(|adds| (adds - 0.5).abs() < 0.06), "{adds:?}");
    assert!((adds.iter().sum::<f64>() - 1.0).abs() < 1e-9 && found.order.last().unwrap().shown == 1.0);
    assert_eq!((found.needed, found.of), (2, 5));
    assert_eq!(found.left_out, ["between", "left again", "most of right"]);
    assert_eq!(found.accuracy.iter().map(|count| count.views).collect::<Vec<_>>(), [1, 2]);
    assert!(found.accuracy[1].psnr_filled_db > found.accuracy[0].psnr_filled_db + 3.0, "{found:?}");
    assert_eq!(chosen(&WALK, 1.0, &Truth::HoldOut), found, "the same every time");
    assert_eq!(names(&chosen(&WALK, 0.4, &Truth::HoldOut)).len(), 1, "as many as are asked for");
}

#[test]
fn a_view_from_near_is_needed_and_one_from_afar_is_not_where_both_show_the_same() {
    // Seen from 5, pixels are 2.5 times as wide as from 2: the far view shows more of the wall, but not what the near one saw.
    let views = [("near", 0.0, 2.0), ("far", 0.0, 5.0)];
    let found = chosen(&views, 1.0, &Truth::HoldOut);
    assert_eq!(names(&found), ["near", "far"], "{found:?}");
    assert!(found.accuracy.is_empty() && found.left_out.is_empty(), "nothing is left to measure at");
    // From 3 away pixels are half as wide again, which is sharp enough.
    let found = chosen(&[("near", 0.0, 2.0), ("farther", 0.0, 3.0)], 1.0, &Truth::HoldOut);
    assert_eq!(names(&found), ["farther"]);
}

#[test]
fn accuracy_is_measured_at_views_whose_truth_is_known_and_grows_to_that_of_all_views() {
    let view = Wall::camera("truth", 1.2, 2.2);
    let truth = Wall::frame(&view);
    let load = Arc::new(move || Ok(truth.clone()));
    let truth = Truth::Views(vec![TruthView::new("truth.png".to_owned(), view, 0, Some(load))]);
    let found = chosen(&WALK, 1.0, &truth);
    assert_eq!(names(&found), ["left", "right"]);
    assert_eq!(found.accuracy.iter().map(|count| count.views).collect::<Vec<_>>(), [1, 2, 5]);
    let db: Vec<f64> = found.accuracy.iter().map(|count| count.psnr_filled_db).collect();
    assert!(db[1] > db[0] + 3.0 && db[2] > db[1] - 1.0, "{db:?}");
    let shown: Vec<f64> = found.accuracy.iter().map(|count| count.shown).collect();
    assert!(shown[0] < 0.6 && shown[1..] == [1.0, 1.0], "{shown:?}");
    assert!(found.words[0].starts_with("2 views of 5 show 100.0 %"), "{:?}", found.words);
}
