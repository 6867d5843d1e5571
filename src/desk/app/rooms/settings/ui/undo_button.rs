//! The buttons that take changes back and make them again, with the list of these changes.

use egui::{Button, Ui};
use egui_material_icons::icons::{ICON_REDO, ICON_UNDO};

use crate::app::model::{Command, Commands, State};
use crate::app::widgets::{bare_icon_button, note};

/// Width of the list, points.
const LIST_WIDTH: f32 = 320.0;

/// The button for undo, or for redo: it names the change, and a right click lists the next ones, to go back to any.
pub(crate) fn undo_button_ui(ui: &mut Ui, state: &State, undo: bool, commands: &mut Commands) {
    let (icon, name, keys, command) = if undo {
        (ICON_UNDO, "Undo", "Ctrl+Z", Command::Undo)
    } else {
        (ICON_REDO, "Redo", "Ctrl+Y", Command::Redo)
    };
    let button = ui.add_enabled_ui(state.can_undo(undo), |ui| bare_icon_button(ui, icon, name)).inner;
    let button = button.on_disabled_hover_text(format!("Nothing to {} ({keys}).", name.to_lowercase()));
    // What it would say is worked out only where it is read.
    let button = button.on_hover_ui(|ui| {
        let change = state.undo_list(undo).into_iter().next().unwrap_or_default();
        ui.label(format!("{name} ({keys}): {change}\nRight-click: the changes before it."));
    });
    if button.clicked() {
        commands.push(command.clone());
    }
    button.context_menu(|ui| {
        ui.set_width(LIST_WIDTH);
        note(ui, if undo { "Undo up to" } else { "Redo up to" });
        for (nth, change) in state.undo_list(undo).into_iter().enumerate() {
            let entry = ui.add(Button::new(change.as_str()).truncate());
            if entry.accessible_name(format!("{name} {}: {change}", nth + 1)).clicked() {
                commands.extend(std::iter::repeat_n(command.clone(), nth + 1));
                ui.close();
            }
        }
    });
}
