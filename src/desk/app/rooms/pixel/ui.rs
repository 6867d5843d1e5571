//! The explanation of one pixel: its verdict, which sample represents it, when it is stored, and the evidence of every camera.

use egui::{Align, Button, Label, Layout, Rect, RichText, ScrollArea, Sense, TextStyle, Ui, pos2, vec2};
use egui_extras::{Column, TableBuilder, TableRow};
use egui_material_icons::icons::{ICON_CONTENT_COPY, ICON_KEEP, ICON_KEEP_OFF, ICON_LOCATION_SEARCHING};

use crate::app::model::camera_text::CameraText;
use crate::app::model::command::{PixelCommand, ViewCommand};
use crate::app::model::look::Unit;
use crate::app::model::{Command, Commands, OpenScene, State};
use crate::app::rooms::pixel::state::Probed;
use crate::app::rooms::pixel::{
    self, DOUBTFUL, distance, is_same_point, number, ordered, own_sample, pending_verdict, rates,
    rule_of_votes, verdict,
};
use crate::app::theme::{Tokens, space};
use crate::app::widgets::{chips, dot, empty_ui, icon_button, note, weak};
use overlook_engine::plural::counted;
use overlook_engine::preprocess::inspect::CameraEvidence;
use overlook_engine::preprocess::pruning::Rule;

/// Width of the summary beside the table.
const SUMMARY: f32 = 264.0;

/// Width that the table needs at its full size, and the size of its letters in less.
const TABLE: f32 = 764.0;
const NARROW: f32 = 11.0;

/// Least width of the last column, which gets what the others leave: beyond that the table scrolls to the side.
const OWN_SAMPLE: f32 = 110.0;

/// Columns of the table: heading, width in points, and what it means.
const COLUMNS: [(&str, f32, &str); 8] = [
    ("Camera", 88.0, "Click a name to see the point there."),
    ("Visible", 128.0, "Whether the camera shows the same surface point, and if not, why."),
    ("Depth", 96.0, "Planar depth expected at the point, and the depth that the camera recorded there."),
    ("Depth error", 74.0, "Distance to the surface found there, in pixel footprints (px)."),
    ("Angle", 44.0, "Angle of incidence: between the line of sight and the surface's normal."),
    (
        "Density",
        54.0,
        "Footprint density: the paper's r with focal length and resolution, this pixel's longest side on the surface beside that camera's; its area where \
         longest sides do not decide.",
    ),
    ("Color", 44.0, "Largest difference of a color channel, in 8-bit steps."),
    (
        "Its own sample",
        150.0,
        "What became of that camera's own pixel. One that blends both sides of a depth edge, or whose normal is not known, yields to others \
         however dense it is.",
    ),
];

pub(crate) fn pixel_view_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    let shown = state.doc.scene.as_ref().zip(state.doc.probe.shown.as_ref());
    let Some((scene, probed)) = shown else {
        let text = if state.doc.probe.spot.is_some() {
            "No verdict here: the spot is a hole, filled or not, or its verdict is still being computed."
        } else {
            "Point at a pixel in the source or the live view. Click to pin it; every camera then says what it \
             knows about the point."
        };
        empty_ui(ui, ICON_LOCATION_SEARCHING, "No pixel selected", text, |_| {});
        return;
    };
    let area = ui.available_rect_before_wrap();
    let left = Rect::from_min_size(area.min, vec2(SUMMARY.min(area.width() * 0.3), area.height()));
    let right = Rect::from_min_max(pos2(left.right() + space::LARGE, area.top()), area.max);
    ui.scope_builder(egui::UiBuilder::new().max_rect(left).id_salt("summary"), |ui| {
        ScrollArea::vertical()
            .auto_shrink(false)
            .show(ui, |ui| summary_ui(ui, state, scene, probed, commands));
    });
    ui.scope_builder(egui::UiBuilder::new().max_rect(right).id_salt("evidence"), |ui| {
        ScrollArea::horizontal()
            .auto_shrink(false)
            .show(ui, |ui| table_ui(ui, state, scene, probed, commands));
    });
    ui.allocate_rect(area, Sense::hover());
}

