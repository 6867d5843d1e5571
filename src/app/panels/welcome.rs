//! The introduction of a first run, and the question before something unsaved or half written is lost.

use egui::{Align2, Area, Frame, Id, Margin, Modal, Order, RichText, Stroke, vec2};

use crate::app::model::{Command, Commands, Purpose, State, Table};
use crate::app::theme::{Tokens, space};

/// What a first run explains: title and text.
const HINTS: [(&str, &str); 3] = [
    (
        "Click a pixel",
        "The Pixel view below says what every camera knows about it: which cameras see the point, which one sampled it best, and by \
         which rule it is kept or dropped.",
    ),
    (
        "Fly through what is left",
        "Drag to orbit, wheel to zoom, W A S D to fly. What no sample reached is filled from behind; press H to see where.",
    ),
    (
        "Change a threshold",
        "In the Settings view each threshold is a line on a histogram of its data. Drag one: this frame shows it at once, the whole capture follows.",
    ),
];

/// The introduction, until it is dismissed.
pub(crate) fn introduction_ui(ctx: &egui::Context, state: &State, commands: &mut Commands) {
    // It speaks of what cameras recorded and of thresholds, which a store does not have: it waits for a capture.
    if state.inspector.introduced || !state.has_capture() {
        return;
    }
    let area = Area::new(Id::unique("introduction")).order(Order::Foreground);
    area.anchor(Align2::RIGHT_TOP, vec2(-12.0, 60.0)).show(ctx, |ui| {
        let tokens = Tokens::in_ui(ui);
        let frame = Frame::new().fill(tokens.raised).stroke(Stroke::new(1.5, tokens.accent));
        frame.corner_radius(8.0).inner_margin(Margin::same(14)).show(ui, |ui| {
            ui.set_width(320.0);
            for (title, text) in HINTS {
                ui.label(RichText::new(title).heading());
                ui.add(egui::Label::new(text).wrap());
                ui.add_space(space::SMALL);
            }
            if ui.button("Got it").clicked() {
                commands.push(Command::Introduced);
            }
        });
    });
}

const UNSAVED: &str =
    "Settings were changed since the last store was saved. The pruned samples would be lost.";
const WRITING: &str = "A file, pictures or a video are still being written. Closing now abandons them; the line at the bottom says how far \
     they are.";
const WRITTEN: &str = "What was being written is done.";

/// The question before closing or before opening something else, while it is open.
pub(crate) fn closing_ui(ctx: &egui::Context, state: &State, commands: &mut Commands) {
    let closes = state.inspector.closing.asks;
    if !closes && state.open_after_question.is_none() {
        return;
    }
    let modal = Modal::new(Id::unique("closing")).show(ctx, |ui| {
        ui.set_width(420.0);
        let inspector = &state.inspector;
        let unsaved_work = inspector.unsaved_work();
        let (title, text) = match (inspector.closing.writing, state.is_unsaved()) {
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
        ui.horizontal(|ui| {
            let saves = closes && state.is_unsaved() && !inspector.closing.writing;
            if saves && ui.button("Save store…").accessible_name("Save before closing").clicked() {
                commands.push(Command::Stay);
                commands.push(Command::AskPath(Purpose::SaveStore));
            }
            for (table, is_lost) in [
                (Table::Sweep, !inspector.charts.sweep.is_empty()),
                (Table::StressTest, !inspector.charts.stress.is_empty()),
            ] {
                let name = format!("Save {} as CSV…", table.name());
                if is_lost && ui.button(name).clicked() {
                    commands.push(Command::Stay);
                    commands.push(Command::AskPath(Purpose::SaveTable(table)));
                }
            }
            let discard = ui.button(if closes { "Discard and close" } else { "Discard and open" });
            if discard.clicked() {
                commands.push(Command::GoOnAnyway);
            }
            // Nothing is lost by Enter.
            let cancel = ui.button("Cancel").accessible_name("Cancel closing");
            if ui.memory(|memory| memory.focused().is_none()) {
                cancel.request_focus();
            }
            if cancel.clicked() {
                commands.push(Command::Stay);
            }
        });
    });
    if modal.should_close() {
        commands.push(Command::Stay);
    }
}
