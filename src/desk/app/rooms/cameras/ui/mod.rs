//! How cameras are drawn: the view of all of them, and their list.

pub(crate) mod overlay;
mod ranking;

use egui::text::{LayoutJob, TextWrapping};
use egui::{
    Align, Layout, Painter, Rect, RichText, ScrollArea, Sense, Stroke, StrokeKind, Ui, UiBuilder, Vec2, pos2,
    vec2,
};
use egui_material_icons::icons::{ICON_PHOTO_LIBRARY, ICON_VISIBILITY, ICON_VISIBILITY_OFF};

use crate::app::camera_cues;
use crate::app::model::look::ShownCameras;
use crate::app::model::{self, Commands, OpenScene, State};
use crate::app::rooms::cameras::{answer_clicks, mark_probe};
use crate::app::rooms::pixel::{self, ordered};
use crate::app::theme::{Tokens, space};
use crate::app::widgets::{self, dot, empty_ui, icon_button, note, waiting};

/// Height of the two lines below a thumbnail.
const CAPTION: f32 = 34.0;

/// Height of the view from which on thumbnails stand in rows.
const ROWS: f32 = 330.0;

/// Heights of a thumbnail with its caption where they stand in rows.
const HEIGHTS: std::ops::RangeInclusive<f32> = 150.0..=520.0;

/// Widths of a thumbnail.
const WIDTHS: std::ops::RangeInclusive<f32> = 90.0..=800.0;

/// The largest height of thumbnails at which all of them fit into an area; the least where none does. `ratio` is the width of the
/// widest picture over its height.
fn height_of_all(area: Vec2, cameras: usize, ratio: f32, gap: Vec2) -> f32 {
    let height = |columns: usize| {
        let rows = cameras.div_ceil(columns) as f32;
        let width = area.x / columns as f32 - gap.x;
        (area.y / rows - gap.y).min(width / ratio + CAPTION)
    };
    let largest = (1..=cameras.max(1)).map(height).fold(0.0, f32::max);
    largest.floor().clamp(*HEIGHTS.start(), *HEIGHTS.end())
}

pub(crate) fn cameras_view_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    let Some(scene) = &state.doc.scene else { return };
    if !state.has_source() {
        let text = "This store does not say why its pixels went (store.verdicts); there are no source pictures in it. Open its capture to see \
                    them, and to rank the cameras.";
        empty_ui(ui, ICON_PHOTO_LIBRARY, "No pictures to show", text, |_| {});
        return;
    }
    if ranking::is_shown(state) {
        let area = ui.available_rect_before_wrap();
        let width = if area.width() < 2.0 * ranking::WIDTH { area.width() } else { ranking::WIDTH };
        let (left, right) = area.split_left_right_at_x(area.right() - width);
        ui.scope_builder(UiBuilder::new().max_rect(right).id_salt("ranking"), |ui| {
            ranking::ranking_ui(ui, state, scene, commands);
        });
        if left.width() > 0.0 {
            let left = left.with_max_x(left.right() - space::MEDIUM);
            let thumbnails = UiBuilder::new().max_rect(left).id_salt("thumbnails");
            ui.scope_builder(thumbnails, |ui| thumbnails_ui(ui, state, scene, commands));
        }
        return;
    }
    thumbnails_ui(ui, state, scene, commands);
}

fn thumbnails_ui(ui: &mut Ui, state: &State, scene: &OpenScene, commands: &mut Commands) {
    // Thumbnails keep the height of the view; where there is room for several rows they wrap, and are as large as lets all be seen.
    let area = ui.available_size();
    let order = order(state, scene);
    let height = if area.y > ROWS {
        let widest = order.iter().map(|index| ratio(scene, *index)).fold(0.1, f32::max);
        height_of_all(area - ui.spacing().item_spacing, order.len(), widest, ui.spacing().item_spacing)
    } else {
        (area.y - space::MEDIUM).max(60.0)
    };
    let width =
        |index: &usize| ((height - CAPTION) * ratio(scene, *index)).clamp(*WIDTHS.start(), *WIDTHS.end());
    let widest = order.iter().map(width).fold(0.0, f32::max);
    let step = vec2(widest, height) + ui.spacing().item_spacing;
    let columns = if area.y > ROWS { ((area.x / step.x) as usize).max(1) } else { order.len() };
    let rows = order.len().div_ceil(columns.max(1));
    let whole = vec2(columns as f32 * step.x, rows as f32 * step.y);
    // Only cameras in view are drawn: there may be hundreds.
    ScrollArea::both().auto_shrink(false).show_viewport(ui, |ui, viewport| {
        ui.set_min_size(whole);
        let origin = ui.min_rect().min;
        for (place, index) in order.iter().enumerate() {
            let corner = vec2((place % columns) as f32 * step.x, (place / columns) as f32 * step.y);
            let card = Rect::from_min_size(corner.to_pos2(), vec2(width(index), height));
            if viewport.intersects(card) {
                let card = card.translate(origin.to_vec2());
                ui.scope_builder(UiBuilder::new().max_rect(card).id_salt(index), |ui| {
                    card_ui(ui, state, scene, *index, commands);
                });
            }
        }
    });
}

