//! The command palette: everything there is to do, by name.

use egui::{Id, Key, Modal, ScrollArea, TextEdit, Ui};

use super::palette_words::asks_for;
use crate::address;
use crate::app::model::{Command, Commands, State};
use crate::app::rooms::charts::model::{ChartCommand, Study};
use crate::app::rooms::edits::model::{EditCommand, EditTool};
use crate::app::rooms::files::model::{FileCommand, Opening, Purpose};
use crate::app::rooms::frame::model::{DockView, WindowCommand};
use crate::app::rooms::help::model::{CommandPalette, HelpPage};
use crate::app::rooms::live::model::{ColorBy, HoleDisplay, ViewCommand};
use crate::app::rooms::path::model::PathCommand;
use crate::app::rooms::pixel::model::PixelCommand;
use crate::app::rooms::readings::model::ReadingCommand;
use crate::app::rooms::settings::model::{PRESETS, SettingsCommand, setting_names};
use crate::app::rooms::source::model::{Overlay, SourceCommand};
use crate::app::rooms::timeline::model::TimeCommand;
use crate::app::theme::space;
use crate::app::widgets::{note, weak};
use overlook_engine::demo::SCENES;
use overlook_engine::edits::Action;
use overlook_engine::settings::{Settings, ValueKind};

/// Something to do: its name, its keys, and the wish.
struct PaletteEntry {
    name: String,
    keys: &'static str,
    command: Command,
    /// Why it cannot be done now; `None` if it can.
    why_not: Option<String>,
}

impl PaletteEntry {
    fn new(name: String, keys: &'static str, command: Command) -> Self {
        Self { name, keys, command, why_not: None }
    }
}

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

/// Of an address, going there; else the entries whose names hold all words of `text` or synonyms: first names that begin with it, last those found by synonyms.
fn matching(state: &State, text: &str) -> Vec<PaletteEntry> {
    if address::split(text).is_some() {
        let command = Command::View(ViewCommand::GoToAddress(text.to_owned()));
        return vec![PaletteEntry::new("Go to this address".to_owned(), "", command)];
    }
    let wanted = text.to_lowercase();
    let words: Vec<&str> = wanted.split_whitespace().collect();
    let mut entries: Vec<PaletteEntry> = entries(state)
        .into_iter()
        .filter(|entry| {
            let name = entry.name.to_lowercase();
            words.iter().all(|word| asks_for(word, &name))
        })
        .collect();
    entries.sort_by_cached_key(|entry| {
        let name = entry.name.to_lowercase();
        (!name.starts_with(&wanted), !words.iter().all(|word| name.contains(word)))
    });
    entries
}

/// The keys that show a camera and view from it, of the first nine.
const CAMERA_KEYS: [[&str; 2]; 9] = [
    ["1", "Shift+1"],
    ["2", "Shift+2"],
    ["3", "Shift+3"],
    ["4", "Shift+4"],
    ["5", "Shift+5"],
    ["6", "Shift+6"],
    ["7", "Shift+7"],
    ["8", "Shift+8"],
    ["9", "Shift+9"],
];

fn entries(state: &State) -> Vec<PaletteEntry> {
    let view_entries = crate::app::rooms::help::ui::view_entries::view_entries(state).into_iter();
    let mut entries: Vec<_> =
        view_entries.map(|(name, keys, command)| PaletteEntry::new(name, keys, command)).collect();
    // A store was made by thresholds that cannot be changed any more.
    let turns = state.has_thresholds();
    let mut add = |name: String, keys: &'static str, command: Command| {
        entries.push(PaletteEntry::new(name, keys, command));
    };
    for (name, keys, command) in fixed_commands() {
        let changes_thresholds = matches!(
            command,
            Command::Undo
                | Command::Redo
                | Command::Settings(SettingsCommand::ResetAll | SettingsCommand::Switch)
        );
        if turns || !changes_thresholds {
            add(name.to_owned(), keys, command);
        }
    }
    entries.push(PaletteEntry {
        why_not: state.why_no_readings(),
        ..PaletteEntry::new(
            "Compare readings".to_owned(),
            "",
            Command::Reading(ReadingCommand::Compare(true)),
        )
    });
    entries.extend(choices(state));
    entries.extend(settings(turns));
    entries
}

