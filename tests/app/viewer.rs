//! The window as a viewer: views that fill it, workspaces, and what is hidden of it.

use super::driver::{
    SIZE, Window, click, demo, do_command, open, open_store, open_view, save_store, settle, shows, small_demo,
};
use egui::accesskit::Role;
use egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable;

fn size_of_live_picture(window: &Window) -> egui::Vec2 {
    window.get_by_label("Live picture").rect().size()
}

/// Clicks twice at a place, as fast as a double-click.
fn double_click_at(window: &mut Window, at: egui::Pos2) {
    // Each event has a frame of its own here, and frames last longer than a person's double-click.
    window.ctx.options_mut(|options| options.input_options.max_double_click_delay = 2.0);
    window.event(egui::Event::PointerMoved(at));
    for pressed in [true, false, true, false] {
        let button = egui::PointerButton::Primary;
        window.event(egui::Event::PointerButton { pos: at, button, pressed, modifiers: Modifiers::NONE });
    }
    window.run_steps(4);
    // The next click is one of its own.
    window.run_steps(12);
}

fn fills_window(window: &Window, view: &str) -> bool {
    window.query_by_label(&format!("Restore {view}")).is_some()
}

#[test]
fn a_double_click_on_its_tab_a_button_and_a_key_let_a_view_fill_the_window_and_put_it_back() {
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    let docked = size_of_live_picture(&window);
    let tab = window.get_by_role_and_label(Role::Button, "Live view").rect().center();
    double_click_at(&mut window, tab);
    assert!(fills_window(&window, "Live view"));
    let large = size_of_live_picture(&window);
    assert!(large.x > 0.95 * SIZE[0] && large.y > 0.65 * SIZE[1], "{large}");
    assert_eq!(window.state().observed().views_in_sight, ["Live view"]);
    let name = window.get_by_role_and_label(Role::Button, "Live view").rect().center();
    double_click_at(&mut window, name);
    assert_eq!(size_of_live_picture(&window), docked);
    click(&mut window, "Maximize Source");
    assert!(fills_window(&window, "Source"));
    click(&mut window, "Restore Source");
    assert!(!fills_window(&window, "Source"));
    window.hover_at(window.get_by_label("Source picture").rect().center());
    window.run_steps(2);
    for expected in [true, false] {
        window.key_press_modifiers(Modifiers::SHIFT, Key::Space);
        window.run_steps(3);
        assert_eq!(fills_window(&window, "Source"), expected);
    }
    window.key_press_modifiers(Modifiers::SHIFT, Key::Space);
    window.run_steps(3);
    window.key_press(Key::Escape);
    window.run_steps(3);
    assert_eq!(size_of_live_picture(&window), docked);
    assert!(window.query_by_label("Play").is_some(), "the key did not play");
}

/// What the window asked of the system in the frames after a key or a click: to fill the screen, or no longer to.
fn asked_for_full_screen(window: &mut Window) -> Option<bool> {
    let mut asked = None;
    for _ in 0..4 {
        window.step();
        for command in window.output().viewport_output.values().flat_map(|viewport| &viewport.commands) {
            if let egui::ViewportCommand::Fullscreen(full) = command {
                asked = Some(*full);
            }
        }
    }
    asked
}

#[test]
fn a_key_and_a_command_fill_the_screen_and_leave_it() {
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    assert_eq!(asked_for_full_screen(&mut window), None);
    window.key_press(Key::F11);
    assert_eq!(asked_for_full_screen(&mut window), Some(true));
    window.input_mut().viewports.entry(egui::ViewportId::ROOT).or_default().fullscreen = Some(true);
    window.run_steps(2);
    click(&mut window, "Commands");
    window.get_by_label("Command").type_text("Full screen");
    window.run_steps(3);
    window.get_by_label("Do: Full screen").click();
    assert_eq!(asked_for_full_screen(&mut window), Some(false));
}

