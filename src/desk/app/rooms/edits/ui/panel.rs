//! Selecting samples, deleting them, and the list of edits.

use egui::{Checkbox, DragValue, Label, RichText, ScrollArea, TextEdit, Ui};
use egui_material_icons::icons::{
    ICON_ARROW_DOWNWARD, ICON_ARROW_UPWARD, ICON_CONTENT_COPY, ICON_DELETE, ICON_REDO, ICON_UNDO,
};

use super::numbers::{GROW_BY, numbers_ui};
use super::tools::{cameras_ui, mask_ui, range_ui, select_ui};
use crate::app::model;
use crate::app::model::{Command, Commands, State};
use crate::app::rooms::edits::model::{
    EditCommand, EditTime, EditTools, SceneEdits, last_shape, words as region_words,
};
use crate::app::rooms::files::model::{FileCommand, Purpose};
use crate::app::rooms::live::ui::view_panel::heading_ui;
use crate::app::theme::{Tokens, space};
use crate::app::widgets::{icon_button, note, segments_ui, weak};
use overlook_engine::edits::{Action, Edit};

const ASKS_WHOLE: &str = "Edits act on all frames: they are shown once the whole capture is pruned.";

/// The panel.
pub(crate) fn edits_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    if state.doc.scene.is_none() {
        return;
    }
    let mut sent = Vec::new();
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        ui.set_max_width(ui.available_width() - space::MEDIUM);
        select_ui(ui, state, &mut sent);
        selection_ui(ui, state, &mut sent);
        mask_ui(ui, state, &mut sent);
        list_ui(ui, state, &mut sent, commands);
        files_ui(ui, state, commands);
    });
    commands.extend(sent.into_iter().map(Command::Edit));
}

/// What is selected, its numbers, and what can be done with it.
fn selection_ui(ui: &mut Ui, state: &State, sent: &mut Vec<EditCommand>) {
    let edits = &state.doc.edits;
    let Some(selection) = &edits.selection else {
        weak(ui, "Nothing is selected.");
        return;
    };
    ui.add(Label::new(RichText::new(region_words(selection)).strong()).truncate());
    let facts = match state.edited_now().filter(|_| edits.trouble.is_none()) {
        Some(edited) => {
            let left = edited.before - edited.deleted;
            let bytes = edited.bytes as f64 * edited.selected as f64 / left.max(1) as f64;
            format!(
                "{} ({}), {} in memory",
                model::count_of(edited.selected, "sample"),
                model::percent(edited.selected, left),
                model::bytes(bytes as u64)
            )
        }
        None if state.samples_to_edit().is_none() => ASKS_WHOLE.to_owned(),
        None if edits.trouble.is_some() => String::new(),
        None => "Selecting…".to_owned(),
    };
    note(ui, facts);
    let mut reshaped = selection.clone();
    if let Some(shape) = last_shape(&mut reshaped)
        && numbers_ui(ui, shape, state)
    {
        sent.push(EditCommand::Reshape(Some(reshaped)));
    }
    if state.has_time()
        && let Some(time) = segments_ui(ui, "Edit acts at", edits.tools.time, EditTime::ALL)
    {
        sent.push(EditCommand::Tools(EditTools { time, ..edits.tools }));
    }
    if state.has_time() && edits.tools.time == EditTime::Range {
        ui.horizontal(|ui| range_ui(ui, state, "Edit", sent));
    }
    ui.horizontal_wrapped(|ui| {
        for (name, help, command) in [
            ("Delete", "Delete what is selected (Delete).", EditCommand::Act(Action::Delete)),
            ("Keep only", "Delete all but what is selected.", EditCommand::Act(Action::KeepOnly)),
            (
                "Restore",
                "Bring back what edits above delete of what is selected.",
                EditCommand::Act(Action::Restore),
            ),
            ("Invert", "Select what is not selected (Ctrl+I).", EditCommand::Reshape(edits.inverted())),
            ("Clear", "Select nothing (Esc).", EditCommand::SelectNothing),
        ] {
            let button = ui.button(name).accessible_name(format!("{name} selection"));
            if button.on_hover_text(help).clicked() {
                sent.push(command);
            }
        }
    });
    grow_ui(ui, edits, sent);
}

/// Grows and shrinks the selection.
fn grow_ui(ui: &mut Ui, edits: &SceneEdits, sent: &mut Vec<EditCommand>) {
    ui.horizontal_wrapped(|ui| {
        for (name, help, grows) in [
            ("Grow", "Select what is near the selection as well (G).", true),
            ("Shrink", "Take what is near its border out of the selection (Shift+G).", false),
        ] {
            let button = ui.button(name).accessible_name(format!("{name} selection"));
            if button.on_hover_text(help).clicked() {
                sent.push(EditCommand::Reshape(edits.grown(grows)));
            }
        }
        ui.label("by");
        let mut by = edits.tools.grow_by;
        let drag = DragValue::new(&mut by).speed(0.1).max_decimals(1).range(GROW_BY).suffix(" footprints");
        let drag = ui.add(drag).on_hover_text("Widths of a pixel where the sample lies.");
        if drag.accessible_name("Grow by").changed() {
            sent.push(EditCommand::Tools(EditTools { grow_by: by, ..edits.tools }));
        }
    });
}

