//! How the camera goes along its keys: around the pivot, in a loop, with its eye on a point, at which pace.

use egui::containers::menu::{MenuButton, MenuConfig};
use egui::{DragValue, PopupCloseBehavior, Ui};

use crate::app::model::{Command, Commands, State};
use crate::app::rooms::path::model::{PathCommand, Turntable};
use crate::app::widgets::{choice_ui, weak};
use overlook_engine::capture::transforms::Easing;

/// How the camera sets off and arrives.
const EASINGS: [(Easing, &str, &str); 4] = [
    (Easing::Linear, "Even", "At an even pace."),
    (Easing::InOut, "Ease in and out", "It sets off and arrives slowly."),
    (Easing::In, "Ease in", "It sets off slowly."),
    (Easing::Out, "Ease out", "It arrives slowly."),
];

/// Width from which on all fits into one row, points.
const ONE_ROW: f32 = 640.0;

/// Room for a pace, points.
const PACE: f32 = 118.0;

const LOOP: &str =
    "The camera goes back to the first key at the end, so that the film can be played over and over.";
const LOOK: &str = "The camera looks at the point of the pinned pixel all the way, wherever keys look.";
const NO_PIN: &str = "Pin a pixel first: click on it.";

pub(super) fn way_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    if ui.available_width() > ONE_ROW {
        ui.horizontal(|ui| {
            loop_ui(ui, state, commands);
            turntable_ui(ui, state, commands);
            pace_ui(ui, state, commands);
            look_ui(ui, state, commands);
        });
        return;
    }
    ui.horizontal(|ui| {
        loop_ui(ui, state, commands);
        turntable_ui(ui, state, commands);
    });
    ui.horizontal(|ui| pace_ui(ui, state, commands));
    ui.horizontal_wrapped(|ui| look_ui(ui, state, commands));
}

fn loop_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    let mut is_closed = state.doc.path.is_closed;
    if ui.checkbox(&mut is_closed, "Loop").on_hover_text(LOOP).changed() {
        commands.push(Command::Path(PathCommand::change(&state.doc.path, None, |path| {
            path.is_closed = is_closed
        })));
    }
}

fn pace_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    ui.label("Pace");
    if let Some(easing) = choice_ui(ui, "Pace of the camera", state.doc.path.easing, &EASINGS, PACE) {
        commands.push(Command::Path(PathCommand::change(&state.doc.path, None, |path| path.easing = easing)));
    }
}

/// Whether the camera looks at one point all the way.
fn look_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    let (path, probe) = (&state.doc.path, &state.doc.probe);
    let pinned = probe.shown.as_ref().filter(|_| probe.pinned).and_then(|probed| probed.point_in_world);
    let mut looks = path.looks_at.is_some();
    let can = looks || pinned.is_some();
    let field = ui.add_enabled(can, egui::Checkbox::new(&mut looks, "Look at the pinned point"));
    if field.on_hover_text(LOOK).on_disabled_hover_text(NO_PIN).changed() {
        commands.push(Command::Path(PathCommand::change(path, None, |path| {
            path.looks_at = pinned.filter(|_| looks)
        })));
    }
    if let Some(at) = path.looks_at {
        weak(ui, format!("{:.2}, {:.2}, {:.2}", at.x, at.y, at.z));
    }
}

const TURN: &str =
    "A closed path of keys once around the pivot of this view, in place of the keys that are there.";

/// A menu that makes the path a turn around the pivot.
pub(super) fn turntable_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    let config = MenuConfig::new().close_behavior(PopupCloseBehavior::CloseOnClickOutside);
    let (button, _) = MenuButton::new("Turntable…").config(config).ui(ui, |ui| {
        let before = state.doc.path.turntable;
        let mut turn = before;
        let Turntable { keys, seconds, passes_time } = &mut turn;
        ui.horizontal(|ui| {
            ui.add(DragValue::new(keys).range(4..=72).suffix(" keys")).accessible_name("Keys of the turn");
            let drag = DragValue::new(seconds).range(0.5..=600.0).speed(0.05).max_decimals(2).suffix(" s");
            ui.add(drag).accessible_name("Seconds of the turn");
        });
        if state.has_time() {
            ui.checkbox(passes_time, "Time passes")
                .on_hover_text("The played frames pass meanwhile; else the frame that is shown stays.");
        }
        if turn != before {
            commands.push(Command::Path(PathCommand::change(&state.doc.path, None, |path| {
                path.turntable = turn
            })));
        }
        if ui.button("Turn around the pivot").clicked() {
            commands.push(Command::Path(PathCommand::TurnAround));
            ui.close();
        }
    });
    button.on_hover_text(TURN);
}
