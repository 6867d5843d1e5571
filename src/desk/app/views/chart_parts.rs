//! What charts share: a legend that hides no point, the point under the pointer, and the button that measures.

use egui::{Color32, Pos2, Sense, Shape, Stroke, Ui, vec2};
use egui_material_icons::MaterialIcon;
use egui_plot::{MarkerShape, Plot, PlotPoint, PlotUi};

use crate::app::model::{self, Command, Commands, State, Study};
use crate::app::theme::Tokens;
use crate::app::widgets::empty_ui;

/// How near the pointer selects a point, points on the screen.
const NEAR: f32 = 12.0;

/// Room below a plot for a line of text.
pub(crate) const HINT: f32 = 20.0;

/// Width of a mark in the legend.
const MARK: f32 = 12.0;

/// What an entry of the legend shows.
#[derive(Clone, Copy)]
pub(crate) enum Mark {
    Points(MarkerShape),
    Line,
    Ring,
}

/// The shape of the series of an index.
pub(crate) fn shape(index: usize) -> MarkerShape {
    [MarkerShape::Circle, MarkerShape::Diamond, MarkerShape::Square, MarkerShape::Up, MarkerShape::Down]
        [index % 5]
}

/// The legend, in rows above the plot: inside it, it would hide points.
pub(crate) fn legend_ui<'a>(ui: &mut Ui, entries: impl IntoIterator<Item = (Mark, Color32, &'a str)>) {
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing = vec2(5.0, 1.0);
        ui.spacing_mut().interact_size.y = 0.0;
        for (mark, color, name) in entries {
            let font = egui::TextStyle::Small.resolve(ui.style());
            let text = Tokens::in_ui(ui).text;
            let words = ui.painter().layout_no_wrap(name.to_owned(), font, text);
            // A mark stays beside its name.
            let size = vec2(MARK + 4.0 + words.size().x + 8.0, words.size().y.max(MARK));
            let (rect, response) = ui.allocate_exact_size(size, Sense::hover());
            let middle = rect.left_center() + vec2(MARK / 2.0, 0.0);
            ui.painter().add(mark_at(mark, middle, color));
            let at = rect.left_center() + vec2(MARK + 4.0, -0.5 * words.size().y);
            ui.painter().galley(at, words, text);
            response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Label, true, name));
        }
    });
}

fn mark_at(mark: Mark, at: Pos2, color: Color32) -> Shape {
    let polygon = |corners: &[(f32, f32)]| {
        let corners = corners.iter().map(|(x, y)| at + vec2(*x, *y) * 4.0).collect();
        Shape::convex_polygon(corners, color, Stroke::NONE)
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

/// The button that measures, or goes on where it was stopped.
pub(crate) fn study_button(ui: &mut Ui, state: &State, study: Study, commands: &mut Commands) {
    let charts = &state.inspector.charts;
    let (name, help) = match study {
        _ if charts.goes_on(study, &state.settings) => {
            ("Resume", "Measures what is left; takes minutes, and can be canceled.")
        }
        Study::Sweep => (
            "Run a sweep",
            "Measures around the settings on the sliders; takes minutes, and can be canceled.",
        ),
        Study::Stress => {
            ("Run a stress test", "Disturbs the capture more and more; takes minutes, and can be canceled.")
        }
    };
    let button = ui.add_enabled(state.has_capture() && !charts.studying, egui::Button::new(name));
    if button
        .on_hover_text(help)
        .on_disabled_hover_text("A capture must be open, and nothing else being measured.")
        .clicked()
    {
        commands.push(Command::Study(study));
    }
}

/// What stands in place of a chart without points: why, or that the first is on its way.
pub(crate) fn no_points_ui(
    ui: &mut Ui,
    state: &State,
    study: Study,
    (icon, text): (MaterialIcon, &str),
    commands: &mut Commands,
) {
    if state.inspector.charts.under_way() == Some(study) {
        let text = "Points appear one by one, as they are measured.";
        empty_ui(ui, icon, "Measuring the first setting…", text, |ui| {
            ui.add(egui::Spinner::new().size(22.0));
        });
        return;
    }
    let title = match study {
        Study::Sweep => "No sweep yet",
        Study::Stress => "No stress test yet",
    };
    empty_ui(ui, icon, title, text, |ui| study_button(ui, state, study, commands));
}

/// A plot with named axes and round marks; `log` says which axes are logarithmic.
pub(crate) fn plot<'a>(id: &'static str, ui: &Ui, [x, y]: [String; 2], log: [bool; 2]) -> Plot<'a> {
    Plot::new(id)
        .x_axis_label(x)
        .y_axis_label(y)
        .x_grid_spacer(move |grid| model::marks(grid.bounds, log[0]))
        .y_grid_spacer(move |grid| model::marks(grid.bounds, log[1]))
        .grid_color(Tokens::in_ui(ui).border)
        .allow_scroll(false)
}
