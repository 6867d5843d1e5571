//! The span map: for how many frames samples are stored, and when.

use egui::{Align2, Id, Painter, Pos2, Rect, RichText, Sense, Ui, pos2, vec2};
use egui_material_icons::icons::ICON_TIMELINE;

use crate::app::colormap::sequential;
use crate::app::model;
use crate::app::model::{Command, Commands, State};
use crate::app::rooms::report::model::Table;
use crate::app::rooms::timeline::model::TimeCommand;
use crate::app::theme::{Tokens, space};
use crate::app::widgets::{empty_ui, note, table_buttons_ui};
use overlook_engine::plural::counted;
use overlook_engine::preprocess::diagnostics::SpanReport;

/// Room for the names of the rows.
const NAMES: f32 = 128.0;

/// Height of a line of names, points.
const NAME: f32 = 14.0;

pub(crate) fn time_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    let tokens = Tokens::in_ui(ui);
    let frames = state.frame_count();
    let Some(report) = state.report().filter(|report| !report.spans.is_empty() && frames > 0) else {
        let text = "The spans of samples are known once the whole capture is pruned.";
        empty_ui(ui, ICON_TIMELINE, "No spans yet", text, |_| {});
        return;
    };
    ui.horizontal_wrapped(|ui| {
        let caption =
            "Samples by the span of frames they are stored for; lighter is more. Click to go to a frame.";
        note(ui, caption);
        table_buttons_ui(ui, Table::Spans, commands);
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
    let map = SpanMap { painter: ui.painter_at(rect), left, step, most };
    let mut hovered = None;
    for (nth, (length, spans)) in levels.iter().enumerate() {
        let top = rect.top() + nth as f32 * height;
        let row = Rect::from_min_max(pos2(rect.left(), top), pos2(rect.right(), top + height));
        // Of rows that are lower than type, some have no name to read; pointing at them gives it.
        let has_name = nth % (NAME / height).ceil() as usize == 0;
        map.name_ui(ui, row, response.id.with(length), *length, spans, has_name);
        hovered = map.spans_ui(row, spans, response.hover_pos()).or(hovered);
    }
    let now = left + (state.timeline.frame as f32 + 0.5) * step;
    map.painter.vline(now, rect.y_range(), egui::Stroke::new(2.0, tokens.text));
    if let Some(at) = response.interact_pointer_pos().filter(|at| at.x >= left) {
        let frame = (((at.x - left) / step) as usize).min(frames - 1);
        if frame != state.timeline.frame {
            commands.push(Command::Time(TimeCommand::Frame(frame)));
        }
    }
    if let Some(SpanReport { span, samples }) = hovered {
        let words =
            format!("Frames {} to {}: {}", span.start + 1, span.end, model::count_of(samples, "sample"));
        response.on_hover_text_at_pointer(words);
    }
}

/// Where the span map draws frames, and how bright counts are.
struct SpanMap {
    painter: Painter,
    /// Where the first frame begins, points.
    left: f32,
    /// Width of a frame, points.
    step: f32,
    /// The largest number of samples of a span.
    most: f32,
}

impl SpanMap {
    /// The length of a row's spans, and how many samples they hold.
    fn name_ui(&self, ui: &Ui, row: Rect, id: Id, length: usize, spans: &[&SpanReport], is_shown: bool) {
        let total: u64 = spans.iter().map(|span| span.samples).sum();
        let name = counted(length, "frame");
        let words = format!("Samples stored for {name}: {}", model::count(total));
        ui.interact(row, id, Sense::hover())
            .widget_info(|| egui::WidgetInfo::labeled(egui::Role::Label, true, &words));
        if !is_shown {
            return;
        }
        let text = format!("{name}  {}", model::count(total));
        let font = egui::TextStyle::Small.resolve(ui.style());
        let color = Tokens::in_ui(ui).text_weak;
        self.painter.text(row.left_center(), Align2::LEFT_CENTER, text, font, color);
    }

    /// The spans of a row; gives the one under the pointer.
    fn spans_ui(&self, row: Rect, spans: &[&SpanReport], pointer: Option<Pos2>) -> Option<SpanReport> {
        let mut hovered = None;
        for span in spans {
            let from = self.left + span.span.start as f32 * self.step;
            let gap = if self.step > 3.0 { 1.0 } else { 0.0 };
            let to = self.left + span.span.end as f32 * self.step - gap;
            let cell = Rect::from_min_max(pos2(from, row.top() + 1.0), pos2(to, row.bottom() - 1.0));
            // The square root makes small counts differ from none.
            self.painter.rect_filled(cell, 2.0, sequential((span.samples as f32 / self.most).sqrt()));
            if pointer.is_some_and(|at| cell.contains(at)) {
                hovered = Some(**span);
            }
        }
        hovered
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