#[test]
fn panels_hide_and_come_back_where_they_were() {
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    let (docked, seen) = (size_of_live_picture(&window), window.state().observed().views_in_sight);
    for (key, hidden) in [(Key::B, "side"), (Key::J, "lower")] {
        let before = size_of_live_picture(&window);
        window.key_press_modifiers(Modifiers::COMMAND, key);
        window.run_steps(4);
        let after = size_of_live_picture(&window);
        assert!(after.x * after.y > 1.2 * before.x * before.y, "{hidden}: {after}");
    }
    do_command(&mut window, "Hide the source picture");
    settle(&mut window);
    assert_eq!(window.state().observed().views_in_sight, ["Live view"]);
    window.key_press_modifiers(Modifiers::COMMAND, Key::Num2);
    settle(&mut window);
    assert_eq!((size_of_live_picture(&window), window.state().observed().views_in_sight), (docked, seen));
    assert!(shows(&window, "Samples kept"));
    do_command(&mut window, "Hide the summary bar");
    assert!(!shows(&window, "Samples kept"));
    for (typed, shown) in [("show the summary bar", true), ("hide the summary bar", false)] {
        window.key_press_modifiers(Modifiers::COMMAND, Key::P);
        window.run_steps(3);
        window.get_by_label("Command").type_text(typed);
        window.run_steps(3);
        window.key_press(Key::Enter);
        window.run_steps(3);
        assert_eq!(shows(&window, "Samples kept"), shown, "{typed}");
    }
}

#[test]
fn the_side_panel_of_every_workspace_hides_as_a_whole() {
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    click(&mut window, "Workspace: Explore");
    open_view(&mut window, "Camera path");
    let (docked, seen) = (size_of_live_picture(&window), window.state().observed().views_in_sight);
    let press = |window: &mut Window, key| {
        window.key_press_modifiers(Modifiers::COMMAND, key);
        window.run_steps(4);
        window.state().observed().views_in_sight
    };
    assert_eq!(press(&mut window, Key::J), seen, "no lower panel is here");
    press(&mut window, Key::J);
    assert_eq!(press(&mut window, Key::B), ["Live view"]);
    let large = size_of_live_picture(&window);
    assert!(large.x > 0.95 * SIZE[0], "{large}");
    open_view(&mut window, "Camera path");
    assert_eq!((size_of_live_picture(&window), window.state().observed().views_in_sight), (docked, seen));
}

#[test]
fn each_workspace_shows_what_it_is_for() {
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    for (name, views) in [
        ("Explore", &["Live view"][..]),
        ("Compare", &["Live view", "Compare"]),
        ("Benchmark", &["Sweep", "Live view", "Cameras"]),
        ("Inspect", &["Source", "Live view", "Pixel"]),
    ] {
        click(&mut window, &format!("Workspace: {name}"));
        settle(&mut window);
        let seen = window.state().observed().views_in_sight;
        assert!(views.iter().all(|view| seen.contains(view)), "{name}: {seen:?}");
        assert!(window.query_by_label("Live picture").is_some());
    }
    click(&mut window, "Workspace: Explore");
    settle(&mut window);
    let large = size_of_live_picture(&window);
    assert!(large.x * large.y > 0.38 * SIZE[0] * SIZE[1], "{large}");
    open_view(&mut window, "Pixel");
    click(&mut window, "Workspace: Inspect");
    click(&mut window, "Workspace: Explore");
    settle(&mut window);
    assert!(
        window.state().observed().views_in_sight.contains(&"Pixel"),
        "a workspace is found as it was left"
    );
    click(&mut window, "Panels");
    click(&mut window, "Reset layout");
    settle(&mut window);
    assert!(!window.state().observed().views_in_sight.contains(&"Pixel"));
}

#[test]
fn a_store_has_no_empty_source_panel_and_a_single_frame_no_timeline() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    assert!(window.query_by_label("Timeline").is_some());
    let of_time = ["Source shows: Motion", "Live view shows: Motion"];
    let has_time_tab = |window: &Window| window.query_by_role_and_label(Role::Button, "Time").is_some();
    assert!(of_time.iter().all(|name| window.query_by_label(name).is_some()) && has_time_tab(&window));
    let docked = size_of_live_picture(&window);
    let path = save_store(&mut window, folder.path());
    open_store(&mut window, &path);
    assert!(!window.state().observed().views_in_sight.contains(&"Source"));
    assert!(size_of_live_picture(&window).x > 1.8 * docked.x);
    open_view(&mut window, "Source");
    assert!(shows(&window, "This store holds no source frames"), "who asks for it is told");
    let mut window = open(demo(2, 1, (64, 48)), SIZE);
    settle(&mut window);
    assert!(window.query_by_label("Timeline").is_none());
    assert!(of_time.iter().all(|name| window.query_by_label(name).is_none()) && !has_time_tab(&window));
    for _ in 0..2 {
        window.key_press_modifiers(Modifiers::COMMAND, Key::J);
        window.run_steps(3);
    }
    assert!(window.query_by_role_and_label(Role::Button, "Cameras").is_some() && !has_time_tab(&window));
    assert!(window.state().observed().views_in_sight.contains(&"Source"));
}
