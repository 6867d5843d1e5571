//! Random scenes of which every color and depth is known exactly: balls, textured, shaded by a lamp or both, cut out of a picture, over a
//! ground or under a sky, seen by two to nine cameras.

use std::f64::consts::TAU;
use std::sync::Arc;

use crate::draws::Draws;
use crate::scene::normal_draw;
use glam::{DAffine3, DQuat, DVec2, DVec3};
use half::f16;
use overlook_engine::capture::{
    Camera, Capture, CaptureParts, Frame, FrameSource, INVALID_INVERSE_DEPTH, Intrinsics, Values,
};
use overlook_engine::error::Result;
use overlook_engine::grid::Grid;

/// A number drawn evenly between two others.
pub(crate) fn between(draws: &mut Draws, least: f64, most: f64) -> f64 {
    least + (most - least) * draws.below(1 << 32) as f64 / (1_u64 << 32) as f64
}

fn direction(draws: &mut Draws) -> DVec3 {
    let up = between(draws, -1.0, 1.0);
    let (y, x) = between(draws, 0.0, TAU).sin_cos();
    let across = (1.0 - up * up).sqrt();
    DVec3::new(across * x, across * y, up)
}

/// What is seen where no surface is.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Background {
    /// Cut out: no depth, and one color.
    Cut(f64),
    /// At infinity.
    Sky,
    /// A textured ground at z = 0, cut out beyond.
    Ground,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Look {
    Textured,
    Shaded,
    Both,
}

#[derive(Clone, Debug)]
struct Ball {
    center: DVec3,
    radius: f64,
    albedo: DVec3,
}

/// A wave of a texture in space.
#[derive(Clone, Debug)]
struct Wave {
    way: DVec3,
    phase: f64,
}

/// A scene with its cameras, and what the rig gets wrong about them.
#[derive(Clone, Debug)]
pub(crate) struct ExactScene {
    balls: Vec<Ball>,
    waves: Vec<Wave>,
    look: Look,
    background: Background,
    lamp: DVec3,
    /// Whether the lamp moves with the cameras instead.
    has_headlight: bool,
    /// Radius of all balls in each picture instead of their own, pixels.
    radius_px: Option<f64>,
    /// Color is averaged over so many rays a side of each pixel.
    color_rays: usize,
    /// Relative standard deviations.
    noise: Noise,
    /// Cameras as they are.
    pub(crate) cameras: Vec<Camera>,
    /// Cameras of color, where they are not those of depth.
    pub(crate) color_cameras: Option<Vec<Camera>>,
    /// Stops by which each camera's pictures are too bright.
    pub(crate) stops: Vec<f64>,
    /// Whether it says that a program rendered it.
    pub(crate) is_rendered: Option<bool>,
}

/// Relative standard deviations.
#[derive(Clone, Copy, Debug)]
struct Noise {
    depth: f64,
    color: f64,
}

