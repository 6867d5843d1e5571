//! The cameras whose samples the live view shows: each on or off, or one alone.

use egui::{Align, Layout, Ui, UiBuilder, vec2};
use egui_material_icons::icons::{ICON_VISIBILITY, ICON_VISIBILITY_OFF};

use super::overlay;
use crate::app::model::{Command, Commands, State};
use crate::app::rooms::live::model::{ShownCameras, ViewCommand};
use crate::app::rooms::source::model::SourceCommand;
use crate::app::widgets::{dot, icon_button, note};

/// Height of an entry, points.
const ROW: f32 = 26.0;

/// Entries that are shown before the rest is asked for, so that what follows stays near.
const FEW: usize = 8;

/// Frames of the window for which a choice is new: the panel may lie behind another when it is made.
const NEW: u64 = 4;

/// What is remembered of the list.
#[derive(Clone, Default)]
struct ListLook {
    filter: String,
    shows_all: bool,
    /// When the camera was chosen that was scrolled to last.
    scrolled_to: Option<u64>,
}

/// The list, with a field that filters it. A camera that is chosen elsewhere is scrolled to.
pub(crate) fn camera_list_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    let Some(scene) = &state.doc.scene else { return };
    let cameras = &state.live.cameras;
    ui.horizontal(|ui| {
        for (name, on) in [("All on", true), ("All off", false)] {
            if ui.button(name).clicked() {
                let off = if on { 0..0 } else { 0..scene.cameras.len() };
                let cameras = ShownCameras { off: off.collect(), solo: None };
                commands.push(Command::View(ViewCommand::look(&state.live, |live| live.cameras = cameras)));
            }
        }
        let shown = (0..scene.cameras.len()).filter(|camera| cameras.shows(*camera)).count();
        note(ui, format!("{shown} of {} shown", scene.cameras.len()));
    });
    let id = ui.scope_id().with("camera list");
    let mut look: ListLook = ui.data(|data| data.get_temp(id)).unwrap_or_default();
    if scene.cameras.len() > FEW {
        let field = egui::TextEdit::singleline(&mut look.filter).hint_text("Filter by name");
        ui.add(field).accessible_name("Filter the cameras");
    }
    let chosen = state.source.camera;
    let now = ui.ctx().cumulative_frame_nr();
    let is_new = state.source.chosen_at.is_some_and(|at| now <= at + NEW)
        && look.scrolled_to != state.source.chosen_at;
    let matching_to = |filter: &str| -> Vec<usize> {
        let (wanted, cameras) = (filter.to_lowercase(), scene.cameras.iter().enumerate());
        cameras
            .filter(|(_, camera)| camera.name.to_lowercase().contains(&wanted))
            .map(|(index, _)| index)
            .collect()
    };
    let mut matching = matching_to(&look.filter);
    if is_new {
        look.scrolled_to = state.source.chosen_at;
        if !matching.contains(&chosen) {
            look.filter.clear();
            matching = matching_to("");
        }
        look.shows_all |=
            matching.iter().position(|index| *index == chosen).is_some_and(|place| place >= FEW);
    }
    let shown = if look.shows_all { matching.len() } else { matching.len().min(FEW) };
    ui.spacing_mut().item_spacing.y = 2.0;
    for index in &matching[..shown] {
        let (_, place) = ui.allocate_space(vec2(ui.available_width(), ROW));
        if is_new && *index == chosen {
            ui.scroll_to_rect(place, None);
        }
        // Of hundreds only what is in view is drawn.
        if ui.is_rect_visible(place) {
            let line = UiBuilder::new().id_salt(("camera", *index)).max_rect(place);
            let mut line = ui.new_child(line.layout(Layout::left_to_right(Align::Center)));
            row_ui(&mut line, state, *index, &scene.cameras[*index].name, commands);
        }
    }
    if matching.len() > FEW {
        let name =
            if look.shows_all { "Show fewer".to_owned() } else { format!("Show all {}", matching.len()) };
        look.shows_all ^= ui.button(name).clicked();
    }
    ui.data_mut(|data| data.insert_temp(id, look));
}

fn row_ui(ui: &mut Ui, state: &State, index: usize, name: &str, commands: &mut Commands) {
    let cameras = &state.live.cameras;
    let is_on = !cameras.off.contains(&index);
    let (icon, verb) = if is_on { (ICON_VISIBILITY, "Hide") } else { (ICON_VISIBILITY_OFF, "Show") };
    let help = format!("{verb} the samples of {name} in the live view");
    if icon_button(ui, icon, &format!("{verb} {name}"), &help).clicked() {
        commands
            .push(Command::View(ViewCommand::look(&state.live, |live| live.cameras.switch(index, !is_on))));
    }
    let is_solo = cameras.solo == Some(index);
    let solo = ui.selectable_label(is_solo, "Solo").accessible_name(format!("Solo {name}"));
    if solo.on_hover_text("Show its samples alone").clicked() {
        let solo = (!is_solo).then_some(index);
        commands.push(Command::View(ViewCommand::look(&state.live, |live| live.cameras.solo = solo)));
    }
    dot(ui, index);
    let chosen = overlay::is_chosen(state, index);
    let label = ui.selectable_label(chosen, name).accessible_name(format!("Camera {name}"));
    let label = label.on_hover_text(overlay::clicks(state));
    if label.double_clicked() {
        commands.push(Command::View(ViewCommand::JumpTo(index)));
    } else if label.clicked() {
        commands.push(Command::Source(SourceCommand::Camera(index)));
    }
}
