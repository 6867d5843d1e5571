//! Where a camera may look from a place.

use glam::{DAffine3, DMat3, DVec3};

use crate::capture::{Camera, Intrinsics};

/// Directions that are tried from each place, evenly over the sphere.
const DIRECTIONS: usize = 24;

/// Targets of coarse cameras that are tried from each place, at most.
const TARGETS: usize = 12;

/// A turn by the golden angle, radians.
const GOLDEN_ANGLE: f64 = 2.399_963_229_728_653;

/// What cameras look at: what the coarse cameras look at together, and what some of them do, as far off.
pub(super) fn targets(cameras: &[Camera], middle: DVec3) -> Vec<DVec3> {
    let step = cameras.len().div_ceil(TARGETS).max(1);
    let of_camera = |camera: &Camera| {
        let eye = camera.position_in_world();
        eye + camera.forward_in_world() * eye.distance(middle)
    };
    std::iter::once(middle).chain(cameras.iter().step_by(step).map(of_camera)).collect()
}

/// Cameras at a place that look at targets, and into all directions.
pub(super) fn poses(eye: DVec3, targets: &[DVec3], lens: Intrinsics, up: DVec3) -> Vec<Camera> {
    let around = (0..DIRECTIONS).map(|nth| {
        let height = 1.0 - (2 * nth + 1) as f64 / DIRECTIONS as f64;
        let (sin, cos) = (nth as f64 * GOLDEN_ANGLE).sin_cos();
        let across = (1.0 - height * height).sqrt();
        eye + DVec3::new(across * cos, across * sin, height)
    });
    let targets = targets.iter().copied().filter(|target| target.distance(eye) > 0.0);
    targets.chain(around).map(|target| Camera::look_at("", lens, eye, target, up)).collect()
}

/// A camera turned to its left or right about an axis, and up or down, in radians.
pub(super) fn turned(camera: &Camera, up: DVec3, [sideways, upward]: [f64; 2]) -> Camera {
    let DAffine3 { matrix3, translation } = camera.world_from_camera;
    let matrix3 = DMat3::from_axis_angle(up, sideways) * matrix3 * DMat3::from_rotation_x(upward);
    Camera { world_from_camera: DAffine3 { matrix3, translation }, ..camera.clone() }
}
