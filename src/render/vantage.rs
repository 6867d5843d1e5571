//! What goes into a renderer and what comes out.

use crate::capture::Camera;
use crate::grid::Grid;

/// Where from, and when.
#[derive(Clone, Debug, PartialEq)]
pub struct Vantage {
    /// The virtual camera.
    pub camera: Camera,
    /// Index of the frame.
    pub frame: usize,
}

/// Marks a pixel that no sample reached, in [`Picture::image`].
pub const NO_IMAGE: u32 = u32::MAX;

/// A rendered vantage.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Linear Rec.709; black in holes.
    pub color: Grid<[f32; 3]>,
    /// Reciprocal of planar z of the nearest sample; 0 at infinity, negative in holes.
    pub inverse_depth: Grid<f32>,
    /// Index in `SampleSet::images` of the image whose sample is nearest; [`NO_IMAGE`] in holes.
    pub image: Grid<u32>,
}

impl Picture {
    /// Pixels that no sample reached.
    #[must_use]
    pub fn holes(&self) -> u64 {
        self.image.as_slice().iter().filter(|image| **image == NO_IMAGE).count() as u64
    }
}

/// What it took to render a vantage.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RenderStats {
    /// Samples that were projected.
    pub samples: u64,
    /// Pixels that no sample reached.
    pub holes: u64,
    /// Wall-clock milliseconds.
    pub milliseconds: f64,
    /// Whether the background was taken from the cache instead of being painted.
    pub background_reused: bool,
}
