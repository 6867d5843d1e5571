//! What is typed belongs to the field it is typed into, and what the window says of its settings is so.

use super::driver::{
    SIZE, Window, click, copied, do_command, drop_on, open, open_store, open_view, pick, save_store, settle,
    shows, small_demo, wait,
};
use egui::{Event, Key, Modifiers};
use egui_kittest::kittest::Queryable;

const FIELD: &str = "Depth tolerance";

fn tolerance(window: &Window) -> f32 {
    window.state().observed().settings.pruning.depth_tolerance
}

/// Puts the caret into the number beside a threshold and types over it.
fn type_number(window: &mut Window, text: &str) {
    click(window, FIELD);
    window.event(Event::Text(text.to_owned()));
    window.run_steps(3);
}

#[test]
fn escape_leaves_a_number_as_it_was_and_nothing_else() {
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    drop_on(&mut window, "/no/such/capture".as_ref());
    wait(&mut window, "the message", |window| !window.state().observed().notices.is_empty());
    type_number(&mut window, "2.5");
    window.key_press(Key::Escape);
    window.run_steps(3);
    assert_eq!(tolerance(&window), 1.0);
    assert_eq!(window.state().observed().notices.len(), 1, "the message is not what was closed");
    window.key_press(Key::Escape);
    window.run_steps(3);
    assert!(window.state().observed().notices.is_empty());
    type_number(&mut window, "2.5");
    window.key_press(Key::Enter);
    window.run_steps(3);
    assert_eq!(tolerance(&window), 2.5);
    settle(&mut window);
}

#[test]
fn a_field_for_a_path_says_in_which_folder_a_name_lies_and_goes_by_cancel() {
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    do_command(&mut window, "Save settings");
    let folder = std::env::current_dir().unwrap();
    let folder = format!("In {}", folder.display());
    assert!(shows(&window, &folder));
    window.event(Event::Text("/tmp/elsewhere/mine".to_owned()));
    window.run_steps(3);
    assert!(!shows(&window, &folder), "a whole path lies where it says");
    click(&mut window, "Cancel this path");
    assert!(window.query_by_label("Path").is_none());
}

#[test]
fn undo_and_redo_while_a_number_is_typed_are_not_meant_at_the_settings() {
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    pick(&mut window, "Presets", "Aggressive");
    type_number(&mut window, "7");
    for key in [Key::Z, Key::Y] {
        window.key_press_modifiers(Modifiers::COMMAND, key);
        window.run_steps(3);
        assert_eq!(tolerance(&window), 2.5, "the preset stays on");
    }
    window.key_press(Key::Escape);
    window.run_steps(3);
    window.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    window.run_steps(3);
    assert_eq!(tolerance(&window), 1.0);
    settle(&mut window);
}

#[test]
fn a_focused_button_takes_letters_and_arrows_and_leaves_other_keys_what_they_do() {
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    let focus = |window: &mut Window| {
        window.key_press(Key::Tab);
        window.run_steps(3);
        assert!(window.ctx.egui_wants_keyboard_input(), "a button has the focus");
    };
    let press = |window: &mut Window, modifiers, key| {
        window.key_press_modifiers(modifiers, key);
        window.run_steps(3);
        window.state().observed().frame
    };
    focus(&mut window);
    assert_eq!(press(&mut window, Modifiers::COMMAND, Key::End), 3);
    assert_eq!(press(&mut window, Modifiers::NONE, Key::ArrowLeft), 3, "arrows go from button to button");
    press(&mut window, Modifiers::NONE, Key::I);
    assert!(window.query_by_label("Loop over all frames").is_none(), "a letter is the button's");
    assert_eq!(press(&mut window, Modifiers::SHIFT, Key::ArrowLeft), 0);
    press(&mut window, Modifiers::SHIFT, Key::M);
    assert!(window.query_by_label("Remove marker").is_some());
    focus(&mut window);
    press(&mut window, Modifiers::SHIFT, Key::Num2);
    let observed = window.state().observed();
    assert_eq!(observed.live_position, observed.camera_positions.get(1).copied());
    press(&mut window, Modifiers::NONE, Key::Home);
    assert_ne!(window.state().observed().live_position, Some(window.state().observed().camera_positions[1]));
    window.event(Event::Copy);
    assert!(copied(&mut window).is_some(), "the view");
    focus(&mut window);
    press(&mut window, Modifiers::SHIFT, Key::Space);
    assert!(window.query_by_label("Restore Live view").is_some());
    settle(&mut window);
}

#[test]
fn delete_acts_on_what_is_selected_while_a_button_has_the_focus_and_not_while_a_number_is_typed() {
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    open_view(&mut window, "Edits");
    click(&mut window, "Select Sphere");
    settle(&mut window);
    let delete = |window: &mut Window| {
        window.key_press(Key::Delete);
        window.run_steps(3);
        settle(window);
        !shows(window, "No edits yet")
    };
    click(&mut window, "Radius X");
    assert!(!delete(&mut window), "the key belongs to the number");
    window.key_press(Key::Escape);
    window.run_steps(3);
    window.key_press(Key::Tab);
    window.run_steps(3);
    assert!(delete(&mut window));
}

#[test]
fn the_report_says_when_it_is_out_of_date() {
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    pick(&mut window, "Pruning method", "Off");
    settle(&mut window);
    open_view(&mut window, "Report");
    assert!(!shows(&window, "Made with other settings"));
    // It lies over the thresholds.
    window.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    window.run_steps(3);
    assert!(shows(&window, "Made with other settings"));
    settle(&mut window);
}

#[test]
fn how_frames_are_read_is_said_to_hold_for_what_is_opened_next() {
    // Tall enough for the last of the settings.
    let mut window = open(small_demo(), [SIZE[0], 2300.0]);
    settle(&mut window);
    click(&mut window, "Loading");
    assert!(shows(&window, "For captures that are opened from now on"));
}

#[test]
fn the_palette_offers_only_painting_where_a_store_keeps_its_thresholds() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    let path = save_store(&mut window, folder.path());
    let offers = |window: &mut Window, name: &str| {
        click(window, "Commands");
        window.get_by_label("Command").type_text(name);
        window.run_steps(3);
        let found = shows(window, &format!("Do: {name}"));
        window.key_press(Key::Escape);
        window.run_steps(3);
        found
    };
    let hidden =
        ["Undo", "Reset all settings", "Switch between", "Preset: Aggressive", "Pruning method: Off"];
    assert!(hidden.iter().all(|name| offers(&mut window, name)));
    open_store(&mut window, &path);
    for name in hidden {
        assert!(!offers(&mut window, name), "{name}");
    }
    assert!(offers(&mut window, "Kernel: Point") && offers(&mut window, "Save settings"));
}
