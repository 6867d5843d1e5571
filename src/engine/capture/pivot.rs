//! What cameras look at together.

use glam::{DMat3, DVec2, DVec3};

use super::camera::Camera;

/// The point that cameras look at, in world space: closest to all lines of sight (least squares), or `typical_depth` before the first
/// camera where the lines run side by side or meet behind it. The origin without cameras.
#[must_use]
pub fn pivot(cameras: &[Camera], typical_depth: f64) -> DVec3 {
    let Some(first) = cameras.first() else { return DVec3::ZERO };
    let mut normal_matrix = DMat3::ZERO;
    let mut right_side = DVec3::ZERO;
    for camera in cameras {
        let forward = camera.forward_in_world();
        let across =
            DMat3::IDENTITY - DMat3::from_cols(forward * forward.x, forward * forward.y, forward * forward.z);
        normal_matrix += across;
        right_side += across * camera.position_in_world();
    }
    let center = first.intrinsics;
    let fallback = first.unproject(DVec2::new(center.cx, center.cy), typical_depth);
    // The determinant falls with the square of the angle between lines of sight; a degree apart gives about 1e-4 per camera.
    if normal_matrix.determinant() < 1e-4 * cameras.len() as f64 {
        return fallback;
    }
    let meeting = normal_matrix.inverse() * right_side;
    let in_front = cameras.iter().all(|c| (meeting - c.position_in_world()).dot(c.forward_in_world()) > 0.0);
    if meeting.is_finite() && in_front { meeting } else { fallback }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capture::Intrinsics;

    fn looking_at(eye: DVec3, target: DVec3) -> Camera {
        Camera::look_at("c", Intrinsics::from_horizontal_angle(64, 48, 1.0), eye, target, DVec3::Z)
    }

    #[test]
    fn the_pivot_is_where_lines_of_sight_meet() {
        let target = DVec3::new(1.0, 2.0, 0.5);
        let cameras = [
            looking_at(DVec3::new(5.0, 0.0, 1.0), target),
            looking_at(DVec3::new(0.0, -6.0, 2.0), target),
            looking_at(DVec3::new(-4.0, 3.0, 1.0), target),
        ];
        assert!((pivot(&cameras, 1.0) - target).length() < 1e-9);
    }

    #[test]
    fn a_single_camera_turns_about_what_it_sees() {
        let camera = looking_at(DVec3::ZERO, DVec3::X);
        assert!((pivot(&[camera], 3.0) - DVec3::new(3.0, 0.0, 0.0)).length() < 1e-9);
    }
}
