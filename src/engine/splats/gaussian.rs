//! A sample as a flat Gaussian on its surface.
//!
//! Source: Zwicker et al., *Surface Splatting*, SIGGRAPH 2001: a sample's kernel lies in its tangent plane. What differs: its two radii
//! are those of the pixel on the plane, which the plane's normal gives exactly. A grazing pixel is an ellipse along the slant.

use glam::{DMat3, DQuat, DVec3, Quat, Vec3};

use super::space::Space;
use crate::capture::Camera;
use crate::color::srgb_from_linear;
use crate::samples::PlacedSample;

/// Standard deviation of a Gaussian along an axis, as a share of the width of its pixel on the surface. Narrower ones let what is behind
/// show through, wider ones cover their neighbors. Measured with backs behind them at three true pictures of a room of nine cameras, by
/// the published formula with and without its anti-aliasing factor: 0.32 gives 29.7 and 31.7 dB, 0.4 30.5 and 31.2, 0.45 30.2 and 30.5.
const SIGMA_SHARE: f64 = 0.4;

/// Without backs they are wider by this factor: half of a pixel. Measured so at three true pictures of a ray traced scene, drawn by the
/// published formula four times as fine and averaged: 0.4 gives 25.2 dB, 0.5 25.8 and 0.6 25.0, where our surfels give 25.9.
pub(super) const WIDER_ALONE: f32 = 1.25;

/// Thickness of a Gaussian, as a share of its smaller radius.
const FLATNESS: f64 = 0.01;

/// The longer radius is at most this many times the smaller one: steeper normals are too inexact.
const LONGEST: f64 = 10.0;

/// Opacity of a sample that is seen.
const OPACITY: f32 = 0.99;

/// Opacity of a doubtful sample, which no other camera confirms.
const DOUBTFUL_OPACITY: f32 = 0.5;

/// A splat in the axes of a format.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Gaussian {
    /// World units from the origin of the file.
    pub(super) center: Vec3,
    /// From the axes of the Gaussian to those of the file; the third axis is the normal.
    pub(super) rotation: Quat,
    /// Standard deviations along its axes, world units, above 0; the first is the longest.
    pub(super) radii: Vec3,
    /// Linear Rec.709, 0 to 1.
    pub(super) color: [f32; 3],
    /// 0 to 1.
    pub(super) opacity: f32,
}

/// What of a sample is not its place.
pub(super) struct Look {
    /// World space, unit length; zero where unknown: then the surface faces the camera.
    pub(super) normal_in_world: Vec3,
    /// Linear Rec.709; what a display cannot show is clipped.
    pub(super) color: [f32; 3],
    pub(super) is_doubtful: bool,
}

/// An ellipse in space.
struct Ellipse {
    /// Unit, orthogonal, right-handed: the longer radius, the shorter one, the normal.
    axes: DMat3,
    radii: [f64; 2],
}

impl Gaussian {
    /// The splat of a sample that `camera` saw.
    pub(super) fn of_sample(placed: &PlacedSample, camera: &Camera, look: &Look, space: &Space) -> Self {
        let world_from_camera = camera.world_from_camera.matrix3;
        let ray = placed.ray_in_camera;
        let known = world_from_camera.transpose() * look.normal_in_world.as_dvec3();
        let normal = (if known == DVec3::ZERO { -ray } else { known }).normalize_or_zero();
        // The side that was seen.
        let normal = if normal.dot(ray) > 0.0 { -normal } else { normal };
        let sides = pixel_sides(ray, placed.depth, normal, camera);
        let mut ellipse = ellipse(sides, normal);
        ellipse.axes = world_from_camera * ellipse.axes;
        let opacity = if look.is_doubtful { DOUBTFUL_OPACITY } else { OPACITY };
        Self::new(placed.point_in_world, &ellipse, look.color, opacity, space)
    }

    /// A round one of some radius that faces along a normal of length 1, all in world space.
    pub(super) fn facing(center: DVec3, normal: DVec3, radius: f64, color: [f32; 3], space: &Space) -> Self {
        let (first, second) = normal.any_orthonormal_pair();
        let ellipse = Ellipse { axes: DMat3::from_cols(first, second, normal), radii: [radius; 2] };
        Self::new(center, &ellipse, color, OPACITY, space)
    }

