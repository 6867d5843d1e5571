//! Colors that depend on the view are found, and nothing else is taken for it.

use std::sync::Arc;

use crate::scene::{Scene, arc};
use glam::{DVec2, DVec3};
use half::f16;
use overlook_engine::capture::{Camera, Capture, CaptureParts, Frame, FrameSource};
use overlook_engine::color::srgb_from_linear;
use overlook_engine::error::Result;
use overlook_engine::grid::Grid;
use overlook_engine::job::Job;
use overlook_engine::preprocess::inspect::VISIBLE_STEPS;
use overlook_engine::preprocess::{inspect_frame, scan};
use overlook_engine::settings::Settings;

const SIDE: usize = 96;

/// The middle one of five cameras.
const CAMERA: usize = 2;

fn view_dependence(capture: &Capture) -> Grid<f32> {
    let settings = Settings::default();
    let scan = scan(capture, &settings, &Job::new()).unwrap();
    inspect_frame(capture, Some(&scan), &settings, 0, &Job::new()).unwrap().view_dependence(CAMERA)
}

/// The pixels that other cameras can judge: the share whose colors differ visibly, and their number.
fn visible(found: &Grid<f32>) -> (f64, usize) {
    let known: Vec<f32> = found.as_slice().iter().copied().filter(|steps| !steps.is_nan()).collect();
    let visible = known.iter().filter(|steps| **steps >= VISIBLE_STEPS).count();
    (visible as f64 / known.len().max(1) as f64, known.len())
}

#[test]
fn surfaces_that_look_the_same_from_everywhere_do_not_depend_on_the_view() {
    let capture = Scene { color_rays: 3, ..Scene::still_life() }.record(arc(5, SIDE as u32), 1);
    let found = view_dependence(&capture);
    let (share, known) = visible(&found);
    assert!(known > SIDE * SIDE / 2, "{known}");
    assert!(share < 0.002, "{share}");
    let depths = capture.frame(CAMERA, 0).unwrap();
    for (steps, w) in found.as_slice().iter().zip(depths.inverse_depth.as_slice()) {
        assert!(*w >= 0.0 || steps.is_nan(), "nothing is known where there is no depth");
    }
}

/// A scene whose ground shines in a disc for one camera alone, as a mirror does.
struct Mirror {
    scene: Scene,
    cameras: Vec<Camera>,
}

/// Center of the disc, and its radius.
const DISC: (DVec3, f64) = (DVec3::new(-0.9, -0.4, 0.0), 0.5);

/// Added to linear color.
const SHINE: f32 = 0.1;

impl Mirror {
    /// Whether a pixel shows the disc, well within its rim or with all of it.
    fn shows_disc(&self, camera: usize, frame: &Frame, pixel: usize, radius: f64) -> bool {
        let (x, y) = (pixel % SIDE, pixel / SIDE);
        let w = f64::from(frame.inverse_depth[(x, y)]);
        let at = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
        let point = self.cameras[camera].unproject(at, 1.0 / w);
        w > 0.0 && point.z.abs() < 1e-3 && point.distance(DISC.0) < radius
    }
}

impl FrameSource for Mirror {
    fn load(&self, camera: usize, frame: usize) -> Result<Frame> {
        let mut seen = self.scene.trace(&self.cameras[camera], frame, camera);
        if camera == CAMERA {
            let lit: Vec<bool> =
                (0..SIDE * SIDE).map(|pixel| self.shows_disc(camera, &seen, pixel, DISC.1)).collect();
            for (color, _) in seen.color.as_mut_slice().iter_mut().zip(lit).filter(|(_, lit)| *lit) {
                *color = color.map(|channel| f16::from_f32(channel.to_f32() + SHINE));
            }
        }
        Ok(seen)
    }

    fn place(&self, camera: usize, frame: usize) -> String {
        format!("mirror, camera {camera}, frame {frame}")
    }
}

#[test]
fn shine_is_found_where_it_is_and_by_how_much_it_differs() {
    let scene = Scene { color_rays: 3, ..Scene::still_life() };
    let cameras = arc(5, SIDE as u32);
    let mirror = Arc::new(Mirror { scene, cameras: cameras.clone() });
    let parts = CaptureParts {
        name: "mirror".to_owned(),
        frame_numbers: vec![0],
        up_in_world: DVec3::Z,
        has_normals: true,
        antialiased_color: true,
        warnings: Vec::new(),
        source: mirror.clone(),
        cameras,
    };
    let capture = Capture::new(parts, 256 << 20);
    let found = view_dependence(&capture);
    let frame = capture.frame(CAMERA, 0).unwrap();
    let (mut lit, mut visible) = (0, 0);
    for (pixel, steps) in found.as_slice().iter().enumerate().filter(|(_, steps)| !steps.is_nan()) {
        if mirror.shows_disc(CAMERA, &frame, pixel, 0.8 * DISC.1) {
            let color = frame.color.as_slice()[pixel].map(f16::to_f32);
            let added = color.map(|c| 255.0 * (srgb_from_linear(c) - srgb_from_linear(c - SHINE)));
            let most = added.into_iter().fold(0.0, f32::max);
            lit += 1;
            visible += usize::from(*steps >= VISIBLE_STEPS);
            assert!(*steps <= most + 0.5, "pixel {pixel}: {steps} of {most}");
            assert!(*steps >= 0.5 * most, "pixel {pixel}: {steps} of {most}");
        }
    }
    assert!(lit > 50, "{lit}");
    assert_eq!(visible, lit);
}

#[test]
fn noise_of_color_is_not_taken_for_view_dependence() {
    let scene = Scene { color_noise: 0.04, color_rays: 3, ..Scene::still_life() };
    let (share, known) = visible(&view_dependence(&scene.record(arc(5, SIDE as u32), 6)));
    assert!(known > SIDE * SIDE / 2, "{known}");
    assert!(share < 0.01, "{share}");
}
