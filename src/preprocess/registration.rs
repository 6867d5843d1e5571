//! Registration (the paper, §3.2): carries every sample into every other camera and asks whether that camera saw the same
//! surface point.
//!
//! Source: Interactive Dynamic Environments Using Image-Based Modeling and Rendering, §3.2, "mapping every image in the same
//! time frame to every other image in that time frame". What differs: *the same point* is decided in pixel footprints, by
//! the distance to the other sample's tangent plane, and by normals and color, each with its own threshold; points at
//! infinity are carried like all others (homogeneous coordinates with `w = 1/z`).

use glam::{Mat3, Vec3};

use super::layer::{Layer, MIXED};
use super::sampling_rate::Rays;
use crate::capture::Camera;
use crate::color;
use crate::settings::Settings;

/// What another camera says about a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Outcome {
    /// The point lies behind the camera.
    Behind,
    /// The point lies outside the picture.
    OutsideView,
    /// The camera recorded no depth at that pixel.
    NoDepth,
    /// The camera sees something nearer at that pixel.
    Occluded,
    /// The camera sees something farther at that pixel: it looks past the point.
    SeesPast,
    /// Same depth, but the normals differ.
    NormalDiffers,
    /// Same depth, but the colors differ.
    ColorDiffers,
    /// The camera shows the surface only on one side of the point: there it cannot be interpolated.
    Seam,
    /// The camera saw the same surface point, at this pixel (`y * width + x`).
    Same(u32),
}

/// Carries samples of one camera into another.
#[derive(Clone, Copy, Debug)]
pub struct Registration {
    /// Source ray (world orientation) to target camera space, scaled to target pixels: row dotted with ray.
    image_from_ray: Mat3,
    /// Source position in target camera space, scaled likewise; multiplied with inverse depth.
    image_from_origin: Vec3,
    /// Source position minus target position, world space.
    offset_in_world: Vec3,
    source: Rays,
    target: Rays,
    target_width: u32,
    target_height: u32,
}

/// Thresholds of the same-surface test, converted once.
#[derive(Clone, Copy, Debug)]
pub struct SameSurface {
    depth_footprints: f32,
    normal_cosine: f32,
    color_steps: f32,
    noise_sigmas: f32,
    overlap: bool,
}

/// Two noisy colors of one surface differ by less than this many standard deviations of their difference.
const COLOR_SIGMAS: f32 = 3.0;

/// A position this close to a pixel's center, in pixels, is that pixel: no neighbor takes part in interpolating there.
const CENTERED: f32 = 1.0 / 16.0;

impl SameSurface {
    /// The thresholds of `settings`.
    #[must_use]
    pub fn new(settings: &Settings) -> Self {
        Self {
            depth_footprints: settings.pruning.depth_tolerance,
            normal_cosine: settings.pruning.normal_tolerance.to_radians().cos(),
            color_steps: settings.pruning.color_tolerance,
            noise_sigmas: settings.spans.noise * COLOR_SIGMAS,
            overlap: settings.pruning.overlap,
        }
    }
}

impl Registration {
    /// Carries samples of `source` into `target`.
    #[must_use]
    pub fn new(source: &Camera, target: &Camera) -> Self {
        let k = target.intrinsics;
        let target_from_world = target.camera_from_world();
        let image_from_camera = glam::DMat3::from_cols(
            glam::DVec3::new(k.fx, 0.0, 0.0),
            glam::DVec3::new(0.0, k.fy, 0.0),
            glam::DVec3::new(k.cx, k.cy, 1.0),
        );
        let offset = source.position_in_world() - target.position_in_world();
        let image_from_world = image_from_camera * target_from_world.matrix3;
        Self {
            image_from_ray: image_from_world.as_mat3(),
            image_from_origin: (image_from_world * offset).as_vec3(),
            offset_in_world: offset.as_vec3(),
            source: Rays::new(source),
            target: Rays::new(target),
            target_width: k.width,
            target_height: k.height,
        }
    }

    /// Image position in the target, times depth ratio, of a source sample: `(x, y)` in pixels after division by `z`, and
    /// `z` is target depth over source depth (for samples at infinity: cosine-like, positive in front).
    fn carry(&self, ray: Vec3, inverse_depth: f32) -> Vec3 {
        self.image_from_ray * ray + self.image_from_origin * inverse_depth
    }

    /// What the target camera says about the sample at pixel `(x, y)` of the source.
    #[must_use]
    pub fn test(&self, source: &Layer, target: &Layer, x: usize, y: usize, limits: &SameSurface) -> Outcome {
        let pixel = y * source.width + x;
        let inverse_depth = source.inverse_depth[pixel];
        let ray = self.source.at(x, y);
        let carried = self.carry(ray, inverse_depth);
        if carried.z <= 0.0 {
            return Outcome::Behind;
        }
        let (u, v) = (carried.x / carried.z, carried.y / carried.z);
        if !(u >= 0.0 && v >= 0.0 && u < self.target_width as f32 && v < self.target_height as f32) {
            return Outcome::OutsideView;
        }
        let (column, row) = (u as usize, v as usize);
        let found = row * target.width + column;
        match self.compare_depth(source, target, (pixel, ray, carried.z), (found, column, row), limits) {
            Some(outcome) => outcome,
            None if limits.overlap && !self.surrounds(target, (u, v), (column, row), limits) => Outcome::Seam,
            None => compare_looks(source, target, pixel, found, limits),
        }
    }

