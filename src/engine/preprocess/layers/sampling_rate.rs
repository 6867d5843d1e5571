//! Sampling rate (the paper, §3.2): how densely a camera samples a surface.
//!
//! Purpose: of two samples of one surface point, tell which camera saw it better.
//!
//! Source: Interactive Dynamic Environments Using Image-Based Modeling and Rendering, §3.2:
//! `r = ((c₁V·d₁)•c₁D · cos(xN•−c₂V)) / ((c₂V·d₂)•c₂D · cos(xN•−c₁V))`; `r < 1` where camera 1 samples more densely.
//! `(cV·d)•cD` is planar depth `z`, and the `cos(…)` of a dot product is that dot product itself, the cosine of the angle
//! of incidence θ. So `r = (z₁ / cos θ₁) / (z₂ / cos θ₂)`: a ratio of two numbers that each belong to one sample alone,
//! here called its *footprint*. What differs: the formula has one point and one normal for both cameras; here each sample
//! brings its own, since who wins must be a total order of all samples, whichever two are compared. The cosine has a
//! floor, so that grazing views and poor normals stay comparable. And beside the paper's footprint there are two that also
//! know focal length and resolution: the surface area of a pixel, `z² cos α / (fx fy cos θ)` with α the angle off the
//! optical axis, and the longest side of that area, `z √(cos α) / (min(fx, fy) cos θ)`, which is
//! `z √(cos α / (fx fy)) / cos θ` where pixels are square. A surface is resolved no better than along the longest side: on
//! every capture tried, the longest side keeps fewer samples than the area and comes closer to the truth
//! (`overlook sweep`, assets/results/notebook.md). Where cameras are alike it orders samples as the paper does, but for α. An
//! orthographic camera has α = 0 and, in place of `z / f`, the width of its pixels at any depth.

use glam::Vec3;

use crate::capture::Camera;
use crate::settings::{PruningSettings, RateModel};

/// How footprints are measured, once decided for a capture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Rate {
    /// `z / cos θ`, capture units.
    Paper,
    /// `z² cos α / (fx fy cos θ)`, capture units squared.
    Footprint,
    /// `z √(cos α) / (min(fx, fy) cos θ)`, capture units.
    Stretch,
}

/// Relative difference of focal lengths below which two cameras count as alike.
const ALIKE: f64 = 1e-3;

impl Rate {
    /// What `model` means for these cameras.
    pub(crate) fn resolve(model: RateModel, cameras: &[Camera]) -> Self {
        let alike = |a: &Camera, b: &Camera| {
            let (a, b) = (a.intrinsics, b.intrinsics);
            let are_in_perspective = !(a.is_orthographic() || b.is_orthographic());
            are_in_perspective && (a.fx / b.fx - 1.0).abs() < ALIKE && (a.fy / b.fy - 1.0).abs() < ALIKE
        };
        match model {
            RateModel::Paper => Self::Paper,
            RateModel::Auto if cameras.windows(2).all(|pair| alike(&pair[0], &pair[1])) => Self::Paper,
            RateModel::Footprint => Self::Footprint,
            RateModel::Stretch | RateModel::Auto => Self::Stretch,
        }
    }

    /// This one where it knows focal length and resolution, else the area of a pixel: what the paper's `r` is shown beside.
    pub(crate) fn with_focal_length(self) -> Self {
        if self == Self::Paper { Self::Footprint } else { self }
    }
}

/// The viewing rays of a camera: camera position plus `ray(x, y) · z` is the world point of a pixel at planar depth `z`. Those of an
/// orthographic camera, which start in its picture plane, are all alike.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ViewingRays {
    origin: Vec3,
    per_column: Vec3,
    per_row: Vec3,
    /// `1 / (fx fy)`: solid angle of a pixel on the optical axis.
    pub(crate) pixel_area: f32,
    /// `1 / min(fx, fy)²`: the square of a pixel's longer side at depth 1; the area where pixels are square.
    longer_side_squared: f32,
    /// What stands for the depth in the paper's rate for an orthographic camera.
    scale: Option<f32>,
}

