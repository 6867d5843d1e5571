//! Two readings of a capture side by side: the one of its files, and the one by which its views agree better.

use egui::{Button, Id, Label, Modal, RichText, Ui, Vec2};

use crate::app::model::command::{FileCommand, Opening, ReadingCommand};
use crate::app::model::{Command, Commands, OpenScene, State};
use crate::app::rooms::readings::state::ReadingCheck;
use crate::app::theme::{Tokens, space};
use crate::app::widgets::{note, picture, waiting, weak};
use overlook_engine::capture::conventions::{Alternative, Finding, Reading};

/// Width of each of the three pictures, points, and of the window's edge and the dialog's.
const PICTURE: f32 = 250.0;
const EDGES: f32 = 90.0;

/// Height of a picture as a share of its width, before it is there.
const ASPECT: f32 = 0.75;

const EXPLAINED: &str = "Every pixel of depth is reprojected from each camera into the others. Under the right reading the colors found there \
     show what the camera itself recorded.";

/// The dialog, while it is open.
pub(crate) fn readings_ui(ctx: &egui::Context, state: &State, commands: &mut Commands) {
    let readings = &state.doc.readings;
    let (Some(finding), Some(other), Some(scene)) =
        (&readings.finding, readings.alternative(), &state.doc.scene)
    else {
        return;
    };
    if !readings.is_open {
        return;
    }
    let modal = Modal::new(Id::unique("readings")).show(ctx, |ui| {
        let width = PICTURE.min((ctx.content_rect().width() - EDGES) / 3.0);
        ui.set_width(3.0 * width + 2.0 * space::LARGE);
        ui.heading("Compare readings");
        ui.add(Label::new(EXPLAINED).wrap());
        ui.add_space(space::SMALL);
        columns_ui(ui, readings, finding, other, width);
        ui.add_space(space::MEDIUM);
        keys_ui(ui, readings, scene, finding, other);
        ui.add_space(space::MEDIUM);
        buttons_ui(ui, scene, other.can_be_written(&finding.claimed), commands);
    });
    if modal.should_close() {
        commands.push(Command::Reading(ReadingCommand::Compare(false)));
    }
}

fn columns_ui(ui: &mut Ui, readings: &ReadingCheck, finding: &Finding, other: &Alternative, width: f32) {
    let shown = readings.shown.as_ref();
    let camera = shown.map_or("one camera", |shown| &shown.camera);
    let columns = [
        (format!("Recorded by {camera}"), None),
        ("As the capture is read".to_owned(), Some((0, &finding.claimed))),
        ("Other reading".to_owned(), Some((1, &other.reading))),
    ];
    ui.horizontal_top(|ui| {
        ui.spacing_mut().item_spacing.x = space::LARGE;
        for (index, (title, reading)) in columns.into_iter().enumerate() {
            ui.vertical(|ui| {
                ui.set_width(width);
                ui.label(RichText::new(&title).strong());
                picture_ui(ui, readings, index, &title, width);
                match reading {
                    Some((side, reading)) => {
                        reading_ui(ui, shown.map(|shown| shown.votes[side]), reading, &finding.claimed);
                    }
                    None => {
                        note(ui, "What the pictures beside it should show.");
                    }
                }
            });
        }
    });
}

fn picture_ui(ui: &mut Ui, readings: &ReadingCheck, index: usize, name: &str, width: f32) {
    let texture = readings.shown.as_ref().map(|shown| &shown.pictures[index]);
    let aspect = texture.map_or(ASPECT, |texture| {
        let size = texture.size_vec2();
        (size.y / size.x).min(1.5)
    });
    let (area, response) = ui.allocate_exact_size(Vec2::new(width, width * aspect), egui::Sense::hover());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, format!("Picture: {name}")));
    ui.painter().rect_filled(area, f32::from(space::RADIUS), Tokens::in_ui(ui).canvas);
    if let Some(texture) = texture {
        picture(ui.painter(), texture.id(), area);
    } else if readings.trouble.is_none() {
        waiting(ui, area, 22.0);
    }
}

/// What a reading means and how well it fits; what differs from the capture's own stands out.
fn reading_ui(ui: &mut Ui, votes: Option<[f64; 2]>, reading: &Reading, claimed: &Reading) {
    let tokens = Tokens::in_ui(ui);
    let fit = votes.map_or_else(String::new, |[agree, contradict]| {
        format!("{:.0} % of the points agree, {:.0} % contradict", 100.0 * agree, 100.0 * contradict)
    });
    ui.label(RichText::new(fit).strong());
    for (text, claim) in words(reading).into_iter().zip(words(claimed)) {
        let color = if text == claim { tokens.text_weak } else { tokens.accent };
        ui.add(Label::new(RichText::new(text).small().color(color)).wrap());
    }
}

/// The parts of a reading.
fn words(reading: &Reading) -> [String; 5] {
    let lens = reading.lens.words();
    let lens = if lens.is_empty() { "as claimed".to_owned() } else { lens.join(", ") };
    [
        format!("Poses: {}", reading.pose.direction.words()),
        format!("Camera axes: {}", reading.pose.axes.words()),
        format!("Depth: {}", reading.measure.words()),
        format!("Unit of depth: {} world units", serde_json::to_string(&reading.unit).unwrap_or_default()),
        format!("Lens: {lens}"),
    ]
}

/// The keys that make the capture open under the other reading from now on, and the file to write them to.
fn keys_ui(ui: &mut Ui, readings: &ReadingCheck, scene: &OpenScene, finding: &Finding, other: &Alternative) {
    if let Some(trouble) = &readings.trouble {
        ui.add(Label::new(RichText::new(trouble).color(Tokens::in_ui(ui).error)).wrap());
    }
    let sure = if other.undecided.is_empty() {
        format!(
            "The other reading is {}: it fits {:.0} times as well as {}.",
            other.certainty(),
            other.margin,
            other.next()
        )
    } else {
        let open: Vec<&str> = other.undecided.iter().map(|open| open.why.as_str()).collect();
        format!("Not sure: {}.", open.join("; "))
    };
    ui.add(Label::new(sure).wrap());
    if !other.can_be_written(&finding.claimed) {
        weak(ui, "No key of a manifest can express this; convert the depth files.");
        return;
    }
    let text = match &scene.manifest {
        Some(manifest) => format!("To keep it, write this before \"frames\" in {}:", manifest.display()),
        None => "To keep it, write the manifest (overlook info FOLDER --write-manifest), and add this before \"frames\" in it:".to_owned(),
    };
    ui.add(Label::new(text).wrap());
    ui.add(Label::new(RichText::new(readings.keys()).monospace()).wrap().selectable(true));
}

fn buttons_ui(ui: &mut Ui, scene: &OpenScene, can_be_written: bool, commands: &mut Commands) {
    ui.horizontal(|ui| {
        let (name, otherwise) = if scene.is_reread {
            ("Open as its files say", false)
        } else {
            ("Open under the other reading", true)
        };
        let help = "Opens the capture again; its files stay as they are.";
        let open = ui.add_enabled(can_be_written, Button::new(name)).on_hover_text(help);
        if open.on_disabled_hover_text("No key of a manifest can express this reading.").clicked() {
            commands.push(Command::File(FileCommand::Open(Opening::Reading(otherwise))));
        }
        if ui.add_enabled(can_be_written, Button::new("Copy keys")).clicked() {
            commands.push(Command::Reading(ReadingCommand::CopyKeys));
        }
        if ui.button("Close").accessible_name("Close readings").clicked() {
            commands.push(Command::Reading(ReadingCommand::Compare(false)));
        }
    });
}