    /// Whether the target shows the surface at `found` on all four pixels around the position `(u, v)`, so that it can
    /// be interpolated there.
    fn surrounds(
        &self,
        target: &Layer,
        (u, v): (f32, f32),
        (column, row): (usize, usize),
        limits: &SameSurface,
    ) -> bool {
        // Along each axis: nothing where the position is the pixel's center, else the pixel on the other side of it.
        let beside = |at: usize, position: f32, size: u32| {
            let off_center = position - at as f32 - 0.5;
            if off_center.abs() <= CENTERED {
                return Some(at);
            }
            let beside = if off_center > 0.0 { at.checked_add(1) } else { at.checked_sub(1) };
            beside.filter(|&beside| beside < size as usize)
        };
        let (Some(x), Some(y)) = (beside(column, u, self.target_width), beside(row, v, self.target_height))
        else {
            return false;
        };
        let found = row * target.width + column;
        [(x, row), (column, y), (x, y)].into_iter().all(|(x, y)| {
            let (here, there) = (target.inverse_depth[found], target.inverse_depth[y * target.width + x]);
            if here <= 0.0 || there <= 0.0 {
                return here == there;
            }
            let center = self.target.at(column, row) / here;
            let point = self.target.at(x, y) / there;
            let normal = target.normal[found];
            let distance = if normal == Vec3::ZERO {
                (here.recip() - there.recip()).abs()
            } else {
                normal.dot(point - center).abs()
            };
            distance <= limits.depth_footprints * self.target.pixel_side() / here.min(there)
        })
    }

    /// The depth part of the test; `None` where the two samples lie on one surface.
    fn compare_depth(
        &self,
        source: &Layer,
        target: &Layer,
        (pixel, ray, depth_ratio): (usize, Vec3, f32),
        (found, column, row): (usize, usize, usize),
        limits: &SameSurface,
    ) -> Option<Outcome> {
        let inverse_depth = source.inverse_depth[pixel];
        let found_inverse_depth = target.inverse_depth[found];
        if found_inverse_depth < 0.0 {
            return Some(Outcome::NoDepth);
        }
        if inverse_depth == 0.0 || found_inverse_depth == 0.0 {
            return if inverse_depth == found_inverse_depth {
                None
            } else if inverse_depth == 0.0 {
                Some(Outcome::Occluded)
            } else {
                Some(Outcome::SeesPast)
            };
        }
        let (source_z, found_z) = (inverse_depth.recip(), found_inverse_depth.recip());
        let expected_z = depth_ratio * source_z;
        let target_ray = self.target.at(column, row);
        // Relative to the target's position, so that large world coordinates cancel before they round.
        let point = ray * source_z + self.offset_in_world;
        let normal = target.normal[found];
        let distance = if normal == Vec3::ZERO {
            (expected_z - found_z).abs()
        } else {
            normal.dot(point - target_ray * found_z).abs()
        };
        let footprint = (self.source.pixel_side() * source_z).max(self.target.pixel_side() * found_z);
        let step = source.depth_step_relative * source_z + target.depth_step_relative * found_z;
        if distance <= limits.depth_footprints * footprint + step {
            None
        } else if found_z < expected_z {
            Some(Outcome::Occluded)
        } else {
            Some(Outcome::SeesPast)
        }
    }
}

/// The normal and color parts of the test.
fn compare_looks(
    source: &Layer,
    target: &Layer,
    pixel: usize,
    found: usize,
    limits: &SameSurface,
) -> Outcome {
    let (a, b) = (source.normal[pixel], target.normal[found]);
    if a != Vec3::ZERO && b != Vec3::ZERO && a.dot(b) < limits.normal_cosine {
        return Outcome::NormalDiffers;
    }
    // A mixed sample's color belongs to no surface: it may not speak against a clean witness.
    let yields = source.rank[pixel] & MIXED != 0 && target.rank[found] & MIXED == 0;
    if !yields {
        for channel in 0..3 {
            let (a, b) = (source.color[pixel][channel], target.color[found][channel]);
            let (a, b) = (color::steps_from_linear(a), color::steps_from_linear(b));
            let noise = source.color_noise(pixel, a).hypot(target.color_noise(found, b));
            if (a - b).abs() > limits.color_steps + limits.noise_sigmas * noise {
                return Outcome::ColorDiffers;
            }
        }
    }
    Outcome::Same(found as u32)
}
