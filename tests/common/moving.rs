//! The still life with a small ball that passes by.

use std::sync::Arc;

use glam::DVec3;
use overlook_engine::capture::Capture;

use super::scene::{Scene, Sphere, arc};

/// Five frames by four cameras on an arc.
pub(crate) fn moving_capture() -> Capture {
    let mut scene = Scene::still_life();
    scene.spheres.push(Sphere {
        center: Arc::new(|frame| Some(DVec3::new(-1.2 + 0.3 * frame as f64, -0.9, 0.3))),
        radius: 0.3,
        color: [0.6, 0.6, 0.1],
    });
    scene.record(arc(4, 96), 5)
}
