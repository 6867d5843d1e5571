//! How well cameras agree about where things are: a wrong pose shows in what never moves, a wrong clock in what does.

use egui::{RichText, Ui};

use super::matrix::{self, PairCell};
use crate::app::model;
use crate::app::theme::{Tokens, space};
use crate::app::widgets::{note, weak};
use crate::preprocess::diagnostics::{PairResiduals, Report, Residual};

/// Residuals from here on are as light as can be, in footprints: a tenth of a footprint can be told from none.
const LIGHTEST_FOOTPRINTS: f32 = 2.0;

/// Both matrices, and what is to be said about cameras that do not fit.
pub(crate) fn ui(ui: &mut Ui, report: &Report) {
    let tokens = Tokens::in_ui(ui);
    ui.heading("How well cameras agree");
    let help = "How far samples of the row's camera lie off what the column's camera saw there, in pixel footprints. Where all of one camera's pairs are light, that camera is wrong.";
    let doubts = report.doubts();
    if doubts.is_empty() {
        weak(ui, "No camera contradicts the others.").on_hover_text(help);
    }
    for doubt in doubts {
        ui.label(RichText::new(model::sentence(&doubt)).color(tokens.warning)).on_hover_text(help);
    }
    let title = "What never moves, 85 % within (a wrong pose shows here)";
    residuals_ui(ui, report, title, |pair| pair.lasting, |residual| residual.most_footprints);
    ui.add_space(space::SMALL);
    let title = "What moves, half within (a wrong clock shows here alone)";
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
    matrix::ui(ui, &names, |row, column| {
        let residual = of(report.residuals.get(row)?.get(column)?)?;
        let Residual { samples, median_footprints, most_footprints, median_color_steps } = residual;
        Some(PairCell {
            strength: Some((footprints(&residual) / LIGHTEST_FOOTPRINTS).sqrt().min(1.0)),
            text: format!("{:.2}", footprints(&residual)),
            help: format!(
                "{} against {}: 85 % of {} samples within {most_footprints:.3} footprints, half within \
                 {median_footprints:.3}; half of their colors within {median_color_steps:.1} steps",
                names[row],
                names[column],
                model::count(samples),
            ),
        })
    });
}
