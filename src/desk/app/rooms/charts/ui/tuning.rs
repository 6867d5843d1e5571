//! The settings that tuning found: what each of them changes, and what puts them on.

use egui::{Button, Grid, RichText, ScrollArea, Ui};
use egui_material_icons::icons::ICON_TUNE;

use super::parts::{no_points_ui, study_button};
use crate::app::model::command::SettingsCommand;
use crate::app::model::setting_names::SettingPairs;
use crate::app::model::{self, Command, Commands, State};
use crate::app::rooms::charts::state::Study;
use crate::app::theme::{Tokens, space};
use crate::app::widgets::{note, weak};
use overlook_engine::plural::counted;
use overlook_engine::settings::Settings;
use overlook_lab::sweep::Point;
use overlook_lab::tune::Tuned;

/// The columns of the table: name and help.
const COLUMNS: [(&str, &str); 5] = [
    ("Setting", ""),
    ("Change", ""),
    ("Samples", "Samples more (+) or fewer (−) than with the settings that tuning began with."),
    ("Store", "Bytes of the store more (+) or fewer (−)."),
    (
        "Accuracy",
        "PSNR gained (+) or lost (−) at the viewpoints whose true pictures are known, holes filled.",
    ),
];

pub(crate) fn tuning_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    let charts = &state.doc.charts;
    let before = charts.made_with(Study::Tuning);
    let Some((tuned, before)) = charts.tuned.as_deref().zip(before) else {
        let text = "Tuning varies one setting after the other and combines what saves bytes. It ends in the smallest settings \
                    that surely give up next to nothing of the best accuracy, and changes nothing before you use them.";
        no_points_ui(ui, state, Study::Tuning, ICON_TUNE, text, commands);
        return;
    };
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        let rows = rows(tuned, before);
        let is_on = state.settings == tuned.settings;
        ui.horizontal_wrapped(|ui| {
            if rows.len() > 1 {
                let tokens = Tokens::in_ui(ui);
                let words = RichText::new("Use these settings").color(tokens.on_accent);
                let take = ui.add_enabled(!is_on, Button::new(words).fill(tokens.accent));
                let take = take.on_hover_text("Ctrl+Z undoes.").on_disabled_hover_text("They are in use.");
                if take.clicked() {
                    let settings = Box::new(tuned.settings.clone());
                    commands.push(Command::Settings(SettingsCommand::Take(settings)));
                }
            }
            study_button(ui, state, Study::Tuning, commands);
        });
        if let Some(words) = charts.stale_note(Study::Tuning, &state.settings).filter(|_| !is_on) {
            ui.label(RichText::new(words).color(Tokens::in_ui(ui).warning));
        }
        ui.add_space(space::SMALL);
        weak(ui, sentence(tuned, rows.len() > 1));
        ui.add_space(space::SMALL);
        ScrollArea::horizontal().show(ui, |ui| table_ui(ui, &rows));
    });
}

fn table_ui(ui: &mut Ui, rows: &[[String; 5]]) {
    if rows.len() < 2 {
        return;
    }
    Grid::new("tuned settings").num_columns(COLUMNS.len()).striped(true).spacing([16.0, 6.0]).show(
        ui,
        |ui| {
            for (name, help) in COLUMNS {
                let head = note(ui, name);
                if !help.is_empty() {
                    head.on_hover_text(help);
                }
            }
            ui.end_row();
            for (nth, row) in rows.iter().enumerate() {
                for cell in row {
                    let words = RichText::new(cell);
                    ui.label(if nth + 1 == rows.len() { words.strong() } else { words });
                }
                ui.end_row();
            }
        },
    );
}

/// What was found, in a sentence or two.
fn sentence(tuned: &Tuned, has_changes: bool) -> String {
    let tried = counted(tuned.points.len(), "setting");
    let viewpoints = counted(tuned.best.vantages, "viewpoint");
    let found = match (has_changes, tuned.cannot_tell) {
        (_, true) => format!("{viewpoints} cannot tell simpler settings from worse ones: yours stay."),
        (true, false) => "These are the smallest that are good enough.".to_owned(),
        (false, false) => "Yours are the smallest that are good enough.".to_owned(),
    };
    let most = tuned.at_most_db.unwrap_or_default();
    format!(
        "{found} Of {tried} tried, the best has {:.2} dB over {viewpoints}; good enough is what surely gives up \
         at most {most} dB of that.",
        tuned.best.psnr_filled_db
    )
}