impl ExactScene {
    /// The scene of a seed, with or without noise.
    pub(crate) fn random(seed: u64, is_noisy: bool) -> Self {
        let mut draws = Draws(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15));
        let draws = &mut draws;
        let ball = |draws: &mut Draws, nth: usize| Ball {
            center: DVec3::Z * 0.9
                + between(draws, 0.0, 0.9) * direction(draws) * f64::from(u8::from(nth > 0)),
            radius: if nth == 0 { between(draws, 0.5, 0.8) } else { between(draws, 0.2, 0.5) },
            albedo: DVec3::new(between(draws, 0.1, 0.9), between(draws, 0.1, 0.9), between(draws, 0.1, 0.9)),
        };
        let count = 2 + draws.below(5) as usize;
        let balls = (0..count).map(|nth| ball(draws, nth)).collect();
        let wave = |draws: &mut Draws| {
            let length = between(draws, 0.25_f64.ln(), 2.0_f64.ln()).exp();
            Wave { way: direction(draws) * TAU / length, phase: between(draws, 0.0, TAU) }
        };
        let waves = (0..4).map(|_| wave(draws)).collect();
        let look = [Look::Textured, Look::Shaded, Look::Both][draws.below(3) as usize];
        let shade = [0.0, 1.0, 0.5][draws.below(3) as usize];
        let background =
            [Background::Cut(shade), Background::Cut(shade), Background::Sky, Background::Ground]
                [draws.below(4) as usize];
        let lamp = (direction(draws) + DVec3::Z * 0.7).normalize_or_zero();
        let color_rays = [1, 3][draws.below(2) as usize];
        let noise = if is_noisy {
            Noise { depth: between(draws, 0.001, 0.008), color: between(draws, 0.005, 0.03) }
        } else {
            Noise { depth: 0.0, color: 0.0 }
        };
        let cameras = cameras(draws);
        let stops = vec![0.0; cameras.len()];
        let (color_cameras, is_rendered) = (None, Some(false));
        Self {
            balls,
            waves,
            look,
            background,
            lamp,
            has_headlight: false,
            radius_px: None,
            color_rays,
            noise,
            cameras,
            color_cameras,
            stops,
            is_rendered,
        }
    }

    /// The scene without textures under a light that moves with the cameras, as visualization programs have it.
    pub(crate) fn under_a_headlight(self) -> Self {
        Self { look: Look::Shaded, has_headlight: true, ..self }
    }

    /// Many balls of one size in each picture, as visualization programs draw points, before a gray background.
    pub(crate) fn of_points(self, seed: u64) -> Self {
        let mut draws = Draws(seed ^ 0x2545_f491);
        let draws = &mut draws;
        let ball = |_| Ball {
            center: DVec3::Z * 0.9 + between(draws, 0.1, 0.9) * direction(draws),
            radius: 0.0,
            albedo: DVec3::new(between(draws, 0.1, 0.9), between(draws, 0.1, 0.9), between(draws, 0.1, 0.9)),
        };
        let balls = (0..80).map(ball).collect();
        Self { balls, look: Look::Shaded, background: Background::Cut(0.5), radius_px: Some(5.0), ..self }
    }

    /// What is recorded of the scene, by cameras that claim to be `claimed`.
    pub(crate) fn record(&self, claimed: Vec<Camera>) -> Capture {
        let parts = CaptureParts {
            name: "exact".to_owned(),
            frame_numbers: vec![0],
            up_in_world: DVec3::Z,
            has_normals: false,
            antialiased_color: self.color_rays > 1,
            warnings: Vec::new(),
            source: Arc::new(self.clone()),
            cameras: claimed,
        };
        Capture::new(parts, 256 << 20)
    }

    /// Nearest hit along a ray: its factor, and the color.
    fn hit(&self, camera: &Camera, ray: DVec3) -> Option<(f64, DVec3)> {
        let eye = camera.position_in_world();
        let mut nearest: Option<(f64, DVec3)> = None;
        for ball in &self.balls {
            let to = eye - ball.center;
            let radius_of = |pixels: f64| {
                pixels * (camera.world_from_camera.inverse().transform_point3(ball.center)).z.abs()
                    / camera.intrinsics.fx
            };
            let radius = self.radius_px.map_or(ball.radius, radius_of);
            let (a, b) = (ray.length_squared(), ray.dot(to));
            let discriminant = b * b - a * (to.length_squared() - radius * radius);
            let t = (-b - discriminant.max(0.0).sqrt()) / a;
            if discriminant > 0.0 && t > 0.0 && nearest.is_none_or(|(nearest, _)| t < nearest) {
                let point = eye + ray * t;
                nearest = Some((t, self.color(eye, point, (point - ball.center) / radius, ball.albedo)));
            }
        }
        let t = -eye.z / ray.z;
        if self.background == Background::Ground && t > 0.0 && nearest.is_none_or(|(nearest, _)| t < nearest)
        {
            let point = eye + ray * t;
            if point.length() < 4.0 {
                nearest = Some((t, self.color(eye, point, DVec3::Z, DVec3::splat(0.6))));
            }
        }
        nearest
    }

    fn color(&self, eye: DVec3, point: DVec3, normal: DVec3, albedo: DVec3) -> DVec3 {
        let toward_light = if self.has_headlight { (eye - point).normalize_or_zero() } else { self.lamp };
        let shade = 0.15 + 0.85 * normal.dot(toward_light).max(0.0);
        let wave = |nth: usize| (self.waves[nth].way.dot(point) + self.waves[nth].phase).sin();
        let texture = DVec3::new(wave(0) + wave(3), wave(1) + wave(3), wave(2) + wave(3)) * 0.2 + 0.55;
        match self.look {
            Look::Textured => albedo.map(f64::sqrt) * texture,
            Look::Shaded => albedo * shade,
            Look::Both => albedo.map(f64::sqrt) * texture * shade,
        }
    }

    fn behind(&self) -> DVec3 {
        match self.background {
            Background::Cut(shade) => DVec3::splat(shade),
            Background::Sky => DVec3::new(0.2, 0.4, 0.8),
            Background::Ground => DVec3::splat(0.05),
        }
    }

    fn seen_color(&self, camera: &Camera, corner: DVec2) -> DVec3 {
        let side = self.color_rays;
        let mut sum = DVec3::ZERO;
        for nth in 0..side * side {
            let offset = (DVec2::new((nth % side) as f64, (nth / side) as f64) + 0.5) / side as f64;
            let ray = camera.world_from_camera.matrix3 * camera.intrinsics.ray_in_camera(corner + offset);
            sum += self.hit(camera, ray).map_or(self.behind(), |(_, color)| color);
        }
        sum / (side * side) as f64
    }
}

