//! The cameras: how they are named, listed and drawn.

pub(crate) mod ui;

use egui::{Color32, Painter, Pos2, Stroke, pos2, vec2};
use glam::{DVec2, DVec3};

use crate::app::theme::Tokens;
use overlook_engine::capture::Camera;

/// Depth at which lines are cut off, as a share of a pyramid's length: scenes are in millimeters as well as in meters.
const NEAR: f64 = 1e-3;

/// A camera's pyramid as line segments in the live picture's pixels, and where its name belongs.
pub(crate) struct Frustum {
    pub lines: Vec<[Pos2; 2]>,
    /// The apex, where it is in view.
    pub apex: Option<Pos2>,
}

/// A camera as it is drawn: the picture of an orthographic one may be as large as the scene, and is drawn as small as those of others.
pub(crate) fn as_drawn(camera: &Camera) -> Camera {
    let lens = camera.intrinsics;
    Camera { intrinsics: lens.in_perspective_from(lens.depth_scale(1.0)), ..camera.clone() }
}

/// The pyramid of `camera`, `length` deep, as `vantage` sees it; of an orthographic camera a box.
pub(crate) fn frustum(camera: &Camera, vantage: &Camera, length: f64) -> Frustum {
    let (width, height) = (f64::from(camera.intrinsics.width), f64::from(camera.intrinsics.height));
    let drawn = as_drawn(camera);
    let corners = [(0.0, 0.0), (width, 0.0), (width, height), (0.0, height)]
        .map(|(x, y)| drawn.unproject(DVec2::new(x, y), length));
    let apex = camera.position_in_world();
    let is_box = camera.intrinsics.is_orthographic();
    let back = corners.map(|corner| if is_box { corner - length * camera.forward_in_world() } else { apex });
    let camera_from_world = vantage.camera_from_world();
    let mut lines = Vec::with_capacity(8);
    for i in 0..4 {
        let next = (i + 1) % 4;
        let behind = is_box.then_some((back[i], back[next]));
        for (a, b) in [(back[i], corners[i]), (corners[i], corners[next])].into_iter().chain(behind) {
            let ends = [a, b].map(|point| camera_from_world.transform_point3(point));
            if let Some([a, b]) = clipped(ends, NEAR * length) {
                lines.extend(projected(vantage, a).zip(projected(vantage, b)).map(|(a, b)| [a, b]));
            }
        }
    }
    Frustum { lines, apex: projected(vantage, camera_from_world.transform_point3(apex)) }
}

pub(crate) fn projected(vantage: &Camera, point_in_camera: DVec3) -> Option<Pos2> {
    vantage.intrinsics.project(point_in_camera).map(|pixel| pos2(pixel.x as f32, pixel.y as f32))
}

/// The part of a segment in camera space that lies before the camera, no nearer than `near`.
pub(crate) fn clipped([a, b]: [DVec3; 2], near: f64) -> Option<[DVec3; 2]> {
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

#[cfg(test)]
mod tests {
    use super::*;
    use overlook_engine::capture::Intrinsics;

    fn camera(eye: DVec3, target: DVec3) -> Camera {
        Camera::look_at("c", Intrinsics::from_horizontal_angle(100, 100, 1.0), eye, target, DVec3::Z)
    }

    #[test]
    fn a_camera_in_view_has_eight_edges_and_one_behind_has_none() {
        let vantage = camera(DVec3::new(0.0, -10.0, 0.0), DVec3::ZERO);
        let seen = frustum(&camera(DVec3::ZERO, DVec3::X), &vantage, 1.0);
        assert_eq!(seen.lines.len(), 8);
        assert!((seen.apex.unwrap() - pos2(50.0, 50.0)).length() < 1e-3);
        let behind =
            frustum(&camera(DVec3::new(0.0, -20.0, 0.0), DVec3::new(0.0, -30.0, 0.0)), &vantage, 1.0);
        assert!(behind.lines.is_empty() && behind.apex.is_none());
    }

    #[test]
    fn an_orthographic_camera_is_a_box_that_is_no_larger_than_the_pyramids_of_others() {
        let vantage = camera(DVec3::new(0.0, -10.0, 0.0), DVec3::ZERO);
        let lens = Intrinsics::orthographic(100, 100, 40.0);
        let large = Camera { intrinsics: lens, ..camera(DVec3::ZERO, DVec3::X) };
        let seen = frustum(&large, &vantage, 1.0);
        assert_eq!(seen.lines.len(), 12);
        let far = seen.lines.iter().flatten().map(|end| (*end - pos2(50.0, 50.0)).length());
        assert!(far.fold(0.0, f32::max) < 15.0);
    }

    #[test]
    fn an_edge_that_passes_the_eye_is_cut_off_before_it() {
        let cut = clipped([DVec3::new(0.0, 0.0, 1.0), DVec3::new(0.0, 1.0, -1.0)], 0.01).unwrap();
        assert!((cut[1].z - 0.01).abs() < 1e-9);
    }

    #[test]
    fn cameras_are_drawn_in_a_scene_of_any_unit() {
        for unit in [1e-6, 1e6] {
            let vantage = camera(DVec3::new(0.0, -10.0, 0.0) * unit, DVec3::ZERO);
            let seen = frustum(&camera(DVec3::ZERO, DVec3::X * unit), &vantage, unit);
            assert_eq!(seen.lines.len(), 8, "{unit}");
        }
    }
}
