//! What the rig got wrong and was corrected: per camera, and how far pairs of cameras were and are apart.

use egui::{Align, Layout, RichText, ScrollArea, Ui};
use egui_extras::{Column, TableBuilder};

use super::pair_grid::{PairCell, by_weight, pairs_ui, short};
use crate::app::colormap::sequential;
use crate::app::model;
use crate::app::model::{Command, Commands, State};
use crate::app::rooms::compare::model::{CompareCommand, CompareSide};
use crate::app::rooms::frame::model::{DockView, WindowCommand};
use crate::app::rooms::live::model::Unit;
use crate::app::rooms::report::model::Table;
use crate::app::rooms::source::ui::legend::bar;
use crate::app::theme::{Tokens, space};
use crate::app::widgets::{dot, note, table_ui, weak};
use overlook_engine::alignment::{AlignedCamera, Alignment};
use overlook_engine::preprocess::diagnostics::Report;

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
            let mut look = state.inspector.compare.clone();
            look.choice.sides = [CompareSide::AsClaimed, CompareSide::Kept];
            commands.push(Command::Compare(CompareCommand::Look(Box::new(look))));
            commands.push(Command::Window(WindowCommand::OpenView(DockView::Compare)));
        }
        table_ui(ui, Table::Alignment, commands);
    });
    for lens in &alignment.lenses {
        ui.label(lens.sentence());
    }
    corrections_ui(ui, alignment, state.live.unit);
    ui.add_space(space::SMALL);
    distances_ui(ui, alignment);
    ui.add_space(space::LARGE);
}

/// Height of a row of the table.
const ROW: f32 = 20.0;

/// Cameras from which on the table is scrolled by itself.
const SCROLLED: usize = 16;

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
fn corrections_ui(ui: &mut Ui, alignment: &Alignment, unit: Unit) {
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
    let order = by_weight(cameras.len(), |camera| {
        cameras[camera].pose.as_ref().map_or(0.0, |pose| pose.footprints as f32)
    });
    let rows = 2.0 + order.len().min(SCROLLED) as f32;
    let height = rows * (ROW + ui.spacing().item_spacing.y);
    let scroll = ScrollArea::horizontal().id_salt("corrections").max_height(height);
    scroll.auto_shrink([false, true]).show(ui, |ui| {
        let mut table =
            TableBuilder::new(ui).id_salt("corrections").striped(true).vscroll(order.len() > SCROLLED);
        table = table.cell_layout(Layout::left_to_right(Align::Center));
        table = table.column(Column::initial(96.0).clip(true));
        for (_, width, ..) in &columns {
            table = table.column(Column::initial(*width));
        }
        let table = table.max_scroll_height(SCROLLED as f32 * ROW).header(ROW, |mut header| {
            header.col(|ui| {
                note(ui, "Camera").on_hover_text("Name of the camera.");
            });
            for (title, _, help, _) in &columns {
                header.col(|ui| {
                    note(ui, title).on_hover_text(*help);
                });
            }
        });
        table.body(|body| {
            body.rows(ROW, order.len(), |mut row| {
                let index = order[row.index()];
                let camera = &cameras[index];
                row.col(|ui| {
                    dot(ui, index);
                    let help = camera.sentence();
                    let help = help.unwrap_or_else(|| format!("{}: nothing was corrected", camera.name));
                    ui.label(short(&camera.name, 14)).on_hover_text(help);
                });
                for (title, .., cell) in &columns {
                    row.col(|ui| {
                        let is_unknown = camera.pose.is_none() && camera.pose_is_weak && title == "Angle";
                        let color = if is_unknown { tokens.warning } else { tokens.text };
                        let words = if is_unknown { Some("stays".to_owned()) } else { cell(camera) };
                        ui.label(RichText::new(words.as_deref().unwrap_or("–")).color(color));
                    });
                }
            });
        });
    });
}

/// Matrices of distances before and after, on one scale.
fn distances_ui(ui: &mut Ui, alignment: &Alignment) {
    let names: Vec<&str> = alignment.cameras.iter().map(|camera| camera.name.as_str()).collect();
    let pair = |row: usize, column: usize| {
        alignment.pairs.iter().find(|pair| pair.source == row && pair.target == column)
    };
    let most = alignment.pairs.iter().map(|pair| pair.footprints[0]).fold(0.0, f64::max).max(0.05);
    let order = by_weight(names.len(), |camera| {
        let of_camera = alignment.pairs.iter().filter(|pair| pair.source == camera || pair.target == camera);
        of_camera.map(|pair| pair.footprints[0] as f32).fold(0.0, f32::max)
    });
    for (when, title) in ["Before: distance from the surface, half within", "After"].into_iter().enumerate() {
        note(ui, title);
        if when == 0 {
            ui.horizontal(|ui| {
                bar(ui, "0", &format!("{} footprints", model::significant(most)), 90.0, sequential);
            });
        }
        pairs_ui(ui, title, &names, &order, |row, column| {
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
