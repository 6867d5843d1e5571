//! The introduction of a first run, what was open lately, and a field for typing a path.

use std::path::Path;

use egui::{Align, Frame, Id, Label, Layout, Margin, Modal, Panel, RichText, Sense, Ui, vec2};
use egui_material_icons::icons::ICON_FOLDER_OPEN;

use crate::app::model::command::{FileCommand, Opening, SourceCommand, WindowCommand};
use crate::app::model::picture::Overlay;
use crate::app::model::purpose::{AskedPath, Purpose, ShareCommand, Table, TypedPath};
use crate::app::model::texture::RECENT_SIDES;
use crate::app::model::window::{DockView, Workspace};
use crate::app::model::{self, Command, Commands, SceneSource, State};
use crate::app::rooms::source::SourceLook;
use crate::app::theme::{Tokens, space};
use crate::app::widgets::{note, small_picture, text_field_ui, weak};
use crate::ways_out::{Action, Way};
use overlook_engine::plural::counted;

/// What a first run explains: title and text. Each speaks of a view that the first workspace shows.
const HINTS: [(&str, &str); 3] = [
    (
        "Click a pixel",
        "The Pixel view shows which cameras see the point, which one sampled it best, and why it is kept or dropped.",
    ),
    (
        "Orbit the live view",
        "Drag to orbit, turn the wheel to zoom, fly with W A S D. Double-click its tab to let it fill the window. Holes are filled; H \
         shows where.",
    ),
    (
        "Change a threshold",
        "In Settings each threshold is a line on a histogram of its data. Drag one: this frame shows it at once, the whole capture \
         follows.",
    ),
];

/// Room for the button that dismisses the introduction, and for those beside what is said of the room, points.
const DISMISS_WIDTH: f32 = 76.0;
const ROOM_BUTTONS_WIDTH: f32 = 270.0;

const ROOM_HELP: &str =
    "Drag the picture to look around, turn the wheel to come nearer; space stops the time.";

/// What the room that comes with the program is, until it is read.
fn room_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    let Some((scene, report)) = state.doc.scene.as_ref().zip(state.report()) else { return };
    let tokens = Tokens::in_ui(ui);
    let band = Frame::new().fill(tokens.accent_faint).inner_margin(Margin::symmetric(space::PANEL, 8));
    let account = report.pixel_account();
    let sentence = format!(
        "{} filmed this room for {}. {} of what they recorded is repeated, and said as well by another pixel: here is the rest.",
        model::sentence(&counted(scene.cameras.len(), "camera")),
        counted(scene.frame_count(), "frame"),
        model::percent(account.represented(), account.pixels),
    );
    Panel::top("room").frame(band).show(ui, |ui| {
        ui.horizontal(|ui| {
            ui.vertical(|ui| {
                ui.spacing_mut().item_spacing.y = 1.0;
                ui.set_width(ui.available_width() - ROOM_BUTTONS_WIDTH);
                ui.add(Label::new(RichText::new(sentence).strong()).wrap());
                ui.add(Label::new(RichText::new(ROOM_HELP).color(tokens.text)).wrap());
            });
            let help = "What was dropped, by which rule, and which camera shows it instead.";
            if ui.button("See why").on_hover_text(help).clicked() {
                let look = SourceLook { overlay: Overlay::WhoWon, ..state.source };
                commands.push(Command::Source(SourceCommand::Look(look)));
                commands.push(Command::Window(WindowCommand::OpenView(DockView::Report)));
            }
            let own =
                ui.button("Open your own…").on_hover_text("A capture folder; or drop it on the window.");
            if own.clicked() {
                commands.push(Command::File(FileCommand::AskPath(Purpose::OpenFolder)));
            }
            if ui.button("Got it").clicked() {
                commands.push(Command::File(FileCommand::RoomExplained));
            }
        });
    });
}

/// The introduction, until it is dismissed: a band of its own, so that it covers nothing of what it explains.
pub(crate) fn introduction_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    let is_room = state.doc.scene.as_ref().is_some_and(|scene| scene.origin == SceneSource::Room);
    if is_room && !state.inspector.room_explained && state.look.maximized.is_none() {
        return room_ui(ui, state, commands);
    }
    // It explains recorded pictures and thresholds, which a store does not have, and views that other workspaces lack.
    let explains = state.has_capture() && state.look.workspace == Workspace::Inspect;
    if state.inspector.introduced || !explains || state.look.maximized.is_some() {
        return;
    }
    let tokens = Tokens::in_ui(ui);
    let band = Frame::new().fill(tokens.accent_faint).inner_margin(Margin::symmetric(space::PANEL, 8));
    Panel::top("introduction").frame(band).show(ui, |ui| {
        ui.horizontal_top(|ui| {
            let gap = ui.spacing().item_spacing.x;
            let width = (ui.available_width() - DISMISS_WIDTH) / HINTS.len() as f32 - gap;
            for (title, text) in HINTS {
                ui.vertical(|ui| {
                    ui.set_width(width);
                    ui.spacing_mut().item_spacing.y = 1.0;
                    ui.label(RichText::new(title).strong());
                    ui.add(Label::new(RichText::new(text).color(tokens.text)).wrap());
                });
            }
            if ui.button("Got it").clicked() {
                commands.push(Command::File(FileCommand::Introduced));
            }
        });
    });
}

