//! Shapes of edits over the live view: the box or sphere that is selected, with handles to drag.

use egui::{Color32, Painter, Pos2, Rect, Sense, Stroke, Ui, Vec2};
use glam::{DAffine3, DMat3, DQuat, DVec3, EulerRot};

use crate::app::model::{Command, Commands, State};
use crate::app::rooms::cameras::ui::overlays::{clipped, projected};
use crate::app::rooms::edits::model::{EditCommand, last_shape};
use crate::app::theme::Tokens;
use overlook_engine::capture::Camera;
use overlook_engine::edits::Region;

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

/// Where a point of the world lies in the live view.
fn place(canvas: Rect, vantage: &Camera, camera_from_world: &DAffine3, point: DVec3) -> Option<Pos2> {
    let at = projected(vantage, camera_from_world.transform_point3(point))?;
    Some(canvas.min + at.to_vec2())
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
    let size = [canvas.width() as u32, canvas.height() as u32];
    let (Some(frame), Some(vantage)) = (ShapeFrame::of(shape), state.seen_camera(size)) else { return false };
    let tokens = Tokens::of(state.dark);
    let painter = painter.with_clip_rect(canvas);
    let camera_from_world = vantage.camera_from_world();
    let near = 1e-3 * frame.sides[0].length().max(1e-9);
    for [a, b] in frame.lines() {
        let ends = [a, b].map(|point| camera_from_world.transform_point3(point));
        let Some([a, b]) = clipped(ends, near) else { continue };
        let (Some(a), Some(b)) = (projected(&vantage, a), projected(&vantage, b)) else { continue };
        let line = [canvas.min + a.to_vec2(), canvas.min + b.to_vec2()];
        painter.line_segment(line, Stroke::new(3.0, Color32::from_black_alpha(120)));
        painter.line_segment(line, Stroke::new(1.4, tokens.mark));
    }
    let mut is_taken = false;
    let Some(middle) = place(canvas, &vantage, &camera_from_world, frame.center) else { return false };
    let handle = |at: Pos2, name: &str| {
        let area = Rect::from_center_size(at, Vec2::splat(HANDLE));
        let response =
            ui.interact(area.intersect(canvas), ui.scope_id().with(("edit handle", name)), Sense::drag());
        let name = name.to_owned();
        response.widget_info(move || egui::WidgetInfo::labeled(egui::Role::Button, true, name.clone()));
        let fill = if response.hovered() || response.dragged() { tokens.mark } else { tokens.on_scrim };
        painter.rect(
            area.shrink(1.5),
            2.0,
            fill,
            Stroke::new(1.0, Color32::BLACK),
            egui::StrokeKind::Outside,
        );
        response
    };
    let mut moved = DVec3::ZERO;
    let response = handle(middle, "Move shape");
    is_taken |= response.hovered() || response.dragged();
    if response.dragged() {
        moved = across(&vantage, frame.center, response.drag_delta());
    }
    let mut grown: Option<(usize, f64, DVec3)> = None;
    for (axis, side) in frame.sides.into_iter().enumerate() {
        for sign in [1.0, -1.0] {
            let Some(at) = place(canvas, &vantage, &camera_from_world, frame.center + side * sign) else {
                continue;
            };
            if !canvas.contains(at) {
                continue;
            }
            let name = format!("Drag side {}{}", if sign > 0.0 { '+' } else { '−' }, ['X', 'Y', 'Z'][axis]);
            let response = handle(at, &name);
            is_taken |= response.hovered() || response.dragged();
            let on_screen = at - middle;
            if response.dragged() && on_screen.length() > 1.0 {
                // Along the side as it is seen.
                let share = response.drag_delta().dot(on_screen) / on_screen.length_sq();
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
    fn a_side_of_a_box_is_dragged_while_the_opposite_one_stays() {
        let mut shape =
            Region::Box { center: [1.0, 0.0, 0.0], half_size: [1.0, 2.0, 3.0], rotation_degrees: [0.0; 3] };
        reshape(&mut shape, DVec3::ZERO, Some((0, 1.0, DVec3::X)));
        let Region::Box { center, half_size, .. } = &shape else { panic!("a box") };
        assert_eq!((center, half_size), (&[1.5, 0.0, 0.0], &[1.5, 2.0, 3.0]));
        assert_eq!(ShapeFrame::of(&shape).unwrap().lines().len(), 12);
    }
}
