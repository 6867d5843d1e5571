//! Guides over the live view: the frame of a picture, the ground, the world's axes, and a measured distance.

use std::sync::Arc;

use egui::{Align2, Color32, Painter, Pos2, Rect, Sense, Stroke, Ui, Vec2, pos2, vec2};
use glam::DVec3;
use half::f16;

use crate::app::model::camera::OrbitCamera;
use crate::app::model::command::ViewCommand;
use crate::app::model::look::FrameGuide;
use crate::app::model::picture::PictureZoom;
use crate::app::model::{Command, Commands, State};
use crate::app::rooms::cameras::{projected, segment};
use crate::app::theme::Tokens;
use crate::app::widgets::plate;
use overlook_engine::capture::Camera;
use overlook_engine::render::Picture;
use overlook_engine::render::output::pick;

/// Length of the axes on the screen, points.
const AXIS: f32 = 30.0;

/// Height of a live view from which on the axes have that length, points; in a lower one they are shorter.
const ROOM_OF_AXES: f32 = 300.0;

/// Shortest axes, as a share of that length.
const SHORTEST_AXES: f32 = 0.6;

/// Offset of the axes' middle from the corner.
const FROM_CORNER: Vec2 = vec2(46.0, -46.0);

/// Lines of the ground on either side of its middle.
const LINES: i32 = 12;

/// Parts of a line of the ground; each is drawn in front of the picture or behind it.
const PARTS: i32 = 24;

/// Nearest part of a line that is drawn, in pivot distances.
const NEAR: f64 = 1e-3;

/// The part of the live view that its picture fills: all of it, or the largest part of the shape of the frame.
pub(crate) fn picture_area(canvas: Rect, state: &State) -> Rect {
    if state.live.guides.locks_aspect { framed_area(canvas, state) } else { canvas }
}

/// The largest part of an area that has the shape of the frame: what a picture of that shape shows.
fn framed_area(area: Rect, state: &State) -> Rect {
    let Some([width, height]) = state.framed_size().map(|size| size.map(|side| side as f32)) else {
        return area;
    };
    PictureZoom::default().placed(vec2(width, height), area)
}

/// Draws the guides, and looks along the axis that is clicked.
pub(crate) fn guides_ui(
    ui: &mut Ui,
    painter: &Painter,
    canvas: Rect,
    state: &State,
    commands: &mut Commands,
) {
    let (Some(orbit), Some(vantage)) = (&state.live.orbit, state.camera_over(canvas)) else { return };
    if state.live.guides.grid {
        ground(painter, canvas, state, orbit, &vantage);
    }
    frame(painter, canvas, state);
    ruler(painter, canvas, state, &vantage);
    if state.live.guides.axes {
        axes_ui(ui, painter, canvas, &vantage, commands);
    }
}

/// Darkens everything outside the frame.
fn frame(painter: &Painter, canvas: Rect, state: &State) {
    let is_on = state.live.guides.frame != FrameGuide::Off;
    let Some([width, height]) = state.framed_size().filter(|_| is_on) else { return };
    let frame = framed_area(canvas, state);
    let shade = Color32::from_black_alpha(140);
    for outside in [
        Rect::from_min_max(canvas.min, pos2(canvas.right(), frame.top())),
        Rect::from_min_max(pos2(canvas.left(), frame.bottom()), canvas.max),
        Rect::from_min_max(pos2(canvas.left(), frame.top()), frame.left_bottom()),
        Rect::from_min_max(frame.right_top(), pos2(canvas.right(), frame.bottom())),
    ] {
        if outside.is_positive() {
            painter.rect_filled(outside, 0.0, shade);
        }
    }
    let tokens = Tokens::of(state.dark);
    painter.rect_stroke(frame, 0.0, Stroke::new(1.0, tokens.on_scrim), egui::StrokeKind::Inside);
    plate(painter, frame.left_top() + vec2(8.0, 8.0), Align2::LEFT_TOP, &format!("{width}×{height}"), tokens);
}

/// Distance between lines of the ground: the power of ten that suits how far away the pivot is.
fn spacing(pivot_distance: f64) -> f64 {
    10.0_f64.powf((pivot_distance * 0.4).log10().floor())
}

