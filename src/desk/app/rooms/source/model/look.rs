//! How the source view looks.

use super::picture::Overlay;
use super::picture_zoom::PictureZoom;

/// How the source view looks.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct SourceLook {
    pub camera: usize,
    /// The frame of the window in which a camera was chosen by hand; `None` before.
    pub chosen_at: Option<u64>,
    pub overlay: Overlay,
    /// Sampling ratio against which camera.
    pub against: Option<usize>,
    /// The part of the picture that is shown.
    pub part: PictureZoom,
}