/// A row for each setting that changes, with what it changes alone, and one for all of them; only that one where none changes.
fn rows(tuned: &Tuned, before: &Settings) -> Vec<[String; 5]> {
    let of = |settings: &Settings| tuned.points.iter().find(|point| point.settings == *settings);
    let start = of(before);
    let changes = |after: Option<&Point>| -> [String; 3] {
        let Some((before, after)) = start.zip(after) else {
            return std::array::from_fn(|_| "–".to_owned());
        };
        let share =
            |before: u64, after: u64| signed(100.0 * (after as f64 / before.max(1) as f64 - 1.0), 1, "%");
        [
            share(before.samples, after.samples),
            share(before.bytes_of_samples(), after.bytes_of_samples()),
            signed(after.psnr_filled_db - before.psnr_filled_db, 2, "dB"),
        ]
    };
    let mut rows: Vec<[String; 5]> = Vec::new();
    for (field, [_, value]) in SettingPairs::new(before, &tuned.settings).differing() {
        let mut alone = before.clone();
        let is_set = alone.set(field.path, value.clone()).is_ok();
        let words = model::setting_names::changes(before, &alone).join("; ");
        let (name, change) = words.split_once(": ").unwrap_or((&words, ""));
        let [samples, store, accuracy] = changes(of(&alone).filter(|_| is_set));
        rows.push([name.to_owned(), change.to_owned(), samples, store, accuracy]);
    }
    let [samples, store, accuracy] = changes(Some(&tuned.chosen));
    rows.push(["All together".to_owned(), String::new(), samples, store, accuracy]);
    rows
}

/// A difference with its sign and unit; none where it rounds to nothing.
pub(crate) fn signed(difference: f64, decimals: usize, unit: &str) -> String {
    let digits = format!("{:.decimals$}", difference.abs());
    let is_nothing = digits.chars().all(|digit| matches!(digit, '0' | '.'));
    let sign = if is_nothing {
        ""
    } else if difference < 0.0 {
        "−"
    } else {
        "+"
    };
    format!("{sign}{digits} {unit}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use overlook_lab::sweep::Series;
    use overlook_lab::trial::{Trial, TrialResult};

    #[test]
    fn each_setting_is_told_with_what_it_changes_alone_and_all_of_them_with_what_they_change_together() {
        let before = Settings::default();
        let point = |assignments: &[&str], psnr: f64, samples: u64| {
            let mut settings = before.clone();
            for assignment in assignments {
                settings.set_text(assignment).unwrap();
            }
            let trial = Trial::new(assignments.join(", "), settings);
            let mut point = Point::new(&trial, Series::Variation, &TrialResult::default());
            (point.psnr_filled_db, point.samples, point.bytes) = (psnr, samples, 10 * samples);
            point
        };
        let [range, kernel] = ["spans.depth_tolerance=0.004", "render.kernel=point"];
        let points =
            vec![point(&[], 30.0, 100), point(&[range], 29.95, 90), point(&[range, kernel], 29.9, 80)];
        let chosen = points[2].clone();
        let tuned = Tuned {
            settings: chosen.settings.clone(),
            cameras: Vec::new(),
            camera_costs: Vec::new(),
            best: points[0].clone(),
            at_most_db: Some(0.1),
            cannot_tell: false,
            chosen,
            bytes_whole: None,
            points,
            words: Vec::new(),
        };
        let rows = rows(&tuned, &before);
        let figures: Vec<&[String]> = rows.iter().map(|row| &row[2..]).collect();
        assert_eq!(
            figures,
            [["−10.0 %", "−10.0 %", "−0.05 dB"], ["–"; 3], ["−20.0 %", "−20.0 %", "−0.10 dB"]]
        );
        assert_eq!((rows[0][0].as_str(), rows[1][0].as_str()), ("Static depth range", "Kernel"));
        assert!(rows[0][1].ends_with(" » 0.004"), "{rows:?}");
        assert!(sentence(&tuned, true).contains("at most 0.1 dB"));
        assert_eq!([signed(-0.001, 2, "dB"), signed(0.5, 1, "%")], ["0.00 dB", "+0.5 %"]);
    }
}
