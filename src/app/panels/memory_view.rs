//! The memory that kept samples take, as a treemap by camera and length of span.

use egui::{Align2, Rect, RichText, Sense, Ui};
use egui_material_icons::icons::ICON_MEMORY;

use super::super::inspector::memory_map::{Block, squarified};
use super::super::state::State;
use super::super::text;
use super::super::theme::Tokens;
use super::super::views::colormap::{camera as camera_color, mix};
use super::empty_ui;
use super::report::stale_ui;

/// The view.
pub(super) fn memory_ui(ui: &mut Ui, state: &State) {
    let tokens = Tokens::in_ui(ui);
    let (Some(scene), Some(blocks)) = (&state.scene, &state.inspector.memory) else {
        let (title, text) = if state.scene.is_none() || state.has_capture() {
            ("No samples yet", "What the kept samples take is known once the whole capture is pruned.")
        } else {
            (
                "A store plays from disk",
                "Only the samples around the frame shown are in memory; what all of them would take is the figure at the top.",
            )
        };
        empty_ui(ui, ICON_MEMORY, title, text, |_| {});
        return;
    };
    let total: u64 = blocks.iter().map(|block| block.bytes).sum();
    let words = format!(
        "{} of samples in memory, by camera; strong: stored for many frames, pale: for one.",
        text::bytes(total)
    );
    ui.label(RichText::new(words).small().color(tokens.text_weak));
    stale_ui(ui, state);
    let (rect, response) = ui.allocate_exact_size(ui.available_size(), Sense::hover());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, "Memory map"));
    let painter = ui.painter_at(rect);
    let weights: Vec<f32> = blocks.iter().map(|block| block.bytes as f32).collect();
    let font = egui::TextStyle::Small.resolve(ui.style());
    let mut hovered: Option<String> = None;
    for (block, place) in blocks.iter().zip(squarified(&weights, rect)) {
        let place = place.shrink(1.0);
        let color =
            mix(tokens.surface, camera_color(block.camera), if block.frames > 1 { 0.9 } else { 0.45 });
        painter.rect_filled(place, 2.0, color);
        let name = scene.cameras.get(block.camera).map_or("", |camera| &camera.name);
        label(&painter, place, name, block, &font, readable_on(color));
        if response.hover_pos().is_some_and(|at| place.contains(at)) {
            let frames =
                if block.frames == 1 { "1 frame".to_owned() } else { format!("{} frames", block.frames) };
            hovered = Some(format!(
                "{name}, stored for {frames}: {} in {} samples, {}",
                text::bytes(block.bytes),
                text::count(block.samples),
                text::percent(block.bytes, total)
            ));
        }
    }
    if let Some(words) = hovered {
        response.on_hover_text_at_pointer(words);
    }
}

fn label(
    painter: &egui::Painter,
    place: Rect,
    name: &str,
    block: &Block,
    font: &egui::FontId,
    color: egui::Color32,
) {
    if place.width() < 54.0 || place.height() < 32.0 {
        return;
    }
    let inside = painter.with_clip_rect(place.shrink(2.0).intersect(painter.clip_rect()));
    let corner = place.min + egui::vec2(6.0, 4.0);
    inside.text(corner, Align2::LEFT_TOP, name, font.clone(), color);
    let figure = text::bytes(block.bytes);
    inside.text(corner + egui::vec2(0.0, 14.0), Align2::LEFT_TOP, figure, font.clone(), color);
}

/// Black or white, whichever stands out.
fn readable_on(color: egui::Color32) -> egui::Color32 {
    let luma = 0.299 * f32::from(color.r()) + 0.587 * f32::from(color.g()) + 0.114 * f32::from(color.b());
    if luma > 125.0 { egui::Color32::BLACK } else { egui::Color32::WHITE }
}