const UNSAVED: &str =
    "Settings were changed since the last store was saved. The pruned samples would be lost.";
const WRITING: &str = "A file, pictures or a video are still being written. Closing now abandons them; the line at the bottom shows their \
     progress.";
const WRITTEN: &str = "What was being written is done.";

/// The question before closing or before opening something else, while it is open.
pub(crate) fn closing_ui(ctx: &egui::Context, state: &State, commands: &mut Commands) {
    let closes = state.inspector.closing.asks;
    if !closes && state.open_after_question.is_none() {
        return;
    }
    let modal = Modal::new(Id::unique("closing")).show(ctx, |ui| {
        ui.set_width(420.0);
        let unsaved_work = state.unsaved_work();
        let (title, text) = match (state.inspector.closing.writing, state.is_unsaved()) {
            _ if !closes => ("Open something else?", None),
            (true, _) => ("Close before all is written?", Some(WRITING)),
            (false, true) => ("Close without saving?", Some(UNSAVED)),
            (false, false) if unsaved_work.is_some() => ("Close without saving?", None),
            (false, false) => ("Close now?", Some(WRITTEN)),
        };
        ui.heading(title);
        if let Some(text) = text {
            ui.label(text);
        }
        if let Some(unsaved_work) = unsaved_work {
            ui.label(format!("This would be lost: {unsaved_work}."));
        }
        ui.add_space(space::MEDIUM);
        ui.horizontal(|ui| closing_buttons_ui(ui, state, closes, commands));
    });
    if modal.should_close() {
        commands.push(Command::File(FileCommand::Stay));
    }
}

/// What can be saved before closing, and the answers; `closes` is false where something else is to be opened.
fn closing_buttons_ui(ui: &mut Ui, state: &State, closes: bool, commands: &mut Commands) {
    let (path, charts) = (&state.doc.path, &state.doc.charts);
    let ask = |purpose| Command::File(FileCommand::AskPath(purpose));
    let save_table = |is_lost: bool, table: Table| {
        (is_lost, format!("Save {}…", table.name()), ask(Purpose::SaveTable(table)))
    };
    for (is_offered, name, command) in [
        (
            state.opened_path().is_some() && state.unsaved_work().is_some(),
            "Save session…".to_owned(),
            ask(Purpose::SaveSession),
        ),
        (
            closes && state.is_unsaved() && !state.inspector.closing.writing,
            "Share the store…".to_owned(),
            Command::Share(ShareCommand::Open(Some(Way::Store))),
        ),
        (path.pictures() > 0 && !path.is_saved(), "Save camera path…".to_owned(), ask(Purpose::SavePath)),
        save_table(!charts.sweep.is_empty(), Table::Sweep),
        save_table(!charts.stress.is_empty(), Table::StressTest),
    ] {
        if is_offered && ui.button(name).clicked() {
            commands.extend([Command::File(FileCommand::Stay), command]);
        }
    }
    let discard = ui.button(if closes { "Discard and close" } else { "Discard and open" });
    if discard.clicked() {
        commands.push(Command::File(FileCommand::GoOnAnyway));
    }
    // Nothing is lost by Enter.
    let cancel = ui.button("Cancel").accessible_name("Cancel closing");
    if ui.memory(|memory| memory.focused().is_none()) {
        cancel.request_focus();
    }
    if cancel.clicked() {
        commands.push(Command::File(FileCommand::Stay));
    }
}

/// Recent files that are offered while nothing is open, how many of them lie side by side, and room for a name, points.
const SHOWN: usize = 6;
const PER_ROW: usize = 3;
const NAME_HEIGHT: f32 = 20.0;

/// Recent files, each opened by a click.
pub(crate) fn recent_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    if state.recent.is_empty() {
        return;
    }
    ui.add_space(space::MEDIUM);
    note(ui, "Recent");
    let [width, height] = RECENT_SIDES.map(|side| side as f32);
    let gap = ui.spacing().item_spacing;
    let offered = &state.recent[..state.recent.len().min(SHOWN)];
    for row in offered.chunks(PER_ROW) {
        let size = vec2(row.len() as f32 * (width + gap.x) - gap.x, height + NAME_HEIGHT + gap.y);
        ui.allocate_ui_with_layout(size, Layout::left_to_right(Align::Min), |ui| {
            for path in row {
                let size = vec2(width, size.y);
                ui.allocate_ui_with_layout(size, Layout::top_down(Align::Center), |ui| {
                    card_ui(ui, path, state, commands);
                });
            }
        });
    }
}

