//! The one button beside the tabs of a view whose menu copies and saves what the view shows: its chart, and its tables.

use egui::{Button, Ui};
use egui_material_icons::icons::{ICON_ARROW_DROP_DOWN, ICON_DOWNLOAD};

use crate::app::model::command::FileCommand;
use crate::app::model::purpose::{Purpose, Table, TableForm};
use crate::app::model::window::{Area, DockView};
use crate::app::model::{Command, Commands, State, sentence};
use crate::app::rooms::charts::state::Study;
use crate::app::rooms::charts::ui::parts::chart_commands;
use crate::app::rooms::report::table_text;
use crate::app::widgets::{NARROW, note};

/// What a view shows in numbers, and the chart that it draws of them.
fn contents(view: DockView) -> (Option<Study>, &'static [Table]) {
    const REPORT: [Table; 6] = [
        Table::Pixels,
        Table::Cameras,
        Table::Memory,
        Table::Alignment,
        Table::Replacements,
        Table::Agreement,
    ];
    match view {
        DockView::Report => (None, &REPORT),
        DockView::Pixel => (None, &[Table::Pixel]),
        DockView::Time => (None, &[Table::Spans]),
        DockView::Tradeoff => (Some(Study::Sweep), &[Table::Sweep]),
        DockView::Stability => (Some(Study::Stress), &[Table::StressTest]),
        _ => (None, &[]),
    }
}

/// The button, where the view has something to export.
pub(crate) fn export_ui(ui: &mut Ui, view: DockView, state: &State, commands: &mut Commands) {
    let (study, tables) = contents(view);
    if tables.is_empty() {
        return;
    }
    // The tabs of the side panel need the room.
    let button = if ui.available_width() < NARROW || view.area() == Some(Area::Side) {
        Button::new(ICON_DOWNLOAD.rich_text().size(16.0))
    } else {
        Button::new(("Export", ICON_ARROW_DROP_DOWN.rich_text()))
    };
    let (response, _) = egui::containers::menu::MenuButton::from_button(button).ui(ui, |ui| {
        ui.set_min_width(190.0);
        let is_there = |table: &Table| table_text(*table, TableForm::Csv, state).is_some();
        let tables: Vec<Table> = tables.iter().copied().filter(is_there).collect();
        if tables.is_empty() {
            note(ui, "Nothing to export yet.");
            return;
        }
        for (verb, command) in
            study.into_iter().flat_map(|study| ["Copy", "Save"].into_iter().zip(chart_commands(study)))
        {
            let dots = if verb == "Save" { "…" } else { "" };
            let name = format!("{verb} the {}", study.map_or_else(String::new, Study::chart_name));
            let entry = ui.button(format!("{verb} chart{dots}")).accessible_name(name);
            if entry.on_hover_text("The series that are shown, on white paper.").clicked() {
                commands.push(command);
            }
        }
        let several = tables.len() > 1;
        for table in tables {
            if several {
                ui.menu_button(sentence(table.name()), |ui| entries_ui(ui, table, commands));
            } else {
                entries_ui(ui, table, commands);
            }
        }
    });
    let name = format!("Export {}", view.name_and_help().0);
    response.accessible_name(name).on_hover_text("Copy or save what is shown here.");
}

/// What a table is copied as, and saved.
fn entries_ui(ui: &mut Ui, table: Table, commands: &mut Commands) {
    let copies =
        TableForm::ALL.map(|(form, name, _)| (format!("Copy {name}"), Command::CopyTable(table, form)));
    let save = ("Save table…".to_owned(), Command::File(FileCommand::AskPath(Purpose::SaveTable(table))));
    for (name, command) in copies.into_iter().chain([save]) {
        if ui.button(&name).accessible_name(format!("{name} of the {}", table.name())).clicked() {
            commands.push(command);
        }
    }
}
