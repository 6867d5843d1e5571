//! How both views show color: exposure, offset, tone curve, channel and background, beside the histogram of the picture.

use egui::{
    Align2, Color32, DragValue, FontId, Painter, Rect, Response, RichText, ScrollArea, Sense, Slider, Ui,
    pos2, vec2,
};

use crate::app::colormap::opaque;
use crate::app::model::command::{EditCommand, ViewCommand, WindowCommand};
use crate::app::model::look::{
    Background, Channel, Display, EXPOSURES, LEVELS, PictureHistogram, ToneCurve, ValueLook, titled_value,
};
use crate::app::model::picture::ColorBy;
use crate::app::model::window::DockView;
use crate::app::model::{self, Command, Commands, State};
use crate::app::rooms::settings::ui::{bars, line};
use crate::app::rooms::settings::{BARS, ThresholdAxis};
use crate::app::theme::{Tokens, space};
use crate::app::widgets::{choice_ui, fold_ui, heading_ui, note, segments_ui};
use overlook_engine::capture::ValueChannel;
use overlook_engine::edits::Region;
use overlook_engine::render::output::ranked_value;
use overlook_engine::settings::{Colormap, ValueScale};

/// Height of the histogram, points.
const HEIGHT: f32 = 72.0;

/// The panel.
pub(crate) fn color_panel_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    let mut display = state.display;
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        let live = state.doc.live_shown.as_ref().and_then(|shown| shown.picture.histogram.as_ref());
        let source = state.doc.source_shown.as_ref().and_then(|shown| shown.picture.histogram.as_ref());
        histogram_ui(ui, "Live view", live, "It is counted once the view rests and shows its picture.");
        values_ui(ui, state, &mut display.values, commands);
        if state.live.color_by != ColorBy::Value {
            brightness_ui(ui, live.or(source), &mut display);
        }
        background_ui(ui, &mut display);
        if state.has_capture() {
            let why_not = "It is counted where the source shows its picture.";
            fold_ui(ui, "Histogram of the source", "color", false, |ui| {
                histogram_ui(ui, "Source", source, why_not);
            });
        }
        fold_ui(ui, "Tone curve and channel", "color", false, |ui| curve_ui(ui, &mut display));
        ui.add_space(space::MEDIUM);
        let reset = ui.add_enabled(state.display != Display::default(), egui::Button::new("Reset colors"));
        if reset.clicked() {
            display = Display::default();
        }
        note(ui, "Both views, copied and saved pictures and videos are shown so. Comparisons, scores and EXR files keep the recorded colors.");
    });
    if display != state.display {
        commands.push(Command::Display(display));
    }
}

fn slider_ui(
    ui: &mut Ui,
    name: &str,
    help: &str,
    value: &mut f32,
    range: std::ops::RangeInclusive<f32>,
    suffix: &str,
) {
    ui.horizontal(|ui| {
        ui.add_sized([64.0, space::CONTROL], egui::Label::new(name).halign(egui::Align::Min));
        let slider = Slider::new(value, range).suffix(suffix).max_decimals(2);
        ui.add(slider).accessible_name(name).on_hover_text(help);
    });
}

fn brightness_ui(ui: &mut Ui, histogram: Option<&PictureHistogram>, display: &mut Display) {
    heading_ui(ui, "Brightness");
    slider_ui(ui, "Exposure", "Stops: 1 is twice as bright.", &mut display.exposure, EXPOSURES, " EV");
    slider_ui(ui, "Offset", "Added after the exposure.", &mut display.offset, -1.0..=1.0, "");
    ui.horizontal(|ui| {
        let auto = ui.add_enabled(histogram.is_some(), egui::Button::new("Fit exposure"));
        let help = "The exposure at which all but the brightest hundredth of the picture lies below white.";
        if auto.on_hover_text(help).clicked() {
            display.exposure = histogram.map_or(0.0, PictureHistogram::exposure);
        }
        ui.checkbox(&mut display.marks_clipped, "Mark clipped")
            .on_hover_text("Red: brighter than white. Blue: below black. Magenta: no finite number.");
    });
}

