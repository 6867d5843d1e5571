//! Keys that work anywhere in the window, except while text is typed.

use egui::{Key, KeyboardShortcut, Modifiers};
use glam::DVec3;

use super::command::Command;
use super::message::Purpose;
use super::state::State;

/// Keys and what they do, for the help.
pub(super) const HELP: &[(&str, &str)] = &[
    ("Space", "play or pause"),
    (", and .", "step back and forward"),
    ("1 – 9", "show a camera"),
    ("Shift + 1 – 9", "stand where a camera stood"),
    ("W A S D, Q E", "fly, down and up"),
    ("F or Home", "back to the first vantage"),
    ("Esc", "close a message, or cancel"),
    ("Ctrl + O", "open a file"),
    ("Ctrl + S", "save the store"),
    ("Ctrl + Q", "quit"),
];

/// Distance flown per second, in pivot distances.
const FLY_PER_SECOND: f64 = 0.6;

const NUMBERS: [Key; 9] =
    [Key::Num1, Key::Num2, Key::Num3, Key::Num4, Key::Num5, Key::Num6, Key::Num7, Key::Num8, Key::Num9];

/// Turns keys into commands.
pub(super) fn commands(ui: &egui::Ui, state: &State, commands: &mut Vec<Command>) {
    let ctx = ui.ctx();
    if ctx.input_mut(|input| input.consume_key(Modifiers::NONE, Key::Escape)) {
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
    if ctx.egui_wants_keyboard_input() || state.typed_path.is_some() || state.scene.is_none() {
        return;
    }
    ctx.input_mut(|input| {
        for (key, command) in [
            (Key::Space, Command::TogglePlay),
            (Key::Comma, Command::Step(-1)),
            (Key::Period, Command::Step(1)),
            (Key::F, Command::Home),
            (Key::Home, Command::Home),
        ] {
            if input.consume_key(Modifiers::NONE, key) {
                commands.push(command);
            }
        }
        for (index, key) in NUMBERS.into_iter().enumerate() {
            if input.consume_key(Modifiers::SHIFT, key) {
                commands.push(Command::JumpTo(index));
            } else if input.consume_key(Modifiers::NONE, key) {
                commands.push(Command::SourceCamera(index));
            }
        }
    });
    if let Some(steps) = ctx.input(flight) {
        commands.push(Command::Fly(steps));
        ctx.request_repaint();
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
