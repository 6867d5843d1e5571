//! The histogram of the kept samples' values at the frame, with the range of colors as two lines that are dragged.

use egui::{Align2, Color32, FontId, Painter, Rect, Sense, Ui, pos2, vec2};

use crate::app::model;
use crate::app::model::{Command, Commands};
use crate::app::rooms::colors::model::ValueLook;
use crate::app::rooms::edits::model::EditCommand;
use crate::app::rooms::frame::model::{DockView, WindowCommand};
use crate::app::rooms::settings::model::{BARS, ThresholdAxis};
use crate::app::rooms::settings::ui::histogram::line;
use crate::app::theme::{Tokens, space};
use overlook_engine::capture::ValueChannel;
use overlook_engine::edits::Region;
use overlook_engine::render::output::ranked_value;
use overlook_engine::settings::ValueScale;

/// Height of the bars, and of the figures above them, points.
const HEIGHT: [f32; 2] = [48.0, 14.0];

/// Ranges by shares of the values.
const SHARES: [(&str, [f32; 2], &str); 2] = [
    ("Full", [0.0, 1.0], "From the lowest value at this frame to the highest."),
    ("2–98 %", [0.02, 0.98], "Without the lowest and the highest fiftieth of the values at this frame."),
];

/// The histogram of values, ascending; they are `None` while they are not counted.
pub(super) fn value_histogram_ui(
    ui: &mut Ui,
    values: Option<&[f32]>,
    channel: &ValueChannel,
    look: &mut ValueLook,
    commands: &mut Commands,
) {
    let tokens = Tokens::in_ui(ui);
    let values = values.unwrap_or_default();
    let range = look.range.unwrap_or(channel.range);
    let (area, response) = ui.allocate_exact_size(
        vec2(ui.available_width() - space::MEDIUM, HEIGHT[0] + HEIGHT[1]),
        Sense::click_and_drag(),
    );
    response.widget_info(|| {
        egui::WidgetInfo::labeled(egui::Role::Image, true, format!("Histogram of {}", channel.name))
    });
    let plot = Rect::from_min_max(area.min + vec2(0.0, HEIGHT[1]), area.max);
    let painter = ui.painter_at(area);
    painter.rect_filled(plot, 3.0, tokens.canvas);
    let axis = axis_of(values, channel, range, look.scale);
    let x = |value: f32| plot.left() + axis.position(f64::from(value)) * plot.width();
    if let Some([low, high]) = look.isolated {
        let band = Rect::from_x_y_ranges(x(low)..=x(high), plot.y_range());
        painter.rect_filled(band, 0.0, tokens.raised);
    }
    let colors = look.colors(channel);
    bars(&painter, plot, values, axis, |value| {
        colors.as_ref().map_or(tokens.text_weak, |colors| {
            let [r, g, b] = colors.color(value);
            Color32::from_rgb(r, g, b)
        })
    });
    let dragged = drag(ui, &response, range.map(x));
    for (end, value) in range.into_iter().enumerate() {
        line(&painter, plot, x(value), tokens.text, dragged.is_some_and(|(line, _)| line == end));
    }
    if let Some((end, pointer)) = dragged {
        let value = axis.value((pointer - plot.left()) / plot.width()) as f32;
        let mut moved = range;
        moved[end] = value;
        if moved[0] < moved[1] && moved != range {
            look.range = Some(moved);
        }
    }
    let within = values.partition_point(|value| *value <= range[1])
        - values.partition_point(|value| *value < range[0]).min(values.len());
    let words = if values.is_empty() {
        "Counted once the view rests and shows the value.".to_owned()
    } else {
        let share = model::percent(within as u64, values.len() as u64);
        format!("{} · {share} within", model::count_of(values.len() as u64, "kept sample"))
    };
    let font = FontId::proportional(10.5);
    painter.text(area.left_top(), Align2::LEFT_TOP, words, font, tokens.text_weak);
    response.on_hover_text("The values of the kept samples at this frame. Drag a line to change the range.");
    ui.horizontal(|ui| {
        for (name, shares, help) in SHARES {
            let button = ui.add_enabled(!values.is_empty(), egui::Button::new(name));
            let button = button.accessible_name(format!("Range: {name}")).on_hover_text(help);
            if button.clicked() {
                let [low, high] = shares.map(|share| ranked_value(values, share).unwrap_or_default());
                look.range = Some([low, high]);
            }
        }
        let button =
            ui.button("Select these").accessible_name(format!("Select this range of {}", channel.name));
        if button.on_hover_text("Selects the samples between the lines, to be edited.").clicked() {
            let [from, to] = range.map(f64::from);
            let region = Region::Value { name: channel.name.clone(), from, to };
            commands.push(Command::Edit(EditCommand::Select(region)));
            commands.push(Command::Window(WindowCommand::OpenView(DockView::Edits)));
        }
    });
}