/// Cameras in the order of the capture; while a pixel is selected, those that see its point come first.
fn order(state: &State, scene: &OpenScene) -> Vec<usize> {
    let mut order: Vec<usize> = (0..scene.cameras.len()).collect();
    let probed = state.doc.probe.shown.as_ref().filter(|_| state.doc.probe.pinned);
    if let Some(explanation) = probed.and_then(|probed| probed.explanation.as_ref()) {
        let places = ordered(&explanation.evidence, explanation.winner);
        let rank = |camera: &usize| {
            let place = places.iter().position(|place| explanation.evidence[*place].camera == *camera);
            place.unwrap_or(usize::MAX)
        };
        order.sort_by_cached_key(rank);
    }
    order
}

/// Width of a camera's picture over its height.
fn ratio(scene: &OpenScene, index: usize) -> f32 {
    let (columns, rows) = scene.cameras[index].intrinsics.size();
    columns as f32 / rows.max(1) as f32
}

/// A camera's thumbnail with its caption over all of its area; it answers clicks.
fn card_ui(ui: &mut Ui, state: &State, scene: &OpenScene, index: usize, commands: &mut Commands) {
    let camera = &scene.cameras[index];
    let (rect, response) = ui.allocate_exact_size(ui.max_rect().size(), Sense::click());
    let picture = rect.with_max_y(rect.bottom() - CAPTION);
    let painter = ui.painter_at(rect.expand(2.0));
    let selected = index == state.source.camera;
    thumbnail_ui(ui, &painter, picture, state, index);
    if selected || response.hovered() {
        let tokens = Tokens::in_ui(ui);
        let color = if selected { tokens.accent } else { tokens.border };
        painter.rect_stroke(picture, 4.0, Stroke::new(2.0, color), StrokeKind::Outside);
    }
    mark_probe(&painter.with_clip_rect(picture), picture, state, index);
    let kept = kept_words(state, index);
    let sees = probed_words(state, index);
    let name = sees.map_or_else(|| camera.name.clone(), |sees| format!("{} · {sees}", camera.name));
    caption_ui(ui, &painter, picture, index, [name, kept.clone()]);
    response.widget_info(|| {
        egui::WidgetInfo::selected(egui::Role::Button, true, selected, format!("Camera {}", camera.name))
    });
    answer_clicks(&response, index, commands);
    overlay::menu(ui, &response, state, Some(index), commands);
    response.on_hover_ui(|ui| {
        let (columns, rows) = camera.intrinsics.size();
        let found = sees.map_or_else(|| kept.clone(), |sees| format!("{kept}, {sees}"));
        ui.label(RichText::new(&camera.name).strong());
        ui.label(format!("{columns}×{rows}, {found}"));
        ui.label("Pruned pixels are dimmed. Click to see it large, double-click to view from this camera, right-click for more.");
    });
}

fn thumbnail_ui(ui: &Ui, painter: &Painter, picture: Rect, state: &State, index: usize) {
    painter.rect_filled(picture, 4.0, Tokens::in_ui(ui).canvas);
    if let Some(texture) = state.doc.thumbs.get(index) {
        widgets::picture(painter, texture.id(), picture);
    } else {
        waiting(ui, picture, 18.0);
    }
}

/// Two lines below a thumbnail, the first beside the camera's sign.
fn caption_ui(ui: &Ui, painter: &Painter, picture: Rect, index: usize, lines: [String; 2]) {
    let tokens = Tokens::in_ui(ui);
    let left = picture.left();
    let sign = Rect::from_center_size(pos2(left + 5.0, picture.bottom() + 11.0), vec2(9.0, 9.0));
    camera_cues::sign(painter, sign, index);
    let font = egui::TextStyle::Small.resolve(ui.style());
    let places = [(11.0, 14.0, tokens.text), (26.0, 0.0, tokens.text_weak)];
    for (text, (row, x, color)) in lines.into_iter().zip(places) {
        let mut job = LayoutJob::simple_singleline(text, font.clone(), color);
        job.wrap = TextWrapping::truncate_at_width(picture.width() - x);
        let galley = ui.fonts_mut(|fonts| fonts.layout_job(job));
        let at = pos2(left + x, picture.bottom() + row - galley.size().y / 2.0);
        painter.galley(at, galley, color);
    }
}

/// What a camera sees of the selected point; `None` while no point is explained.
fn probed_words(state: &State, index: usize) -> Option<&'static str> {
    let explanation = state.doc.probe.shown.as_ref()?.explanation.as_ref()?;
    let row = explanation.evidence.iter().find(|row| row.camera == index)?;
    Some(pixel::sees(row).0)
}

