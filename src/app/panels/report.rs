//! What was pruned, by which rule, for which camera, and how noisy the capture is.

use egui::{Grid, Rect, RichText, ScrollArea, Sense, Ui, Vec2, vec2};

use egui_material_icons::icons::ICON_GRID_ON;

use super::super::state::State;
use super::super::text;
use super::super::theme::{Tokens, space};
use super::super::views::colormap;
use crate::preprocess::Report;
use crate::preprocess::report::CameraReport;

/// The panel.
pub(super) fn report_ui(ui: &mut Ui, state: &State) {
    let tokens = Tokens::in_ui(ui);
    let Some(report) = state.report() else {
        ui.add_space(space::MEDIUM);
        ui.label(
            RichText::new("The report appears here once the whole capture is pruned.")
                .color(tokens.text_weak),
        );
        return;
    };
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        ui.set_max_width(ui.available_width() - space::MEDIUM);
        if state.is_stale() {
            ui.label(
                RichText::new("Made with other thresholds; being brought up to date.").color(tokens.warning),
            );
        }
        rules_ui(ui, report);
        ui.add_space(space::LARGE);
        matrix_ui(ui, report);
        ui.add_space(space::LARGE);
        cameras_ui(ui, report);
        ui.add_space(space::LARGE);
    });
}

/// The matrix alone.
pub(super) fn matrix_view_ui(ui: &mut Ui, state: &State) {
    let Some(report) = state.report() else {
        let text = "Who stands for whom is known once the whole capture is pruned.";
        super::empty_ui(ui, ICON_GRID_ON, "No matrix yet", text, |_| {});
        return;
    };
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| matrix_ui(ui, report));
}

fn rule_words(rule: &str) -> (String, &'static str) {
    let (words, help) = match rule {
        "static" => ("Same over all frames", "Repetitions that a background sample stands for."),
        "lower_rate" => ("Seen better elsewhere", "Another camera samples the point more densely."),
        "tie" => ("Seen equally well", "Equal rates: the earlier camera's sample stays."),
        "later_camera" => ("Seen by an earlier camera", "First camera wins, whatever the sampling rate."),
        "mixed_yields" => {
            ("Blended at a silhouette", "The color is blended, and a clean sample shows the point.")
        }
        "mixed_dropped" => ("Blended, dropped", "The color is blended and the settings drop such samples."),
        "no_sample" => ("Without depth", "The pixel has no depth and takes part in nothing."),
        other => return (text::words(other), ""),
    };
    (words.to_owned(), help)
}

fn rules_ui(ui: &mut Ui, report: &Report) {
    let tokens = Tokens::in_ui(ui);
    ui.heading("What was redundant, and why");
    let mut rules: Vec<_> = report.pruned.iter().filter(|(_, count)| **count > 0).collect();
    rules.sort_by_key(|(_, count)| std::cmp::Reverse(**count));
    if rules.is_empty() {
        ui.label(RichText::new("Nothing was pruned.").color(tokens.text_weak));
    }
    for (rule, &count) in rules {
        let (words, help) = rule_words(rule);
        let figure = format!("{}  {}", text::count(count), text::percent(count, report.samples_in));
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
        text::count(report.samples_kept),
        text::percent(report.samples_kept, report.samples_in)
    );
    let share = report.samples_kept as f32 / report.samples_in.max(1) as f32;
    share_ui(ui, "Kept", &kept, share, tokens.moving).on_hover_text("Samples that stay.");
}

/// A name, a figure, and a bar of the share below them.
fn share_ui(ui: &mut Ui, name: &str, figure: &str, share: f32, color: egui::Color32) -> egui::Response {
    let tokens = Tokens::in_ui(ui);
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), 28.0), Sense::hover());
    let painter = ui.painter();
    let font = egui::TextStyle::Body.resolve(ui.style());
    painter.text(rect.left_top(), egui::Align2::LEFT_TOP, name, font.clone(), tokens.text);
    painter.text(rect.right_top(), egui::Align2::RIGHT_TOP, figure, font, tokens.text_weak);
    let rail = Rect::from_min_max(egui::pos2(rect.left(), rect.bottom() - 7.0), rect.max - vec2(0.0, 2.0));
    painter.rect_filled(rail, 2.0, tokens.raised);
    let bar = Rect::from_min_size(rail.min, vec2(rail.width() * share.clamp(0.0, 1.0), rail.height()));
    painter.rect_filled(bar, 2.0, color);
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Label, true, format!("{name}: {figure}")));
    response
}

