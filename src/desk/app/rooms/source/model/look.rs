//! How the source view looks.

use super::picture::Overlay;
use super::picture_zoom::PictureZoom;

/// How the source view looks.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct SourceLook {
    pub camera: usize,
    pub overlay: Overlay,
    /// Sampling ratio against which camera.
    pub against: Option<usize>,
    /// The part of the picture that is shown.
    pub part: PictureZoom,
}
