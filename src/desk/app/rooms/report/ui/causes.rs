//! What became of all pixels, as bars that are always in view: what is kept, and for each reason what is dropped.

use egui::{Align2, Color32, Rect, Response, RichText, ScrollArea, Sense, TextStyle, Ui, pos2, vec2};
use egui_extras::Column;

use crate::app::colormap::sequential;
use crate::app::model::look::Unit;
use crate::app::model::{self, Commands, State};
use crate::app::rooms::compare::compare_with;
use crate::app::rooms::compare::state::CompareSide;
use crate::app::rooms::report::ui::pairs::{
    PairCell, ROW, SCROLLED, camera_table_ui, name_ui, order, pairs_ui,
};
use crate::app::rooms::source::ui::legend::bar;
use crate::app::theme::{Tokens, space};
use crate::app::widgets::{note, weak};
use overlook_engine::alignment::{AlignedCamera, Alignment};
use overlook_engine::preprocess::diagnostics::{PixelAccount, Report};

/// Least width of a bar with its name, points. Where they have less, the least shares have no bar.
const LEAST_WIDTH: f32 = 78.0;

/// Between two bars, and the height of each, points.
const GAP: f32 = 10.0;
const BAR: f32 = 7.0;

/// Shares below this have no bar: 0.1 %.
const LEAST_SHARE: f32 = 0.001;

/// A share of all pixels.
struct Cause {
    name: &'static str,
    pixels: u64,
    share: f32,
    /// The share in words.
    percent: String,
    color: Color32,
    help: &'static str,
}

/// Every share that is not nearly nothing, in the order in which pixels are lost.
fn causes(account: &PixelAccount, tokens: &Tokens) -> Vec<Cause> {
    let cause = |name, pixels, color, help| {
        let share = pixels as f32 / account.pixels.max(1) as f32;
        Cause { name, pixels, share, percent: model::percent(pixels, account.pixels), color, help }
    };
    let all = vec![
        cause("Kept", account.kept, tokens.moving, "Samples that stay."),
        cause(
            "Repeated",
            account.repeated,
            tokens.static_over_time,
            "The same camera shows the same in other frames: one sample is stored for all of them.",
        ),
        cause(
            "Redundant",
            account.redundant,
            tokens.accent,
            "A kept sample of another camera shows the same point at least as well.",
        ),
        cause(
            "No depth",
            account.without_depth,
            tokens.text_weak,
            "Pixels without depth say nothing about the scene.",
        ),
        cause("Blended", account.mixed, tokens.warning, "Color or depth is blended across an edge."),
        cause(
            "Contradicted",
            account.contradicted,
            tokens.error,
            "More cameras look past the point than confirm it.",
        ),
        cause("Cut by hand", account.cut, tokens.text, "An edit deletes it."),
    ];
    all.into_iter().filter(|cause| cause.share >= LEAST_SHARE).collect()
}

/// The bars in the room that is left; nothing where that is too little.
pub(crate) fn causes_ui(ui: &mut Ui, account: &PixelAccount) -> Option<Response> {
    let tokens = Tokens::in_ui(ui);
    let mut all = causes(account, tokens);
    let room = ui.available_size();
    let fits = ((room.x + GAP) / (LEAST_WIDTH + GAP)) as usize;
    let mut shares: Vec<u64> = all.iter().map(|cause| cause.pixels).collect();
    shares.sort_unstable_by_key(|pixels| std::cmp::Reverse(*pixels));
    let least = shares.get(fits.checked_sub(1)?).or(shares.last()).copied()?;
    all.retain(|cause| cause.pixels >= least);
    let each = (room.x + GAP) / all.len() as f32 - GAP;
    let (area, response) = ui.allocate_exact_size(room, Sense::click());
    let parts: Vec<String> = all.iter().map(|cause| format!("{} {}", cause.name, cause.percent)).collect();
    let name = format!("What became of all pixels: {}", parts.join(", "));
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, &name));
    let pointer = response.hover_pos();
    let mut help = None;
    for (nth, cause) in all.iter().enumerate() {
        let left = area.left() + nth as f32 * (each + GAP);
        let place = Rect::from_min_size(pos2(left, area.top()), vec2(each, area.height()));
        cause_bar(ui, place, cause, tokens);
        if pointer.is_some_and(|pointer| place.expand(GAP / 2.0).contains(pointer)) {
            help = Some(format!("{} {}: {} Click for the rules.", cause.name, cause.percent, cause.help));
        }
    }
    Some(match help {
        Some(help) => response.on_hover_text(help),
        None => response,
    })
}

