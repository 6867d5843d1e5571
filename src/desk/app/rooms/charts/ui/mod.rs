//! How charts are drawn, and the question of what is to be measured.

pub(crate) mod parts;
pub(crate) mod tuning;

use std::sync::LazyLock;
use std::time::Duration;

use egui::{Button, Checkbox, Color32, Frame, Grid, Id, Modal, RichText, ScrollArea, Ui};
use egui_material_icons::icons::{ICON_MONITORING, ICON_SCATTER_PLOT};
use egui_plot::{Line, MarkerShape, Plot, PlotPoints, Points};

use super::state::axis::{
    FRONT, Quantity, START, ShownAxis, coordinate, kernel_name, method_name, place, point_name, series_name,
    settings_alone,
};
use super::state::{Charts, Study, StudyChoice};
use crate::app::camera_cues;
use crate::app::model::command::{ChartCommand, SettingsCommand};
use crate::app::model::{self, Command, Commands, State, sentence};
use crate::app::theme::{Tokens, space};
use crate::app::widgets::{choice_ui, one_line, segments_ui, weak};
use overlook_engine::plural::{counted, either};
use overlook_engine::settings::{Kernel, Settings};
use overlook_lab::chart::{ChartSeries, Marker, Scale, series};
use overlook_lab::stress::{StressPlan, StressPoint, distinct};
use overlook_lab::sweep::{Point, Series};
use overlook_lab::trial::Fineness;
use parts::{
    HINT, Mark, left_out_words, legend_ui, nearest, no_points_ui, plot, scale_ui, shape, study_button,
};

/// Name of the ring in the chart.
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
    let axes = charts.axes;
    let tokens = *Tokens::in_ui(ui);
    let shows = |name: &str| charts.shows(Study::Sweep, name);
    let drawn = series(&charts.sweep, |point| (point.settings.render.kernel, point.series));
    let current = charts.of(&state.settings).and_then(|point| place(axes, point));
    let kernels = Kernel::ALL.iter().copied().filter(|kernel| drawn.iter().any(|of| of.kind.0 == *kernel));
    let kernels: Vec<_> = kernels.map(|kernel| (kernel_color(kernel), kernel_name(kernel))).collect();
    let colors =
        kernels.iter().map(|(color, name)| (Mark::Points(MarkerShape::Circle), *color, name.as_str()));
    let shapes = Series::ALL.into_iter().filter(|series| drawn.iter().any(|of| of.kind.1 == *series));
    let shapes = shapes.map(|series| {
        let (shape, color) = look_of_series(series, tokens.text_weak, &tokens);
        (Mark::Points(shape), color, series_name(series))
    });
    let lines = [(Mark::Line, tokens.text_weak, FRONT), (Mark::Ring, tokens.mark, CURRENT)];
    let lines = &lines[..=usize::from(current.is_some())];
    legend_ui(ui, charts, Study::Sweep, colors.chain(shapes).chain(lines.iter().copied()), commands);
    let is_shown = |point: &&Point| charts.shows_point(point);
    let shown: Vec<&Point> = charts.sweep.iter().filter(is_shown).collect();
    let placed: Vec<_> = shown.iter().filter_map(|point| Some((*point, place(axes, point)?))).collect();
    let places: Vec<_> = placed.iter().map(|(_, place)| *place).collect();
    let shows_time = axes.iter().any(|axis| axis.quantity.is_time());
    let is_doubtful = |point: &Point| shows_time && point.is_timed_under_load();
    let height = (ui.available_height() - HINT).max(40.0);
    let plot = sweep_plot(ui, axes, &places, height).show(ui, |plot_ui| {
        if shows(FRONT) {
            plot_ui.line(Line::new(FRONT, charts.front()).color(tokens.text_weak).width(1.0));
        }
        for ChartSeries { kind: (kernel, series), points } in drawn {
            let name = format!("{}, {}", series_name(series), kernel_name(kernel));
            let points = points.into_iter().filter(|point| is_shown(point));
            let (loaded, quiet): (Vec<&Point>, Vec<&Point>) = points.partition(|point| is_doubtful(point));
            let (shape, color) = look_of_series(series, kernel_color(kernel), &tokens);
            for (points, is_quiet) in [(quiet, true), (loaded, false)] {
                let places: Vec<_> = points.into_iter().filter_map(|point| place(axes, point)).collect();
                let points = Points::new(name.clone(), places).color(color).radius(4.0).shape(shape);
                plot_ui.points(points.filled(is_quiet));
            }
        }
        if let Some(at) = current.filter(|_| shows(CURRENT)) {
            plot_ui.points(Points::new(CURRENT, vec![at]).color(tokens.mark).radius(8.0).filled(false));
        }
        nearest(plot_ui, places.iter().copied())
    });
    let count = placed.len();
    let hint = format!("{}; click {} to apply it", counted(count, "setting"), either(count, "it", "one"));
    let left_out = left_out_words(shown.len() - count).map_or_else(String::new, |words| format!("; {words}"));
    let is_loaded = placed.iter().any(|(point, _)| is_doubtful(point));
    let hollow = if is_loaded { "; hollow: timed while other programs used the machine" } else { "" };
    one_line(ui, hint + &left_out + hollow, tokens.text_weak);
    plot.response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, "Sweep chart"));
    if let Some((point, _)) = plot.inner.and_then(|index| placed.get(index)) {
        if let Some(settings) = settings_alone(point).filter(|_| plot.response.clicked()) {
            commands.push(Command::Settings(SettingsCommand::Take(Box::new(settings.clone()))));
        }
        plot.response.on_hover_text_at_pointer(words(point, axes.map(|axis| axis.quantity)));
    }
}

