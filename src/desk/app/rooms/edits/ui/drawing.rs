//! Drawing in a picture to select what it shows: rectangles, lassos, strokes of a brush, and clicks on surfaces.

use std::sync::Arc;

use egui::{
    Color32, CursorIcon, Painter, PointerButton, Pos2, Rect, Response, Sense, Shape, Stroke, Ui, Vec2, pos2,
};
use glam::{DMat3, DQuat, DVec3, EulerRot};
use half::f16;

use crate::app::model::command::{Combine, EditCommand, EditTool};
use crate::app::model::{Command, Commands, State};
use crate::app::rooms::cameras::{projected, segment};
use crate::app::rooms::edits::state::last_shape;
use crate::app::theme::Tokens;
use overlook_engine::capture::Camera;
use overlook_engine::edits::{self, Action, Outline, Region, Viewpoint};

/// Points of the pointer closer together than this are one corner of a lasso.
const CORNER: f32 = 3.0;

/// Points of a stroke are at least this share of its radius apart.
const STROKE_STEP: f32 = 0.2;

/// How far from a color that is clicked on others are selected, steps of 1/255.
const NEW_TOLERANCE: f64 = 24.0;

/// Where a picture lies on the screen.
pub(crate) struct PicturePlace {
    pub(crate) corner: Pos2,
    /// Points along a pixel of the picture.
    pub(crate) scale: f32,
    /// What can be seen of it.
    pub(crate) shown: Rect,
}

impl PicturePlace {
    /// A picture whose pixels are points.
    pub(crate) fn filling(area: Rect) -> Self {
        Self { corner: area.min, scale: 1.0, shown: area }
    }

    fn pixel(&self, at: Pos2) -> [f64; 2] {
        let within = (at - self.corner) / self.scale;
        [f64::from(within.x), f64::from(within.y)]
    }

    fn on_screen(&self, [x, y]: [f64; 2]) -> Pos2 {
        self.corner + Vec2::new(x as f32, y as f32) * self.scale
    }
}

/// What was drawn, in pixels of the picture. One of both is there.
pub(crate) struct Drawn {
    pub(crate) outline: Outline,
    pub(crate) strokes: Vec<edits::Stroke>,
}

/// How what is drawn now joins the selection: as the keys say, or else as the panel says.
fn combine_now(ui: &Ui, state: &State) -> Combine {
    let modifiers = ui.input(|input| input.modifiers);
    match (modifiers.shift, modifiers.alt) {
        (true, false) => Combine::Add,
        (false, true) => Combine::Subtract,
        (true, true) => Combine::Intersect,
        (false, false) => state.doc.edits.tools.combine,
    }
}

/// Lets a person draw with the tool that is on, and selects what `region_of` makes of it.
pub(crate) fn select_drawn(
    ui: &Ui,
    response: &Response,
    painter: &Painter,
    place: &PicturePlace,
    state: &State,
    commands: &mut Commands,
    region_of: impl FnOnce(Drawn) -> Option<Region>,
) {
    let Some((drawn, is_done)) = drawing_ui(ui, response, painter, place, state) else { return };
    if let Some(region) = region_of(drawn) {
        let combine = combine_now(ui, state);
        commands.push(Command::Edit(EditCommand::Draw { region, combine, is_done }));
    }
}

/// Selects the surface or the color that is clicked on.
pub(crate) fn select_clicked(
    ui: &Ui,
    response: &Response,
    state: &State,
    commands: &mut Commands,
    region_at: impl FnOnce(Pos2) -> Option<Region>,
) {
    if response.hovered() {
        ui.ctx().set_cursor_icon(CursorIcon::Crosshair);
    }
    let clicked = response.interact_pointer_pos().filter(|_| response.clicked());
    let Some(region) = clicked.and_then(region_at) else { return };
    let combine = combine_now(ui, state);
    commands.push(Command::Edit(EditCommand::Draw { region, combine, is_done: true }));
}

