//! Charts: accuracy against cost over many settings, and accuracy against the size of a disturbance.

use std::sync::LazyLock;

use egui::{Color32, RichText, Ui};
use egui_material_icons::icons::{ICON_MONITORING, ICON_SCATTER_PLOT};
use egui_plot::{Line, MarkerShape, Plot, PlotPoints, Points};

use super::parts::{HINT, Mark, legend_ui, nearest, no_points_ui, plot, shape, study_button, tick_label};
use crate::app::model::{Command, Commands, State};
use crate::app::rooms::charts::model::{
    ChartCommand, Quantity, Study, method_name, point_name, series_name, settings_alone,
};
use crate::app::rooms::report::model::Table;
use crate::app::rooms::settings::model::{SettingsCommand, setting_names};
use crate::app::theme::Tokens;
use crate::app::widgets::{choice_ui, one_line, table_ui, weak};
use crate::app::{camera_cues, model};
use overlook_engine::plural::{counted, either};
use overlook_engine::settings::{Kernel, Settings};
use overlook_lab::chart::{ChartSeries, Marker, Scale, series};
use overlook_lab::stress::{StressPlan, StressPoint, distinct};
use overlook_lab::sweep::{Point, Series};

/// Names of the line and of the ring in the chart.
const FRONT: &str = "Pareto front";
const CURRENT: &str = "current";

pub(crate) fn tradeoff_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    let charts = &state.doc.charts;
    if charts.sweep.is_empty() {
        let text = "A sweep tries many settings and other methods on this capture, and draws what each costs and how close \
                    it comes to the truth. Points appear one by one; a click on one applies its settings.";
        no_points_ui(ui, state, Study::Sweep, ICON_SCATTER_PLOT, text, commands);
        return;
    }
    axes_ui(ui, state, commands);
    let [along, up] = charts.axes();
    let tokens = *Tokens::in_ui(ui);
    let place = |point: &Point| [along.of(point), up.of(point)];
    let drawn = series(&charts.sweep, |point| (point.settings.render.kernel, point.series));
    let current = charts.of(&state.settings).map(place);
    let kernels = Kernel::ALL.iter().copied().filter(|kernel| drawn.iter().any(|of| of.kind.0 == *kernel));
    let kernels: Vec<_> = kernels.map(|kernel| (kernel_color(kernel), kernel_name(kernel))).collect();
    let colors =
        kernels.iter().map(|(color, name)| (Mark::Points(MarkerShape::Circle), *color, name.as_str()));
    let shapes = Series::ALL.into_iter().filter(|series| drawn.iter().any(|of| of.kind.1 == *series));
    let shapes =
        shapes.map(|series| (Mark::Points(shape(Marker::of(series))), tokens.text_weak, series_name(series)));
    let lines = [(Mark::Line, tokens.text_weak, FRONT), (Mark::Ring, tokens.mark, CURRENT)];
    let lines = &lines[..=usize::from(current.is_some())];
    legend_ui(ui, colors.chain(shapes).chain(lines.iter().copied()));
    let places: Vec<_> = charts.sweep.iter().map(place).collect();
    let height = (ui.available_height() - HINT).max(40.0);
    let plot = sweep_plot(ui, [along, up], &places).height(height);
    let shown = plot.show(ui, |plot_ui| {
        plot_ui.line(Line::new(FRONT, charts.front()).color(tokens.text_weak).width(1.0));
        for ChartSeries { kind: (kernel, series), points } in drawn {
            let name = format!("{}, {}", series_name(series), kernel_name(kernel));
            let points = Points::new(name, points.into_iter().map(place).collect::<Vec<_>>());
            let shape = shape(Marker::of(series));
            plot_ui.points(points.color(kernel_color(kernel)).radius(4.0).shape(shape));
        }
        if let Some(at) = current {
            plot_ui.points(Points::new(CURRENT, vec![at]).color(tokens.mark).radius(8.0).filled(false));
        }
        nearest(plot_ui, places.into_iter())
    });
    let count = charts.sweep.len();
    let hint = format!("{}; click {} to apply it", counted(count, "setting"), either(count, "it", "one"));
    one_line(ui, hint, tokens.text_weak);
    shown.response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, "Sweep chart"));
    if let Some(point) = shown.inner.and_then(|index| charts.sweep.get(index)) {
        if let Some(settings) = settings_alone(point).filter(|_| shown.response.clicked()) {
            commands.push(Command::Settings(SettingsCommand::Take(Box::new(settings.clone()))));
        }
        shown.response.on_hover_text_at_pointer(words(point, [along, up]));
    }
}

