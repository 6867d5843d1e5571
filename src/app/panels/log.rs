//! What happened, in order; and what the window's own work takes.

use egui::{Align2, Rect, RichText, ScrollArea, Sense, Ui, pos2};
use egui_material_icons::icons::ICON_NOTES;

use super::super::command::Command;
use super::super::inspector::meter::{BUDGET_MS, Figures};
use super::super::state::{NoticeKind, State};
use super::super::theme::Tokens;
use super::empty_ui;

/// The log.
pub(super) fn log_ui(ui: &mut Ui, state: &State) {
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

/// The meter.
pub(super) fn meter_ui(ui: &mut Ui, state: &State, commands: &mut Vec<Command>) {
    let tokens = Tokens::in_ui(ui);
    let Some(times) = state.inspector.meter.times() else { return };
    ui.horizontal(|ui| {
        if ui.button("Start over").clicked() {
            commands.push(Command::ClearMeter);
        }
        ui.vertical(|ui| {
            ui.spacing_mut().item_spacing.y = 2.0;
            let line = |ui: &mut Ui, what: &str, figures: &Figures, help: &str| {
                let words = RichText::new(format!("{what}: {figures}")).small();
                ui.add(egui::Label::new(words).truncate()).on_hover_text(help);
            };
            line(
                ui,
                "Time passed",
                &times.wall,
                "Time that passes in logic() and ui() on the thread that draws; painting by the graphics driver comes after \
                 it.",
            );
            if let Some(cpu) = &times.cpu {
                line(
                    ui,
                    "Processor time",
                    cpu,
                    "The part of it in which a processor worked for this thread; in the rest others held the processors.",
                );
            }
        });
    });
    let size = ui.available_size();
    let (rect, response) = ui.allocate_exact_size(size, Sense::hover());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, "Frame times"));
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, 4.0, tokens.background);
    let scale = rect.height() / (BUDGET_MS * 1.5);
    let budget = rect.bottom() - BUDGET_MS * scale;
    painter.hline(rect.x_range(), budget, egui::Stroke::new(1.0, tokens.warning));
    let font = egui::TextStyle::Small.resolve(ui.style());
    painter.text(
        pos2(rect.left() + 4.0, budget - 2.0),
        Align2::LEFT_BOTTOM,
        format!("{BUDGET_MS} ms"),
        font,
        tokens.warning,
    );
    // The latest frames, as many as bars of two points have room for.
    let step = 2.0;
    let bars = (rect.width() / step) as usize;
    let first = times.wall.frames.saturating_sub(bars);
    for (index, ms) in state.inspector.meter.wall_ms().skip(first).enumerate() {
        let left = rect.left() + index as f32 * step;
        let top = (rect.bottom() - ms * scale).max(rect.top());
        let color = if ms > BUDGET_MS { tokens.error } else { tokens.accent };
        painter.rect_filled(
            Rect::from_min_max(pos2(left, top), pos2(left + step, rect.bottom())),
            0.0,
            color,
        );
    }
}