/// What a click with the tool of surfaces selects at a surface point, world space.
pub(crate) fn surface_region(state: &State, point: DVec3) -> Option<Region> {
    Some(Region::same_surface(point.to_array(), state.frame_number()?))
}

/// What a click with the tool of colors selects at a linear color.
pub(crate) fn color_region(color: [f16; 3]) -> Region {
    Region::Color { linear: color.map(f64::from), tolerance: NEW_TOLERANCE }
}

/// Draws a shape while the pointer is dragged; gives what a brush has painted so far as it goes, and every shape once it is done, and
/// whether it is.
pub(crate) fn drawing_ui(
    ui: &Ui,
    response: &Response,
    painter: &Painter,
    place: &PicturePlace,
    state: &State,
) -> Option<(Drawn, bool)> {
    let tool = state.doc.edits.tools.tool?;
    let radius = state.doc.edits.tools.radius;
    if response.hovered() {
        ui.ctx().set_cursor_icon(CursorIcon::Crosshair);
    }
    let id = ui.scope_id().with("drawn in a picture");
    let mut corners: Vec<Pos2> = ui.data(|data| data.get_temp(id)).unwrap_or_default();
    let before = corners.len();
    let within = |at: Pos2| at.clamp(place.shown.min, place.shown.max);
    if response.drag_started_by(PointerButton::Primary) {
        corners = ui.ctx().input(|input| input.pointer.press_origin()).map(within).into_iter().collect();
    }
    let is_dabbed = tool.has_radius() && response.clicked_by(PointerButton::Primary);
    let is_drawn = response.dragged_by(PointerButton::Primary) || is_dabbed;
    if let Some(at) = response.interact_pointer_pos().filter(|_| is_drawn).map(within) {
        draw_to(&mut corners, at, tool, radius);
        ui.ctx().request_repaint();
    }
    let tokens = Tokens::of(state.dark);
    let painter = painter.with_clip_rect(place.shown);
    if tool.has_radius() {
        let at = response.hover_pos().or(response.interact_pointer_pos());
        brush_shape(&painter, &corners, at, radius, tokens.mark);
    } else if corners.len() > 1 {
        for (width, color) in [(3.0, Color32::from_black_alpha(140)), (1.4, tokens.mark)] {
            painter.add(Shape::closed_line(corners.clone(), Stroke::new(width, color)));
        }
    }
    let is_done = response.drag_stopped() || is_dabbed;
    let drawn = (is_done || (tool.has_radius() && corners.len() != before))
        .then(|| drawn(&corners, place, tool, radius))
        .flatten();
    if is_done {
        corners.clear();
    }
    ui.data_mut(|data| data.insert_temp(id, corners));
    Some((drawn?, is_done))
}

/// Draws on to where the pointer is.
fn draw_to(corners: &mut Vec<Pos2>, at: Pos2, tool: EditTool, radius: f32) {
    let step = if tool.has_radius() { (STROKE_STEP * radius).max(1.0) } else { CORNER };
    if tool == EditTool::Rectangle {
        let start = corners.first().copied().unwrap_or(at);
        *corners = vec![start, pos2(at.x, start.y), at, pos2(start.x, at.y)];
    } else if corners.last().is_none_or(|last| last.distance(at) >= step) {
        corners.push(at);
    }
}

/// What was drawn; `None` for an outline without an area.
fn drawn(corners: &[Pos2], place: &PicturePlace, tool: EditTool, radius: f32) -> Option<Drawn> {
    let pixels: Outline = corners.iter().map(|at| place.pixel(*at)).collect();
    if tool.has_radius() {
        let stroke = edits::Stroke { radius: f64::from(radius / place.scale), points: pixels };
        let is_drawn = !stroke.points.is_empty();
        return is_drawn.then(|| Drawn { outline: Vec::new(), strokes: vec![stroke] });
    }
    let area = Rect::from_points(corners);
    let has_area = corners.len() >= 3 && area.width() >= CORNER && area.height() >= CORNER;
    has_area.then(|| Drawn { outline: pixels, strokes: Vec::new() })
}