/// Lines of the ground at the height of the world's origin, below the pivot; faint where the picture is in front of them.
fn ground(painter: &Painter, canvas: Rect, state: &State, orbit: &OrbitCamera, vantage: &Camera) {
    let up = orbit.up_in_world;
    let (a, b) = if up == DVec3::Z { (DVec3::X, DVec3::Y) } else { up.any_orthonormal_pair() };
    let step = spacing(orbit.pivot_distance);
    let pivot = orbit.world_from_camera.transform_point3(DVec3::Z * orbit.pivot_distance);
    let [at_a, at_b] = [a, b].map(|axis| (pivot.dot(axis) / step).round() * step);
    let tokens = Tokens::of(state.dark);
    let is_hidden = |[start, end]: [DVec3; 2]| {
        let (pixel, depth) = vantage.project(start.midpoint(end))?;
        let inverse_depth = inverse_depth_at(state, canvas, pos2(pixel.x as f32, pixel.y as f32))?;
        // The picture may show the ground itself, which then must not hide its lines.
        Some(inverse_depth * depth * 0.97 > 1.0)
    };
    let reach = f64::from(LINES) * step;
    for (along, across, from, at) in [(a, b, at_a, at_b), (b, a, at_b, at_a)] {
        for line in -LINES..=LINES {
            let place = at + f64::from(line) * step;
            let is_axis = place.abs() < step * 1e-6;
            let color = if is_axis { Tokens::axis_of(along) } else { tokens.on_scrim };
            for part in 0..PARTS {
                let ends = [part, part + 1].map(|part| {
                    let share = f64::from(part) / f64::from(PARTS) * 2.0 - 1.0;
                    along * (from + share * reach) + across * place
                });
                let fade = fade(line, part);
                let seen = segment(vantage, ends, NEAR * orbit.pivot_distance);
                let Some(seen) = seen.filter(|_| fade > 0.0) else { continue };
                let strength = fade * if is_hidden(ends) == Some(true) { 0.07 } else { 0.5 };
                painter.line_segment(seen, Stroke::new(1.0, color.gamma_multiply(strength)));
            }
        }
    }
    let text = format!("grid {}", state.live.unit.length(step));
    plate(painter, canvas.right_bottom() + vec2(-8.0, -8.0), Align2::RIGHT_BOTTOM, &text, tokens);
}

/// How strong a part of a line is: 1 in the middle of the ground, 0 at its edge.
fn fade(line: i32, part: i32) -> f32 {
    let across = line as f32 / LINES as f32;
    let along = (part as f32 + 0.5) / PARTS as f32 * 2.0 - 1.0;
    (1.0 - across.hypot(along)).clamp(0.0, 1.0)
}

/// The distance that is measured, between its points.
fn ruler(painter: &Painter, canvas: Rect, state: &State, vantage: &Camera) {
    let ruler = &state.live.ruler;
    let tokens = Tokens::of(state.dark);
    let places: Vec<Pos2> = ruler.points.iter().filter_map(|point| projected(vantage, *point)).collect();
    if let (Some(distance), [a, b]) = (ruler.distance(), places.as_slice()) {
        for (width, color) in [(4.0, Color32::from_black_alpha(170)), (2.0, tokens.mark)] {
            painter.line_segment([*a, *b], Stroke::new(width, color));
        }
        let text = state.live.unit.length(distance);
        plate(painter, a.lerp(*b, 0.5) + vec2(0.0, -10.0), Align2::CENTER_BOTTOM, &text, tokens);
    }
    for place in &places {
        painter.circle(*place, 4.0, tokens.mark, Stroke::new(1.5, Color32::from_black_alpha(200)));
    }
    if ruler.active {
        let text = match ruler.points.len() {
            0 => "Click the first point to measure from (M ends)",
            1 => "Click the second point",
            _ => "Click to measure anew (M ends)",
        };
        plate(painter, canvas.center_top() + vec2(0.0, 8.0), Align2::CENTER_TOP, text, tokens);
    }
}

