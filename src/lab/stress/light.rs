//! Relighting of a recorded scene from depth and normals, without shadows or bounces; the truth is relit by the same rule.

use glam::{DVec2, DVec3, Vec3};
use half::f16;
use rayon::prelude::*;

use overlook_engine::capture::{Camera, Capture, Frame};
use overlook_engine::preprocess::normals::{DepthView, estimate_all};
use overlook_engine::settings::{NormalEstimator, NormalSettings};

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
