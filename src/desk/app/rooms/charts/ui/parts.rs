//! What charts share: a legend that hides no point, the point under the pointer, and the button that measures.

use std::ops::RangeInclusive;

use egui::{Color32, Pos2, Sense, Shape, Stroke, TextWrapMode, Ui, vec2};
use egui_material_icons::MaterialIcon;
use egui_plot::{GridMark, MarkerShape, Plot, PlotPoint, PlotUi};

use crate::app::model::command::{ChartCommand, FileCommand};
use crate::app::model::purpose::Purpose;
use crate::app::model::{Command, Commands, State};
use crate::app::rooms::charts::state::axis::{Quantity, TICKS};
use crate::app::rooms::charts::state::{Charts, Study};
use crate::app::theme::Tokens;
use crate::app::widgets::empty_ui;
use overlook_engine::plural::counted;
use overlook_lab::chart::{Marker, Scale};

/// How near the pointer selects a point, points on the screen.
const NEAR: f32 = 12.0;

/// Room below a plot for a line of text.
pub(crate) const HINT: f32 = 20.0;

/// Width of a mark in the legend.
const MARK: f32 = 12.0;

/// How strong the color of an entry is whose series is left out.
const HIDDEN: f32 = 0.45;

/// What an entry of the legend shows.
#[derive(Clone, Copy)]
pub(crate) enum Mark {
    Points(MarkerShape),
    Line,
    Ring,
}

pub(crate) fn shape(marker: Marker) -> MarkerShape {
    match marker {
        Marker::Dot | Marker::Ring => MarkerShape::Circle,
        Marker::Square => MarkerShape::Square,
        Marker::Diamond => MarkerShape::Diamond,
        Marker::Up => MarkerShape::Up,
        Marker::Down => MarkerShape::Down,
        Marker::Cross => MarkerShape::Cross,
        Marker::Plus => MarkerShape::Plus,
        Marker::Star => MarkerShape::Asterisk,
    }
}

/// The legend, in rows above the plot: inside it, it would hide points. A click on an entry leaves its series out, or shows it again.
pub(crate) fn legend_ui<'a>(
    ui: &mut Ui,
    charts: &Charts,
    study: Study,
    entries: impl IntoIterator<Item = (Mark, Color32, &'a str)>,
    commands: &mut Commands,
) {
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing = vec2(5.0, 1.0);
        ui.spacing_mut().interact_size.y = 0.0;
        let tokens = *Tokens::in_ui(ui);
        for (mark, color, name) in entries {
            let is_shown = charts.shows(study, name);
            let dimmed = |color: Color32| if is_shown { color } else { color.gamma_multiply(HIDDEN) };
            let font = egui::TextStyle::Small.resolve(ui.style());
            let words = ui.painter().layout_no_wrap(name.to_owned(), font, dimmed(tokens.text));
            // A mark stays beside its name.
            let size = vec2(MARK + 4.0 + words.size().x + 8.0, words.size().y.max(MARK));
            let (rect, response) = ui.allocate_exact_size(size, Sense::click());
            if response.hovered() || response.has_focus() {
                ui.painter().rect_filled(rect.expand2(vec2(2.0, 0.0)), 3.0, tokens.raised);
            }
            let middle = rect.left_center() + vec2(MARK / 2.0, 0.0);
            ui.painter().add(mark_at(mark, middle, dimmed(color)));
            let at = rect.left_center() + vec2(MARK + 4.0, -0.5 * words.size().y);
            if !is_shown {
                let ends = at.x..=at.x + words.size().x;
                ui.painter().hline(ends, rect.center().y, Stroke::new(1.0, dimmed(tokens.text)));
            }
            ui.painter().galley(at, words, tokens.text);
            response.widget_info(|| egui::WidgetInfo::selected(egui::Role::CheckBox, true, is_shown, name));
            let help = if is_shown { "Click to leave it out." } else { "Click to show it again." };
            if response.on_hover_text(help).clicked() {
                commands.push(Command::Chart(ChartCommand::Toggle(study, name.to_owned())));
            }
        }
    });
}

/// Switches an axis between logarithms and values; gives the scale that was switched to.
pub(crate) fn scale_ui(ui: &mut Ui, name: &str, scale: Scale) -> Option<Scale> {
    let is_log = scale == Scale::Log;
    let button = egui::Button::selectable(is_log, "log").wrap_mode(TextWrapMode::Extend);
    let button = ui.add(button).accessible_name(format!("{name}: logarithmic"));
    let help = "Equal factors take equal room. Zero has no place on such an axis.";
    let other = if is_log { Scale::Linear } else { Scale::Log };
    button.on_hover_text(help).clicked().then_some(other)
}