/// A name, its share in words, and a bar as long as the share.
fn cause_bar(ui: &Ui, place: Rect, cause: &Cause, tokens: &Tokens) {
    let font = TextStyle::Small.resolve(ui.style());
    let painter = ui.painter();
    let name = painter.text(place.left_top(), Align2::LEFT_TOP, cause.name, font.clone(), tokens.text_weak);
    let figure = pos2(place.left(), name.bottom() + 1.0);
    let figure = painter.text(figure, Align2::LEFT_TOP, &cause.percent, font, tokens.text);
    let rail = Rect::from_min_size(pos2(place.left(), figure.bottom() + 2.0), vec2(place.width(), BAR));
    painter.rect_filled(rail, 2.0, tokens.raised);
    let length = (rail.width() * cause.share).max(1.5);
    painter.rect_filled(Rect::from_min_size(rail.min, vec2(length, BAR)), 2.0, cause.color);
}

/// The corrections, and a button that shows the picture with and without them. Nothing without corrections.
pub(crate) fn alignment_ui(ui: &mut Ui, state: &State, report: &Report, commands: &mut Commands) {
    let Some(alignment) = &report.alignment else { return };
    for line in alignment.refusals() {
        ui.label(RichText::new(format!("Not corrected: {line}")).color(Tokens::in_ui(ui).warning));
    }
    if !alignment.is_of_cameras() {
        ui.add_space(space::LARGE);
        return;
    }
    ui.heading("What was corrected");
    weak(ui, "Cameras agree better so, by samples that took no part in finding it.");
    ui.horizontal(|ui| {
        let is_capture = state.doc.scene.as_ref().is_some_and(|scene| scene.capture().is_some());
        let button = ui.add_enabled(is_capture, egui::Button::new("Compare before and after"));
        let button =
            button.on_hover_text("The kept samples as the capture claims to be, beside those as corrected.");
        if button.on_disabled_hover_text("Open the capture that the store was made from.").clicked() {
            compare_with(CompareSide::AsClaimed, state, commands);
        }
    });
    for lens in &alignment.lenses {
        ui.label(lens.sentence());
    }
    let order = order(report);
    corrections_ui(ui, alignment, &order, state.live.unit);
    ui.add_space(space::SMALL);
    distances_ui(ui, alignment, &order);
    ui.add_space(space::LARGE);
}

/// Cameras whose poses stay unknown that are named.
const TOLD: usize = 3;

/// What a column says of a camera; `None` where nothing was corrected.
type Cell = Box<dyn Fn(&AlignedCamera) -> Option<String>>;

/// A column: its heading, its width in points, what it means, and what it says.
type CorrectionColumn = (String, f32, &'static str, Cell);

/// Columns with the corrections that were made: no column for what was corrected of no camera.
fn columns(alignment: &Alignment, unit: Unit) -> Vec<CorrectionColumn> {
    let mut columns: Vec<CorrectionColumn> = Vec::new();
    let mut add = |title: String, width: f32, help: &'static str, cell: Cell| {
        columns.push((title, width, help, cell));
    };
    let cameras = &alignment.cameras;
    if cameras.iter().any(|camera| camera.pose.is_some()) {
        let help = "By how much the camera was turned.";
        add("Angle".to_owned(), 48.0, help, Box::new(|it| Some(format!("{:.2}°", it.pose?.degrees))));
        let distance = |it: &AlignedCamera| Some(model::significant(it.pose?.distance));
        let help = "How far the camera was moved, in the unit of the View panel.";
        add(format!("Moved, {}", unit.name()), 72.0, help, Box::new(distance));
        let footprints = |it: &AlignedCamera| Some(format!("{:.1}", it.pose?.footprints));
        let help = "How far its samples moved by both, root mean square, in pixel footprints.";
        add("Footprints".to_owned(), 66.0, help, Box::new(footprints));
    }
    if cameras.iter().any(|camera| camera.exposure.is_some()) {
        for (channel, name) in ["R, stops", "G, stops", "B, stops"].into_iter().enumerate() {
            let help = "By how many stops the channel was made brighter, negative: darker.";
            let stops = move |it: &AlignedCamera| {
                it.exposure.as_ref().map(|exposure| format!("{:+.2}", exposure.stops[channel]))
            };
            add(name.to_owned(), 54.0, help, Box::new(stops));
        }
    }
    if cameras.iter().any(|camera| camera.clock.is_some()) {
        let frames = |it: &AlignedCamera| Some(format!("{:+.2}", it.clock.as_ref()?.frames));
        let help = "By how many frames the camera was late.";
        add("Late, frames".to_owned(), 74.0, help, Box::new(frames));
    }
    columns
}