impl FrameSource for ExactScene {
    fn load(&self, index: usize, _frame: usize) -> Result<Frame> {
        let camera = &self.cameras[index];
        let color_camera = self.color_cameras.as_ref().map_or(camera, |cameras| &cameras[index]);
        let (width, height) = camera.intrinsics.size();
        let draw = |x: usize, y: usize, kind: usize| f64::from(normal_draw((x + 1000 * y, kind, index)));
        let color = Grid::from_fn(width, height, |x, y| {
            let seen = self.seen_color(color_camera, DVec2::new(x as f64, y as f64));
            let gain = self.stops[index].exp2() * (1.0 + self.noise.color * draw(x, y, 1));
            (seen * gain).to_array().map(f16::from_f64)
        });
        let inverse_depth = Grid::from_fn(width, height, |x, y| {
            let ray = camera.intrinsics.ray_in_camera(DVec2::new(x as f64 + 0.5, y as f64 + 0.5));
            let hit = self.hit(camera, camera.world_from_camera.matrix3 * ray);
            let none = if self.background == Background::Sky { 0.0 } else { INVALID_INVERSE_DEPTH };
            hit.map_or(none, |(t, _)| (1.0 / (t * (1.0 + self.noise.depth * draw(x, y, 2)))) as f32)
        });
        Ok(Frame {
            color,
            inverse_depth,
            normal_in_world: None,
            depth_step_relative: 0.0,
            values: Values::default(),
        })
    }

    fn place(&self, camera: usize, _frame: usize) -> String {
        format!("exact scene, camera {camera}")
    }

    fn is_rendered(&self) -> Option<bool> {
        self.is_rendered
    }
}

/// Two to nine cameras of one lens, around the scene or along one side of it.
fn cameras(draws: &mut Draws) -> Vec<Camera> {
    let count = 2 + draws.below(8) as usize;
    let lens = Intrinsics::from_horizontal_angle(128, 96, between(draws, 0.8, 1.2));
    let angle = if draws.below(2) == 0 { TAU } else { between(draws, 0.6, 1.6) };
    let start = between(draws, 0.0, TAU);
    let camera = |nth: usize| {
        let at = start + angle * nth as f64 / count as f64;
        let eye = DVec3::new(3.0 * at.cos(), 3.0 * at.sin(), between(draws, 1.0, 2.2));
        let target = DVec3::Z * 0.9 + 0.15 * direction(draws);
        Camera::look_at(format!("c{nth}"), lens, eye, target, DVec3::Z)
    };
    (0..count).map(camera).collect()
}

/// A pose turned about its center by `degrees` about a random axis, and moved by `distance`.
pub(crate) fn misplaced(camera: &Camera, draws: &mut Draws, degrees: f64, distance: f64) -> Camera {
    let turn = DQuat::from_axis_angle(direction(draws), degrees.to_radians());
    let shift = distance * direction(draws);
    let mut moved = camera.clone();
    moved.world_from_camera *= DAffine3::from_rotation_translation(turn, shift);
    moved
}

/// The camera of color beside one of depth.
pub(crate) fn color_camera(depth: &Camera, ratio: f64, color_from_depth: DAffine3) -> Camera {
    let mut color = depth.clone();
    color.intrinsics.fx *= ratio;
    color.intrinsics.fy *= ratio;
    color.world_from_camera *= color_from_depth.inverse();
    color
}