fn mark_at(mark: Mark, at: Pos2, color: Color32) -> Shape {
    let polygon = |corners: &[(f32, f32)]| {
        let corners = corners.iter().map(|(x, y)| at + vec2(*x, *y) * 4.0).collect();
        Shape::convex_polygon(corners, color, Stroke::NONE)
    };
    let strokes = |ends: &[(f32, f32)]| {
        let stroke = |(x, y): &(f32, f32)| {
            let half = vec2(*x, *y) * 4.0;
            Shape::line_segment([at - half, at + half], Stroke::new(1.0, color))
        };
        Shape::Vec(ends.iter().map(stroke).collect())
    };
    match mark {
        Mark::Line => {
            let half = vec2(MARK / 2.0, 0.0);
            Shape::line_segment([at - half, at + half], Stroke::new(1.5, color))
        }
        Mark::Ring => Shape::circle_stroke(at, 5.0, Stroke::new(1.5, color)),
        Mark::Points(MarkerShape::Diamond) => polygon(&[(0.0, -1.0), (1.0, 0.0), (0.0, 1.0), (-1.0, 0.0)]),
        Mark::Points(MarkerShape::Square) => polygon(&[(-0.8, -0.8), (0.8, -0.8), (0.8, 0.8), (-0.8, 0.8)]),
        Mark::Points(MarkerShape::Up) => polygon(&[(0.0, -1.0), (0.9, 0.7), (-0.9, 0.7)]),
        Mark::Points(MarkerShape::Down) => polygon(&[(-0.9, -0.7), (0.9, -0.7), (0.0, 1.0)]),
        Mark::Points(MarkerShape::Cross) => strokes(&[(0.7, 0.7), (0.7, -0.7)]),
        Mark::Points(MarkerShape::Plus) => strokes(&[(1.0, 0.0), (0.0, 1.0)]),
        Mark::Points(MarkerShape::Asterisk) => strokes(&[(0.0, 1.0), (0.87, 0.5), (0.87, -0.5)]),
        Mark::Points(_) => Shape::circle_filled(at, 4.0, color),
    }
}

/// The point under the pointer, if one is near.
pub(crate) fn nearest(plot_ui: &PlotUi<'_>, places: impl Iterator<Item = [f64; 2]>) -> Option<usize> {
    let pointer = plot_ui.screen_from_plot(plot_ui.pointer_coordinate()?);
    places
        .enumerate()
        .map(|(index, [x, y])| (index, plot_ui.screen_from_plot(PlotPoint::new(x, y)).distance(pointer)))
        .filter(|(_, distance)| *distance < NEAR)
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .map(|(index, _)| index)
}

/// The button that asks what to measure, and the one that resumes a stopped run.
pub(crate) fn study_button(ui: &mut Ui, state: &State, study: Study, commands: &mut Commands) {
    let charts = &state.doc.charts;
    let ask = Command::Chart(ChartCommand::Ask(Some(study)));
    let measure = Command::Chart(ChartCommand::Study(study));
    let (name, help, ask) = match study {
        Study::Sweep => ("Run a sweep…", "Measures around the settings on the sliders.", ask),
        Study::Stress => ("Run a stress test…", "Disturbs the capture more and more.", ask),
        Study::Tuning => ("Tune settings…", "Starts from the settings on the sliders.", ask),
        Study::Ranking => (
            "Rank cameras",
            "Measures what would be lost without each, to find a needless one.",
            measure.clone(),
        ),
    };
    let mut buttons = vec![(name, help, ask)];
    if charts.goes_on(study, &state.settings) {
        buttons.insert(0, ("Resume", "Measures what is left, as long as was chosen.", measure));
    }
    for (name, help, command) in buttons {
        let button = egui::Button::new(name).wrap_mode(TextWrapMode::Extend);
        let button = ui.add_enabled(state.has_capture() && !charts.studying, button);
        let why_not = "A capture must be open, and nothing else being measured.";
        if button.on_hover_text(help).on_disabled_hover_text(why_not).clicked() {
            commands.push(command);
        }
    }
}

/// What copies and what saves a chart.
pub(crate) fn chart_commands(study: Study) -> [Command; 2] {
    [
        Command::Chart(ChartCommand::Copy(study)),
        Command::File(FileCommand::AskPath(Purpose::SaveChart(study))),
    ]
}

