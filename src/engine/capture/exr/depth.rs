//! What a depth value means, and the inverse of planar z that it amounts to.
//!
//! ```text
//! planar_z                      z = v
//! ray_distance                  z = v · cos a            a: angle between ray and optical axis
//! ray_distance_from_near_clip   z = v · cos a + near     (Mitsuba 3 measures from the near plane, along the ray)
//! position                      z = forward · (p − eye)  (states its kind by itself)
//! world_z                       z = (v − eye.z) / ray.z  (ray: in world space, scaled to z = 1 in the camera's)
//! z_buffer, reversed_z_buffer   1/z even between planes  (becomes planar z before these rules are asked)
//! ```

use glam::{DVec2, DVec3};

use crate::capture::camera::{Camera, Intrinsics};
use crate::capture::frame::INVALID_INVERSE_DEPTH;
use crate::median::median;
use crate::simd::{self, VectorLoop};

/// Depth at or beyond this was not hit where it is written in floats: Blender writes 1e10, others `f32::MAX` or infinity.
pub(crate) const MISS_DEPTH: f32 = 1e9;
/// The largest half float, to which half-float depth saturates, and light that is written as half floats.
pub(crate) const HALF_MAX: f32 = 65_504.0;
/// Slack of comparisons with given limits, which passed through `f32` once or twice.
const RELATIVE_SLACK: f64 = 1e-6;

/// What the depth channel of a capture holds. Known at the import boundary only; inside the program depth is planar.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub(crate) enum DepthKind {
    /// Distance along the optical axis.
    #[default]
    PlanarZ,
    /// Distance from the center of projection along the pixel's ray.
    RayDistance,
    /// Distance from the near plane along the pixel's ray.
    RayDistanceFromNearClip,
    /// World-space position of the surface point, three channels.
    WorldPosition,
    /// The z coordinate of the surface point in world space.
    WorldZ,
    /// A depth buffer: 0 at the near plane, 1 at the far plane.
    ZBuffer,
    /// A reversed depth buffer: 1 at the near plane, 0 at the far plane.
    ReversedZBuffer,
}

impl DepthKind {
    /// The kind by its name in the manifest.
    pub(crate) fn from_name(name: &str) -> Option<Self> {
        Some(match name {
            "planar_z" => Self::PlanarZ,
            "ray_distance" => Self::RayDistance,
            "ray_distance_from_near_clip" => Self::RayDistanceFromNearClip,
            "position" => Self::WorldPosition,
            "world_z" => Self::WorldZ,
            "z_buffer" => Self::ZBuffer,
            "reversed_z_buffer" => Self::ReversedZBuffer,
            _ => return None,
        })
    }

    /// Whether values are between two planes.
    pub(crate) fn is_buffer(self) -> bool {
        matches!(self, Self::ZBuffer | Self::ReversedZBuffer)
    }
}

/// How the values of a depth channel are read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DepthRules {
    /// What they measure.
    pub(crate) kind: DepthKind,
    /// The value that means "nothing hit", beside those that always do.
    pub(crate) miss_value: Option<f64>,
    /// The value that means "not measured", beside those that always do.
    pub(crate) invalid_value: Option<f32>,
    /// Distance of the near plane, world units.
    pub(crate) near_clip: f64,
    /// Planar z from which on nothing was hit, world units.
    pub(crate) far_clip: Option<f64>,
    /// World units per unit of the file.
    pub(crate) unit_scale: f64,
    /// Values from here on were not hit: [`MISS_DEPTH`] in floats, and the largest number of narrower ones and of whole numbers,
    /// which represents everything farther away.
    pub(crate) misses_from: f32,
    /// Whether 0 means "not measured" (depth sensors) rather than "nothing hit" (renderers).
    pub(crate) zero_is_unknown: bool,
}

impl Default for DepthRules {
    fn default() -> Self {
        Self {
            kind: DepthKind::PlanarZ,
            miss_value: None,
            invalid_value: None,
            near_clip: 0.0,
            far_clip: None,
            unit_scale: 1.0,
            misses_from: MISS_DEPTH,
            zero_is_unknown: false,
        }
    }
}