/// Shape and color of a series. What the settings on the sliders gave has the color of text, which no kernel and no other method has.
fn look_of_series(series: Series, of_others: Color32, tokens: &Tokens) -> (MarkerShape, Color32) {
    let color = if series == Series::Reference { tokens.text } else { of_others };
    (shape(Marker::of(series)), color)
}

/// Colors like those of charts on paper, told apart from both grounds: yellow is not from the light one.
fn kernel_color(kernel: Kernel) -> Color32 {
    camera_cues::color(match kernel {
        Kernel::Point => 20,
        Kernel::Block => 1,
        Kernel::Surfel => 2,
        Kernel::Gather => 6,
    })
}

/// What is along and up, and the button that measures.
fn axes_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    let axes = state.doc.charts.axes;
    ui.horizontal_wrapped(|ui| {
        let quantities = Quantity::ALL.map(|(of, name, _)| (of, name, ""));
        for (index, caption, name) in [(0, "X axis:", "X axis"), (1, "Y axis:", "Y axis")] {
            weak(ui, caption);
            let ShownAxis { quantity, scale } = axes[index];
            let other = choice_ui(ui, name, quantity, &quantities, 124.0).map(ShownAxis::of);
            let switched = if quantity.has_decades() { scale_ui(ui, name, scale) } else { None };
            if let Some(axis) = other.or(switched.map(|scale| ShownAxis { quantity, scale })) {
                let mut axes = axes;
                axes[index] = axis;
                commands.push(Command::Chart(ChartCommand::Axes(axes)));
            }
        }
        study_button(ui, state, Study::Sweep, commands);
    });
}

/// What a point is and costs, first by the axes that are shown.
fn words(point: &Point, axes: [Quantity; 2]) -> String {
    let mut lines = vec![model::setting_names::label(&point_name(point))];
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
    if let Some(load) = point.load_of_others.filter(|_| point.is_timed_under_load()) {
        lines.push(format!("Timed while other programs used {:.0} % of the machine", 100.0 * load));
    }
    if settings_alone(point).is_none() {
        lines.push("Only for comparison: no settings give it".to_owned());
    }
    lines.join("\n")
}

