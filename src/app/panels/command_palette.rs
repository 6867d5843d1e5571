//! The command palette and the sheet of keys: everything there is to do, by name.

use egui::{Id, Key, Modal, RichText, ScrollArea, TextEdit, Ui};

use crate::app::control;
use crate::app::model::{
    ColorBy, Command, CommandPalette, Commands, DockView, HoleDisplay, Overlay, PRESETS, Purpose, State,
    Study,
};
use crate::app::theme::space;
use crate::app::widgets::weak;
use crate::demo::SCENES;
use crate::settings::{Settings, ValueKind};

/// Something to do: its name, its keys, and the wish.
struct PaletteEntry {
    name: String,
    keys: &'static str,
    command: Command,
}

/// Entries shown at once.
const SHOWN: usize = 200;

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
            .hint_text("What would you like to do?");
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
        if let Some(entry) = clicked.or(taken.then_some(chosen)).and_then(|index| matching.get(index)) {
            commands.push(entry.command.clone());
            next = None;
        }
    });
    if modal.should_close() {
        next = None;
    }
    if next.as_ref() != Some(palette) {
        commands.push(Command::Palette(next));
    }
}

fn entries_ui(ui: &mut Ui, entries: &[PaletteEntry], chosen: usize) -> Option<usize> {
    if entries.is_empty() {
        weak(ui, "Nothing of that name.");
        return None;
    }
    let mut clicked = None;
    ScrollArea::vertical().max_height(320.0).auto_shrink([false, true]).show(ui, |ui| {
        ui.with_layout(egui::Layout::top_down_justified(egui::Align::Min), |ui| {
            ui.spacing_mut().item_spacing.y = 1.0;
            for (index, entry) in entries.iter().enumerate().take(SHOWN) {
                let button = egui::Button::selectable(index == chosen, &entry.name).shortcut_text(entry.keys);
                let response = ui.add(button).accessible_name(format!("Do: {}", entry.name));
                if index == chosen {
                    response.scroll_to_me(None);
                }
                if response.clicked() {
                    clicked = Some(index);
                }
            }
        });
    });
    clicked
}

/// The entries whose names hold all words of `text`, those that begin with it first.
fn matching(state: &State, text: &str) -> Vec<PaletteEntry> {
    let wanted = text.to_lowercase();
    let words: Vec<&str> = wanted.split_whitespace().collect();
    let mut entries: Vec<PaletteEntry> = entries(state)
        .into_iter()
        .filter(|entry| {
            let name = entry.name.to_lowercase();
            words.iter().all(|word| name.contains(word))
        })
        .collect();
    entries.sort_by_key(|entry| !entry.name.to_lowercase().starts_with(&wanted));
    entries
}

