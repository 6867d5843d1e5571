//! The span map: for how many frames samples are stored, and when.

use egui::{Align2, Rect, RichText, Sense, Ui, pos2, vec2};
use egui_material_icons::icons::ICON_TIMELINE;

use crate::app::colormap::sequential;
use crate::app::model::{self, Command, Commands, State};
use crate::app::theme::{Tokens, space};
use crate::app::widgets::{empty_ui, note};
use overlook_engine::plural::counted;
use overlook_engine::preprocess::diagnostics::SpanReport;

/// Room for the names of the rows.
const NAMES: f32 = 128.0;

pub(crate) fn time_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    let tokens = Tokens::in_ui(ui);
    let frames = state.frame_count();
    let Some(report) = state.report().filter(|report| !report.spans.is_empty() && frames > 0) else {
        let text = "For how long samples are stored is known once the whole capture is pruned.";
        empty_ui(ui, ICON_TIMELINE, "No spans yet", text, |_| {});
        return;
    };
    ui.horizontal_wrapped(|ui| {
        let caption =
            "Samples by the span of frames they are stored for; light is many. Click to go to a frame.";
        note(ui, caption);
        if state.is_stale() {
            ui.label(RichText::new("Out of date.").small().color(tokens.warning));
        }
    });
    let levels = levels(&report.spans);
    let most = report.spans.iter().map(|span| span.samples).max().unwrap_or(1).max(1) as f32;
    let area = ui.available_rect_before_wrap();
    let height = ((area.height() - space::SMALL) / levels.len() as f32).clamp(6.0, 30.0);
    let left = area.left() + NAMES;
    let step = (area.width() - NAMES) / frames as f32;
    let (rect, response) = ui.allocate_exact_size(
        vec2(area.width(), (height * levels.len() as f32).min(area.height())),
        Sense::click_and_drag(),
    );
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, "Span map"));
    let painter = ui.painter_at(rect);
    let font = egui::TextStyle::Small.resolve(ui.style());
    let mut hovered = None;
    for (row, (length, spans)) in levels.iter().enumerate() {
        let top = rect.top() + row as f32 * height;
        let total: u64 = spans.iter().map(|span| span.samples).sum();
        let name = counted(*length, "frame");
        let row_rect = Rect::from_min_max(pos2(rect.left(), top), pos2(rect.right(), top + height));
        let words = format!("Samples stored for {name}: {}", model::count(total));
        ui.interact(row_rect, response.id.with(length), Sense::hover())
            .widget_info(|| egui::WidgetInfo::labeled(egui::Role::Label, true, &words));
        let text = format!("{name}  {}", model::count(total));
        painter.text(
            pos2(rect.left(), top + height / 2.0),
            Align2::LEFT_CENTER,
            text,
            font.clone(),
            tokens.text_weak,
        );
        for span in spans {
            let from = left + span.span.start as f32 * step;
            let to = left + span.span.end as f32 * step - if step > 3.0 { 1.0 } else { 0.0 };
            let cell = Rect::from_min_max(pos2(from, top + 1.0), pos2(to, top + height - 1.0));
            // The square root makes small counts differ from none.
            painter.rect_filled(cell, 2.0, sequential((span.samples as f32 / most).sqrt()));
            if response.hover_pos().is_some_and(|at| cell.contains(at)) {
                hovered = Some(**span);
            }
        }
    }
    let now = left + (state.timeline.frame as f32 + 0.5) * step;
    painter.vline(now, rect.y_range(), egui::Stroke::new(2.0, tokens.text));
    if let Some(at) = response.interact_pointer_pos().filter(|at| at.x >= left) {
        let frame = (((at.x - left) / step) as usize).min(frames - 1);
        if frame != state.timeline.frame {
            commands.push(Command::Frame(frame));
        }
    }
    if let Some(SpanReport { span, samples }) = hovered {
        let words =
            format!("Frames {} to {}: {}", span.start + 1, span.end, model::count_of(samples, "sample"));
        response.on_hover_text_at_pointer(words);
    }
}

/// Spans by their length, longest first.
fn levels(spans: &[SpanReport]) -> Vec<(usize, Vec<&SpanReport>)> {
    let mut levels = std::collections::BTreeMap::<_, Vec<_>>::new();
    for span in spans {
        levels.entry(std::cmp::Reverse(span.span.len())).or_default().push(span);
    }
    levels.into_iter().map(|(length, spans)| (length.0, spans)).collect()
}
