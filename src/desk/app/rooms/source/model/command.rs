//! What concerns the source view.

use super::picture::Overlay;
use super::picture_zoom::PictureZoom;

/// What concerns the source view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum SourceCommand {
    /// Show another camera on the left.
    Camera(usize),
    Overlay(Overlay),
    /// Compare sampling rates with this camera, or the best other.
    Against(Option<usize>),
    Zoom(PictureZoom),
    /// Show one camera alone in its color where colors are those of cameras, or all of them.
    Isolate(Option<usize>),
}