fn sweep_plot<'a>(ui: &Ui, axes: [ShownAxis; 2], places: &[[f64; 2]], height: f32) -> Plot<'a> {
    let shown = axes.map(|ShownAxis { quantity, scale }| (quantity.axis_name(), scale, Some(quantity)));
    let mut plot = plot("tradeoff", ui, shown, height).set_margin_fraction(egui::vec2(0.06, 0.08));
    if let Some([low, high]) = around(places.iter().map(|place| place[0]), axes[0].scale) {
        plot = plot.include_x(low).include_x(high);
    }
    if let Some([low, high]) = around(places.iter().map(|place| place[1]), axes[1].scale) {
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
    let Some(first) = names.first().copied() else {
        let text = "A stress test disturbs the capture more and more (noise, miscalibrated cameras, thin things) and draws \
                    when accuracy breaks: with these settings, with noise handling off, and as in the paper.";
        no_points_ui(ui, state, Study::Stress, ICON_MONITORING, text, commands);
        return;
    };
    let chosen = names.iter().copied().find(|name| *name == charts.disturbance).unwrap_or(first);
    ui.horizontal_wrapped(|ui| {
        let choices: Vec<_> = names.iter().map(|name| (*name, model::words(name), String::new())).collect();
        if let Some(name) = choice_ui(ui, "Disturbance", chosen, &choices, 150.0) {
            commands.push(Command::Chart(ChartCommand::Disturbance(name.to_owned())));
        }
        if let Some(scale) = scale_ui(ui, "Disturbance axis", charts.dial_scale) {
            commands.push(Command::Chart(ChartCommand::DialScale(scale)));
        }
        study_button(ui, state, Study::Stress, commands);
    });
    if let Some(words) = charts.stale_note(Study::Stress, &state.settings) {
        ui.label(RichText::new(words).color(Tokens::in_ui(ui).warning));
    }
    stability_plot_ui(ui, chosen, charts, commands);
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

/// Shape, color and name of a method: its own, whichever disturbance is shown and however much is measured.
fn look<'a>(method: &'a str, tokens: &Tokens) -> (MarkerShape, Color32, &'a str) {
    if method_name(method) == START {
        let (shape, color) = look_of_series(Series::Reference, tokens.text, tokens);
        return (shape, color, START);
    }
    let index = METHODS.iter().position(|name| name == method).unwrap_or(METHODS.len());
    (SHAPES[index % SHAPES.len()], camera_cues::color(index), method_name(method))
}

fn stability_plot_ui(ui: &mut Ui, disturbance: &str, charts: &Charts, commands: &mut Commands) {
    let (points, scale) = (&charts.stress, charts.dial_scale);
    let place = |point: &StressPoint| {
        Some([coordinate(point.dial, scale)?, coordinate(point.point.psnr_filled_db, Scale::Linear)?])
    };
    let shows = |point: &StressPoint| charts.shows(Study::Stress, method_name(&point.method));
    let here: Vec<&StressPoint> = points.iter().filter(|point| point.disturbance == disturbance).collect();
    let shown: Vec<&StressPoint> = here.iter().copied().filter(|point| shows(point)).collect();
    let placed: Vec<_> = shown.iter().filter_map(|point| Some((*point, place(point)?))).collect();
    let methods = distinct(here.iter().map(|point| point.method.as_str()));
    let tokens = *Tokens::in_ui(ui);
    let looks = methods.iter().copied().map(|method| look(method, &tokens));
    let entries = looks.map(|(shape, color, name)| (Mark::Points(shape), color, name));
    legend_ui(ui, charts, Study::Stress, entries, commands);
    let unit = here.first().map_or("", |point| point.unit.as_str());
    let along = (format!("{} ({unit})", model::words(disturbance)), scale, None);
    let up = (Quantity::Psnr.axis_name(), Scale::Linear, Some(Quantity::Psnr));
    let left_out = left_out_words(shown.len() - placed.len());
    let room = left_out.as_ref().map_or(0.0, |_| HINT);
    let height = (ui.available_height() - room).max(40.0);
    let plot = plot("stability", ui, [along, up], height).show(ui, |plot_ui| {
        for method in &methods {
            let (shape, color, name) = look(method, &tokens);
            let of_method = placed.iter().filter(|(point, _)| point.method == *method);
            let places: Vec<_> = of_method.map(|(_, place)| *place).collect();
            plot_ui.line(Line::new(name, PlotPoints::from(places.clone())).color(color).width(2.0));
            plot_ui.points(Points::new(name, places).color(color).radius(3.5).shape(shape));
        }
        nearest(plot_ui, placed.iter().map(|(_, place)| *place))
    });
    if let Some(words) = left_out {
        one_line(ui, words, tokens.text_weak);
    }
    plot.response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, "Stress test chart"));
    if let Some((point, _)) = plot.inner.and_then(|index| placed.get(index)) {
        let words = format!(
            "{} at {} {}: {:.2} dB, {:+.2} dB lost",
            sentence(method_name(&point.method)),
            model::significant(point.dial),
            point.unit,
            point.point.psnr_filled_db,
            point.loss_db
        );
        plot.response.on_hover_text_at_pointer(words);
    }
}

/// Width of the dialog, points.
const WIDTH: f32 = 700.0;
/// Most height of the names in a group, points.
const GROUP: f32 = 168.0;
/// Names beside each other.
const COLUMNS: usize = 3;

