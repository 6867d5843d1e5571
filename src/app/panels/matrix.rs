//! Squares of cells, one for each ordered pair of cameras; and how well cameras agree about where things are: a wrong pose
//! shows in what never moves, a wrong clock in what does.

use egui::{Painter, Rect, RichText, Sense, Ui, vec2};

use crate::app::theme::{Tokens, space};
use crate::app::widgets::{note, weak};
use crate::app::{colormap, model};
use crate::preprocess::diagnostics::{PairResiduals, Report, Residual};

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
pub(crate) fn pairs_ui(ui: &mut Ui, names: &[&str], cell: impl Fn(usize, usize) -> Option<PairCell>) {
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
    painter: &Painter,
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

/// Residual at the light end of the color map, footprints; a tenth of a footprint still differs from none.
const LIGHTEST_FOOTPRINTS: f32 = 2.0;

/// Both matrices, and what is to be said about cameras that do not fit.
pub(crate) fn agreement_ui(ui: &mut Ui, report: &Report) {
    let tokens = Tokens::in_ui(ui);
    ui.heading("How well cameras agree");
    let help = "How far samples of the row's camera lie off what the column's camera saw there, in pixel footprints. Where all of one camera's pairs are light, that camera is wrong.";
    let warnings = report.warnings();
    if warnings.is_empty() {
        weak(ui, "No camera contradicts the others.").on_hover_text(help);
    }
    for warning in warnings {
        ui.label(RichText::new(model::sentence(&warning)).color(tokens.warning)).on_hover_text(help);
    }
    let title = "What never moves, 85 % within (a pose error shows here)";
    residuals_ui(ui, report, title, |pair| pair.lasting, |residual| residual.most_footprints);
    ui.add_space(space::SMALL);
    let title = "What moves, half within (a time offset shows here alone)";
    residuals_ui(ui, report, title, |pair| pair.moving, |residual| residual.median_footprints);
}

fn residuals_ui(
    ui: &mut Ui,
    report: &Report,
    title: &str,
    of: impl Fn(&PairResiduals) -> Option<Residual>,
    footprints: impl Fn(&Residual) -> f32,
) {
    note(ui, title);
    let names: Vec<&str> = report.cameras.iter().map(|camera| camera.name.as_str()).collect();
    pairs_ui(ui, &names, |row, column| {
        let residual = of(report.residuals.get(row)?.get(column)?)?;
        let Residual { samples, median_footprints, most_footprints, median_color_steps } = residual;
        Some(PairCell {
            strength: Some((footprints(&residual) / LIGHTEST_FOOTPRINTS).sqrt().min(1.0)),
            text: format!("{:.2}", footprints(&residual)),
            help: format!(
                "{} against {}: 85 % of {} samples within {most_footprints:.3} footprints, half within \
                 {median_footprints:.3}; half of their colors within {median_color_steps:.1} steps",
                names[row],
                names[column],
                model::count(samples),
            ),
        })
    });
}
