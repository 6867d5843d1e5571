//! Keys that work anywhere in the window, except while text is typed.

use std::collections::HashSet;

use egui::{Key, Modifiers};
use glam::DVec3;
use overlook_engine::edits::Action;

use crate::app::model::command::{
    EditCommand, EditTool, EditTools, FileCommand, KeptViewCommand, PathCommand, PixelCommand, SourceCommand,
    ViewCommand, WindowCommand,
};
use crate::app::model::purpose::{Purpose, ShareCommand};
use crate::app::model::window::{Area, CommandPalette, HelpPage, Workspace};
use crate::app::model::{Command, Commands, State};
use crate::app::rooms::timeline::{TimeCommand, Timeline};

/// Distance flown per second, in pivot distances.
const FLY_PER_SECOND: f64 = 0.6;

const NUMBERS: [Key; 9] =
    [Key::Num1, Key::Num2, Key::Num3, Key::Num4, Key::Num5, Key::Num6, Key::Num7, Key::Num8, Key::Num9];

/// Turns keys into commands.
pub(crate) fn commands(ui: &egui::Ui, state: &State, commands: &mut Commands) {
    let ctx = ui.ctx();
    let inspector = &state.inspector;
    let typing = state.typed_path.is_some()
        || state.share.is_open
        || state.doc.charts.question.is_some()
        || inspector.palette.is_some();
    let edits = edits_text(ctx);
    let asks = state.is_asking() || inspector.help.is_some();
    // An open menu takes the key, and so does a number that is being typed, which gets its earlier value back.
    if !egui::Popup::is_any_open(ctx)
        && (asks || !edits)
        && ctx.input_mut(|input| input.consume_key(Modifiers::NONE, Key::Escape))
    {
        commands.push(Command::Escape);
    }
    commands.extend(pressed(ctx, keys_anywhere(state)));
    if ctx.input_mut(|input| input.consume_key(Modifiers::COMMAND, Key::Q)) {
        ctx.send_viewport_cmd(egui::ViewportCommand::Close);
    }
    if edits && ctx.input(|input| input.key_pressed(Key::Escape)) {
        let frame = ctx.cumulative_frame_nr();
        ctx.data_mut(|data| data.insert_temp(given_up_id(), frame));
    }
    // What is typed is undone by the field it is typed into.
    if state.doc.scene.is_some() && !typing && !edits {
        commands.extend(pressed(ctx, undo_keys()));
    }
    let held = held_keys(ctx);
    if typing || edits || state.doc.scene.is_none() {
        return;
    }
    let number_or_clipboard = |event: &egui::Event| number_key(event).or_else(|| clipboard(event));
    commands
        .extend(ctx.input(|input| input.events.iter().filter_map(number_or_clipboard).collect::<Vec<_>>()));
    let is_focused = ctx.egui_wants_keyboard_input();
    let mut keys =
        [window_keys(state), axis_keys(), time_keys(state), edit_keys(state), other_keys(state)].concat();
    keys.retain(|(modifiers, key, _)| !(is_focused && is_for_focused_button(*modifiers, *key)));
    commands.extend(pressed(ctx, keys));
    if is_focused {
        return;
    }
    if let Some(steps) = ctx.input(|input| flight(input, &held)) {
        commands.push(Command::View(ViewCommand::Fly(steps * state.live.fly_speed)));
        ctx.request_repaint();
    }
}

/// What is held, a key, and what it does.
type Bound = (Modifiers, Key, Command);

/// What the pressed ones of the keys do. With fewer modifiers a key is consumed whatever else is held: those with more go first.
fn pressed(ctx: &egui::Context, keys: Vec<Bound>) -> Vec<Command> {
    ctx.input_mut(|input| {
        let pressed = keys.into_iter().filter(|(modifiers, key, _)| input.consume_key(*modifiers, *key));
        pressed.map(|(.., command)| command).collect()
    })
}

