//! The views that are kept, each with its picture and its name.

use egui::{Rect, Sense, TextEdit, TextureHandle, Ui, vec2};
use egui_material_icons::icons::{ICON_BOOKMARK_ADD, ICON_DELETE};

use crate::app::model::State;
use crate::app::rooms::live::model::{KeptViewCommand, ViewCommand};
use crate::app::theme::{Tokens, space};
use crate::app::widgets::{icon_button, note, picture};

/// Columns and rows of a picture, points.
const PICTURE: egui::Vec2 = vec2(58.0, 39.0);

/// Room for the button behind a name, points.
const BUTTON: f32 = 30.0;

/// The section of the panel.
pub(super) fn kept_views_ui(ui: &mut Ui, state: &State, sent: &mut Vec<ViewCommand>) {
    let kept = &state.doc.kept_views;
    for (index, kept) in kept.iter().enumerate() {
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = space::SMALL;
            let picture = state.doc.view_pictures.of(&kept.view);
            if view_picture_ui(ui, picture, &kept.name) {
                sent.push(ViewCommand::Kept(KeptViewCommand::GoTo(index)));
            }
            let mut name = kept.name.clone();
            let width = (ui.available_width() - BUTTON).max(40.0);
            let field = ui.add(TextEdit::singleline(&mut name).desired_width(width));
            if field.accessible_name(format!("Name of kept view {}", index + 1)).changed() {
                sent.push(ViewCommand::Kept(KeptViewCommand::Rename(index, name)));
            }
            let remove = format!("Remove {}", kept.name);
            if icon_button(ui, ICON_DELETE, &remove, "Remove this view from the list.").clicked() {
                sent.push(ViewCommand::Kept(KeptViewCommand::Remove(index)));
            }
        });
    }
    let button = ui.button((ICON_BOOKMARK_ADD.rich_text(), "Keep view")).accessible_name("Keep view");
    if button.on_hover_text("Keep this view and its frame in the list (Ctrl+D).").clicked() {
        sent.push(ViewCommand::Kept(KeptViewCommand::Keep));
    }
    if !kept.is_empty() {
        note(ui, "A picture goes there; Alt and the left arrow come back. Sessions keep the list.");
    }
}

/// The small picture of a view that is called `name`; true where it was clicked.
pub(crate) fn view_picture_ui(ui: &mut Ui, shown: Option<&TextureHandle>, name: &str) -> bool {
    let tokens = Tokens::in_ui(ui);
    let (room, response) = ui.allocate_exact_size(PICTURE, Sense::click());
    let name = format!("Go to {name}");
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, &name));
    ui.painter().rect_filled(room, 3.0, tokens.canvas);
    if let Some(texture) = shown {
        let size = texture.size_vec2();
        let scale = (room.width() / size.x).min(room.height() / size.y);
        picture(ui.painter(), texture.id(), Rect::from_center_size(room.center(), size * scale));
    }
    if response.hovered() || response.has_focus() {
        let stroke = egui::Stroke::new(2.0, tokens.accent);
        ui.painter().rect_stroke(room, 3.0, stroke, egui::StrokeKind::Inside);
    }
    response.on_hover_text(name).clicked()
}