fn kept_words(state: &State, index: usize) -> String {
    let inspected = state.doc.inspected.as_ref().filter(|_| state.inspection_here().is_some());
    let Some(inspected) = inspected else { return "…".to_owned() };
    let pixels = inspected.inspection.cameras[index].verdict.len() as u64;
    format!("{} kept", model::percent(inspected.kept[index], pixels))
}

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

/// The cameras whose names contain a text, in capitals or not.
pub(crate) fn cameras_named(scene: &OpenScene, text: &str) -> Vec<usize> {
    let wanted = text.to_lowercase();
    let is_named = |index: &usize| scene.cameras[*index].name.to_lowercase().contains(&wanted);
    (0..scene.cameras.len()).filter(is_named).collect()
}

/// The list, with a field that filters it. A camera that is chosen elsewhere is scrolled to.
pub(crate) fn camera_list_ui(
    ui: &mut Ui,
    state: &State,
    cameras: &mut ShownCameras,
    commands: &mut Commands,
) {
    let Some(scene) = &state.doc.scene else { return };
    ui.horizontal(|ui| {
        for (name, off) in [("All on", 0..0), ("All off", 0..scene.cameras.len())] {
            if ui.button(name).clicked() {
                *cameras = ShownCameras { off: off.collect(), solo: None };
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
    let mut matching = cameras_named(scene, &look.filter);
    if is_new {
        look.scrolled_to = state.source.chosen_at;
        if !matching.contains(&chosen) {
            look.filter.clear();
            matching = cameras_named(scene, "");
        }
        look.shows_all |= matching.iter().skip(FEW).any(|index| *index == chosen);
    }
    let shown = if look.shows_all { matching.len() } else { matching.len().min(FEW) };
    ui.spacing_mut().item_spacing.y = 2.0;
    for index in &matching[..shown] {
        let (_, place) = ui.allocate_space(vec2(ui.available_width(), ROW));
        if is_new && *index == chosen {
            ui.scroll_to_rect(place, None);
        }
        // Only what is in view is drawn, of hundreds.
        if ui.is_rect_visible(place) {
            let line = UiBuilder::new().id_salt(("camera", *index)).max_rect(place);
            let mut line = ui.new_child(line.layout(Layout::left_to_right(Align::Center)));
            row_ui(&mut line, state, *index, &scene.cameras[*index].name, cameras, commands);
        }
    }
    if matching.len() > FEW {
        let name =
            if look.shows_all { "Show fewer".to_owned() } else { format!("Show all {}", matching.len()) };
        look.shows_all ^= ui.button(name).clicked();
    }
    ui.data_mut(|data| data.insert_temp(id, look));
}

fn row_ui(
    ui: &mut Ui,
    state: &State,
    index: usize,
    name: &str,
    cameras: &mut ShownCameras,
    commands: &mut Commands,
) {
    let is_on = !cameras.off.contains(&index);
    let (icon, verb) = if is_on { (ICON_VISIBILITY, "Hide") } else { (ICON_VISIBILITY_OFF, "Show") };
    let help = format!("{verb} the samples of {name} in the live view");
    if icon_button(ui, icon, &format!("{verb} {name}"), &help).clicked() {
        cameras.switch(index, !is_on);
    }
    let is_solo = cameras.solo == Some(index);
    let solo = ui.selectable_label(is_solo, "Solo").accessible_name(format!("Solo {name}"));
    if solo.on_hover_text("Show its samples alone").clicked() {
        cameras.solo = (!is_solo).then_some(index);
    }
    dot(ui, index);
    let chosen = overlay::is_chosen(state, index);
    let label = ui.selectable_label(chosen, name).accessible_name(format!("Camera {name}"));
    answer_clicks(&label.on_hover_text(overlay::clicks(state)), index, commands);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thumbnails_are_as_large_as_lets_all_of_them_be_seen() {
        let gap = vec2(8.0, 8.0);
        let height = |x: f32, y: f32, cameras: usize| height_of_all(vec2(x, y), cameras, 4.0 / 3.0, gap);
        for (x, y, cameras) in [(1200.0, 700.0, 5), (1200.0, 700.0, 3), (1900.0, 1000.0, 20)] {
            let height = height(x, y, cameras);
            let width = (height - CAPTION) * 4.0 / 3.0;
            let columns = (x / (width + gap.x)) as usize;
            let rows = cameras.div_ceil(columns);
            assert!(height > 150.0 && rows as f32 * (height + gap.y) <= y, "{height}: {columns}×{rows}");
        }
        assert_eq!(height(1200.0, 700.0, 300), 150.0, "many are scrolled");
        assert_eq!(height(4000.0, 3000.0, 1), 520.0);
    }
}