/// Whether a key belongs to a button or a slider while it has the focus: a letter, an arrow or what presses it, by itself.
fn is_for_focused_button(modifiers: Modifiers, key: Key) -> bool {
    let name = key.name();
    let is_letter = name.len() == 1 && name.starts_with(|letter: char| letter.is_ascii_alphabetic());
    let presses = matches!(key, Key::Space | Key::Enter | Key::Tab);
    let is_arrow = matches!(key, Key::ArrowLeft | Key::ArrowRight | Key::ArrowUp | Key::ArrowDown);
    modifiers.is_none() && (is_letter || presses || is_arrow)
}

/// Keys of the views, the pixel and the camera path.
fn other_keys(state: &State) -> Vec<Bound> {
    let page = state.inspector.help.is_none().then_some(HelpPage::Shortcuts);
    let help = Command::Window(WindowCommand::Help(page));
    let mut keys = vec![
        (Modifiers::SHIFT, Key::Space, Command::Window(WindowCommand::Maximize(None))),
        (Modifiers::SHIFT, Key::Questionmark, help.clone()),
    ];
    let plain = [
        (Key::Space, Command::Time(TimeCommand::TogglePlay)),
        (Key::Comma, Command::Time(TimeCommand::Step(-1))),
        (Key::Period, Command::Time(TimeCommand::Step(1))),
        (Key::P, Command::Pixel(PixelCommand::Pin(!state.doc.probe.pinned))),
        (Key::F, Command::View(ViewCommand::FramePoint)),
        (Key::H, Command::View(ViewCommand::Holes(state.holes_shown().other()))),
        (Key::K, Command::Path(PathCommand::AddKey)),
        (
            Key::M,
            Command::View(ViewCommand::look(&state.live, |live| live.ruler.measure(!live.ruler.active))),
        ),
        (Key::OpenBracket, Command::View(ViewCommand::look(&state.live, |live| live.fly_speed /= FASTER))),
        (Key::CloseBracket, Command::View(ViewCommand::look(&state.live, |live| live.fly_speed *= FASTER))),
        (Key::Home, Command::View(ViewCommand::Home)),
        (Key::Questionmark, help),
    ];
    keys.extend(plain.map(|(key, command)| (Modifiers::NONE, key, command)));
    keys
}

fn undo_keys() -> Vec<Bound> {
    vec![
        (Modifiers::COMMAND, Key::Y, Command::Redo),
        (Modifiers::COMMAND | Modifiers::SHIFT, Key::Z, Command::Redo),
        (Modifiers::COMMAND, Key::Z, Command::Undo),
    ]
}

/// Keys that work while text is typed as well.
fn keys_anywhere(state: &State) -> Vec<Bound> {
    let palette = state.inspector.palette.is_none().then(CommandPalette::default);
    vec![
        (Modifiers::COMMAND, Key::O, Command::File(FileCommand::AskPath(Purpose::OpenFile))),
        (Modifiers::COMMAND, Key::E, Command::Share(ShareCommand::Open(None))),
        (Modifiers::COMMAND, Key::S, Command::File(FileCommand::SaveSession)),
        (Modifiers::COMMAND, Key::L, Command::View(ViewCommand::CopyAddress)),
        (Modifiers::COMMAND, Key::P, Command::Window(WindowCommand::Palette(palette))),
        (Modifiers::COMMAND | Modifiers::SHIFT, Key::C, Command::Pixel(PixelCommand::CopyExplanation)),
        (Modifiers::COMMAND | Modifiers::SHIFT, Key::F, Command::Share(ShareCommand::CopyFigure(None))),
        (Modifiers::NONE, Key::F11, Command::Window(WindowCommand::FullScreen)),
    ]
}

/// Copying and pasting outside of text: the view.
fn clipboard(event: &egui::Event) -> Option<Command> {
    match event {
        egui::Event::Copy => Some(Command::View(ViewCommand::Copy)),
        egui::Event::Paste(text) => Some(Command::View(ViewCommand::Pasted(text.clone()))),
        _ => None,
    }
}

