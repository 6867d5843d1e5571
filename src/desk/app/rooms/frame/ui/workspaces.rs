//! Workspaces, and the areas of the window that are shown.

use egui::Ui;

use crate::app::model::{Command, Commands, State};
use crate::app::rooms::frame::model::{Area, WindowCommand, Workspace};
use crate::app::theme::space;
use crate::app::widgets::{choice_ui, segments_ui, width_of_segments};

/// The workspaces, at the right end of what is left of a line; as a list where less than the `rest` would be left of it.
pub(crate) fn workspaces_ui(ui: &mut Ui, state: &State, rest: f32, commands: &mut Commands) {
    let now = state.look.workspace;
    let width = width_of_segments(ui, &Workspace::ALL);
    let chosen = if ui.available_width() < width + rest + 2.0 * space::MEDIUM {
        choice_ui(ui, "Workspace", now, &Workspace::ALL, 76.0)
    } else {
        let layout = egui::Layout::left_to_right(egui::Align::Center);
        let area = egui::vec2(width, space::CONTROL);
        ui.allocate_ui_with_layout(area, layout, |ui| segments_ui(ui, "Workspace", now, Workspace::ALL)).inner
    };
    commands.extend(chosen.map(|it| Command::Window(WindowCommand::Workspace(it))));
}

/// What of the window can be hidden, for the menu of views.
pub(crate) fn shown_parts_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    for (area, name, keys) in Area::ALL {
        let mut shown = state.look.shows(area);
        let text = if keys.is_empty() { name.to_owned() } else { format!("{name}  ({keys})") };
        if ui.checkbox(&mut shown, text).accessible_name(format!("Show {name}")).changed() {
            commands.push(Command::Window(WindowCommand::ShowArea(area, shown)));
        }
    }
    let mut totals = !state.look.hides_totals;
    if ui.checkbox(&mut totals, "Summary bar").accessible_name("Show Summary bar").changed() {
        commands.push(Command::Window(WindowCommand::ShowTotals(totals)));
    }
    ui.horizontal(|ui| {
        ui.label("Interface size");
        let percent = format!("{:.0} %", 100.0 * ui.ctx().zoom_factor());
        for (text, name, help, step) in [
            ("−", "Smaller interface", "Everything smaller (Ctrl+−)", -1),
            (percent.as_str(), "Normal interface", "As large as the system says (Ctrl+0)", 0),
            ("+", "Larger interface", "Everything larger (Ctrl++)", 1),
        ] {
            if ui.button(text).on_hover_text(help).accessible_name(name).clicked() {
                commands.push(Command::Window(WindowCommand::InterfaceSize(step)));
            }
        }
    });
    if ui.add(egui::Button::new("Full screen").shortcut_text("F11")).accessible_name("Full screen").clicked()
    {
        commands.push(Command::Window(WindowCommand::FullScreen));
    }
}
