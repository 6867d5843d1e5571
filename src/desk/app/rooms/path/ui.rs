//! The camera path: what is done with it, above its keys.

use egui::containers::menu::{MenuButton, MenuConfig};
use egui::{Button, DragValue, Grid, PopupCloseBehavior, RichText, ScrollArea, Ui};
use egui_material_icons::icons::{
    ICON_ARROW_DOWNWARD, ICON_ARROW_UPWARD, ICON_ASPECT_RATIO, ICON_DELETE, ICON_MOVIE, ICON_PAUSE,
    ICON_PLAY_ARROW, ICON_RESTART_ALT, ICON_UPDATE,
};

use crate::app::model::command::{FileCommand, PathCommand};
use crate::app::model::purpose::{Purpose, ShareCommand};
use crate::app::model::{Command, Commands, SIDES, State};
use crate::app::rooms::path::{CameraPath, MOST_ON_A_LEG, SavedPathKey, Turntable};
use crate::app::widgets::{choice_ui, empty_ui, icon_button, note, view_picture_ui, weak};
use crate::ways_out::Way;
use overlook_engine::capture::transforms::Easing;
use overlook_engine::plural::counted;

/// Columns and rows of exported pictures.
pub(crate) fn size_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    let size = state.export_size();
    let mut chosen = size;
    let [width, height] = &mut chosen;
    for (name, separator, side) in [("Picture width", "×", width), ("Picture height", "", height)] {
        let drag = DragValue::new(side).range(SIDES).speed(2.0).update_while_editing(false);
        ui.add(drag).on_hover_text(SIZE).accessible_name(name);
        ui.label(separator);
    }
    let menu = ui.menu_button(ICON_ASPECT_RATIO.rich_text(), |ui| {
        let offered = state.offered_sizes();
        for (nth, [width, height]) in offered.into_iter().enumerate() {
            let name = if nth == 0 { "Largest camera: " } else { "" };
            let button = ui.button(format!("{name}{width}×{height}"));
            // Twice as fine as recorded is as fine as the live view gets.
            let help = if width > 2 * offered[0][0] { FINER } else { SHAPE };
            if button.on_hover_text(help).clicked() {
                chosen = [width, height];
            }
        }
    });
    menu.response.on_hover_text("Usual sizes").accessible_name("Sizes");
    if chosen != size {
        commands
            .push(Command::Path(PathCommand::change(&state.doc.path, None, |path| path.size = Some(chosen))));
    }
}

const SHAPE: &str = "In the shape of the largest camera's pictures.";
const FINER: &str = "More than twice as fine as the capture, which shows no more of it.";

const SIZE: &str = "Columns and rows of exported pictures, at first those of the largest camera. What the lens sees fits inside.";

pub(crate) fn path_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    let mut path = state.doc.path.clone();
    if path.keys.is_empty() {
        let text = "Fly to where the path should begin and add a key; fly on and add the next. The path runs smoothly \
                    through all of them, in space and in time.";
        empty_ui(ui, ICON_MOVIE, "No camera path yet", text, |ui| {
            if ui.button("Add key here (K)").clicked() {
                commands.push(Command::Path(PathCommand::AddKey));
            }
            turntable_ui(ui, state, &mut path, commands);
            path_file_ui(ui, &mut path, commands);
        });
    } else {
        // Low panels show the keys below the controls.
        ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
            controls_ui(ui, state, &mut path, commands);
            way_ui(ui, state, &mut path, commands);
            still_ui(ui, state);
            keys_ui(ui, state, &mut path, commands);
        });
    }
    if path != state.doc.path {
        commands.push(Command::Path(PathCommand::Change(Box::new(path), None)));
    }
}

fn controls_ui(ui: &mut Ui, state: &State, path: &mut CameraPath, commands: &mut Commands) {
    let in_a_row = match ui.available_width() {
        width if width > ONE_ROW => 4,
        width if width > TWO_ROWS => 2,
        _ => 1,
    };
    for row in PathControls::ALL.chunks(in_a_row) {
        let parts_ui = |ui: &mut Ui| {
            for part in row {
                part_ui(ui, state, *part, path, commands);
            }
        };
        // Buttons of menus do not wrap: they would lie over what is before them.
        if row.iter().any(|part| matches!(part, PathControls::Size | PathControls::File)) {
            ui.horizontal(parts_ui);
        } else {
            ui.horizontal_wrapped(parts_ui);
        }
    }
}