/// Keys that hide and show what surrounds the views, and those of views that were left or are kept.
fn window_keys(state: &State) -> Vec<Bound> {
    let hide = |area| Command::Window(WindowCommand::ShowArea(area, !state.look.shows(area)));
    vec![
        (Modifiers::ALT, Key::ArrowLeft, Command::View(ViewCommand::Back)),
        (Modifiers::ALT, Key::ArrowRight, Command::View(ViewCommand::Forward)),
        (Modifiers::COMMAND, Key::D, Command::View(ViewCommand::Kept(KeptViewCommand::Keep))),
        (Modifiers::COMMAND, Key::B, hide(Area::Side)),
        (Modifiers::COMMAND, Key::J, hide(Area::Lower)),
    ]
}

/// Keys that move in time, or that set the range that is played.
fn time_keys(state: &State) -> Vec<Bound> {
    let (timeline, frames) = (&state.timeline, state.frame_count());
    let last = frames.saturating_sub(1);
    let here = timeline.frame;
    let range = |range| Command::Time(TimeCommand::change(timeline, |timeline| timeline.range = range));
    let from = |begins| range(Some(timeline.range_here(begins, frames)));
    let marks = Command::Time(TimeCommand::change(timeline, Timeline::toggle_marker));
    vec![
        (Modifiers::COMMAND, Key::Home, Command::Time(TimeCommand::Frame(0))),
        (Modifiers::COMMAND, Key::End, Command::Time(TimeCommand::Frame(last))),
        (Modifiers::SHIFT, Key::M, marks),
        (Modifiers::COMMAND, Key::ArrowLeft, Command::Time(TimeCommand::Frame(timeline.marker(false)))),
        (Modifiers::COMMAND, Key::ArrowRight, Command::Time(TimeCommand::Frame(timeline.marker(true)))),
        (Modifiers::SHIFT, Key::ArrowLeft, Command::Time(TimeCommand::Frame(here.saturating_sub(TEN)))),
        (Modifiers::SHIFT, Key::ArrowRight, Command::Time(TimeCommand::Frame((here + TEN).min(last)))),
        (Modifiers::NONE, Key::ArrowLeft, Command::Time(TimeCommand::Step(-1))),
        (Modifiers::NONE, Key::ArrowRight, Command::Time(TimeCommand::Step(1))),
        (Modifiers::SHIFT, Key::I, range(None)),
        (Modifiers::NONE, Key::I, from(true)),
        (Modifiers::NONE, Key::O, from(false)),
    ]
}

/// Keys that select and delete. While there is a brush, brackets change it.
fn edit_keys(state: &State) -> Vec<Bound> {
    let edits = &state.doc.edits;
    let tool = |tool: EditTool| EditCommand::Tools(edits.tools.with(tool));
    let brush =
        |wider: f32| EditCommand::Tools(EditTools { radius: edits.tools.radius * wider, ..edits.tools });
    let mut keys = vec![
        (Modifiers::COMMAND, Key::I, EditCommand::Reshape(edits.inverted())),
        (Modifiers::SHIFT, Key::B, tool(EditTool::Mask)),
        (Modifiers::SHIFT, Key::G, EditCommand::Reshape(edits.grown(false))),
        (Modifiers::NONE, Key::B, tool(EditTool::Brush)),
        (Modifiers::NONE, Key::G, EditCommand::Reshape(edits.grown(true))),
        (Modifiers::NONE, Key::L, tool(EditTool::Lasso)),
        (Modifiers::NONE, Key::R, tool(EditTool::Rectangle)),
        (Modifiers::NONE, Key::T, tool(EditTool::Surface)),
        (Modifiers::NONE, Key::C, tool(EditTool::Color)),
        (Modifiers::NONE, Key::Delete, EditCommand::Act(Action::Delete)),
    ];
    if edits.tools.tool.is_some_and(EditTool::has_radius) {
        keys.push((Modifiers::NONE, Key::OpenBracket, brush(1.0 / WIDER)));
        keys.push((Modifiers::NONE, Key::CloseBracket, brush(WIDER)));
    }
    keys.into_iter().map(|(modifiers, key, command)| (modifiers, key, Command::Edit(command))).collect()
}