/// The brush, and where it went.
fn brush_shape(painter: &Painter, path: &[Pos2], at: Option<Pos2>, radius: f32, color: Color32) {
    stroke_shape(painter, path, radius, color.gamma_multiply(0.35));
    if let Some(at) = at {
        painter.circle_stroke(at, radius, Stroke::new(3.0, Color32::from_black_alpha(140)));
        painter.circle_stroke(at, radius, Stroke::new(1.4, color));
    }
}

fn stroke_shape(painter: &Painter, path: &[Pos2], radius: f32, color: Color32) {
    if let [at] = path {
        painter.circle_filled(*at, radius, color);
    } else {
        painter.add(Shape::line(path.to_vec(), Stroke::new(2.0 * radius, color)));
    }
}

/// Shows what is drawn on the picture of a camera: of the selection, and by masks that act at the frame that is shown.
pub(crate) fn drawn_areas(painter: &Painter, place: &PicturePlace, camera: &str, state: &State) {
    let painter = painter.with_clip_rect(place.shown);
    let mark = Tokens::of(state.dark).mark;
    let number = state.frame_number();
    let drawn_here = |region: &Region| matches!(region, Region::Pixels { camera: of, .. } if of == camera);
    for edit in state.doc.edits.list.acting().filter(|edit| edit.action == Action::Delete) {
        let is_now =
            edit.frames.is_none_or(|[first, last]| number.is_some_and(|at| (first..=last).contains(&at)));
        if is_now && matches!(edit.region, Region::Pixels { frame: None, .. }) {
            area_shapes(&painter, place, &drawn_here, &edit.region, Color32::from_black_alpha(150));
        }
    }
    if let Some(selection) = &state.doc.edits.selection {
        area_shapes(&painter, place, &drawn_here, selection, mark.gamma_multiply(0.35));
    }
}

/// Shows what was drawn in the live view from where it looks now, until the picture has the marks themselves.
pub(crate) fn fresh_areas(painter: &Painter, place: &PicturePlace, seen: &Camera, state: &State) {
    let Some(selection) = &state.doc.edits.selection else { return };
    let shown = state.doc.live_shown.as_ref().map(|shown| &shown.key.samples.0);
    let has_marks = |samples| state.edited_now().is_some_and(|edited| Arc::ptr_eq(&edited.shown, samples));
    if shown.is_some_and(has_marks) {
        return;
    }
    let from_here = Viewpoint::of(seen);
    let drawn_here =
        |region: &Region| matches!(region, Region::View { viewpoint, .. } if *viewpoint == from_here);
    let color = Tokens::of(state.dark).mark.gamma_multiply(0.35);
    area_shapes(&painter.with_clip_rect(place.shown), place, &drawn_here, selection, color);
}

/// Draws the areas of those parts of a region that are drawn in this picture.
fn area_shapes(
    painter: &Painter,
    place: &PicturePlace,
    is_drawn_here: &dyn Fn(&Region) -> bool,
    region: &Region,
    color: Color32,
) {
    match region {
        Region::Pixels { outline, strokes, .. } | Region::View { outline, strokes, .. }
            if is_drawn_here(region) =>
        {
            let on_screen = |points: &[[f64; 2]]| -> Vec<Pos2> {
                points.iter().map(|pixel| place.on_screen(*pixel)).collect()
            };
            if !outline.is_empty() {
                painter.add(Shape::closed_line(on_screen(outline), Stroke::new(2.0, color.to_opaque())));
            }
            for stroke in strokes {
                stroke_shape(painter, &on_screen(&stroke.points), stroke.radius as f32 * place.scale, color);
            }
        }
        Region::Any(parts) | Region::All(parts) | Region::Without(parts) => {
            for part in parts {
                area_shapes(painter, place, is_drawn_here, part, color);
            }
        }
        Region::Grow { region, .. } | Region::Shrink { region, .. } | Region::Not(region) => {
            area_shapes(painter, place, is_drawn_here, region, color);
        }
        _ => {}
    }
}

