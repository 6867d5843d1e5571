//! Time: play, scrub, step, and how much of each frame does not hold for all frames.

use egui::{
    Align, Align2, CursorIcon, DragValue, Id, Layout, Painter, Pos2, Rect, RichText, Sense, Shape, Stroke,
    Ui, pos2, vec2,
};
use egui_material_icons::icons::{
    ICON_BOOKMARK_ADD, ICON_BOOKMARK_REMOVE, ICON_FIRST_PAGE, ICON_LAST_PAGE, ICON_PAUSE, ICON_PLAY_ARROW,
    ICON_REPEAT, ICON_SKIP_NEXT, ICON_SKIP_PREVIOUS, ICON_SWAP_HORIZ, ICON_TIMELINE,
};

use crate::app::colormap::sequential;
use crate::app::model::command::PathCommand;
use crate::app::model::{self, Command, Commands, State};
use crate::app::rooms::timeline::{TimeCommand, Timeline};
use crate::app::theme::{Tokens, space};
use crate::app::widgets::{empty_ui, icon_button, note, weak};
use overlook_engine::plural::counted;
use overlook_engine::preprocess::diagnostics::SpanReport;

/// Fewer frames than this share of those that are asked for are told.
const FALLS_SHORT: f32 = 0.9;

pub(crate) fn timeline_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    ui.add_enabled_ui(state.doc.scene.is_some(), |ui| {
        ui.horizontal(|ui| controls_ui(ui, state, commands));
        strip_ui(ui, state, commands);
    });
}

fn controls_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    let mut timeline = state.timeline.clone();
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
    let frame = format!("Frame {} of {}", timeline.frame + 1, state.frame_count().max(1));
    let label = ui.label(RichText::new(frame).strong());
    if let Some(number) = state.frame_number() {
        label.on_hover_text(format!("The capture calls it frame {number}."));
    }
    ui.add_space(space::LARGE);
    let suffix = rate_text(&timeline);
    let rate = DragValue::new(&mut timeline.frames_per_second).range(1.0..=120.0).speed(0.25);
    ui.add(rate.max_decimals(0).suffix(suffix))
        .on_hover_text("Frames per second of playback")
        .accessible_name("Frames per second");
    loop_ui(ui, &mut timeline, state.frame_count());
    if timeline != state.timeline {
        commands.push(Command::Time(TimeCommand::Change(Box::new(timeline))));
    }
    ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
        if let Some(counts) = foreground(state) {
            let here = counts.get(state.timeline.frame).copied().unwrap_or(0);
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

/// The range that is played, of so many frames, and how its ends are met.
fn loop_ui(ui: &mut Ui, timeline: &mut Timeline, frames: usize) {
    ui.add_space(space::SMALL);
    for (icon, name, keys, begins) in
        [(ICON_FIRST_PAGE, "Loop from here", "(I)", true), (ICON_LAST_PAGE, "Loop to here", "(O)", false)]
    {
        if icon_button(ui, icon, name, &format!("{name} {keys}")).clicked() {
            timeline.range = Some(timeline.range_here(begins, frames));
        }
    }
    if let Some([first, last]) = timeline.range {
        let text = format!("{} – {}", first + 1, last + 1);
        let clear = ui.button(text).accessible_name("Loop over all frames");
        if clear.on_hover_text("Loop over all frames again (Shift+I)").clicked() {
            timeline.range = None;
        }
    }
    let (icon, name) = if timeline.markers.contains(&timeline.frame) {
        (ICON_BOOKMARK_REMOVE, "Remove marker")
    } else {
        (ICON_BOOKMARK_ADD, "Add marker")
    };
    let help = format!("{name} (Shift+M); Ctrl+Left and Ctrl+Right go from marker to marker");
    if icon_button(ui, icon, name, &help).clicked() {
        timeline.toggle_marker();
    }
    let (icon, name) = if timeline.ping_pong {
        (ICON_SWAP_HORIZ, "Play around the ends")
    } else {
        (ICON_REPEAT, "Play back and forth")
    };
    if icon_button(ui, icon, name, name).clicked() {
        timeline.ping_pong ^= true;
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
            painter.vline(x, range.y_range(), Stroke::new(2.0, tokens.text_weak));
        }
    }
    let here = column(state.timeline.frame);
    painter.rect_filled(here.expand2(vec2((1.5 - step / 2.0).max(0.0), 0.0)), 2.0, tokens.accent_faint);
    if let Some(counts) = foreground(state) {
        bars(&painter, state, counts, column);
    }
    let x = here.center().x;
    painter.vline(x, rect.y_range(), Stroke::new(2.0, tokens.accent));
    for marker in &state.timeline.markers {
        let top = pos2(column(*marker).center().x, rect.top());
        let corners = vec![top + vec2(-5.0, 0.0), top + vec2(5.0, 0.0), top + vec2(0.0, 8.0)];
        let edge = Stroke::new(1.0, tokens.background);
        painter.add(Shape::convex_polygon(corners, tokens.text, edge));
    }
    let frame_at = |at: Pos2| ((at.x - rect.left()) / step).clamp(0.0, frames as f32 - 1.0) as usize;
    let held = response.interact_pointer_pos().filter(|_| response.is_pointer_button_down_on());
    if let Some(frame) = held.map(frame_at).filter(|frame| *frame != state.timeline.frame) {
        commands.push(Command::Time(TimeCommand::Frame(frame)));
    }
    // What is on top is taken hold of first.
    keys_ui(ui, &painter, (rect, step), state, commands);
    if let Some(frame) = response.hover_pos().map(frame_at) {
        let count = foreground(state).and_then(|counts| counts.get(frame));
        let kept =
            count.map_or(String::new(), |count| format!(": {} time-varying samples", model::count(*count)));
        response.on_hover_text_at_pointer(format!("Frame {}{kept}", frame + 1));
    }
}

