//! Charts: accuracy against cost over many settings, and accuracy against the size of a disturbance.

use std::collections::BTreeMap;

use egui::{RichText, Ui};
use egui_material_icons::icons::{ICON_MONITORING, ICON_SCATTER_PLOT};
use egui_plot::{Line, MarkerShape, Plot, PlotPoints, Points};

use super::chart_parts::{HINT, Mark, legend_ui, nearest, no_points_ui, plot, shape, study_button};
use crate::app::camera_cues;
use crate::app::model::{
    self, Command, Commands, Quantity, State, Study, Table, method_name, point_name, series_name,
    setting_names, settings_alone,
};
use crate::app::theme::Tokens;
use crate::app::widgets::{choice_ui, one_line, table_ui, weak};
use overlook_engine::plural::{counted, either};
use overlook_engine::settings::Kernel;
use overlook_lab::stress::StressPoint;
use overlook_lab::sweep::{Point, Series};

/// Names of the line and of the ring in the chart.
const FRONT: &str = "Pareto front";
const CURRENT: &str = "current";

pub(crate) fn tradeoff_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    let charts = &state.inspector.charts;
    if charts.sweep.is_empty() {
        let text = "A sweep tries many settings and other methods on this capture, and draws what each costs and how close \
                    it comes to the truth. Points appear one by one; a click on one applies its settings.";
        no_points_ui(ui, state, Study::Sweep, (ICON_SCATTER_PLOT, text), commands);
        return;
    }
    axes_ui(ui, state, commands);
    let [along, up] = charts.axes();
    let tokens = *Tokens::in_ui(ui);
    let place = |point: &Point| [along.of(point), up.of(point)];
    let groups = groups(&charts.sweep, place);
    let current = charts.of(&state.settings).map(place);
    let kernels: std::collections::BTreeSet<usize> = groups.keys().map(|(kernel, _)| *kernel).collect();
    let kernels: Vec<_> = kernels.into_iter().map(|kernel| (kernel, kernel_name(kernel))).collect();
    let colors = kernels.iter().map(|(kernel, name)| {
        (Mark::Points(MarkerShape::Circle), camera_cues::color(*kernel), name.as_str())
    });
    let shapes = shapes(&groups);
    let names =
        shapes.iter().map(|(series, shape)| (Mark::Points(*shape), tokens.text_weak, series_name(*series)));
    let names = colors.chain(names);
    let lines = [(Mark::Line, tokens.text_weak, FRONT), (Mark::Ring, tokens.mark, CURRENT)];
    let lines = &lines[..=usize::from(current.is_some())];
    legend_ui(ui, names.chain(lines.iter().copied()));
    let places: Vec<_> = charts.sweep.iter().map(place).collect();
    let height = (ui.available_height() - HINT).max(40.0);
    let plot = sweep_plot(ui, [along, up], &places).height(height);
    let shown = plot.show(ui, |plot_ui| {
        plot_ui.line(Line::new(FRONT, charts.front()).color(tokens.text_weak).width(1.0));
        for ((kernel, name), (series, places)) in groups {
            let shape = shapes
                .iter()
                .find(|(of, _)| of.name() == name)
                .map_or(MarkerShape::Circle, |(_, shape)| *shape);
            let points = Points::new(format!("{}, {}", series_name(series), kernel_name(kernel)), places);
            plot_ui.points(points.color(camera_cues::color(kernel)).radius(4.0).shape(shape));
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
            commands.push(Command::TakeSettings(Box::new(settings.clone())));
        }
        shown.response.on_hover_text_at_pointer(words(point, [along, up]));
    }
}

