//! What was open lately, by small pictures.

use std::path::Path;
use std::sync::Arc;

use egui::{
    Align, Color32, Id, Label, Layout, Pos2, Rect, Sense, Stroke, StrokeKind, TextureHandle, Ui, pos2, vec2,
};
use egui_material_icons::icons::ICON_FOLDER_OPEN;

use crate::app::model::{Command, Commands, State};
use crate::app::rooms::files::model::{FileCommand, Opening, RECENT_SIDES, RecentPicture};
use crate::app::theme::{Tokens, space};
use crate::app::widgets::note;

/// Recent files that are offered while nothing is open, and how many of them lie side by side.
const SHOWN: usize = 6;
const PER_ROW: usize = 3;

/// Room for a name, points.
const NAME_HEIGHT: f32 = 20.0;

/// Recent files, each opened by a click.
pub(crate) fn recent_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    if state.recent.is_empty() {
        return;
    }
    ui.add_space(space::MEDIUM);
    note(ui, "Recent");
    let [width, height] = RECENT_SIDES.map(|side| side as f32);
    let gap = ui.spacing().item_spacing;
    let offered = &state.recent[..state.recent.len().min(SHOWN)];
    for row in offered.chunks(PER_ROW) {
        let size = vec2(row.len() as f32 * (width + gap.x) - gap.x, height + NAME_HEIGHT + gap.y);
        ui.allocate_ui_with_layout(size, Layout::left_to_right(Align::Min), |ui| {
            for path in row {
                let size = vec2(width, size.y);
                ui.allocate_ui_with_layout(size, Layout::top_down(Align::Center), |ui| {
                    card_ui(ui, path, state, commands);
                });
            }
        });
    }
}

fn card_ui(ui: &mut Ui, path: &Path, state: &State, commands: &mut Commands) {
    let tokens = Tokens::in_ui(ui);
    let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy();
    let [width, height] = RECENT_SIDES.map(|side| side as f32);
    let (area, response) = ui.allocate_exact_size(vec2(width, height), Sense::click());
    ui.painter().rect_filled(area, 4.0, tokens.surface);
    if let Some(picture) = state.recent_pictures.iter().find(|picture| picture.path == path) {
        picture_ui(ui, area, picture);
    } else {
        let icon = ICON_FOLDER_OPEN.rich_text().size(28.0).color(tokens.text_weak);
        ui.put(area, Label::new(icon).selectable(false));
    }
    if response.hovered() || response.has_focus() {
        ui.painter().rect_stroke(area, 4.0, Stroke::new(1.5, tokens.accent), StrokeKind::Inside);
    }
    let label =
        ui.add_sized([width, NAME_HEIGHT], Label::new(name.as_ref()).truncate().sense(Sense::click()));
    let is_label_clicked = label.on_hover_text(path.display().to_string()).clicked();
    response.widget_info(|| {
        let has_picture = state.recent_pictures.iter().any(|picture| picture.path == path);
        let kind = if has_picture { "Open recent" } else { "Open recent without picture" };
        egui::WidgetInfo::labeled(egui::Role::Button, true, format!("{kind} {name}"))
    });
    if response.on_hover_text(path.display().to_string()).clicked() || is_label_clicked {
        commands.push(Command::File(FileCommand::Open(Opening::Path(path.to_path_buf()))));
    }
}

fn picture_ui(ui: &Ui, area: Rect, picture: &RecentPicture) {
    let id = Id::unique("recent picture").with(&picture.path);
    let of = Arc::as_ptr(&picture.image) as usize;
    let known = ui.data(|data| data.get_temp::<(usize, TextureHandle)>(id)).filter(|(known, _)| *known == of);
    let texture = known.map_or_else(
        || {
            let image = picture.image.clone();
            let texture = ui.ctx().load_texture("recent picture", image, egui::TextureOptions::LINEAR);
            ui.data_mut(|data| data.insert_temp(id, (of, texture.clone())));
            texture
        },
        |(_, texture)| texture,
    );
    let size = picture.image.size.map(|side| side as f32);
    let scale = (area.width() / size[0]).min(area.height() / size[1]);
    let shown = Rect::from_center_size(area.center(), vec2(size[0], size[1]) * scale);
    let whole = Rect::from_min_max(Pos2::ZERO, pos2(1.0, 1.0));
    ui.painter().image(texture.id(), shown, whole, Color32::WHITE);
}
