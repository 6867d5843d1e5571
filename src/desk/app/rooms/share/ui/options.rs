//! The options of each way out.

use egui::{DragValue, Grid, RichText, TextEdit, Ui};

use crate::app::model::command::EditCommand;
use crate::app::model::picture::HoleDisplay;
use crate::app::model::purpose::{DOTS_PER_INCH, FigureOf, FigureOptions, FigureWidth};
use crate::app::model::ways_out::{ShareOptions, ShareWay, SharedPictures};
use crate::app::model::{Command, Commands, SIDES, State};
use crate::app::rooms::path::ui::{length_ui, size_ui, still_ui};
use crate::app::rooms::timeline::{TimeCommand, Timeline};
use crate::app::widgets::{note, segments_ui, weak};
use overlook_engine::plural::counted;
use overlook_engine::render::film::FilmComparison;
use overlook_engine::splats::{SplatFormat, SplatSky};

/// Width of the names of options, so that what is chosen stands in one line whatever the way.
const LABELS: f32 = 70.0;

/// Formats of splats: name and help.
const FORMATS: [(SplatFormat, &str, &str); 4] = [
    (SplatFormat::Ply, "PLY", "One frame, as most programs read it."),
    (SplatFormat::Spz, "SPZ", "One frame, a sixth as large."),
    (SplatFormat::Glb, "GLB", "All frames as glTF, shown by an animation."),
    (SplatFormat::Usda, "USDA", "All frames as USD, shown by visibility."),
];

/// What becomes of the sky.
const SKIES: [(SplatSky, &str, &str); 2] = [
    (SplatSky::Out, "Left out", "No format has a place for what is infinitely far away."),
    (SplatSky::Dome, "Far dome", "Its colors become a dome of splats around the scene."),
];

/// Whether pictures are EXR.
const KINDS: [(bool, &str, &str); 2] = [
    (false, "PNG", "As they are shown, with alpha where the background is transparent."),
    (true, "EXR", "Linear color, coverage and depth."),
];

/// What a film shows.
const COMPARES: [(Option<FilmComparison>, &str, &str); 3] = [
    (None, "Samples", "What the live view renders."),
    (Some(FilmComparison::Wipe), "Wipe", "Both sides of the comparison; the line moves across once."),
    (Some(FilmComparison::Flip), "Flip", "Both sides of the comparison, each for half a second."),
];

const PATH: &str = "Whoever opens it can follow the camera path.";
const NO_PATH: &str = "The camera path is not in it, as its keys are at one moment.";

/// The paper of figures.
const PAPERS: [(bool, &str, &str); 2] =
    [(false, "Light", "Dark type on white paper."), (true, "Dark", "Light type on dark paper, for slides.")];

/// Which points.
const POINTS: [(bool, &str, &str); 2] =
    [(false, "This frame", "One file."), (true, "Every frame", "A folder with a file for each frame.")];

