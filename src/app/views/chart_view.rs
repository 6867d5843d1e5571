//! Charts: accuracy against cost over many settings, and accuracy against the size of a disturbance.

use std::collections::BTreeMap;

use egui::{Color32, RichText, Ui};
use egui_material_icons::icons::{ICON_MONITORING, ICON_SCATTER_PLOT};
use egui_plot::{Legend, Line, MarkerShape, Plot, PlotPoint, PlotPoints, PlotUi, Points};

use super::super::command::Command;
use super::super::inspector::charts::{Quantity, Study, point_name, series_name, settings_alone};
use super::super::panels::{choice_ui, empty_ui};
use super::super::state::State;
use super::super::text;
use super::super::theme::{Tokens, space};
use super::{axis_marks, colormap};
use crate::evaluate::stress::StressPoint;
use crate::evaluate::sweep::{Point, Series};

/// A point this near to the pointer is meant, points on the screen.
const NEAR: f32 = 12.0;

/// Accuracy against cost.
pub(crate) fn tradeoff_ui(ui: &mut Ui, state: &State, commands: &mut Vec<Command>) {
    let charts = &state.inspector.charts;
    if charts.sweep.is_empty() {
        let text = "A sweep tries many settings and other methods on this capture, and draws what each costs and how close \
                    it comes to the truth. Points appear one by one; a click on one puts its settings on.";
        empty_ui(ui, ICON_SCATTER_PLOT, "No sweep yet", text, |ui| {
            study_button(ui, state, Study::Sweep, commands);
        });
        return;
    }
    ui.horizontal(|ui| {
        let quantities: Vec<_> =
            Quantity::ALL.iter().map(|(of, name, _)| (*of, (*name).to_owned(), String::new())).collect();
        for (index, caption, name) in [(0, "Along", "Along axis"), (1, "Up", "Up axis")] {
            ui.label(RichText::new(caption).color(Tokens::in_ui(ui).text_weak));
            if let Some(quantity) = choice_ui(ui, name, charts.axes[index], &quantities, 96.0) {
                let mut axes = charts.axes;
                axes[index] = quantity;
                commands.push(Command::ChartAxes(axes));
            }
        }
        study_button(ui, state, Study::Sweep, commands);
        let hint = format!("{} settings; click one to put it on", charts.sweep.len());
        let hint = RichText::new(hint).small().color(Tokens::in_ui(ui).text_weak);
        ui.add(egui::Label::new(hint).truncate());
    });
    let [along, up] = charts.axes;
    let tokens = *Tokens::in_ui(ui);
    let place = |point: &Point| [along.of(point), up.of(point)];
    let mut series = BTreeMap::<&str, (Series, Vec<[f64; 2]>)>::new();
    for point in &charts.sweep {
        let (_, places) = series.entry(point.series.name()).or_insert((point.series, Vec::new()));
        places.push(place(point));
    }
    let on_front = charts.sweep.iter().filter(|point| point.pareto && point.is_lossless());
    let mut front: Vec<[f64; 2]> = on_front.map(place).collect();
    front.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let current = charts.of(&state.settings).map(place);
    let plot = plot("tradeoff", along, up, &tokens);
    let shown = plot.show(ui, |plot_ui| {
        plot_ui.line(Line::new("best lossless for its size", front).color(tokens.text_weak).width(1.0));
        for (index, (series, places)) in series.into_values().enumerate() {
            let color = colormap::camera(index);
            plot_ui.points(
                Points::new(series_name(series), places).color(color).radius(4.0).shape(shape(index)),
            );
        }
        if let Some(at) = current {
            plot_ui.points(Points::new("on now", vec![at]).color(tokens.mark).radius(8.0).filled(false));
        }
        nearest(plot_ui, charts.sweep.iter().map(place))
    });
    shown
        .response
        .widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, "Speed and accuracy chart"));
    if let Some(point) = shown.inner.and_then(|index| charts.sweep.get(index)) {
        if let Some(settings) = settings_alone(point).filter(|_| shown.response.clicked()) {
            commands.push(Command::TakeSettings(Box::new(settings.clone())));
        }
        shown.response.on_hover_text_at_pointer(words(point));
    }
}

fn words(point: &Point) -> String {
    let advice =
        if settings_alone(point).is_some() { "" } else { "\nOnly for comparison: no settings give it" };
    format!(
        "{}\n{:.2} ± {:.2} dB, SSIM {:.3}, coverage {:.1} %\n{} in {} samples, {} ms a view{advice}",
        point_name(point),
        point.psnr_filled_db,
        point.psnr_filled_db_se,
        point.ssim,
        100.0 * point.coverage,
        text::bytes(point.bytes),
        text::count(point.samples),
        text::significant(point.milliseconds)
    )
}

fn shape(index: usize) -> MarkerShape {
    [MarkerShape::Circle, MarkerShape::Diamond, MarkerShape::Square, MarkerShape::Up, MarkerShape::Down]
        [index % 5]
}

