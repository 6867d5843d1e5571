//! What a painted background depends on.

use std::sync::Arc;

use crate::capture::Camera;
use crate::samples::SampleSet;
use crate::settings::RenderSettings;

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
