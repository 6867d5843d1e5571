//! Time: play, scrub, step, and how much of each frame does not hold for all frames.

use egui::{Align, DragValue, Layout, Painter, Rect, RichText, Sense, Ui, pos2, vec2};
use egui_material_icons::icons::{
    ICON_BOOKMARK_ADD, ICON_BOOKMARK_REMOVE, ICON_FIRST_PAGE, ICON_LAST_PAGE, ICON_PAUSE, ICON_PLAY_ARROW,
    ICON_REPEAT, ICON_SKIP_NEXT, ICON_SKIP_PREVIOUS, ICON_SWAP_HORIZ,
};

use super::timeline_keys::keys_ui;
use crate::app::model;
use crate::app::model::{Command, Commands, State};
use crate::app::rooms::timeline::model::{TimeCommand, Timeline};
use crate::app::theme::{Tokens, space};
use crate::app::widgets::{icon_button, weak};

/// Fewer frames than this share of those that are asked for are told.
const FALLS_SHORT: f32 = 0.9;

pub(crate) fn timeline_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    ui.add_enabled_ui(state.doc.scene.is_some(), |ui| {
        ui.horizontal(|ui| controls_ui(ui, state, commands));
        strip_ui(ui, state, commands);
    });
}

fn controls_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    let timeline = &state.timeline;
    if icon_button(ui, ICON_SKIP_PREVIOUS, "Step back", "Step back (,)").clicked() {
        commands.push(Command::Time(TimeCommand::Step(-1)));
    }
    let (icon, name) = if timeline.playing { (ICON_PAUSE, "Pause") } else { (ICON_PLAY_ARROW, "Play") };
    if icon_button(ui, icon, name, &format!("{name} (Space)")).clicked() {
        commands.push(Command::Time(TimeCommand::TogglePlay));
    }
    if icon_button(ui, ICON_SKIP_NEXT, "Step forward", "Step forward (.)").clicked() {
        commands.push(Command::Time(TimeCommand::Step(1)));
    }
    ui.add_space(space::SMALL);
    let number = state.doc.scene.as_ref().and_then(|scene| scene.frame_numbers.get(timeline.frame));
    let frame = format!("Frame {} of {}", timeline.frame + 1, state.frame_count().max(1));
    let label = ui.label(RichText::new(frame).strong());
    if let Some(number) = number {
        label.on_hover_text(format!("The capture calls it frame {number}."));
    }
    ui.add_space(space::LARGE);
    let mut rate = timeline.frames_per_second;
    let drag =
        DragValue::new(&mut rate).range(1.0..=120.0).speed(0.25).max_decimals(0).suffix(rate_text(timeline));
    let drag =
        ui.add(drag).on_hover_text("Frames per second of playback").accessible_name("Frames per second");
    if drag.changed() {
        commands
            .push(Command::Time(TimeCommand::change(timeline, |timeline| timeline.frames_per_second = rate)));
    }
    loop_ui(ui, state, commands);
    ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
        if let Some(counts) = foreground(state) {
            let here = counts.get(timeline.frame).copied().unwrap_or(0);
            weak(ui, format!("{} time-varying samples", model::count(here)));
        }
    });
}

/// Behind the number of frames a second: how many are really shown, where these are fewer.
fn rate_text(timeline: &Timeline) -> String {
    let shown = timeline.shown.per_second().filter(|_| timeline.playing);
    let falls_short = shown.filter(|shown| *shown < FALLS_SHORT * timeline.frames_per_second);
    falls_short.map_or_else(|| " fps".to_owned(), |shown| format!(" fps (showing {shown:.0})"))
}

/// The range that is played, and how its ends are met.
fn loop_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    let (timeline, frames) = (&state.timeline, state.frame_count());
    ui.add_space(space::SMALL);
    let here = timeline.frame;
    for (icon, name, help, range) in [
        (
            ICON_FIRST_PAGE,
            "Loop from here",
            "Loop from here (I)",
            timeline.range_from(Some(here), None, frames),
        ),
        (ICON_LAST_PAGE, "Loop to here", "Loop to here (O)", timeline.range_from(None, Some(here), frames)),
    ] {
        if icon_button(ui, icon, name, help).clicked() {
            commands
                .push(Command::Time(TimeCommand::change(timeline, |timeline| timeline.range = Some(range))));
        }
    }
    if let Some([first, last]) = timeline.range {
        let text = format!("{} – {}", first + 1, last + 1);
        let clear = ui.button(text).accessible_name("Loop over all frames");
        if clear.on_hover_text("Loop over all frames again (Shift+I)").clicked() {
            commands.push(Command::Time(TimeCommand::change(timeline, |timeline| timeline.range = None)));
        }
    }
    let (icon, name) = if timeline.markers.contains(&here) {
        (ICON_BOOKMARK_REMOVE, "Remove marker")
    } else {
        (ICON_BOOKMARK_ADD, "Add marker")
    };
    if icon_button(
        ui,
        icon,
        name,
        &format!("{name} (Shift+M); Ctrl+Left and Ctrl+Right go from marker to marker"),
    )
    .clicked()
    {
        commands.push(Command::Time(TimeCommand::change(timeline, Timeline::toggle_marker)));
    }
    let (icon, name) = if timeline.ping_pong {
        (ICON_SWAP_HORIZ, "Play around the ends")
    } else {
        (ICON_REPEAT, "Play back and forth")
    };
    if icon_button(ui, icon, name, name).clicked() {
        commands.push(Command::Time(TimeCommand::change(timeline, |timeline| timeline.ping_pong ^= true)));
    }
}

