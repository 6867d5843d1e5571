//! Which camera's samples replace whose, and how well cameras agree on positions: a wrong pose shows on static surfaces, a wrong clock
//! on moving ones, noise on both.

use std::f32::consts::FRAC_PI_2;

use egui::epaint::TextShape;
use egui::{
    Align, Align2, Color32, FontId, Layout, Painter, Rect, RichText, ScrollArea, Sense, Ui, pos2, vec2,
};
use egui_extras::{Column, TableBuilder};

use crate::app::camera_cues;
use crate::app::colormap::sequential;
use crate::app::model;
use crate::app::rooms::source::ui::legend::bar;
use crate::app::theme::{Tokens, space};
use crate::app::widgets::{dot, note, weak};
use overlook_engine::plural::counted;
use overlook_engine::preprocess::diagnostics::{CameraReport, PairResiduals, Report, Residual};

/// The matrix of replaced samples.
pub(crate) fn replacements_ui(ui: &mut Ui, report: &Report) {
    ui.heading("Which camera replaces which");
    weak(ui, "Rows lose samples, columns keep the ones that replace them.");
    let left_out: u64 = report.witnesses_left_out.iter().sum();
    if left_out > 0 {
        let samples = model::count_of(left_out, "sample");
        let text = "Each row shows the cameras that replace most of it";
        weak(ui, format!("{text}; {samples} were dropped for others."));
    }
    let most = report.witnesses.iter().map(|(.., count)| *count).max().unwrap_or(0).max(1) as f32;
    let names: Vec<&str> = report.cameras.iter().map(|camera| camera.name.as_str()).collect();
    pairs_ui(ui, "replacements", &names, &order(report), |loser, winner| {
        let count = *report.witnesses.get(loser, winner)?;
        Some(PairCell {
            // The square root makes small counts differ from none.
            strength: (count > 0).then(|| (count as f32 / most).sqrt()),
            text: model::count(count),
            help: format!(
                "'{}': {} dropped for '{}'",
                names[loser],
                model::count_of(count, "sample"),
                names[winner]
            ),
        })
    });
}

/// A scale ends at this many times the mean: a pair that is far off does not make all others alike.
const ABOVE_MEAN: f32 = 3.0;

/// The least that the end of a scale stands for, footprints.
const LEAST_FOOTPRINTS: f32 = 0.05;

