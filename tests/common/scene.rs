//! An analytic scene with known answers: spheres over a textured ground, under a sky at infinity.
//!
//! It shares nothing with the built-in demo scenes: what a test believes must not come from the code under test.

use std::sync::Arc;

use crate::draws::Draws;
use glam::{DVec2, DVec3};
use half::f16;
use overlook_engine::capture::{
    Camera, Capture, CaptureParts, Frame, FrameSource, INVALID_INVERSE_DEPTH, Intrinsics, Values,
};
use overlook_engine::error::Result;
use overlook_engine::grid::Grid;

/// A sphere that may move, and be absent.
#[derive(Clone)]
pub(crate) struct Sphere {
    /// Center in world space at a frame; `None` while it is not there.
    pub(crate) center: Arc<dyn Fn(usize) -> Option<DVec3> + Send + Sync>,
    pub(crate) radius: f64,
    pub(crate) color: [f32; 3],
}

impl Sphere {
    pub(crate) fn resting(center: DVec3, radius: f64, color: [f32; 3]) -> Self {
        Self { center: Arc::new(move |_| Some(center)), radius, color }
    }
}

#[derive(Clone, Default)]
pub(crate) struct Scene {
    pub(crate) spheres: Vec<Sphere>,
    /// Whether there is a ground at z = 0.
    pub(crate) ground: bool,
    /// Relative standard deviation of color noise that differs from frame to frame.
    pub(crate) color_noise: f32,
    /// Relative standard deviation of depth noise that differs from frame to frame.
    pub(crate) depth_noise: f32,
    /// Share of the pixels whose depth is read far too near, each camera's own and the same in all frames.
    pub(crate) strays: f32,
    /// A camera, by the seed that tells it apart, that reads what it sees in the middle of its picture at half its depth.
    pub(crate) misreading: Option<usize>,
    /// Whether depth is rounded to half floats.
    pub(crate) half_depth: bool,
    /// Whether frames carry normals.
    pub(crate) normals: bool,
    /// Color is averaged over so many rays a side of each pixel, as renderers do; depth and normal stay those of its center.
    /// 0 and 1 trace the center alone.
    pub(crate) color_rays: u32,
    /// Added to the ground's linear color at a frame.
    pub(crate) ground_light: Option<Arc<dyn Fn(usize, DVec3) -> f32 + Send + Sync>>,
}

pub(crate) const SKY: [f32; 3] = [0.2, 0.4, 0.8];

/// Smooth texture of the ground.
pub(crate) fn ground_color(point: DVec3) -> [f32; 3] {
    let wave = |a: f64, b: f64| (0.3 + 0.12 * (a * point.x + b * point.y).sin()) as f32;
    [wave(1.3, 0.4), wave(0.5, 1.7), wave(-0.8, 0.9)]
}

impl Scene {
    /// A ground with two resting spheres, with normals.
    pub(crate) fn still_life() -> Self {
        Self {
            spheres: vec![
                Sphere::resting(DVec3::new(0.0, 0.0, 0.6), 0.6, [0.7, 0.2, 0.1]),
                Sphere::resting(DVec3::new(1.2, 0.5, 0.4), 0.4, [0.1, 0.5, 0.2]),
            ],
            ground: true,
            normals: true,
            ..Self::default()
        }
    }

    /// Nearest hit: distance factor of `ray`, normal, color.
    fn hit(&self, frame: usize, eye: DVec3, ray: DVec3) -> Option<(f64, DVec3, [f32; 3])> {
        let mut best: Option<(f64, DVec3, [f32; 3])> = None;
        let mut offer = |t: f64, normal: DVec3, color: [f32; 3]| {
            if t > 1e-6 && best.is_none_or(|(nearest, ..)| t < nearest) {
                best = Some((t, normal, color));
            }
        };
        if self.ground && ray.z != 0.0 {
            let t = -eye.z / ray.z;
            let point = eye + ray * t;
            let light = self.ground_light.as_ref().map_or(0.0, |light| light(frame, point));
            offer(t, DVec3::Z * eye.z.signum(), ground_color(point).map(|c| c + light));
        }
        for sphere in &self.spheres {
            let Some(center) = (sphere.center)(frame) else { continue };
            let (a, b) = (ray.length_squared(), ray.dot(eye - center));
            let discriminant = b * b - a * ((eye - center).length_squared() - sphere.radius * sphere.radius);
            if discriminant > 0.0 {
                for t in [(-b - discriminant.sqrt()) / a, (-b + discriminant.sqrt()) / a] {
                    let normal = (eye + ray * t - center) / sphere.radius;
                    let normal = if normal.dot(ray) > 0.0 { -normal } else { normal };
                    offer(t, normal, sphere.color);
                }
            }
        }
        best
    }

    /// Mean color over a pixel.
    fn average_color(&self, camera: &Camera, frame: usize, (x, y): (usize, usize)) -> [f32; 3] {
        let side = self.color_rays;
        let mut sum = [0.0; 3];
        for i in 0..side * side {
            let offset = (DVec2::new(f64::from(i % side), f64::from(i / side)) + 0.5) / f64::from(side);
            let at = DVec2::new(x as f64, y as f64) + offset;
            let ray = camera.world_from_camera.matrix3 * camera.intrinsics.ray_in_camera(at);
            let hit = self.hit(frame, camera.line_of_sight_start(at), ray);
            let color = hit.map_or(SKY, |(_, _, color)| color);
            (0..3).for_each(|channel| sum[channel] += color[channel] / (side * side) as f32);
        }
        sum
    }

