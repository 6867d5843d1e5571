//! Three callouts on the first run, and the question before something unsaved or half written is lost.

use egui::{Align2, Area, Button, Frame, Id, Margin, Modal, Order, RichText, Stroke};

use super::super::command::Command;
use super::super::message::Purpose;
use super::super::state::State;
use super::super::theme::{Tokens, space};

/// What a first run explains: title, text, and where in the window (shares of its size) the callout stands.
const CALLOUTS: [(&str, &str, [f32; 2]); 3] = [
    (
        "Point at a pixel",
        "The Pixel view below says what every camera knows about it: who sees the point, who sampled it best, and by \
         which rule it stays or goes. Click to keep it.",
        [0.05, 0.30],
    ),
    (
        "Fly through what is left",
        "Drag to orbit, wheel to zoom, W A S D to fly. Hatched pixels are holes: no sample reached them.",
        [0.42, 0.30],
    ),
    (
        "Turn a threshold",
        "Each line lies on the data that it cuts. Drag one: this frame shows it at once, the whole capture follows.",
        [0.48, 0.42],
    ),
];

/// Callouts there are.
pub(super) const COUNT: usize = CALLOUTS.len();

/// The callout that is next, if any.
pub(super) fn callouts_ui(ctx: &egui::Context, state: &State, commands: &mut Vec<Command>) {
    let next = state.inspector.callout;
    let Some((title, text, place)) = CALLOUTS.get(next) else { return };
    // They speak of what cameras recorded and of thresholds, which a store no longer has: they wait for a capture.
    if !state.has_capture() {
        return;
    }
    let area = ctx.content_rect();
    let at = area.min + area.size() * egui::vec2(place[0], place[1]);
    Area::new(Id::unique("callout")).order(Order::Foreground).fixed_pos(at).pivot(Align2::LEFT_TOP).show(
        ctx,
        |ui| {
            let tokens = Tokens::in_ui(ui);
            Frame::new()
                .fill(tokens.raised)
                .stroke(Stroke::new(1.5, tokens.accent))
                .corner_radius(8.0)
                .inner_margin(Margin::same(14))
                .show(ui, |ui| {
                    ui.set_width(300.0);
                    ui.label(RichText::new(*title).heading());
                    ui.add(egui::Label::new(*text).wrap());
                    ui.add_space(space::SMALL);
                    ui.horizontal(|ui| {
                        let last = next + 1 == COUNT;
                        let go_on = Button::new(
                            RichText::new(if last { "Got it" } else { "Next" }).color(tokens.on_accent),
                        )
                        .fill(tokens.accent);
                        if ui.add(go_on).accessible_name("Next callout").clicked() {
                            commands.push(Command::Callout(next + 1));
                        }
                        if !last && ui.button("Skip").clicked() {
                            commands.push(Command::Callout(COUNT));
                        }
                        ui.label(
                            RichText::new(format!("{} of {COUNT}", next + 1)).small().color(tokens.text_weak),
                        );
                    });
                });
        },
    );
}

const UNSAVED: &str = "Thresholds were changed since the last store was saved. They are remembered; the pruned samples are not.";
const WRITING: &str = "A file, pictures or a film are still being written. Closing now abandons them; the line at the bottom says how far \
     they are.";
const WRITTEN: &str = "What was being written is done.";

/// The question before closing or before opening something else, while it is asked.
pub(super) fn closing_ui(ctx: &egui::Context, state: &State, commands: &mut Vec<Command>) {
    let closes = state.inspector.closing.asks;
    if !closes && state.asks_to_open.is_none() {
        return;
    }
    let modal = Modal::new(Id::unique("closing")).show(ctx, |ui| {
        ui.set_width(420.0);
        let inspector = &state.inspector;
        let losses = inspector.losses();
        let (title, text) = match (inspector.closing.writing, state.is_unsaved()) {
            _ if !closes => ("Open something else?", None),
            (true, _) => ("Close before all is written?", Some(WRITING)),
            (false, true) => ("Close without saving?", Some(UNSAVED)),
            (false, false) if losses.is_some() => ("Close without saving?", None),
            (false, false) => ("Close now?", Some(WRITTEN)),
        };
        ui.heading(title);
        if let Some(text) = text {
            ui.label(text);
        }
        if let Some(losses) = losses {
            ui.label(format!("This would be lost: {losses}."));
        }
        ui.add_space(space::MEDIUM);
        ui.horizontal(|ui| {
            let saves = closes && state.is_unsaved() && !inspector.closing.writing;
            if saves && ui.button("Save store…").accessible_name("Save before closing").clicked() {
                commands.push(Command::Stay);
                commands.push(Command::AskPath(Purpose::SaveStore));
            }
            if ui.button(if closes { "Close anyway" } else { "Open anyway" }).clicked() {
                commands.push(Command::GoOnAnyway);
            }
            if ui.button("Stay").clicked() {
                commands.push(Command::Stay);
            }
        });
    });
    if modal.should_close() {
        commands.push(Command::Stay);
    }
}