fn card_ui(ui: &mut Ui, path: &Path, state: &State, commands: &mut Commands) {
    let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy();
    let [width, height] = RECENT_SIDES.map(|side| side as f32);
    let (area, response) = ui.allocate_exact_size(vec2(width, height), Sense::click());
    let picture = state.recent_pictures.iter().find(|picture| picture.path == path);
    small_picture(ui, &response, picture.map(|picture| &picture.texture));
    if picture.is_none() {
        let icon = ICON_FOLDER_OPEN.rich_text().size(28.0).color(Tokens::in_ui(ui).text_weak);
        ui.put(area, Label::new(icon).selectable(false));
    }
    let label =
        ui.add_sized([width, NAME_HEIGHT], Label::new(name.as_ref()).truncate().sense(Sense::click()));
    let is_label_clicked = label.on_hover_text(path.display().to_string()).clicked();
    response.widget_info(|| {
        let kind = if picture.is_some() { "Open recent" } else { "Open recent without picture" };
        egui::WidgetInfo::labeled(egui::Role::Button, true, format!("{kind} {name}"))
    });
    if response.on_hover_text(path.display().to_string()).clicked() || is_label_clicked {
        commands.push(Command::File(FileCommand::Open(Opening::Path(path.to_path_buf()))));
    }
}

/// The question before something is replaced.
fn replaced_words(typed: &TypedPath) -> String {
    let path = typed.text.trim();
    if typed.purpose.asked().endings.is_empty() {
        return format!(
            "Replace files in {path}? It holds files already; those of the same name will be replaced."
        );
    }
    format!("Replace {path}? It exists already.")
}

/// What kind of path the field takes.
fn hint(purpose: Purpose, AskedPath { action, endings, .. }: &AskedPath) -> String {
    match endings {
        _ if *action == Action::Open => {
            "folder of a capture, transforms.json, .ovl file, or the address of a view".to_owned()
        }
        [] if purpose == Purpose::OpenPictures => "folder of pictures".to_owned(),
        [] => "folder".to_owned(),
        [before @ .., last] => {
            let before: Vec<String> = before.iter().map(|ending| format!(".{ending}")).collect();
            let or = if before.is_empty() { "" } else { " or " };
            format!("{}{or}.{last} file", before.join(", "))
        }
    }
}

/// The field, while it is open.
pub(crate) fn path_field_ui(ctx: &egui::Context, state: &State, commands: &mut Commands) {
    let Some(typed) = &state.typed_path else { return };
    let purpose = typed.purpose;
    let asked = purpose.asked();
    let is_opened = asked.action == Action::Open;
    let title = if is_opened { "Open a capture or a store" } else { asked.title };
    let modal = Modal::new(Id::unique("path field")).show(ctx, |ui| {
        ui.set_width(480.0);
        ui.heading(title);
        if let Some(reason) = &typed.reason {
            weak(ui, reason);
        }
        let place = typed.text.trim();
        let is_named_alone = Path::new(place).is_relative() && !place.starts_with('~');
        if let Some(folder) = typed.folder.as_ref().filter(|_| is_named_alone) {
            note(ui, format!("In {}", folder.display()));
        }
        ui.add_space(space::MEDIUM);
        let mut text = typed.text.clone();
        let (changed, entered) = text_field_ui(ui, &mut text, &hint(purpose, &asked), "Path");
        if changed {
            commands.push(Command::File(FileCommand::TypedPath(text)));
        }
        if entered {
            commands.push(Command::File(FileCommand::TakeTypedPath));
        }
        if typed.replaces {
            ui.label(RichText::new(replaced_words(typed)).color(Tokens::in_ui(ui).warning));
        }
        ui.add_space(space::MEDIUM);
        ui.horizontal(|ui| {
            let action = if typed.replaces { "Replace" } else { asked.action.word() };
            let take = ui.add_enabled(!typed.text.trim().is_empty(), egui::Button::new(action));
            if take.accessible_name(format!("{action} this path")).clicked() {
                commands.push(Command::File(FileCommand::TakeTypedPath));
            }
            if ui.button("Cancel").accessible_name("Cancel this path").clicked() {
                commands.push(Command::File(FileCommand::CloseTypedPath));
            }
        });
    });
    if modal.should_close() {
        commands.push(Command::File(FileCommand::CloseTypedPath));
    }
}
