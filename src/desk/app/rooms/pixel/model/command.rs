//! What concerns the selected pixel.

use super::pixel::Spot;

/// What concerns the selected pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum PixelCommand {
    /// Point at a pixel, or at nothing.
    Probe(Option<Spot>),
    /// Pin the selected pixel, or unpin it.
    Pin(bool),
    /// Show the selected point in a camera's picture.
    ShowPointIn(usize),
    CopyExplanation,
}