fn kernel_color(kernel: Kernel) -> Color32 {
    camera_cues::color(Kernel::ALL.iter().position(|of| *of == kernel).unwrap_or(0))
}

fn kernel_name(kernel: Kernel) -> String {
    setting_names::choice("render.kernel", kernel.name())
}

/// What is along and up, and the button that measures.
fn axes_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    let axes = state.doc.charts.axes();
    ui.horizontal_wrapped(|ui| {
        let quantities = Quantity::ALL.map(|(of, name, _)| (of, name, ""));
        for (index, caption, name) in [(0, "X axis:", "X axis"), (1, "Y axis:", "Y axis")] {
            weak(ui, caption);
            if let Some(quantity) = choice_ui(ui, name, axes[index], &quantities, 124.0) {
                let mut axes = axes;
                axes[index] = quantity;
                commands.push(Command::Chart(ChartCommand::Axes(axes)));
            }
        }
        study_button(ui, state, Study::Sweep, commands);
        table_ui(ui, Table::Sweep, commands);
    });
}

/// What a point is and costs, first by the axes that are shown.
fn words(point: &Point, axes: [Quantity; 2]) -> String {
    let mut lines = vec![setting_names::label(&point_name(point))];
    lines.extend(axes.map(|quantity| format!("{}: {}", quantity.name(), quantity.words(point))));
    lines.push(format!(
        "{:.2} dB with holes filled, {:.2} ± {:.2} dB behind the best, SSIM {:.3}, coverage {:.1} %",
        point.psnr_filled_db,
        point.behind_best_db,
        point.behind_best_db_se,
        point.ssim,
        100.0 * point.coverage
    ));
    lines.push(format!(
        "{} store of {}, {} in memory, {} ms a view",
        model::bytes(point.bytes),
        model::count_of(point.samples, "sample"),
        model::bytes(point.bytes_memory),
        model::significant(point.milliseconds)
    ));
    if settings_alone(point).is_none() {
        lines.push("Only for comparison: no settings give it".to_owned());
    }
    lines.join("\n")
}

fn sweep_plot<'a>(ui: &Ui, axes: [Quantity; 2], places: &[[f64; 2]]) -> Plot<'a> {
    let axis = |quantity: Quantity| {
        move |tick: egui_plot::GridMark, shown: &std::ops::RangeInclusive<f64>| {
            let whole = |tick: egui_plot::GridMark| 10_f64.powf(tick.value) as u64;
            match quantity {
                Quantity::Bytes => model::bytes(whole(tick)),
                Quantity::Samples => model::count(whole(tick)),
                _ => tick_label(tick, shown, quantity.scale()),
            }
        }
    };
    let mut plot = plot("tradeoff", ui, axes.map(Quantity::axis_name), axes.map(Quantity::scale))
        .x_axis_formatter(axis(axes[0]))
        .y_axis_formatter(axis(axes[1]))
        .set_margin_fraction(egui::vec2(0.06, 0.08));
    if let Some([low, high]) = around(places.iter().map(|place| place[0]), axes[0].scale()) {
        plot = plot.include_x(low).include_x(high);
    }
    if let Some([low, high]) = around(places.iter().map(|place| place[1]), axes[1].scale()) {
        plot = plot.include_y(low).include_y(high);
    }
    plot
}

/// What an axis shows at least, so that points at one value do not span decades.
fn around(values: impl Iterator<Item = f64>, scale: Scale) -> Option<[f64; 2]> {
    let [low, high] = values
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| [low.min(value), high.max(value)]);
    let middle = 0.5 * (low + high);
    // About half a decade, or a twentieth of the value.
    let span = if scale == Scale::Log { 0.5 } else { 0.05 * middle.abs().max(0.1) };
    (middle.is_finite() && high - low < span).then_some([middle - 0.5 * span, middle + 0.5 * span])
}

pub(crate) fn stability_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    let charts = &state.doc.charts;
    let names = distinct(charts.stress.iter().map(|point| point.disturbance.as_str()));
    let Some(first) = names.first() else {
        let text = "A stress test disturbs the capture more and more (noise, miscalibrated cameras, thin things) and draws \
                    when accuracy breaks: with these settings, without defenses, and as in the paper.";
        no_points_ui(ui, state, Study::Stress, ICON_MONITORING, text, commands);
        return;
    };
    let chosen =
        if names.contains(&charts.disturbance.as_str()) { charts.disturbance.as_str() } else { first };
    ui.horizontal_wrapped(|ui| {
        let choices: Vec<_> = names
            .iter()
            .enumerate()
            .map(|(index, name)| (index, model::words(name), String::new()))
            .collect();
        let now = names.iter().position(|name| *name == chosen).unwrap_or(0);
        if let Some(index) = choice_ui(ui, "Disturbance", now, &choices, 150.0) {
            commands.push(Command::Chart(ChartCommand::Disturbance(names[index].to_owned())));
        }
        study_button(ui, state, Study::Stress, commands);
        table_ui(ui, Table::StressTest, commands);
    });
    if let Some(words) = charts.stale_stress_note(&state.settings) {
        ui.label(RichText::new(words).color(Tokens::in_ui(ui).warning));
    }
    stability_plot_ui(ui, chosen, &charts.stress);
}

