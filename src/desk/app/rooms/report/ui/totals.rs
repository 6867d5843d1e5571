//! The strip that is always in view: what pruning saved, why, and what it cost.

use egui::{Align, Layout, RichText, Ui};

use super::causes::causes_ui;
use crate::app::model;
use crate::app::model::{Accuracy, Command, Commands, Content, State};
use crate::app::rooms::frame::model::{DockView, WindowCommand};
use crate::app::theme::{Tokens, figure_style};
use crate::app::widgets::one_line;
use overlook_engine::plural::counted;
use overlook_engine::preprocess::diagnostics::{PixelAccount, Report};

/// Height of a figure with its name.
const FIGURE: f32 = 38.0;

/// Between a figure and its note.
const GAP: f32 = 6.0;

/// Between a note and the next figure.
const MARGIN: f32 = 14.0;

/// A figure with its name.
pub(crate) struct KeyFigure {
    pub name: &'static str,
    pub value: String,
    pub note: String,
    help: String,
    /// Whether it changes with the whole-capture settings, so that it can be out of date.
    of_whole: bool,
}

/// The note on what is known of the frame that is shown, until the whole capture is pruned.
const THIS_FRAME: &str = "this frame";

/// Width of the bars beside the figures at most, points; as many again as figures need are theirs first.
const CAUSES_MOST: f32 = 640.0;

pub(crate) fn totals_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    let figures = figures(state);
    let account = state.report().map(Report::pixel_account).or(account_here(state));
    let (needed, spare) = widths(ui, &figures);
    let bars = if account.is_some() { spare.min(CAUSES_MOST) } else { 0.0 };
    let more = (spare - bars) / figures.len().max(1) as f32;
    ui.horizontal_centered(|ui| {
        ui.spacing_mut().item_spacing.x = 0.0;
        for (figure, width) in figures.iter().zip(needed) {
            let size = egui::vec2(width + more, FIGURE);
            ui.allocate_ui_with_layout(size, Layout::top_down(Align::Min), |ui| {
                figure_ui(ui, figure, state.is_stale());
            });
        }
        let Some(account) = account else { return };
        ui.allocate_ui_with_layout(egui::vec2(bars, FIGURE), Layout::top_down(Align::Min), |ui| {
            if causes_ui(ui, &account).is_some_and(|bars| bars.clicked()) {
                commands.push(Command::Window(WindowCommand::OpenView(DockView::Report)));
            }
        });
    });
}

/// What each figure needs, and what is left beside them.
fn widths(ui: &Ui, figures: &[KeyFigure]) -> (Vec<f32>, f32) {
    let styles = (figure_style().resolve(ui.style()), egui::TextStyle::Small.resolve(ui.style()));
    let width_of = |text: &str, font: &egui::FontId| {
        ui.painter().layout_no_wrap(text.to_owned(), font.clone(), egui::Color32::PLACEHOLDER).size().x
    };
    let needed: Vec<f32> = figures
        .iter()
        .map(|figure| {
            let line = width_of(&figure.value, &styles.0) + GAP + width_of(&figure.note, &styles.1);
            line.max(width_of(figure.name, &styles.1)) + MARGIN
        })
        .collect();
    let spare = (ui.available_width() - needed.iter().sum::<f32>()).max(0.0);
    (needed, spare)
}

fn figure_ui(ui: &mut Ui, figure: &KeyFigure, stale: bool) {
    let tokens = Tokens::in_ui(ui);
    let stale = stale && figure.of_whole;
    ui.set_min_width(ui.available_width());
    ui.set_max_width(ui.available_width() - MARGIN);
    ui.spacing_mut().item_spacing = egui::vec2(GAP, 1.0);
    let name = RichText::new(figure.name).small().color(tokens.text_weak);
    let note = if stale { "out of date" } else { &figure.note };
    let color = if stale { tokens.text_weak } else { tokens.text };
    let response = ui
        .vertical(|ui| {
            ui.label(name);
            ui.horizontal(|ui| {
                ui.label(RichText::new(&figure.value).text_style(figure_style()).color(color));
                let note_color = if stale { tokens.warning } else { tokens.text_weak };
                one_line(ui, note, note_color);
            });
        })
        .response;
    let mut help = figure.help.clone();
    if stale {
        help.push_str(
            " A setting was changed since; the number is out of date until the capture is pruned again.",
        );
    }
    response.on_hover_text(help);
}

/// What became of the pixels of the frame that is shown, while nothing is known of the others.
fn account_here(state: &State) -> Option<PixelAccount> {
    let is_unknown = state.report().is_none() && state.inspection_here().is_some();
    state.doc.inspected.as_ref().filter(|_| is_unknown).map(|inspected| inspected.account)
}