/// The options of the chosen way.
pub(crate) fn options_ui(ui: &mut Ui, state: &State, options: &mut ShareOptions, commands: &mut Commands) {
    let grid = Grid::new("options of sharing").num_columns(2).min_col_width(LABELS).spacing([12.0, 8.0]);
    grid.show(ui, |ui| match options.way {
        ShareWay::Page => page_ui(ui, state, options),
        ShareWay::Splats => splats_ui(ui, options),
        ShareWay::Film => film_ui(ui, state, options, commands),
        ShareWay::Pictures => pictures_ui(ui, state, options, commands),
        ShareWay::Figure => figure_ui(ui, options),
        ShareWay::Points => {
            ui.label("Points of");
            let all = &mut options.points_of_all_frames;
            *all = segments_ui(ui, "Points of", *all, POINTS).unwrap_or(*all);
            ui.end_row();
        }
        ShareWay::Cameras => cameras_ui(ui, state),
        ShareWay::Store => store_ui(ui, state),
    });
    match options.way {
        ShareWay::Splats if !options.format.holds_time() => {
            let number = state.timeline.frame + 1;
            note(ui, format!("Such a file holds one frame: number {number}, which is shown."));
        }
        ShareWay::Store if !state.live.cameras.shows_all() => hidden_cameras_ui(ui, state, commands),
        ShareWay::Pictures if options.pictures == SharedPictures::View => {
            if state.holes_shown() == HoleDisplay::Dimmed && !options.linear {
                note(ui, "As in the live view, what fills holes far from samples is dimmed.");
            }
            let link =
                ui.link(RichText::new("With what its colors mean and a scale bar it is a figure.").small());
            if link.accessible_name("Share a figure of this view").clicked() {
                (options.way, options.figure_of) = (ShareWay::Figure, FigureOf::Live);
            }
        }
        ShareWay::Page if state.doc.path.pictures() > 0 => {
            let keys = &state.doc.path.keys;
            let passes_time = keys.first().map(|key| key.frame) < keys.last().map(|key| key.frame);
            note(ui, if passes_time { PATH } else { NO_PATH });
        }
        ShareWay::Film => {
            look_ui(ui, state, options);
            still_ui(ui, state);
        }
        ShareWay::Pictures if options.pictures == SharedPictures::CameraPath => look_ui(ui, state, options),
        _ => {}
    }
}

fn page_ui(ui: &mut Ui, state: &State, options: &mut ShareOptions) {
    let name = state.doc.scene.as_ref().map_or("", |scene| scene.name.as_str());
    ui.label("Title");
    ui.add(TextEdit::singleline(&mut options.title).desired_width(f32::INFINITY).hint_text(name))
        .accessible_name("Title of the page");
    ui.end_row();
    ui.label("Text");
    ui.add(
        TextEdit::multiline(&mut options.text)
            .desired_width(f32::INFINITY)
            .desired_rows(2)
            .hint_text("About the scene"),
    )
    .accessible_name("Text of the page");
    ui.end_row();
    ui.checkbox(&mut options.page_is_bounded, "At most")
        .on_hover_text("What shows least is made coarser until the page fits.");
    ui.horizontal(|ui| {
        let drag =
            DragValue::new(&mut options.page_megabytes).range(0.2..=10_000.0).speed(0.1).max_decimals(1);
        ui.add_enabled(options.page_is_bounded, drag.suffix(" MB"))
            .accessible_name("Most megabytes of the page");
    });
    ui.end_row();
}

fn splats_ui(ui: &mut Ui, options: &mut ShareOptions) {
    ui.label("Format");
    options.format = segments_ui(ui, "Format", options.format, FORMATS).unwrap_or(options.format);
    ui.end_row();
    ui.label("Sky");
    options.sky = segments_ui(ui, "Sky", options.sky, SKIES).unwrap_or(options.sky);
    ui.end_row();
    ui.checkbox(&mut options.splats_are_bounded, "At most")
        .on_hover_text("Samples are merged where that shows least.");
    ui.horizontal(|ui| {
        let drag =
            DragValue::new(&mut options.kilosplats).range(1..=1_000_000).speed(10.0).suffix(" k splats");
        ui.add_enabled(options.splats_are_bounded, drag).accessible_name("Most splats");
    });
    ui.end_row();
}

fn film_ui(ui: &mut Ui, state: &State, options: &mut ShareOptions, commands: &mut Commands) {
    compares_ui(ui, state, options);
    picture_size_ui(ui, state, commands);
    ui.label("Pace");
    ui.horizontal(|ui| {
        let mut rate = state.timeline.frames_per_second;
        let drag = DragValue::new(&mut rate).range(1.0..=120.0).max_decimals(2).suffix(" a second");
        if ui.add(drag).accessible_name("Pictures a second").changed() {
            let change = |timeline: &mut Timeline| timeline.frames_per_second = rate;
            commands.push(Command::Time(TimeCommand::change(&state.timeline, change)));
        }
        let keys = counted(state.doc.path.keys.len(), "key");
        weak(ui, format!("{keys}, {}", counted(state.film_pictures(), "picture")));
    });
    ui.end_row();
    if state.doc.path.pictures() > 0 {
        ui.label("Length");
        length_ui(ui, state, commands);
        ui.end_row();
    }
}