/// Shapes of the methods of a stress test, in turn.
const SHAPES: [MarkerShape; 5] =
    [MarkerShape::Circle, MarkerShape::Diamond, MarkerShape::Square, MarkerShape::Up, MarkerShape::Down];

/// The names of all methods, in the order of their looks.
static METHODS: LazyLock<Vec<String>> = LazyLock::new(|| {
    let settings = Settings::default();
    let plan = StressPlan::standard(&settings).with_rivals(&settings);
    plan.methods.into_iter().map(|method| method.name).collect()
});

fn stability_plot_ui(ui: &mut Ui, disturbance: &str, points: &[StressPoint]) {
    let place = |point: &StressPoint| [point.dial, point.point.psnr_filled_db];
    let is_here = |point: &&StressPoint| point.disturbance == disturbance;
    let here: Vec<&StressPoint> = points.iter().filter(is_here).collect();
    // The looks of a method are its own, whichever disturbance is shown and however much is measured.
    let methods = series(points, |point| point.method.as_str());
    let curves: Vec<_> = methods
        .into_iter()
        .map(|method| {
            let index = METHODS.iter().position(|name| name == method.kind).unwrap_or(METHODS.len());
            let places: Vec<_> = method.points.into_iter().filter(is_here).map(place).collect();
            (SHAPES[index % SHAPES.len()], camera_cues::color(index), method_name(method.kind), places)
        })
        .filter(|(.., places)| !places.is_empty())
        .collect();
    legend_ui(ui, curves.iter().map(|(shape, color, name, _)| (Mark::Points(*shape), *color, *name)));
    let unit = here.first().map_or("", |point| point.unit.as_str());
    let names = [format!("{} ({unit})", model::words(disturbance)), Quantity::Psnr.axis_name()];
    let plot = plot("stability", ui, names, [Scale::Linear; 2]);
    let shown = plot.show(ui, |plot_ui| {
        for (shape, color, name, places) in curves {
            plot_ui.line(Line::new(name, PlotPoints::from(places.clone())).color(color).width(2.0));
            plot_ui.points(Points::new(name, places).color(color).radius(3.5).shape(shape));
        }
        nearest(plot_ui, here.iter().copied().map(place))
    });
    shown.response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, "Stress test chart"));
    if let Some(point) = shown.inner.and_then(|index| here.get(index)) {
        let words = format!(
            "{} at {} {}: {:.2} dB, {:+.2} dB lost",
            model::sentence(method_name(&point.method)),
            model::significant(point.dial),
            point.unit,
            point.point.psnr_filled_db,
            point.loss_db
        );
        shown.response.on_hover_text_at_pointer(words);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use overlook_lab::trial::{Trial, TrialResult};

    #[test]
    fn an_axis_with_one_value_shows_half_a_decade_around_it() {
        assert_eq!(around([6.0, 6.0].into_iter(), Scale::Log), Some([5.75, 6.25]));
        assert_eq!(around([5.0, 6.0].into_iter(), Scale::Log), None);
        assert_eq!(around([20.0].into_iter(), Scale::Linear), Some([19.5, 20.5]));
        assert_eq!(around([f64::INFINITY].into_iter(), Scale::Linear), None);
        assert_eq!(around([].into_iter(), Scale::Log), None);
    }

    #[test]
    fn a_point_is_told_by_the_axes_that_are_shown_and_by_the_names_of_the_panel() {
        let trial = Trial::new("spans.color_tolerance = 4, gather", Settings::default());
        let mut point = Point::new(&trial, Series::Variation, &TrialResult::default());
        (point.seconds_preprocess, point.flip) = (2.5, 0.125);
        let told = words(&point, [Quantity::Seconds, Quantity::Flip]);
        assert!(told.starts_with("Static color range: 4, gather\n"), "{told}");
        assert!(told.contains("Preprocessing, s: 2.50\nFLIP: 0.125\n"), "{told}");
    }
}
