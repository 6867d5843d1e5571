//! The options of each way out.

use egui::{DragValue, Grid, RichText, TextEdit, Ui};

use crate::app::model::command::EditCommand;
use crate::app::model::{Command, Commands, SIDES, State};
use crate::app::rooms::path::ui::{length_ui, size_ui, still_ui};
use crate::app::rooms::timeline::{TimeCommand, Timeline};
use crate::app::widgets::{note, segments_ui, weak};
use crate::ways_out::figure::{DOTS_PER_INCH, FigureOf, FigureWidth};
use crate::ways_out::{Options, Way};
use overlook_engine::plural::counted;
use overlook_engine::render::film::FilmComparison;
use overlook_engine::splats::{SplatFormat, SplatSky};

/// Width of the names of options, so that what is chosen stands in one line whatever the way.
const LABELS: f32 = 70.0;

const PATH: &str = "Whoever opens it can follow the camera path.";
const NO_PATH: &str = "The camera path is not in it, as its keys are at one moment.";

const POINTS: [(bool, &str, &str); 2] =
    [(false, "This frame", "One file."), (true, "Every frame", "A folder with a file for each frame.")];

/// A row of the grid: its label, and what is chosen.
fn row_ui(ui: &mut Ui, label: &str, contents: impl FnOnce(&mut Ui)) {
    ui.label(label);
    ui.horizontal(contents);
    ui.end_row();
}

/// A row with a text; `name` names it for screen readers.
fn text_ui(ui: &mut Ui, label: &str, name: &str, field: TextEdit) {
    ui.label(label);
    ui.add(field.desired_width(f32::INFINITY)).accessible_name(name);
    ui.end_row();
}

/// A row with a box that bounds a size, and the bound; `name` names the latter for screen readers.
fn bound_ui(ui: &mut Ui, is_bounded: &mut bool, help: &str, most: DragValue, name: &str) {
    ui.checkbox(is_bounded, "At most").on_hover_text(help);
    ui.horizontal(|ui| ui.add_enabled(*is_bounded, most).accessible_name(name));
    ui.end_row();
}

/// A row of the grid with its label and its name for screen readers: one of some choices.
fn choice_ui<T: Copy + PartialEq, const N: usize>(
    ui: &mut Ui,
    [label, name]: [&str; 2],
    chosen: &mut T,
    choices: [(T, &'static str, &'static str); N],
) {
    ui.label(label);
    *chosen = segments_ui(ui, name, *chosen, choices).unwrap_or(*chosen);
    ui.end_row();
}

/// The options of the chosen way.
pub(crate) fn options_ui(ui: &mut Ui, state: &State, options: &mut Options, commands: &mut Commands) {
    let grid = Grid::new("options of sharing").num_columns(2).min_col_width(LABELS).spacing([12.0, 8.0]);
    grid.show(ui, |ui| match options.way {
        Way::Page => page_ui(ui, state, options),
        Way::Splats => splats_ui(ui, options),
        Way::Film => film_ui(ui, state, options, commands),
        Way::Pictures => pictures_ui(ui, state, options, commands),
        Way::Figure => figure_ui(ui, options),
        Way::Points => choice_ui(ui, ["Points of"; 2], &mut options.points_of_all_frames, POINTS),
        _ => holds_ui(ui, state, options.way),
    });
    match options.way {
        Way::Splats if !options.format.holds_time() => {
            let number = state.timeline.frame + 1;
            note(ui, format!("Such a file holds one frame: number {number}, which is shown."));
        }
        Way::Store if !state.live.cameras.shows_all() => hidden_cameras_ui(ui, state, commands),
        Way::Pictures if !options.along_path => {
            let link =
                ui.link(RichText::new("With what its colors mean and a scale bar it is a figure.").small());
            if link.accessible_name("Share a figure of this view").clicked() {
                (options.way, options.figure_of) = (Way::Figure, FigureOf::Live);
            }
        }
        Way::Page if state.doc.path.pictures() > 0 => {
            let keys = &state.doc.path.keys;
            let passes_time = keys.first().map(|key| key.frame) < keys.last().map(|key| key.frame);
            note(ui, if passes_time { PATH } else { NO_PATH });
        }
        Way::Film => {
            look_ui(ui, state, options);
            still_ui(ui, state);
        }
        Way::Pictures => look_ui(ui, state, options),
        _ => {}
    }
}

