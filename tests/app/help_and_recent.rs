//! What helps somebody on: the palette, the guide, shortcuts, About, and what was open before.

use std::path::Path;
use std::sync::{Arc, Mutex};

use egui::accesskit::Role;
use egui::{Key, Modifiers};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use overlook::app::{OverlookApp, Start};

use super::driver::{
    SIZE, Storage, Window, click, do_command, open, settle, shows, small_capture, small_demo, wait,
};

fn open_palette(window: &mut Window) {
    window.key_press_modifiers(Modifiers::COMMAND, Key::P);
    window.run_steps(3);
}

fn entries(window: &Window) -> usize {
    window.query_all_by_label_contains("Do: ").count()
}

#[test]
fn the_palette_keeps_its_height_after_a_word_that_finds_nothing() {
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    open_palette(&mut window);
    let (all, field) = (entries(&window), window.get_by_label("Command").rect());
    assert!(all > 8, "{all}");
    window.get_by_label("Command").type_text("zzz");
    window.run_steps(3);
    assert!(shows(&window, "No matching command."));
    assert_eq!(window.get_by_label("Command").rect(), field, "the field stays where it is");
    for _ in 0..3 {
        window.key_press(Key::Backspace);
        window.run_steps(2);
    }
    assert_eq!(entries(&window), all);
}

#[test]
fn the_help_menu_has_the_guide_the_keys_and_mouse_and_the_version_with_the_adapter() {
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    for (entry, texts) in [
        ("Guide", &["See what is redundant", "Ask about one pixel"][..]),
        ("Keyboard and mouse shortcuts", &["orbit", "zoom to the pointer", "interface size: larger"]),
        ("About Overlook", &[env!("CARGO_PKG_VERSION"), "MIT"]),
    ] {
        click(&mut window, "Help");
        click(&mut window, entry);
        for text in texts {
            assert!(shows(&window, text), "{entry}: {text}");
        }
        if entry == "Guide" {
            let place = window.query_all_by_label_contains(texts[0]).next().unwrap().rect();
            let menus = window.get_by_role_and_label(Role::Button, "Help").rect();
            assert!(place.left() > SIZE[0] / 2.0 && place.top() > menus.bottom(), "{place}");
            for (link, text) in [("SCIENCE.md", "For scientists"), ("Guide", texts[1])] {
                window.get_by_role_and_label(Role::Link, link).click();
                window.run_steps(3);
                assert!(shows(&window, text), "{link} leads to {text}");
            }
        }
        window.key_press(Key::Escape);
        window.run_steps(3);
        assert!(!shows(&window, texts[0]), "{entry} closes");
    }
}

#[test]
fn what_was_open_before_is_offered_where_nothing_is_open() {
    let storage = Arc::new(Mutex::new(Storage::default()));
    let start = |path: &Path| -> Window {
        let (storage, start) = (storage.clone(), Start::Path(path.to_path_buf()));
        Harness::builder().with_size(SIZE).with_os(egui::os::OperatingSystem::Nix).build_eframe(move |cc| {
            OverlookApp::new(&cc.egui_ctx, Some(&*storage.lock().unwrap()), None, start).unwrap()
        })
    };
    let capture = small_capture();
    let mut window = start(&capture);
    settle(&mut window);
    assert!(window.state().observed().live_coverage.is_some(), "there is a picture to remember");
    eframe::App::save(window.state_mut(), &mut *storage.lock().unwrap());
    let mut window = start(Path::new("/no/such/capture"));
    wait(&mut window, "the error", |window| !window.state().observed().notices.is_empty());
    window.run_steps(3);
    assert!(shows(&window, "Nothing is open"));
    click(&mut window, "Open recent small_capture");
    wait(&mut window, "the capture", |window| window.state().observed().scene_name.is_some());
}

#[test]
fn the_size_of_the_interface_is_a_command() {
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    let size = |window: &mut Window, name: &str| {
        do_command(window, &format!("Interface size: {name}"));
        window.run_steps(3);
        window.ctx.zoom_factor()
    };
    assert!(size(&mut window, "larger") > 1.05);
    assert_eq!(size(&mut window, "normal"), 1.0);
    assert!(size(&mut window, "smaller") < 0.95);
}