/// Controls above the keys, in rows as wide as the panel.
#[derive(Clone, Copy)]
enum PathControls {
    Keys,
    Pace,
    Size,
    File,
}

impl PathControls {
    const ALL: [Self; 4] = [Self::Keys, Self::Pace, Self::Size, Self::File];
}

/// Widths from which on all controls fit into one row and into two.
const ONE_ROW: f32 = 1040.0;
const TWO_ROWS: f32 = 600.0;

fn part_ui(ui: &mut Ui, state: &State, part: PathControls, path: &mut CameraPath, commands: &mut Commands) {
    let ready = path.pictures() > 0;
    match part {
        PathControls::Keys => {
            if ui.button("Add key here (K)").on_hover_text(ADD).clicked() {
                commands.push(Command::Path(PathCommand::AddKey));
            }
            let is_playing = path.playing.is_some();
            let (icon, name) =
                if is_playing { (ICON_PAUSE, "Stop path") } else { (ICON_PLAY_ARROW, "Play path") };
            if ui.add_enabled_ui(ready, |ui| icon_button(ui, icon, name, name)).inner.clicked() {
                path.playing = (!is_playing).then_some(0.0);
            }
            weak(ui, counted(path.pictures(), "picture"));
        }
        PathControls::Pace => {
            ui.label("Frames per segment");
            let drag = DragValue::new(&mut path.pictures_per_leg).range(1..=MOST_ON_A_LEG);
            ui.add(drag).accessible_name("Frames per segment");
            if ready {
                ui.label("Length");
                length_ui(ui, state, commands);
            }
        }
        PathControls::Size => {
            ui.label("Size");
            size_ui(ui, state, commands);
        }
        PathControls::File => {
            path_file_ui(ui, path, commands);
            if ui.button("Share…").on_hover_text(SHARE).accessible_name("Share the camera path").clicked() {
                commands.push(Command::Share(ShareCommand::Open(Some(Way::Film))));
            }
        }
    }
}

/// How long the film of the path is.
pub(crate) fn length_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    let (path, rate) = (&state.doc.path, f64::from(state.timeline.frames_per_second));
    let mut seconds = path.pictures() as f64 / rate;
    let drag = DragValue::new(&mut seconds).range(0.0..=1e7).speed(0.05).max_decimals(2).suffix(" s");
    let field = ui.add(drag.update_while_editing(false)).on_hover_text(LENGTH);
    if field.accessible_name("Length of the film").changed() {
        commands.push(Command::Path(PathCommand::change(path, None, |path| path.set_seconds(seconds, rate))));
    }
}

const LENGTH: &str = "Seconds of the film. Each segment gets as many whole frames as come nearest to it.";

/// Says that time stands still along the path, where it does.
pub(crate) fn still_ui(ui: &mut Ui, state: &State) {
    if let Some(frame) = state.doc.path.only_frame().filter(|_| state.has_time()) {
        let number = frame + 1;
        note(
            ui,
            format!(
                "Time stands still in the film: all keys lie at frame {number}. Drag keys along the time bar to let it pass."
            ),
        );
    }
}

fn path_file_ui(ui: &mut Ui, path: &mut CameraPath, commands: &mut Commands) {
    let ready = path.pictures() > 0;
    ui.menu_button("Path file…", |ui| {
        let mut clicked = |name: &str, is_possible: bool| {
            let button = ui.add_enabled(is_possible, Button::new(name));
            button.on_hover_text(PATH_FILE).clicked()
        };
        if clicked("Save camera path…", ready) {
            commands.push(Command::File(FileCommand::AskPath(Purpose::SavePath)));
        }
        if clicked("Open camera path…", true) {
            commands.push(Command::File(FileCommand::AskPath(Purpose::LoadPath)));
        }
        if clicked("Remove all keys", ready) {
            path.clear();
        }
    });
}

const ADD: &str = "The view becomes a key behind the selected one.";

const SHARE: &str = "A video or pictures along the path.";

const PATH_FILE: &str = "A transforms.json of every picture of the path with its keys marked, as render --views takes. Opening one adds its keys.";