fn curve_ui(ui: &mut Ui, display: &mut Display) {
    heading_ui(ui, "Tone curve");
    if let Some(curve) = segments_ui(ui, "Tone curve", display.curve, ToneCurve::ALL) {
        display.curve = curve;
    }
    if display.curve == ToneCurve::Gamma {
        let help = "Displayed is linear to the power of 1/gamma.";
        slider_ui(ui, "Gamma", help, &mut display.gamma, 0.5..=4.0, "");
    }
    heading_ui(ui, "Channel");
    if let Some(channel) = segments_ui(ui, "Channel", display.channel, Channel::ALL) {
        display.channel = channel;
    }
}

fn background_ui(ui: &mut Ui, display: &mut Display) {
    heading_ui(ui, "Background");
    let solid = match display.background {
        Background::Solid(color) => color,
        _ => [24, 26, 30],
    };
    let choices = [
        (Background::Recorded, "Recorded", "The sky as the cameras saw it."),
        (
            Background::Transparent,
            "Transparent",
            "Nothing where pixels lie at infinity; saved pictures have alpha 0 there.",
        ),
        (Background::Solid(solid), "Color", "One color where pixels lie at infinity."),
    ];
    ui.horizontal(|ui| {
        if let Some(background) = segments_ui(ui, "Background", display.background, choices) {
            display.background = background;
        }
        if let Background::Solid(color) = &mut display.background {
            ui.color_edit_button_srgb(color).accessible_name("Background color");
        }
    });
}

fn histogram_ui(ui: &mut Ui, name: &str, histogram: Option<&PictureHistogram>, why_not: &str) {
    heading_ui(ui, name);
    let tokens = Tokens::in_ui(ui);
    let (area, _, painter) = room_ui(ui, HEIGHT, Sense::hover(), &format!("the {}", name.to_lowercase()));
    painter.rect_filled(area, 3.0, tokens.canvas);
    let Some(histogram) = histogram else {
        note(ui, why_not);
        return;
    };
    channel_bars(&painter, area, histogram);
    let of = |count: u32| model::percent(u64::from(count), u64::from(histogram.pixels));
    let mut facts = format!("at white {} · at black {}", of(histogram.at_white), of(histogram.at_black));
    if histogram.not_finite > 0 {
        facts = format!("{facts} · not finite {}", of(histogram.not_finite));
    }
    note(ui, facts);
}

/// Room for the histogram of something, which is named for screen readers.
fn room_ui(ui: &mut Ui, height: f32, sense: Sense, of: &str) -> (Rect, Response, Painter) {
    let size = vec2(ui.available_width() - space::MEDIUM, height);
    let (area, response) = ui.allocate_exact_size(size, sense);
    let name = format!("Histogram of {of}");
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, &name));
    (area, response, ui.painter_at(area))
}

/// Three channels over each other; heights are square roots, so that a few pixels show beside many.
fn channel_bars(painter: &Painter, area: Rect, histogram: &PictureHistogram) {
    let most = histogram.counts.iter().flatten().copied().max().unwrap_or(0).max(1) as f32;
    let width = area.width() / LEVELS as f32;
    let colors = [(230, 70, 60), (80, 190, 80), (70, 120, 240)];
    for (counts, (r, g, b)) in histogram.counts.iter().zip(colors) {
        let color = Color32::from_rgba_unmultiplied(r, g, b, 130);
        for (level, count) in counts.iter().enumerate().filter(|(_, count)| **count > 0) {
            let height = ((*count as f32 / most).sqrt() * area.height()).max(1.0);
            let left = area.left() + level as f32 * width;
            let bar =
                Rect::from_min_max(pos2(left, area.bottom() - height), pos2(left + width, area.bottom()));
            painter.rect_filled(bar, 0.0, color);
        }
    }
}

/// Height of the bars, and of the figures above them, points.
const VALUES_HEIGHT: [f32; 2] = [48.0, 14.0];

