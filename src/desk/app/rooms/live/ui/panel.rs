//! The live view's lens, the cameras whose samples it shows, its pose in numbers, its guides, and the views that are kept.

use std::f64::consts::PI;

use egui::{
    Checkbox, DragValue, Grid, Label, Popup, PopupCloseBehavior, Rect, Response, RichText, ScrollArea, Sense,
    Slider, SliderClamping, TextEdit, Ui, vec2,
};
use egui_material_icons::icons::{ICON_BOOKMARK_ADD, ICON_DELETE, ICON_PLACE};

use crate::app::camera_cues;
use crate::app::model::camera::{ANGLES_OF_VIEW, OrbitCamera, ViewAngles};
use crate::app::model::command::{KeptViewCommand, ViewCommand};
use crate::app::model::look::{FLY_SPEEDS, FrameGuide, Guides, UP_DIRECTIONS, Unit};
use crate::app::model::picture::PictureZoom;
use crate::app::model::{Command, Commands, State};
use crate::app::rooms::cameras::ui::{camera_list_ui, cameras_named};
use crate::app::rooms::live::state::LiveLook;
use crate::app::theme::{Tokens, space};
use crate::app::widgets::{
    NARROW, choice_ui, fold_ui, heading_ui, icon_button, note, picture, segments_ui, text_field_ui,
    view_picture_ui, weak,
};

/// Frames of the window for which the panel scrolls to what was asked for: it may lie behind another then.
const NEW: u64 = 4;

pub(crate) fn view_panel_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    let Some(before) = &state.live.orbit else { return };
    let (mut look, mut orbit) = (state.live.clone(), before.clone());
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        heading_ui(ui, "Kept views");
        kept_views_ui(ui, state, commands);
        lens_ui(ui, &mut orbit);
        heading_ui(ui, "Cameras");
        // The rows are closer than what follows.
        ui.scope(|ui| camera_list_ui(ui, state, &mut look.cameras, commands));
        moving_ui(ui, &mut look, commands);
        fold_ui(ui, "Guides", "view", false, |ui| guides_ui(ui, &mut look.guides));
        fold_ui(ui, "Pose", "view", false, |ui| pose_ui(ui, &mut look.unit, &mut orbit));
    });
    if orbit != *before {
        commands.push(Command::View(ViewCommand::Camera(Box::new(orbit))));
    }
    if look != state.live {
        commands.push(Command::View(ViewCommand::Look(Box::new(look))));
    }
}

fn lens_ui(ui: &mut Ui, orbit: &mut OrbitCamera) {
    heading_ui(ui, "Lens");
    let mut degrees = orbit.angle_of_view() * 180.0 / PI;
    let range = ANGLES_OF_VIEW.map(|angle| angle * 180.0 / PI);
    ui.horizontal(|ui| {
        ui.label("Field of view");
        let slider = Slider::new(&mut degrees, range[0]..=range[1]).suffix("°").max_decimals(1);
        // A value that is only shown is not rounded: that would count as a change.
        let slider = ui.add(slider.clamping(SliderClamping::Edits)).accessible_name("Field of view");
        if slider.on_hover_text("Horizontal angle that the lens sees.").changed() {
            orbit.set_angle_of_view(degrees * PI / 180.0);
        }
    });
    note(ui, format!("focal length {:.0} px of {}×{}", orbit.lens.fx, orbit.lens.width, orbit.lens.height));
}

