//! Depth as a camera sees it, and what is estimated from it.

use glam::Vec3;

use crate::capture::Camera;
use crate::settings::NormalSettings;

/// One estimated normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Unit, in camera space, toward the camera; zero where nothing can be said.
    pub normal_in_camera: Vec3,
    /// 0 (a guess) to 1 (all neighbors agree).
    pub(crate) confidence: f32,
}

/// Where nothing can be said.
pub(crate) const NOTHING: Estimate = Estimate { normal_in_camera: Vec3::ZERO, confidence: 0.0 };

/// Depth seen by a camera, with what an estimator needs to know about it.
pub struct DepthView<'a> {
    pub(crate) inverse_depth: &'a [f32],
    pub(crate) width: i32,
    pub(crate) height: i32,
    pub(crate) focal: [f32; 2],
    pub(crate) center: [f32; 2],
    /// Largest step in depth to a direct neighbor on the same surface, as a share of the depth; of an orthographic camera in world units.
    pub(crate) edge_relative: f32,
    /// Whether lines of sight are parallel.
    pub(crate) is_orthographic: bool,
}

impl<'a> DepthView<'a> {
    /// Inverse depth of `camera`, row-major, with the edge threshold of `settings`.
    #[must_use]
    pub fn new(inverse_depth: &'a [f32], camera: &Camera, settings: &NormalSettings) -> Self {
        let k = camera.intrinsics;
        let focal = [k.fx as f32, k.fy as f32];
        Self {
            inverse_depth,
            width: k.width as i32,
            height: k.height as i32,
            focal,
            center: [k.cx as f32, k.cy as f32],
            edge_relative: settings.edge / (focal[0] * focal[1]).sqrt(),
            is_orthographic: k.is_orthographic(),
        }
    }

    /// Inverse depth at `(x, y)` if it belongs to the same surface as `center` (an inverse depth above 0), `reach`
    /// pixels away.
    pub(crate) fn same_surface(&self, x: i32, y: i32, center: f32, reach: i32) -> Option<f32> {
        if x < 0 || y < 0 || x >= self.width || y >= self.height {
            return None;
        }
        let w = self.inverse_depth[(y * self.width + x) as usize];
        // |z − z₀| / z₀ = |w₀ − w| / w
        let scale = if self.is_orthographic { w * center } else { w.max(center) };
        (w > 0.0 && (w - center).abs() <= scale * self.edge_relative * reach as f32).then_some(w)
    }

    pub(crate) fn point(&self, x: i32, y: i32, w: f32) -> Vec3 {
        let [x, y] = [
            (x as f32 + 0.5 - self.center[0]) / self.focal[0],
            (y as f32 + 0.5 - self.center[1]) / self.focal[1],
        ];
        if self.is_orthographic { Vec3::new(x, y, w.recip()) } else { Vec3::new(x, y, 1.0) / w }
    }
}
