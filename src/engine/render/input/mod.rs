//! The samples of one frame, as renderers read them.

mod dense_tile;
mod frame_tiles;
mod tile_cache;
mod tile_grid;

use std::sync::Arc;

use crate::capture::{Camera, Projection};
use crate::samples::SampleSet;
use crate::settings::RenderSettings;
pub(crate) use dense_tile::{DenseTile, beside_edges, slopes};
pub(crate) use frame_tiles::{
    ColorIndex, FrameImages, FrameSamples, FrameTile, TileIndex, linear, samples_above,
};
pub(crate) use tile_cache::{LaneValues, Quads, TexelColor, TileCaches};
pub(crate) use tile_grid::{CellTable, Lookup};

/// What a painted background depends on: while it stays the same, so does the background.
#[derive(Debug)]
pub(crate) struct BackgroundKey {
    pub(crate) samples: Arc<SampleSet>,
    /// Indices of the images of the background.
    pub(crate) images: Vec<usize>,
    pub(crate) camera: Camera,
    pub(crate) settings: RenderSettings,
    /// Pixels of the z-buffer along each side of a pixel of the picture.
    pub(crate) subpixels: usize,
    /// Whether pictures tell what pixels show in front of their farthest surface.
    pub(crate) with_fronts: bool,
}

impl BackgroundKey {
    /// Whether both give the same background.
    pub(crate) fn matches(&self, other: &Self) -> bool {
        self.images == other.images
            && (Arc::ptr_eq(&self.samples, &other.samples)
                || self.samples.shares(&other.samples, &other.images))
            && self.camera == other.camera
            && self.settings == other.settings
            && (self.subpixels, self.with_fronts) == (other.subpixels, other.with_fronts)
    }
}

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
