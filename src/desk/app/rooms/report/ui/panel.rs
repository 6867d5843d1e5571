//! How many samples each rule pruned, for which camera; how well cameras agree; and how noisy the capture is.

use egui::{Align, Color32, Layout, Rect, RichText, ScrollArea, Sense, Stroke, StrokeKind, Ui, vec2};
use egui_extras::{Column, TableBuilder};
use egui_material_icons::icons::ICON_GRID_ON;

use super::alignment::alignment_ui;
use super::matrix::{agreement_ui, replacements_ui};
use super::pair_grid::{by_weight, short};
use crate::app::model;
use crate::app::model::{Commands, State};
use crate::app::rooms::report::model::Table;
use crate::app::theme::{Tokens, space};
use crate::app::widgets::{dot, note, table_ui, weak};
use overlook_engine::preprocess::diagnostics::{CameraReport, Report};

pub(crate) fn report_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    let Some(report) = state.report() else {
        ui.add_space(space::MEDIUM);
        weak(ui, "The report appears here once the whole capture is pruned.");
        return;
    };
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        ui.set_max_width(ui.available_width() - space::MEDIUM);
        stale_ui(ui, state);
        rules_ui(ui, report, commands);
        ui.add_space(space::LARGE);
        replacements_ui(ui, report, commands);
        ui.add_space(space::LARGE);
        agreement_ui(ui, report, commands);
        ui.add_space(space::LARGE);
        alignment_ui(ui, state, report, commands);
        cameras_ui(ui, report, commands);
        ui.add_space(space::LARGE);
    });
}

/// A note on numbers that were made with other settings.
pub(crate) fn stale_ui(ui: &mut Ui, state: &State) {
    if let Some(words) = state.stale_note() {
        ui.label(RichText::new(words).color(Tokens::in_ui(ui).warning));
    }
}

/// Width from which on matrices stand beside each other.
const TWO_COLUMNS: f32 = 720.0;

/// The matrices alone.
pub(crate) fn matrix_view_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    let Some(report) = state.report() else {
        let text = "Which camera replaces which, and how well cameras agree, is known once the whole capture is pruned.";
        crate::app::widgets::empty_ui(ui, ICON_GRID_ON, "No matrix yet", text, |_| {});
        return;
    };
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        stale_ui(ui, state);
        if ui.available_width() < TWO_COLUMNS {
            alignment_ui(ui, state, report, commands);
            replacements_ui(ui, report, commands);
            ui.add_space(space::LARGE);
            agreement_ui(ui, report, commands);
        } else {
            ui.columns(2, |columns| {
                replacements_ui(&mut columns[0], report, commands);
                alignment_ui(&mut columns[1], state, report, commands);
                agreement_ui(&mut columns[1], report, commands);
            });
        }
    });
}

fn rule_words(rule: &str) -> (String, &'static str) {
    let (words, help) = match rule {
        "static" => (
            "Repeated over time",
            "Repetitions over time that one sample stored for several frames replaces.",
        ),
        "lower_rate" => ("Seen better elsewhere", "Another camera samples the point more densely."),
        "tie" => ("Seen equally well", "Equal rates: the earlier camera's sample stays."),
        "later_camera" => ("Seen by an earlier camera", "First camera wins, whatever the sampling rate."),
        "mixed_yields" => (
            "Edge-blended, another is clean",
            "Color or depth is blended across an edge, and a clean sample shows the point.",
        ),
        "unsure_yields" => (
            "Normal unknown",
            "The normal is not known here, and a sample with a known normal shows the point.",
        ),
        "mixed_dropped" => (
            "Edge-blended, rejected",
            "Color or depth is blended across an edge, and the settings drop such samples.",
        ),
        "contradicted" => (
            "Contradicted",
            "More cameras contradict the point than confirm it: one camera misread it, or it flies between foreground and background.",
        ),
        "no_sample" => ("Without depth", "The pixel has no depth and takes part in nothing."),
        "cut" => (
            "Cut by hand",
            "An edit deletes it: its camera was left out, or it is in a region that was deleted.",
        ),
        other => return (model::words(other), ""),
    };
    (words.to_owned(), help)
}

fn rules_ui(ui: &mut Ui, report: &Report, commands: &mut Commands) {
    let tokens = Tokens::in_ui(ui);
    ui.heading("What was dropped, and why");
    let account = report.pixel_account();
    let others = [("no_sample", account.without_depth), ("cut", account.cut)];
    let rules = report.pruned.iter().map(|(rule, count)| (rule.as_str(), *count));
    let mut rules: Vec<_> = rules.chain(others).filter(|(_, count)| *count > 0).collect();
    rules.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    if rules.is_empty() {
        weak(ui, "Nothing was pruned.");
    }
    for (rule, count) in rules {
        let (words, help) = rule_words(rule);
        let figure = format!("{}  {}", model::count(count), model::percent(count, report.samples_in));
        share_ui(
            ui,
            &words,
            &figure,
            count as f32 / report.samples_in.max(1) as f32,
            tokens.static_over_time,
        )
        .on_hover_text(help);
    }
    let kept = format!(
        "{}  {}",
        model::count(report.samples_kept),
        model::percent(report.samples_kept, report.samples_in)
    );
    let share = report.samples_kept as f32 / report.samples_in.max(1) as f32;
    share_ui(ui, "Kept", &kept, share, tokens.moving).on_hover_text("Samples that stay.");
    table_ui(ui, Table::Pixels, commands);
}

