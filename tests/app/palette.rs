//! The palette understands people who do not know what a command is called here.

use egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable;
use overlook::app::Start;

use super::driver::{SIZE, Window, click, demo, open, settle, shows, small_demo, wait};

/// Opens the palette, types, and gives whether an entry is there.
fn offers(window: &mut Window, typed: &str, entry: &str) -> bool {
    window.key_press_modifiers(Modifiers::COMMAND, Key::P);
    window.run_steps(3);
    window.get_by_label("Command").type_text(typed);
    window.run_steps(3);
    let found = window.query_by_label(&format!("Do: {entry}")).is_some();
    assert!(!found || !shows(window, "No matching command."));
    window.key_press(Key::Escape);
    window.run_steps(3);
    found
}

#[test]
fn words_that_people_type_find_what_they_mean() {
    let capture = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/small_capture");
    let mut window = open(Start::Path(capture), SIZE);
    settle(&mut window);
    for (typed, entry) in [
        ("help", "Guide"),
        ("zoom", "Interface size: larger"),
        ("fov", "Open view: View"),
        ("full", "Full screen"),
        ("maxim", "Maximize or restore a view"),
        ("screenshot", "Share: Pictures"),
        ("measure", "Measure a distance"),
        ("recent", "Open recent: small_capture"),
        ("hole", "Hole filling: None"),
        ("background", "Open view: Color"),
        ("exposure", "Open view: Color"),
        ("scale", "Interface size: smaller"),
    ] {
        assert!(offers(&mut window, typed, entry), "{typed} does not find {entry:?}");
    }
    assert!(!offers(&mut window, "zzz", "Guide"));
    assert!(!offers(&mut window, "render.fill", "Hole filling: None"), "no raw key is a name");
}

#[test]
fn a_command_that_was_found_by_another_word_is_done() {
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    click(&mut window, "Commands");
    window.get_by_label("Command").type_text("bigger");
    window.run_steps(3);
    click(&mut window, "Do: Interface size: larger");
    assert!(window.ctx.zoom_factor() > 1.05);
}

#[test]
fn enter_does_what_a_word_means_most_likely() {
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    click(&mut window, "Commands");
    window.get_by_label("Command").type_text("help");
    window.run_steps(3);
    window.key_press(Key::Enter);
    window.run_steps(4);
    assert!(shows(&window, "See what is redundant"));
}

#[test]
fn a_camera_beyond_the_keys_is_shown_and_viewed_from_by_its_name() {
    let mut window = open(demo(12, 1, (32, 24)), SIZE);
    settle(&mut window);
    let last = "extra6";
    assert!(offers(&mut window, last, &format!("Show camera '{last}'")));
    click(&mut window, "Commands");
    window.get_by_label("Command").type_text(&format!("view from {last}"));
    window.run_steps(3);
    window.key_press(Key::Enter);
    wait(&mut window, "the view from the camera", |window| {
        let (view, camera) = (
            window.state().observed().live_position.unwrap(),
            window.state().observed().camera_positions[11],
        );
        view.iter().zip(camera).map(|(a, b)| (a - b).abs()).sum::<f64>() < 1e-9
    });
}