/// Side of a handle, points.
const HANDLE: f32 = 11.0;

/// Lines of a circle.
const ARCS: usize = 48;

/// A circle and a cross from the middle of a shape to its sides; handles lie at their ends.
struct ShapeFrame {
    center: DVec3,
    /// From the middle to each side, world space.
    sides: [DVec3; 3],
    is_box: bool,
}

impl ShapeFrame {
    fn of(region: &Region) -> Option<Self> {
        match region {
            Region::Box { center, half_size, rotation_degrees } => {
                let [x, y, z] = rotation_degrees.map(f64::to_radians);
                let turned = DMat3::from_quat(DQuat::from_euler(EulerRot::XYZEx, x, y, z));
                let sides = [0, 1, 2].map(|axis| turned.col(axis) * half_size[axis]);
                Some(Self { center: DVec3::from(*center), sides, is_box: true })
            }
            Region::Sphere { center, radius } => {
                let sides = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| axis * *radius);
                Some(Self { center: DVec3::from(*center), sides, is_box: false })
            }
            _ => None,
        }
    }

    /// Its lines in world space.
    fn lines(&self) -> Vec<[DVec3; 2]> {
        let [a, b, c] = self.sides;
        if self.is_box {
            let corner = |x: f64, y: f64, z: f64| self.center + a * x + b * y + c * z;
            let along = |f: &dyn Fn(f64) -> DVec3| [f(-1.0), f(1.0)];
            let signs = [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)];
            return signs
                .into_iter()
                .flat_map(|(s, t)| {
                    [along(&|u| corner(u, s, t)), along(&|u| corner(s, u, t)), along(&|u| corner(s, t, u))]
                })
                .collect();
        }
        let circle = |p: DVec3, q: DVec3| {
            let at = move |step: usize| {
                let angle = std::f64::consts::TAU * step as f64 / ARCS as f64;
                self.center + p * angle.cos() + q * angle.sin()
            };
            (0..ARCS).map(move |step| [at(step), at(step + 1)])
        };
        circle(a, b).chain(circle(b, c)).chain(circle(c, a)).collect()
    }
}

/// Draws the shape that is selected, and drags its handles; true while one is under the pointer or dragged.
pub(crate) fn shape_ui(
    ui: &Ui,
    painter: &Painter,
    canvas: Rect,
    state: &State,
    commands: &mut Commands,
) -> bool {
    let Some(mut selection) = state.doc.edits.selection.clone() else { return false };
    let Some(shape) = last_shape(&mut selection) else { return false };
    let (Some(frame), Some(vantage)) = (ShapeFrame::of(shape), state.camera_over(canvas)) else {
        return false;
    };
    let tokens = Tokens::of(state.dark);
    let painter = painter.with_clip_rect(canvas);
    let near = 1e-3 * frame.sides[0].length().max(1e-9);
    for line in frame.lines().into_iter().filter_map(|line| segment(&vantage, line, near)) {
        painter.line_segment(line, Stroke::new(3.0, Color32::from_black_alpha(120)));
        painter.line_segment(line, Stroke::new(1.4, tokens.mark));
    }
    let Some(middle) = projected(&vantage, frame.center) else { return false };
    let mut is_taken = false;
    let mut drag = |at: Pos2, name: String| {
        let area = Rect::from_center_size(at, Vec2::splat(HANDLE));
        let id = ui.scope_id().with(("edit handle", &name));
        let response = ui.interact(area.intersect(canvas), id, Sense::drag());
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, &name));
        let is_held = response.hovered() || response.dragged();
        is_taken |= is_held;
        let fill = if is_held { tokens.mark } else { tokens.on_scrim };
        let edge = Stroke::new(1.0, Color32::BLACK);
        painter.rect(area.shrink(1.5), 2.0, fill, edge, egui::StrokeKind::Outside);
        response.drag_delta()
    };
    let moved = across(&vantage, frame.center, drag(middle, "Move shape".to_owned()));
    let mut grown: Option<(usize, f64, DVec3)> = None;
    for (axis, side) in frame.sides.into_iter().enumerate() {
        for sign in [1.0, -1.0] {
            let at = projected(&vantage, frame.center + side * sign);
            let Some(at) = at.filter(|at| canvas.contains(*at)) else { continue };
            let name = format!("Drag side {}{}", if sign > 0.0 { '+' } else { '−' }, ['X', 'Y', 'Z'][axis]);
            let (dragged, on_screen) = (drag(at, name), at - middle);
            if dragged != Vec2::ZERO && on_screen.length() > 1.0 {
                // Along the side as it is seen.
                let share = dragged.dot(on_screen) / on_screen.length_sq();
                grown = Some((axis, f64::from(share), side * sign));
            }
        }
    }
    if moved == DVec3::ZERO && grown.is_none() {
        return is_taken;
    }
    reshape(shape, moved, grown);
    commands.push(Command::Edit(EditCommand::Reshape(Some(selection))));
    true
}

