//! What is open, and what can be opened and saved.

use egui::{Align, Button, Color32, Label, Layout, RichText, Ui};
use egui_material_icons::icons::{
    ICON_DARK_MODE, ICON_DASHBOARD, ICON_FOLDER_OPEN, ICON_HELP, ICON_LIGHT_MODE, ICON_SAVE, ICON_SCIENCE,
    ICON_TERMINAL,
};

use super::workspaces::{shown_parts_ui, workspaces_ui};
use crate::app::model;
use crate::app::model::{Command, Commands, SceneSource, State};
use crate::app::rooms::files::model::{FileCommand, Opening, Purpose};
use crate::app::rooms::frame::model::{DockView, WindowCommand};
use crate::app::rooms::help::model::{CommandPalette, HelpPage};
use crate::app::rooms::live::model::ViewCommand;
use crate::app::rooms::readings::model::ReadingCommand;
use crate::app::rooms::share::model::ShareCommand;
use crate::app::theme::{Tokens, space};
use crate::app::widgets::{icon_button, note};
use overlook_engine::demo::SCENES;
use overlook_engine::plural::counted;

pub(crate) fn top_bar_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    let tokens = Tokens::in_ui(ui);
    ui.horizontal_centered(|ui| {
        ui.label(RichText::new("Overlook").heading().color(tokens.text));
        ui.add_space(space::MEDIUM);
        open_menu_ui(ui, state, commands);
        save_menu_ui(ui, state, commands);
        demo_menu_ui(ui, commands);
        views_menu_ui(ui, state, commands);
        help_menu_ui(ui, commands);
        ui.add_space(space::MEDIUM);
        let title = title_of(state);
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            let (icon, name) =
                if state.dark { (ICON_LIGHT_MODE, "Light theme") } else { (ICON_DARK_MODE, "Dark theme") };
            if icon_button(ui, icon, name, name).clicked() {
                commands.push(Command::Window(WindowCommand::Dark(!state.dark)));
            }
            if icon_button(ui, ICON_TERMINAL, "Commands", "Find any command by name (Ctrl+P)").clicked() {
                commands.push(Command::Window(WindowCommand::Palette(Some(CommandPalette::default()))));
            }
            workspaces_ui(ui, state, width_of(ui, title.as_ref()), commands);
            // What is open gives way: all else is pressed.
            ui.with_layout(Layout::left_to_right(Align::Center), |ui| title_ui(ui, state, title));
        });
    });
}

fn item<'a>(name: &'a str, keys: &'a str) -> Button<'a> {
    let button = Button::new(name);
    if keys.is_empty() { button } else { button.shortcut_text(keys) }
}

fn menu_ui(ui: &mut Ui, icon: egui_material_icons::MaterialIcon, name: &str, contents: impl FnOnce(&mut Ui)) {
    let button = Button::new((icon.rich_text().size(16.0), name));
    let (response, _) = egui::containers::menu::MenuButton::from_button(button).ui(ui, |ui| {
        ui.set_min_width(210.0);
        contents(ui);
    });
    response.accessible_name(name);
}

fn open_menu_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    menu_ui(ui, ICON_FOLDER_OPEN, "Open", |ui| {
        for (name, keys, command) in [
            ("Open folder…", "", Command::File(FileCommand::AskPath(Purpose::OpenFolder))),
            ("Open file…", "Ctrl+O", Command::File(FileCommand::AskPath(Purpose::OpenFile))),
            ("Load settings…", "", Command::File(FileCommand::AskPath(Purpose::LoadSettings))),
            ("Open edits…", "", Command::File(FileCommand::AskPath(Purpose::LoadEdits))),
        ] {
            if ui.add(item(name, keys)).accessible_name(name).clicked() {
                commands.push(command);
            }
        }
        let why_not = state.why_no_readings();
        let compare = ui.add_enabled(why_not.is_none(), Button::new("Compare readings…"));
        let help = "Show how poses and depth are read, and how they would fit better.";
        if compare.on_hover_text(help).on_disabled_hover_text(why_not.unwrap_or_default()).clicked() {
            commands.push(Command::Reading(ReadingCommand::Compare(true)));
        }
        if state.recent.is_empty() {
            return;
        }
        ui.separator();
        note(ui, "Recent");
        for path in &state.recent {
            let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy();
            if ui.button(name).on_hover_text(path.display().to_string()).clicked() {
                commands.push(Command::File(FileCommand::Open(Opening::Path(path.clone()))));
            }
        }
        if ui.button("Forget recent files").clicked() {
            commands.push(Command::File(FileCommand::ForgetRecent));
        }
    });
}

