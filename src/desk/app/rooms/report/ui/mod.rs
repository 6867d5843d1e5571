//! How many samples each rule pruned, for which camera; how well cameras agree; and how noisy the capture is.

mod causes;
mod pairs;

use egui::{Align, Color32, Layout, Rect, RichText, ScrollArea, Sense, Stroke, StrokeKind, Ui, vec2};
use egui_extras::Column;

use crate::app::camera_cues;
use crate::app::model::command::WindowCommand;
use crate::app::model::window::DockView;
use crate::app::model::{self, Accuracy, CameraMemory, Command, Commands, Content, State};
use crate::app::rooms::report::ui::causes::{alignment_ui, causes_ui};
use crate::app::rooms::report::ui::pairs::{agreement_ui, camera_table_ui, name_ui, order, replacements_ui};
use crate::app::theme::{Tokens, figure_style, space};
use crate::app::widgets::{note, one_line, weak};
use overlook_engine::plural::counted;
use overlook_engine::preprocess::diagnostics::{CameraReport, PixelAccount, Report};

pub(crate) fn report_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    let Some(report) = state.report() else {
        ui.add_space(space::MEDIUM);
        weak(ui, "The report appears here once the whole capture is pruned.");
        return;
    };
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        ui.set_max_width(ui.available_width() - space::MEDIUM);
        if let Some(words) = state.stale_note() {
            ui.label(RichText::new(words).color(Tokens::in_ui(ui).warning));
        }
        alignment_ui(ui, state, report, commands);
        let counts = |ui: &mut Ui| {
            rules_ui(ui, report);
            ui.add_space(space::LARGE);
            cameras_ui(ui, report);
            memory_ui(ui, state, &order(report));
        };
        let pairs = |ui: &mut Ui| {
            replacements_ui(ui, report);
            ui.add_space(space::LARGE);
            agreement_ui(ui, report);
            ui.add_space(space::LARGE);
        };
        if ui.available_width() < TWO_COLUMNS {
            counts(ui);
            pairs(ui);
        } else {
            ui.columns(2, |columns| {
                counts(&mut columns[0]);
                pairs(&mut columns[1]);
            });
        }
    });
}

/// Width from which on matrices stand beside the rest.
const TWO_COLUMNS: f32 = 720.0;

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

fn rules_ui(ui: &mut Ui, report: &Report) {
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
        let part = [count, report.samples_in];
        share_ui(ui, &words, model::count, part, tokens.static_over_time).on_hover_text(help);
    }
    let kept = [report.samples_kept, report.samples_in];
    share_ui(ui, "Kept", model::count, kept, tokens.moving).on_hover_text("Samples that stay.");
}

/// How much darker the rim of a bar is.
const RIM: f32 = 0.35;

/// Heights of a row with a share, and of its bar.
const SHARE_ROW: f32 = 28.0;
const SHARE_BAR: f32 = 6.0;

