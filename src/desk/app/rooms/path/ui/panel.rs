//! The camera path: what is done with it, above its keys.

use egui::{Button, DragValue, ScrollArea, Ui};
use egui_material_icons::icons::{ICON_ASPECT_RATIO, ICON_MOVIE, ICON_PAUSE, ICON_PLAY_ARROW};

use super::keys::keys_ui;
use super::way::{turntable_ui, way_ui};
use crate::app::model::{Command, Commands, SIDES, State};
use crate::app::rooms::files::model::{FileCommand, Purpose};
use crate::app::rooms::path::model::{CameraPath, MOST_ON_A_LEG, PathCommand};
use crate::app::rooms::share::model::{ShareCommand, ShareWay};
use crate::app::widgets::{empty_ui, icon_button, note, weak};
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
    let path = &state.doc.path;
    if path.keys.is_empty() {
        let text = "Fly to where the path should begin and add a key; fly on and add the next. The path runs smoothly \
                    through all of them, in space and in time.";
        empty_ui(ui, ICON_MOVIE, "No camera path yet", text, |ui| {
            if ui.button("Add key here (K)").clicked() {
                commands.push(Command::Path(PathCommand::AddKey));
            }
            turntable_ui(ui, state, commands);
            path_file_ui(ui, state, false, commands);
        });
        return;
    }
    // Low panels show the keys below the controls.
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        controls_ui(ui, state, commands);
        way_ui(ui, state, commands);
        still_ui(ui, state);
        keys_ui(ui, state, commands);
    });
}

fn controls_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    let rows: &[&[PathControls]] = match ui.available_width() {
        width if width > ONE_ROW => {
            &[&[PathControls::Keys, PathControls::Pace, PathControls::Size, PathControls::File]]
        }
        width if width > TWO_ROWS => {
            &[&[PathControls::Keys, PathControls::Pace], &[PathControls::Size, PathControls::File]]
        }
        _ => &[&[PathControls::Keys], &[PathControls::Pace], &[PathControls::Size], &[PathControls::File]],
    };
    for row in rows {
        let parts_ui = |ui: &mut Ui| {
            for part in *row {
                part_ui(ui, state, *part, commands);
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

/// Widths from which on all controls fit into one row and into two.
const ONE_ROW: f32 = 1040.0;
const TWO_ROWS: f32 = 600.0;

fn part_ui(ui: &mut Ui, state: &State, part: PathControls, commands: &mut Commands) {
    let path = &state.doc.path;
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
                commands.push(Command::Path(PathCommand::change(path, None, |path| path.play(!is_playing))));
            }
            weak(ui, counted(path.pictures(), "picture"));
        }
        PathControls::Pace => {
            ui.label("Frames per segment");
            let mut pictures = path.pictures_per_leg;
            let drag = DragValue::new(&mut pictures).range(1..=MOST_ON_A_LEG);
            if ui.add(drag).accessible_name("Frames per segment").changed() {
                commands.push(Command::Path(PathCommand::change(path, None, |path| {
                    path.set_pictures_per_leg(pictures)
                })));
            }
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
            path_file_ui(ui, state, ready, commands);
            if ui.button("Share…").on_hover_text(SHARE).accessible_name("Share the camera path").clicked() {
                commands.push(Command::Share(ShareCommand::Open(Some(ShareWay::Film))));
            }
        }
    }
}

/// How long the film of the path is.
pub(crate) fn length_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    let (path, rate) = (&state.doc.path, f64::from(state.timeline.frames_per_second));
    let mut seconds = path.seconds(rate);
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

/// The path's file.
fn path_file_ui(ui: &mut Ui, state: &State, ready: bool, commands: &mut Commands) {
    ui.menu_button("Path file…", |ui| {
        for (name, needs_path, command) in [
            ("Save camera path…", true, Command::File(FileCommand::AskPath(Purpose::SavePath))),
            ("Open camera path…", false, Command::File(FileCommand::AskPath(Purpose::LoadPath))),
            (
                "Remove all keys",
                true,
                Command::Path(PathCommand::change(&state.doc.path, None, CameraPath::clear)),
            ),
        ] {
            let button = ui.add_enabled(ready || !needs_path, Button::new(name));
            if button.on_hover_text(PATH_FILE).clicked() {
                commands.push(command);
            }
        }
    });
}

const ADD: &str = "The view becomes a key behind the selected one.";

const SHARE: &str = "A video or pictures along the path.";

const PATH_FILE: &str = "A transforms.json of every picture of the path with its keys marked, as render --views takes. Opening one adds its keys.";
