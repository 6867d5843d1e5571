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
    let levels = levels(&report.spans);
    let most = report.spans.iter().map(|span| span.samples).max().unwrap_or(1).max(1) as f32;
    let area = ui.available_rect_before_wrap();
    let height = ((area.height() - space::SMALL) / levels.len() as f32).clamp(6.0, 30.0);
    let left = area.left() + NAMES;
    let step = (area.width() - NAMES) / frames as f32;
    let (rect, response) = ui.allocate_exact_size(
        vec2(area.width(), (height * levels.len() as f32).min(area.height())),
        Sense::click_and_drag(),
    );
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, "Span map"));
    let map = SpanMap { painter: ui.painter_at(rect), left, step, most };
    let mut hovered = None;
    for (nth, (length, spans)) in levels.iter().enumerate() {
        let top = rect.top() + nth as f32 * height;
        let row = Rect::from_min_max(pos2(rect.left(), top), pos2(rect.right(), top + height));
        // Where rows are lower than type, some have no name to read; pointing at them gives it.
        let has_name = nth % (NAME / height).ceil() as usize == 0;
        map.name_ui(ui, row, response.id.with(length), *length, spans, has_name);
        hovered = map.spans_ui(row, spans, response.hover_pos()).or(hovered);
    }
    let now = left + (state.timeline.frame as f32 + 0.5) * step;
    map.painter.vline(now, rect.y_range(), Stroke::new(2.0, tokens.text));
    if let Some(at) = response.interact_pointer_pos().filter(|at| at.x >= left) {
        let frame = (((at.x - left) / step) as usize).min(frames - 1);
        if frame != state.timeline.frame {
            commands.push(Command::Time(TimeCommand::Frame(frame)));
        }
    }
    if let Some(SpanReport { span, samples }) = hovered {
        let words =
            format!("Frames {} to {}: {}", span.start + 1, span.end, model::count_of(samples, "sample"));
        response.on_hover_text_at_pointer(words);
    }
}

/// Where the span map draws frames, and how bright counts are.
struct SpanMap {
    painter: Painter,
    /// Where the first frame begins, points.
    left: f32,
    /// Width of a frame, points.
    step: f32,
    /// The largest number of samples of a span.
    most: f32,
}

impl SpanMap {
    /// The length of a row's spans, and how many samples they hold.
    fn name_ui(&self, ui: &Ui, row: Rect, id: Id, length: usize, spans: &[&SpanReport], is_shown: bool) {
        let total: u64 = spans.iter().map(|span| span.samples).sum();
        let name = counted(length, "frame");
        let words = format!("Samples stored for {name}: {}", model::count(total));
        ui.interact(row, id, Sense::hover())
            .widget_info(|| egui::WidgetInfo::labeled(egui::Role::Label, true, &words));
        if !is_shown {
            return;
        }
        let text = format!("{name}  {}", model::count(total));
        let font = egui::TextStyle::Small.resolve(ui.style());
        let color = Tokens::in_ui(ui).text_weak;
        self.painter.text(row.left_center(), Align2::LEFT_CENTER, text, font, color);
    }

    /// The spans of a row; gives the one under the pointer.
    fn spans_ui(&self, row: Rect, spans: &[&SpanReport], pointer: Option<Pos2>) -> Option<SpanReport> {
        let mut hovered = None;
        for span in spans {
            let from = self.left + span.span.start as f32 * self.step;
            let gap = if self.step > 3.0 { 1.0 } else { 0.0 };
            let to = self.left + span.span.end as f32 * self.step - gap;
            let cell = Rect::from_min_max(pos2(from, row.top() + 1.0), pos2(to, row.bottom() - 1.0));
            // The square root makes small counts differ from none.
            self.painter.rect_filled(cell, 2.0, sequential((span.samples as f32 / self.most).sqrt()));
            if pointer.is_some_and(|at| cell.contains(at)) {
                hovered = Some(**span);
            }
        }
        hovered
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
pub(crate) fn keys_ui(
    ui: &mut Ui,
    painter: &Painter,
    (bar, step): (Rect, f32),
    state: &State,
    commands: &mut Commands,
) {
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
        painter.add(Shape::convex_polygon(diamond(middle), color, Stroke::new(1.0, tokens.background)));
        if let Some(pointer) = response.interact_pointer_pos().filter(|_| response.dragged()) {
            let frame = ((pointer.x - bar.left()) / step).clamp(0.0, last as f32) as usize;
            if frame != key.frame {
                let key = Some(index);
                commands.push(Command::Path(PathCommand::change(&state.doc.path, key, |path| {
                    path.move_key(index, frame);
                })));
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

fn diamond(middle: Pos2) -> Vec<Pos2> {
    [(0.0, -HALF), (HALF, 0.0), (0.0, HALF), (-HALF, 0.0)].map(|(x, y)| middle + vec2(x, y)).to_vec()
}
