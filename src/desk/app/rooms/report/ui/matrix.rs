//! Which camera's samples replace whose, and how well cameras agree on positions: a wrong pose shows on static surfaces, a wrong clock
//! on moving ones, noise on both.

use egui::{RichText, Ui};

use super::pair_grid::{PairCell, by_weight, pairs_ui};
use crate::app::colormap::sequential;
use crate::app::model;
use crate::app::model::Commands;
use crate::app::rooms::report::model::Table;
use crate::app::rooms::source::ui::legend::bar;
use crate::app::theme::{Tokens, space};
use crate::app::widgets::{note, table_ui, weak};
use overlook_engine::preprocess::diagnostics::{PairResiduals, Report, Residual};

/// The matrix of replaced samples.
pub(crate) fn replacements_ui(ui: &mut Ui, report: &Report, commands: &mut Commands) {
    ui.heading("Which camera replaces which");
    weak(ui, "Rows lose samples, columns keep the ones that replace them.");
    table_ui(ui, Table::Replacements, commands);
    left_out_ui(ui, report);
    let most = report.witnesses.iter().map(|(.., count)| *count).max().unwrap_or(0).max(1) as f32;
    let names: Vec<&str> = report.cameras.iter().map(|camera| camera.name.as_str()).collect();
    let kept_for = |winner: usize| {
        let counts = (0..names.len()).filter_map(|loser| report.witnesses.get(loser, winner));
        counts.map(|count| *count as f32).sum::<f32>()
    };
    let order = by_weight(names.len(), kept_for);
    pairs_ui(ui, "replacements", &names, &order, |loser, winner| {
        let count = *report.witnesses.get(loser, winner)?;
        Some(PairCell {
            // The square root makes small counts differ from none.
            strength: (count > 0).then(|| (count as f32 / most).sqrt()),
            text: model::count(count),
            help: format!(
                "'{}': {} dropped for '{}'",
                names[loser],
                model::count_of(count, "sample"),
                names[winner]
            ),
        })
    });
}

/// Says what the matrix of replaced samples lacks where there are many cameras.
fn left_out_ui(ui: &mut Ui, report: &Report) {
    let left_out: u64 = report.witnesses_left_out.iter().sum();
    if left_out > 0 {
        let samples = model::count_of(left_out, "sample");
        weak(
            ui,
            format!("Each row shows the cameras that replace most of it; {samples} were dropped for others."),
        );
    }
}

/// A scale ends at this many times the mean: a pair that is far off does not make all others alike.
const ABOVE_MEAN: f32 = 3.0;

/// The least that the end of a scale stands for, footprints.
const LEAST_FOOTPRINTS: f32 = 0.05;

/// Both matrices, and notes on cameras that do not fit.
pub(crate) fn agreement_ui(ui: &mut Ui, report: &Report, commands: &mut Commands) {
    let tokens = Tokens::in_ui(ui);
    ui.heading("How well cameras agree");
    let help = "How far samples of the row's camera lie off what the column's camera saw there, in pixel footprints. Where all of one camera's pairs are light, that camera is wrong.";
    let suspects = report.suspects();
    for (cause, warning) in &suspects {
        let words = format!("{}: {warning}", cause.name());
        ui.label(RichText::new(words).color(tokens.warning)).on_hover_text(help);
    }
    if suspects.is_empty() {
        let words = if report.is_noisy() {
            "Noise: cameras differ by as much as the noise that was measured between them; no pose and no clock stands out."
        } else {
            "No camera contradicts the others."
        };
        weak(ui, words).on_hover_text(help);
    }
    table_ui(ui, Table::Agreement, commands);
    let title = "What never moves, 85 % within (a pose error shows here)";
    residuals_ui(ui, report, title, |pair| pair.lasting, |residual| residual.most_footprints);
    ui.add_space(space::SMALL);
    let title = "What moves, half within (a time offset shows here alone)";
    residuals_ui(ui, report, title, |pair| pair.moving, |residual| residual.median_footprints);
}

fn residuals_ui(
    ui: &mut Ui,
    report: &Report,
    title: &str,
    of: impl Fn(&PairResiduals) -> Option<Residual>,
    footprints: impl Fn(&Residual) -> f32,
) {
    note(ui, title);
    let names: Vec<&str> = report.cameras.iter().map(|camera| camera.name.as_str()).collect();
    let value = |row: usize, column: usize| Some(footprints(&of(report.residuals.get(row, column)?)?));
    let (mut sum, mut count, mut most) = (0.0, 0, 0.0_f32);
    for (row, column) in (0..names.len()).flat_map(|row| (0..names.len()).map(move |column| (row, column))) {
        if let Some(value) = value(row, column) {
            (sum, count, most) = (sum + value, count + 1, most.max(value));
        }
    }
    let lightest = most.min(ABOVE_MEAN * sum / count.max(1) as f32).max(LEAST_FOOTPRINTS);
    ui.horizontal(|ui| {
        let end = format!("{} footprints or more", model::significant(f64::from(lightest)));
        bar(ui, "0", &end, 90.0, sequential);
    });
    let order = by_weight(names.len(), |camera| {
        (0..names.len()).filter_map(|other| value(camera, other)).fold(0.0, f32::max)
    });
    pairs_ui(ui, title, &names, &order, |row, column| {
        let residual = of(report.residuals.get(row, column)?)?;
        let Residual { samples, median_footprints, most_footprints, median_color_steps } = residual;
        Some(PairCell {
            strength: Some((footprints(&residual) / lightest).sqrt().min(1.0)),
            text: format!("{:.2}", footprints(&residual)),
            help: format!(
                "'{}' against '{}': 85 % of {} within {most_footprints:.3} footprints, half within \
                 {median_footprints:.3}; half of their colors within {median_color_steps:.1} steps",
                names[row],
                names[column],
                model::count_of(samples, "sample"),
            ),
        })
    });
}
