//! The live view's pose in numbers: position, heading, pitch and roll; its angle of view; and views along an axis.
//!
//! Heading is the compass direction of the line of sight: 0 looks along `north`, and it grows to the right. Pitch grows upward from
//! the horizon. Roll grows as the camera turns clockwise about its line of sight. All in radians.

use std::f64::consts::PI;

use glam::{DAffine3, DMat3, DVec3};

use super::orbit_camera::OrbitCamera;

/// Narrowest and widest horizontal angle of view, radians.
pub(crate) const ANGLES_OF_VIEW: [f64; 2] = [PI / 180.0, 160.0 * PI / 180.0];

/// Lines of sight whose horizontal part is shorter are taken as vertical.
const VERTICAL: f64 = 1e-9;

/// Where a line of sight points, and how the camera is turned about it; radians.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ViewAngles {
    /// From north to the right, −π to π.
    pub heading: f64,
    /// From the horizon upward, −π/2 to π/2.
    pub pitch: f64,
    /// Clockwise about the line of sight, −π to π.
    pub roll: f64,
}

impl OrbitCamera {
    /// East and north on the ground: for an up of z, x and y.
    fn compass(&self) -> [DVec3; 2] {
        let up = self.up_in_world;
        let about = if up.y.abs() < 0.9 { DVec3::Y } else { DVec3::NEG_Z };
        let east = about.cross(up).normalize_or_zero();
        [east, up.cross(east)]
    }

    /// Heading, pitch and roll.
    pub(crate) fn angles(&self) -> ViewAngles {
        let ([east, north], up) = (self.compass(), self.up_in_world);
        let DMat3 { x_axis: right, y_axis: down, z_axis: forward } = self.world_from_camera.matrix3;
        let pitch = forward.dot(up).clamp(-1.0, 1.0).asin();
        let level = forward - up * forward.dot(up);
        // Straight up or down, the heading is where the picture's upper edge points.
        let ahead = if level.length() > VERTICAL { level } else { down * forward.dot(up).signum() };
        let heading = ahead.dot(east).atan2(ahead.dot(north));
        let level_right = east * heading.cos() - north * heading.sin();
        let level_up = level_right.cross(forward);
        ViewAngles { heading, pitch, roll: (-right.dot(level_up)).atan2(right.dot(level_right)) }
    }

    /// Turns about the eye until the angles are these.
    pub(crate) fn set_angles(&mut self, angles: ViewAngles) {
        let ([east, north], up) = (self.compass(), self.up_in_world);
        let ViewAngles { heading, pitch, roll } = angles;
        let pitch = pitch.clamp(-PI / 2.0, PI / 2.0);
        let ahead = north * heading.cos() + east * heading.sin();
        let forward = (ahead * pitch.cos() + up * pitch.sin()).normalize_or_zero();
        let level_right = east * heading.cos() - north * heading.sin();
        let right = level_right * roll.cos() - level_right.cross(forward) * roll.sin();
        let axes = DMat3::from_cols(right, forward.cross(right), forward);
        self.world_from_camera = DAffine3::from_mat3_translation(axes, self.world_from_camera.translation);
    }

    /// Looks at the pivot along a direction in world space, from as far away as now.
    pub(crate) fn look_along(&mut self, direction_in_world: DVec3) {
        let Some(direction) = direction_in_world.try_normalize() else { return };
        let pivot = self.world_from_camera.transform_point3(DVec3::Z * self.pivot_distance);
        let [east, north] = self.compass();
        let pitch = direction.dot(self.up_in_world).clamp(-1.0, 1.0).asin();
        let heading = if pitch.abs() > 1.5 { 0.0 } else { direction.dot(east).atan2(direction.dot(north)) };
        self.set_angles(ViewAngles { heading, pitch, roll: 0.0 });
        self.world_from_camera.translation =
            pivot - self.world_from_camera.matrix3.z_axis * self.pivot_distance;
    }

    /// The horizontal angle of view of the lens, radians.
    pub(crate) fn angle_of_view(&self) -> f64 {
        2.0 * (f64::from(self.lens.width) / (2.0 * self.lens.fx)).atan()
    }