fn foreground(state: &State) -> Option<&[u64]> {
    state.report().map(|report| report.foreground_per_frame.as_slice())
}

/// A bar for the time-varying samples of each frame, within its column.
fn bars(painter: &Painter, state: &State, counts: &[u64], column: impl Fn(usize) -> Rect) {
    let tokens = Tokens::of(state.dark);
    let highest = counts.iter().copied().max().unwrap_or(0).max(1) as f32;
    let color = if state.is_stale() { tokens.invalid } else { tokens.moving };
    for (frame, &count) in counts.iter().enumerate() {
        let column = column(frame);
        let gap = if column.width() > 4.0 { 1.0 } else { 0.0 };
        let mut bar = column.shrink2(vec2(gap / 2.0, 0.0));
        bar.min.y = bar.max.y - (column.height() - 6.0) * count as f32 / highest;
        let current = frame == state.timeline.frame;
        painter.rect_filled(bar, 0.0, if current { color } else { color.gamma_multiply(0.45) });
    }
}

fn strip_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    let tokens = Tokens::in_ui(ui);
    let size = vec2(ui.available_width(), ui.available_height() - 2.0);
    let (rect, response) = ui.allocate_exact_size(size, Sense::click_and_drag());
    let frames = state.frame_count().max(1);
    response.widget_info(|| {
        egui::WidgetInfo::slider(state.doc.scene.is_some(), state.timeline.frame as f64, "Timeline")
    });
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, f32::from(space::RADIUS), tokens.background);
    let step = rect.width() / frames as f32;
    let column = |frame: usize| {
        let left = rect.left() + frame as f32 * step;
        Rect::from_min_max(pos2(left, rect.top()), pos2(left + step, rect.bottom()))
    };
    if state.doc.scene.is_none() {
        return;
    }
    if state.timeline.range.is_some() {
        let [first, last] = state.timeline.played(frames);
        let range = Rect::from_min_max(column(first).min, column(last).max);
        painter.rect_filled(range, 2.0, tokens.raised_hovered);
        for x in [range.left(), range.right()] {
            painter.vline(x, range.y_range(), egui::Stroke::new(2.0, tokens.text_weak));
        }
    }
    let here = column(state.timeline.frame);
    painter.rect_filled(here.expand2(vec2((1.5 - step / 2.0).max(0.0), 0.0)), 2.0, tokens.accent_faint);
    if let Some(counts) = foreground(state) {
        bars(&painter, state, counts, column);
    }
    let x = here.center().x;
    painter.vline(x, rect.y_range(), egui::Stroke::new(2.0, tokens.accent));
    for marker in &state.timeline.markers {
        let top = pos2(column(*marker).center().x, rect.top());
        let corners = vec![top + vec2(-5.0, 0.0), top + vec2(5.0, 0.0), top + vec2(0.0, 8.0)];
        let edge = egui::Stroke::new(1.0, tokens.background);
        painter.add(egui::Shape::convex_polygon(corners, tokens.text, edge));
    }
    if let Some(pointer) = response.interact_pointer_pos().filter(|_| response.is_pointer_button_down_on()) {
        let frame = ((pointer.x - rect.left()) / step).clamp(0.0, frames as f32 - 1.0) as usize;
        if frame != state.timeline.frame {
            commands.push(Command::Time(TimeCommand::Frame(frame)));
        }
    }
    // What is on top is taken hold of first.
    keys_ui(ui, &painter, (rect, step), state, commands);
    if let Some(pointer) = response.hover_pos() {
        let frame = ((pointer.x - rect.left()) / step).clamp(0.0, frames as f32 - 1.0) as usize;
        let count = foreground(state).and_then(|counts| counts.get(frame));
        let kept =
            count.map_or(String::new(), |count| format!(": {} time-varying samples", model::count(*count)));
        response.on_hover_text_at_pointer(format!("Frame {}{kept}", frame + 1));
    }
}
