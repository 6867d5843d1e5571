//! What would be lost without each camera, the most needless first.

use std::collections::BTreeSet;

use egui::{Button, Grid, RichText, ScrollArea, Ui};
use egui_material_icons::icons::{ICON_CLOSE, ICON_PHOTO_LIBRARY};

use crate::app::model::command::{ChartCommand, EditCommand, SourceCommand};
use crate::app::model::{self, Command, Commands, OpenScene, State};
use crate::app::rooms::charts::state::Study;
use crate::app::rooms::charts::ui::parts::no_points_ui;
use crate::app::rooms::charts::ui::tuning::signed;
use crate::app::theme::{Tokens, space};
use crate::app::widgets::{bare_icon_button, dot, note, weak};
use overlook_lab::tune::CameraWorth;

/// Width of the ranking beside the pictures, points; in less than twice of it the pictures give way.
pub(super) const WIDTH: f32 = 430.0;

/// Width of a camera's name and sign, points.
const NAME: f32 = 100.0;

/// Whether there is a ranking to be shown.
pub(super) fn is_shown(state: &State) -> bool {
    let charts = &state.doc.charts;
    !charts.hides_ranking && (!charts.ranking.is_empty() || charts.under_way() == Some(Study::Ranking))
}

pub(super) fn ranking_ui(ui: &mut Ui, state: &State, scene: &OpenScene, commands: &mut Commands) {
    let charts = &state.doc.charts;
    ui.horizontal(|ui| {
        ui.label(RichText::new("Most needless first").strong());
        if charts.under_way() == Some(Study::Ranking) && !charts.ranking.is_empty() {
            ui.add(egui::Spinner::new().size(14.0));
        }
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            if bare_icon_button(ui, ICON_CLOSE, "Close the ranking").clicked() {
                commands.push(Command::Chart(ChartCommand::CloseRanking));
            }
        });
    });
    if charts.ranking.is_empty() {
        no_points_ui(ui, state, Study::Ranking, ICON_PHOTO_LIBRARY, "", commands);
        return;
    }
    if let Some(words) = stale_words(state) {
        ui.label(RichText::new(words).color(Tokens::in_ui(ui).warning));
    }
    let left_out = state.doc.edits.list.cameras_left_out();
    ScrollArea::both().auto_shrink(false).show(ui, |ui| {
        let grid = Grid::new("ranked cameras").num_columns(5).spacing([14.0, 4.0]);
        grid.show(ui, |ui| {
            heads_ui(ui, &charts.ranking);
            for camera in &charts.ranking {
                row_ui(ui, scene, camera, &left_out, commands);
                ui.end_row();
            }
        });
        ui.add_space(space::SMALL);
    });
}

/// Why the figures are those of another state; `None` for current ones.
fn stale_words(state: &State) -> Option<&'static str> {
    let charts = &state.doc.charts;
    if charts.ranked_edits != state.doc.edits.list {
        return Some("Made before the last edit; rank again to see what is needless now.");
    }
    charts.stale_note(Study::Ranking, &state.settings)
}

fn heads_ui(ui: &mut Ui, ranking: &[CameraWorth]) {
    let accuracy = if ranking.iter().any(|camera| camera.loss_db.is_some()) {
        "What accuracy changes by without this camera, at the viewpoints whose true pictures are known."
    } else {
        "How near the other cameras come to this one's own pictures: the higher, the less it is needed."
    };
    let columns = [
        ("Without", ""),
        (
            "Less is seen",
            "The share of all seen surfaces that no other camera shows, at half of its sharpness or better.",
        ),
        ("Accuracy", accuracy),
        ("Store", "Bytes of the store more (+) or fewer (−) without this camera."),
        ("", ""),
    ];
    for (name, help) in columns {
        let head = note(ui, name);
        if !help.is_empty() {
            head.on_hover_text(help);
        }
    }
    ui.end_row();
}

fn row_ui(
    ui: &mut Ui,
    scene: &OpenScene,
    camera: &CameraWorth,
    left_out: &BTreeSet<&str>,
    commands: &mut Commands,
) {
    let index = scene.cameras.iter().position(|known| known.name == camera.name);
    ui.horizontal(|ui| {
        // In the width of the column before, a name that was cut off would stay so.
        ui.set_max_width(NAME);
        if let Some(index) = index {
            dot(ui, index);
        }
        let name = egui::Label::new(&camera.name).truncate().sense(egui::Sense::click());
        if let Some(index) = index.filter(|_| ui.add(name).on_hover_text(&camera.name).clicked()) {
            commands.push(Command::Source(SourceCommand::Camera(index)));
        }
    });
    let [seen, accuracy, bytes] = figures(camera);
    for figure in [seen, accuracy, bytes] {
        ui.label(figure);
    }
    if left_out.contains(camera.name.as_str()) {
        weak(ui, "Left out");
        return;
    }
    let button = ui.add_enabled(index.is_some(), Button::new("Leave out").small());
    let button = button.accessible_name(format!("Leave out {}", camera.name));
    if button.on_hover_text("An edit: nothing of it is used any more. Ctrl+Z undoes.").clicked() {
        commands.push(Command::Edit(EditCommand::LeaveOut(index.into_iter().collect())));
    }
}

/// How much less is seen without a camera, how accurate the rest is, and how many bytes fewer it takes.
fn figures(camera: &CameraWorth) -> [String; 3] {
    let accuracy = match camera.loss_db {
        Some(loss) => signed(-loss, 2, "dB"),
        None => format!("{:.1} dB", camera.psnr_filled_db),
    };
    let sign = if camera.bytes_less > 0 { "−" } else { "+" };
    let bytes = format!("{sign}{}", model::bytes(camera.bytes_less.unsigned_abs()));
    [signed(-100.0 * camera.seen_alone, 2, "%"), accuracy, bytes]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_lost_without_a_camera_has_its_sign() {
        let camera = CameraWorth {
            name: "left".to_owned(),
            seen_alone: 0.0123,
            psnr_filled_db: 31.25,
            loss_db: Some(0.5),
            samples_less: 10,
            bytes_less: 2_000_000,
        };
        assert_eq!(figures(&camera), ["−1.23 %", "−0.50 dB", "−2.00 MB"]);
        let needless = CameraWorth { seen_alone: 0.0, loss_db: None, bytes_less: -1000, ..camera };
        assert_eq!(figures(&needless), ["0.00 %", "31.2 dB", "+1.00 kB"]);
    }
}
