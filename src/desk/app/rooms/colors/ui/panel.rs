//! How both views show color: exposure, offset, tone curve, channel and background, beside the histogram of the picture.

use egui::{Color32, Painter, Rect, ScrollArea, Sense, Slider, Ui, vec2};

use super::value_panel::values_ui;
use crate::app::model;
use crate::app::model::{Command, Commands, State};
use crate::app::rooms::colors::model::{
    Background, Channel, Display, EXPOSURES, LEVELS, PictureHistogram, ToneCurve,
};
use crate::app::theme::{Tokens, space};
use crate::app::widgets::{note, segments_ui};

/// Height of the histogram, points.
const HEIGHT: f32 = 72.0;

/// The panel.
pub(crate) fn color_panel_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    let mut display = state.display;
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        let live = state.doc.live_shown.as_ref().and_then(|shown| shown.picture.histogram.as_ref());
        let source = state.doc.source_shown.as_ref().and_then(|shown| shown.picture.histogram.as_ref());
        histogram_ui(ui, "Live view", live, "It is counted once the view rests and shows its picture.");
        if state.has_capture() {
            histogram_ui(ui, "Source", source, "It is counted where the source shows its picture.");
        }
        values_ui(ui, state, &mut display.values, commands);
        brightness_ui(ui, live.or(source), &mut display);
        curve_ui(ui, &mut display);
        background_ui(ui, &mut display);
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
    crate::app::rooms::live::ui::view_panel::heading_ui(ui, "Brightness");
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
    crate::app::rooms::live::ui::view_panel::heading_ui(ui, "Tone curve");
    if let Some(curve) = segments_ui(ui, "Tone curve", display.curve, ToneCurve::ALL) {
        display.curve = curve;
    }
    if display.curve == ToneCurve::Gamma {
        slider_ui(
            ui,
            "Gamma",
            "Displayed is linear to the power of 1/gamma.",
            &mut display.gamma,
            0.5..=4.0,
            "",
        );
    }
    crate::app::rooms::live::ui::view_panel::heading_ui(ui, "Channel");
    if let Some(channel) = segments_ui(ui, "Channel", display.channel, Channel::ALL) {
        display.channel = channel;
    }
}

fn background_ui(ui: &mut Ui, display: &mut Display) {
    crate::app::rooms::live::ui::view_panel::heading_ui(ui, "Background");
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
    crate::app::rooms::live::ui::view_panel::heading_ui(ui, name);
    let tokens = Tokens::in_ui(ui);
    let (area, response) =
        ui.allocate_exact_size(vec2(ui.available_width() - space::MEDIUM, HEIGHT), Sense::hover());
    response.widget_info(|| {
        egui::WidgetInfo::labeled(
            egui::Role::Image,
            true,
            format!("Histogram of the {}", name.to_lowercase()),
        )
    });
    let painter = ui.painter_at(area);
    painter.rect_filled(area, 3.0, tokens.canvas);
    let Some(histogram) = histogram else {
        note(ui, why_not);
        return;
    };
    bars(&painter, area, histogram);
    let of = |count: u32| model::percent(u64::from(count), u64::from(histogram.pixels));
    let mut facts = format!("at white {} · at black {}", of(histogram.at_white), of(histogram.at_black));
    if histogram.not_finite > 0 {
        facts = format!("{facts} · not finite {}", of(histogram.not_finite));
    }
    note(ui, facts);
}

/// Three channels over each other; heights are square roots, so that a few pixels show beside many.
fn bars(painter: &Painter, area: Rect, histogram: &PictureHistogram) {
    let most = histogram.counts.iter().flatten().copied().max().unwrap_or(0).max(1) as f32;
    let width = area.width() / LEVELS as f32;
    let colors = [(230, 70, 60), (80, 190, 80), (70, 120, 240)];
    for (counts, (r, g, b)) in histogram.counts.iter().zip(colors) {
        let color = Color32::from_rgba_unmultiplied(r, g, b, 130);
        for (level, count) in counts.iter().enumerate().filter(|(_, count)| **count > 0) {
            let height = ((*count as f32 / most).sqrt() * area.height()).max(1.0);
            let left = area.left() + level as f32 * width;
            let bar = Rect::from_min_max(
                egui::pos2(left, area.bottom() - height),
                egui::pos2(left + width, area.bottom()),
            );
            painter.rect_filled(bar, 0.0, color);
        }
    }
}