/// Both matrices, and notes on cameras that do not fit.
pub(crate) fn agreement_ui(ui: &mut Ui, report: &Report) {
    let tokens = Tokens::in_ui(ui);
    ui.heading("How well cameras agree");
    let help = "How far samples of the row's camera lie off what the column's camera saw there, in pixel footprints. Where all of one camera's pairs are light, that camera is wrong.";
    let suspects = report.suspects();
    for (cause, warning) in &suspects {
        let words = format!("{}: {warning}", cause.name());
        ui.label(RichText::new(words).color(tokens.warning)).on_hover_text(help);
    }
    if suspects.is_empty() {
        let words = if report.is_noisy() {
            "Noise: cameras differ by as much as the noise that was measured between them; no pose and no clock stands out."
        } else {
            "No camera contradicts the others."
        };
        weak(ui, words).on_hover_text(help);
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
    let values: Vec<f32> =
        report.residuals.iter().filter_map(|(.., pair)| Some(footprints(&of(pair)?))).collect();
    let most = values.iter().copied().fold(0.0, f32::max);
    let mean = values.iter().sum::<f32>() / values.len().max(1) as f32;
    let lightest = most.min(ABOVE_MEAN * mean).max(LEAST_FOOTPRINTS);
    ui.horizontal(|ui| {
        let end = format!("{} footprints or more", model::significant(f64::from(lightest)));
        bar(ui, "0", &end, 90.0, sequential);
    });
    pairs_ui(ui, title, &names, &order(report), |row, column| {
        let residual = of(report.residuals.get(row, column)?)?;
        let Residual { samples, median_footprints, most_footprints, median_color_steps } = residual;
        Some(PairCell {
            strength: Some((footprints(&residual) / lightest).sqrt().min(1.0)),
            text: format!("{:.2}", footprints(&residual)),
            help: format!(
                "'{}' against '{}': 85 % of {} within {most_footprints:.3} footprints, half within \
                 {median_footprints:.3}; half of their colors within {median_color_steps:.1} steps",
                names[row],
                names[column],
                model::count_of(samples, "sample"),
            ),
        })
    });
}

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
const HEADER_HEIGHT: f32 = 76.0;

/// Widths of a cell, points, from where its pairs can be told apart to where its number has room; and its heights.
const CELL: [std::ops::RangeInclusive<f32>; 2] = [9.0..=44.0, 12.0..=24.0];

/// Height beyond which the square is scrolled by itself, where the view is not taller.
const TALLEST: f32 = 460.0;

/// Height of a tall view that is left for what stands above and below the square.
const AROUND: f32 = 110.0;

/// Cameras up to which the square keeps the capture's order.
const FEW: usize = 8;

/// Cameras in the one order of all tables and matrices: that of the capture while they are few, else by what is kept of them, most first.
pub(crate) fn order(report: &Report) -> Vec<usize> {
    let mut order: Vec<usize> = (0..report.cameras.len()).collect();
    if report.cameras.len() > FEW {
        let kept = |camera: &CameraReport| camera.background_kept + camera.foreground_kept;
        order.sort_by_key(|index| std::cmp::Reverse(kept(&report.cameras[*index])));
    }
    order
}

/// The sign and the name of a camera.
pub(crate) fn name_ui(ui: &mut Ui, camera: usize, name: &str, help: &str) -> egui::Response {
    dot(ui, camera);
    ui.label(short(name, 14)).on_hover_text(help)
}

/// Height of a row of a table of cameras.
pub(crate) const ROW: f32 = 20.0;

/// Cameras from which on their table is scrolled by itself.
pub(crate) const SCROLLED: usize = 16;

/// A row for each camera in `order`: title, width and meaning of the columns, and what shows a column by its place and a camera.
pub(crate) fn camera_table_ui(
    ui: &mut Ui,
    id: &str,
    order: &[usize],
    columns: &[(&str, Column, &str)],
    cell_ui: impl Fn(&mut Ui, usize, usize),
) {
    let mut table = TableBuilder::new(ui).id_salt(id).striped(true).vscroll(order.len() > SCROLLED);
    table = table.cell_layout(Layout::left_to_right(Align::Center));
    for (_, width, _) in columns {
        table = table.column(*width);
    }
    let table = table.max_scroll_height(SCROLLED as f32 * ROW).header(ROW, |mut header| {
        for (title, _, help) in columns {
            header.col(|ui| {
                note(ui, *title).on_hover_text(*help);
            });
        }
    });
    table.body(|body| {
        body.rows(ROW, order.len(), |mut row| {
            let camera = order[row.index()];
            for column in 0..columns.len() {
                row.col(|ui| cell_ui(ui, column, camera));
            }
        });
    });
}

/// Size of a cell in so much width.
fn cell_size(width: f32, cameras: usize) -> egui::Vec2 {
    let [width, height] =
        CELL.map(|side| ((width - NAME_WIDTH) / cameras as f32).clamp(*side.start(), *side.end()));
    vec2(width, height)
}

/// The cells of all pairs of cameras, `order` being their indices; `cell` is given those of row and column.
pub(crate) fn pairs_ui(
    ui: &mut Ui,
    id: &str,
    names: &[&str],
    order: &[usize],
    cell: impl Fn(usize, usize) -> Option<PairCell>,
) {
    let cameras = order.len();
    if cameras == 0 {
        return;
    }
    // What is in view: the view itself is scrolled, and has no end.
    let tallest = (ui.clip_rect().height() - AROUND).max(TALLEST);
    let step = cell_size(ui.available_width(), cameras);
    let corner = vec2(NAME_WIDTH, HEADER_HEIGHT);
    let size = corner + step * cameras as f32;
    let scroll = ScrollArea::both().id_salt(id).max_height(tallest).auto_shrink([false, true]);
    scroll.show_viewport(ui, |ui, viewport| {
        let (area, response) = ui.allocate_exact_size(size, Sense::hover());
        let seen = Rect::from_min_size(area.min + viewport.min.to_vec2(), viewport.size()).intersect(area);
        let cells = Rect::from_min_max(seen.min + corner, seen.max);
        let grid = PairGrid { names, order, corner: area.min + corner, cell: step };
        let painter = ui.painter().with_clip_rect(cells.intersect(ui.clip_rect()));
        let [rows, columns] = grid.within(cells);
        for row in rows {
            for column in columns.clone() {
                grid.cell(&painter, row, column, cell(order[row], order[column]), Tokens::in_ui(ui));
            }
        }
        grid.names_ui(ui, seen, cells);
        response.widget_info(|| {
            egui::WidgetInfo::labeled(
                egui::Role::Image,
                true,
                format!("Matrix of {}", counted(cameras, "camera")),
            )
        });
        let pointed = response.hover_pos().filter(|at| cells.contains(*at)).and_then(|at| {
            let place = (at - grid.corner) / grid.cell;
            let [row, column] = [place.y, place.x].map(|place| (place as usize).min(cameras - 1));
            cell(order[row], order[column])
        });
        if let Some(pointed) = pointed {
            response.on_hover_text_at_pointer(pointed.help);
        }
    });
}

struct PairGrid<'a> {
    names: &'a [&'a str],
    order: &'a [usize],
    /// Corner of the first cell.
    corner: egui::Pos2,
    cell: egui::Vec2,
}