impl DepthRules {
    /// Inverse planar z of a raw `value` at a pixel whose ray, scaled to z = 1, has the given length: 0 where nothing
    /// was hit, [`INVALID_INVERSE_DEPTH`] for NaN, negative and unmeasured values.
    #[inline(always)]
    pub(crate) fn inverse_depth(&self, value: f32, ray_length: f64) -> f32 {
        let raw = f64::from(value);
        let scaled = raw * self.unit_scale;
        let depth_z = match self.kind {
            DepthKind::RayDistance => scaled / ray_length,
            DepthKind::RayDistanceFromNearClip => scaled / ray_length + self.near_clip,
            DepthKind::PlanarZ
            | DepthKind::WorldPosition
            | DepthKind::WorldZ
            | DepthKind::ZBuffer
            | DepthKind::ReversedZBuffer => scaled,
        };
        // All branches are the same for a whole plane, so that sixteen pixels are worked on at once.
        let is_miss = self.is_given_miss(raw) | (value >= self.misses_from);
        let at_zero = if self.zero_is_unknown { INVALID_INVERSE_DEPTH } else { 0.0 };
        let inverse = self.inverse_of_planar(depth_z);
        let inverse = if value > 0.0 { inverse } else { INVALID_INVERSE_DEPTH };
        let inverse = if value == 0.0 { at_zero } else { inverse };
        let inverse = if is_miss { 0.0 } else { inverse };
        if value == self.invalid_value.unwrap_or(f32::NAN) { INVALID_INVERSE_DEPTH } else { inverse }
    }

    /// Whether raw values measure backwards: some are negative, and no other is a distance.
    pub(crate) fn are_negative(&self, values: &[f32]) -> bool {
        let counts = |value: &&f32| **value < self.misses_from && !self.is_given_miss(f64::from(**value));
        // In this order: in nearly every picture one of the first values is a distance.
        !values.iter().filter(counts).any(|value| *value > 0.0)
            && values.iter().filter(counts).any(|value| *value < 0.0)
    }

    #[inline(always)]
    fn is_given_miss(&self, raw: f64) -> bool {
        let miss = self.miss_value.unwrap_or(f64::NAN);
        (raw == miss) | ((raw - miss).abs() <= RELATIVE_SLACK * miss.abs())
    }

    #[inline(always)]
    fn inverse_of_planar(&self, depth_z: f64) -> f32 {
        let far = self.far_clip.map_or(f64::INFINITY, |far| far * (1.0 - RELATIVE_SLACK));
        let inverse = (1.0 / depth_z) as f32;
        // Not a number, behind the camera, or so close that the reciprocal overflows.
        let is_good = inverse.is_finite() & (inverse >= 0.0);
        let inverse = if is_good { inverse } else { INVALID_INVERSE_DEPTH };
        if depth_z >= far { 0.0 } else { inverse }
    }

    /// Inverse planar z of every pixel of `camera` in place of a plane of raw values, row-major.
    pub(crate) fn inverse_depth_plane(&self, mut values: Vec<f32>, camera: &Camera) -> Vec<f32> {
        let width = camera.intrinsics.size().0.max(1);
        if self.kind == DepthKind::WorldZ {
            let inverse = |(index, value): (usize, &f32)| {
                let pixel = DVec2::new((index % width) as f64 + 0.5, (index / width) as f64 + 0.5);
                self.inverse_depth_of_world_z(*value, pixel, camera)
            };
            return values.iter().enumerate().map(inverse).collect();
        }
        for (y, values) in values.chunks_mut(width).enumerate() {
            simd::run(DepthRow { rules: *self, intrinsics: camera.intrinsics, y, values });
        }
        values
    }

    /// Inverse planar z of a pixel whose surface point has this z coordinate in world space.
    fn inverse_depth_of_world_z(&self, value: f32, pixel: DVec2, camera: &Camera) -> f32 {
        let raw = f64::from(value);
        let is_unknown = value.is_nan() || (value == 0.0 && self.zero_is_unknown);
        if is_unknown || Some(value) == self.invalid_value {
            return INVALID_INVERSE_DEPTH;
        }
        if self.is_given_miss(raw) || value >= self.misses_from {
            return 0.0;
        }
        let ray = camera.world_from_camera.transform_vector3(camera.intrinsics.ray_in_camera(pixel));
        let start = camera.line_of_sight_start(pixel);
        self.inverse_of_planar((raw * self.unit_scale - start.z) / ray.z)
    }