/// How much darker the rim of a bar is.
const RIM: f32 = 0.35;

/// Heights of a row with a share, and of its bar.
pub(super) const SHARE_ROW: f32 = 28.0;
pub(super) const SHARE_BAR: f32 = 6.0;

/// A name, a figure, and a bar of the share below them.
pub(crate) fn share_ui(ui: &mut Ui, name: &str, figure: &str, share: f32, color: Color32) -> egui::Response {
    tall_share_ui(ui, name, figure, share, color, SHARE_BAR)
}

/// The same with a bar of a height.
pub(super) fn tall_share_ui(
    ui: &mut Ui,
    name: &str,
    figure: &str,
    share: f32,
    color: Color32,
    bar_height: f32,
) -> egui::Response {
    let tokens = Tokens::in_ui(ui);
    let size = vec2(ui.available_width(), SHARE_ROW - SHARE_BAR + bar_height);
    let (rect, response) = ui.allocate_exact_size(size, Sense::hover());
    let painter = ui.painter();
    let font = egui::TextStyle::Body.resolve(ui.style());
    painter.text(rect.left_top(), egui::Align2::LEFT_TOP, name, font.clone(), tokens.text);
    painter.text(rect.right_top(), egui::Align2::RIGHT_TOP, figure, font, tokens.text_weak);
    let rail = Rect::from_min_max(
        egui::pos2(rect.left(), rect.bottom() - 2.0 - bar_height),
        rect.max - vec2(0.0, 2.0),
    );
    painter.rect_filled(rail, 2.0, tokens.raised);
    let bar = Rect::from_min_size(rail.min, vec2(rail.width() * share.clamp(0.0, 1.0), rail.height()));
    // The rim keeps light colors visible in a light window.
    let rim = Stroke::new(1.0, color.lerp_to_gamma(Color32::BLACK, RIM));
    painter.rect(bar, 2.0, color, rim, StrokeKind::Inside);
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Label, true, format!("{name}: {figure}")));
    response
}

/// What was measured of a camera, and where the tolerances of the spans lie in it.
fn measured(camera: &CameraReport) -> String {
    let ranges = &camera.ranges;
    let percent = |share: f32| format!("{:.1} %", 100.0 * share);
    let half = ranges.color_percentiles_steps.first().copied().unwrap_or(0.0);
    let between = camera.noise_between().map_or_else(String::new, |noise| format!("{noise}\n"));
    format!(
        "{between}Depth noise {:.1e}, depth recorded in steps of {:.1e}, both relative.\nOver all frames the color of half of the \
         pixels stays within {half:.1} steps. Within the tolerance: {}; with what noise explains: {}.\nDepth within {:.1e}: \
         {} of the pixels.",
        camera.depth_noise_relative,
        camera.depth_step_relative,
        percent(ranges.within_color_tolerance),
        percent(ranges.within_color_tolerance_and_noise),
        ranges.depth_granted_relative,
        percent(ranges.within_depth_granted),
    )
}

/// Height of a row of the table of cameras.
const CAMERA_ROW: f32 = 20.0;

fn cameras_ui(ui: &mut Ui, report: &Report, commands: &mut Commands) {
    ui.heading("Cameras");
    table_ui(ui, Table::Cameras, commands);
    let kept = |index: usize| report.cameras[index].background_kept + report.cameras[index].foreground_kept;
    let order = by_weight(report.cameras.len(), |index| kept(index) as f32);
    let frames = report.foreground_per_frame.len().max(1) as u64;
    let columns =
        [Column::remainder().clip(true), Column::initial(66.0), Column::initial(60.0), Column::initial(50.0)];
    let mut table = TableBuilder::new(ui).id_salt("cameras").striped(true).vscroll(order.len() > SCROLLED);
    table = table.cell_layout(Layout::left_to_right(Align::Center));
    for column in columns {
        table = table.column(column);
    }
    let table = table.max_scroll_height(SCROLLED as f32 * CAMERA_ROW).header(CAMERA_ROW, |mut header| {
        for (title, help) in [
            ("Name", "Name of the camera."),
            ("Kept", "Samples kept of all its pixels."),
            ("Static", "Share of its pixels that are the same over all frames."),
            ("Noise", "Measured color noise of static pixels, in 8-bit steps."),
        ] {
            header.col(|ui| {
                note(ui, title).on_hover_text(help);
            });
        }
    });
    table.body(|body| {
        body.rows(CAMERA_ROW, order.len(), |mut row| {
            let index = order[row.index()];
            let camera = &report.cameras[index];
            row.col(|ui| {
                dot(ui, index);
                ui.label(short(&camera.name, 14)).on_hover_text(&camera.name);
            });
            row.col(|ui| {
                ui.label(model::count(kept(index)));
            });
            row.col(|ui| {
                ui.label(model::percent(camera.background_pixels, camera.pixels / frames));
            });
            row.col(|ui| {
                ui.label(format!("{:.2}", camera.color_noise_steps)).on_hover_text(measured(camera));
            });
        });
    });
}

/// Cameras from which on their table is scrolled by itself.
const SCROLLED: usize = 16;