/// How many values of each dial: name and help.
const FINENESS: [(Fineness, &str, &str); 3] = [
    (Fineness::Coarse, "Coarse", "The least and the largest value of each."),
    (Fineness::Medium, "Medium", "The ends and the middle of each."),
    (Fineness::Fine, "Fine", "All values of each: the ends first, then the middles."),
];

/// For how long, minutes; without end by 0.
const MINUTES: [(u64, &str, &str); 5] = [
    (1, "1 min", "Stops after a minute; Resume goes on."),
    (3, "3 min", "Stops after 3 minutes; Resume goes on."),
    (10, "10 min", "Stops after 10 minutes; Resume goes on."),
    (30, "30 min", "Stops after half an hour; Resume goes on."),
    (0, "Until done", "Measures everything that is chosen."),
];

/// The dialog, while it is open.
pub(crate) fn question_ui(ctx: &egui::Context, state: &State, commands: &mut Commands) {
    let charts = &state.doc.charts;
    let Some(question) = &charts.question else { return };
    let study = question.study;
    let mut choice = charts.choice(study).clone();
    let frame = Frame::popup(&ctx.style_of(ctx.theme())).inner_margin(space::LARGE);
    let modal = Modal::new(Id::unique("what to measure")).frame(frame).show(ctx, |ui| {
        ui.set_width(WIDTH.min(ctx.content_rect().width() - 2.0 * space::LARGE));
        ui.heading(study.name());
        let amounts = [
            (Some(StudyChoice::quick()), "Quick"),
            (Some(StudyChoice::default()), "Full"),
            (None, "Choose…"),
        ];
        let help = if study == Study::Tuning { TUNING_AMOUNTS } else { AMOUNTS };
        let id = ui.scope_id().with("chooses");
        let is_known = amounts.iter().any(|(known, _)| known.as_ref() == Some(&choice));
        let chooses = !is_known || ui.data(|data| data.get_temp(id).unwrap_or(false));
        let now = if chooses { 2 } else { usize::from(choice == StudyChoice::default()) };
        let segments = [0, 1, 2].map(|at| (at, amounts[at].1, help[at]));
        if let Some(at) = segments_ui(ui, "Amount", now, segments) {
            ui.data_mut(|data| data.insert_temp(id, at == 2));
            choice = amounts[at].0.clone().unwrap_or(choice.clone());
        }
        if chooses {
            for (title, names) in &question.groups {
                group_ui(ui, title, names, &mut choice);
            }
            ui.add_space(space::MEDIUM);
            let grid = Grid::new("how to measure").num_columns(2).spacing([12.0, 8.0]);
            grid.show(ui, |ui| how_ui(ui, &mut choice));
        }
        ui.add_space(space::SMALL);
        weak(ui, amount(question.measurements, charts.seconds_for(study, question.measurements)));
        ui.add_space(space::MEDIUM);
        ui.horizontal(|ui| {
            let words = RichText::new("Measure").color(Tokens::in_ui(ui).on_accent);
            let measure = Button::new(words).fill(Tokens::in_ui(ui).accent);
            let measure =
                ui.add_enabled(question.measurements > 0, measure).accessible_name("Start measuring");
            if measure.clicked() {
                commands.push(Command::Chart(ChartCommand::Study(study)));
            }
            if ui.button("Cancel").accessible_name("Measure nothing").clicked() {
                commands.push(Command::Chart(ChartCommand::Ask(None)));
            }
        });
    });
    if choice != *charts.choice(study) {
        commands.push(Command::Chart(ChartCommand::Choose(study, Box::new(choice))));
    }
    if modal.should_close() {
        commands.push(Command::Chart(ChartCommand::Ask(None)));
    }
}

/// What each amount of measuring is.
const AMOUNTS: [&str; 3] = [
    "The ends and the middle of everything, your settings and other methods first; stops after 3 minutes.",
    "All values of everything, until all is measured.",
    "What is measured, how finely and for how long.",
];

/// What each amount of tuning is.
const TUNING_AMOUNTS: [&str; 3] = [
    "The ends and the middle of each setting for 3 minutes; then what was found is combined.",
    "All values of each setting, however long that takes.",
    "Which settings are varied, how finely and for how long.",
];