/// Entries that are there whatever is open.
fn fixed_commands() -> [(&'static str, &'static str, Command); 49] {
    [
        ("Open folder", "", Command::File(FileCommand::AskPath(Purpose::OpenFolder))),
        ("Open file", "Ctrl+O", Command::File(FileCommand::AskPath(Purpose::OpenFile))),
        ("Open path", "", Command::File(FileCommand::TypePath(Purpose::OpenFile))),
        ("Save settings", "", Command::File(FileCommand::AskPath(Purpose::SaveSettings))),
        ("Load settings", "", Command::File(FileCommand::AskPath(Purpose::LoadSettings))),
        ("Save edits", "", Command::File(FileCommand::AskPath(Purpose::SaveEdits))),
        ("Save session", "", Command::File(FileCommand::AskPath(Purpose::SaveSession))),
        ("Open edits", "", Command::File(FileCommand::AskPath(Purpose::LoadEdits))),
        ("Edit: delete selection", "Delete", Command::Edit(EditCommand::Act(Action::Delete))),
        ("Edit: keep only the selection", "", Command::Edit(EditCommand::Act(Action::KeepOnly))),
        ("Edit: select by rectangle", "R", Command::Edit(EditCommand::Tool(Some(EditTool::Rectangle)))),
        ("Edit: select by lasso", "L", Command::Edit(EditCommand::Tool(Some(EditTool::Lasso)))),
        ("Edit: select by brush", "B", Command::Edit(EditCommand::Tool(Some(EditTool::Brush)))),
        ("Edit: select the same surface", "T", Command::Edit(EditCommand::Tool(Some(EditTool::Surface)))),
        ("Edit: mask pixels of a camera", "Shift+B", Command::Edit(EditCommand::Tool(Some(EditTool::Mask)))),
        ("Edit: grow the selection", "G", Command::Edit(EditCommand::Grow(true))),
        ("Edit: shrink the selection", "Shift+G", Command::Edit(EditCommand::Grow(false))),
        ("Edit: invert the selection", "Ctrl+I", Command::Edit(EditCommand::Invert)),
        ("Edit: select nothing", "", Command::Edit(EditCommand::SelectNothing)),
        (
            "Save settings as a preset",
            "",
            Command::Settings(SettingsCommand::NamePreset(Some(String::new()))),
        ),
        ("Copy picture", "", Command::View(ViewCommand::CopyPicture)),
        ("Copy explanation", "Ctrl+Shift+C", Command::Pixel(PixelCommand::CopyExplanation)),
        ("Undo", "Ctrl+Z", Command::Undo),
        ("Redo", "Ctrl+Y", Command::Redo),
        ("Reset all settings", "", Command::Settings(SettingsCommand::ResetAll)),
        ("Switch between settings A and B", "", Command::Settings(SettingsCommand::Switch)),
        ("Play or pause", "Space", Command::Time(TimeCommand::TogglePlay)),
        ("Reset view to start", "Home", Command::View(ViewCommand::Home)),
        ("Back to the view before", "Alt+Left", Command::View(ViewCommand::Back)),
        ("Forward to the next view", "Alt+Right", Command::View(ViewCommand::Forward)),
        ("Center view on selected pixel", "F", Command::View(ViewCommand::FramePoint)),
        ("Add key to the camera path", "K", Command::Path(PathCommand::AddKey)),
        ("Recompute the whole capture", "", Command::Recompute),
        ("Run a sweep", "", Command::Chart(ChartCommand::Ask(Some(Study::Sweep)))),
        ("Run a stress test", "", Command::Chart(ChartCommand::Ask(Some(Study::Stress)))),
        ("Frame times: write to the log and reset", "", Command::LogFrameTimes),
        ("Cancel", "Esc", Command::Cancel),
        ("Light theme", "", Command::Window(WindowCommand::Dark(false))),
        ("Dark theme", "", Command::Window(WindowCommand::Dark(true))),
        ("Reset layout", "", Command::Window(WindowCommand::ResetLayout)),
        ("Guide", "", Command::Window(WindowCommand::Help(Some(HelpPage::Guide)))),
        ("What opens", "", Command::Window(WindowCommand::Help(Some(HelpPage::Sources)))),
        (
            "Keyboard and mouse shortcuts",
            "?",
            Command::Window(WindowCommand::Help(Some(HelpPage::Shortcuts))),
        ),
        ("About Overlook and its version", "", Command::Window(WindowCommand::Help(Some(HelpPage::About)))),
        ("Interface size: larger", "Ctrl++", Command::Window(WindowCommand::InterfaceSize(1))),
        ("Interface size: smaller", "Ctrl+−", Command::Window(WindowCommand::InterfaceSize(-1))),
        ("Interface size: normal", "Ctrl+0", Command::Window(WindowCommand::InterfaceSize(0))),
        ("Forget recent files", "", Command::File(FileCommand::ForgetRecent)),
        ("Close the introduction", "", Command::File(FileCommand::Introduced)),
    ]
}