/// Room for the names of the rows.
const NAMES: f32 = 128.0;

/// Height of a line of names, points.
const NAME: f32 = 14.0;

pub(crate) fn time_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    let tokens = Tokens::in_ui(ui);
    let frames = state.frame_count();
    let Some(report) = state.report().filter(|report| !report.spans.is_empty() && frames > 0) else {
        let text = "The spans of samples are known once the whole capture is pruned.";
        empty_ui(ui, ICON_TIMELINE, "No spans yet", text, |_| {});
        return;
    };
    ui.horizontal_wrapped(|ui| {
        let caption =
            "Samples by the span of frames they are stored for; lighter is more. Click to go to a frame.";
        note(ui, caption);
        if state.is_stale() {
            ui.label(RichText::new("Out of date.").small().color(tokens.warning));
        }
    });
    spans_ui(ui, state, &report.spans, commands);
}

/// The map of spans: a row for each length, and a cell for each span.
fn spans_ui(ui: &mut Ui, state: &State, spans: &[SpanReport], commands: &mut Commands) {
    let (levels, frames) = (levels(spans), state.frame_count());
    let most = spans.iter().map(|span| span.samples).max().unwrap_or(1).max(1) as f32;
    let area = ui.available_rect_before_wrap();
    let height = ((area.height() - space::SMALL) / levels.len() as f32).clamp(6.0, 30.0);
    let left = area.left() + NAMES;
    let step = (area.width() - NAMES) / frames as f32;
    let gap = if step > 3.0 { 1.0 } else { 0.0 };
    let size = vec2(area.width(), (height * levels.len() as f32).min(area.height()));
    let (rect, response) = ui.allocate_exact_size(size, Sense::click_and_drag());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, "Span map"));
    let painter = ui.painter_at(rect);
    let mut hovered = None;
    for (nth, (length, spans)) in levels.iter().enumerate() {
        let top = rect.top() + nth as f32 * height;
        let row = Rect::from_min_max(pos2(rect.left(), top), pos2(rect.right(), top + height));
        // Where rows are lower than type, some have no name to read; pointing at them gives it.
        let has_name = nth % (NAME / height).ceil() as usize == 0;
        let samples = spans.iter().map(|span| span.samples).sum();
        row_name_ui(ui, &painter, row, *length, samples, has_name);
        for SpanReport { span, samples } in spans {
            let [from, to] = [span.start, span.end].map(|frame| left + frame as f32 * step);
            let cell = Rect::from_min_max(pos2(from, row.top() + 1.0), pos2(to - gap, row.bottom() - 1.0));
            // The square root makes small counts differ from none.
            painter.rect_filled(cell, 2.0, sequential((*samples as f32 / most).sqrt()));
            if response.hover_pos().is_some_and(|at| cell.contains(at)) {
                hovered = Some((*span, *samples));
            }
        }
    }
    let now = left + (state.timeline.frame as f32 + 0.5) * step;
    painter.vline(now, rect.y_range(), Stroke::new(2.0, Tokens::in_ui(ui).text));
    if let Some(at) = response.interact_pointer_pos().filter(|at| at.x >= left) {
        let frame = (((at.x - left) / step) as usize).min(frames - 1);
        if frame != state.timeline.frame {
            commands.push(Command::Time(TimeCommand::Frame(frame)));
        }
    }
    if let Some((span, samples)) = hovered {
        let words =
            format!("Frames {} to {}: {}", span.start + 1, span.end, model::count_of(samples, "sample"));
        response.on_hover_text_at_pointer(words);
    }
}