/// What a film shows: the samples, or both sides of the comparison.
fn compares_ui(ui: &mut Ui, state: &State, options: &mut ShareOptions) {
    ui.label("Shows");
    options.compares = segments_ui(ui, "Shows", options.compares, COMPARES).unwrap_or(options.compares);
    ui.end_row();
    if options.compares.is_some() {
        ui.label("");
        let sides = state.inspector.compare.choice.sides;
        let [left, right] = sides.map(|side| state.side_name(side));
        let along = state.doc.path.pictures() > 0;
        let place = if along { "along the camera path" } else { "over the played frames" };
        note(ui, format!("{left} and {right}, as chosen in Compare, {place}."));
        ui.end_row();
    }
}

/// Says that pictures along the path look as the live view does, where that is not plain.
fn look_ui(ui: &mut Ui, state: &State, options: &ShareOptions) {
    if let (Some(look), None) = (state.film_look(), options.compares) {
        let linear = options.way == ShareWay::Pictures && options.linear;
        let but = if linear { " EXR keeps linear color." } else { "" };
        note(ui, format!("Shown as in the live view: {look}.{but}"));
    }
}

fn picture_size_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    ui.label("Size");
    ui.horizontal(|ui| size_ui(ui, state, commands));
    ui.end_row();
}

fn pictures_ui(ui: &mut Ui, state: &State, options: &mut ShareOptions, commands: &mut Commands) {
    ui.label("Of");
    options.pictures =
        segments_ui(ui, "Pictures of", options.pictures, SharedPictures::ALL).unwrap_or(options.pictures);
    ui.end_row();
    let is_path = options.pictures == SharedPictures::CameraPath;
    if is_path {
        compares_ui(ui, state, options);
    }
    let is_compared = is_path && options.compares.is_some();
    if !is_compared {
        ui.label("Format");
        options.linear = segments_ui(ui, "Format", options.linear, KINDS).unwrap_or(options.linear);
        ui.end_row();
    }
    if is_path {
        picture_size_ui(ui, state, commands);
    }
    if options.pictures == SharedPictures::View {
        view_size_ui(ui, state, options);
    }
}

const VIEW_SIZE: &str =
    "Columns and rows of the picture. What the view shows fits inside; it is rendered as finely.";

/// Columns and rows of a picture of this view, or percent of what is shown.
fn view_size_ui(ui: &mut Ui, state: &State, options: &mut ShareOptions) {
    let shown = state.doc.live_shown.as_ref().map(|shown| shown.picture.size.map(|side| side as u32));
    let shown = shown.unwrap_or(state.live.size);
    let before = options.picture_size.unwrap_or(shown);
    let mut size = before;
    ui.label("Size");
    ui.horizontal(|ui| {
        let [width, height] = &mut size;
        for (name, separator, side) in [("Columns", "×", width), ("Rows", "", height)] {
            let drag = DragValue::new(side).range(SIDES).speed(2.0).update_while_editing(false);
            ui.add(drag).on_hover_text(VIEW_SIZE).accessible_name(name);
            ui.label(separator);
        }
        let mut percent = 100.0 * f64::from(before[0]) / f64::from(shown[0].max(1));
        let drag = DragValue::new(&mut percent).range(0.0..=1e6).max_decimals(0).suffix(" %");
        let field = ui.add(drag.update_while_editing(false)).on_hover_text("Of what is shown.");
        if field.accessible_name("Percent of what is shown").changed() {
            let side = |side: u32| (f64::from(side) * percent / 100.0).round() as u32;
            size = shown.map(|shown| side(shown).clamp(*SIDES.start(), *SIDES.end()));
        }
        if options.picture_size.is_some() && ui.button("As shown").clicked() {
            size = shown;
        }
    });
    ui.end_row();
    if size != before {
        options.picture_size = (size != shown).then_some(size);
    }
}