fn pose_ui(ui: &mut Ui, unit: &mut Unit, orbit: &mut OrbitCamera) {
    let position = &mut orbit.world_from_camera.translation;
    let speed = orbit.pivot_distance * 0.005;
    ui.horizontal(|ui| {
        // Three numbers and their unit fit into the narrowest panel.
        ui.spacing_mut().item_spacing.x = space::SMALL;
        ui.spacing_mut().button_padding.x = space::SMALL + 1.0;
        for (name, value) in [("X", &mut position.x), ("Y", &mut position.y), ("Z", &mut position.z)] {
            let drag = DragValue::new(value).speed(speed).max_decimals(4).prefix(format!("{name} "));
            let drag = ui.add(drag.update_while_editing(false)).accessible_name(format!("Position {name}"));
            drag.on_hover_text("Position of the eye in world space.");
        }
        if *unit == Unit::Meters {
            ui.label("m");
        }
    });
    let before = orbit.angles();
    let mut angles = before;
    ui.horizontal_wrapped(|ui| {
        let ViewAngles { heading, pitch, roll } = &mut angles;
        for (name, help, value) in [
            ("Heading", "Where the view looks on the compass: 0° along +Y, 90° along +X.", heading),
            ("Pitch", "How far it looks up.", pitch),
            ("Roll", "How far it is turned clockwise about the line of sight.", roll),
        ] {
            let mut degrees = *value * 180.0 / PI;
            let drag = DragValue::new(&mut degrees).speed(0.5).max_decimals(1).suffix("°");
            let drag = ui.add(drag.update_while_editing(false)).accessible_name(name);
            if drag.on_hover_text(format!("{name}: {help}")).changed() {
                *value = degrees * PI / 180.0;
            }
        }
        let caption = RichText::new("heading, pitch, roll").small().color(Tokens::in_ui(ui).text_weak);
        // In a row of its own where it does not fit beside the numbers.
        ui.add(Label::new(caption).extend());
    });
    if angles != before {
        orbit.set_angles(angles);
    }
    ui.horizontal(|ui| {
        ui.label("Unit");
        *unit = segments_ui(ui, "Unit", *unit, Unit::ALL).unwrap_or(*unit);
    });
}

fn guides_ui(ui: &mut Ui, guides: &mut Guides) {
    ui.horizontal(|ui| {
        ui.label("Frame");
        guides.frame = segments_ui(ui, "Frame guide", guides.frame, FrameGuide::ALL).unwrap_or(guides.frame);
    });
    for (name, help, on) in [
        ("Lock aspect", "Give the picture the shape of that frame.", &mut guides.locks_aspect),
        ("Axes", "The world's axes; click one to look along it.", &mut guides.axes),
        ("Ground grid", "The ground at the height of the world's origin.", &mut guides.grid),
        ("Pictures in cameras", "Draw every camera with its picture.", &mut guides.pictures),
    ] {
        ui.add(Checkbox::new(on, name)).on_hover_text(help);
    }
}

fn moving_ui(ui: &mut Ui, look: &mut LiveLook, commands: &mut Commands) {
    heading_ui(ui, "Navigation");
    Grid::new("moving").num_columns(2).spacing([space::LARGE, 6.0]).show(ui, |ui| {
        ui.label("Fly speed");
        let slider = Slider::new(&mut look.fly_speed, FLY_SPEEDS).logarithmic(true);
        let help = "Speed of W A S D, Q E; [ and ] change it, Shift is four times as fast.";
        let slider = slider.suffix("×").max_decimals(2).clamping(SliderClamping::Edits);
        ui.add(slider).accessible_name("Fly speed").on_hover_text(help);
        ui.end_row();
        let up = ui.label("Up");
        let now = ui.ctx().cumulative_frame_nr();
        if look.up_wanted_at.is_some_and(|at| now <= at + NEW) {
            up.scroll_to_me(Some(egui::Align::Center));
        }
        if let Some(up) = choice_ui(ui, "Up axis", look.up, &UP_DIRECTIONS, 106.0) {
            commands.push(Command::View(ViewCommand::Up(up)));
        }
        ui.end_row();
        ui.label("Distance");
        ui.horizontal(|ui| {
            let button = ui.selectable_label(look.ruler.active, "Measure distance");
            let help = "Click two points of the live view to measure between them (M).";
            if button.on_hover_text(help).clicked() {
                look.ruler.measure(!look.ruler.active);
            }
            if let Some(distance) = look.ruler.distance() {
                ui.label(RichText::new(look.unit.length(distance)).strong());
            }
        });
        ui.end_row();
    });
}

/// Room for the button behind a name, points.
const BUTTON: f32 = 30.0;

