//! One picture of one camera: color, inverse depth and, where given, normals and scalar values.

use half::f16;

use super::values::Values;
use crate::grid::Grid;

/// Inverse depth of a pixel that has no depth at all. Every negative value means the same.
pub const INVALID_INVERSE_DEPTH: f32 = -1.0;

/// One frame of one camera, in the program's own conventions whatever the file said.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// Linear Rec.709, scene referred, as the capture gives it. Finite.
    pub color: Grid<[f16; 3]>,
    /// Reciprocal of planar z, 1/unit. 0 is a sample at infinity (sky); negative is a pixel without depth, which
    /// takes part in nothing. Never NaN, never infinite.
    pub inverse_depth: Grid<f32>,
    /// Unit normals in world space, toward the camera; `[0, 0, 0]` for no normal. `None` where the capture
    /// gives no normals.
    pub normal_in_world: Option<Grid<[f32; 3]>>,
    /// Relative quantization step of the depth as recorded (2⁻¹¹ for half floats, 0 where it is exact to `f32`).
    pub depth_step_relative: f32,
    /// Scalar values of every pixel, row-major, one for each of the capture's channels; empty where it has none.
    pub values: Values,
}

impl Frame {
    /// `(width, height)` in pixels.
    #[must_use]
    pub fn size(&self) -> (usize, usize) {
        self.inverse_depth.size()
    }

    /// Pixels without depth.
    #[must_use]
    pub fn invalid_pixels(&self) -> usize {
        self.inverse_depth.as_slice().iter().filter(|w| **w < 0.0).count()
    }

    /// Bytes this frame occupies in memory.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let normals = if self.normal_in_world.is_some() { 12 } else { 0 };
        self.inverse_depth.len() * (6 + 4 + normals) + self.values.bytes()
    }
}