/// One row a camera, with its standard errors where the pointer rests; and a warning of poses that stay unknown.
fn corrections_ui(ui: &mut Ui, alignment: &Alignment, order: &[usize], unit: Unit) {
    let tokens = *Tokens::in_ui(ui);
    let cameras = &alignment.cameras;
    let unknown = cameras.iter().filter(|camera| camera.pose.is_none() && camera.pose_is_weak);
    let unknown: Vec<&str> = unknown.map(|camera| camera.name.as_str()).collect();
    if !unknown.is_empty() {
        let (told, others) = unknown.split_at(unknown.len().min(TOLD));
        let more = if others.is_empty() { String::new() } else { format!(" and {} more", others.len()) };
        let whose = format!("{}{more}", told.join(", "));
        let words = format!("What cameras see does not tell the pose of {whose}: it stays as it was.");
        ui.label(RichText::new(words).color(tokens.warning)).on_hover_text(unknown.join(", "));
    }
    let columns = columns(alignment, unit);
    if columns.is_empty() {
        return;
    }
    let rows = 2.0 + order.len().min(SCROLLED) as f32;
    let height = rows * (ROW + ui.spacing().item_spacing.y);
    let scroll = ScrollArea::horizontal().id_salt("corrections").max_height(height);
    let name = ("Camera", Column::initial(96.0).clip(true), "Name of the camera.");
    let others =
        columns.iter().map(|(title, width, help, _)| (title.as_str(), Column::initial(*width), *help));
    let heads: Vec<_> = std::iter::once(name).chain(others).collect();
    scroll.auto_shrink([false, true]).show(ui, |ui| {
        camera_table_ui(ui, "corrections", order, &heads, |ui, column, index| {
            let camera = &cameras[index];
            let Some((title, .., cell)) = column.checked_sub(1).map(|column| &columns[column]) else {
                let help = camera.sentence();
                let help = help.unwrap_or_else(|| format!("{}: nothing was corrected", camera.name));
                name_ui(ui, index, &camera.name, &help);
                return;
            };
            let is_unknown = camera.pose.is_none() && camera.pose_is_weak && title == "Angle";
            let color = if is_unknown { tokens.warning } else { tokens.text };
            let words = if is_unknown { Some("stays".to_owned()) } else { cell(camera) };
            ui.label(RichText::new(words.as_deref().unwrap_or("–")).color(color));
        });
    });
}

/// Matrices of distances before and after, on one scale.
fn distances_ui(ui: &mut Ui, alignment: &Alignment, order: &[usize]) {
    let names: Vec<&str> = alignment.cameras.iter().map(|camera| camera.name.as_str()).collect();
    let pair = |row: usize, column: usize| {
        alignment.pairs.iter().find(|pair| pair.source == row && pair.target == column)
    };
    let most = alignment.pairs.iter().map(|pair| pair.footprints[0]).fold(0.0, f64::max).max(0.05);
    for (when, title) in ["Before: distance from the surface, half within", "After"].into_iter().enumerate() {
        note(ui, title);
        if when == 0 {
            ui.horizontal(|ui| {
                bar(ui, "0", &format!("{} footprints", model::significant(most)), 90.0, sequential);
            });
        }
        pairs_ui(ui, title, &names, order, |row, column| {
            let pair = pair(row, column)?;
            let [before, after] = pair.footprints;
            let [dim, clear] = pair.brightness;
            Some(PairCell {
                strength: Some((pair.footprints[when] / most).clamp(0.0, 1.0).sqrt() as f32),
                text: format!("{:.2}", pair.footprints[when]),
                help: format!(
                    "'{}' against '{}': half within {before:.3} footprints before, {after:.3} after; brightness {dim:.4} before, {clear:.4} after",
                    names[row], names[column]
                ),
            })
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use overlook_engine::alignment::AlignedPose;

    #[test]
    fn the_table_has_columns_for_what_was_corrected_and_lengths_in_the_unit_of_the_scene() {
        let moved =
            AlignedPose { degrees: 0.5, distance: 0.0123, footprints: 2.04, ..AlignedPose::default() };
        let camera = AlignedCamera { name: "left".to_owned(), pose: Some(moved), ..AlignedCamera::default() };
        let stays = AlignedCamera { name: "right".to_owned(), ..AlignedCamera::default() };
        let alignment = Alignment { cameras: vec![camera, stays], ..Alignment::default() };
        let columns = columns(&alignment, Unit::Meters);
        let titles: Vec<&str> = columns.iter().map(|(title, ..)| title.as_str()).collect();
        assert_eq!(titles, ["Angle", "Moved, m", "Footprints"], "neither exposure nor clock was corrected");
        let cells = |camera: usize| -> Vec<Option<String>> {
            columns.iter().map(|(.., cell)| cell(&alignment.cameras[camera])).collect()
        };
        assert_eq!(cells(0), ["0.50°", "0.0123", "2.0"].map(|cell| Some(cell.to_owned())));
        assert_eq!(cells(1), [None, None, None]);
    }
}