    fn new(center: DVec3, ellipse: &Ellipse, color: [f32; 3], opacity: f32, space: &Space) -> Self {
        let [longer, shorter] = ellipse.radii;
        let rotation = DQuat::from_mat3(&(space.turn * ellipse.axes)).normalize();
        let rotation = if rotation.w < 0.0 { -rotation } else { rotation };
        let radii = DVec3::new(longer, shorter, FLATNESS * shorter).as_vec3();
        Self {
            center: space.place(center),
            rotation: rotation.as_quat(),
            // Logarithms are taken of them.
            radii: radii.max(Vec3::splat(f32::MIN_POSITIVE)),
            color: color.map(|channel| channel.clamp(0.0, 1.0)),
            opacity,
        }
    }
}

/// The two sides of a pixel's parallelogram on the plane through its sample, in camera space: the plane `n·X = d` meets the ray `r` at
/// `d / (n·r)`, whose derivatives these are.
fn pixel_sides(ray: DVec3, depth: f64, normal: DVec3, camera: &Camera) -> [DVec3; 2] {
    let lens = &camera.intrinsics;
    // Edge on, the plane says nothing.
    let facing = normal.dot(ray).min(-ray.length() / (4.0 * LONGEST));
    let scale = lens.spread_at(depth);
    [(DVec3::X, normal.x, lens.fx), (DVec3::Y, normal.y, lens.fy)]
        .map(|(axis, slope, focal)| (axis - ray * (slope / facing)) * (scale / focal))
}

/// The ellipse whose covariance is that of a parallelogram's sides, in the plane across a normal.
fn ellipse(sides: [DVec3; 2], normal: DVec3) -> Ellipse {
    let (first, second) = normal.any_orthonormal_pair();
    let [mut xx, mut xy, mut yy] = [0.0; 3];
    for side in sides {
        let (x, y) = (side.dot(first), side.dot(second));
        (xx, xy, yy) = (xx + x * x, xy + x * y, yy + y * y);
    }
    let (mean, half) = (0.5 * (xx + yy), 0.5 * (xx - yy));
    let apart = half.hypot(xy);
    let (sin, cos) = (0.5 * xy.atan2(half)).sin_cos();
    let longer = first * cos + second * sin;
    let shorter_radius = (mean - apart).max(0.0).sqrt();
    let longer_radius = (mean + apart).sqrt().min(LONGEST * shorter_radius);
    Ellipse {
        axes: DMat3::from_cols(longer, normal.cross(longer), normal),
        radii: [SIGMA_SHARE * longer_radius, SIGMA_SHARE * shorter_radius],
    }
}

/// The spherical harmonic of degree 0, the same in all directions: ½ √(1/π).
const DEGREE_0: f32 = 0.282_094_8;

/// The coefficient of degree 0 that shows a linear color on a display: splats are blended as sRGB-encoded values.
pub(super) fn coefficients(linear: [f32; 3]) -> [f32; 3] {
    linear.map(|channel| (srgb_from_linear(channel) - 0.5) / DEGREE_0)
}

/// The sRGB-encoded byte of a linear channel's coefficient, as SPZ packs it: its unit is 0.15 of a coefficient.
pub(super) fn packed(linear: [f32; 3]) -> [u8; 3] {
    coefficients(linear).map(|coefficient| byte(coefficient * 0.15 * 255.0 + 127.5))
}