/// Keys that view the scene along an axis. egui does not distinguish digits of the number pad from those above the
/// letters, which show cameras.
fn axis_keys() -> Vec<Bound> {
    let mut keys = Vec::new();
    for (key, axis) in [(Key::X, DVec3::X), (Key::Y, DVec3::Y), (Key::Z, DVec3::Z)] {
        for (modifiers, direction) in [(Modifiers::ALT | Modifiers::SHIFT, axis), (Modifiers::ALT, -axis)] {
            keys.push((modifiers, key, Command::View(ViewCommand::LookAlong(direction))));
        }
    }
    keys
}

/// Frames that Shift and an arrow step.
const TEN: usize = 10;

/// How much wider or narrower a bracket makes the brush.
const WIDER: f32 = 1.25;

/// How much faster or slower a bracket makes flying.
const FASTER: f64 = 1.5;

fn given_up_id() -> egui::Id {
    egui::Id::unique("number given up")
}

/// Whether Escape ended the typing of a number in this frame or the one before: egui commits the number one frame after the key,
/// without naming the key.
pub(crate) fn gave_up_number(ctx: &egui::Context) -> bool {
    let now = ctx.cumulative_frame_nr();
    ctx.data(|data| data.get_temp::<u64>(given_up_id())).is_some_and(|frame| now <= frame + 1)
}

/// Whether text is typed, or was until this frame: Escape ends that before anything is drawn.
fn edits_text(ctx: &egui::Context) -> bool {
    let (frame, now) = (ctx.cumulative_frame_nr(), ctx.text_edit_focused());
    ctx.data_mut(|data| {
        let id = egui::Id::unique("text is edited");
        let (known, at_known, before_known) = data.get_temp(id).unwrap_or((frame, now, now));
        // A frame that is drawn twice has the same frame before it both times.
        let before = if known == frame { before_known } else { at_known };
        data.insert_temp(id, (frame, now, before));
        now || before
    })
}

/// With Shift, number keys type something else on every layout: their place on the keyboard counts.
fn number_key(event: &egui::Event) -> Option<Command> {
    let egui::Event::Key { key, physical_key, pressed: true, modifiers, .. } = event else { return None };
    let place = physical_key.unwrap_or(*key);
    let index = NUMBERS.iter().position(|number| *number == place)?;
    if modifiers.is_none() {
        Some(Command::Source(SourceCommand::Camera(index)))
    } else if modifiers.shift_only() {
        Some(Command::View(ViewCommand::JumpTo(index)))
    } else if modifiers.command_only() {
        Workspace::ALL.get(index).map(|(workspace, ..)| Command::Window(WindowCommand::Workspace(*workspace)))
    } else {
        None
    }
}

/// The keys held down, by their position on the keyboard: W A S D are neighbors on every layout.
fn held_keys(ctx: &egui::Context) -> HashSet<Key> {
    let events = ctx.input(|input| input.events.clone());
    ctx.data_mut(|data| {
        let held: &mut HashSet<Key> = data.get_temp_mut_or_default(egui::Id::unique("held keys"));
        for event in events {
            match event {
                egui::Event::Key { key, physical_key, pressed, .. } => {
                    let place = physical_key.unwrap_or(key);
                    if pressed {
                        held.insert(place);
                    } else {
                        held.remove(&place);
                    }
                }
                egui::Event::WindowFocused(false) => held.clear(),
                _ => {}
            }
        }
        held.clone()
    })
}

fn flight(input: &egui::InputState, held: &HashSet<Key>) -> Option<DVec3> {
    if input.modifiers.any() && !input.modifiers.shift_only() {
        return None;
    }
    let pressed = |positive, negative| {
        f64::from(u8::from(held.contains(&positive))) - f64::from(u8::from(held.contains(&negative)))
    };
    let direction = DVec3::new(pressed(Key::D, Key::A), pressed(Key::Q, Key::E), pressed(Key::W, Key::S));
    let pace = if input.modifiers.shift { 4.0 } else { 1.0 };
    let seconds = f64::from(input.stable_dt.min(0.1));
    (direction != DVec3::ZERO).then(|| direction * FLY_PER_SECOND * pace * seconds)
}