fn entries(state: &State) -> Vec<PaletteEntry> {
    let mut entries = Vec::new();
    // Those of a store are not its own, and cannot be seen beside it.
    let turns = state.has_thresholds();
    let mut add = |name: String, keys: &'static str, command: Command| {
        entries.push(PaletteEntry { name, keys, command });
    };
    for (name, keys, command) in [
        ("Open folder", "", Command::AskPath(Purpose::OpenFolder)),
        ("Open file", "Ctrl+O", Command::AskPath(Purpose::OpenFile)),
        ("Open path", "", Command::TypePath(Purpose::OpenFile)),
        ("Save store", "Ctrl+S", Command::AskPath(Purpose::SaveStore)),
        ("Save settings", "", Command::AskPath(Purpose::SaveSettings)),
        ("Load settings", "", Command::AskPath(Purpose::LoadSettings)),
        ("Keep settings as a preset", "", Command::NamePreset(Some(String::new()))),
        ("Save picture", "", Command::AskPath(Purpose::SavePicture)),
        ("Copy picture", "", Command::CopyPicture),
        ("Export pictures of the camera path", "", Command::AskPath(Purpose::ExportPictures)),
        ("Export a film of the camera path", "", Command::AskPath(Purpose::ExportFilm)),
        ("Copy argument for the pixel", "Ctrl+Shift+C", Command::CopyExplanation),
        ("Undo", "Ctrl+Z", Command::Undo),
        ("Redo", "Ctrl+Y", Command::Redo),
        ("Reset all settings", "", Command::ResetAll),
        ("Switch between settings A and B", "", Command::SwitchSettings),
        ("Play or pause", "Space", Command::TogglePlay),
        ("Back to the first vantage", "Home", Command::Home),
        ("Frame the pixel that is looked at", "F", Command::FramePoint),
        ("Add key to the camera path", "K", Command::AddKey),
        ("Rerun", "", Command::Rerun),
        ("Run a sweep", "", Command::Study(Study::Sweep)),
        ("Run a stress test", "", Command::Study(Study::Stress)),
        ("Log and reset frame times", "", Command::LogFrameTimes),
        ("Cancel", "Esc", Command::Cancel),
        ("Light theme", "", Command::Dark(false)),
        ("Dark theme", "", Command::Dark(true)),
        ("Reset layout", "", Command::ResetLayout),
        ("Show the keys", "?", Command::CheatSheet(true)),
        ("Skip the introduction", "", Command::Introduced),
    ] {
        let changes_thresholds =
            matches!(command, Command::Undo | Command::Redo | Command::ResetAll | Command::SwitchSettings);
        if turns || !changes_thresholds {
            add(name.to_owned(), keys, command);
        }
    }
    for (view, name, _) in DockView::ALL {
        add(format!("Open view: {name}"), "", Command::OpenView(view));
    }
    for (overlay, name, _) in Overlay::ALL {
        add(format!("Source shows: {name}"), "", Command::Overlay(overlay));
    }
    for (color_by, name, _) in ColorBy::ALL {
        add(format!("Live view shows: {name}"), "", Command::ColorBy(color_by));
    }
    for (holes, name, _) in HoleDisplay::ALL {
        add(format!("Holes: {name}"), "H", Command::Holes(holes));
    }
    for (index, (name, ..)) in PRESETS.iter().enumerate().filter(|_| turns) {
        add(format!("Preset: {name}"), "", Command::Preset(index));
    }
    for (index, (name, _)) in state.inspector.presets.iter().enumerate().filter(|_| turns) {
        add(format!("Preset: {name}"), "", Command::OwnPreset(index));
    }
    for (name, _) in SCENES {
        add(format!("Demo: {name}"), "", Command::OpenDemo((*name).to_owned()));
    }
    for (index, camera) in state.scene.iter().flat_map(|scene| scene.cameras.iter().enumerate()) {
        add(format!("Show camera {}", camera.name), "1 – 9", Command::SourceCamera(index));
        add(format!("Stand where {} stood", camera.name), "Shift+1 – 9", Command::JumpTo(index));
    }
    for field in Settings::fields().filter(|field| turns || field.path.starts_with("render.")) {
        let values: Vec<(&str, toml::Value)> = match field.kind {
            ValueKind::Choice(names) => names.iter().map(|(value, _)| (*value, (*value).into())).collect(),
            ValueKind::Switch => vec![("on", true.into()), ("off", false.into())],
            // Numbers are turned on their sliders.
            ValueKind::Number { .. } | ValueKind::Integer { .. } => Vec::new(),
        };
        for (name, value) in values {
            add(format!("Set {} to {name}", field.path), "", Command::Set { path: field.path, value });
        }
    }
    entries
}

/// The sheet of keys, while it is open.
pub(crate) fn cheat_sheet_ui(ctx: &egui::Context, state: &State, commands: &mut Commands) {
    if !state.inspector.cheat_sheet {
        return;
    }
    let modal = Modal::new(Id::unique("cheat sheet")).show(ctx, |ui| {
        ui.heading("Keys and mouse");
        ui.add_space(space::SMALL);
        ui.horizontal_top(|ui| {
            for (column, list) in control::HELP.chunks(control::HELP.len().div_ceil(2)).enumerate() {
                egui::Grid::new(("keys", column)).num_columns(2).spacing([18.0, 5.0]).show(ui, |ui| {
                    for (keys, help) in list {
                        ui.label(RichText::new(*keys).strong());
                        ui.label(*help);
                        ui.end_row();
                    }
                });
                ui.add_space(space::LARGE);
            }
        });
        ui.add_space(space::MEDIUM);
        if ui.button("Close keys").clicked() {
            commands.push(Command::CheatSheet(false));
        }
    });
    if modal.should_close() {
        commands.push(Command::CheatSheet(false));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    #[test]
    fn switches_are_set_by_name() {
        let mut state = State::default();
        for (text, on) in [("set render.antialias to on", true), ("set render.antialias to off", false)] {
            let entry = matching(&state, text).into_iter().next().unwrap();
            let expected = Command::Set { path: "render.antialias", value: on.into() };
            assert_eq!(entry.command, expected);
            let Command::Set { path, value } = entry.command else { unreachable!() };
            state.settings.set(path, value).unwrap();
            assert_eq!(state.settings.render.antialias, on);
        }
    }
}