impl ViewingRays {
    /// The rays of `camera`, in world orientation.
    pub(crate) fn new(camera: &Camera) -> Self {
        let k = camera.intrinsics;
        let rotation = camera.world_from_camera.matrix3;
        let is_orthographic = k.is_orthographic();
        let growth = |axis: glam::DVec3, focal: f64| {
            if is_orthographic { Vec3::ZERO } else { (axis / focal).as_vec3() }
        };
        Self {
            origin: (rotation * k.ray_in_camera(glam::DVec2::splat(0.5))).as_vec3(),
            per_column: growth(rotation.x_axis, k.fx),
            per_row: growth(rotation.y_axis, k.fy),
            pixel_area: (1.0 / (k.fx * k.fy)) as f32,
            longer_side_squared: (1.0 / k.fx.min(k.fy).powi(2)) as f32,
            scale: is_orthographic.then(|| k.depth_scale(1.0) as f32),
        }
    }

    /// The ray through the center of pixel `(x, y)`, scaled to planar depth 1, in world orientation.
    pub(crate) fn at(&self, x: usize, y: usize) -> Vec3 {
        self.origin + self.per_column * x as f32 + self.per_row * y as f32
    }
}

/// The cosine of incidence θ between a ray and a surface normal, both in world orientation, no less than `floor`.
/// An unknown (zero) normal counts as the floor. That it loses to every known one is up to the sample's
/// [`Rank`](super::packed_sample::Rank).
fn cosine_of_incidence(ray: Vec3, normal: Vec3, floor: f32) -> f32 {
    (-normal.dot(ray) / ray.length()).max(floor)
}

/// The footprint of a sample: smaller is sampled more densely; the ratio of two is the paper's `r`.
///
/// `ray` comes from [`ViewingRays::at`]; samples at infinity (`inverse_depth` 0) are compared by the size of their pixel alone.
pub(crate) fn footprint(
    rate: Rate,
    rays: &ViewingRays,
    ray: Vec3,
    inverse_depth: f32,
    normal: Vec3,
    settings: &PruningSettings,
) -> f32 {
    let secant_off_axis = ray.length();
    if let Some(scale) = rays.scale {
        let cosine = cosine_of_incidence(ray, normal, settings.cosine_floor);
        return match rate {
            // All of its sky is in one direction, which any camera in perspective shows finer.
            _ if inverse_depth <= 0.0 => 1.0,
            Rate::Paper => scale / cosine,
            Rate::Footprint => rays.pixel_area / cosine,
            Rate::Stretch => rays.longer_side_squared.sqrt() / cosine,
        };
    }
    if inverse_depth <= 0.0 {
        return match rate {
            Rate::Paper => 1.0,
            Rate::Footprint => rays.pixel_area / secant_off_axis.powi(3),
            // Squared, which orders them alike.
            Rate::Stretch => rays.longer_side_squared / secant_off_axis.powi(3),
        };
    }
    let cosine = cosine_of_incidence(ray, normal, settings.cosine_floor);
    let z = inverse_depth.recip();
    match rate {
        Rate::Paper => z / cosine,
        Rate::Footprint => z * z * rays.pixel_area / (secant_off_axis * cosine),
        Rate::Stretch => z * (rays.longer_side_squared / secant_off_axis).sqrt() / cosine,
    }
}

/// Footprints that differ by less than about a thousandth compare as equal: rounding never settles a comparison.
const RANK_SHIFT: u32 = 13;