fn page_ui(ui: &mut Ui, state: &State, options: &mut Options) {
    let name = state.doc.scene.as_ref().map_or("", |scene| scene.name.as_str());
    text_ui(ui, "Title", "Title of the page", TextEdit::singleline(&mut options.title).hint_text(name));
    let text = TextEdit::multiline(&mut options.text).desired_rows(2).hint_text("About the scene");
    text_ui(ui, "Text", "Text of the page", text);
    let help = "What shows least is made coarser until the page fits.";
    let most = DragValue::new(&mut options.page_megabytes).range(0.2..=10_000.0).speed(0.1).max_decimals(1);
    let most = most.suffix(" MB");
    bound_ui(ui, &mut options.page_is_bounded, help, most, "Most megabytes of the page");
}

fn splats_ui(ui: &mut Ui, options: &mut Options) {
    let formats = [
        (SplatFormat::Ply, "PLY", "One frame, as most programs read it."),
        (SplatFormat::Spz, "SPZ", "One frame, a sixth as large."),
        (SplatFormat::Glb, "GLB", "All frames as glTF, shown by an animation."),
        (SplatFormat::Usda, "USDA", "All frames as USD, shown by visibility."),
    ];
    choice_ui(ui, ["Format"; 2], &mut options.format, formats);
    let skies = [
        (SplatSky::Dome, "Far dome", "Its colors become a dome of splats around the scene."),
        (SplatSky::Out, "Left out", "No format has a place for what is infinitely far away."),
    ];
    choice_ui(ui, ["Sky"; 2], &mut options.sky, skies);
    let help = "Samples are merged where that shows least.";
    let most = DragValue::new(&mut options.kilosplats).range(1..=1_000_000).speed(10.0).suffix(" k splats");
    bound_ui(ui, &mut options.splats_are_bounded, help, most, "Most splats");
}

fn film_ui(ui: &mut Ui, state: &State, options: &mut Options, commands: &mut Commands) {
    compares_ui(ui, state, options);
    row_ui(ui, "Size", |ui| size_ui(ui, state, commands));
    row_ui(ui, "Pace", |ui| {
        let mut rate = state.timeline.frames_per_second;
        let drag = DragValue::new(&mut rate).range(1.0..=120.0).max_decimals(2).suffix(" a second");
        if ui.add(drag).accessible_name("Pictures a second").changed() {
            let change = |timeline: &mut Timeline| timeline.frames_per_second = rate;
            commands.push(Command::Time(TimeCommand::change(&state.timeline, change)));
        }
        let keys = counted(state.doc.path.keys.len(), "key");
        weak(ui, format!("{keys}, {}", counted(state.film_pictures(), "picture")));
    });
    if state.doc.path.pictures() > 0 {
        row_ui(ui, "Length", |ui| length_ui(ui, state, commands));
    }
    let caption = TextEdit::singleline(&mut options.film_caption).hint_text("Below every picture");
    text_ui(ui, "Caption", "Caption of the video", caption);
}

