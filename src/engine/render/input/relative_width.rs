//! Pixels of a camera as a share of the depth.

use crate::capture::{Camera, Projection};

/// A number of pixels of a camera along the line of sight, as a share of the depth: in perspective a constant, of an orthographic camera
/// in proportion to the inverse depth.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RelativeWidth {
    constant: f32,
    per_inverse_depth: f32,
}

impl RelativeWidth {
    /// So many pixels of a camera.
    pub(crate) fn of(pixels: f32, camera: &Camera) -> Self {
        let width = pixels / focal(camera);
        match camera.intrinsics.projection {
            Projection::Perspective => Self { constant: width, per_inverse_depth: 0.0 },
            Projection::Orthographic => Self { constant: 0.0, per_inverse_depth: width },
        }
    }

    /// At an inverse depth. In perspective the bits of the constant.
    #[inline(always)]
    pub(crate) fn at(self, inverse_depth: f32) -> f32 {
        self.constant + self.per_inverse_depth * inverse_depth
    }
}

/// Mean focal length in pixels.
pub(crate) fn focal(camera: &Camera) -> f32 {
    (camera.intrinsics.fx * camera.intrinsics.fy).sqrt() as f32
}
