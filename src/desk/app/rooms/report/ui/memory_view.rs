//! The memory that kept samples take: one bar per camera.

use egui::{ScrollArea, Ui};
use egui_material_icons::icons::ICON_MEMORY;

use super::panel::{share_ui, stale_ui};
use crate::app::model::{CameraMemory, State};
use crate::app::widgets::{empty_ui, note};
use crate::app::{camera_cues, model};

pub(crate) fn memory_ui(ui: &mut Ui, state: &State) {
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
    note(ui, words);
    stale_ui(ui, state);
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        let mut order: Vec<usize> = (0..cameras.len().min(scene.cameras.len())).collect();
        order.sort_by_key(|index| std::cmp::Reverse(bytes(&cameras[*index])));
        for index in order {
            let (memory, camera) = (&cameras[index], &scene.cameras[index]);
            let figure = format!("{}  {}", model::bytes(bytes(memory)), model::percent(bytes(memory), total));
            let share = bytes(memory) as f32 / total.max(1) as f32;
            share_ui(ui, &camera.name, &figure, share, camera_cues::color(index)).on_hover_text(format!(
                "{}. Stored for several frames: {}, for one: {}.",
                model::count_of(memory.samples, "sample"),
                model::bytes(memory.lasting_bytes),
                model::bytes(memory.frame_bytes)
            ));
        }
    });
}
