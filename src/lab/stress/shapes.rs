//! Solids inserted into a recorded scene: rays hit them exactly, and the nearer surface replaces the recorded depth, color and
//! normal. They stand still, are lit from above and cast no shadow.

use glam::{DVec2, DVec3};
use half::f16;
use rayon::prelude::*;

use overlook_engine::capture::{Camera, Capture, Frame, INVALID_INVERSE_DEPTH};
use overlook_engine::error::Result;
use overlook_engine::median::median;

/// A bar between two points, or a flat panel.
enum AddedShape {
    /// Both ends on the axis; thickness in capture units.
    Bar { from: DVec3, axis: DVec3, length: f64, radius: f64 },
    /// Center, unit normal, two unit directions in it, half its side.
    Panel { center: DVec3, normal: DVec3, across: DVec3, up: DVec3, half: f64 },
}

/// What is put into a scene.
pub(super) struct Inserted {
    shapes: Vec<AddedShape>,
    /// Length of the pattern on them, capture units.
    pattern: f64,
}

/// Where the scene is, and how large.
struct SceneExtent {
    center: DVec3,
    /// Median distance of surfaces from the center.
    reach: f64,
    /// Width of a pixel at the center, mean over cameras.
    pixel: f64,
}

/// One pixel in this many is used to find where the scene is.
const STRIDE: usize = 61;

impl SceneExtent {
    fn of(capture: &Capture) -> Result<Self> {
        let mut points = Vec::new();
        for (index, camera) in capture.cameras.iter().enumerate() {
            let frame = capture.frame(index, 0)?;
            let width = frame.size().0;
            for (pixel, &inverse_depth) in frame.inverse_depth.as_slice().iter().enumerate().step_by(STRIDE) {
                if inverse_depth > 0.0 {
                    let at = DVec2::new((pixel % width) as f64 + 0.5, (pixel / width) as f64 + 0.5);
                    points.push(camera.unproject(at, 1.0 / f64::from(inverse_depth)));
                }
            }
        }
        let middle = |value: &dyn Fn(&DVec3) -> f64| {
            median(&mut points.iter().map(value).collect::<Vec<_>>()).unwrap_or(0.0)
        };
        let center = DVec3::from_array(std::array::from_fn(|axis| middle(&|point| point[axis])));
        let reach = middle(&|point| point.distance(center)).max(1e-6);
        let width = |camera: &Camera| {
            let distance = camera.position_in_world().distance(center);
            camera.intrinsics.spread_at(distance) / camera.intrinsics.fx
        };
        let widths = capture.cameras.iter().map(width);
        let pixel = widths.sum::<f64>() / capture.cameras.len().max(1) as f64;
        Ok(Self { center, reach, pixel })
    }
}

struct ShapeHit {
    depth: f64,
    normal: DVec3,
    /// Where on the pattern, in lengths of it.
    at: DVec2,
}

/// A true pixel is scored within this distance of an inserted shape, pixels.
const NEAR_PX: usize = 2;

impl Inserted {
    /// Upright and leaning bars around the middle of the scene, with a thickness in pixels.
    pub(super) fn bars(capture: &Capture, thickness_px: f64) -> Result<Self> {
        const BARS: usize = 9;
        let SceneExtent { center, reach, pixel } = SceneExtent::of(capture)?;
        let up = capture.up_in_world;
        let across = up.any_orthonormal_vector();
        let bar = |index: usize| {
            let angle = std::f64::consts::TAU * index as f64 / BARS as f64;
            let outward = across * angle.cos() + up.cross(across) * angle.sin();
            let lean = if index.is_multiple_of(3) { 0.5 } else { 0.0 };
            let axis = (up + lean * up.cross(outward)).normalize_or_zero();
            let from = center + 0.5 * reach * outward - 0.5 * reach * axis;
            AddedShape::Bar { from, axis, length: 1.2 * reach, radius: 0.5 * thickness_px * pixel }
        };
        Ok(Self { shapes: (0..BARS).map(bar).collect(), pattern: 24.0 * pixel })
    }

    /// A panel in the middle of the scene, with the angle between its normal and the view of the first camera.
    pub(super) fn panel(capture: &Capture, degrees: f64) -> Result<Self> {
        let SceneExtent { center, reach, pixel } = SceneExtent::of(capture)?;
        let eye = capture.cameras.first().map_or(center + capture.up_in_world, Camera::position_in_world);
        let toward = (eye - center).try_normalize().unwrap_or(DVec3::Z);
        let side = toward.cross(capture.up_in_world).try_normalize().unwrap_or(DVec3::X);
        let (sin, cos) = degrees.to_radians().sin_cos();
        let normal = toward * cos + side * sin;
        let across = side * cos - toward * sin;
        let up = normal.cross(across);
        let panel = AddedShape::Panel { center, normal, across, up, half: 0.6 * reach };
        Ok(Self { shapes: vec![panel], pattern: 12.0 * pixel })
    }

