//! The question before a sweep or a stress test: what is measured, how finely, and for how long.

use std::time::Duration;

use egui::{Button, Checkbox, Frame, Grid, Id, Modal, RichText, ScrollArea, Ui};

use crate::app::model::{Command, Commands, State, sentence};
use crate::app::rooms::charts::model::{ChartCommand, StudyChoice, method_name};
use crate::app::rooms::settings::model::setting_names;
use crate::app::theme::{Tokens, space};
use crate::app::widgets::{segments_ui, weak};
use overlook_engine::plural::counted;
use overlook_lab::trial::Fineness;

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
        for (title, names) in &question.groups {
            group_ui(ui, title, names, &mut choice);
        }
        ui.add_space(space::MEDIUM);
        Grid::new("how to measure")
            .num_columns(2)
            .spacing([12.0, 8.0])
            .show(ui, |ui| how_ui(ui, &mut choice));
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

/// Names with check boxes, all of which are switched on or off together as well.
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
        return setting_names::name(name);
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

    #[test]
    fn what_is_measured_is_told_with_its_time_where_that_is_known() {
        assert_eq!(amount(768, None), "768 measurements, how long is unknown until the first is measured");
        assert_eq!(amount(1, Some(2.0)), "1 measurement, about 2 s");
        assert_eq!(amount(190, Some(600.0)), "190 measurements, about 10 min");
        assert_eq!(shown_name("ours"), "Your settings");
        assert_eq!(shown_name("pruning.depth_tolerance"), setting_names::name("pruning.depth_tolerance"));
    }
}
