//! A square of cells, one for each ordered pair of cameras.

use egui::{Rect, Sense, Ui, vec2};

use crate::app::colormap;
use crate::app::theme::Tokens;

/// What is shown of a pair.
pub(crate) struct PairCell {
    /// 0 to 1: the lighter the larger; `None` leaves the cell dark.
    pub(crate) strength: Option<f32>,
    /// Shown where there is room for it, and where the cell is not dark.
    pub(crate) text: String,
    /// Shown where the pointer rests.
    pub(crate) help: String,
}

const NAME_WIDTH: f32 = 78.0;
const HEADER_HEIGHT: f32 = 18.0;

/// The cells of all pairs of cameras with these names; `cell` is given row and column.
pub(crate) fn ui(ui: &mut Ui, names: &[&str], cell: impl Fn(usize, usize) -> Option<PairCell>) {
    let cameras = names.len();
    if cameras == 0 {
        return;
    }
    let tokens = Tokens::in_ui(ui);
    let width = ((ui.available_width() - NAME_WIDTH) / cameras as f32).clamp(3.0, 44.0);
    let height = width.min(24.0);
    let size = vec2(ui.available_width(), HEADER_HEIGHT + height * cameras as f32);
    let (area, whole) = ui.allocate_exact_size(size, Sense::hover());
    let painter = ui.painter_at(area);
    let small = egui::TextStyle::Small.resolve(ui.style());
    for row in 0..cameras {
        let top = area.top() + HEADER_HEIGHT + height * row as f32;
        camera_name(&painter, egui::pos2(area.left(), top + height / 2.0), row, names[row], &small, tokens);
        for column in 0..cameras {
            let left = area.left() + NAME_WIDTH + width * column as f32;
            let rect = Rect::from_min_size(egui::pos2(left, top), vec2(width, height)).shrink(1.0);
            if row == 0 {
                let center = egui::pos2(rect.center().x, area.top() + 8.0);
                painter.circle_filled(center, 4.0, colormap::camera(column));
            }
            let Some(cell) = cell(row, column) else {
                painter.rect_filled(rect, 2.0, tokens.background);
                continue;
            };
            let color = cell.strength.map_or(tokens.background, colormap::sequential);
            painter.rect_filled(rect, 2.0, color);
            if let Some(strength) = cell.strength.filter(|_| width >= 40.0) {
                // The map passes mid gray at about half its range: black reads on what is lighter, white on the rest.
                let text_color = if strength > 0.55 { egui::Color32::BLACK } else { egui::Color32::WHITE };
                let font = egui::FontId::proportional(10.0);
                painter.text(rect.center(), egui::Align2::CENTER_CENTER, cell.text, font, text_color);
            }
            let response = ui.interact(rect, whole.id.with((row, column)), Sense::hover());
            response.on_hover_text(cell.help);
        }
    }
}

fn camera_name(
    painter: &egui::Painter,
    at: egui::Pos2,
    index: usize,
    name: &str,
    font: &egui::FontId,
    tokens: &Tokens,
) {
    painter.circle_filled(at + vec2(5.0, 0.0), 4.0, colormap::camera(index));
    painter.text(at + vec2(14.0, 0.0), egui::Align2::LEFT_CENTER, short(name, 11), font.clone(), tokens.text);
}

/// The first characters of a name, and whether there are more.
pub(crate) fn short(name: &str, length: usize) -> String {
    if name.chars().count() <= length {
        return name.to_owned();
    }
    let mut text: String = name.chars().take(length - 1).collect();
    text.push('…');
    text
}
