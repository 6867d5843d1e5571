//! Settings to start from: those that come along, one's own, and a field to name new ones.

use egui::{Button, Id, Modal, Ui};
use egui_material_icons::icons::ICON_DELETE;

use crate::app::model::{Command, Commands, PRESETS, State};
use crate::app::theme::space;
use crate::app::widgets::{icon_button, note, text_field_ui, weak};

/// The menu, as wide as there is room.
pub(crate) fn menu_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    let button = Button::new("Presets…").min_size(egui::vec2(ui.available_width() - space::MEDIUM, 0.0));
    let (response, _) = egui::containers::menu::MenuButton::from_button(button).ui(ui, |ui| {
        ui.set_min_width(220.0);
        for (index, (name, help, _)) in PRESETS.iter().enumerate() {
            if ui.button(*name).on_hover_text(*help).clicked() {
                commands.push(Command::Preset(index));
            }
        }
        ui.separator();
        note(ui, "Your own");
        for (index, (name, _)) in state.inspector.presets.iter().enumerate() {
            ui.horizontal(|ui| {
                if ui.button(name).clicked() {
                    commands.push(Command::OwnPreset(index));
                    ui.close();
                }
                let forget = format!("Forget preset {name}");
                if icon_button(ui, ICON_DELETE, &forget, &forget).clicked() {
                    commands.push(Command::RemovePreset(index));
                }
            });
        }
        if ui.button("Keep these settings…").on_hover_text("Keeps them under a name, for next time").clicked()
        {
            commands.push(Command::NamePreset(Some(String::new())));
        }
    });
    response.accessible_name("Presets");
}

/// The field for a name, while a new preset is named.
pub(crate) fn naming_ui(ctx: &egui::Context, state: &State, commands: &mut Commands) {
    let Some(name) = &state.inspector.naming else { return };
    let modal = Modal::new(Id::unique("naming a preset")).show(ctx, |ui| {
        ui.set_width(360.0);
        ui.heading("Keep these settings");
        let taken = state.inspector.presets.iter().any(|(known, _)| known == name.trim());
        let words =
            if taken { "This name is taken: its settings will be replaced." } else { "Under which name?" };
        weak(ui, words);
        ui.add_space(space::MEDIUM);
        let mut text = name.clone();
        let (changed, entered) = text_field_ui(ui, &mut text, "", "Name of the preset");
        let named = !text.trim().is_empty();
        if changed {
            commands.push(Command::NamePreset(Some(text.clone())));
        }
        ui.add_space(space::MEDIUM);
        ui.horizontal(|ui| {
            let keep = ui.add_enabled(named, Button::new("Keep")).accessible_name("Keep this preset");
            if (keep.clicked() || entered) && named {
                commands.push(Command::SavePreset(text));
            }
            if ui.button("Close").clicked() {
                commands.push(Command::NamePreset(None));
            }
        });
    });
    if modal.should_close() {
        commands.push(Command::NamePreset(None));
    }
}
