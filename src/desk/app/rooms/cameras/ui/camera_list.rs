//! The cameras whose samples the live view shows: each on or off, or one alone.

use egui::{ScrollArea, Ui};
use egui_material_icons::icons::{ICON_VISIBILITY, ICON_VISIBILITY_OFF};

use crate::app::model::{Command, Commands, State};
use crate::app::rooms::live::model::ViewCommand;
use crate::app::rooms::source::model::SourceCommand;
use crate::app::widgets::{dot, icon_button, note};

/// Height of an entry, points.
const ROW: f32 = 26.0;

/// Cameras from which on a field filters them.
const MANY: usize = 8;

/// The list, with a field that filters it.
pub(crate) fn camera_list_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    let Some(scene) = &state.doc.scene else { return };
    let cameras = &state.live.cameras;
    ui.horizontal(|ui| {
        for (name, on) in [("All on", true), ("All off", false)] {
            if ui.button(name).clicked() {
                commands.push(Command::View(ViewCommand::AllCameras(on)));
            }
        }
        let shown = (0..scene.cameras.len()).filter(|camera| cameras.shows(*camera)).count();
        note(ui, format!("{shown} of {} shown", scene.cameras.len()));
    });
    let id = ui.scope_id().with("camera filter");
    let mut filter: String = ui.data(|data| data.get_temp(id)).unwrap_or_default();
    if scene.cameras.len() >= MANY {
        let field = egui::TextEdit::singleline(&mut filter).hint_text("Filter by name");
        if ui.add(field).accessible_name("Filter the cameras").changed() {
            ui.data_mut(|data| data.insert_temp(id, filter.clone()));
        }
    }
    let wanted = filter.to_lowercase();
    let matching: Vec<usize> = (0..scene.cameras.len())
        .filter(|index| scene.cameras[*index].name.to_lowercase().contains(&wanted))
        .collect();
    ui.spacing_mut().item_spacing.y = 2.0;
    let list = ScrollArea::vertical().id_salt("cameras").max_height(260.0).auto_shrink([false, true]);
    list.show_rows(ui, ROW, matching.len(), |ui, rows| {
        for index in &matching[rows] {
            ui.horizontal(|ui| row_ui(ui, state, *index, &scene.cameras[*index].name, commands));
        }
    });
}

fn row_ui(ui: &mut Ui, state: &State, index: usize, name: &str, commands: &mut Commands) {
    let cameras = &state.live.cameras;
    let is_on = !cameras.off.contains(&index);
    let (icon, verb) = if is_on { (ICON_VISIBILITY, "Hide") } else { (ICON_VISIBILITY_OFF, "Show") };
    let help = format!("{verb} the samples of {name} in the live view");
    if icon_button(ui, icon, &format!("{verb} {name}"), &help).clicked() {
        commands.push(Command::View(ViewCommand::CameraOn(index, !is_on)));
    }
    let is_solo = cameras.solo == Some(index);
    let solo = ui.selectable_label(is_solo, "Solo").accessible_name(format!("Solo {name}"));
    if solo.on_hover_text("Show its samples alone").clicked() {
        commands.push(Command::View(ViewCommand::Solo((!is_solo).then_some(index))));
    }
    dot(ui, index);
    let chosen = index == state.source.camera;
    let label = ui.selectable_label(chosen, name).accessible_name(format!("Camera {name}"));
    let label = label.on_hover_text("Click: show its picture. Double-click: view from it.");
    if label.double_clicked() {
        commands.push(Command::View(ViewCommand::JumpTo(index)));
    } else if label.clicked() {
        commands.push(Command::Source(SourceCommand::Camera(index)));
    }
}