    /// Inverse planar z of every pixel of `camera` from planes of world-space positions, in the file's unit, row-major. A
    /// position of exactly zero is Blender's "nothing hit"; so is one whose every coordinate is the given miss value.
    pub(crate) fn inverse_depth_from_positions(&self, xyz: [&[f32]; 3], camera: &Camera) -> Vec<f32> {
        let eye = camera.position_in_world();
        let forward = camera.forward_in_world();
        let [xs, ys, zs] = xyz;
        xs.iter()
            .zip(ys)
            .zip(zs)
            .map(|((&x, &y), &z)| {
                let largest = x.abs().max(y.abs()).max(z.abs());
                let is_miss = largest == 0.0 || largest >= self.misses_from;
                if x.is_nan() || y.is_nan() || z.is_nan() {
                    INVALID_INVERSE_DEPTH
                } else if is_miss || [x, y, z].iter().all(|value| self.is_given_miss(f64::from(*value))) {
                    0.0
                } else {
                    let point_in_world =
                        DVec3::new(f64::from(x), f64::from(y), f64::from(z)) * self.unit_scale;
                    self.inverse_of_planar((point_in_world - eye).dot(forward))
                }
            })
            .collect()
    }

    /// The median distance between pixels and the projections of their positions, less rounding by `step_relative`, in pixels;
    /// infinite if most are behind the camera, and `None` if nothing was hit.
    pub(crate) fn distance_from_rays_px(
        &self,
        xyz: [&[f32]; 3],
        inverse_depth: &[f32],
        step_relative: f32,
        camera: &Camera,
    ) -> Option<f64> {
        const LOOKED_AT: usize = 4096;
        let width = camera.intrinsics.size().0.max(1);
        let focal_px = camera.intrinsics.fx.max(camera.intrinsics.fy);
        let camera_from_world = camera.camera_from_world();
        let is_hit = |&index: &usize| {
            let is_number = xyz.iter().all(|axis| axis[index].is_finite());
            is_number && inverse_depth[index] != 0.0
        };
        let step = (inverse_depth.len() / LOOKED_AT).max(1);
        let distance = |index: usize| {
            let point = DVec3::from_array(xyz.map(|axis| f64::from(axis[index]))) * self.unit_scale;
            let in_camera = camera_from_world.transform_point3(point);
            let Some(found) = camera.intrinsics.project(in_camera) else { return f64::INFINITY };
            let pixel = DVec2::new((index % width) as f64 + 0.5, (index / width) as f64 + 0.5);
            let scale = camera.intrinsics.spread_at(in_camera.z);
            let rounding = f64::from(step_relative) * point.length() * focal_px / scale;
            (found.distance(pixel) - 2.0 * rounding).max(0.0)
        };
        let hits = (0..inverse_depth.len()).step_by(step).filter(is_hit);
        median(&mut hits.map(distance).collect::<Vec<_>>())
    }
}

/// One row of raw values that become inverse depths.
struct DepthRow<'a> {
    rules: DepthRules,
    intrinsics: Intrinsics,
    y: usize,
    values: &'a mut [f32],
}

