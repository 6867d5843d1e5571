//! The pixel that is looked at, marked in every view that shows its point.

use egui::{Color32, Painter, Pos2, Stroke, vec2};

use crate::app::theme::Tokens;

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