    /// Gives the lens another horizontal angle of view, radians, within [`ANGLES_OF_VIEW`].
    pub(crate) fn set_angle_of_view(&mut self, angle: f64) {
        let [narrowest, widest] = ANGLES_OF_VIEW;
        let focal = f64::from(self.lens.width) / (2.0 * (angle.clamp(narrowest, widest) / 2.0).tan());
        (self.lens.fx, self.lens.fy) = (focal, self.lens.fy * focal / self.lens.fx);
    }

    /// Lets another direction be up, for what is done from now on; the view stays.
    pub(crate) fn set_up(&mut self, up_in_world: DVec3) {
        self.up_in_world = up_in_world;
    }

    /// Turns about the line of sight until the horizon is level.
    pub(crate) fn level(&mut self) {
        self.set_angles(ViewAngles { roll: 0.0, ..self.angles() });
    }

    /// Up in world space, unit length.
    pub(crate) fn up_in_world(&self) -> DVec3 {
        self.up_in_world
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_that_are_set_are_those_that_are_read_and_the_eye_stays() {
        let mut orbit = OrbitCamera::for_tests();
        let eye = orbit.world_from_camera.translation;
        for up in [DVec3::Z, DVec3::Y, DVec3::NEG_Y, DVec3::new(0.6, 0.0, 0.8)] {
            orbit.up_in_world = up;
            for (heading, pitch, roll) in
                [(0.0, 0.0, 0.0), (1.0, 0.4, -0.3), (-2.5, -1.2, 2.0), (3.0, 1.5, 0.1)]
            {
                orbit.set_angles(ViewAngles { heading, pitch, roll });
                let read = orbit.angles();
                for (read, set) in [(read.heading, heading), (read.pitch, pitch), (read.roll, roll)] {
                    assert!((read - set).abs() < 1e-9, "{up}: {read} for {set}");
                }
                assert!((orbit.world_from_camera.matrix3.determinant() - 1.0).abs() < 1e-12);
                assert_eq!(orbit.world_from_camera.translation, eye);
            }
        }
    }

    #[test]
    fn a_view_is_leveled_by_another_up_and_looks_where_it_looked() {
        let mut orbit = OrbitCamera::for_tests();
        let forward = orbit.world_from_camera.matrix3.z_axis;
        orbit.set_up(DVec3::X);
        orbit.level();
        let DMat3 { x_axis: right, y_axis: down, z_axis } = orbit.world_from_camera.matrix3;
        assert!((z_axis - forward).length() < 1e-12);
        assert!(right.dot(DVec3::X).abs() < 1e-12 && down.dot(DVec3::X) < 0.0);
    }

    #[test]
    fn a_level_view_to_the_north_has_the_east_on_its_right() {
        let mut orbit = OrbitCamera::for_tests();
        orbit.set_angles(ViewAngles { heading: 0.0, pitch: 0.0, roll: 0.0 });
        let axes = orbit.world_from_camera.matrix3;
        assert!((axes.z_axis - DVec3::Y).length() < 1e-12 && (axes.x_axis - DVec3::X).length() < 1e-12);
        assert!((axes.y_axis + DVec3::Z).length() < 1e-12, "down");
    }

    #[test]
    fn a_view_along_an_axis_keeps_the_pivot_and_its_distance() {
        for direction in [DVec3::X, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z] {
            let mut orbit = OrbitCamera::for_tests();
            orbit.look_along(direction);
            assert!((orbit.world_from_camera.matrix3.z_axis - direction).length() < 1e-9, "{direction}");
            let pivot = orbit.world_from_camera.transform_point3(DVec3::Z * orbit.pivot_distance);
            assert!(pivot.length() < 1e-9);
            let angles = orbit.angles();
            assert!(angles.roll.abs() < 1e-9 && angles.pitch.is_finite(), "{angles:?}");
        }
    }

    #[test]
    fn the_angle_of_view_keeps_the_shape_of_pixels_and_stays_in_its_range() {
        let mut orbit = OrbitCamera::for_tests();
        orbit.lens.fy = 2.0 * orbit.lens.fx;
        orbit.set_angle_of_view(0.5);
        assert!((orbit.angle_of_view() - 0.5).abs() < 1e-12);
        assert!((orbit.lens.fy - 2.0 * orbit.lens.fx).abs() < 1e-9);
        orbit.set_angle_of_view(0.0);
        assert!((orbit.angle_of_view() - ANGLES_OF_VIEW[0]).abs() < 1e-9);
    }
}
