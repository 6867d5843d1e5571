//! Keys that work anywhere in the window, except while text is typed.

use egui::{Key, KeyboardShortcut, Modifiers};
use glam::DVec3;

use super::command::Command;
use super::message::Purpose;
use super::state::State;
use super::views::pixel_view;

/// Keys and what they do, for the help.
pub(super) const HELP: &[(&str, &str)] = &[
    ("Space", "play or pause"),
    (", and .", "step back and forward"),
    ("1 – 9", "show a camera"),
    ("Shift + 1 – 9", "stand where a camera stood"),
    ("W A S D, Q E", "fly, down and up"),
    ("P", "keep the pixel, or let go of it"),
    ("F or Home", "back to the first vantage"),
    ("Esc", "close a message, or cancel"),
    ("Ctrl + O", "open a file"),
    ("Ctrl + S", "save the store"),
    ("Ctrl + Z, Ctrl + Y", "take back a change, do it again"),
    ("Ctrl + Shift + C", "copy the argument for the pixel"),
    ("Ctrl + Q", "quit"),
];

/// Distance flown per second, in pivot distances.
const FLY_PER_SECOND: f64 = 0.6;

const NUMBERS: [Key; 9] =
    [Key::Num1, Key::Num2, Key::Num3, Key::Num4, Key::Num5, Key::Num6, Key::Num7, Key::Num8, Key::Num9];

/// Turns keys into commands.
pub(super) fn commands(ui: &egui::Ui, state: &State, commands: &mut Vec<Command>) {
    let ctx = ui.ctx();
    // An open menu takes the key for itself.
    if !egui::Popup::is_any_open(ctx)
        && ctx.input_mut(|input| input.consume_key(Modifiers::NONE, Key::Escape))
    {
        commands.push(Command::Escape);
    }
    let shortcut = |key| KeyboardShortcut::new(Modifiers::COMMAND, key);
    if ctx.input_mut(|input| input.consume_shortcut(&shortcut(Key::O))) {
        commands.push(Command::AskPath(Purpose::OpenFile));
    }
    if ctx.input_mut(|input| input.consume_shortcut(&shortcut(Key::S))) {
        commands.push(Command::AskPath(Purpose::SaveStore));
    }
    if ctx.input_mut(|input| input.consume_shortcut(&shortcut(Key::Q))) {
        ctx.send_viewport_cmd(egui::ViewportCommand::Close);
    }
    if state.has_capture() {
        let shift = Modifiers::COMMAND | Modifiers::SHIFT;
        let redo = [shortcut(Key::Y), KeyboardShortcut::new(shift, Key::Z)];
        if redo.iter().any(|keys| ctx.input_mut(|input| input.consume_shortcut(keys))) {
            commands.push(Command::Redo);
        } else if ctx.input_mut(|input| input.consume_shortcut(&shortcut(Key::Z))) {
            commands.push(Command::Undo);
        }
    }
    let copy = KeyboardShortcut::new(Modifiers::COMMAND | Modifiers::SHIFT, Key::C);
    if ctx.input_mut(|input| input.consume_shortcut(&copy)) {
        pixel_view::copy(ctx, state, commands);
    }
    if ctx.egui_wants_keyboard_input() || state.typed_path.is_some() || state.scene.is_none() {
        return;
    }
    ctx.input_mut(|input| {
        for (key, command) in [
            (Key::Space, Command::TogglePlay),
            (Key::Comma, Command::Step(-1)),
            (Key::Period, Command::Step(1)),
            (Key::P, Command::Pin(!state.inspector.probe.pinned)),
            (Key::F, Command::Home),
            (Key::Home, Command::Home),
        ] {
            if input.consume_key(Modifiers::NONE, key) {
                commands.push(command);
            }
        }
        // With Shift, number keys type something else on every layout: their place on the keyboard counts.
        commands.extend(input.events.iter().filter_map(number_key));
    });
    if let Some(steps) = ctx.input(flight) {
        commands.push(Command::Fly(steps));
        ctx.request_repaint();
    }
}

fn number_key(event: &egui::Event) -> Option<Command> {
    let egui::Event::Key { key, physical_key, pressed: true, modifiers, .. } = event else { return None };
    let place = physical_key.unwrap_or(*key);
    let index = NUMBERS.iter().position(|number| *number == place)?;
    if modifiers.is_none() {
        Some(Command::SourceCamera(index))
    } else if modifiers.shift_only() {
        Some(Command::JumpTo(index))
    } else {
        None
    }
}

fn flight(input: &egui::InputState) -> Option<DVec3> {
    if input.modifiers.any() && !input.modifiers.shift_only() {
        return None;
    }
    let pressed = |positive, negative| {
        f64::from(u8::from(input.key_down(positive))) - f64::from(u8::from(input.key_down(negative)))
    };
    let direction = DVec3::new(pressed(Key::D, Key::A), pressed(Key::Q, Key::E), pressed(Key::W, Key::S));
    let pace = if input.modifiers.shift { 4.0 } else { 1.0 };
    let seconds = f64::from(input.stable_dt.min(0.1));
    (direction != DVec3::ZERO).then(|| direction * FLY_PER_SECOND * pace * seconds)
}