    /// The nearest hit of a ray (direction with camera-space `z = 1`) before `limit`.
    fn hit(&self, origin: DVec3, direction: DVec3, limit: f64) -> Option<ShapeHit> {
        let mut nearest: Option<ShapeHit> = None;
        for shape in &self.shapes {
            let limit = nearest.as_ref().map_or(limit, |hit| hit.depth);
            if let Some(hit) = shape.hit(origin, direction, self.pattern).filter(|hit| hit.depth < limit) {
                nearest = Some(hit);
            }
        }
        nearest
    }

    /// Puts the shapes into a frame.
    pub(super) fn put_into(&self, camera: &Camera, frame: &mut Frame) {
        let width = frame.size().0;
        let hits = self.hits(camera, frame);
        for (pixel, hit) in hits.into_iter().enumerate() {
            let Some(hit) = hit else { continue };
            let at = (pixel % width, pixel / width);
            frame.inverse_depth[at] = (1.0 / hit.depth) as f32;
            frame.color[at] = color(&hit);
            if let Some(normals) = &mut frame.normal_in_world {
                normals[at] = hit.normal.as_vec3().to_array();
            }
        }
    }

    /// Marks all pixels far from the shapes, which are in the frame already, as unknown.
    pub(super) fn only_near(&self, camera: &Camera, frame: &mut Frame) {
        let (width, height) = frame.size();
        let hits = self.hits(camera, frame);
        let is_near = |x: usize, y: usize| {
            (y.saturating_sub(NEAR_PX)..(y + NEAR_PX + 1).min(height)).any(|row| {
                let columns = x.saturating_sub(NEAR_PX)..(x + NEAR_PX + 1).min(width);
                hits[row * width..][columns].iter().any(Option::is_some)
            })
        };
        for y in 0..height {
            for x in 0..width {
                if !is_near(x, y) {
                    frame.inverse_depth[(x, y)] = INVALID_INVERSE_DEPTH;
                }
            }
        }
    }

    fn hits(&self, camera: &Camera, frame: &Frame) -> Vec<Option<ShapeHit>> {
        let width = frame.size().0;
        (0..frame.inverse_depth.len())
            .into_par_iter()
            .map(|pixel| {
                let inverse_depth = f64::from(frame.inverse_depth.as_slice()[pixel]);
                // A shape that is in the frame already is met again, a rounding error away.
                let limit = if inverse_depth > 0.0 { (1.0 + 1e-5) / inverse_depth } else { f64::INFINITY };
                let at = DVec2::new((pixel % width) as f64 + 0.5, (pixel / width) as f64 + 0.5);
                let ray = camera.intrinsics.ray_in_camera(at);
                let origin = camera.line_of_sight_start(at);
                self.hit(origin, camera.world_from_camera.transform_vector3(ray), limit)
            })
            .collect()
    }
}

impl AddedShape {
    fn hit(&self, origin: DVec3, direction: DVec3, pattern: f64) -> Option<ShapeHit> {
        match *self {
            Self::Bar { from, axis, length, radius } => {
                let (to, along) = (origin - from, direction.dot(axis));
                let (flat_to, flat) = (to - axis * to.dot(axis), direction - axis * along);
                let (a, b) = (flat.length_squared(), flat_to.dot(flat));
                let discriminant = b * b - a * (flat_to.length_squared() - radius * radius);
                if a <= 0.0 || discriminant <= 0.0 {
                    return None;
                }
                let depth = (-b - discriminant.sqrt()) / a;
                let height = to.dot(axis) + depth * along;
                if depth <= 0.0 || !(0.0..=length).contains(&height) {
                    return None;
                }
                let normal = ((flat_to + flat * depth) / radius).normalize_or_zero();
                Some(ShapeHit { depth, normal, at: DVec2::new(height / pattern, 0.5) })
            }
            Self::Panel { center, normal, across, up, half } => {
                let facing = direction.dot(normal);
                if facing.abs() < 1e-9 {
                    return None;
                }
                let depth = (center - origin).dot(normal) / facing;
                let at = origin + direction * depth - center;
                let (x, y) = (at.dot(across), at.dot(up));
                if depth <= 0.0 || x.abs() > half || y.abs() > half {
                    return None;
                }
                let toward = if facing > 0.0 { -normal } else { normal };
                Some(ShapeHit { depth, normal: toward, at: DVec2::new(x, y) / pattern })
            }
        }
    }
}

/// Smooth stripes across smooth stripes, lit from above.
fn color(hit: &ShapeHit) -> [f16; 3] {
    let wave = |at: f64| (0.5 + 0.5 * (std::f64::consts::TAU * at).sin()) as f32;
    let (x, y) = (wave(hit.at.x), wave(hit.at.y + 0.3 * hit.at.x));
    let light = 0.6 + 0.4 * hit.normal.z as f32;
    [0.15 + 0.7 * x, 0.2 + 0.5 * y, 0.6 - 0.4 * x * y].map(|value| f16::from_f32(value * light))
}
