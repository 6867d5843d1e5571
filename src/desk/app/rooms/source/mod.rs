//! The source view: what a camera recorded, with what was decided about its pixels.

mod control;
pub(crate) mod ui;
pub(crate) mod work;

use crate::app::model::picture::{Overlay, PictureZoom};

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
