//! A static camera: a lens with a pose.

use glam::{DAffine3, DVec2, DVec3};
use serde::{Deserialize, Serialize};

pub(super) use super::intrinsics::{Intrinsics, Projection};
use crate::error::{Error, Result};

/// Largest width and height of a picture that is believed, wherever it comes from.
pub(super) const MAX_SIDE: usize = 32_768;
/// Largest number of pixels of a picture that is believed: 16 k × 16 k.
pub(super) const MAX_PIXELS: usize = 1 << 28;

/// Whether a picture may have this many columns and rows.
pub(crate) fn is_believable_size(width: usize, height: usize) -> bool {
    let sides = 1..=MAX_SIDE;
    sides.contains(&width) && sides.contains(&height) && width * height <= MAX_PIXELS
}

/// The error of a picture that has another size than its camera.
pub(super) fn wrong_size(place: &str, found: (usize, usize), expected: (usize, usize)) -> Error {
    let ((width, height), (columns, rows)) = (found, expected);
    let what = format!(
        "the picture is {width}×{height} but its camera is {columns}×{rows}; render it at the camera's size, or correct the camera's (w and h in a manifest)"
    );
    Error::invalid(place, what)
}

/// A named static camera: x right, y down, z forward; rigid pose in the world, in the capture's unit (meters).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Camera {
    /// Name, unique in its capture.
    pub name: String,
    /// Image size and projection.
    pub intrinsics: Intrinsics,
    /// Camera space to world space: a rotation and a translation, no scale.
    pub world_from_camera: DAffine3,
}

impl Camera {
    /// A camera at `eye` that looks at `target`, with `up` pointing up in the picture; all in world space.
    ///
    /// Where `up` runs along the line of sight, any perpendicular direction serves instead.
    #[must_use]
    pub fn look_at(
        name: impl Into<String>,
        intrinsics: Intrinsics,
        eye: DVec3,
        target: DVec3,
        up: DVec3,
    ) -> Self {
        let forward = (target - eye).try_normalize().unwrap_or(DVec3::Z);
        let right = forward.cross(up).try_normalize().unwrap_or_else(|| forward.any_orthonormal_vector());
        let down = forward.cross(right);
        Self {
            name: name.into(),
            intrinsics,
            world_from_camera: DAffine3::from_mat3_translation(
                glam::DMat3::from_cols(right, down, forward),
                eye,
            ),
        }
    }

    /// World space to camera space.
    #[must_use]
    pub fn camera_from_world(&self) -> DAffine3 {
        self.world_from_camera.inverse()
    }

    /// The center of projection, in world space; of an orthographic camera the point of its picture plane at the principal point.
    #[must_use]
    pub fn position_in_world(&self) -> DVec3 {
        self.world_from_camera.translation
    }

    /// The look vector (the paper's `cD`): unit length, in world space.
    #[must_use]
    pub fn forward_in_world(&self) -> DVec3 {
        self.world_from_camera.matrix3.z_axis
    }

    /// The world point at image position `pixel` and planar depth `depth_z`.
    #[must_use]
    pub fn unproject(&self, pixel: DVec2, depth_z: f64) -> DVec3 {
        self.world_from_camera.transform_point3(self.intrinsics.point_in_camera(pixel, depth_z))
    }

    /// Where the line of sight through image position `pixel` begins, in world space: the position, or of an orthographic camera the
    /// pixel's own place in its picture plane.
    #[must_use]
    pub fn line_of_sight_start(&self, pixel: DVec2) -> DVec3 {
        if self.intrinsics.is_orthographic() { self.unproject(pixel, 0.0) } else { self.position_in_world() }
    }

    /// Image position and planar depth of a world point, or `None` where it is not in front of the camera.
    #[must_use]
    pub fn project(&self, point_in_world: DVec3) -> Option<(DVec2, f64)> {
        let point_in_camera = self.camera_from_world().transform_point3(point_in_world);
        Some((self.intrinsics.project(point_in_camera)?, point_in_camera.z))
    }
}

/// How far the components of a direction may be off by rounding in double precision.
const ROUNDING: f64 = 1e-12;

/// A direction in a camera's space, along its z axis where it is but for rounding.
pub(crate) fn along_axis(direction: DVec3) -> DVec3 {
    if direction.truncate().length() < ROUNDING { DVec3::new(0.0, 0.0, direction.z) } else { direction }
}

/// Whether the lines of sight of any camera are parallel.
pub(crate) fn any_orthographic<'a>(cameras: impl IntoIterator<Item = &'a Camera>) -> bool {
    cameras.into_iter().any(|camera| camera.intrinsics.is_orthographic())
}