fn list_ui(ui: &mut Ui, state: &State, sent: &mut Vec<EditCommand>, commands: &mut Commands) {
    let edits = &state.doc.edits;
    heading_ui(ui, "List of edits");
    if edits.list.edits.is_empty() {
        weak(ui, "No edits yet. What is deleted stays in the list, to be switched off or saved.");
    }
    let last = edits.list.edits.len().saturating_sub(1);
    let mut selects = None;
    let mut change = |named: Option<usize>, change: &dyn Fn(&mut Vec<Edit>)| {
        let mut list = edits.list.clone();
        change(&mut list.edits);
        sent.push(EditCommand::List(list, named));
    };
    for (index, edit) in edits.list.edits.iter().enumerate() {
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 2.0;
            let mut on = edit.is_on;
            if ui
                .add(Checkbox::without_text(&mut on))
                .accessible_name(format!("Edit {} acts", index + 1))
                .changed()
            {
                change(None, &|edits| edits[index].is_on = on);
            }
            let mut name = edit.name.clone();
            let width = (ui.available_width() - 148.0).max(60.0);
            let field = ui.add(TextEdit::singleline(&mut name).desired_width(width));
            let field = field.accessible_name(format!("Name of edit {}", index + 1));
            if field.on_hover_text(region_words(&edit.region)).changed() {
                change(Some(index), &|edits| name.clone_into(&mut edits[index].name));
            }
            for (icon, name, to) in [
                (ICON_ARROW_UPWARD, "Move edit up", index.checked_sub(1)),
                (ICON_ARROW_DOWNWARD, "Move edit down", (index < last).then_some(index + 1)),
            ] {
                ui.add_enabled_ui(to.is_some(), |ui| {
                    if let (true, Some(to)) = (icon_button(ui, icon, name, name).clicked(), to) {
                        change(None, &|edits| edits.swap(index, to));
                    }
                });
            }
            let help = "Select the region of this edit, to reshape it or to combine it with others";
            if icon_button(ui, ICON_CONTENT_COPY, "Select region of edit", help).clicked() {
                selects = Some(edit.region.clone());
            }
            if icon_button(ui, ICON_DELETE, "Remove edit", "Take this edit out of the list").clicked() {
                change(None, &|edits| drop(edits.remove(index)));
            }
        });
    }
    sent.extend(selects.map(|region| EditCommand::Reshape(Some(region))));
    if let Some(trouble) = &edits.trouble {
        ui.add(Label::new(RichText::new(trouble).color(Tokens::in_ui(ui).error)).wrap());
    } else if let Some(edited) = state.edited().filter(|edited| edited.deleted > 0) {
        let deleted = model::count_of(edited.deleted, "sample");
        let share = model::percent(edited.deleted, edited.before);
        note(ui, format!("{deleted} deleted ({share}); {} in memory", model::bytes(edited.bytes)));
    } else if edits.are_in_use() && state.samples_to_edit().is_none() {
        note(ui, ASKS_WHOLE);
    }
    ui.horizontal_wrapped(|ui| {
        let scene = state.doc.scene.as_ref();
        let leave_out = |name: &str| {
            let index = scene.and_then(|scene| scene.cameras.iter().position(|camera| camera.name == name));
            EditCommand::LeaveOut(index.into_iter().collect())
        };
        cameras_ui(ui, state, "Leave out camera", leave_out, sent);
        for (icon, name, help, command, is_possible) in [
            (
                ICON_UNDO,
                "Undo edit",
                "Undo the last edit (Ctrl+Z)",
                Command::Undo,
                state.would_step_edits(true),
            ),
            (ICON_REDO, "Redo edit", "Redo it (Ctrl+Shift+Z)", Command::Redo, state.would_step_edits(false)),
        ] {
            ui.add_enabled_ui(is_possible, |ui| {
                if icon_button(ui, icon, name, help).clicked() {
                    commands.push(command);
                }
            });
        }
    });
}

fn files_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    ui.add_space(space::MEDIUM);
    ui.horizontal_wrapped(|ui| {
        for (name, help, command) in [
            (
                "Save edits…",
                "Write the list as text, which overlook preprocess, render, export and edit obey.",
                Purpose::SaveEdits,
            ),
            ("Open edits…", "Put a list that was saved in the place of this one.", Purpose::LoadEdits),
            ("Save cleaned store…", SAVES, Purpose::SaveStore),
        ] {
            if ui.button(name).on_hover_text(help).clicked() {
                commands.push(Command::File(FileCommand::AskPath(command)));
            }
        }
    });
    if state.has_capture() && !state.doc.edits.list.is_idle() {
        weak(
            ui,
            "Saving prunes the capture again: cameras that are left out take no part, and nothing brings deleted things back.",
        );
    }
}

const SAVES: &str = "Write what edits leave as a store. Cameras that are hidden in the View panel are saved; those that are left out here are not.";