/// Points of the chart by kernel (its place among all) and name of the series.
type Groups = BTreeMap<(usize, &'static str), (Series, Vec<[f64; 2]>)>;

fn groups(points: &[Point], place: impl Fn(&Point) -> [f64; 2]) -> Groups {
    let mut groups = Groups::new();
    for point in points {
        let kernel = Kernel::ALL.iter().position(|of| *of == point.settings.render.kernel).unwrap_or(0);
        let key = (kernel, point.series.name());
        groups.entry(key).or_insert((point.series, Vec::new())).1.push(place(point));
    }
    groups
}

/// The shape of each series; colors are those of kernels.
fn shapes(groups: &Groups) -> Vec<(Series, MarkerShape)> {
    let mut names: Vec<(&str, Series)> =
        groups.iter().map(|((_, name), (series, _))| (*name, *series)).collect();
    names.sort_by_key(|(name, _)| *name);
    names.dedup_by_key(|(name, _)| *name);
    names.into_iter().enumerate().map(|(index, (_, series))| (series, shape(index))).collect()
}

fn kernel_name(kernel: usize) -> String {
    Kernel::ALL
        .get(kernel)
        .map_or_else(String::new, |kernel| setting_names::choice("render.kernel", kernel.name()))
}

/// What is along and up, and the button that measures.
fn axes_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    let axes = state.inspector.charts.axes();
    ui.horizontal_wrapped(|ui| {
        let quantities = Quantity::ALL.map(|(of, name, _)| (of, name, ""));
        for (index, caption, name) in [(0, "X axis:", "X axis"), (1, "Y axis:", "Y axis")] {
            weak(ui, caption);
            if let Some(quantity) = choice_ui(ui, name, axes[index], &quantities, 124.0) {
                let mut axes = axes;
                axes[index] = quantity;
                commands.push(Command::ChartAxes(axes));
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
        move |mark: egui_plot::GridMark, range: &std::ops::RangeInclusive<f64>| {
            let whole = |mark: egui_plot::GridMark| 10_f64.powf(mark.value) as u64;
            match quantity {
                Quantity::Bytes => model::bytes(whole(mark)),
                Quantity::Samples => model::count(whole(mark)),
                _ => model::label(mark, range, quantity.is_log()),
            }
        }
    };
    let mut plot = plot("tradeoff", ui, axes.map(Quantity::axis_name), axes.map(Quantity::is_log))
        .x_axis_formatter(axis(axes[0]))
        .y_axis_formatter(axis(axes[1]))
        .set_margin_fraction(egui::vec2(0.06, 0.08));
    if let Some([low, high]) = around(places.iter().map(|place| place[0]), axes[0].is_log()) {
        plot = plot.include_x(low).include_x(high);
    }
    if let Some([low, high]) = around(places.iter().map(|place| place[1]), axes[1].is_log()) {
        plot = plot.include_y(low).include_y(high);
    }
    plot
}

/// What an axis shows at least, so that points at one value do not span decades.
fn around(values: impl Iterator<Item = f64>, log: bool) -> Option<[f64; 2]> {
    let [low, high] = values
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| [low.min(value), high.max(value)]);
    let middle = 0.5 * (low + high);
    // About half a decade, or a twentieth of the value.
    let span = if log { 0.5 } else { 0.05 * middle.abs().max(0.1) };
    (middle.is_finite() && high - low < span).then_some([middle - 0.5 * span, middle + 0.5 * span])
}

pub(crate) fn stability_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
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
        no_points_ui(ui, state, Study::Stress, (ICON_MONITORING, text), commands);
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
            commands.push(Command::Disturbance(names[index].to_owned()));
        }
        study_button(ui, state, Study::Stress, commands);
        table_ui(ui, Table::StressTest, commands);
    });
    if let Some(words) = charts.stale_stress_note(&state.settings) {
        ui.label(RichText::new(words).color(Tokens::in_ui(ui).warning));
    }
    let here: Vec<&StressPoint> = charts.stress.iter().filter(|point| point.disturbance == chosen).collect();
    stability_plot_ui(ui, chosen, &here);
}

fn stability_plot_ui(ui: &mut Ui, disturbance: &str, here: &[&StressPoint]) {
    let mut methods = BTreeMap::<&str, Vec<[f64; 2]>>::new();
    for point in here {
        methods.entry(&point.method).or_default().push([point.dial, point.point.psnr_filled_db]);
    }
    let methods = methods.into_iter().enumerate();
    let curves: Vec<_> = methods
        .map(|(index, (method, places))| {
            (shape(index), camera_cues::color(index), method_name(method), places)
        })
        .collect();
    legend_ui(ui, curves.iter().map(|(shape, color, name, _)| (Mark::Points(*shape), *color, *name)));
    let unit = here.first().map_or("", |point| point.unit.as_str());
    let names = [format!("{} ({unit})", model::words(disturbance)), Quantity::Psnr.axis_name()];
    let plot = plot("stability", ui, names, [false; 2]);
    let shown = plot.show(ui, |plot_ui| {
        for (shape, color, name, places) in curves {
            plot_ui.line(Line::new(name, PlotPoints::from(places.clone())).color(color).width(2.0));
            plot_ui.points(Points::new(name, places).color(color).radius(3.5).shape(shape));
        }
        nearest(plot_ui, here.iter().map(|point| [point.dial, point.point.psnr_filled_db]))
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
    use overlook_engine::settings::Settings;
    use overlook_lab::trial::{Trial, TrialResult};

    #[test]
    fn an_axis_with_one_value_shows_half_a_decade_around_it() {
        assert_eq!(around([6.0, 6.0].into_iter(), true), Some([5.75, 6.25]));
        assert_eq!(around([5.0, 6.0].into_iter(), true), None);
        assert_eq!(around([20.0].into_iter(), false), Some([19.5, 20.5]));
        assert_eq!(around([f64::INFINITY].into_iter(), false), None);
        assert_eq!(around([].into_iter(), true), None);
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