    /// What `camera` records; `seed` tells cameras' noise apart.
    pub(crate) fn trace(&self, camera: &Camera, frame: usize, seed: usize) -> Frame {
        let (width, height) = camera.intrinsics.size();
        let mut color = Grid::filled(width, height, [f16::ZERO; 3]);
        let mut inverse_depth = Grid::filled(width, height, INVALID_INVERSE_DEPTH);
        let mut normal = Grid::filled(width, height, [0.0; 3]);
        for y in 0..height {
            for x in 0..width {
                let center = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
                let ray = camera.world_from_camera.matrix3 * camera.intrinsics.ray_in_camera(center);
                let hit = self.hit(frame, camera.line_of_sight_start(center), ray);
                let noise = 1.0 + self.color_noise * normal_draw((x + 1000 * y, frame, seed));
                let (w, n, c) = hit.map_or((0.0, DVec3::ZERO, SKY), |(t, n, c)| (1.0 / t, n, c));
                let depth_noise = self.depth_noise * normal_draw((x + 1000 * y, frame, seed + 100));
                let w = w / f64::from(1.0 + depth_noise);
                let w = w * self.misread((x, y), (width, height), seed);
                let w = if self.half_depth { 1.0 / f64::from(f16::from_f64(1.0 / w).to_f32()) } else { w };
                let c = if self.color_rays > 1 { self.average_color(camera, frame, (x, y)) } else { c };
                color[(x, y)] = c.map(|c| f16::from_f32(c * noise));
                inverse_depth[(x, y)] = if w.is_finite() { w as f32 } else { 0.0 };
                normal[(x, y)] = n.as_vec3().to_array();
            }
        }
        Frame {
            color,
            inverse_depth,
            normal_in_world: self.normals.then_some(normal),
            depth_step_relative: if self.half_depth { 1.0 / 2048.0 } else { 0.0 },
            values: Values::default(),
        }
    }

    /// How many times nearer a pixel reads its depth than it is.
    fn misread(&self, (x, y): (usize, usize), (width, height): (usize, usize), seed: usize) -> f64 {
        let is_stray = self.strays > 0.0
            && Draws((x + 1000 * y) as u64 ^ (seed as u64) << 40).below(1 << 20) as f32
                <= self.strays * (1 << 20) as f32;
        let is_middle = |at: usize, size: usize| 4 * at >= size && 4 * at < 3 * size;
        let misreads = self.misreading == Some(seed) && is_middle(x, width) && is_middle(y, height);
        if is_stray {
            1.7
        } else if misreads {
            2.0
        } else {
            1.0
        }
    }

    /// The scene recorded by `cameras` over `frames` frames.
    pub(crate) fn record(&self, cameras: Vec<Camera>, frames: usize) -> Capture {
        Capture::new(
            CaptureParts {
                name: "analytic".to_owned(),
                frame_numbers: (0..frames as i64).collect(),
                up_in_world: DVec3::Z,
                has_normals: self.normals,
                antialiased_color: self.color_rays > 1,
                warnings: Vec::new(),
                source: Arc::new(Recorder { scene: self.clone(), cameras: cameras.clone() }),
                cameras,
            },
            256 << 20,
        )
    }
}

struct Recorder {
    scene: Scene,
    cameras: Vec<Camera>,
}

impl FrameSource for Recorder {
    fn load(&self, camera: usize, frame: usize) -> Result<Frame> {
        Ok(self.scene.trace(&self.cameras[camera], frame, camera))
    }

    fn place(&self, camera: usize, frame: usize) -> String {
        format!("analytic scene, camera {camera}, frame {frame}")
    }
}

/// A draw from a normal distribution that depends on nothing but its key.
pub(crate) fn normal_draw(key: (usize, usize, usize)) -> f32 {
    let key = (key.0 as u64) ^ (key.1 as u64) << 24 ^ (key.2 as u64) << 48;
    let mut draws = Draws(key ^ 0x9e37_79b9_7f4a_7c15);
    let mut uniform = || draws.below(1 << 24) as f32 / (1 << 24) as f32;
    let (a, b) = (uniform().max(1e-7), uniform());
    (-2.0 * a.ln()).sqrt() * (std::f32::consts::TAU * b).cos()
}

/// A camera of `size` square pixels and an angle of view of 0.9 radians.
pub(crate) fn camera(name: &str, eye: DVec3, target: DVec3, size: u32) -> Camera {
    Camera::look_at(name, Intrinsics::from_horizontal_angle(size, size, 0.9), eye, target, DVec3::Z)
}

/// Cameras on an arc around the origin.
pub(crate) fn arc(count: usize, size: u32) -> Vec<Camera> {
    (0..count)
        .map(|i| {
            let angle = -0.6 + 1.2 * (i as f64 + 0.5) / count as f64;
            let eye = DVec3::new(5.0 * angle.sin(), -5.0 * angle.cos(), 2.0 + 0.3 * i as f64);
            camera(&format!("arc{i}"), eye, DVec3::new(0.3, 0.2, 0.3), size)
        })
        .collect()
}

impl std::fmt::Debug for Scene {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Scene")
            .field("spheres", &self.spheres.len())
            .field("color_noise", &self.color_noise)
            .field("depth_noise", &self.depth_noise)
            .field("half_depth", &self.half_depth)
            .field("normals", &self.normals)
            .field("color_rays", &self.color_rays)
            .finish_non_exhaustive()
    }
}