/// Ranges by shares of the values.
const SHARES: [(&str, [f32; 2], &str); 2] = [
    ("Full", [0.0, 1.0], "From the lowest value at this frame to the highest."),
    ("2–98 %", [0.02, 0.98], "Without the lowest and the highest fiftieth of the values at this frame."),
];

/// The histogram of values, ascending; they are `None` while they are not counted.
fn value_histogram_ui(
    ui: &mut Ui,
    values: Option<&[f32]>,
    channel: &ValueChannel,
    look: &mut ValueLook,
    commands: &mut Commands,
) {
    let tokens = Tokens::in_ui(ui);
    let values = values.unwrap_or_default();
    let range = look.range.unwrap_or(channel.range);
    let height = VALUES_HEIGHT.iter().sum();
    let (area, response, painter) = room_ui(ui, height, Sense::click_and_drag(), &channel.name);
    let plot = Rect::from_min_max(area.min + vec2(0.0, VALUES_HEIGHT[1]), area.max);
    painter.rect_filled(plot, 3.0, tokens.canvas);
    let axis = axis_of(values, channel, range, look.scale);
    let x = |value: f32| plot.left() + axis.position(f64::from(value)) * plot.width();
    if let Some([low, high]) = look.isolated {
        let band = Rect::from_x_y_ranges(x(low)..=x(high), plot.y_range());
        painter.rect_filled(band, 0.0, tokens.raised);
    }
    let colors = look.colors(channel);
    bars(&painter, plot, &counts(values, axis), |bar, _| {
        let middle = axis.exact_value((bar as f32 + 0.5) / BARS as f32) as f32;
        colors.as_ref().map_or(tokens.text_weak, |colors| opaque(colors.color(middle)))
    });
    let dragged = drag(ui, &response, range.map(x));
    for (end, value) in range.into_iter().enumerate() {
        line(&painter, plot, x(value), tokens.text, dragged.is_some_and(|(line, _)| line == end));
    }
    if let Some((end, pointer)) = dragged {
        let mut moved = range;
        moved[end] = axis.value((pointer - plot.left()) / plot.width()) as f32;
        if moved[0] < moved[1] && moved != range {
            look.range = Some(moved);
        }
    }
    let up_to_high = values.partition_point(|value| *value <= range[1]);
    let within = up_to_high.saturating_sub(values.partition_point(|value| *value < range[0]));
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

/// All values, the range of the channel and the one that is set lie on it.
fn axis_of(values: &[f32], channel: &ValueChannel, range: [f32; 2], scale: ValueScale) -> ThresholdAxis {
    let ends = values.first().into_iter().chain(values.last()).chain(&channel.range).chain(&range);
    let (min, max) = ends
        .filter(|end| end.is_finite())
        .fold((f32::INFINITY, f32::NEG_INFINITY), |(min, max), end| (min.min(*end), max.max(*end)));
    let (min, max) = if min < max { (min, max) } else { (min.min(0.0), min.max(0.0) + 1.0) };
    ThresholdAxis { min: min.into(), max: max.into(), log: scale == ValueScale::Log && min > 0.0 }
}

/// How many values lie in each bar.
fn counts(values: &[f32], axis: ThresholdAxis) -> Vec<[u32; 1]> {
    let below = |bar: usize| {
        if bar == BARS {
            return values.len();
        }
        let end = axis.exact_value(bar as f32 / BARS as f32);
        values.partition_point(|value| f64::from(*value) < end)
    };
    (0..BARS).map(|bar| [(below(bar + 1) - below(bar)) as u32]).collect()
}

/// The line that is dragged, of two by where they are, and where the pointer is.
fn drag(ui: &Ui, response: &Response, lines: [f32; 2]) -> Option<(usize, f32)> {
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

/// How a range runs over the colormap.
const SCALES: [(ValueScale, &str, &str); 3] = [
    (ValueScale::Linear, "Linear", "Evenly."),
    (ValueScale::Log, "Log", "Evenly in logarithms. Values that are not above 0 are gray."),
    (ValueScale::Symmetric, "Symmetric", "As far below zero as above it."),
];

/// The controls, where the scene has values.
pub(crate) fn values_ui(ui: &mut Ui, state: &State, look: &mut ValueLook, commands: &mut Commands) {
    let channels = state.value_channels();
    let Some((index, channel)) = look.channel_of(channels) else { return };
    heading_ui(ui, "Values");
    ui.horizontal(|ui| {
        let named = |(nth, channel): (usize, &ValueChannel)| (nth, titled_value(channel), String::new());
        let choices: Vec<_> = channels.iter().enumerate().map(named).collect();
        if let Some(chosen) = choice_ui(ui, "Value", index, &choices, 150.0) {
            *look = ValueLook { channel: chosen, map: look.map, scale: look.scale, ..ValueLook::default() };
        }
        let shown = state.live.color_by == ColorBy::Value;
        if !shown && ui.button("Show").on_hover_text("Color the live view by it.").clicked() {
            commands
                .push(Command::View(ViewCommand::look(&state.live, |live| live.color_by = ColorBy::Value)));
        }
    });
    let maps: Vec<_> =
        Colormap::ALL.iter().map(|map| (*map, model::sentence(map.name()), String::new())).collect();
    if let Some(map) = choice_ui(ui, "Colormap", look.map, &maps, 150.0) {
        look.map = map;
    }
    if let Some(scale) = segments_ui(ui, "Scale of the values", look.scale, SCALES) {
        look.scale = scale;
    }
    let counted = state.doc.values.as_ref().filter(|values| values.channel == index);
    let counted = counted.map(|values| &values.ascending[..]);
    if counted.is_some() || state.live.color_by == ColorBy::Value {
        value_histogram_ui(ui, counted, channel, look, commands);
    }
    let mut range = look.range.unwrap_or(channel.range);
    ui.horizontal(|ui| {
        if range_ui(ui, "Range", &mut range, channel) {
            look.range = Some(range);
        }
        let reset = ui.add_enabled(look.range.is_some(), egui::Button::new("Reset"));
        if reset.accessible_name("Reset the range").on_hover_text("The range of the channel.").clicked() {
            look.range = None;
        }
    });
    let mut isolates = look.isolated.is_some();
    let mut isolated = look.isolated.unwrap_or(range);
    ui.horizontal(|ui| {
        ui.checkbox(&mut isolates, "Only").on_hover_text("Values outside are gray.");
        ui.add_enabled_ui(isolates, |ui| range_ui(ui, "Shown values", &mut isolated, channel));
    });
    look.isolated = isolates.then_some(isolated);
    if let Err(why) = look.colors(channel) {
        ui.label(RichText::new(format!("Nothing is colored: {why}.")).color(Tokens::in_ui(ui).warning));
    }
    note(
        ui,
        "Each pixel shows the value of the sample that is nearest there; nothing is blended. What has none is gray.",
    );
}

/// Two numbers; true where one was changed.
fn range_ui(ui: &mut Ui, name: &str, range: &mut [f32; 2], channel: &ValueChannel) -> bool {
    let speed = f64::from((channel.range[1] - channel.range[0]).abs().max(1e-6)) / 200.0;
    let [low, high] = range;
    [(low, "from"), (high, "to")].into_iter().fold(false, |changed, (end, word)| {
        let drag = DragValue::new(end).speed(speed).max_decimals(6);
        ui.add(drag).accessible_name(format!("{name} {word}")).changed() || changed
    })
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
            assert_eq!((counts.iter().flatten().sum::<u32>(), counts[0]), (100, [in_first]));
        }
        let flat = ValueChannel { range: [3.0, 3.0], ..channel };
        let axis = axis_of(&[3.0], &flat, flat.range, ValueScale::Linear);
        assert_eq!(counts(&[3.0], axis).iter().flatten().sum::<u32>(), 1);
    }
}