/// Refuses orthographic cameras: `what` names the feature that cannot have them, and what to do instead.
///
/// # Errors
/// `Unsupported` where one of the cameras is orthographic.
pub fn in_perspective(cameras: &[Camera], place: &str, what: &str) -> Result<()> {
    match cameras.iter().find(|camera| camera.intrinsics.is_orthographic()) {
        Some(camera) => {
            Err(Error::unsupported(place, format!("camera '{}' is orthographic, and {what}", camera.name)))
        }
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::{Camera, Intrinsics, Projection};
    use crate::capture::PixelSide;
    use glam::{DVec2, DVec3};
    use proptest::prelude::*;

    fn any_camera() -> impl Strategy<Value = Camera> {
        (
            prop::array::uniform3(-10.0..10.0_f64),
            prop::array::uniform3(-10.0..10.0_f64),
            0.2..2.5_f64,
            1..2000_u32,
            1..2000_u32,
        )
            .prop_map(|(eye, target, angle, width, height)| {
                Camera::look_at(
                    "c",
                    Intrinsics::from_horizontal_angle(width, height, angle),
                    DVec3::from(eye),
                    DVec3::from(target),
                    DVec3::Z,
                )
            })
    }

    #[test]
    fn an_orthographic_camera_shows_lengths_and_footprints_alike_at_any_depth() {
        let lens = Intrinsics { cy: 10.5, ..Intrinsics::orthographic(200, 100, 4.0) };
        let camera =
            Camera::look_at("o", lens, DVec3::new(1.0, -5.0, 2.0), DVec3::new(0.0, 1.0, 0.0), DVec3::Z);
        for depth in [0.01, 3.0, 4000.0] {
            let pixel = DVec2::new(17.5, 80.25);
            let point = camera.unproject(pixel, depth);
            let (found, z) = camera.project(point).unwrap();
            assert!((found - pixel).length() < 1e-9 && (z - depth).abs() < 1e-9);
            assert_eq!(lens.pixel_width(depth, PixelSide::Longer), 0.02);
            let beside = camera.unproject(pixel + DVec2::X * 50.0, depth);
            assert!((beside.distance(point) - 1.0).abs() < 1e-9);
        }
        let behind = camera.position_in_world() - camera.forward_in_world();
        assert_eq!(camera.project(behind), None);
    }

    #[test]
    fn a_perspective_lens_is_written_as_before_there_were_others() {
        let lens = Intrinsics::from_horizontal_angle(4, 3, 1.0);
        let text = serde_json::to_string(&lens).unwrap();
        assert!(!text.contains("projection"), "{text}");
        assert_eq!(serde_json::from_str::<Intrinsics>(&text).unwrap(), lens);
        let lens = Intrinsics { projection: Projection::Orthographic, ..lens };
        let text = serde_json::to_string(&lens).unwrap();
        assert_eq!(serde_json::from_str::<Intrinsics>(&text).unwrap(), lens);
    }

    proptest! {
        #[test]
        fn projecting_undoes_unprojecting(camera in any_camera(), u in 0.0..2000.0, v in 0.0..2000.0, z in 0.01..1e4) {
            let (pixel, depth) = camera.project(camera.unproject(DVec2::new(u, v), z)).unwrap();
            prop_assert!((pixel - DVec2::new(u, v)).length() < 1e-5);
            prop_assert!((depth - z).abs() < 1e-8 * z.max(1.0));
        }

        #[test]
        fn a_camera_is_a_right_handed_rigid_frame(camera in any_camera()) {
            let m = camera.world_from_camera.matrix3;
            prop_assert!((m.determinant() - 1.0).abs() < 1e-9);
            prop_assert!((m.x_axis.cross(m.y_axis) - m.z_axis).length() < 1e-9);
        }
    }

    #[test]
    fn the_papers_unprojection_is_the_intrinsics_form() {
        // w = h = 1, aspect a = 1, focal length fl on the normalized plane, rw pixels, 1-based index u.
        let (fl, rw, d) = (1.2_f64, 640.0_f64, 3.5_f64);
        let u = 17.0_f64;
        let paper_x = (((u - 1.0) / rw - 0.5) / fl) * d;
        let intrinsics =
            Intrinsics { fx: fl * rw, fy: fl * rw, ..Intrinsics::from_horizontal_angle(640, 640, 1.0) };
        // The paper's 1-based index marks the left edge of the pixel, hence 0-based index 16 without its half.
        let ours = intrinsics.ray_in_camera(DVec2::new(16.0, 0.0)).x * d;
        assert!((paper_x - ours).abs() < 1e-12);
    }

    #[test]
    fn up_in_the_world_is_up_in_the_picture() {
        let camera = Camera::look_at(
            "c",
            Intrinsics::from_horizontal_angle(100, 100, 1.0),
            DVec3::new(0.0, -5.0, 0.0),
            DVec3::ZERO,
            DVec3::Z,
        );
        let (above, _) = camera.project(DVec3::new(0.0, 0.0, 1.0)).unwrap();
        let (right, _) = camera.project(DVec3::new(1.0, 0.0, 0.0)).unwrap();
        assert!(above.y < 50.0 && right.x > 50.0);
    }
}