const MOVE: &str = "Move this view in the list. Frames stay in their order.";

/// Width from which on a key takes one line, with its position.
const ROOMY: f32 = 640.0;

fn keys_ui(ui: &mut Ui, state: &State, path: &mut CameraPath, commands: &mut Commands) {
    let keys = 0..state.doc.path.keys.len();
    if ui.available_width() > ROOMY {
        Grid::new("keys of the path").striped(true).spacing(egui::vec2(18.0, 3.0)).show(ui, |ui| {
            for index in keys {
                key_ui(ui, state, index, true, commands);
                ui.horizontal(|ui| leg_ui(ui, state, index, commands));
                ui.horizontal(|ui| buttons_ui(ui, state, index, path));
                ui.end_row();
            }
        });
        return;
    }
    for index in keys {
        ui.horizontal(|ui| key_ui(ui, state, index, false, commands));
        ui.horizontal(|ui| {
            buttons_ui(ui, state, index, path);
            leg_ui(ui, state, index, commands);
        });
    }
}

/// A key: its picture, its number, its position where there is room for it, and its frame.
fn key_ui(ui: &mut Ui, state: &State, index: usize, is_roomy: bool, commands: &mut Commands) {
    let path = &state.doc.path;
    let (key, number) = (&path.keys[index], index + 1);
    let at = key.orbit.world_from_camera.translation;
    let place = format!("{:.2}, {:.2}, {:.2}", at.x, at.y, at.z);
    let view = state.address_of(&key.orbit, key.frame);
    let picture = view.and_then(|view| state.doc.view_pictures.of(&view));
    let is_clicked = view_picture_ui(ui, picture, &format!("key {number}"));
    let button = Button::new(format!("Key {number}")).selected(path.selected == Some(index));
    let help = format!("Go to this key, at {place}");
    if ui.add(button).on_hover_text(help).clicked() || is_clicked {
        commands.push(Command::Path(PathCommand::GoToKey(index)));
    }
    if is_roomy {
        ui.label(RichText::new(place).monospace());
    }
    weak(ui, format!("frame {}", key.frame + 1));
}

/// What is done with a key.
fn buttons_ui(ui: &mut Ui, state: &State, index: usize, path: &mut CameraPath) {
    let (number, keys) = (index + 1, path.keys.len());
    let here = format!("Set key {number} to the current view");
    if icon_button(ui, ICON_UPDATE, &here, "Set this key to the current view").clicked()
        && let Some(here) = state.key_here()
    {
        let key = &mut path.keys[index];
        *key = SavedPathKey { pictures: key.pictures, ..here };
    }
    for (icon, to, other) in [
        (ICON_ARROW_UPWARD, "up", index.checked_sub(1)),
        (ICON_ARROW_DOWNWARD, "down", Some(index + 1).filter(|other| *other < keys)),
    ] {
        let name = format!("Move key {number} {to}");
        let move_ui = |ui: &mut Ui| icon_button(ui, icon, &name, MOVE).clicked();
        if let (true, Some(other)) = (ui.add_enabled_ui(other.is_some(), move_ui).inner, other) {
            path.exchange_keys(index, other);
        }
    }
    let remove = format!("Remove key {number}");
    if icon_button(ui, ICON_DELETE, &remove, "Remove this key").clicked() {
        path.remove_key(index);
    }
}

const LEG: &str = "Seconds from this key to the next. A longer way is slow motion where time passes.";

/// How long the way from a key to the next takes.
fn leg_ui(ui: &mut Ui, state: &State, leg: usize, commands: &mut Commands) {
    let path = &state.doc.path;
    if leg >= path.legs() {
        return;
    }
    let (rate, number) = (f64::from(state.timeline.frames_per_second), leg + 1);
    let mut seconds = path.pictures_of_leg(leg) as f64 / rate;
    let drag = DragValue::new(&mut seconds).range(0.0..=3600.0).speed(0.02).max_decimals(2).suffix(" s");
    let field = ui.add(drag.update_while_editing(false)).on_hover_text(LEG);
    let set = |pictures| PathCommand::change(path, Some(leg), |path| path.set_leg(leg, pictures));
    if field.accessible_name(format!("Seconds behind key {number}")).changed() {
        commands.push(Command::Path(set(Some(seconds * rate))));
    }
    if path.keys[leg].pictures.is_some() {
        let name = format!("As long behind key {number} as elsewhere");
        if icon_button(ui, ICON_RESTART_ALT, &name, "As long as the other segments").clicked() {
            commands.push(Command::Path(set(None)));
        }
    }
}

