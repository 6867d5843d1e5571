//! Every camera as a thumbnail: its kept share, and where it sees the selected pixel.

use egui::text::{LayoutJob, TextWrapping};
use egui::{Painter, Rect, RichText, ScrollArea, Sense, Stroke, StrokeKind, Ui, Vec2, pos2, vec2};
use egui_material_icons::icons::ICON_PHOTO_LIBRARY;

use crate::app::model::{Command, Commands, OpenScene, State};
use crate::app::rooms::cameras::ui::{overlay as cameras_overlay, overlays};
use crate::app::rooms::live::model::ViewCommand;
use crate::app::rooms::pixel::model::verdict_text as words;
use crate::app::rooms::source::model::SourceCommand;
use crate::app::theme::{Tokens, space};
use crate::app::widgets::{empty_ui, waiting};
use crate::app::{camera_cues, model, widgets};

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
    if !state.has_capture() {
        let text = "A store keeps only what was not redundant; there are no source pictures in it.";
        empty_ui(ui, ICON_PHOTO_LIBRARY, "No pictures to show", text, |_| {});
        return;
    }
    // Thumbnails keep the height of the view; where there is room for several rows they wrap, and are as large as lets all be seen.
    let area = ui.available_size();
    let order = order(state, scene);
    let height = if area.y > ROWS {
        let ratio = |index: &usize| {
            let (columns, rows) = scene.cameras[*index].intrinsics.size();
            columns as f32 / rows.max(1) as f32
        };
        let widest = order.iter().map(ratio).fold(0.1, f32::max);
        height_of_all(area - ui.spacing().item_spacing, order.len(), widest, ui.spacing().item_spacing)
    } else {
        (area.y - space::MEDIUM).max(60.0)
    };
    let widest = order.iter().map(|index| card_width(scene, *index, height)).fold(0.0, f32::max);
    let step = vec2(widest, height) + ui.spacing().item_spacing;
    let columns = if area.y > ROWS { ((area.x / step.x) as usize).max(1) } else { order.len() };
    let rows = order.len().div_ceil(columns.max(1));
    let whole = vec2(columns as f32 * step.x, rows as f32 * step.y);
    // Of hundreds of cameras only those in view are drawn.
    ScrollArea::both().auto_shrink(false).show_viewport(ui, |ui, viewport| {
        ui.set_min_size(whole);
        let origin = ui.min_rect().min;
        for (place, index) in order.iter().enumerate() {
            let corner = vec2((place % columns) as f32 * step.x, (place / columns) as f32 * step.y);
            let card = Rect::from_min_size(corner.to_pos2(), vec2(card_width(scene, *index, height), height));
            if viewport.intersects(card) {
                let card = card.translate(origin.to_vec2());
                ui.scope_builder(egui::UiBuilder::new().max_rect(card).id_salt(index), |ui| {
                    card_ui(ui, state, scene, *index, height, commands);
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
        let places = words::ordered(&explanation.evidence, explanation.winner);
        let rank = |camera: &usize| {
            let place = places.iter().position(|place| explanation.evidence[*place].camera == *camera);
            place.unwrap_or(usize::MAX)
        };
        order.sort_by_cached_key(rank);
    }
    order
}

fn card_width(scene: &OpenScene, index: usize, height: f32) -> f32 {
    let (columns, rows) = scene.cameras[index].intrinsics.size();
    ((height - CAPTION) * columns as f32 / rows.max(1) as f32).clamp(*WIDTHS.start(), *WIDTHS.end())
}

/// A camera's thumbnail with its caption, which answers clicks.
fn card_ui(
    ui: &mut Ui,
    state: &State,
    scene: &OpenScene,
    index: usize,
    height: f32,
    commands: &mut Commands,
) {
    let camera = &scene.cameras[index];
    let width = card_width(scene, index, height);
    let (rect, response) = ui.allocate_exact_size(vec2(width, height), Sense::click());
    let picture = Rect::from_min_size(rect.min, vec2(width, height - CAPTION));
    let painter = ui.painter_at(rect.expand(2.0));
    let selected = index == state.source.camera;
    thumbnail_ui(ui, &painter, picture, state, index);
    if selected || response.hovered() {
        let tokens = Tokens::in_ui(ui);
        let color = if selected { tokens.accent } else { tokens.border };
        painter.rect_stroke(picture, 4.0, Stroke::new(2.0, color), StrokeKind::Outside);
    }
    mark_probe(ui, &painter, picture, state, scene, index);
    let kept = kept_words(state, index);
    let sees = probed_words(state, index);
    caption_ui(ui, &painter, picture, index, [name_words(&camera.name, sees), kept.clone()]);
    response.widget_info(|| {
        egui::WidgetInfo::selected(egui::Role::Button, true, selected, format!("Camera {}", camera.name))
    });
    if response.clicked() {
        commands.push(Command::Source(SourceCommand::Camera(index)));
    }
    if response.double_clicked() {
        commands.push(Command::View(ViewCommand::JumpTo(index)));
    }
    cameras_overlay::menu(ui, &response, state, Some(index), commands);
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

/// Marks the selected point in a camera's thumbnail.
fn mark_probe(ui: &Ui, painter: &Painter, picture: Rect, state: &State, scene: &OpenScene, index: usize) {
    let probe = &state.doc.probe;
    let probed = probe.shown.as_ref();
    let Some((at, sees)) = probed.and_then(|probed| probed.in_camera(&scene.cameras, index)) else { return };
    let (columns, rows) = scene.cameras[index].intrinsics.size();
    let scale = vec2(picture.width() / columns as f32, picture.height() / rows as f32);
    let at = picture.min + at.to_vec2() * scale;
    overlays::mark(&painter.with_clip_rect(picture), at, sees, probe.pinned, Tokens::in_ui(ui));
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
    Some(words::sees(row).0)
}

fn name_words(name: &str, sees: Option<&str>) -> String {
    sees.map_or_else(|| name.to_owned(), |sees| format!("{name} · {sees}"))
}

fn kept_words(state: &State, index: usize) -> String {
    let inspected = state.doc.inspected.as_ref().filter(|_| state.inspection_here().is_some());
    let Some(inspected) = inspected else { return "…".to_owned() };
    let pixels = inspected.inspection.cameras[index].verdict.len() as u64;
    format!("{} kept", model::percent(inspected.kept[index], pixels))
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