/// Every figure, from left to right.
pub(crate) fn figures(state: &State) -> Vec<KeyFigure> {
    let report = state.report();
    let here = account_here(state);
    let of_frame = |value: String| [value, THIS_FRAME.to_owned()];
    let bytes_here = state.inspection_here().filter(|_| here.is_some()).map(|it| it.samples.bytes());
    let account = report.map(Report::pixel_account).or(here);
    let figure = |name, of_whole, value_and_note: Option<[String; 2]>, help: &str| {
        let [value, note] = value_and_note.unwrap_or_else(|| ["…".to_owned(), String::new()]);
        let first =
            if note == THIS_FRAME { "Of the frame that is shown, until all are pruned. " } else { "" };
        KeyFigure { name, value, note, help: format!("{first}{help}"), of_whole }
    };
    let memory_note = |report: &Report| match state.content() {
        Some(Content::Store { bytes, .. }) => format!("file {}", model::bytes(*bytes)),
        _ => format!("of {}", model::bytes(report.bytes_raw)),
    };
    let seconds = report.map(|r| r.seconds).filter(|seconds| *seconds > 0.0);
    let render = state.doc.live_shown.as_ref().map(|shown| {
        let stats = &shown.picture.stats;
        let pixels = shown.picture.size.iter().product::<usize>().max(1) as u64;
        let covered = model::percent(pixels.saturating_sub(stats.holes), pixels);
        [format!("{} ms", model::significant(stats.milliseconds)), format!("{covered} covered")]
    });
    let mut figures = vec![
        figure(
            "Samples kept",
            true,
            report
                .map(|r| [model::count(r.samples_kept), format!("of {}", model::count(r.samples_in))])
                .or(here.map(|account| of_frame(model::count(account.kept)))),
            "The samples kept, of all pixels of all frames of all cameras.",
        ),
        figure(
            "Dropped",
            true,
            account.map(|account| {
                let note = if report.is_some() { String::new() } else { THIS_FRAME.to_owned() };
                [model::percent(account.not_kept(), account.pixels), note]
            }),
            &account.map_or_else(String::new, |account| dropped_help(&account)),
        ),
        figure(
            "Memory",
            true,
            report
                .map(|r| [model::bytes(r.bytes_memory), memory_note(r)])
                .or(bytes_here.map(|bytes| of_frame(model::bytes(bytes)))),
            "The kept samples in memory, of all pixels as 8-bit color and 32-bit depth; a saved store is smaller.",
        ),
    ];
    // What nobody can know here has no place.
    if state.doc.accuracy.is_some() || state.has_truth() {
        figures.push(accuracy_figure(state.doc.accuracy, figure));
    }
    if state.has_capture() {
        let help = "Seconds that pruning the whole capture took.";
        let took = seconds.map(|pruned| format!("{help} {}.", model::took(state.doc.read_seconds, pruned)));
        figures.push(figure(
            "Pruning",
            true,
            seconds.map(|seconds| [format!("{} s", model::significant(seconds)), String::new()]),
            took.as_deref().unwrap_or(help),
        ));
    }
    figures.push(figure(
        "Live view",
        false,
        render,
        "Milliseconds that rendering the live view took, and the share of it that samples reached.",
    ));
    figures
}

/// The parts of what is not kept, which add up.
fn dropped_help(account: &PixelAccount) -> String {
    let [_, dropped @ ..] = model::account_parts(account);
    let parts = dropped.into_iter().filter(|(_, pixels)| *pixels > 0);
    let parts = parts.map(|(what, pixels)| format!("{} {what}", model::percent(pixels, account.pixels)));
    format!(
        "Share of all pixels of all frames of all cameras that are not kept: {}. Redundant are those that a kept sample represents at \
         least as well.",
        parts.collect::<Vec<_>>().join(", ")
    )
}

fn accuracy_figure(
    accuracy: Option<Accuracy>,
    figure: impl Fn(&'static str, bool, Option<[String; 2]>, &str) -> KeyFigure,
) -> KeyFigure {
    let Some(accuracy) = accuracy else {
        let help = "Accuracy is measured at the viewpoints whose true picture is known, once the scene is pruned and rests: not while it \
                    plays, nor after Esc.";
        return figure("Accuracy", true, None, help);
    };
    let Accuracy { psnr_db, unpruned_psnr_db, views } = accuracy;
    let help = format!(
        "Mean PSNR at {} whose true picture is known, over the pixels that samples reached: charts fill holes first \
         and count all. With nothing pruned it is {unpruned_psnr_db:.1} dB.",
        counted(views, "viewpoint")
    );
    let change = format!("{:+.2} dB vs unpruned", psnr_db - unpruned_psnr_db);
    figure("Accuracy", true, Some([format!("{psnr_db:.1} dB"), change]), &help)
}
