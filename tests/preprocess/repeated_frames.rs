//! Sequences that show pictures more than once, as where an animation is drawn on twos or its ends are held: noise is that of
//! the pictures, however often each is shown.

use std::sync::Arc;

use crate::scene::{Scene, arc};
use glam::DVec3;
use overlook_engine::capture::{Capture, CaptureParts, Frame, FrameSource};
use overlook_engine::error::Result;
use overlook_engine::job::Job;
use overlook_engine::preprocess::diagnostics::Report;
use overlook_engine::preprocess::preprocess;
use overlook_engine::settings::{Settings, SpanLevels};

/// A recording whose pictures are shown in some order.
struct Shown {
    recording: Capture,
    order: Vec<usize>,
}

impl FrameSource for Shown {
    fn load(&self, camera: usize, frame: usize) -> Result<Frame> {
        self.recording.frame(camera, self.order[frame]).map(Arc::unwrap_or_clone)
    }

    fn place(&self, camera: usize, frame: usize) -> String {
        self.recording.place(camera, self.order[frame])
    }
}

const PICTURES: usize = 12;

fn report(scene: &Scene, order: &[usize], levels: SpanLevels) -> Report {
    let recording = scene.record(arc(2, 64), PICTURES);
    let capture = Capture::new(
        CaptureParts {
            name: "shown".to_owned(),
            cameras: recording.cameras.clone(),
            frame_numbers: (0..order.len() as i64).collect(),
            up_in_world: DVec3::Z,
            has_normals: true,
            antialiased_color: false,
            warnings: Vec::new(),
            source: Arc::new(Shown { recording, order: order.to_vec() }),
        },
        64 << 20,
    );
    let mut settings = Settings::default();
    settings.spans.levels = levels;
    preprocess(&capture, &settings, &Job::new()).unwrap().report
}

#[test]
fn noise_is_that_of_the_pictures_however_often_each_is_shown() {
    let scene = Scene { color_noise: 0.02, depth_noise: 0.002, ..Scene::still_life() };
    let once: Vec<usize> = (0..PICTURES).collect();
    let held = |count: usize| {
        let (first, last) = (vec![0; count], vec![PICTURES - 1; count]);
        [first, once.clone(), last].concat()
    };
    let on_twos: Vec<usize> = (0..2 * PICTURES).map(|frame| frame / 2).collect();
    for levels in [SpanLevels::Tree, SpanLevels::Paper] {
        let expected = report(&scene, &once, levels);
        for order in [held(1), held(40), on_twos.clone()] {
            let found = report(&scene, &order, levels);
            for (found, expected) in found.cameras.iter().zip(&expected.cameras) {
                let ratio = found.depth_noise_relative / expected.depth_noise_relative;
                assert!((0.8..1.25).contains(&ratio), "depth {ratio}: {order:?}");
                let ratio = found.color_noise_steps / expected.color_noise_steps;
                assert!((0.8..1.25).contains(&ratio), "color {ratio}: {order:?}");
                let moving = 4096 - found.background_pixels;
                assert!(moving < 41, "{moving} pixels move: {order:?}");
            }
            let (found, expected) = (found.samples_kept as f64, expected.samples_kept as f64);
            assert!(found < 1.1 * expected, "{found} against {expected}: {order:?}");
        }
    }
}

#[test]
fn a_picture_that_never_changes_has_no_noise() {
    let scene = Scene { color_noise: 0.02, depth_noise: 0.002, ..Scene::still_life() };
    let still = report(&scene, &[3; 20], SpanLevels::Tree);
    for camera in &still.cameras {
        assert_eq!((camera.color_noise_steps, camera.depth_noise_relative), (0.0, 0.0));
        assert_eq!(camera.background_pixels, 4096);
    }
}