fn summary_ui(ui: &mut Ui, state: &State, scene: &OpenScene, probed: &Probed, commands: &mut Commands) {
    let tokens = Tokens::in_ui(ui);
    ui.spacing_mut().item_spacing.y = 3.0;
    ui.horizontal(|ui| heading_ui(ui, state, scene, probed, commands));
    if let Some(explanation) = &probed.explanation {
        let sentence = verdict(&scene.cameras, explanation.verdict);
        let color = if explanation.verdict.is_kept() { tokens.text } else { tokens.warning };
        ui.add(Label::new(chips(ui, &sentence, &scene.cameras, &TextStyle::Body, color)).wrap());
        if explanation.is_doubtful {
            note(ui, DOUBTFUL);
        }
        if let Some(votes) = pixel::votes(explanation.votes, explanation.is_flying) {
            note(ui, votes).on_hover_text(rule_of_votes(&state.settings.pruning));
        }
        if explanation.chain.len() > 1 {
            let chain = pixel::chain(&scene.cameras, &explanation.chain);
            ui.add(Label::new(chips(ui, &chain, &scene.cameras, &TextStyle::Small, tokens.text_weak)).wrap())
                .on_hover_text("The witness chain: from this pixel to the sample that replaces it.");
        }
    } else {
        let text = if state.has_capture() {
            pending_verdict(state, state.doc.probe.pinned)
        } else {
            "This store does not say why samples were kept: open its capture, or make it again with a larger store.verdicts."
        };
        ui.add(Label::new(RichText::new(text).color(tokens.text_weak)).wrap());
    }
    if let Some(p) = probed.point_in_world {
        note(ui, format!("Point {:.3}, {:.3}, {:.3} {}", p.x, p.y, p.z, state.live.unit.name()));
    } else if probed.explanation.is_some() || !state.has_capture() {
        // Before the capture was searched, that is not known.
        note(ui, "Infinitely far, or without depth");
    }
    for value in &probed.values {
        note(ui, value);
    }
    spans_ui(ui, state, probed);
}

/// Which pixel it is, and what can be done with it.
fn heading_ui(ui: &mut Ui, state: &State, scene: &OpenScene, probed: &Probed, commands: &mut Commands) {
    let is_narrow = ui.available_width() < 0.9 * SUMMARY;
    let name = scene.cameras.get(probed.camera).map_or("", |camera| &camera.name);
    // Buttons first: the name gets what is left.
    ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
        let pinned = state.doc.probe.pinned;
        let (pin, pin_name) = if pinned { (ICON_KEEP_OFF, "Unpin pixel") } else { (ICON_KEEP, "Pin pixel") };
        let pin_help = "A pinned pixel stays selected while the pointer moves on (click a pixel, or P)";
        let copy_help = "Copy all of this as text (Ctrl+Shift+C)";
        if icon_button(ui, ICON_CONTENT_COPY, "Copy explanation", copy_help).clicked() {
            commands.push(Command::Pixel(PixelCommand::CopyExplanation));
        }
        if icon_button(ui, pin, pin_name, pin_help).clicked() {
            commands.push(Command::Pixel(PixelCommand::Pin(!pinned)));
        }
        ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
            dot(ui, probed.camera);
            let text = RichText::new(format!("{name}  {}, {}", probed.x, probed.y));
            ui.add(Label::new(if is_narrow { text.strong() } else { text.heading() }).truncate());
        });
    });
}