/// The directions of the world's axes; a click on an end looks along it.
fn axes_ui(ui: &mut Ui, painter: &Painter, canvas: Rect, vantage: &Camera, commands: &mut Commands) {
    let tokens = Tokens::in_ui(ui);
    let scale = (canvas.height() / ROOM_OF_AXES).clamp(SHORTEST_AXES, 1.0);
    let middle = canvas.left_bottom() + FROM_CORNER * scale;
    let camera_from_world = vantage.world_from_camera.matrix3.transpose();
    let ends = [(DVec3::X, ["X", "−X"]), (DVec3::Y, ["Y", "−Y"]), (DVec3::Z, ["Z", "−Z"])];
    let ends = ends.into_iter().flat_map(|(axis, [name, opposite])| [(axis, name), (-axis, opposite)]);
    let mut ends: Vec<_> = ends.map(|(axis, name)| (camera_from_world * axis, axis, name)).collect();
    ends.sort_by(|a, b| b.0.z.total_cmp(&a.0.z));
    painter.circle_filled(middle, (AXIS + 12.0) * scale, tokens.scrim.gamma_multiply(0.6));
    for (direction, axis, name) in ends {
        let end = middle + vec2(direction.x as f32, direction.y as f32) * AXIS * scale;
        let color = Tokens::axis_of(axis);
        let is_positive = name.len() == 1;
        let area = Rect::from_center_size(end, Vec2::splat(scale * if is_positive { 16.0 } else { 12.0 }));
        let response = ui.interact(area, ui.scope_id().with(("axis", name)), Sense::click());
        response
            .widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, format!("View from {name}")));
        if is_positive {
            painter.line_segment([middle, end], Stroke::new(2.0, color));
            painter.circle_filled(end, 8.0 * scale, color);
            let font = egui::FontId::proportional(11.0 * scale.max(0.8));
            painter.text(end, Align2::CENTER_CENTER, name, font, Color32::BLACK);
        } else {
            let fill = if response.hovered() { color } else { color.gamma_multiply(0.35) };
            painter.circle(end, 5.0 * scale, fill, Stroke::new(1.0, color));
        }
        if response.on_hover_text(format!("View from {name}")).clicked() {
            commands.push(Command::View(ViewCommand::LookAlong(-axis)));
        }
    }
}

/// Inverse depth of the live picture at a place; negative in holes, `None` where its pixels cannot be read.
pub(crate) fn inverse_depth_at(state: &State, canvas: Rect, at: Pos2) -> Option<f64> {
    let depth = state.live_seen()?.inverse_depth?;
    place_in(depth.size(), canvas, at).map(|place| f64::from(depth[place]))
}

/// The live picture that was painted last, and its column and row at a place.
pub(crate) fn pixel_at(state: &State, canvas: Rect, at: Pos2) -> Option<(&Picture, (usize, usize))> {
    let picture = state.doc.live_shown.as_ref()?.picture.rendered()?;
    place_in(picture.image.size(), canvas, at).map(|place| (picture.as_ref(), place))
}

/// The linear color of the sample that the live picture shows at a place, as it is where no selection is shown.
pub(crate) fn color_under(state: &State, canvas: Rect, at: Pos2) -> Option<[f16; 3]> {
    let shown = state.doc.live_shown.as_ref().filter(|_| state.doc.live_carried.is_none())?;
    let (picture, (x, y)) = pixel_at(state, canvas, at)?;
    let picked = pick(&shown.picture.samples, &shown.key.vantage, picture, x, y)?;
    let edited = state.edited().filter(|edited| Arc::ptr_eq(&edited.shown, &shown.key.samples));
    let samples = edited.map_or(&shown.picture.samples, |edited| &edited.samples);
    samples.images.get(picked.image)?.color.get(picked.index).copied()
}

/// Column and row of a picture over the canvas at a place; `None` outside.
pub(crate) fn place_in((width, height): (usize, usize), canvas: Rect, at: Pos2) -> Option<(usize, usize)> {
    let share = (at - canvas.min) / canvas.size();
    let place = ((share.x * width as f32) as usize, (share.y * height as f32) as usize);
    (share.min_elem() >= 0.0 && place.0 < width && place.1 < height).then_some(place)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ground_has_a_line_for_each_power_of_ten_that_suits_the_distance() {
        for (distance, expected) in [(1.0, 0.1), (5.0, 1.0), (30.0, 10.0), (2.5e-6, 1e-6)] {
            assert!((spacing(distance) / expected - 1.0).abs() < 1e-9, "{distance}: {}", spacing(distance));
        }
    }
}