/// A name, a part in words and as a share of the whole, and a bar of that share below them.
fn share_ui(
    ui: &mut Ui,
    name: &str,
    words: fn(u64) -> String,
    [part, whole]: [u64; 2],
    color: Color32,
) -> egui::Response {
    let tokens = Tokens::in_ui(ui);
    let figure = format!("{}  {}", words(part), model::percent(part, whole));
    let share = part as f32 / whole.max(1) as f32;
    let size = vec2(ui.available_width(), SHARE_ROW);
    let (rect, response) = ui.allocate_exact_size(size, Sense::hover());
    let painter = ui.painter();
    let font = egui::TextStyle::Body.resolve(ui.style());
    painter.text(rect.left_top(), egui::Align2::LEFT_TOP, name, font.clone(), tokens.text);
    painter.text(rect.right_top(), egui::Align2::RIGHT_TOP, &figure, font, tokens.text_weak);
    let rail = Rect::from_min_max(
        egui::pos2(rect.left(), rect.bottom() - 2.0 - SHARE_BAR),
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

fn cameras_ui(ui: &mut Ui, report: &Report) {
    ui.heading("Cameras");
    let frames = report.foreground_per_frame.len().max(1) as u64;
    let columns = [
        ("Name", Column::remainder().clip(true), "Name of the camera."),
        ("Kept", Column::initial(66.0), "Samples kept of all its pixels."),
        ("Static", Column::initial(60.0), "Share of its pixels that are the same over all frames."),
        ("Noise", Column::initial(50.0), "Measured color noise of static pixels, in 8-bit steps."),
    ];
    camera_table_ui(ui, "cameras", &order(report), &columns, |ui, column, index| {
        let camera = &report.cameras[index];
        match column {
            0 => name_ui(ui, index, &camera.name, &camera.name),
            1 => ui.label(model::count(camera.background_kept + camera.foreground_kept)),
            2 => ui.label(model::percent(camera.background_pixels, camera.pixels / frames)),
            _ => ui.label(format!("{:.2}", camera.color_noise_steps)).on_hover_text(measured(camera)),
        };
    });
}

/// Height of a figure with its name, and the gaps between it and its note, and between that and the next figure.
const FIGURE: f32 = 38.0;
const GAP: f32 = 6.0;
const MARGIN: f32 = 14.0;

/// A figure with its name.
pub(crate) struct KeyFigure {
    pub name: &'static str,
    pub value: String,
    pub note: String,
    help: String,
}

/// The note on what is known of the frame that is shown, until the whole capture is pruned.
const THIS_FRAME: &str = "this frame";

/// The note on figures of other settings than those on the sliders.
const STALE: &str = "out of date";

/// Width of the bars beside the figures at most, points; as many again as figures need are theirs first.
const CAUSES_MOST: f32 = 640.0;

pub(crate) fn totals_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    let figures = figures(state);
    let account = state.report().map(Report::pixel_account).or(account_here(state));
    let (needed, spare) = widths(ui, &figures, state.has_capture());
    let bars = if account.is_some() { spare.min(CAUSES_MOST) } else { 0.0 };
    let more = (spare - bars) / figures.len().max(1) as f32;
    ui.horizontal_centered(|ui| {
        ui.spacing_mut().item_spacing.x = 0.0;
        for (figure, width) in figures.iter().zip(needed) {
            let size = vec2(width + more, FIGURE);
            ui.allocate_ui_with_layout(size, Layout::top_down(Align::Min), |ui| {
                figure_ui(ui, figure, state.is_stale());
            });
        }
        let Some(account) = account else { return };
        ui.allocate_ui_with_layout(vec2(bars, FIGURE), Layout::top_down(Align::Min), |ui| {
            if causes_ui(ui, &account).is_some_and(|bars| bars.clicked()) {
                commands.push(Command::Window(WindowCommand::OpenView(DockView::Report)));
            }
        });
    });
}

/// What each figure needs, with room for saying that it is out of date where it may become so, and what is left beside them.
fn widths(ui: &Ui, figures: &[KeyFigure], may_be_stale: bool) -> (Vec<f32>, f32) {
    let styles = (figure_style().resolve(ui.style()), egui::TextStyle::Small.resolve(ui.style()));
    let width_of = |text: &str, font: &egui::FontId| {
        ui.painter().layout_no_wrap(text.to_owned(), font.clone(), Color32::PLACEHOLDER).size().x
    };
    let stale = if may_be_stale { width_of(STALE, &styles.1) } else { 0.0 };
    let width = |figure: &KeyFigure| {
        let note = width_of(&figure.note, &styles.1).max(stale);
        let line = width_of(&figure.value, &styles.0) + GAP + note;
        line.max(width_of(figure.name, &styles.1)) + MARGIN
    };
    let needed: Vec<f32> = figures.iter().map(width).collect();
    let spare = (ui.available_width() - needed.iter().sum::<f32>()).max(0.0);
    (needed, spare)
}

fn figure_ui(ui: &mut Ui, figure: &KeyFigure, stale: bool) {
    let tokens = Tokens::in_ui(ui);
    ui.set_min_width(ui.available_width());
    ui.set_max_width(ui.available_width() - MARGIN);
    ui.spacing_mut().item_spacing = vec2(GAP, 1.0);
    let (words, color, note_color, more) = if stale {
        let more =
            " A setting was changed since; the number is out of date until the capture is pruned again.";
        (STALE, tokens.text_weak, tokens.warning, more)
    } else {
        (figure.note.as_str(), tokens.text, tokens.text_weak, "")
    };
    let shown = ui.vertical(|ui| {
        note(ui, figure.name);
        ui.horizontal(|ui| {
            ui.label(RichText::new(&figure.value).text_style(figure_style()).color(color));
            one_line(ui, words, note_color);
        });
    });
    shown.response.on_hover_text(format!("{}{more}", figure.help));
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
    let cut = state.cut_scene();
    let edits = match cut {
        Some(_) => state.with_edits(),
        None if state.doc.edits.list.is_idle() => String::new(),
        None => ", before edits".to_owned(),
    };
    let figure = |name, value_and_note: Option<[String; 2]>, help: &str| {
        let [value, note] = value_and_note.unwrap_or_else(|| ["…".to_owned(), String::new()]);
        let first =
            if note == THIS_FRAME { "Of the frame that is shown, until all are pruned. " } else { "" };
        KeyFigure { name, value, note, help: format!("{first}{help}") }
    };
    let memory_note = |report: &Report| match state.content() {
        Some(Content::Store { bytes, .. }) => format!("file {}", model::bytes(*bytes)),
        _ if report.bytes_memory > report.bytes_raw => format!("raw {}", model::bytes(report.bytes_raw)),
        _ => format!("of {}", model::bytes(report.bytes_raw)),
    };
    let mut figures = vec![
        figure(
            "Samples kept",
            report
                .map(|r| {
                    let kept = cut.map_or(r.samples_kept, |cut| cut.before.saturating_sub(cut.deleted));
                    [model::count(kept), format!("of {}{edits}", model::count(r.samples_in))]
                })
                .or(here.map(|account| of_frame(model::count(account.kept)))),
            "The samples kept, of all pixels of all frames of all cameras.",
        ),
        figure(
            "Dropped",
            account.map(|account| {
                let note = if report.is_some() { String::new() } else { THIS_FRAME.to_owned() };
                [model::percent(account.not_kept(), account.pixels), note]
            }),
            &account.map_or_else(String::new, |account| dropped_help(&account)),
        ),
        figure(
            "Memory",
            report
                .map(|r| [model::bytes(cut.map_or(r.bytes_memory, |cut| cut.bytes)), memory_note(r)])
                .or(bytes_here.map(|bytes| of_frame(model::bytes(bytes)))),
            "The kept samples in memory, of all pixels as 8-bit color and 32-bit depth. A sample in memory has normals and its place as well, so that \
             few dropped pixels can make it more; a saved store is smaller.",
        ),
    ];
    // What nobody can know here has no place.
    if state.doc.accuracy.is_some() || state.has_truth() {
        figures.push(accuracy_figure(state.doc.accuracy, figure));
    }
    let told = if state.is_stale() { Vec::new() } else { state.differences() };
    for difference in told {
        let figure = figures.iter_mut().find(|figure| figure.name == difference.name);
        if let (Some(figure), Some(change)) = (figure, difference.change) {
            let before = &difference.before;
            figure.help = format!("{} {before} before the last change of settings: {change}.", figure.help);
            change.split(" (").next().unwrap_or_default().clone_into(&mut figure.note);
        }
    }
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
    figure: impl Fn(&'static str, Option<[String; 2]>, &str) -> KeyFigure,
) -> KeyFigure {
    let Some(accuracy) = accuracy else {
        let help = "Accuracy is measured at the viewpoints whose true picture is known, once the scene is pruned and rests: not while it \
                    plays, nor after Esc.";
        return figure("Accuracy", None, help);
    };
    let Accuracy { psnr_db, unpruned_psnr_db, views } = accuracy;
    let help = format!(
        "Mean PSNR at {} whose true picture is known, over the pixels that samples reached: charts fill holes first \
         and count all. With nothing pruned it is {unpruned_psnr_db:.1} dB.",
        counted(views, "viewpoint")
    );
    let change = format!("{:+.2} dB vs unpruned", psnr_db - unpruned_psnr_db);
    figure("Accuracy", Some([format!("{psnr_db:.1} dB"), change]), &help)
}

/// What the samples of each camera take, where they are in memory: a store plays from disk.
fn memory_ui(ui: &mut Ui, state: &State, order: &[usize]) {
    let (Some(scene), Some(cameras)) = (&state.doc.scene, &state.doc.memory) else { return };
    let bytes = |camera: &CameraMemory| camera.lasting_bytes + camera.frame_bytes;
    let total: u64 = cameras.iter().map(bytes).sum();
    ui.add_space(space::LARGE);
    ui.heading("Memory");
    note(ui, format!("{} of samples in memory, by camera.", model::bytes(total)));
    for &index in order {
        let Some((memory, camera)) = cameras.get(index).zip(scene.cameras.get(index)) else { continue };
        let help = format!(
            "{}. Stored for several frames: {}, for one: {}.",
            model::count_of(memory.samples, "sample"),
            model::bytes(memory.lasting_bytes),
            model::bytes(memory.frame_bytes)
        );
        let (part, color) = ([bytes(memory), total], camera_cues::color(index));
        share_ui(ui, &camera.name, model::bytes, part, color).on_hover_text(help);
    }
    ui.add_space(space::LARGE);
}