/// A bar for each run of values, in its color.
fn bars(painter: &Painter, plot: Rect, values: &[f32], axis: ThresholdAxis, color: impl Fn(f32) -> Color32) {
    let counts = counts(values, axis);
    let most = counts.iter().copied().max().unwrap_or(0).max(1) as f32;
    for (index, count) in counts.iter().enumerate().filter(|(_, count)| **count > 0) {
        let ends = [index, index + 1].map(|bar| bar as f32 / BARS as f32);
        let middle = axis.exact_value(f32::midpoint(ends[0], ends[1])) as f32;
        // The logarithm lets rare values be seen beside frequent ones.
        let height = (*count as f32).ln_1p() / most.ln_1p() * (plot.height() - 3.0);
        let [left, right] = ends.map(|end| plot.left() + end * plot.width());
        let bar = Rect::from_min_max(pos2(left, plot.bottom() - height), pos2(right - 0.5, plot.bottom()));
        painter.rect_filled(bar, 0.0, color(middle));
    }
}

/// All values, the range of the channel and the one that is set lie on it.
fn axis_of(values: &[f32], channel: &ValueChannel, range: [f32; 2], scale: ValueScale) -> ThresholdAxis {
    let ends = values.first().into_iter().chain(values.last()).chain(&channel.range).chain(&range);
    let (min, max) = ends
        .filter(|end| end.is_finite())
        .fold((f32::INFINITY, f32::NEG_INFINITY), |(min, max), end| (min.min(*end), max.max(*end)));
    let (min, max) = if min < max { (min, max) } else { (min.min(0.0), min.max(0.0) + 1.0) };
    ThresholdAxis::over([min, max].map(f64::from), scale == ValueScale::Log && min > 0.0)
}

/// How many values lie in each bar.
fn counts(values: &[f32], axis: ThresholdAxis) -> Vec<usize> {
    let below = |bar: usize| {
        if bar == BARS {
            return values.len();
        }
        let end = axis.exact_value(bar as f32 / BARS as f32);
        values.partition_point(|value| f64::from(*value) < end)
    };
    (0..BARS).map(|bar| below(bar + 1) - below(bar)).collect()
}

/// The line that is dragged, of two by where they are, and where the pointer is.
fn drag(ui: &Ui, response: &egui::Response, lines: [f32; 2]) -> Option<(usize, f32)> {
    let pointer = response.interact_pointer_pos().filter(|_| response.is_pointer_button_down_on())?.x;
    let nearest = || {
        let [low, high] = lines.map(|line| (line - pointer).abs());
        // Where both are at one place, the pointer's side tells which is meant.
        usize::from(high < low || (high == low && pointer > lines[1]))
    };
    let id = response.id.with("line");
    let begins = ui.input(|input| input.pointer.primary_pressed());
    let line = ui.data(|data| data.get_temp(id)).filter(|_| !begins).unwrap_or_else(nearest);
    ui.data_mut(|data| data.insert_temp(id, line));
    Some((line, pointer))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_value_is_in_one_bar_on_linear_and_logarithmic_axes() {
        let channel = ValueChannel {
            name: "p".to_owned(),
            unit: String::new(),
            range: [1.0, 50.0],
            tolerance: 0.0,
            is_exact: true,
        };
        let values: Vec<f32> = (1..=100).map(|i| i as f32).collect();
        for (scale, in_first) in [(ValueScale::Linear, 2), (ValueScale::Log, 1)] {
            let axis = axis_of(&values, &channel, channel.range, scale);
            let counts = counts(&values, axis);
            assert_eq!((counts.iter().sum::<usize>(), counts[0]), (100, in_first));
        }
        let flat = ValueChannel { range: [3.0, 3.0], ..channel };
        let axis = axis_of(&[3.0], &flat, flat.range, ValueScale::Linear);
        assert_eq!(counts(&[3.0], axis).iter().sum::<usize>(), 1);
    }
}
