//! The cameras: how they are named, listed and drawn.

pub(crate) mod ui;

use egui::{Color32, Painter, Pos2, Rect, Response, Stroke, pos2, vec2};
use glam::{DVec2, DVec3};

use crate::app::model::command::{SourceCommand, ViewCommand};
use crate::app::model::{Command, Commands, State};
use crate::app::theme::Tokens;
use overlook_engine::capture::Camera;

/// Depth at which lines are cut off, as a share of a pyramid's length: scenes are in millimeters as well as in meters.
const NEAR: f64 = 1e-3;

/// A camera as it is drawn: the picture of an orthographic one may be as large as the scene, and is drawn as small as those of others.
pub(crate) fn as_drawn(camera: &Camera) -> Camera {
    let lens = camera.intrinsics;
    Camera { intrinsics: lens.in_perspective_from(lens.depth_scale(1.0)), ..camera.clone() }
}

/// The edges of the pyramid of `camera`, `length` deep, in the pixels of `vantage`; of an orthographic camera those of a box.
pub(crate) fn frustum(camera: &Camera, vantage: &Camera, length: f64) -> Vec<[Pos2; 2]> {
    let (width, height) = (f64::from(camera.intrinsics.width), f64::from(camera.intrinsics.height));
    let drawn = as_drawn(camera);
    let corners = [(0.0, 0.0), (width, 0.0), (width, height), (0.0, height)]
        .map(|(x, y)| drawn.unproject(DVec2::new(x, y), length));
    let apex = camera.position_in_world();
    let is_box = camera.intrinsics.is_orthographic();
    let back = corners.map(|corner| if is_box { corner - length * camera.forward_in_world() } else { apex });
    let edges = (0..4).flat_map(|i| {
        let next = (i + 1) % 4;
        let behind = is_box.then_some([back[i], back[next]]);
        [[back[i], corners[i]], [corners[i], corners[next]]].into_iter().chain(behind)
    });
    edges.filter_map(|edge| segment(vantage, edge, NEAR * length)).collect()
}

/// Where a camera shows a point of the world, in its pixels; `None` behind it.
pub(crate) fn projected(vantage: &Camera, point_in_world: DVec3) -> Option<Pos2> {
    vantage.project(point_in_world).map(|(pixel, _)| pos2(pixel.x as f32, pixel.y as f32))
}

/// Where a camera shows a segment in world space, in its pixels; without what is nearer than `near`.
pub(crate) fn segment(vantage: &Camera, ends: [DVec3; 2], near: f64) -> Option<[Pos2; 2]> {
    let camera_from_world = vantage.camera_from_world();
    let ends = clipped(ends.map(|end| camera_from_world.transform_point3(end)), near)?;
    let [start, end] = ends.map(|end| vantage.intrinsics.project(end));
    start.zip(end).map(|(start, end)| [start, end].map(|pixel| pos2(pixel.x as f32, pixel.y as f32)))
}

/// The part of a segment in camera space that lies before the camera, no nearer than `near`.
fn clipped([a, b]: [DVec3; 2], near: f64) -> Option<[DVec3; 2]> {
    let cut = |inside: DVec3, outside: DVec3| {
        let share = (inside.z - near) / (inside.z - outside.z);
        inside + (outside - inside) * share
    };
    match (a.z >= near, b.z >= near) {
        (true, true) => Some([a, b]),
        (true, false) => Some([a, cut(a, b)]),
        (false, true) => Some([cut(b, a), b]),
        (false, false) => None,
    }
}

/// A ring with a cross through it for a point that is seen, an empty ring for one that is not.
pub(crate) fn mark(painter: &Painter, at: Pos2, sees: bool, pinned: bool, tokens: &Tokens) {
    if !painter.clip_rect().contains(at) {
        return;
    }
    let radius = if pinned { 7.0 } else { 6.0 };
    let color = if sees { tokens.mark } else { tokens.on_scrim };
    for (width, color) in [(4.0, Color32::from_black_alpha(170)), (if sees { 2.0 } else { 1.2 }, color)] {
        let stroke = Stroke::new(width, color);
        painter.circle_stroke(at, radius, stroke);
        if sees {
            for direction in [vec2(1.0, 0.0), vec2(-1.0, 0.0), vec2(0.0, 1.0), vec2(0.0, -1.0)] {
                painter.line_segment([at + direction * radius, at + direction * (radius + 5.0)], stroke);
            }
        }
    }
}

/// Marks the selected point where the picture of a camera, over an area, shows it.
pub(crate) fn mark_probe(painter: &Painter, picture: Rect, state: &State, camera: usize) {
    let probe = &state.doc.probe;
    let Some((scene, probed)) = state.doc.scene.as_ref().zip(probe.shown.as_ref()) else { return };
    let Some((at, sees)) = probed.in_camera(&scene.cameras, camera) else { return };
    let (columns, rows) = scene.cameras[camera].intrinsics.size();
    let at = picture.min + at.to_vec2() * picture.size() / vec2(columns as f32, rows as f32);
    mark(painter, at, sees, probe.pinned, Tokens::of(state.dark));
}

/// A click on what stands for a camera chooses it, a double-click views from it.
fn answer_clicks(response: &Response, camera: usize, commands: &mut Commands) {
    if response.double_clicked() {
        commands.push(Command::View(ViewCommand::JumpTo(camera)));
    } else if response.clicked() {
        commands.push(Command::Source(SourceCommand::Camera(camera)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use overlook_engine::capture::Intrinsics;

    fn camera(eye: DVec3, target: DVec3) -> Camera {
        Camera::look_at("c", Intrinsics::from_horizontal_angle(100, 100, 1.0), eye, target, DVec3::Z)
    }

    #[test]
    fn a_camera_in_view_has_eight_edges_in_a_scene_of_any_unit_and_one_behind_has_none() {
        for unit in [1e-6, 1.0, 1e6] {
            let vantage = camera(DVec3::new(0.0, -10.0, 0.0) * unit, DVec3::ZERO);
            let seen =
                |eye: DVec3, target: DVec3| frustum(&camera(eye * unit, target * unit), &vantage, unit);
            assert_eq!(seen(DVec3::ZERO, DVec3::X).len(), 8, "{unit}");
            let behind = seen(DVec3::new(0.0, -20.0, 0.0), DVec3::new(0.0, -30.0, 0.0));
            assert!(behind.is_empty(), "{unit}");
        }
    }

    #[test]
    fn an_orthographic_camera_is_a_box_that_is_no_larger_than_the_pyramids_of_others() {
        let vantage = camera(DVec3::new(0.0, -10.0, 0.0), DVec3::ZERO);
        let lens = Intrinsics::orthographic(100, 100, 40.0);
        let large = Camera { intrinsics: lens, ..camera(DVec3::ZERO, DVec3::X) };
        let seen = frustum(&large, &vantage, 1.0);
        assert_eq!(seen.len(), 12);
        let far = seen.iter().flatten().map(|end| (*end - pos2(50.0, 50.0)).length());
        assert!(far.fold(0.0, f32::max) < 15.0);
    }

    #[test]
    fn an_edge_that_passes_the_eye_is_cut_off_before_it() {
        let cut = clipped([DVec3::new(0.0, 0.0, 1.0), DVec3::new(0.0, 1.0, -1.0)], 0.01).unwrap();
        assert!((cut[1].z - 0.01).abs() < 1e-9);
    }
}
