//! The command palette: everything there is to do, by name.

use egui::{Id, Key, Modal, ScrollArea, TextEdit, Ui};

use crate::address;
use crate::app::model::command::{ViewCommand, WindowCommand};
use crate::app::model::window::CommandPalette;
use crate::app::model::{Command, Commands, State};
use crate::app::rooms::help::rank;
use crate::app::rooms::help::ui::entries::{PaletteEntry, entries};
use crate::app::theme::space;
use crate::app::widgets::{note, weak};

/// Entries shown at once.
const SHOWN: usize = 200;

/// Height of the list, points.
const LIST_HEIGHT: f32 = 320.0;

/// The palette, while it is open.
pub(crate) fn palette_ui(ctx: &egui::Context, state: &State, commands: &mut Commands) {
    let Some(palette) = &state.inspector.palette else { return };
    let mut next = Some(palette.clone());
    let modal = Modal::new(Id::unique("palette")).show(ctx, |ui| {
        ui.set_width(480.0);
        let matching = matching(state, &palette.text);
        let chosen = palette.chosen.min(matching.len().saturating_sub(1));
        let moved = ui.input_mut(|input| {
            let down = input.consume_key(egui::Modifiers::NONE, Key::ArrowDown);
            let up = input.consume_key(egui::Modifiers::NONE, Key::ArrowUp);
            i64::from(down) - i64::from(up)
        });
        let mut text = palette.text.clone();
        let field = TextEdit::singleline(&mut text)
            .desired_width(f32::INFINITY)
            .margin(egui::vec2(8.0, 6.0))
            .hint_text("Type a command, or paste the address of a view");
        let field = ui.add(field).accessible_name("Command");
        let taken = field.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter));
        if !taken {
            field.request_focus();
        }
        let last = matching.len().saturating_sub(1) as i64;
        let chosen = if text == palette.text { (chosen as i64 + moved).clamp(0, last) as usize } else { 0 };
        next = Some(CommandPalette { text, chosen });
        ui.add_space(space::SMALL);
        let clicked = entries_ui(ui, &matching, chosen);
        let entry = clicked.or(taken.then_some(chosen)).and_then(|index| matching.get(index));
        if let Some(entry) = entry.filter(|entry| entry.why_not.is_none()) {
            commands.push(entry.command.clone());
            next = None;
        }
    });
    if modal.should_close() {
        next = None;
    }
    if next.as_ref() != Some(palette) {
        commands.push(Command::Window(WindowCommand::Palette(next)));
    }
}

fn entries_ui(ui: &mut Ui, entries: &[PaletteEntry], chosen: usize) -> Option<usize> {
    let mut clicked = None;
    // The height is constant, so that the field above does not move.
    let list =
        ScrollArea::vertical().max_height(LIST_HEIGHT).min_scrolled_height(LIST_HEIGHT).auto_shrink(false);
    list.show(ui, |ui| {
        if entries.is_empty() {
            weak(ui, "No matching command.");
        }
        ui.with_layout(egui::Layout::top_down_justified(egui::Align::Min), |ui| {
            ui.spacing_mut().item_spacing.y = 1.0;
            for (index, entry) in entries.iter().enumerate().take(SHOWN) {
                let button = egui::Button::selectable(index == chosen, &entry.name).shortcut_text(entry.keys);
                let response = ui.add_enabled(entry.why_not.is_none(), button);
                let response = response.accessible_name(format!("Do: {}", entry.name));
                if index == chosen {
                    response.scroll_to_me(None);
                }
                if response.clicked() {
                    clicked = Some(index);
                }
                if let Some(why_not) = &entry.why_not {
                    note(ui, why_not);
                }
            }
        });
    });
    clicked
}

/// Going there, if `text` is an address; else the entries that it asks for, the likeliest first.
fn matching(state: &State, text: &str) -> Vec<PaletteEntry> {
    if address::split(text).is_some() {
        let command = Command::View(ViewCommand::GoToAddress(text.to_owned()));
        return vec![PaletteEntry::new("Go to this address", "", command)];
    }
    let wanted = text.to_lowercase();
    let asked_for = |entry: PaletteEntry| Some((rank(&wanted, &entry.name.to_lowercase())?, entry));
    let mut entries: Vec<_> = entries(state).into_iter().filter_map(asked_for).collect();
    entries.sort_by_key(|(rank, _)| *rank);
    entries.into_iter().map(|(_, entry)| entry).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::model::command::SettingsCommand;
    use overlook_engine::settings::Settings;

    #[test]
    fn what_people_type_is_found_and_no_raw_key_is_shown() {
        let state = State::default();
        for (typed, found) in [
            ("screensh", "Copy picture"),
            ("measure", "Run a sweep"),
            ("hole", "Hole filling: Push-pull"),
            ("background", "Holes: Fill"),
            ("film", "Share: Video"),
            ("ply", "Share: Splats"),
            ("chart", "Copy the sweep chart"),
            ("svg", "Save the stress test chart"),
            ("html", "Share: Interactive page"),
            ("rerun", "Recompute the whole capture"),
            ("kernel point", "Kernel: Point"),
            ("brush", "Edit: select by brush"),
            ("delete object", "Edit: delete selection"),
            ("flood fill", "Edit: select the same surface"),
            ("expand", "Edit: grow the selection"),
        ] {
            let names: Vec<String> = matching(&state, typed).into_iter().map(|entry| entry.name).collect();
            assert!(names.iter().any(|name| name == found), "{typed}: {names:?}");
        }
        for entry in entries(&state) {
            assert!(!Settings::fields().any(|field| entry.name.contains(field.path)), "{}", entry.name);
        }
    }

    #[test]
    fn what_a_word_means_most_likely_is_found_first() {
        let mut state = State::default();
        state.recent.push("/captures/kitchen.ovl".into());
        for (typed, first) in [
            ("bookmark", "Keep view"),
            ("field of view", "Open view: View"),
            ("fov", "Open view: View"),
            ("resolution", "Share: Pictures"),
            ("mesh", "Share: Splats"),
            ("blender", "Share: Splats"),
            ("dpi", "Share: Figure"),
            ("image", "Share: Pictures"),
            ("speed", "Open view: View"),
            ("redundant", "Open view: Report"),
            ("why", "Open view: Report"),
            ("colormap", "Open view: Color"),
            ("markdown", "Copy the camera table as Markdown"),
            ("latex", "Copy the camera table as LaTeX"),
            ("csv", "Copy the camera table as CSV"),
            ("help", "Guide"),
            ("exposure", "Open view: Color"),
            ("crop", "Edit: keep only the selection"),
            ("mask", "Edit: mask pixels of a camera"),
            ("delete", "Edit: delete selection"),
            ("gpu", "Renderer: GPU"),
            ("recent", "Open recent: kitchen.ovl"),
            ("undo", "Undo"),
            ("export", "Share…"),
            ("mp4", "Share: Video"),
            ("screensh", "Share: Pictures"),
            ("figure", "Share: Figure"),
        ] {
            let names: Vec<String> = matching(&state, typed).into_iter().map(|entry| entry.name).collect();
            assert_eq!(names.first().map(String::as_str), Some(first), "{typed}: {names:?}");
        }
    }

    #[test]
    fn switches_are_set_by_name() {
        let state = State::default();
        for (text, on) in [("line-of-sight test: on", true), ("line-of-sight test: off", false)] {
            let entry = matching(&state, text).into_iter().next().unwrap();
            let expected = SettingsCommand::Set { path: "render.free_space", value: on.into() };
            assert_eq!(entry.command, Command::Settings(expected));
        }
    }
}