fn plot<'a>(id: &'static str, along: Quantity, up: Quantity, tokens: &Tokens) -> Plot<'a> {
    let axis = |quantity: Quantity| {
        move |mark: egui_plot::GridMark, range: &std::ops::RangeInclusive<f64>| {
            let whole = |mark: egui_plot::GridMark| 10_f64.powf(mark.value) as u64;
            match quantity {
                Quantity::Bytes => text::bytes(whole(mark)),
                Quantity::Samples => text::count(whole(mark)),
                _ => axis_marks::label(mark, range, quantity.is_log()),
            }
        }
    };
    Plot::new(id)
        .legend(Legend::default())
        .x_axis_label(along.name())
        .y_axis_label(up.name())
        .x_axis_formatter(axis(along))
        .y_axis_formatter(axis(up))
        .x_grid_spacer(move |grid| axis_marks::marks(grid.bounds, along.is_log()))
        .y_grid_spacer(move |grid| axis_marks::marks(grid.bounds, up.is_log()))
        .grid_color(tokens.border)
        .allow_scroll(false)
        .set_margin_fraction(egui::vec2(0.06, 0.08))
}

/// The point under the pointer, if one is near.
fn nearest(plot_ui: &PlotUi<'_>, places: impl Iterator<Item = [f64; 2]>) -> Option<usize> {
    let pointer = plot_ui.screen_from_plot(plot_ui.pointer_coordinate()?);
    places
        .enumerate()
        .map(|(index, [x, y])| (index, plot_ui.screen_from_plot(PlotPoint::new(x, y)).distance(pointer)))
        .filter(|(_, distance)| *distance < NEAR)
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .map(|(index, _)| index)
}

fn study_button(ui: &mut Ui, state: &State, study: Study, commands: &mut Vec<Command>) {
    let (name, help) = match study {
        Study::Sweep => (
            "Run a sweep",
            "Measures around the settings on the sliders; takes minutes, and can be cancelled.",
        ),
        Study::Stress => {
            ("Run a stress test", "Disturbs the capture more and more; takes minutes, and can be cancelled.")
        }
    };
    let idle = !state.inspector.charts.studying;
    let button = ui.add_enabled(state.has_capture() && idle, egui::Button::new(name));
    if button
        .on_hover_text(help)
        .on_disabled_hover_text("A capture must be open, and nothing else being measured.")
        .clicked()
    {
        commands.push(Command::Study(study));
    }
}

/// Accuracy against the size of a disturbance.
pub(crate) fn stability_ui(ui: &mut Ui, state: &State, commands: &mut Vec<Command>) {
    let charts = &state.inspector.charts;
    let mut names: Vec<&str> = Vec::new();
    for point in &charts.stress {
        if !names.contains(&point.disturbance.as_str()) {
            names.push(&point.disturbance);
        }
    }
    let Some(first) = names.first() else {
        let text = "A stress test disturbs the capture more and more (noise, miscalibrated cameras, thin things) and draws \
                    when accuracy breaks: with these settings, without defenses, and as in the paper.";
        empty_ui(ui, ICON_MONITORING, "No stress test yet", text, |ui| {
            study_button(ui, state, Study::Stress, commands);
        });
        return;
    };
    let chosen =
        if names.contains(&charts.disturbance.as_str()) { charts.disturbance.as_str() } else { first };
    ui.horizontal(|ui| {
        let choices: Vec<_> =
            names.iter().enumerate().map(|(index, name)| (index, text::words(name), String::new())).collect();
        let now = names.iter().position(|name| *name == chosen).unwrap_or(0);
        if let Some(index) = choice_ui(ui, "Disturbance", now, &choices, 150.0) {
            commands.push(Command::Disturbance(names[index].to_owned()));
        }
        study_button(ui, state, Study::Stress, commands);
        ui.add_space(space::SMALL);
    });
    let here: Vec<&StressPoint> = charts.stress.iter().filter(|point| point.disturbance == chosen).collect();
    let mut methods = BTreeMap::<&str, Vec<[f64; 2]>>::new();
    for point in &here {
        methods.entry(&point.method).or_default().push([point.dial, point.point.psnr_filled_db]);
    }
    let unit = here.first().map_or("", |point| point.unit.as_str()).to_owned();
    let plot = Plot::new("stability")
        .legend(Legend::default())
        .x_axis_label(format!("{} ({unit})", text::words(chosen)))
        .y_axis_label("PSNR, dB")
        .x_grid_spacer(|grid| axis_marks::marks(grid.bounds, false))
        .y_grid_spacer(|grid| axis_marks::marks(grid.bounds, false))
        .grid_color(Tokens::in_ui(ui).border)
        .allow_scroll(false);
    let shown = plot.show(ui, |plot_ui| {
        for (index, (method, places)) in methods.into_iter().enumerate() {
            let color: Color32 = colormap::camera(index);
            plot_ui.line(Line::new(method, PlotPoints::from(places.clone())).color(color).width(2.0));
            plot_ui.points(Points::new(method, places).color(color).radius(3.5).shape(shape(index)));
        }
        nearest(plot_ui, here.iter().map(|point| [point.dial, point.point.psnr_filled_db]))
    });
    shown.response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, "Stability chart"));
    if let Some(point) = shown.inner.and_then(|index| here.get(index)) {
        let words = format!(
            "{} at {} {}: {:.2} dB, {:+.2} dB lost",
            point.method,
            text::significant(point.dial),
            point.unit,
            point.point.psnr_filled_db,
            point.loss_db
        );
        shown.response.on_hover_text_at_pointer(words);
    }
}