/// How the camera sets off and arrives.
const EASINGS: [(Easing, &str, &str); 4] = [
    (Easing::Linear, "Even", "At an even pace."),
    (Easing::InOut, "Ease in and out", "It sets off and arrives slowly."),
    (Easing::In, "Ease in", "It sets off slowly."),
    (Easing::Out, "Ease out", "It arrives slowly."),
];

/// Width from which on all fits into one row, points.
const WAY_ON_ONE_ROW: f32 = 640.0;

/// Room for a pace, points.
const PACE: f32 = 118.0;

const LOOP: &str =
    "The camera goes back to the first key at the end, so that the film can be played over and over.";
const LOOK: &str = "The camera looks at the point of the pinned pixel all the way, wherever keys look.";
const NO_PIN: &str = "Pin a pixel first: click on it.";

fn way_ui(ui: &mut Ui, state: &State, path: &mut CameraPath, commands: &mut Commands) {
    if ui.available_width() > WAY_ON_ONE_ROW {
        ui.horizontal(|ui| {
            ui.checkbox(&mut path.is_closed, "Loop").on_hover_text(LOOP);
            turntable_ui(ui, state, path, commands);
            pace_ui(ui, path);
            look_ui(ui, state, path);
        });
        return;
    }
    ui.horizontal(|ui| {
        ui.checkbox(&mut path.is_closed, "Loop").on_hover_text(LOOP);
        turntable_ui(ui, state, path, commands);
    });
    ui.horizontal(|ui| pace_ui(ui, path));
    ui.horizontal_wrapped(|ui| look_ui(ui, state, path));
}

fn pace_ui(ui: &mut Ui, path: &mut CameraPath) {
    ui.label("Pace");
    path.easing = choice_ui(ui, "Pace of the camera", path.easing, &EASINGS, PACE).unwrap_or(path.easing);
}

/// Whether the camera looks at one point all the way.
fn look_ui(ui: &mut Ui, state: &State, path: &mut CameraPath) {
    let probe = &state.doc.probe;
    let pinned = probe.shown.as_ref().filter(|_| probe.pinned).and_then(|probed| probed.point_in_world);
    let mut looks = path.looks_at.is_some();
    let can = looks || pinned.is_some();
    let field = ui.add_enabled(can, egui::Checkbox::new(&mut looks, "Look at the pinned point"));
    if field.on_hover_text(LOOK).on_disabled_hover_text(NO_PIN).changed() {
        path.looks_at = pinned.filter(|_| looks);
    }
    if let Some(at) = path.looks_at {
        weak(ui, format!("{:.2}, {:.2}, {:.2}", at.x, at.y, at.z));
    }
}

const TURN: &str =
    "A closed path of keys once around the pivot of this view, in place of the keys that are there.";

fn turntable_ui(ui: &mut Ui, state: &State, path: &mut CameraPath, commands: &mut Commands) {
    let config = MenuConfig::new().close_behavior(PopupCloseBehavior::CloseOnClickOutside);
    let (button, _) = MenuButton::new("Turntable…").config(config).ui(ui, |ui| {
        let Turntable { keys, seconds, passes_time } = &mut path.turntable;
        ui.horizontal(|ui| {
            ui.add(DragValue::new(keys).range(4..=72).suffix(" keys")).accessible_name("Keys of the turn");
            let drag = DragValue::new(seconds).range(0.5..=600.0).speed(0.05).max_decimals(2).suffix(" s");
            ui.add(drag).accessible_name("Seconds of the turn");
        });
        if state.has_time() {
            ui.checkbox(passes_time, "Time passes")
                .on_hover_text("The played frames pass meanwhile; else the frame that is shown stays.");
        }
        if ui.button("Turn around the pivot").clicked() {
            commands.push(Command::Path(PathCommand::TurnAround));
            ui.close();
        }
    });
    button.on_hover_text(TURN);
}
