//! Disturbances of the recording: each changes a frame as it is loaded.

use glam::{DVec2, DVec3, Vec3};
use half::f16;
use rayon::prelude::*;

use overlook_engine::capture::{Camera, Capture, Frame, INVALID_INVERSE_DEPTH};
use overlook_engine::demo::with_render_noise;
use overlook_engine::grid::Grid;
use overlook_engine::preprocess::normals::{DepthView, estimate_all};
use overlook_engine::random::{gaussian_pair, mix, uniform_pair};
use overlook_engine::settings::{NormalEstimator, NormalSettings};

/// Camera and index of a frame.
#[derive(Clone, Copy)]
pub(super) struct FrameKey {
    pub(super) camera: usize,
    pub(super) frame: usize,
}

/// Random numbers that depend on camera, frame and pixel alone: noise is the same in every run.
pub(super) struct PixelRandom {
    stream: u64,
}

impl PixelRandom {
    pub(super) fn of(at: FrameKey) -> Self {
        Self { stream: mix(mix(at.camera as u64) ^ at.frame as u64) }
    }

    /// Two independent numbers between 0 and 1, the ends left out. Numbers of another `salt` are independent of these.
    pub(super) fn uniform_pair(&self, pixel: usize, salt: u64) -> [f32; 2] {
        uniform_pair(self.bits(pixel, salt))
    }

    /// Two independent standard normal numbers.
    pub(super) fn gaussian_pair(&self, pixel: usize, salt: u64) -> [f32; 2] {
        gaussian_pair(self.bits(pixel, salt))
    }

    fn bits(&self, pixel: usize, salt: u64) -> u64 {
        mix(self.stream ^ mix(pixel as u64 ^ (salt << 48)))
    }
}

pub(super) fn depth_noise(frame: &mut Frame, share: f32, at: FrameKey) {
    let noise = PixelRandom::of(at);
    for (pixel, inverse_depth) in frame.inverse_depth.as_mut_slice().iter_mut().enumerate() {
        if *inverse_depth > 0.0 {
            let factor = 1.0 + share * noise.gaussian_pair(pixel, 0)[0];
            *inverse_depth /= factor.max(0.1);
        }
    }
}

/// From this many bits on, whole numbers are as fine as the floats that depth comes in.
const EXACT_BITS: f64 = 24.0;

pub(super) fn depth_steps(frame: &mut Frame, bits: f64, near: f32, far: f32) {
    if bits >= EXACT_BITS {
        return;
    }
    let step = f64::from(far - near) / (bits.exp2() - 1.0);
    for inverse_depth in frame.inverse_depth.as_mut_slice() {
        if *inverse_depth > 0.0 {
            let steps = ((1.0 / f64::from(*inverse_depth) - f64::from(near)) / step).round();
            *inverse_depth = (1.0 / (f64::from(near) + steps.max(0.0) * step)) as f32;
        }
    }
}

pub(super) fn depth_float(frame: &mut Frame, bits: u32) {
    let dropped = 23_u32.saturating_sub(bits);
    if dropped == 0 {
        return;
    }
    for inverse_depth in frame.inverse_depth.as_mut_slice() {
        if *inverse_depth > 0.0 {
            let depth = (1.0 / *inverse_depth).to_bits() + (1 << (dropped - 1));
            *inverse_depth = 1.0 / f32::from_bits(depth >> dropped << dropped);
        }
    }
    frame.depth_step_relative = frame.depth_step_relative.max((-(bits as f32) - 1.0).exp2());
}

/// Noise as the demo's cameras have it, without those pixels that stray far.
pub(super) fn color_noise(frame: &mut Frame, share: f32, at: FrameKey) {
    let noise = PixelRandom::of(at);
    for (pixel, color) in frame.color.as_mut_slice().iter_mut().enumerate() {
        let [common, r] = noise.gaussian_pair(pixel, 1);
        let [g, b] = noise.gaussian_pair(pixel, 2);
        let own = [r, g, b];
        for channel in 0..3 {
            let value = color[channel].to_f32().max(0.0);
            color[channel] = f16::from_f32(with_render_noise(value, share, common, own[channel]));
        }
    }
}