fn how_ui(ui: &mut Ui, choice: &mut StudyChoice) {
    ui.label("Values");
    choice.fineness = segments_ui(ui, "Values", choice.fineness, FINENESS).unwrap_or(choice.fineness);
    ui.end_row();
    ui.label("Time");
    let minutes = choice.budget.map_or(0, |budget| budget.as_secs() / 60);
    if let Some(minutes) = segments_ui(ui, "Time", minutes, MINUTES) {
        choice.budget = (minutes > 0).then(|| Duration::from_mins(minutes));
    }
    ui.end_row();
}

/// Names with check boxes, and a way to switch all of them on or off.
fn group_ui(ui: &mut Ui, title: &str, names: &[String], choice: &mut StudyChoice) {
    ui.add_space(space::SMALL);
    ui.horizontal(|ui| {
        ui.label(RichText::new(title).strong());
        let lower = title.to_lowercase();
        if ui.small_button("All").accessible_name(format!("All {lower}")).clicked() {
            choice.left_out.retain(|name| !names.contains(name));
        }
        if ui.small_button("None").accessible_name(format!("No {lower}")).clicked() {
            choice.left_out.extend(names.iter().cloned());
        }
    });
    ScrollArea::vertical().id_salt(title).max_height(GROUP).show(ui, |ui| {
        let width = ui.available_width() / COLUMNS as f32 - 2.0 * space::MEDIUM;
        Grid::new(title).num_columns(COLUMNS).min_col_width(width).max_col_width(width).show(ui, |ui| {
            for row in names.chunks(COLUMNS) {
                for name in row {
                    let mut is_taken = !choice.left_out.contains(name);
                    let words = shown_name(name);
                    let label = RichText::new(&words).small();
                    ui.add(Checkbox::new(&mut is_taken, label)).on_hover_text(&words).accessible_name(words);
                    if is_taken {
                        choice.left_out.remove(name);
                    } else {
                        choice.left_out.insert(name.clone());
                    }
                }
                ui.end_row();
            }
        });
    });
}

/// What a setting, a method, a kernel or a disturbance is called in the window.
fn shown_name(name: &str) -> String {
    if name.contains('.') && !name.contains(' ') {
        return model::setting_names::name(name);
    }
    sentence(method_name(name))
}

/// How much is measured, and about how long that takes.
fn amount(measurements: usize, seconds: Option<f64>) -> String {
    let time = match seconds {
        _ if measurements == 0 => return "Nothing is left to measure of what is chosen.".to_owned(),
        None => "how long is unknown until the first is measured".to_owned(),
        Some(seconds) if seconds < 90.0 => format!("about {seconds:.0} s"),
        Some(seconds) => format!("about {:.0} min", seconds / 60.0),
    };
    format!("{}, {time}", counted(measurements, "measurement"))
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
    fn a_method_has_a_look_of_its_own_and_your_settings_have_one_in_all_charts() {
        for dark in [false, true] {
            let tokens = Tokens::of(dark);
            let looks: Vec<_> = METHODS.iter().map(|method| look(method, tokens)).collect();
            assert!(looks.len() > 3, "{looks:?}");
            for (nth, (shape, color, name)) in looks.iter().enumerate() {
                let before = &looks[..nth];
                assert!(!before.iter().any(|other| (other.0, other.1) == (*shape, *color)), "{name}");
            }
            let (shape, color, _) = look("ours", tokens);
            for of_kernel in Kernel::ALL.iter().copied().map(kernel_color) {
                assert_eq!(look_of_series(Series::Reference, of_kernel, tokens), (shape, color));
                assert_ne!(look_of_series(Series::Variation, of_kernel, tokens), (shape, color));
            }
        }
    }

    #[test]
    fn a_point_is_told_by_the_axes_that_are_shown_and_by_the_names_of_the_panel() {
        let trial = Trial::new("spans.color_tolerance = 4, gather", Settings::default());
        let mut point = Point::new(&trial, Series::Variation, &TrialResult::default());
        (point.seconds_preprocess, point.flip) = (2.5, 0.125);
        let told = words(&point, [Quantity::Seconds, Quantity::Flip]);
        assert!(told.starts_with("Static color range: 4, gather\n"), "{told}");
        assert!(told.contains("Reading and pruning, s: 2.50\nFLIP: 0.125\n"), "{told}");
    }

    #[test]
    fn what_is_measured_is_told_with_its_time_where_that_is_known() {
        assert_eq!(amount(768, None), "768 measurements, how long is unknown until the first is measured");
        assert_eq!(amount(1, Some(2.0)), "1 measurement, about 2 s");
        assert_eq!(amount(190, Some(600.0)), "190 measurements, about 10 min");
    }
}