/// What a shift on the screen is in the world, at the depth of a point.
fn across(vantage: &Camera, point: DVec3, delta: Vec2) -> DVec3 {
    let Some((pixel, depth)) = vantage.project(point) else { return DVec3::ZERO };
    let moved = pixel + glam::DVec2::new(f64::from(delta.x), f64::from(delta.y));
    vantage.unproject(moved, depth) - vantage.unproject(pixel, depth)
}

/// Moves a shape, or one of its sides by a share of its distance from the middle. The opposite side of a box stays.
fn reshape(shape: &mut Region, moved: DVec3, grown: Option<(usize, f64, DVec3)>) {
    /// The smallest share that is left of a side in one step.
    const LEAST: f64 = 0.1;
    match shape {
        Region::Box { center, half_size, .. } => {
            let mut middle = DVec3::from(*center) + moved;
            if let Some((axis, share, side)) = grown {
                let factor = (1.0 + 0.5 * share).max(LEAST);
                half_size[axis] *= factor;
                middle += side * (factor - 1.0);
            }
            *center = middle.to_array();
        }
        Region::Sphere { center, radius } => {
            *center = (DVec3::from(*center) + moved).to_array();
            if let Some((_, share, _)) = grown {
                *radius *= (1.0 + share).max(LEAST);
            }
        }
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_drawn_on_a_magnified_picture_is_in_its_pixels() {
        let place = PicturePlace {
            corner: pos2(10.0, 20.0),
            scale: 4.0,
            shown: Rect::from_min_max(pos2(10.0, 20.0), pos2(410.0, 320.0)),
        };
        let mut corners = Vec::new();
        for at in [pos2(50.0, 60.0), pos2(50.5, 60.0), pos2(90.0, 60.0)] {
            draw_to(&mut corners, at, EditTool::Brush, 8.0);
        }
        let stroke = drawn(&corners, &place, EditTool::Brush, 8.0).unwrap().strokes.remove(0);
        assert_eq!((stroke.radius, stroke.points), (2.0, vec![[10.0, 10.0], [20.0, 10.0]]));
        corners.clear();
        for at in [pos2(50.0, 60.0), pos2(90.0, 100.0)] {
            draw_to(&mut corners, at, EditTool::Rectangle, 8.0);
        }
        let outline = drawn(&corners, &place, EditTool::Rectangle, 8.0).unwrap().outline;
        assert_eq!(outline, [[10.0, 10.0], [20.0, 10.0], [20.0, 20.0], [10.0, 20.0]]);
        assert!(drawn(&corners[..2], &place, EditTool::Lasso, 8.0).is_none(), "a line has no area");
    }
}