/// Exposes even cameras half as many stops less, odd ones half as many more.
pub(super) fn expose(frame: &mut Frame, stops: f32, camera: usize) {
    let half = if camera.is_multiple_of(2) { -0.5 } else { 0.5 };
    let gain = (half * stops).exp2();
    for color in frame.color.as_mut_slice() {
        *color = color.map(|value| f16::from_f32(value.to_f32() * gain));
    }
}

/// Neighbors whose depths differ by more than this share have a silhouette between them.
pub(super) const SILHOUETTE: f32 = 0.03;

/// Mixes the colors of pixels near a silhouette with a Gaussian of the given radius; depth stays as it is.
pub(super) fn antialias(frame: &mut Frame, radius_px: f32) {
    if radius_px <= 0.0 {
        return;
    }
    let reach = (2.0 * radius_px).ceil() as i64;
    let (width, height) = frame.size();
    let (colors, depths) = (frame.color.clone(), &frame.inverse_depth);
    let around = |x: usize, y: usize, reach: i64| {
        let columns = (x as i64 - reach).max(0)..=(x as i64 + reach).min(width as i64 - 1);
        let rows = (y as i64 - reach).max(0)..=(y as i64 + reach).min(height as i64 - 1);
        rows.flat_map(move |row| columns.clone().map(move |column| (column as usize, row as usize)))
    };
    for y in 0..height {
        for x in 0..width {
            let here = depths[(x, y)];
            let is_edge = here >= 0.0
                && around(x, y, 1).any(|at| (depths[at] - here).abs() > SILHOUETTE * depths[at].max(here));
            if !is_edge {
                continue;
            }
            let (mut sum, mut total) = ([0.0; 3], 0.0);
            for at in around(x, y, reach) {
                let distance = (at.0 as f32 - x as f32).hypot(at.1 as f32 - y as f32) / radius_px;
                let weight = (-2.0 * distance * distance).exp();
                total += weight;
                for (sum, value) in sum.iter_mut().zip(colors[at]) {
                    *sum += weight * value.to_f32();
                }
            }
            frame.color[(x, y)] = sum.map(|value| f16::from_f32(value / total));
        }
    }
}

pub(super) fn normals_missing(frame: &mut Frame, share: f32, at: FrameKey) {
    let width = frame.size().0;
    if let Some(normals) = &mut frame.normal_in_world {
        for (pixel, normal) in normals.as_mut_slice().iter_mut().enumerate() {
            let square = (pixel % width / 8, pixel / width / 8);
            let chance = mix(mix(at.camera as u64) ^ mix(square.0 as u64 ^ (square.1 as u64) << 32));
            if ((chance >> 40) as f32) < share * (1 << 24) as f32 {
                *normal = [0.0; 3];
            }
        }
    }
}

pub(super) fn normals_noisy(frame: &mut Frame, radians: f32, at: FrameKey) {
    let noise = PixelRandom::of(at);
    let Some(normals) = frame.normal_in_world.as_mut().filter(|_| radians > 0.0) else { return };
    for (pixel, normal) in normals.as_mut_slice().iter_mut().enumerate() {
        let exact = Vec3::from(*normal);
        if exact == Vec3::ZERO {
            continue;
        }
        let [a, b] = noise.gaussian_pair(pixel, 3);
        let [c, _] = noise.gaussian_pair(pixel, 4);
        let off = exact + radians * Vec3::new(a, b, c);
        *normal = off.normalize_or_zero().to_array();
    }
}

