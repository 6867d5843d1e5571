//! The samples of one frame, as renderers read them.

mod dense_tile;
mod frame_tiles;
mod relative_width;
mod tile_cache;
mod tile_grid;

use std::sync::Arc;

use crate::capture::Camera;
use crate::samples::SampleSet;
use crate::settings::RenderSettings;
pub(crate) use dense_tile::{DenseTile, MISSING, beside_edges, slopes};
pub(crate) use frame_tiles::{
    ColorIndex, FrameImages, FrameSamples, FrameTile, TileIndex, linear, samples_above,
};
pub(crate) use relative_width::{RelativeWidth, focal};
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