fn figure_ui(ui: &mut Ui, options: &mut ShareOptions) {
    ui.label("Of");
    options.figure_of =
        segments_ui(ui, "Figure of", options.figure_of, FigureOf::ALL).unwrap_or(options.figure_of);
    ui.end_row();
    let figure = &mut options.figure;
    ui.label("Width");
    ui.horizontal(|ui| {
        let (mut width, mut dots) = (figure.width_mm(), figure.dots_per_inch);
        let drag = DragValue::new(&mut width).range(5.0..=1500.0).speed(0.5).max_decimals(1).suffix(" mm");
        ui.add(drag.update_while_editing(false)).accessible_name("Width of the figure");
        let drag = DragValue::new(&mut dots).range(DOTS_PER_INCH).suffix(" dpi");
        ui.add(drag.update_while_editing(false)).accessible_name("Dots per inch");
        if dots != figure.dots_per_inch || (width - figure.width_mm()).abs() > 0.01 {
            *figure = FigureOptions {
                columns: FigureWidth::Millimeters(width).columns(dots),
                dots_per_inch: dots,
                ..figure.clone()
            };
        }
        weak(ui, format!("{} px", figure.columns));
    });
    ui.end_row();
    ui.label("Paper");
    ui.horizontal(|ui| {
        figure.is_dark = segments_ui(ui, "Paper", figure.is_dark, PAPERS).unwrap_or(figure.is_dark);
        let size = DragValue::new(&mut figure.type_points).range(4.0..=48.0).speed(0.1).max_decimals(1);
        ui.add(size.suffix(" pt")).on_hover_text("Size of the type").accessible_name("Size of the type");
    });
    ui.end_row();
    ui.label("With");
    ui.horizontal(|ui| {
        ui.checkbox(&mut figure.has_legend, "Legend")
            .on_hover_text("What the colors mean, below the picture.");
        ui.checkbox(&mut figure.has_scale_bar, "Scale bar")
            .on_hover_text("A length in the picture, at the distance of what its middle shows.");
    });
    ui.end_row();
    ui.label("Caption");
    let caption = TextEdit::multiline(&mut figure.caption).desired_width(f32::INFINITY).desired_rows(2);
    ui.add(caption).accessible_name("Caption of the figure");
    ui.end_row();
}

/// Says that hidden cameras are saved as well, and can leave them out.
fn hidden_cameras_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    let Some(scene) = &state.doc.scene else { return };
    let left_out = state.doc.edits.list.cameras_left_out();
    let is_in = |index: &usize| !left_out.contains(scene.cameras[*index].name.as_str());
    let saved: Vec<usize> = (0..scene.cameras.len()).filter(is_in).collect();
    let hidden: Vec<usize> =
        saved.iter().copied().filter(|camera| !state.live.cameras.shows(*camera)).collect();
    if hidden.is_empty() {
        return;
    }
    note(ui, "Cameras that the live view leaves out are in it as well.");
    // Something has to be left.
    if hidden.len() < saved.len() {
        let help = "In one edit: they take no part in pruning and are not saved. Ctrl+Z takes it back.";
        if ui.button("Leave hidden cameras out").on_hover_text(help).clicked() {
            commands.push(Command::Edit(EditCommand::LeaveOut(hidden)));
        }
    }
}

fn cameras_ui(ui: &mut Ui, state: &State) {
    ui.label("Holds");
    let cameras = state.doc.scene.as_ref().map_or(0, |scene| scene.cameras.len());
    let poses = if state.current_whole().is_some() { "posed as pruned" } else { "posed as in the capture" };
    ui.label(format!("{}, {poses}", counted(cameras, "camera")));
    ui.end_row();
}

fn store_ui(ui: &mut Ui, state: &State) {
    let cameras = state.doc.scene.as_ref().map_or(0, |scene| scene.cameras.len());
    ui.label("Holds");
    ui.label(format!("{}, {}", counted(cameras, "camera"), counted(state.frame_count(), "frame")));
    ui.end_row();
}
