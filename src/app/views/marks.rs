//! The pixel that is looked at, marked in every view that shows its point.

use egui::{Color32, Painter, Pos2, Stroke, pos2, vec2};

use crate::app::model::State;
use crate::app::theme::Tokens;
use crate::app::work::Probed;
use crate::preprocess::registration::Outcome;

/// Where a camera shows the point, in its pixels, and whether it sees it.
pub(crate) fn in_camera(state: &State, probed: &Probed, camera: usize) -> Option<(Pos2, bool)> {
    if camera == probed.camera {
        return Some((pos2(probed.x as f32 + 0.5, probed.y as f32 + 0.5), true));
    }
    if let Some(row) = probed.argument.as_ref().and_then(|argument| argument.evidence.get(camera)) {
        let sees = matches!(row.outcome, Some(Outcome::Same(_)));
        return row.position.map(|position| (pos2(position.x as f32, position.y as f32), sees));
    }
    let scene = state.scene.as_ref()?;
    let (position, _) = scene.cameras.get(camera)?.project(probed.point_in_world?)?;
    Some((pos2(position.x as f32, position.y as f32), false))
}

/// A ring with a cross through it where the point is seen, an empty ring where it is not.
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