/// What a film shows: the samples, or both sides of the comparison.
fn compares_ui(ui: &mut Ui, state: &State, options: &mut Options) {
    let shows = [
        (None, "Samples", "What the live view renders."),
        (Some(FilmComparison::Wipe), "Wipe", "Both sides of the comparison; the line moves across once."),
        (Some(FilmComparison::Flip), "Flip", "Both sides of the comparison, each for half a second."),
    ];
    choice_ui(ui, ["Shows"; 2], &mut options.compares, shows);
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
fn look_ui(ui: &mut Ui, state: &State, options: &Options) {
    if let (Some(look), None) = (state.film_look(), options.compares) {
        let linear = options.way == Way::Pictures && options.linear;
        let but = if linear { " EXR keeps linear color." } else { "" };
        note(ui, format!("Shown as in the live view: {look}.{but}"));
    }
}

fn pictures_ui(ui: &mut Ui, state: &State, options: &mut Options, commands: &mut Commands) {
    let pictures_of = [
        (false, "This view", "The picture of the live view."),
        (true, "Camera path", "A folder of numbered pictures along the camera path."),
    ];
    choice_ui(ui, ["Of", "Pictures of"], &mut options.along_path, pictures_of);
    let is_path = options.along_path;
    if is_path {
        compares_ui(ui, state, options);
    }
    let is_compared = is_path && options.compares.is_some();
    if !is_compared {
        let is_exr = [
            (false, "PNG", "As they are shown, with alpha where the background is transparent."),
            (true, "EXR", "Linear color, coverage and depth."),
        ];
        choice_ui(ui, ["Format"; 2], &mut options.linear, is_exr);
    }
    if is_path {
        row_ui(ui, "Size", |ui| size_ui(ui, state, commands));
    } else {
        view_size_ui(ui, state, options);
    }
}

const VIEW_SIZE: &str =
    "Columns and rows of the picture. What the view shows fits inside; it is rendered as finely.";

/// Columns and rows of a picture of this view, or percent of what is shown.
fn view_size_ui(ui: &mut Ui, state: &State, options: &mut Options) {
    let shown = state.doc.live_shown.as_ref().map(|shown| shown.picture.size.map(|side| side as u32));
    let shown = shown.unwrap_or(state.live.size);
    let before = options.picture_size.unwrap_or(shown);
    let mut size = before;
    row_ui(ui, "Size", |ui| {
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
    if size != before {
        options.picture_size = (size != shown).then_some(size);
    }
}

fn figure_ui(ui: &mut Ui, options: &mut Options) {
    choice_ui(ui, ["Of", "Figure of"], &mut options.figure_of, FigureOf::ALL);
    let figure = &mut options.figure;
    row_ui(ui, "Width", |ui| {
        let (mut width, mut dots) = (figure.width_mm(), figure.dots_per_inch);
        let drag = DragValue::new(&mut width).range(5.0..=1500.0).speed(0.5).max_decimals(1).suffix(" mm");
        ui.add(drag.update_while_editing(false)).accessible_name("Width of the figure");
        let drag = DragValue::new(&mut dots).range(DOTS_PER_INCH).suffix(" dpi");
        ui.add(drag.update_while_editing(false)).accessible_name("Dots per inch");
        if dots != figure.dots_per_inch || (width - figure.width_mm()).abs() > 0.01 {
            (figure.width, figure.dots_per_inch) = (FigureWidth::Millimeters(width), dots);
        }
        weak(ui, format!("{} px", figure.columns()));
    });
    row_ui(ui, "Paper", |ui| {
        let papers = [
            (false, "Light", "Dark type on white paper."),
            (true, "Dark", "Light type on dark paper, for slides."),
        ];
        figure.is_dark = segments_ui(ui, "Paper", figure.is_dark, papers).unwrap_or(figure.is_dark);
        let size = DragValue::new(&mut figure.type_points).range(4.0..=48.0).speed(0.1).max_decimals(1);
        ui.add(size.suffix(" pt")).on_hover_text("Size of the type").accessible_name("Size of the type");
    });
    row_ui(ui, "With", |ui| {
        ui.checkbox(&mut figure.has_legend, "Legend")
            .on_hover_text("What the colors mean, below the picture.");
        ui.checkbox(&mut figure.has_scale_bar, "Scale bar")
            .on_hover_text("A length in the picture, at the distance of what its middle shows.");
    });
    let caption = TextEdit::multiline(&mut figure.caption).desired_rows(2);
    text_ui(ui, "Caption", "Caption of the figure", caption);
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

/// What a file holds that nothing is chosen of.
fn holds_ui(ui: &mut Ui, state: &State, way: Way) {
    let cameras = state.doc.scene.as_ref().map_or(0, |scene| scene.cameras.len());
    let what = match way {
        Way::Cameras if state.current_whole().is_some() => "posed as pruned".to_owned(),
        Way::Cameras => "posed as in the capture".to_owned(),
        _ => counted(state.frame_count(), "frame"),
    };
    ui.label("Holds");
    ui.label(format!("{}, {what}", counted(cameras, "camera")));
    ui.end_row();
}
