//! What the live picture shows at a place of the window.

use std::sync::Arc;

use egui::Rect;
use half::f16;

use crate::app::model::State;
use overlook_engine::render::Picture;
use overlook_engine::render::output::pick;

/// Whether the live picture shows nothing nearer than this depth at a place; `None` where that is not known.
pub(crate) fn is_seen(state: &State, canvas: Rect, at: egui::Pos2, depth: f64) -> Option<bool> {
    inverse_depth_at(state, canvas, at).map(|inverse_depth| inverse_depth * depth <= 1.0)
}

/// Inverse depth of the live picture at a place; negative in holes, `None` where its pixels cannot be read.
pub(crate) fn inverse_depth_at(state: &State, canvas: Rect, at: egui::Pos2) -> Option<f64> {
    let depth = state.live_seen()?.inverse_depth?;
    place_in(depth.size(), canvas, at).map(|place| f64::from(depth[place]))
}

/// The live picture that was painted last, and its column and row at a place.
pub(crate) fn pixel_at(state: &State, canvas: Rect, at: egui::Pos2) -> Option<(&Picture, (usize, usize))> {
    let picture = state.doc.live_shown.as_ref()?.picture.rendered()?;
    place_in(picture.image.size(), canvas, at).map(|place| (picture.as_ref(), place))
}

/// The linear color of the sample that the live picture shows at a place, as it is where no selection is shown.
pub(crate) fn color_under(state: &State, canvas: Rect, at: egui::Pos2) -> Option<[f16; 3]> {
    let shown = state.doc.live_shown.as_ref().filter(|_| state.doc.live_carried.is_none())?;
    let (picture, (x, y)) = pixel_at(state, canvas, at)?;
    let picked = pick(&shown.picture.samples, &shown.key.vantage, picture, x, y)?;
    let edited = state.edited().filter(|edited| Arc::ptr_eq(&edited.shown, &shown.key.samples));
    let samples = edited.map_or(&shown.picture.samples, |edited| &edited.samples);
    samples.images.get(picked.image)?.color.get(picked.index).copied()
}

/// Column and row of a picture over the canvas at a place; `None` outside.
fn place_in((width, height): (usize, usize), canvas: Rect, at: egui::Pos2) -> Option<(usize, usize)> {
    let share = (at - canvas.min) / canvas.size();
    let place = ((share.x * width as f32) as usize, (share.y * height as f32) as usize);
    (share.min_elem() >= 0.0 && place.0 < width && place.1 < height).then_some(place)
}