/// When the pixel is stored: one bar per span, and the frame shown.
fn spans_ui(ui: &mut Ui, state: &State, probed: &Probed) {
    let tokens = Tokens::in_ui(ui);
    let frames = state.frame_count().max(1);
    let has_depth =
        probed.explanation.as_ref().is_none_or(|explanation| explanation.verdict.rule != Rule::NoSample);
    if frames == 1 || !has_depth {
        // Nothing lasts in one frame, and what has no depth is nowhere replaced.
        return;
    }
    let caption = match &probed.spans {
        None if state.has_capture() => "When it is stored is known once the capture is pruned.".to_owned(),
        None => "A store plays frame by frame; open the capture to see when the pixel is stored.".to_owned(),
        Some(spans) if spans.is_empty() => {
            "Never stored: other samples replace it in every frame.".to_owned()
        }
        Some(spans) => {
            let stored: usize = spans.iter().map(|span| span.len()).sum();
            format!(
                "Stored for {stored} of {}, by {}",
                counted(frames, "frame"),
                counted(spans.len(), "sample")
            )
        }
    };
    note(ui, &caption);
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), 14.0), Sense::hover());
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, 3.0, tokens.raised);
    let step = rect.width() / frames as f32;
    let gap = if step > 4.0 { 1.0 } else { 0.0 };
    for span in probed.spans.iter().flatten() {
        let [start, end] = [span.start, span.end].map(|frame| rect.left() + frame as f32 * step);
        let bar = Rect::from_x_y_ranges(start..=end - gap, rect.y_range().shrink(2.0));
        painter.rect_filled(bar, 1.0, tokens.of_span(span.len(), frames));
    }
    let now = rect.left() + (state.timeline.frame as f32 + 0.5) * step;
    painter.vline(now, rect.y_range(), egui::Stroke::new(2.0, tokens.text));
    response.widget_info(|| {
        egui::WidgetInfo::labeled(egui::Role::Label, true, format!("Spans of the pixel: {caption}"))
    });
    response.on_hover_text(
        "When this pixel is stored: blue for all frames at once, green for several, orange for one; gray where another \
         camera's sample replaces it. The line is the frame shown.",
    );
}

fn table_ui(ui: &mut Ui, state: &State, scene: &OpenScene, probed: &Probed, commands: &mut Commands) {
    let Some(explanation) = &probed.explanation else { return };
    if explanation.evidence.is_empty() {
        let text = if explanation.verdict.rule == Rule::NoSample {
            "The pixel has no depth, so that it cannot be compared with other cameras."
        } else {
            "What each camera shows of the point, in numbers, needs the source pictures: open the capture."
        };
        weak(ui, text);
        return;
    }
    let narrow = ui.available_width() < TABLE;
    let row_height = if narrow { 16.0 } else { 19.0 };
    ui.spacing_mut().item_spacing.x = if narrow { 6.0 } else { 12.0 };
    ui.spacing_mut().interact_size.y = row_height;
    ui.spacing_mut().button_padding.y = 0.0;
    if narrow {
        for font in ui.style_mut().text_styles.values_mut() {
            font.size = font.size.min(NARROW);
        }
    }
    let order = ordered(&explanation.evidence, explanation.winner);
    let scale = if narrow { 0.86 } else { 1.0 };
    let mut table = TableBuilder::new(ui).id_salt("evidence").striped(true).auto_shrink(false);
    // Letters of several sizes stand on one middle.
    table = table.cell_layout(Layout::left_to_right(Align::Center));
    for (_, width, _) in &COLUMNS[..COLUMNS.len() - 1] {
        table = table.column(Column::initial(width * scale).at_least(24.0).clip(true).resizable(true));
    }
    let table =
        table.column(Column::remainder().at_least(OWN_SAMPLE).clip(true)).header(row_height, |mut header| {
            for (name, _, help) in COLUMNS {
                header.col(|ui| {
                    note(ui, name).on_hover_text(help);
                });
            }
        });
    // Only cameras in view are drawn: there may be hundreds.
    table.body(|body| {
        body.rows(row_height, order.len(), |mut row| {
            let evidence = &explanation.evidence[order[row.index()]];
            row_ui(&mut row, state, scene, evidence, explanation.winner == Some(evidence.camera), commands);
        });
    });
}