/// The order in which samples win: smaller wins. Monotone in the footprint (positive, finite).
pub(super) fn rank(footprint: f32) -> u32 {
    footprint.to_bits() >> RANK_SHIFT
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capture::Intrinsics;
    use glam::{DVec2, DVec3, Vec2};

    fn camera(eye: DVec3, target: DVec3, width: u32) -> Camera {
        Camera::look_at("c", Intrinsics::from_horizontal_angle(width, width, 0.9), eye, target, DVec3::Z)
    }

    fn settings() -> PruningSettings {
        PruningSettings { cosine_floor: 0.01, ..PruningSettings::default() }
    }

    fn footprint_at(rate: Rate, camera: &Camera, point: DVec3, normal: Vec3) -> f32 {
        let (pixel, z) = camera.project(point).unwrap();
        let rays = ViewingRays::new(camera);
        let ray = (camera.world_from_camera.matrix3 * camera.intrinsics.ray_in_camera(pixel)).as_vec3();
        footprint(rate, &rays, ray, (1.0 / z) as f32, normal, &settings())
    }

    #[test]
    fn r_is_two_where_one_camera_stands_twice_as_far_on_the_normal() {
        let (near, far) = (
            camera(DVec3::Z * 2.0 + DVec3::Y * 1e-9, DVec3::ZERO, 100),
            camera(DVec3::Z * 4.0 + DVec3::Y * 1e-9, DVec3::ZERO, 100),
        );
        let r = footprint_at(Rate::Paper, &far, DVec3::ZERO, Vec3::Z)
            / footprint_at(Rate::Paper, &near, DVec3::ZERO, Vec3::Z);
        assert!((r - 2.0).abs() < 1e-5);
    }

    #[test]
    fn r_is_the_secant_where_one_camera_looks_from_the_side() {
        // Both at distance 3 and looking at the point; one along the normal, one 60° off: r = 1 / cos 60° = 2.
        let side = DVec3::new(3.0 * 60_f64.to_radians().sin(), 0.0, 3.0 * 60_f64.to_radians().cos());
        let (front, side) =
            (camera(DVec3::new(0.0, 1e-9, 3.0), DVec3::ZERO, 100), camera(side, DVec3::ZERO, 100));
        let r = footprint_at(Rate::Paper, &side, DVec3::ZERO, Vec3::Z)
            / footprint_at(Rate::Paper, &front, DVec3::ZERO, Vec3::Z);
        assert!((r - 2.0).abs() < 1e-4, "{r}");
    }

    /// The paper's `r` for one point seen by two cameras, as printed: view vectors `v`, look vectors `d` (unit, world space),
    /// distances along the view vector, and the normal at the point.
    fn paper_r(view: [Vec3; 2], look: [Vec3; 2], distance: Vec2, normal: Vec3) -> f32 {
        let numerator = (view[0] * distance.x).dot(look[0]) * normal.dot(-view[1]);
        let denominator = (view[1] * distance.y).dot(look[1]) * normal.dot(-view[0]);
        numerator / denominator
    }

    #[test]
    fn the_ratio_of_footprints_is_the_papers_r_as_printed() {
        let point = DVec3::new(0.3, -0.2, 0.1);
        let normal = Vec3::new(0.2, -0.3, 0.9).normalize_or_zero();
        let cameras = [
            camera(DVec3::new(1.0, -2.0, 3.0), DVec3::ZERO, 64),
            camera(DVec3::new(-2.0, -1.0, 2.0), DVec3::X, 64),
        ];
        let view = cameras.each_ref().map(|c| (point - c.position_in_world()).as_vec3().normalize_or_zero());
        let look = cameras.each_ref().map(|c| c.forward_in_world().as_vec3());
        let distance = cameras.each_ref().map(|c| (point - c.position_in_world()).length() as f32);
        let printed = paper_r(view, look, Vec2::from(distance), normal);
        let [a, b] = cameras.each_ref().map(|c| footprint_at(Rate::Paper, c, point, normal));
        assert!((printed - a / b).abs() < 1e-5 * printed);
    }

    #[test]
    fn the_footprint_is_the_area_that_the_pixel_covers_on_the_surface() {
        // Carry the corners of one pixel onto the plane z = 0 and measure the quadrilateral.
        let camera = camera(DVec3::new(1.0, -2.0, 3.0), DVec3::new(0.4, 0.2, 0.0), 400);
        let corner = |dx: f64, dy: f64| {
            let ray = camera.world_from_camera.matrix3
                * camera.intrinsics.ray_in_camera(DVec2::new(310.0 + dx, 90.0 + dy));
            let eye = camera.position_in_world();
            eye - ray * (eye.z / ray.z)
        };
        let diagonals = (corner(1.0, 1.0) - corner(0.0, 0.0)).cross(corner(0.0, 1.0) - corner(1.0, 0.0));
        let area = diagonals.length() / 2.0;
        let ours = f64::from(footprint_at(Rate::Footprint, &camera, corner(0.5, 0.5), Vec3::Z));
        assert!((ours / area - 1.0).abs() < 1e-3, "{ours} {area}");
    }

    #[test]
    fn the_footprint_knows_resolution_and_the_papers_r_does_not() {
        let (coarse, fine) = (
            camera(DVec3::new(0.0, -3.0, 1.0), DVec3::ZERO, 100),
            camera(DVec3::new(0.0, -3.0, 1.0), DVec3::ZERO, 400),
        );
        let ratio = |rate| {
            footprint_at(rate, &coarse, DVec3::ZERO, Vec3::Z)
                / footprint_at(rate, &fine, DVec3::ZERO, Vec3::Z)
        };
        assert!((ratio(Rate::Paper) - 1.0).abs() < 1e-5);
        assert!((ratio(Rate::Footprint) - 16.0).abs() < 1e-3);
        assert!((ratio(Rate::Stretch) - 4.0).abs() < 1e-4);
        assert_eq!(Rate::resolve(RateModel::Auto, &[coarse.clone(), fine]), Rate::Stretch);
        assert_eq!(Rate::resolve(RateModel::Auto, &[coarse.clone(), coarse]), Rate::Paper);
    }

    #[test]
    fn the_footprint_of_an_orthographic_camera_is_the_same_at_any_depth() {
        let lens = Intrinsics::orthographic(100, 100, 4.0);
        let at = |distance: f64| {
            Camera::look_at("c", lens, DVec3::new(0.0, -distance, 0.0), DVec3::ZERO, DVec3::Z)
        };
        let normal = Vec3::new(0.0, -0.5, 0.75_f32.sqrt());
        for (rate, expected) in [(Rate::Footprint, 0.04 * 0.04 / 0.5), (Rate::Stretch, 0.04 / 0.5)] {
            for distance in [0.5, 3.0, 900.0] {
                let found = footprint_at(rate, &at(distance), DVec3::new(0.3, 0.0, 0.2), normal);
                assert!((found / expected - 1.0).abs() < 1e-5, "{found}");
            }
        }
        let near = camera(DVec3::new(0.0, -3.0, 1.0), DVec3::ZERO, 100);
        assert_eq!(Rate::resolve(RateModel::Auto, &[near, at(3.0)]), Rate::Stretch);
    }

    #[test]
    fn a_pixel_is_as_long_as_its_longer_side() {
        let square = camera(DVec3::new(0.0, -3.0, 1.0), DVec3::ZERO, 100);
        let stretched = |fx: f64, fy: f64| {
            let mut camera = square.clone();
            (camera.intrinsics.fx, camera.intrinsics.fy) =
                (camera.intrinsics.fx * fx, camera.intrinsics.fy * fy);
            footprint_at(Rate::Stretch, &camera, DVec3::ZERO, Vec3::Z)
        };
        let expected = footprint_at(Rate::Stretch, &square, DVec3::ZERO, Vec3::Z);
        for (fx, fy, longer) in [(4.0, 1.0, 1.0), (1.0, 4.0, 1.0), (0.5, 1.0, 2.0), (4.0, 4.0, 0.25)] {
            assert!((stretched(fx, fy) / expected - longer).abs() < 1e-5, "{fx} {fy}");
        }
        let rays = ViewingRays::new(&square);
        assert_eq!(rays.longer_side_squared, rays.pixel_area, "bit for bit where pixels are square");
    }

    #[test]
    fn an_unknown_normal_counts_as_seen_at_grazing_incidence() {
        let camera = camera(DVec3::new(0.0, -3.0, 1.0), DVec3::ZERO, 100);
        for rate in [Rate::Paper, Rate::Footprint, Rate::Stretch] {
            let footprint = |normal| footprint_at(rate, &camera, DVec3::ZERO, normal);
            assert_eq!(footprint(Vec3::ZERO), footprint(Vec3::X), "the camera looks along the surface");
            assert!(rank(footprint(Vec3::ZERO)) > rank(footprint(Vec3::Z)));
        }
    }
}