fn kept_views_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    let mut kept = state.doc.kept_views.clone();
    let mut send = |command| commands.push(Command::View(ViewCommand::Kept(command)));
    let mut removed = None;
    for (index, kept) in kept.iter_mut().enumerate() {
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = space::SMALL;
            if view_picture_ui(ui, state.doc.view_pictures.of(&kept.view), &kept.name) {
                send(KeptViewCommand::GoTo(index));
            }
            let width = (ui.available_width() - BUTTON).max(40.0);
            let field = ui.add(TextEdit::singleline(&mut kept.name).desired_width(width));
            field.accessible_name(format!("Name of kept view {}", index + 1));
            let remove = format!("Remove {}", kept.name);
            if icon_button(ui, ICON_DELETE, &remove, "Remove this view from the list.").clicked() {
                removed = Some(index);
            }
        });
    }
    if let Some(index) = removed {
        kept.remove(index);
    }
    if kept != state.doc.kept_views {
        send(KeptViewCommand::Change(kept));
    }
    let button = ui.button((ICON_BOOKMARK_ADD.rich_text(), "Keep view")).accessible_name("Keep view");
    if button.on_hover_text("Keep this view and its frame in the list (Ctrl+D).").clicked() {
        send(KeptViewCommand::Keep);
    }
}

/// Height of an entry, points.
const ROW: f32 = 42.0;

/// Width of an entry's picture.
const LISTED_PICTURE: f32 = 52.0;

/// The button and its list.
pub(crate) fn go_to_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    let Some(scene) = &state.doc.scene else { return };
    let text = if ui.available_width() < NARROW { ICON_PLACE.rich_text() } else { "Go to…".into() };
    let button = ui.button(text).accessible_name("Go to camera");
    let button = button.on_hover_text("View from a camera, or go to a view that was kept.");
    let id = ui.scope_id().with("go to");
    Popup::menu(&button).close_behavior(PopupCloseBehavior::CloseOnClickOutside).width(260.0).show(|ui| {
        let mut filter: String = ui.data(|data| data.get_temp(id)).unwrap_or_default();
        let (changed, entered) = text_field_ui(ui, &mut filter, "Filter by name", "Filter cameras");
        if changed {
            ui.data_mut(|data| data.insert_temp(id, filter.clone()));
        }
        kept_entries_ui(ui, state, commands);
        let matching = cameras_named(scene, &filter);
        ui.add_space(space::SMALL);
        let mut chosen = matching.first().copied().filter(|_| entered);
        if matching.is_empty() {
            weak(ui, "No camera of that name.");
        }
        ui.spacing_mut().item_spacing.y = 2.0;
        let list = ScrollArea::vertical().max_height(360.0).auto_shrink([false, true]);
        list.show_rows(ui, ROW, matching.len(), |ui, rows| {
            for index in &matching[rows] {
                if entry_ui(ui, state, *index, &scene.cameras[*index].name).clicked() {
                    chosen = Some(*index);
                }
            }
        });
        if let Some(camera) = chosen {
            commands.push(Command::View(ViewCommand::JumpTo(camera)));
            ui.data_mut(|data| data.remove::<String>(id));
            ui.close();
        }
    });
}

/// The views that are kept, as pictures beside each other.
fn kept_entries_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    ui.horizontal_wrapped(|ui| {
        for (index, kept) in state.doc.kept_views.iter().enumerate() {
            let name = format!("kept {}", kept.name);
            if view_picture_ui(ui, state.doc.view_pictures.of(&kept.view), &name) {
                commands.push(Command::View(ViewCommand::Kept(KeptViewCommand::GoTo(index))));
                ui.close();
            }
        }
    });
}

fn entry_ui(ui: &mut Ui, state: &State, index: usize, name: &str) -> Response {
    let tokens = Tokens::in_ui(ui);
    let (row, response) = ui.allocate_exact_size(vec2(ui.available_width(), ROW), Sense::click());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, name));
    if response.hovered() || response.has_focus() {
        ui.painter().rect_filled(row, 4.0, tokens.raised_hovered);
    }
    let room = Rect::from_min_size(row.min + vec2(3.0, 3.0), vec2(LISTED_PICTURE, ROW - 6.0));
    ui.painter().rect_filled(room, 3.0, tokens.canvas);
    if let Some(texture) = state.doc.thumbs.get(index) {
        let area = PictureZoom::default().placed(texture.size_vec2(), room);
        picture(ui.painter(), texture.id(), area);
    }
    let dot = egui::pos2(room.right() + 12.0, row.center().y);
    camera_cues::sign(ui.painter(), Rect::from_center_size(dot, vec2(10.0, 10.0)), index);
    let font = egui::TextStyle::Body.resolve(ui.style());
    let at = dot + vec2(12.0, 0.0);
    ui.painter().text(at, egui::Align2::LEFT_CENTER, name, font, tokens.text);
    response
}