impl PairGrid<'_> {
    /// The rows and the columns in an area.
    fn within(&self, area: Rect) -> [std::ops::Range<usize>; 2] {
        let area = area.translate(-self.corner.to_vec2());
        let between = |from: f32, to: f32, step: f32| {
            let last = (to / step).ceil().max(0.0) as usize;
            ((from / step).max(0.0) as usize)..last.min(self.order.len())
        };
        [between(area.top(), area.bottom(), self.cell.y), between(area.left(), area.right(), self.cell.x)]
    }

    fn cell(&self, painter: &Painter, row: usize, column: usize, cell: Option<PairCell>, tokens: &Tokens) {
        let corner = self.corner + vec2(self.cell.x * column as f32, self.cell.y * row as f32);
        let gap = if self.cell.x > 14.0 { 1.0 } else { 0.5 };
        let rect = Rect::from_min_size(corner, self.cell).shrink(gap);
        let strength = cell.as_ref().and_then(|cell| cell.strength);
        painter.rect_filled(rect, 2.0, strength.map_or(tokens.background, sequential));
        if let (Some(cell), Some(strength)) = (cell, strength.filter(|_| self.cell.x >= 40.0)) {
            // The map passes mid gray at about half its range: black reads on what is lighter, white on the rest.
            let color = if strength > 0.55 { Color32::BLACK } else { Color32::WHITE };
            let font = FontId::proportional(10.0);
            painter.text(rect.center(), Align2::CENTER_CENTER, cell.text, font, color);
        }
    }

    /// Names at the left end and above, of what is in view.
    fn names_ui(&self, ui: &Ui, seen: Rect, cells: Rect) {
        let tokens = Tokens::in_ui(ui);
        let font = egui::TextStyle::Small.resolve(ui.style());
        let left = Rect::from_min_max(pos2(seen.left(), cells.top()), pos2(cells.left(), seen.bottom()));
        let painter = ui.painter().with_clip_rect(left.intersect(ui.clip_rect()));
        let [rows, columns] = self.within(cells);
        for row in rows {
            let camera = self.order[row];
            let at = pos2(seen.left(), self.corner.y + self.cell.y * (row as f32 + 0.5));
            camera_cues::sign(&painter, Rect::from_center_size(at + vec2(5.0, 0.0), vec2(9.0, 9.0)), camera);
            let name = short(self.names.get(camera).unwrap_or(&""), 11);
            painter.text(at + vec2(14.0, 0.0), Align2::LEFT_CENTER, name, font.clone(), tokens.text);
        }
        let top = Rect::from_min_max(pos2(cells.left(), seen.top()), pos2(seen.right(), cells.top()));
        let painter = ui.painter().with_clip_rect(top.intersect(ui.clip_rect()));
        for column in columns {
            let at = pos2(self.corner.x + self.cell.x * (column as f32 + 0.5), cells.top() - 8.0);
            let side = vec2(9.0, 9.0).min(egui::Vec2::splat(self.cell.x - 1.0));
            let camera = self.order[column];
            camera_cues::sign(&painter, Rect::from_center_size(at, side), camera);
            // Names go up from their columns.
            let name = short(self.names.get(camera).unwrap_or(&""), 11);
            let name = painter.layout_no_wrap(name, font.clone(), tokens.text);
            let corner = at + vec2(-0.5 * name.size().y, -8.0);
            painter.add(TextShape::new(corner, name, tokens.text).with_angle(-FRAC_PI_2));
        }
    }
}

/// The first characters of a name, and whether there are more.
pub(crate) fn short(name: &str, length: usize) -> String {
    if name.chars().count() <= length {
        return name.to_owned();
    }
    name.chars().take(length - 1).chain(['…']).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_cameras_keep_their_order_and_many_are_sorted_by_what_is_kept() {
        let kept = |background_kept| CameraReport { background_kept, ..CameraReport::default() };
        let order =
            |cameras| order(&Report { cameras: (0..cameras).map(kept).collect(), ..Report::default() });
        assert_eq!(order(3), [0, 1, 2]);
        assert_eq!(order(10), [9, 8, 7, 6, 5, 4, 3, 2, 1, 0]);
    }

    #[test]
    fn of_a_large_square_only_what_is_in_view_is_drawn() {
        let order: Vec<usize> = (0..300).collect();
        let (corner, cell) = (pos2(0.0, 0.0), vec2(10.0, 12.0));
        let grid = PairGrid { names: &[], order: &order, corner, cell };
        let seen = Rect::from_min_size(pos2(100.0, 240.0), vec2(200.0, 120.0));
        assert_eq!(grid.within(seen), [20..30, 10..30]);
        let beyond = Rect::from_min_size(pos2(2900.0, 3500.0), vec2(400.0, 400.0));
        assert_eq!(grid.within(beyond), [291..300, 290..300]);
    }
}