impl VectorLoop for DepthRow<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { rules, intrinsics, y, values } = self;
        if matches!(rules.kind, DepthKind::PlanarZ | DepthKind::WorldPosition) {
            for value in values {
                *value = rules.inverse_depth(*value, 1.0);
            }
        } else {
            for (x, value) in values.iter_mut().enumerate() {
                let pixel = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
                *value = rules.inverse_depth(*value, intrinsics.ray_in_camera(pixel).length());
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera() -> Camera {
        let intrinsics = Intrinsics { fy: 6.0, cx: 4.0, cy: 3.0, ..Intrinsics::centered(9, 7, 5.0) };
        Camera::look_at("c", intrinsics, DVec3::new(1.0, -4.0, 2.0), DVec3::new(0.5, 0.0, 0.0), DVec3::Z)
    }

    /// Every kind of depth of the plane that faces the camera at planar z 3 is 3 when read.
    #[test]
    fn every_kind_of_depth_of_a_facing_plane_is_planar_again() {
        let camera = camera();
        let near = 0.25;
        let (width, height) = camera.intrinsics.size();
        let rays: Vec<DVec3> = (0..width * height)
            .map(|i| DVec2::new((i % width) as f64 + 0.5, (i / width) as f64 + 0.5))
            .map(|pixel| camera.intrinsics.ray_in_camera(pixel))
            .collect();
        let planes: [(DepthKind, Vec<f32>); 3] = [
            (DepthKind::PlanarZ, vec![3.0; rays.len()]),
            (DepthKind::RayDistance, rays.iter().map(|ray| (3.0 * ray.length()) as f32).collect()),
            (
                DepthKind::RayDistanceFromNearClip,
                rays.iter().map(|ray| ((3.0 - near) * ray.length()) as f32).collect(),
            ),
        ];
        for (kind, values) in planes {
            let rules = DepthRules { kind, near_clip: near, ..DepthRules::default() };
            for inverse in rules.inverse_depth_plane(values, &camera) {
                assert!((1.0 / inverse - 3.0).abs() < 1e-5, "{kind:?}");
            }
        }
        let points: Vec<DVec3> =
            rays.iter().map(|ray| camera.world_from_camera.transform_point3(*ray * 3.0)).collect();
        let axis = |pick: fn(&DVec3) -> f64| points.iter().map(|p| pick(p) as f32).collect::<Vec<_>>();
        let (x, y, z) = (axis(|p| p.x), axis(|p| p.y), axis(|p| p.z));
        for inverse in DepthRules::default().inverse_depth_from_positions([&x, &y, &z], &camera) {
            assert!((1.0 / inverse - 3.0).abs() < 1e-5);
        }
        let in_cm = [&x, &y, &z].map(|axis| axis.iter().map(|value| value * 100.0).collect::<Vec<f32>>());
        let rules = DepthRules { unit_scale: 0.01, ..DepthRules::default() };
        for inverse in rules.inverse_depth_from_positions(in_cm.each_ref().map(Vec::as_slice), &camera) {
            assert!((1.0 / inverse - 3.0).abs() < 1e-5);
        }
    }

    #[test]
    fn nothing_hit_lies_at_infinity_and_nonsense_is_invalid() {
        let rules = DepthRules { far_clip: Some(100.0), miss_value: Some(77.0), ..DepthRules::default() };
        for miss in [1e10, f32::INFINITY, f32::MAX, 0.0, -0.0, 100.0, 5000.0, 77.0] {
            assert_eq!(rules.inverse_depth(miss, 1.0), 0.0, "{miss}");
        }
        for nonsense in [f32::NAN, -1.0, f32::NEG_INFINITY, 1e-42] {
            assert_eq!(rules.inverse_depth(nonsense, 1.0), INVALID_INVERSE_DEPTH, "{nonsense}");
        }
        assert_eq!(rules.inverse_depth(4.0, 1.0), 0.25);
    }

    #[test]
    fn saturated_half_floats_and_unmeasured_zeros_are_told_from_distances() {
        let float = DepthRules::default();
        let half = DepthRules { misses_from: HALF_MAX, ..float };
        let sensor = DepthRules { zero_is_unknown: true, unit_scale: 1e-3, ..float };
        assert_eq!(half.inverse_depth(65_504.0, 1.0), 0.0);
        assert!(float.inverse_depth(65_504.0, 1.0) > 0.0);
        assert_eq!(sensor.inverse_depth(0.0, 1.0), INVALID_INVERSE_DEPTH);
        assert_eq!(sensor.inverse_depth(2000.0, 1.0), 0.5);
    }

    #[test]
    fn a_position_of_zero_was_not_hit_and_one_behind_the_camera_is_invalid() {
        let camera = camera();
        let behind = camera.unproject(DVec2::new(4.0, 3.0), -2.0);
        let planes = [behind.x, behind.y, behind.z].map(|value| vec![value as f32, 0.0, f32::NAN]);
        let inverse =
            DepthRules::default().inverse_depth_from_positions([&planes[0], &planes[1], &planes[2]], &camera);
        assert_eq!(inverse, [INVALID_INVERSE_DEPTH, 0.0, INVALID_INVERSE_DEPTH]);
        let rules = DepthRules { miss_value: Some(-1.0), ..DepthRules::default() };
        assert_eq!(rules.inverse_depth_from_positions([&[-1.0], &[-1.0], &[-1.0]], &camera), [0.0]);
    }
}
