//! What happened, in order.

use egui::{RichText, ScrollArea, Ui};
use egui_material_icons::icons::ICON_NOTES;

use crate::app::model::{NoticeKind, State};
use crate::app::theme::Tokens;
use crate::app::widgets::empty_ui;

pub(crate) fn log_ui(ui: &mut Ui, state: &State) {
    let tokens = Tokens::in_ui(ui);
    let log = &state.inspector.log;
    let Some(first) = log.front() else {
        empty_ui(
            ui,
            ICON_NOTES,
            "Nothing happened yet",
            "Work that is done and trouble that is met appear here.",
            |_| {},
        );
        return;
    };
    ScrollArea::vertical().auto_shrink(false).stick_to_bottom(true).show(ui, |ui| {
        ui.spacing_mut().item_spacing.y = 2.0;
        for line in log {
            ui.horizontal_top(|ui| {
                let seconds = line.at.duration_since(first.at).as_secs_f64();
                ui.label(RichText::new(format!("{seconds:8.2} s")).monospace().color(tokens.text_weak));
                let color = match line.kind {
                    NoticeKind::Error => tokens.error,
                    NoticeKind::Warning => tokens.warning,
                    NoticeKind::Done => tokens.text,
                };
                ui.add(egui::Label::new(RichText::new(&line.text).color(color)).wrap().selectable(true));
            });
        }
    });
}
