//! How far the inverse depths of neighboring pixels may differ on one surface.
//!
//! Purpose: the one rule of what is a step in depth, for everything that looks at one picture. Source: none; a number of footprints, which
//! in perspective is a share of the depth, and of an orthographic camera a distance.

use crate::capture::Camera;
use crate::capture::overlap::relative_side;

/// The step in depth that parts two surfaces.
#[derive(Clone, Copy, Debug)]
pub(super) struct SurfaceEdge {
    /// In perspective as a share of the depth, else in world units.
    size: f32,
    is_orthographic: bool,
}

impl SurfaceEdge {
    /// A step of more than so many footprints of `camera`.
    pub(super) fn new(camera: &Camera, footprints: f32) -> Self {
        let k = camera.intrinsics;
        Self { size: footprints / ((k.fx * k.fy).sqrt() as f32), is_orthographic: k.is_orthographic() }
    }

    /// The step as a share of the depth at an inverse depth.
    #[inline(always)]
    pub(super) fn relative(self, inverse_depth: f32) -> f32 {
        relative_side(self.size, self.is_orthographic, inverse_depth)
    }

    /// By how much two inverse depths of one surface may differ.
    #[inline(always)]
    pub(super) fn between(self, a: f32, b: f32) -> f32 {
        // As |z − z'| = |w − w'| / (w w').
        if self.is_orthographic { a * b * self.size } else { a.max(b) * self.size }
    }
}
