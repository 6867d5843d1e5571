//! The memory that kept samples take: one bar per camera.

use egui::{ScrollArea, Ui};
use egui_material_icons::icons::ICON_MEMORY;

use super::panel::{SHARE_BAR, SHARE_ROW, stale_ui, tall_share_ui};
use crate::app::model::{CameraMemory, Commands, State};
use crate::app::rooms::report::model::Table;
use crate::app::widgets::{empty_ui, note, table_buttons_ui};
use crate::app::{camera_cues, model};

pub(crate) fn memory_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    let (Some(scene), Some(cameras)) = (&state.doc.scene, &state.doc.memory) else {
        let (title, text) = if state.doc.scene.is_none() || state.has_capture() {
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
    let bytes = |camera: &CameraMemory| camera.lasting_bytes + camera.frame_bytes;
    let total: u64 = cameras.iter().map(bytes).sum();
    let words = format!("{} of samples in memory, by camera.", model::bytes(total));
    ui.horizontal_wrapped(|ui| {
        note(ui, words);
        table_buttons_ui(ui, Table::Memory, commands);
    });
    stale_ui(ui, state);
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        let mut order: Vec<usize> = (0..cameras.len().min(scene.cameras.len())).collect();
        order.sort_by_key(|index| std::cmp::Reverse(bytes(&cameras[*index])));
        let height = bar_height(ui.clip_rect().height(), order.len(), ui.spacing().item_spacing.y);
        for index in order {
            let (memory, camera) = (&cameras[index], &scene.cameras[index]);
            let figure = format!("{}  {}", model::bytes(bytes(memory)), model::percent(bytes(memory), total));
            let share = bytes(memory) as f32 / total.max(1) as f32;
            let color = camera_cues::color(index);
            tall_share_ui(ui, &camera.name, &figure, share, color, height).on_hover_text(format!(
                "{}. Stored for several frames: {}, for one: {}.",
                model::count_of(memory.samples, "sample"),
                model::bytes(memory.lasting_bytes),
                model::bytes(memory.frame_bytes)
            ));
        }
    });
}

/// Heights of a bar: as elsewhere, and at most, where few cameras have much room.
const HEIGHTS: std::ops::RangeInclusive<f32> = SHARE_BAR..=36.0;

/// Height of bars at which all rows fit into a height, if any.
fn bar_height(height: f32, rows: usize, gap: f32) -> f32 {
    let row = height / rows.max(1) as f32 - gap;
    (row - (SHARE_ROW - SHARE_BAR)).clamp(*HEIGHTS.start(), *HEIGHTS.end())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bars_grow_while_all_rows_fit() {
        assert_eq!(bar_height(200.0, 20, 4.0), SHARE_BAR);
        let grown = bar_height(400.0, 10, 4.0);
        assert!(grown > SHARE_BAR && 10.0 * (SHARE_ROW - SHARE_BAR + grown + 4.0) <= 400.0, "{grown}");
        assert_eq!(bar_height(2000.0, 3, 4.0), 36.0);
    }
}