fn row_ui(
    line: &mut TableRow<'_, '_>,
    state: &State,
    scene: &OpenScene,
    row: &CameraEvidence,
    wins: bool,
    commands: &mut Commands,
) {
    line.col(|ui| {
        ui.horizontal(|ui| name_ui(ui, scene, row, wins, commands));
    });
    let tokens = *Tokens::of(state.dark);
    let tolerance = &state.settings.pruning;
    let same = is_same_point(row);
    let (sees, why) = pixel::sees(row);
    line.col(|ui| {
        let color = if same { tokens.text } else { tokens.text_weak };
        ui.label(RichText::new(sees).color(color)).on_hover_text(why);
    });
    let mut cell = |text: String, over: bool, help: String| {
        line.col(|ui| {
            let color = if over { tokens.warning } else { tokens.text };
            let label = ui.label(RichText::new(text).monospace().color(color));
            if !help.is_empty() {
                label.on_hover_text(help);
            }
        });
    };
    cell(depth_words(row), false, depth_help(row, state.live.unit));
    let off = row.plane_distance_footprints;
    let help = format!(
        "{} footprints of {}; the tolerance is {}.",
        distance(off),
        state.live.unit.length(row.footprint),
        tolerance.depth_tolerance
    );
    cell(distance(off), off > f64::from(tolerance.depth_tolerance), help);
    let turned = row.normal_angle_degrees > f64::from(tolerance.normal_tolerance);
    let angle =
        if row.incidence_degrees.is_nan() { "–".into() } else { format!("{:.0}°", row.incidence_degrees) };
    let help = format!(
        "The normals differ by {}°; the tolerance is {}°.",
        distance(row.normal_angle_degrees),
        tolerance.normal_tolerance
    );
    cell(angle, turned, help);
    let [paper_r, density] = rates(row);
    cell(density, false, format!("The paper's r, without focal length and resolution: {paper_r}."));
    let apart = row.color_difference_steps > f64::from(tolerance.color_tolerance);
    cell(distance(row.color_difference_steps), apart, String::new());
    line.col(|ui| {
        let own = own_sample(row).unwrap_or_else(|| CameraText::new("–"));
        let own = if wins && row.outcome.is_some() { own.words(", replaces it") } else { own };
        let color = if wins { tokens.accent } else { tokens.text_weak };
        ui.label(chips(ui, &own, &scene.cameras, &TextStyle::Body, color));
    });
}

/// The depth that is expected, and the one that was found.
fn depth_words(row: &CameraEvidence) -> String {
    match (row.depth_expected.is_nan(), row.depth_found.is_nan()) {
        (true, _) => "–".to_owned(),
        (_, true) => number(row.depth_expected),
        _ => format!("{} / {}", number(row.depth_expected), number(row.depth_found)),
    }
}

/// That help with the unit of the scene.
fn depth_help(row: &CameraEvidence, unit: Unit) -> String {
    let part = |name: &str, depth: f64| (!depth.is_nan()).then(|| format!("{name} {}", unit.length(depth)));
    let parts = [part("Expected", row.depth_expected), part("found", row.depth_found)];
    parts.into_iter().flatten().collect::<Vec<_>>().join(", ")
}

/// A button with the name of a row's camera: it shows the point in the camera's picture.
fn name_ui(ui: &mut Ui, scene: &OpenScene, row: &CameraEvidence, wins: bool, commands: &mut Commands) {
    let tokens = Tokens::in_ui(ui);
    let name = scene.cameras.get(row.camera).map_or("", |camera| &camera.name);
    dot(ui, row.camera);
    let text = RichText::new(name).color(if wins { tokens.accent } else { tokens.text });
    let button = Button::new(if wins { text.strong() } else { text }).small().frame(false);
    let help = "See the point in this camera's picture; Shift + click views from the camera";
    let response = ui.add(button).on_hover_text(help).accessible_name(format!("Go to the point in {name}"));
    if response.clicked() {
        if ui.input(|input| input.modifiers.shift) {
            commands.push(Command::View(ViewCommand::JumpTo(row.camera)));
        } else {
            commands.push(Command::Pixel(PixelCommand::ShowPointIn(row.camera)));
        }
    }
}