/// The text in place of a chart without points: the reason, or that the first is being measured.
pub(crate) fn no_points_ui(
    ui: &mut Ui,
    state: &State,
    study: Study,
    icon: MaterialIcon,
    text: &str,
    commands: &mut Commands,
) {
    if state.doc.charts.under_way() == Some(study) {
        let (title, text) = match study {
            Study::Sweep | Study::Stress => {
                ("Measuring the first setting…", "Points appear one by one, as they are measured.")
            }
            Study::Tuning => ("Trying settings…", "What was found appears once enough of them are measured."),
            Study::Ranking => {
                ("Measuring the first camera…", "Cameras appear one by one, as they are measured.")
            }
        };
        empty_ui(ui, icon, title, text, |ui| {
            ui.add(egui::Spinner::new().size(22.0));
        });
        return;
    }
    let title = match study {
        Study::Sweep => "No sweep yet",
        Study::Stress => "No stress test yet",
        Study::Tuning => "Not tuned yet",
        Study::Ranking => "Not ranked yet",
    };
    empty_ui(ui, icon, title, text, |ui| study_button(ui, state, study, commands));
}

/// The value at a coordinate of the plot; logarithmic axes have decimal logarithms as coordinates.
fn value_at(coordinate: f64, scale: Scale) -> f64 {
    match scale {
        Scale::Linear => coordinate,
        // Beyond, there are no numbers.
        Scale::Log => 10_f64.powf(coordinate.clamp(-300.0, 300.0)),
    }
}

/// The ticks between two coordinates of the plot, all of them equally strong.
fn ticks(low: f64, high: f64, scale: Scale) -> Vec<GridMark> {
    let step_size = (high - low) / TICKS as f64;
    if !(step_size.is_finite() && step_size > 0.0) {
        return Vec::new();
    }
    let values = scale.ticks(value_at(low, scale), value_at(high, scale), TICKS).into_iter();
    let coordinates = values.map(|value| if scale == Scale::Log { value.log10() } else { value });
    let inside = coordinates.filter(|coordinate| (low..=high).contains(coordinate));
    inside.map(|value| GridMark { value, step_size }).collect()
}

/// The longest part of an axis's name that fits into its length: without what is in brackets, and up to the first comma.
fn fitted(ui: &Ui, name: &str, length: f32) -> String {
    let before = |mark: &str| name.split(mark).next().unwrap_or_default();
    let fits = |name: &&str| {
        let font = egui::TextStyle::Body.resolve(ui.style());
        ui.painter().layout_no_wrap((*name).to_owned(), font, Color32::WHITE).size().x <= length
    };
    [name, before(" ("), before(", ")].into_iter().find(fits).unwrap_or_default().to_owned()
}

/// Room that the ticks and the name of an axis take.
const AXIS: f32 = 44.0;

/// An axis of a plot: its name, its scale, and the quantity along it where that has ticks of its own.
pub(crate) type PlotAxis = (String, Scale, Option<Quantity>);

/// A plot of a height, with named axes and round ticks.
pub(crate) fn plot<'a>(id: &'static str, ui: &Ui, [x, y]: [PlotAxis; 2], height: f32) -> Plot<'a> {
    let words = |(_, scale, quantity): &PlotAxis| {
        let (scale, quantity) = (*scale, *quantity);
        move |tick: GridMark, shown: &RangeInclusive<f64>| {
            let [tick, low, high] = [tick.value, *shown.start(), *shown.end()].map(|at| value_at(at, scale));
            match quantity {
                Some(quantity) => quantity.tick_words(tick, [low, high], scale),
                None => scale.label(tick, low, high, TICKS),
            }
        }
    };
    Plot::new(id)
        .height(height)
        .x_axis_label(fitted(ui, &x.0, ui.available_width() - AXIS))
        .y_axis_label(fitted(ui, &y.0, height - AXIS))
        .x_axis_formatter(words(&x))
        .y_axis_formatter(words(&y))
        .x_grid_spacer(move |grid| ticks(grid.bounds.0, grid.bounds.1, x.1))
        .y_grid_spacer(move |grid| ticks(grid.bounds.0, grid.bounds.1, y.1))
        .grid_color(Tokens::in_ui(ui).border)
        // Coordinates are logarithms on a logarithmic axis: what is pointed at has words of its own.
        .label_formatter(|_| None)
        .allow_scroll(false)
}

/// What is said of points that an axis cannot show; `None` without any.
pub(crate) fn left_out_words(count: usize) -> Option<String> {
    let words =
        || format!("{} left out: no place on these axes for zero or infinity", counted(count, "point"));
    (count > 0).then(words)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_of_a_logarithmic_axis_lie_at_the_logarithms_of_round_values() {
        let at = |low: f64, high: f64, scale| -> Vec<f64> {
            ticks(low, high, scale).into_iter().map(|tick| tick.value).collect()
        };
        assert_eq!(at(22.4, 28.1, Scale::Linear), [23.0, 24.0, 25.0, 26.0, 27.0, 28.0]);
        assert_eq!(at(-0.5, 4.5, Scale::Log), [0.0, 1.0, 2.0, 3.0, 4.0]);
        assert!(at(1.0, 1.0, Scale::Log).is_empty() && at(400.0, 500.0, Scale::Log).is_empty());
    }
}
