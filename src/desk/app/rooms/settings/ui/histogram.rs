//! A threshold as a line that is dragged on the histogram of what it cuts.

use egui::{Align2, Color32, Label, Painter, Rect, RichText, Sense, Stroke, Ui, pos2, vec2};

use crate::app::model;
use crate::app::model::{Command, Commands, State};
use crate::app::rooms::settings::model::{BARS, SettingsCommand, ThresholdAxis, ThresholdHistogram};
use crate::app::theme::Tokens;
use crate::app::widgets::help_beside;
use overlook_engine::settings::Field;

const BARS_HEIGHT: f32 = 40.0;
/// Height of the figures above them.
const FIGURES: f32 = 14.0;

/// The histogram with its line; `name` names it for screen readers.
pub(crate) fn histogram_ui(
    ui: &mut Ui,
    field: &'static Field,
    name: &str,
    value: f64,
    state: &State,
    commands: &mut Commands,
) {
    let tokens = Tokens::in_ui(ui);
    let Some(axis) = ThresholdAxis::of(field) else { return };
    let width = ui.available_width() - crate::app::theme::space::MEDIUM;
    let (rect, response) =
        ui.allocate_exact_size(vec2(width, FIGURES + BARS_HEIGHT), Sense::click_and_drag());
    response
        .widget_info(|| egui::WidgetInfo::slider(ui.is_enabled(), value, format!("{name} on its histogram")));
    let plot = Rect::from_min_max(rect.min + vec2(0.0, FIGURES), rect.max);
    let painter = ui.painter_at(rect);
    painter.rect_filled(plot, 3.0, tokens.background);
    // The room is kept while nothing is counted, so that nothing below jumps; the line can be dragged already.
    let mut histograms = state.doc.histograms.iter();
    let histogram = histograms.find(|histogram| histogram.path == field.path && !histogram.is_empty());
    if let Some(histogram) = histogram {
        bars(&painter, plot, axis, histogram, tokens);
    }
    let enabled = ui.is_enabled();
    let x = plot.left() + axis.position(value) * plot.width();
    let grabbed = enabled && (response.hovered() || response.dragged());
    line(&painter, plot, x, if enabled { tokens.text } else { tokens.text_weak }, grabbed);
    let font = egui::FontId::proportional(10.5);
    let [left, right] = side_words(histogram, value);
    painter.text(rect.left_top(), Align2::LEFT_TOP, left, font.clone(), tokens.text_weak);
    painter.text(rect.right_top(), Align2::RIGHT_TOP, right, font.clone(), tokens.text_weak);
    let frame = histogram.and_then(|histogram| histogram.frame);
    if let Some(frame) = frame.filter(|frame| *frame != state.timeline.frame) {
        let words = RichText::new(at_frame(frame)).font(font).color(tokens.warning);
        let place = Rect::from_min_max(rect.min, pos2(rect.right(), plot.top()));
        ui.place(place, Label::new(words).selectable(false));
    }
    if enabled
        && response.is_pointer_button_down_on()
        && let Some(pointer) = response.interact_pointer_pos()
    {
        let dragged = axis.value((pointer.x - plot.left()) / plot.width());
        if (dragged - value).abs() > 1e-6 * value.abs() {
            commands
                .push(Command::Settings(SettingsCommand::Set { path: field.path, value: dragged.into() }));
        }
    }
    help_beside(&response, help_words(histogram, value));
}

/// A line that can be dragged, with its handle.
pub(crate) fn line(painter: &Painter, plot: Rect, x: f32, color: Color32, is_grabbed: bool) {
    painter.vline(x, plot.y_range(), Stroke::new(if is_grabbed { 3.0 } else { 2.0 }, color));
    let handle = [pos2(x - 5.0, plot.top()), pos2(x + 5.0, plot.top()), pos2(x, plot.top() + 7.0)];
    painter.add(egui::Shape::convex_polygon(handle.to_vec(), color, Stroke::NONE));
}

/// The shares within the line and beyond it.
fn side_words(histogram: Option<&ThresholdHistogram>, value: f64) -> [String; 2] {
    let (within, beyond) = histogram.map_or((0, 0), |histogram| histogram.sides(value));
    let share = |part: usize| model::percent(part as u64, (within + beyond) as u64);
    [format!("{} within", share(within)), format!("{} beyond", share(beyond))]
}

/// What is counted, and what the colors of the bars mean.
fn help_words(histogram: Option<&ThresholdHistogram>, value: f64) -> String {
    let Some(histogram) = histogram else {
        return "Not counted yet; the line can be dragged already.".to_owned();
    };
    let (within, beyond) = histogram.sides(value);
    format!(
        "{} {}{}: {within} within the line, {beyond} beyond. Blue passes all rules, orange does not{}. Drag the line.",
        model::count((within + beyond) as u64),
        histogram.of,
        histogram.frame.map_or_else(String::new, |frame| format!(", {}", at_frame(frame))),
        if histogram.noise.is_some() { "; measured noise explains the light band" } else { "" }
    )
}

fn at_frame(frame: usize) -> String {
    format!("at frame {}", frame + 1)
}

/// The bars, over the band that noise explains.
fn bars(painter: &Painter, plot: Rect, axis: ThresholdAxis, histogram: &ThresholdHistogram, tokens: &Tokens) {
    if let Some(noise) = histogram.noise {
        let right = plot.left() + axis.position(f64::from(noise)) * plot.width();
        let band = Rect::from_min_max(plot.min, pos2(right, plot.bottom()));
        painter.rect_filled(band, 3.0, tokens.raised);
        painter.vline(right, plot.y_range(), Stroke::new(1.0, tokens.text_weak));
    }
    // The logarithm lets rare values be seen beside frequent ones.
    let height = |count: u32| (count as f32).ln_1p();
    let most = height(histogram.bars.iter().map(|bar| bar[0] + bar[1]).max().unwrap_or(0).max(1));
    let step = plot.width() / BARS as f32;
    for (index, [passes, fails]) in histogram.bars.iter().enumerate() {
        let left = plot.left() + index as f32 * step;
        let total = height(passes + fails) / most * (plot.height() - 3.0);
        let part = total * *passes as f32 / (passes + fails).max(1) as f32;
        let bar = |from: f32, to: f32| {
            Rect::from_min_max(pos2(left, plot.bottom() - to), pos2(left + step - 0.5, plot.bottom() - from))
        };
        painter.rect_filled(bar(0.0, part), 0.0, tokens.static_over_time);
        painter.rect_filled(bar(part, total), 0.0, tokens.moving);
    }
}