/// What is chosen among views, overlays, presets, scenes, files and cameras.
fn choices(state: &State) -> Vec<PaletteEntry> {
    let mut entries = Vec::new();
    let turns = state.has_thresholds();
    let mut add = |name: String, keys: &'static str, command: Command| {
        entries.push(PaletteEntry::new(name, keys, command));
    };
    for (view, name, _) in DockView::ALL {
        add(format!("Open view: {name}"), "", Command::Window(WindowCommand::OpenView(view)));
    }
    for (overlay, name, _) in Overlay::ALL {
        add(format!("Source shows: {name}"), "", Command::Source(SourceCommand::Overlay(overlay)));
    }
    for (color_by, name, _) in ColorBy::ALL {
        add(format!("Live view shows: {name}"), "", Command::View(ViewCommand::ColorBy(color_by)));
    }
    for (holes, name, _) in HoleDisplay::ALL {
        add(format!("Holes: {name}"), "H", Command::View(ViewCommand::Holes(holes)));
    }
    for (index, (name, ..)) in PRESETS.iter().enumerate().filter(|_| turns) {
        add(format!("Preset: {name}"), "", Command::Settings(SettingsCommand::Preset(index)));
    }
    for (index, (name, _)) in state.inspector.presets.iter().enumerate().filter(|_| turns) {
        add(format!("Preset: {name}"), "", Command::Settings(SettingsCommand::OwnPreset(index)));
    }
    for path in &state.recent {
        let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy();
        add(
            format!("Open recent: {name}"),
            "",
            Command::File(FileCommand::Open(Opening::Path(path.clone()))),
        );
    }
    add("Demo: room, pruned".to_owned(), "", Command::File(FileCommand::Open(Opening::Room)));
    for (name, _) in SCENES {
        add(format!("Demo: {name}"), "", Command::File(FileCommand::Open(Opening::Demo((*name).to_owned()))));
    }
    for (index, camera) in state.doc.scene.iter().flat_map(|scene| scene.cameras.iter().enumerate()) {
        let [show, view] = CAMERA_KEYS.get(index).copied().unwrap_or_default();
        add(format!("Show camera '{}'", camera.name), show, Command::Source(SourceCommand::Camera(index)));
        add(format!("View from camera '{}'", camera.name), view, Command::View(ViewCommand::JumpTo(index)));
    }
    entries
}

/// Every setting, and every value that one of them can be given by name; `turns` where thresholds can be changed.
fn settings(turns: bool) -> Vec<PaletteEntry> {
    let mut entries = Vec::new();
    let mut add = |name: String, keys: &'static str, command: Command| {
        entries.push(PaletteEntry::new(name, keys, command));
    };
    for field in Settings::fields().filter(|field| turns || field.path.starts_with("render.")) {
        let setting = setting_names::name(field.path);
        add(format!("Setting: {setting}"), "", Command::Settings(SettingsCommand::Find(field.path)));
        let values: Vec<(String, toml::Value)> = match field.kind {
            ValueKind::Choice(names) => names
                .iter()
                .map(|(value, _)| (setting_names::choice(field.path, value), (*value).into()))
                .collect(),
            ValueKind::Switch => vec![("on".to_owned(), true.into()), ("off".to_owned(), false.into())],
            // Numbers are turned on their sliders.
            ValueKind::Number { .. } | ValueKind::Integer { .. } => Vec::new(),
        };
        for (name, value) in values {
            add(
                format!("{setting}: {name}"),
                "",
                Command::Settings(SettingsCommand::Set { path: field.path, value }),
            );
        }
    }
    entries
}

#[cfg(test)]
mod tests {
    use super::*;
    #[test]
    fn what_people_type_is_found_and_no_raw_key_is_shown() {
        let mut state = State::default();
        state.recent.push("/captures/kitchen.ovl".into());
        for (typed, found) in [
            ("help", "Guide"),
            ("zoom", "Interface size: larger"),
            ("fov", "Open view: View"),
            ("screenshot", "Share: Pictures"),
            ("screensh", "Copy picture"),
            ("measure", "Run a sweep"),
            ("recent", "Open recent: kitchen.ovl"),
            ("hole", "Hole filling: Push-pull"),
            ("background", "Holes: Fill"),
            ("exposure", "Open view: Color"),
            ("scale", "Interface size: smaller"),
            ("film", "Share: Video"),
            ("export", "Share…"),
            ("ply", "Share: Splats"),
            ("chart", "Copy the sweep chart"),
            ("svg", "Save the stress test chart"),
            ("html", "Share: Interactive page"),
            ("rerun", "Recompute the whole capture"),
            ("kernel point", "Kernel: Point"),
            ("brush", "Edit: select by brush"),
            ("mask", "Edit: mask pixels of a camera"),
            ("delete object", "Edit: delete selection"),
            ("crop", "Edit: keep only the selection"),
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
    fn switches_are_set_by_name() {
        let mut state = State::default();
        for (text, on) in [("line-of-sight test: on", true), ("line-of-sight test: off", false)] {
            let entry = matching(&state, text).into_iter().next().unwrap();
            let expected =
                Command::Settings(SettingsCommand::Set { path: "render.free_space", value: on.into() });
            assert_eq!(entry.command, expected);
            let Command::Settings(SettingsCommand::Set { path, value }) = entry.command else {
                unreachable!()
            };
            state.settings.set(path, value).unwrap();
            assert_eq!(state.settings.render.free_space, on);
        }
    }
}
