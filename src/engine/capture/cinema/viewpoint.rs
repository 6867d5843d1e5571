//! Where a picture of a database was taken from.

use glam::{DAffine3, DMat3, DVec3};

/// Degrees from the upper edge of a picture to the lower one where no column says it: as VTK's cameras have it at first.
pub(super) const VIEW_ANGLE: f64 = 30.0;

/// Where a camera stands, as a row says it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DatabaseCamera {
    /// In the world.
    pub position: DVec3,
    /// The point in the middle of its picture.
    pub focal_point: DVec3,
    /// What points up in its picture; need not be at right angles to the line of sight.
    pub up: DVec3,
    /// From the upper edge to the lower one, degrees.
    pub view_angle: f64,
    /// Half of the world units from the upper edge to the lower one, where lines of sight are parallel.
    pub parallel_scale: Option<f64>,
}

impl DatabaseCamera {
    /// World from camera: x right, y down, z forward; `None` where a number is not finite, or the camera looks nowhere or straight up.
    #[must_use]
    pub fn world_from_camera(&self) -> Option<DAffine3> {
        let forward = (self.focal_point - self.position).try_normalize()?;
        let right = forward.cross(self.up).try_normalize()?;
        let down = forward.cross(right);
        let pose = DAffine3::from_mat3_translation(DMat3::from_cols(right, down, forward), self.position);
        (pose.is_finite() && self.position.is_finite()).then_some(pose)
    }

    /// Pixels of focal length of pictures with so many rows, or per world unit where lines of sight are parallel; `None` where the angle or
    /// the scale is none.
    #[must_use]
    pub fn focal_length_px(&self, rows: f64) -> Option<f64> {
        if let Some(scale) = self.parallel_scale {
            return (scale > 0.0).then(|| 0.5 * rows / scale);
        }
        let is_angle = self.view_angle > 0.0 && self.view_angle < 180.0;
        is_angle.then(|| 0.5 * rows / (0.5 * self.view_angle.to_radians()).tan())
    }
}

/// The direction at `phi` degrees about `up`, counted from the world's x (from its y where x is up), and `theta` degrees above.
#[must_use]
pub fn direction(phi: f64, theta: f64, up: DVec3) -> DVec3 {
    let [along, across] = axes(up);
    let (sin_phi, cos_phi) = phi.to_radians().sin_cos();
    let (sin_theta, cos_theta) = theta.to_radians().sin_cos();
    (along * cos_phi + across * sin_phi) * cos_theta + up.normalize_or_zero() * sin_theta
}

/// Where `phi` is 0, and where it is 90 degrees.
pub(super) fn axes(up: DVec3) -> [DVec3; 2] {
    let up = up.normalize_or(DVec3::Z);
    let from = if up.x.abs() < 0.9 { DVec3::X } else { DVec3::Y };
    let along = (from - up * from.dot(up)).normalize_or(DVec3::X);
    [along, up.cross(along)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_direction_turns_about_up_and_rises_above_it() {
        let near = |a: DVec3, b: DVec3| (a - b).length() < 1e-12;
        assert!(near(direction(0.0, 0.0, DVec3::Z), DVec3::X));
        assert!(near(direction(90.0, 0.0, DVec3::Z), DVec3::Y));
        assert!(near(direction(12.0, 90.0, DVec3::Y), DVec3::Y));
        assert!(near(direction(0.0, 0.0, DVec3::X), DVec3::Y));
    }

    #[test]
    fn a_camera_of_a_row_looks_at_its_focal_point_with_its_angle() {
        let camera = DatabaseCamera {
            position: DVec3::new(0.0, -4.0, 0.0),
            focal_point: DVec3::ZERO,
            up: DVec3::new(0.0, 0.3, 1.0),
            view_angle: 90.0,
            parallel_scale: None,
        };
        let pose = camera.world_from_camera().unwrap();
        assert!(
            (pose.matrix3.z_axis - DVec3::Y).length() < 1e-12
                && (pose.matrix3.y_axis + DVec3::Z).length() < 1e-12
        );
        assert!((camera.focal_length_px(480.0).unwrap() - 240.0).abs() < 1e-9);
        assert!(DatabaseCamera { up: DVec3::Y, ..camera }.world_from_camera().is_none(), "it looks along up");
        assert!(DatabaseCamera { view_angle: 0.0, ..camera }.focal_length_px(480.0).is_none());
        let parallel = DatabaseCamera { parallel_scale: Some(3.0), ..camera };
        assert_eq!(parallel.focal_length_px(480.0), Some(80.0), "pixels per world unit");
        assert!(DatabaseCamera { parallel_scale: Some(0.0), ..camera }.focal_length_px(480.0).is_none());
    }
}
