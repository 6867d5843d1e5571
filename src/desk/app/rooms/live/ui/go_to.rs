//! The list of cameras to go to: with their pictures, and a field that filters them by name.

use egui::{Popup, PopupCloseBehavior, Rect, Response, ScrollArea, Sense, Ui, vec2};

use egui_material_icons::icons::ICON_PLACE;

use crate::app::model::{Command, Commands, State};
use crate::app::rooms::live::model::ViewCommand;
use crate::app::theme::{Tokens, space};
use crate::app::widgets::{text_field_ui, weak};
use crate::app::{camera_cues, widgets};

/// Height of an entry, points.
const ROW: f32 = 42.0;

/// Width of an entry's picture.
const PICTURE: f32 = 52.0;

/// In less than this width the button shows an icon instead of its name, since the tabs need the room.
const NARROW: f32 = 180.0;

/// The button and its list.
pub(crate) fn go_to_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    let Some(scene) = &state.doc.scene else { return };
    let text = if ui.available_width() < NARROW { ICON_PLACE.rich_text() } else { "Go to…".into() };
    let button = ui.button(text).accessible_name("Go to camera");
    let button = button.on_hover_text("View from a camera.");
    let id = ui.scope_id().with("go to");
    Popup::menu(&button).close_behavior(PopupCloseBehavior::CloseOnClickOutside).width(260.0).show(|ui| {
        let mut filter: String = ui.data(|data| data.get_temp(id)).unwrap_or_default();
        let (changed, entered) = text_field_ui(ui, &mut filter, "Filter by name", "Filter cameras");
        if changed {
            ui.data_mut(|data| data.insert_temp(id, filter.clone()));
        }
        let wanted = filter.to_lowercase();
        let matching: Vec<usize> = (0..scene.cameras.len())
            .filter(|index| scene.cameras[*index].name.to_lowercase().contains(&wanted))
            .collect();
        ui.add_space(space::SMALL);
        let mut chosen = matching.first().copied().filter(|_| entered);
        if matching.is_empty() {
            weak(ui, "No camera of that name.");
        }
        ui.spacing_mut().item_spacing.y = 2.0;
        let list = ScrollArea::vertical().max_height(360.0).auto_shrink([false, true]);
        list.show_rows(ui, ROW, matching.len(), |ui, rows| {
            for index in &matching[rows] {
                if entry_ui(ui, state, *index).clicked() {
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

fn entry_ui(ui: &mut Ui, state: &State, index: usize) -> Response {
    let tokens = Tokens::in_ui(ui);
    let camera = &state.doc.scene.as_ref().map_or(&[][..], |scene| &scene.cameras)[index];
    let (row, response) = ui.allocate_exact_size(vec2(ui.available_width(), ROW), Sense::click());
    let name = camera.name.as_str();
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, name));
    if response.hovered() || response.has_focus() {
        ui.painter().rect_filled(row, 4.0, tokens.raised_hovered);
    }
    let room = Rect::from_min_size(row.min + vec2(3.0, 3.0), vec2(PICTURE, ROW - 6.0));
    ui.painter().rect_filled(room, 3.0, tokens.canvas);
    if let Some(texture) = state.doc.thumbs.get(index) {
        let [width, height] = [camera.intrinsics.width, camera.intrinsics.height].map(|side| side as f32);
        let scale = (room.width() / width).min(room.height() / height);
        let area = Rect::from_center_size(room.center(), vec2(width, height) * scale);
        widgets::picture(ui.painter(), texture.id(), area);
    }
    let dot = egui::pos2(room.right() + 12.0, row.center().y);
    camera_cues::sign(ui.painter(), Rect::from_center_size(dot, vec2(10.0, 10.0)), index);
    let font = egui::TextStyle::Body.resolve(ui.style());
    let at = dot + vec2(12.0, 0.0);
    ui.painter().text(at, egui::Align2::LEFT_CENTER, name, font, tokens.text);
    response
}
