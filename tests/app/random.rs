//! Ten thousand events nobody would make on purpose: the window neither panics nor hangs.

use super::driver::{SIZE, demo, drop_on, open, settle};
use egui::{Event, Key, Modifiers, MouseWheelUnit, PointerButton, Pos2, TouchPhase, pos2, vec2};

const EVENTS: usize = 10_000;

/// Events of one frame: a hand is never faster.
const PER_FRAME: usize = 5;

/// Small numbers that look random and are the same in every run (Marsaglia, *Xorshift RNGs*, 2003).
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    fn below(&mut self, end: usize) -> usize {
        (self.next() % end as u64) as usize
    }

    fn one_of<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[self.below(choices.len())]
    }

    fn share(&mut self) -> f32 {
        self.below(10_000) as f32 / 10_000.0
    }
}

const KEYS: [Key; 35] = [
    Key::Space,
    Key::Comma,
    Key::Period,
    Key::F,
    Key::H,
    Key::K,
    Key::P,
    Key::X,
    Key::W,
    Key::A,
    Key::S,
    Key::D,
    Key::Q,
    Key::E,
    Key::Home,
    Key::Escape,
    Key::Enter,
    Key::Tab,
    Key::Num1,
    Key::Num2,
    Key::Num3,
    Key::Num9,
    Key::Z,
    Key::Y,
    Key::C,
    Key::O,
    Key::ArrowUp,
    Key::ArrowDown,
    Key::ArrowLeft,
    Key::ArrowRight,
    Key::Backspace,
    Key::Delete,
    Key::PageDown,
    Key::Questionmark,
    Key::End,
];

const MODIFIERS: [Modifiers; 5] =
    [Modifiers::NONE, Modifiers::NONE, Modifiers::SHIFT, Modifiers::COMMAND, Modifiers::ALT];

struct Hand {
    numbers: Numbers,
    at: Pos2,
    pressed: Option<PointerButton>,
    size: egui::Vec2,
}

impl Hand {
    fn event(&mut self) -> Event {
        let modifiers = self.numbers.one_of(&MODIFIERS);
        match self.numbers.below(20) {
            0..=5 => {
                self.at = pos2(self.numbers.share() * self.size.x, self.numbers.share() * self.size.y);
                Event::PointerMoved(self.at)
            }
            6..=7 => {
                self.at += vec2(self.numbers.share() - 0.5, self.numbers.share() - 0.5) * 60.0;
                Event::PointerMoved(self.at)
            }
            8..=12 => {
                let buttons = [PointerButton::Primary, PointerButton::Primary, PointerButton::Secondary];
                let (button, pressed) = match self.pressed.take() {
                    Some(button) => (button, false),
                    None => (self.numbers.one_of(&buttons), true),
                };
                self.pressed = pressed.then_some(button);
                Event::PointerButton { pos: self.at, button, pressed, modifiers }
            }
            13..=16 => {
                let (key, pressed) = (self.numbers.one_of(&KEYS), self.numbers.below(3) > 0);
                Event::Key { key, physical_key: Some(key), pressed, repeat: false, modifiers }
            }
            17 => Event::Text(self.numbers.one_of(&["a", "7", "-", ".", "§", "/tmp", "e9"]).to_owned()),
            18 => {
                let delta = vec2(0.0, (self.numbers.share() - 0.5) * 300.0);
                Event::MouseWheel {
                    unit: MouseWheelUnit::Point,
                    delta,
                    modifiers,
                    phase: TouchPhase::Move,
                    source: egui::MouseWheelSource::Wheel,
                }
            }
            _ => {
                let focused = Event::WindowFocused(self.numbers.below(2) == 0);
                if self.numbers.below(2) == 0 { Event::PointerGone } else { focused }
            }
        }
    }
}

#[test]
fn ten_thousand_random_events_neither_panic_nor_hang() {
    let folder = tempfile::tempdir().unwrap();
    let bad = folder.path().join("bad.ovl");
    std::fs::write(&bad, b"FORM\0\0\0\x08OVLK\xff\xff").unwrap();
    // What the hand happens to save or export must not land among the sources.
    std::env::set_current_dir(env!("CARGO_TARGET_TMPDIR")).unwrap();
    let mut window = open(demo(2, 3, (48, 36)), SIZE);
    settle(&mut window);
    let mut hand = Hand {
        numbers: Numbers(0x5eed_0f0e_41ec_0deb),
        at: pos2(600.0, 300.0),
        pressed: None,
        size: vec2(1280.0, 800.0),
    };
    for frame in 0..EVENTS / PER_FRAME {
        for _ in 0..PER_FRAME {
            let event = hand.event();
            window.input_mut().events.push(event);
        }
        match hand.numbers.below(60) {
            0 => {
                hand.size = vec2(480.0 + hand.numbers.share() * 1500.0, 320.0 + hand.numbers.share() * 800.0);
                window.set_size(hand.size);
            }
            1 => {
                let path =
                    hand.numbers.one_of(&[bad.as_path(), folder.path(), "/no/such".as_ref()]).to_path_buf();
                drop_on(&mut window, &path);
            }
            _ => {}
        }
        window.step();
        let mut notices = window.state().observed().notices.into_iter();
        let fault = notices.find(|notice| notice.contains("a fault in Overlook"));
        assert_eq!(fault, None, "after {} events", (frame + 1) * PER_FRAME);
    }
    for _ in 0..20 {
        window.key_press(Key::Escape);
        window.step();
    }
    assert!(window.state().observed().scene_name.is_some());
}
