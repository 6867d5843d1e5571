//! The keys of the path: a list.

use egui::{Button, DragValue, Grid, RichText, Ui};
use egui_material_icons::icons::{
    ICON_ARROW_DOWNWARD, ICON_ARROW_UPWARD, ICON_DELETE, ICON_RESTART_ALT, ICON_UPDATE,
};

use crate::app::model::{Command, Commands, State};
use crate::app::rooms::live::ui::view_picture_ui;
use crate::app::rooms::path::model::{KeyNeighbor, PathCommand, SavedPathKey};
use crate::app::widgets::{icon_button, weak};

const MOVE: &str = "Move this view in the list. Frames stay in their order.";

/// Width from which on a key takes one line, with its position.
const ROOMY: f32 = 640.0;

pub(super) fn keys_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    let keys = 0..state.doc.path.keys.len();
    if ui.available_width() > ROOMY {
        Grid::new("keys of the path").striped(true).spacing(egui::vec2(18.0, 3.0)).show(ui, |ui| {
            for index in keys {
                key_ui(ui, state, index, true, commands);
                ui.horizontal(|ui| leg_ui(ui, state, index, commands));
                ui.horizontal(|ui| buttons_ui(ui, state, index, commands));
                ui.end_row();
            }
        });
        return;
    }
    for index in keys {
        ui.horizontal(|ui| key_ui(ui, state, index, false, commands));
        ui.horizontal(|ui| {
            buttons_ui(ui, state, index, commands);
            leg_ui(ui, state, index, commands);
        });
    }
}

/// A key: its picture, its number, its position where there is room for it, and its frame.
fn key_ui(ui: &mut Ui, state: &State, index: usize, is_roomy: bool, commands: &mut Commands) {
    let path = &state.doc.path;
    let (key, number) = (&path.keys[index], index + 1);
    let at = key.orbit.world_from_camera.translation;
    let place = format!("{:.2}, {:.2}, {:.2}", at.x, at.y, at.z);
    let view = state.address_of(&key.orbit, key.frame);
    let picture = view.and_then(|view| state.doc.view_pictures.of(&view));
    let is_clicked = view_picture_ui(ui, picture, &format!("key {number}"));
    let button = Button::new(format!("Key {number}")).selected(path.selected == Some(index));
    let help = format!("Go to this key, at {place}");
    if ui.add(button).on_hover_text(help).clicked() || is_clicked {
        commands.push(Command::Path(PathCommand::GoToKey(index)));
    }
    if is_roomy {
        ui.label(RichText::new(place).monospace());
    }
    weak(ui, format!("frame {}", key.frame + 1));
}

/// What is done with a key.
fn buttons_ui(ui: &mut Ui, state: &State, index: usize, commands: &mut Commands) {
    let path = &state.doc.path;
    let (number, last) = (index + 1, path.keys.len() - 1);
    let here = format!("Set key {number} to the current view");
    if icon_button(ui, ICON_UPDATE, &here, "Set this key to the current view").clicked() {
        commands.extend(state.key_here().map(|here| {
            Command::Path(PathCommand::change(path, None, |path| {
                let key = &mut path.keys[index];
                *key = SavedPathKey { pictures: key.pictures, ..here };
            }))
        }));
    }
    for (icon, to, with, can) in [
        (ICON_ARROW_UPWARD, "up", KeyNeighbor::Before, index > 0),
        (ICON_ARROW_DOWNWARD, "down", KeyNeighbor::Behind, index < last),
    ] {
        let name = format!("Move key {number} {to}");
        let move_ui = |ui: &mut Ui| icon_button(ui, icon, &name, MOVE).clicked();
        if ui.add_enabled_ui(can, move_ui).inner {
            commands
                .push(Command::Path(PathCommand::change(path, None, |path| path.exchange_key(index, with))));
        }
    }
    let remove = format!("Remove key {number}");
    if icon_button(ui, ICON_DELETE, &remove, "Remove this key").clicked() {
        commands.push(Command::Path(PathCommand::change(path, None, |path| path.remove_key(index))));
    }
}

const LEG: &str = "Seconds from this key to the next. A longer way is slow motion where time passes.";

/// How long the way from a key to the next takes.
fn leg_ui(ui: &mut Ui, state: &State, leg: usize, commands: &mut Commands) {
    let path = &state.doc.path;
    if !path.has_leg(leg) {
        return;
    }
    let (rate, number) = (f64::from(state.timeline.frames_per_second), leg + 1);
    let mut seconds = path.pictures_of_leg(leg) as f64 / rate;
    let drag = DragValue::new(&mut seconds).range(0.0..=3600.0).speed(0.02).max_decimals(2).suffix(" s");
    let field = ui.add(drag.update_while_editing(false)).on_hover_text(LEG);
    let key = Some(leg);
    if field.accessible_name(format!("Seconds behind key {number}")).changed() {
        commands.push(Command::Path(PathCommand::change(path, key, |path| {
            path.set_leg(leg, Some(seconds * rate))
        })));
    }
    if path.keys[leg].pictures.is_some() {
        let name = format!("As long behind key {number} as elsewhere");
        if icon_button(ui, ICON_RESTART_ALT, &name, "As long as the other segments").clicked() {
            commands.push(Command::Path(PathCommand::change(path, key, |path| path.set_leg(leg, None))));
        }
    }
}
