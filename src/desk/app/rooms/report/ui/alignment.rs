//! What the rig got wrong and was corrected: per camera, and how far pairs of cameras were and are apart.

use egui::{RichText, Ui};

use super::pair_grid::{PairCell, by_weight, pairs_ui};
use crate::app::colormap::sequential;
use crate::app::model;
use crate::app::model::{Command, Commands, State};
use crate::app::rooms::compare::model::{CompareCommand, CompareSide};
use crate::app::rooms::frame::model::{DockView, WindowCommand};
use crate::app::rooms::report::model::Table;
use crate::app::rooms::source::ui::legend::bar;
use crate::app::theme::{Tokens, space};
use crate::app::widgets::{note, table_ui, weak};
use overlook_engine::alignment::{AlignedCamera, AlignedExposure, Alignment};
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
    for camera in &alignment.cameras {
        camera_ui(ui, camera);
    }
    ui.add_space(space::SMALL);
    distances_ui(ui, alignment);
    ui.add_space(space::LARGE);
}

/// One line on a camera, with its standard errors where the pointer rests.
fn camera_ui(ui: &mut Ui, camera: &AlignedCamera) {
    let mut parts = Vec::new();
    if let Some(pose) = &camera.pose {
        let distance = model::significant(pose.distance);
        parts.push(format!("{:.2}°, {distance} units, {:.1} footprints", pose.degrees, pose.footprints));
    }
    if let Some(AlignedExposure { stops, .. }) = &camera.exposure {
        let [r, g, b] = stops;
        parts.push(format!("R {r:+.2} G {g:+.2} B {b:+.2} stops"));
    }
    if let Some(clock) = &camera.clock {
        parts.push(format!("late by {:+.2} of a frame", clock.frames));
    }
    if !parts.is_empty() {
        let line = ui.label(format!("{}: {}", camera.name, parts.join("; ")));
        line.on_hover_text(camera.sentence().unwrap_or_default());
    } else if camera.pose_is_weak {
        let words = format!("{}: what the cameras see does not tell its pose, which stays", camera.name);
        ui.label(RichText::new(words).color(Tokens::in_ui(ui).warning));
    }
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