fn save_menu_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    menu_ui(ui, ICON_SAVE, "Save", |ui| {
        let (opened, shown) = (state.doc.scene.is_some(), state.doc.live_shown.is_some());
        for (name, keys, enabled, command) in [
            ("Share…", "Ctrl+E", opened, Command::Share(ShareCommand::Open(None))),
            ("Copy picture", "", shown, Command::View(ViewCommand::CopyPicture)),
            ("Copy the address of this view", "Ctrl+L", opened, Command::View(ViewCommand::CopyAddress)),
            ("Copy as command line", "", opened, Command::File(FileCommand::CopyCommandLine)),
            ("Save session…", "", opened, Command::File(FileCommand::AskPath(Purpose::SaveSession))),
            ("Save settings…", "", true, Command::File(FileCommand::AskPath(Purpose::SaveSettings))),
            ("Save edits…", "", opened, Command::File(FileCommand::AskPath(Purpose::SaveEdits))),
        ] {
            let button = ui
                .add_enabled(enabled, item(name, keys))
                .accessible_name(name)
                .on_disabled_hover_text("Nothing is shown yet.");
            if button.clicked() {
                commands.push(command);
            }
        }
    });
}

fn demo_menu_ui(ui: &mut Ui, commands: &mut Commands) {
    menu_ui(ui, ICON_SCIENCE, "Demo", |ui| {
        let room =
            ui.button("Room, pruned").on_hover_text("The room that the program comes with: opens at once.");
        if room.clicked() {
            commands.push(Command::File(FileCommand::Open(Opening::Room)));
        }
        for (name, help) in SCENES {
            if ui.button(model::words(name)).on_hover_text(*help).clicked() {
                commands.push(Command::File(FileCommand::Open(Opening::Demo((*name).to_owned()))));
            }
        }
    });
}

fn views_menu_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    menu_ui(ui, ICON_DASHBOARD, "Panels", |ui| {
        // In two columns, so that all of the menu fits a window 640 points high.
        egui::Grid::new("views").num_columns(2).show(ui, |ui| {
            let views = DockView::ALL.into_iter().filter(|(view, ..)| state.has_use_of(*view));
            for (nth, (view, name, help)) in views.enumerate() {
                let button = ui.button(name).on_hover_text(help);
                if button.accessible_name(format!("Open view {name}")).clicked() {
                    commands.push(Command::Window(WindowCommand::OpenView(view)));
                }
                if nth % 2 == 1 {
                    ui.end_row();
                }
            }
        });
        ui.separator();
        shown_parts_ui(ui, state, commands);
        ui.separator();
        if ui.button("Reset layout").on_hover_text("Put all views where they were at first").clicked() {
            commands.push(Command::Window(WindowCommand::ResetLayout));
        }
    });
}

fn help_menu_ui(ui: &mut Ui, commands: &mut Commands) {
    menu_ui(ui, ICON_HELP, "Help", |ui| {
        for (name, keys, page) in [
            ("Guide", "", HelpPage::Guide),
            ("Keyboard and mouse shortcuts", "?", HelpPage::Shortcuts),
            ("About Overlook", "", HelpPage::About),
        ] {
            if ui.add(item(name, keys)).accessible_name(name).clicked() {
                commands.push(Command::Window(WindowCommand::Help(Some(page))));
            }
        }
    });
}

/// The name of what is open, and how large it is.
fn title_of(state: &State) -> Option<[RichText; 2]> {
    let scene = state.doc.scene.as_ref()?;
    let kind = match (&scene.origin, scene.capture().is_some()) {
        (SceneSource::Demo(_), _) => "built-in capture, traced here",
        (SceneSource::Room, _) => "built-in store",
        (_, true) => "capture",
        (_, false) => "store",
    };
    let cameras = scene.cameras.len();
    let (width, height) = scene.cameras.first().map_or((0, 0), |camera| camera.intrinsics.size());
    let facts = format!(
        "{kind} · {} × {} · {width}×{height}",
        counted(cameras, "camera"),
        counted(scene.frame_count(), "frame")
    );
    Some([RichText::new(&scene.name).strong(), RichText::new(facts)])
}

/// Width that the title takes where nothing of it is cut off.
fn width_of(ui: &Ui, title: Option<&[RichText; 2]>) -> f32 {
    let font = egui::TextStyle::Body.resolve(ui.style());
    let width = |part: &RichText| {
        ui.painter().layout_no_wrap(part.text().to_owned(), font.clone(), Color32::PLACEHOLDER).size().x
    };
    title.map_or(0.0, |parts| parts.iter().map(|part| width(part) + ui.spacing().item_spacing.x).sum())
}

fn title_ui(ui: &mut Ui, state: &State, title: Option<[RichText; 2]>) {
    let (Some([name, facts]), Some(scene)) = (title, &state.doc.scene) else { return };
    ui.add(Label::new(name).truncate());
    let response = ui.add(Label::new(facts.color(Tokens::in_ui(ui).text_weak)).truncate());
    if let SceneSource::Path(path) = &scene.origin {
        response.on_hover_text(path.display().to_string());
    }
}
