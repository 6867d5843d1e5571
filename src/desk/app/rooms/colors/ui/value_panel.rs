//! How scalar values become colors: channel, colormap, scale, range, and the part of it that is shown.

use egui::{DragValue, RichText, Ui};

use super::value_histogram::value_histogram_ui;
use crate::app::model;
use crate::app::model::{Command, Commands, State};
use crate::app::rooms::colors::model::{ValueLook, titled_value};
use crate::app::rooms::live::model::{ColorBy, ViewCommand};
use crate::app::theme::Tokens;
use crate::app::widgets::{choice_ui, note, segments_ui};
use overlook_engine::capture::ValueChannel;
use overlook_engine::settings::{Colormap, ValueScale};

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
    crate::app::rooms::live::ui::view_panel::heading_ui(ui, "Values");
    ui.horizontal(|ui| {
        let choices: Vec<_> = channels
            .iter()
            .enumerate()
            .map(|(nth, channel)| (nth, titled_value(channel), String::new()))
            .collect();
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
    let mut ends = [(low, "from"), (high, "to")].into_iter().map(|(end, word)| {
        let drag = DragValue::new(end).speed(speed).max_decimals(6);
        ui.add(drag).accessible_name(format!("{name} {word}")).changed()
    });
    let changed = [ends.next(), ends.next()];
    changed.contains(&Some(true))
}