fn matrix_ui(ui: &mut Ui, report: &Report) {
    let tokens = Tokens::in_ui(ui);
    ui.heading("Who stands for whom");
    ui.label(
        RichText::new("Rows lose samples, columns keep the ones that stand for them.")
            .color(tokens.text_weak),
    );
    let cameras = report.cameras.len();
    if cameras == 0 {
        return;
    }
    let name_width = 78.0;
    let cell = ((ui.available_width() - name_width) / cameras as f32).clamp(3.0, 44.0);
    let most = report.witnesses.iter().flatten().copied().max().unwrap_or(0).max(1) as f32;
    let small = egui::TextStyle::Small.resolve(ui.style());
    let (area, _) = ui.allocate_exact_size(
        vec2(ui.available_width(), 18.0 + cell.min(24.0) * cameras as f32),
        Sense::hover(),
    );
    let painter = ui.painter_at(area);
    let height = cell.min(24.0);
    for (loser, row) in report.witnesses.iter().enumerate() {
        let top = area.top() + 18.0 + height * loser as f32;
        let name = &report.cameras[loser].name;
        camera_name(&painter, egui::pos2(area.left(), top + height / 2.0), loser, name, &small, tokens);
        for (winner, &count) in row.iter().enumerate() {
            let left = area.left() + name_width + cell * winner as f32;
            let rect = Rect::from_min_size(egui::pos2(left, top), vec2(cell, height)).shrink(1.0);
            if loser == 0 {
                let center = egui::pos2(rect.center().x, area.top() + 8.0);
                painter.circle_filled(center, 4.0, colormap::camera(winner));
            }
            // The square root lets small counts be told from none.
            let strength = (count as f32 / most).sqrt();
            let color = if count == 0 { tokens.background } else { colormap::sequential(strength) };
            painter.rect_filled(rect, 2.0, color);
            if cell >= 40.0 && count > 0 {
                // The map passes mid gray at about half its range: black reads on what is lighter, white on the rest.
                let text_color = if strength > 0.55 { egui::Color32::BLACK } else { egui::Color32::WHITE };
                let font = egui::FontId::proportional(10.0);
                painter.text(
                    rect.center(),
                    egui::Align2::CENTER_CENTER,
                    text::count(count),
                    font,
                    text_color,
                );
            }
            let label =
                format!("{name}: {} samples dropped for {}", text::count(count), report.cameras[winner].name);
            let response = ui.interact(rect, ui.scope_id().with((loser, winner)), Sense::hover());
            response.on_hover_text(label);
        }
    }
}

fn camera_name(
    painter: &egui::Painter,
    at: egui::Pos2,
    index: usize,
    name: &str,
    font: &egui::FontId,
    tokens: &Tokens,
) {
    painter.circle_filled(at + vec2(5.0, 0.0), 4.0, colormap::camera(index));
    painter.text(at + vec2(14.0, 0.0), egui::Align2::LEFT_CENTER, short(name, 11), font.clone(), tokens.text);
}

/// The first characters of a name, and whether there are more.
fn short(name: &str, length: usize) -> String {
    if name.chars().count() <= length {
        return name.to_owned();
    }
    let mut text: String = name.chars().take(length - 1).collect();
    text.push('…');
    text
}

/// What was measured of a camera, and where the tolerances of the spans lie in it.
fn measured(camera: &CameraReport) -> String {
    let ranges = &camera.ranges;
    let percent = |share: f32| format!("{:.1} %", 100.0 * share);
    let half = ranges.color_percentiles_steps.first().copied().unwrap_or(0.0);
    format!(
        "Depth noise {:.1e}, depth recorded in steps of {:.1e}, both relative.\nOver all frames the color of half of the \
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

fn cameras_ui(ui: &mut Ui, report: &Report) {
    let tokens = Tokens::in_ui(ui);
    ui.heading("Cameras");
    Grid::new("cameras").num_columns(4).min_col_width(62.0).striped(true).spacing(Vec2::new(12.0, 4.0)).show(
        ui,
        |ui| {
            for (title, help) in [
                ("Name", "Name of the camera."),
                ("Kept", "Samples kept of all its pixels."),
                ("Still", "Share of its pixels that are the same over all frames."),
                ("Noise", "Measured color noise of still pixels, in 8-bit steps."),
            ] {
                ui.label(RichText::new(title).small().color(tokens.text_weak)).on_hover_text(help);
            }
            ui.end_row();
            let frames = report.foreground_per_frame.len().max(1) as u64;
            for (index, camera) in report.cameras.iter().enumerate() {
                ui.horizontal(|ui| {
                    let (dot, _) = ui.allocate_exact_size(Vec2::splat(8.0), Sense::hover());
                    ui.painter().circle_filled(dot.center(), 4.0, colormap::camera(index));
                    ui.label(short(&camera.name, 12)).on_hover_text(&camera.name);
                });
                ui.label(text::count(camera.background_kept + camera.foreground_kept));
                ui.label(text::percent(camera.background_pixels, camera.pixels / frames));
                ui.label(format!("{:.2}", camera.color_noise_steps)).on_hover_text(measured(camera));
                ui.end_row();
            }
        },
    );
}