pub(super) fn narrow(frame: &mut Frame, share: f64) {
    let (width, height) = frame.size();
    let inside = |at: usize, length: usize| ((at as f64 + 0.5) / length as f64 - 0.5).abs() <= 0.5 * share;
    let depths = &frame.inverse_depth;
    frame.inverse_depth = Grid::from_fn(width, height, |x, y| {
        if inside(x, width) && inside(y, height) { depths[(x, y)] } else { INVALID_INVERSE_DEPTH }
    });
}

/// How the scene is lit in addition.
pub(super) struct Lighting {
    kind: LightChange,
    /// Radiance of a highlight, or share of a surface's own color that the light adds.
    strength: f32,
    up: DVec3,
    frames: usize,
}

pub(super) enum LightChange {
    /// A highlight of a light that stands still.
    Specular,
    /// A light that goes round once.
    Moving,
}

/// Phong's exponent: a highlight about 25° wide, as of varnish.
const SHININESS: i32 = 20;

impl Lighting {
    pub(super) fn new(capture: &Capture, kind: LightChange, strength: f32) -> Self {
        Self { kind, strength, up: capture.up_in_world, frames: capture.frame_count() }
    }

    /// Toward the light, unit length, world space, at a frame.
    fn toward(&self, frame: usize) -> Vec3 {
        let turn = match self.kind {
            LightChange::Specular => 0.1,
            LightChange::Moving => frame as f64 / self.frames.max(1) as f64,
        };
        let (sin, cos) = (std::f64::consts::TAU * turn).sin_cos();
        let across = self.up.any_orthonormal_vector();
        let around = across * cos + self.up.cross(across) * sin;
        (around + 0.8 * self.up).normalize_or_zero().as_vec3()
    }

    fn lit(&self, color: [f16; 3], normal: Vec3, toward_eye: Vec3, toward_light: Vec3) -> [f16; 3] {
        let facing = normal.dot(toward_light).max(0.0);
        let value = |channel: f16| match self.kind {
            LightChange::Specular => {
                let mirrored = 2.0 * normal.dot(toward_light) * normal - toward_light;
                let highlight = mirrored.dot(toward_eye).max(0.0).powi(SHININESS);
                channel.to_f32() + self.strength * highlight * facing.sqrt()
            }
            LightChange::Moving => channel.to_f32() * (1.0 + self.strength * facing),
        };
        color.map(|channel| f16::from_f32(value(channel)))
    }
    /// Puts a frame under this light. Surfaces without a normal, and what is at infinity, stay as they are.
    pub(super) fn apply(&self, camera: &Camera, frame_index: usize, frame: &mut Frame) {
        let width = frame.size().0.max(1);
        let toward_light = self.toward(frame_index);
        let settings = NormalSettings::default();
        let view = DepthView::new(frame.inverse_depth.as_slice(), camera, &settings);
        let rotation = camera.world_from_camera.matrix3.as_mat3();
        let estimates = frame.normal_in_world.is_none().then(|| estimate_all(&view, NormalEstimator::Plane));
        let normal = |x: usize, y: usize| match (&frame.normal_in_world, &estimates) {
            (Some(normals), _) => Vec3::from(normals[(x, y)]),
            (None, Some(estimates)) => rotation * estimates[(x, y)].normal_in_camera,
            (None, None) => Vec3::ZERO,
        };
        frame.color.as_mut_slice().par_iter_mut().enumerate().for_each(|(pixel, color)| {
            let (x, y) = (pixel % width, pixel / width);
            if frame.inverse_depth[(x, y)] <= 0.0 {
                return;
            }
            let normal = normal(x, y);
            if normal == Vec3::ZERO {
                return;
            }
            let ray = camera.intrinsics.ray_in_camera(DVec2::new(x as f64 + 0.5, y as f64 + 0.5));
            let toward_eye = -camera.world_from_camera.transform_vector3(ray).normalize_or_zero().as_vec3();
            *color = self.lit(*color, normal, toward_eye, toward_light);
        });
    }
}