/// The nearest byte.
pub(super) fn byte(value: f32) -> u8 {
    (value + 0.5).clamp(0.0, 255.0) as u8
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capture::Intrinsics;
    use crate::samples::Sample;
    use crate::splats::space::Axes;
    use glam::{DAffine3, DVec2};

    fn camera() -> Camera {
        let intrinsics = Intrinsics::centered(200, 100, 100.0);
        let turned = DQuat::from_euler(glam::EulerRot::XYZ, 0.3, -0.8, 1.1);
        let world_from_camera = DAffine3::from_rotation_translation(turned, DVec3::new(3.0, -1.0, 0.5));
        Camera { name: "c".into(), intrinsics, world_from_camera }
    }

    /// The Gaussian of a pixel on a plane with a normal in camera space.
    fn gaussian(pixel: DVec2, depth: f64, normal_in_camera: DVec3) -> Gaussian {
        let camera = camera();
        let ray_in_camera = camera.intrinsics.ray_in_camera(pixel);
        let point_in_world = camera.world_from_camera.transform_point3(ray_in_camera * depth);
        let sample = Sample { x: 0, y: 0, index: 0 };
        let placed = PlacedSample { sample, ray_in_camera, depth, point_in_world };
        let normal_in_world = (camera.world_from_camera.matrix3 * normal_in_camera).as_vec3();
        let look = Look { normal_in_world, color: [0.5, 2.0, -1.0], is_doubtful: false };
        Gaussian::of_sample(&placed, &camera, &look, &Space::upright(Axes::BackUp))
    }

    fn in_camera(axis: Vec3) -> DVec3 {
        let space = Space::upright(Axes::BackUp);
        camera().world_from_camera.matrix3.transpose() * (space.turn.transpose() * axis.as_dvec3())
    }

    #[test]
    fn a_surface_that_faces_the_camera_gets_a_round_flat_splat_as_wide_as_its_pixel() {
        let splat = gaussian(DVec2::new(100.0, 50.0), 4.0, DVec3::NEG_Z);
        let width = (4.0 / 100.0 * SIGMA_SHARE) as f32;
        assert!((splat.radii - Vec3::new(width, width, width * FLATNESS as f32)).length() < 1e-7);
        assert!((in_camera(splat.rotation * Vec3::Z) - DVec3::NEG_Z).length() < 1e-6);
        assert_eq!((splat.color, splat.opacity), ([0.5, 1.0, 0.0], 0.99));
    }

    #[test]
    fn a_slanted_surface_gets_an_ellipse_along_its_slant_longer_by_one_over_the_cosine() {
        for (degrees, turned) in [(30.0_f64, 0.0_f64), (60.0, 0.7), (80.0, 2.0)] {
            let (slant, around) = (degrees.to_radians(), DVec3::new(turned.cos(), turned.sin(), 0.0));
            let normal = around * slant.sin() - DVec3::Z * slant.cos();
            let splat = gaussian(DVec2::new(100.0, 50.0), 2.0, normal);
            let width = 2.0 / 100.0 * SIGMA_SHARE;
            let expected = [width / slant.cos(), width];
            assert!((f64::from(splat.radii.x) - expected[0]).abs() < 1e-3 * expected[0], "{degrees}");
            assert!((f64::from(splat.radii.y) - expected[1]).abs() < 1e-3 * expected[1], "{degrees}");
            assert!((in_camera(splat.rotation * Vec3::Z) - normal).length() < 1e-6);
            let along = (around * slant.cos() + DVec3::Z * slant.sin()).normalize_or_zero();
            assert!(in_camera(splat.rotation * Vec3::X).dot(along).abs() > 0.9999, "{degrees}");
        }
    }

    #[test]
    fn off_the_axis_the_splat_covers_as_much_of_its_surface_as_the_pixel() {
        let (pixel, depth) = (DVec2::new(180.0, 10.0), 3.0);
        let normal = DVec3::new(-0.3, 0.4, -0.8).normalize_or_zero();
        let splat = gaussian(pixel, depth, normal);
        let lens = camera().intrinsics;
        let corner = |dx: f64, dy: f64| {
            let ray = lens.ray_in_camera(pixel + DVec2::new(dx, dy));
            let at = lens.ray_in_camera(pixel) * depth;
            ray * (normal.dot(at) / normal.dot(ray))
        };
        let across = corner(0.5, 0.0) - corner(-0.5, 0.0);
        let down = corner(0.0, 0.5) - corner(0.0, -0.5);
        let area = across.cross(down).length() * SIGMA_SHARE * SIGMA_SHARE;
        let found = f64::from(splat.radii.x * splat.radii.y);
        assert!((found / area - 1.0).abs() < 1e-3, "{found} {area}");
    }

    #[test]
    fn grazing_and_unknown_surfaces_stay_bounded_and_the_seen_side_is_out() {
        let edge_on = gaussian(DVec2::new(100.0, 50.0), 1.0, DVec3::X);
        assert!(edge_on.radii.is_finite() && edge_on.radii.x <= LONGEST as f32 * edge_on.radii.y * 1.0001);
        let unknown = gaussian(DVec2::new(150.0, 50.0), 1.0, DVec3::ZERO);
        assert!(in_camera(unknown.rotation * Vec3::Z).dot(DVec3::new(0.5, 0.0, 1.0)) < 0.0);
        let turned = gaussian(DVec2::new(100.0, 50.0), 1.0, DVec3::Z);
        assert!((in_camera(turned.rotation * Vec3::Z) - DVec3::NEG_Z).length() < 1e-6);
        // Nothing is lost where a surface touches the lens.
        assert!(gaussian(DVec2::new(100.0, 50.0), 1e-44, DVec3::NEG_Z).radii.min_element() > 0.0);
    }

    #[test]
    fn black_middle_gray_and_white_have_the_coefficients_that_viewers_turn_back() {
        let middle = crate::color::linear_from_srgb(0.5);
        let [black, gray, white] = coefficients([0.0, middle, 1.0]);
        assert!((black + 1.772_454).abs() < 1e-5 && gray.abs() < 1e-5 && (white - 1.772_454).abs() < 1e-5);
        assert_eq!(packed([0.0, middle, 1.0]), [60, 128, 195]);
    }
}