/// The length of a row's spans, and how many samples they hold.
fn row_name_ui(ui: &Ui, painter: &Painter, row: Rect, length: usize, samples: u64, is_shown: bool) {
    let (name, total) = (counted(length, "frame"), model::count(samples));
    let words = format!("Samples stored for {name}: {total}");
    ui.interact(row, ui.scope_id().with(("row of spans", length)), Sense::hover())
        .widget_info(|| egui::WidgetInfo::labeled(egui::Role::Label, true, &words));
    if is_shown {
        let font = egui::TextStyle::Small.resolve(ui.style());
        let color = Tokens::in_ui(ui).text_weak;
        painter.text(row.left_center(), Align2::LEFT_CENTER, format!("{name}  {total}"), font, color);
    }
}

/// Spans by their length, longest first.
fn levels(spans: &[SpanReport]) -> Vec<(usize, Vec<&SpanReport>)> {
    let mut levels = std::collections::BTreeMap::<_, Vec<_>>::new();
    for span in spans {
        levels.entry(std::cmp::Reverse(span.span.len())).or_default().push(span);
    }
    levels.into_iter().map(|(length, spans)| (length.0, spans)).collect()
}

/// Half the width of a key, and how far around its middle it is taken hold of, points.
const HALF: f32 = 5.5;
const REACH: f32 = 8.0;

/// Draws the keys into the bar, over what it shows, and lets them be dragged. The columns of frames are `step` wide.
fn keys_ui(ui: &mut Ui, painter: &Painter, (bar, step): (Rect, f32), state: &State, commands: &mut Commands) {
    let tokens = Tokens::in_ui(ui);
    let last = state.frame_count().saturating_sub(1);
    let keys = &state.doc.path.keys;
    for (index, key) in keys.iter().enumerate() {
        // The last of the keys at one frame lies above and is taken first.
        if keys[index + 1..].iter().any(|later| later.frame.min(last) == key.frame.min(last)) {
            continue;
        }
        let x = bar.left() + (key.frame.min(last) as f32 + 0.5) * step;
        let middle = pos2(x, bar.bottom() - HALF - 1.0);
        let area = Rect::from_center_size(middle, vec2(2.0 * REACH, 2.0 * REACH)).intersect(bar);
        let response = ui.interact(area, Id::unique(("key of the path", index)), Sense::click_and_drag());
        let name = format!("Key {} on the time bar", index + 1);
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, &name));
        let is_held = response.dragged() || response.hovered();
        let color = if is_held { tokens.accent } else { tokens.warning };
        let corners = [(0.0, -HALF), (HALF, 0.0), (0.0, HALF), (-HALF, 0.0)];
        let corners = corners.map(|(x, y)| middle + vec2(x, y)).to_vec();
        painter.add(Shape::convex_polygon(corners, color, Stroke::new(1.0, tokens.background)));
        if let Some(pointer) = response.interact_pointer_pos().filter(|_| response.dragged()) {
            let frame = ((pointer.x - bar.left()) / step).clamp(0.0, last as f32) as usize;
            if frame != key.frame {
                let path = &state.doc.path;
                let moved = PathCommand::change(path, Some(index), |path| path.move_key(index, frame));
                commands.push(Command::Path(moved));
            }
        }
        if response.clicked() {
            commands.push(Command::Path(PathCommand::GoToKey(index)));
        }
        let help = format!(
            "Key {} at frame {}. Drag it to another frame; a click goes there.",
            index + 1,
            key.frame + 1
        );
        response.on_hover_cursor(CursorIcon::ResizeHorizontal).on_hover_text(help);
    }
}
