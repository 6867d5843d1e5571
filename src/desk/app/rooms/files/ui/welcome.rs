//! The introduction of a first run, and the question before something unsaved or half written is lost.

use egui::{Frame, Id, Label, Margin, Modal, Panel, RichText, Ui};

use crate::app::model;
use crate::app::model::{Command, Commands, SceneSource, State};
use crate::app::rooms::files::model::{FileCommand, Purpose};
use crate::app::rooms::frame::model::{DockView, WindowCommand, Workspace};
use crate::app::rooms::report::model::Table;
use crate::app::rooms::share::model::{ShareCommand, ShareWay};
use crate::app::theme::{Tokens, space};
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

/// Room for the button that dismisses the introduction, points.
const DISMISS_WIDTH: f32 = 76.0;

/// Room for the buttons beside what is said of the room, points.
const ROOM_BUTTONS_WIDTH: f32 = 270.0;

/// What somebody can do about the room, in its band.
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
            if ui.button("See why").on_hover_text("What was dropped, and by which rule.").clicked() {
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
    let inspector = &state.inspector;
    let saves = closes && state.is_unsaved() && !inspector.closing.writing;
    if saves && ui.button("Share the store…").accessible_name("Save before closing").clicked() {
        commands.push(Command::File(FileCommand::Stay));
        commands.push(Command::Share(ShareCommand::Open(Some(ShareWay::Store))));
    }
    let path = &state.doc.path;
    if path.pictures() > 0 && !path.is_saved() && ui.button("Save camera path…").clicked() {
        commands.push(Command::File(FileCommand::Stay));
        commands.push(Command::File(FileCommand::AskPath(Purpose::SavePath)));
    }
    for (table, is_lost) in [
        (Table::Sweep, !state.doc.charts.sweep.is_empty()),
        (Table::StressTest, !state.doc.charts.stress.is_empty()),
    ] {
        let name = format!("Save {}…", table.name());
        if is_lost && ui.button(name).clicked() {
            commands.push(Command::File(FileCommand::Stay));
            commands.push(Command::File(FileCommand::AskPath(Purpose::SaveTable(table))));
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
