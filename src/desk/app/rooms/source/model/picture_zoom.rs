//! The part of a picture that a view shows, and its magnification.

use egui::{Rect, Vec2};

/// Largest magnification.
const MOST: f32 = 64.0;

/// The part of a picture that a view shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PictureZoom {
    /// Magnification beyond fitting the view, 1 to 64.
    pub zoom: f32,
    /// The picture's point in the middle of the view, as shares of its size.
    pub center: Vec2,
}

impl Default for PictureZoom {
    /// The whole picture.
    fn default() -> Self {
        Self { zoom: 1.0, center: Vec2::splat(0.5) }
    }
}

impl PictureZoom {
    /// Magnified by `zoom` about `center`, as far as that is possible.
    pub(crate) fn new(zoom: f32, center: Vec2) -> Self {
        Self { zoom: zoom.clamp(1.0, MOST), center: center.clamp(Vec2::ZERO, Vec2::splat(1.0)) }
    }

    /// The area of a picture of `size` in the view `canvas`.
    pub(crate) fn placed(self, size: Vec2, canvas: Rect) -> Rect {
        let drawn = size * (canvas.width() / size.x).min(canvas.height() / size.y) * self.zoom;
        Rect::from_min_size(canvas.center() - drawn * self.center, drawn)
    }

    /// Shifted by shares of the picture's size, where it does not fit the view.
    #[must_use]
    pub(crate) fn shifted(self, share: Vec2) -> Self {
        if self.zoom > 1.0 { Self::new(self.zoom, self.center - share) } else { self }
    }

    /// Zoomed by the wheel: the point at `at`, as shares of the picture's size, stays under the pointer.
    #[must_use]
    pub(crate) fn scrolled(self, scroll: f32, at: Vec2) -> Self {
        let zoom = (self.zoom * (scroll * 0.005).exp()).clamp(1.0, MOST);
        if zoom <= 1.0 {
            Self::default()
        } else {
            Self::new(zoom, at - (at - self.center) * (self.zoom / zoom))
        }
    }
}
