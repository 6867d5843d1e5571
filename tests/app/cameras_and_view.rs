//! The live view's camera: moved by numbers, copied and pasted, along paths that are saved; and the cameras that it shows.

use super::driver::{
    SIZE, Window, choose, click, copied, demo, drag, fold, open, open_view, pick, settle, shows, small_demo,
    told, type_path, wait,
};
use egui::accesskit::Role;
use egui::{Key, Modifiers, vec2};
use egui_kittest::kittest::{NodeT, Queryable};

/// A window in the workspace that has the View panel beside the live view.
fn explore() -> Window {
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    click(&mut window, "Workspace: Explore");
    settle(&mut window);
    fold(&mut window, "Pose");
    fold(&mut window, "Guides");
    window
}

/// Scrolls until a control of the panel is in view.
fn in_sight(window: &mut Window, name: &str) {
    window.get_by_label(name).scroll_to_me();
    window.run_steps(3);
}

fn position(window: &Window) -> [f64; 3] {
    window.state().observed().live_position.unwrap()
}

fn number(window: &Window, name: &str) -> f64 {
    let mut named = window.query_all_by_label(name);
    named.find_map(|node| node.accesskit_node().numeric_value()).unwrap()
}

/// Presses at a place in the live picture, as often as asked.
fn click_at(window: &mut Window, at: egui::Pos2, times: usize) {
    // Each event has a frame of its own here, and frames last longer than a person's double-click.
    window.ctx.options_mut(|options| options.input_options.max_double_click_delay = 2.0);
    window.hover_at(at);
    window.run_steps(12);
    for pressed in [true, false].repeat(times) {
        let button = egui::PointerButton::Primary;
        window.event(egui::Event::PointerButton { pos: at, button, pressed, modifiers: Modifiers::NONE });
    }
    window.run_steps(3);
}

#[test]
fn the_lens_and_the_pose_are_numbers_that_can_be_set() {
    let mut window = explore();
    let before = position(&window);
    let angle = number(&window, "Field of view");
    window.get_by_role_and_label(Role::Slider, "Field of view").focus();
    window.run_steps(2);
    for _ in 0..5 {
        window.key_press(Key::ArrowRight);
        window.run_steps(2);
    }
    settle(&mut window);
    assert!(number(&window, "Field of view") > angle);
    assert_eq!(position(&window), before, "the lens alone changed, and no frame was stepped");
    assert_eq!(window.state().observed().frame, 0);
    for name in ["Position X", "Position Y", "Position Z", "Heading", "Pitch", "Roll"] {
        assert!(window.query_by_label(name).is_some(), "{name}");
    }
    assert!(window.query_by_label_contains("focal length").is_some());
    click(&mut window, "View from Z");
    settle(&mut window);
    assert!((number(&window, "Pitch") + 90.0).abs() < 0.1, "{}", number(&window, "Pitch"));
    window.key_press(Key::Home);
    settle(&mut window);
    assert_eq!(position(&window), before);
}

#[test]
fn a_copied_view_is_pasted_and_what_is_no_view_says_so() {
    let mut window = explore();
    let home = position(&window);
    window.event(egui::Event::Copy);
    let copied = copied(&mut window).expect("text on the clipboard");
    let views = overlook_engine::capture::transforms::path_from_json(copied.as_bytes(), "clipboard".as_ref())
        .unwrap();
    assert_eq!(views[0].camera.world_from_camera.translation.to_array(), home);
    drag(&mut window, "Live picture", vec2(0.5, 0.5), vec2(70.0, 15.0));
    assert_ne!(position(&window), home);
    window.event(egui::Event::Paste(copied));
    settle(&mut window);
    let apart: f64 = position(&window).iter().zip(home).map(|(a, b)| (a - b).abs()).sum();
    assert!(apart < 1e-9, "{apart}");
    window.event(egui::Event::Paste("hello".to_owned()));
    window.run_steps(3);
    let notices = window.state().observed().notices;
    assert!(notices.iter().any(|notice| notice.starts_with("Nothing to paste")), "{notices:?}");
    assert_eq!(window.state().observed().scene_name, Some("orrery"));
}

#[test]
fn cameras_are_left_out_shown_alone_and_put_back() {
    let mut window = explore();
    // Tall enough for the whole panel.
    window.set_size(vec2(SIZE[0], 1200.0));
    // A picture of the new size is asked for once the layout has one.
    window.run_steps(4);
    settle(&mut window);
    let all = window.state().observed().live_coverage.unwrap().1;
    click(&mut window, "Hide left");
    settle(&mut window);
    assert!(shows(&window, "2 of 3 shown"));
    let without = window.state().observed().live_coverage.unwrap().1;
    assert!(without < all, "{without} of {all}");
    click(&mut window, "Solo left");
    settle(&mut window);
    assert!(shows(&window, "1 of 3 shown"));
    let alone = window.state().observed().live_coverage.unwrap().1;
    assert!(alone > 0.0 && alone < all, "{alone} of {all}");
    click(&mut window, "All off");
    settle(&mut window);
    assert_eq!(window.state().observed().live_coverage.unwrap().1, 0.0);
    click(&mut window, "All on");
    settle(&mut window);
    assert_eq!(window.state().observed().live_coverage.unwrap().1, all);
}

#[test]
fn a_pyramid_is_clicked_to_choose_its_camera_and_double_clicked_to_view_from_it() {
    let mut window = explore();
    let canvas = window.get_by_label("Live picture").rect();
    // From farther away the cameras are in view.
    window.key_down(Key::S);
    for _ in 0..60 {
        window.step();
        if window.state().observed().cameras_on_screen.len() > 1 {
            break;
        }
    }
    window.key_up(Key::S);
    settle(&mut window);
    let before = window.state().observed().source_camera;
    open_view(&mut window, "Color");
    let seen = window.state().observed().cameras_on_screen;
    let (camera, at) = *seen.iter().find(|(camera, _)| *camera != before).expect("a camera in view");
    let place = canvas.min + canvas.size() * at;
    // On its way the pointer may have rested on the picture.
    window.hover_at(place);
    settle(&mut window);
    let probed = window.state().observed().probed_pixel;
    click_at(&mut window, place, 1);
    assert_eq!(window.state().observed().source_camera, camera);
    assert_eq!(window.state().observed().probed_pixel, probed, "the picture behind was not clicked");
    // No view shows its picture here, so that the list of cameras does.
    assert!(window.state().observed().views_in_sight.contains(&"View"));
    window.hover_at(place);
    window.run_steps(6);
    assert!(shows(&window, "Click: choose it"));
    let away = position(&window);
    std::thread::sleep(std::time::Duration::from_millis(600));
    window.run_steps(3);
    click_at(&mut window, place, 2);
    settle(&mut window);
    assert_ne!(position(&window), away);
    let there = window.state().observed().camera_positions[camera];
    assert_eq!(position(&window), there);
}

#[test]
fn a_double_click_orbits_about_the_point_under_the_pointer_and_resets_the_view_where_nothing_is() {
    let mut window = explore();
    // A double-click on a camera views from it.
    click(&mut window, "Hide cameras");
    window.run_steps(4);
    settle(&mut window);
    let apart = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
    let double_click = |window: &mut Window, share: egui::Vec2| {
        let canvas = window.get_by_label("Live picture").rect();
        click_at(window, canvas.min + canvas.size() * share, 2);
        settle(window);
        // The next click is one of its own.
        std::thread::sleep(std::time::Duration::from_millis(600));
        window.run_steps(12);
        position(window)
    };
    let home = position(&window);
    let focused = double_click(&mut window, vec2(0.45, 0.6));
    assert!(apart(home, focused) > 1e-3, "the point is in the middle now");
    let again = double_click(&mut window, vec2(0.5, 0.5));
    assert!(apart(focused, again) < 0.3 * apart(home, focused), "{home:?} {focused:?} {again:?}");
    for _ in 0..2 {
        window.key_press_modifiers(Modifiers::ALT, Key::ArrowLeft);
        settle(&mut window);
    }
    assert!(apart(position(&window), home) < 1e-9);
    drag(&mut window, "Live picture", vec2(0.5, 0.5), vec2(70.0, 15.0));
    click(&mut window, "All off");
    settle(&mut window);
    assert_ne!(position(&window), home);
    assert_eq!(double_click(&mut window, vec2(0.45, 0.6)), home);
}

#[test]
fn the_list_to_go_to_is_filtered_by_name() {
    let mut window = explore();
    click(&mut window, "Go to camera");
    window.get_by_label("Filter cameras").type_text("lef");
    window.run_steps(3);
    assert!(window.query_by_role_and_label(Role::Button, "left").is_some());
    window.get_by_label("Filter cameras").type_text("zzz");
    window.run_steps(3);
    assert!(shows(&window, "No camera of that name."));
    window.key_press(Key::Escape);
    window.run_steps(3);
}

#[test]
fn a_camera_path_is_saved_rendered_and_opened_again() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("transforms.json");
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    window.key_press(Key::K);
    drag(&mut window, "Live picture", vec2(0.5, 0.5), vec2(70.0, 15.0));
    window.key_press(Key::Period);
    window.run_steps(2);
    window.key_press(Key::K);
    settle(&mut window);
    open_view(&mut window, "Camera path");
    let there = position(&window);
    type_path(&mut window, "Save camera path", &file, "Save this path");
    wait(&mut window, "the file", |window| told(window, "Saved"));
    let views = overlook_engine::capture::transforms::open_views(&file).unwrap();
    assert_eq!(views.len(), 49, "as render --views takes them");
    // Messages lie over the lower panel.
    while !window.state().observed().notices.is_empty() {
        window.key_press(Key::Escape);
        window.run_steps(3);
    }
    in_sight(&mut window, "Path file…");
    click(&mut window, "Path file…");
    click(&mut window, "Remove all keys");
    assert!(window.query_by_label("Key 1").is_none());
    window.key_press(Key::Home);
    settle(&mut window);
    type_path(&mut window, "Open camera path", &file, "Load this path");
    wait(&mut window, "the keys", |window| window.query_by_label("Key 2").is_some());
    while !window.state().observed().notices.is_empty() {
        window.key_press(Key::Escape);
        window.run_steps(2);
    }
    in_sight(&mut window, "Key 2");
    click(&mut window, "Key 2");
    settle(&mut window);
    let apart: f64 = position(&window).iter().zip(there).map(|(a, b)| (a - b).abs()).sum();
    assert!(apart < 1e-9 && window.state().observed().frame == 1, "{apart}");
    std::fs::write(&file, "no path").unwrap();
    type_path(&mut window, "Open camera path", &file, "Load this path");
    wait(&mut window, "the message", |window| {
        window.state().observed().notices.iter().any(|notice| notice.contains("holds no JSON"))
    });
}

#[test]
fn guides_frame_the_picture_lock_its_shape_and_measure_distances() {
    let mut window = explore();
    in_sight(&mut window, "Measure distance");
    let free = window.get_by_label("Live picture").rect();
    choose(&mut window, "Frame guide", "Camera");
    click(&mut window, "Ground grid");
    settle(&mut window);
    assert!(shows(&window, "Ground grid"));
    click(&mut window, "Lock aspect");
    settle(&mut window);
    let locked = window.get_by_label("Live picture").rect();
    assert!((locked.aspect_ratio() - 4.0 / 3.0).abs() < 0.02 && locked.area() < free.area(), "{locked}");
    window.key_press(Key::M);
    window.run_steps(2);
    click_at(&mut window, locked.min + locked.size() * vec2(0.45, 0.6), 1);
    click_at(&mut window, locked.min + locked.size() * vec2(0.6, 0.62), 1);
    let distance = window.state().observed().measured_distance.expect("a distance");
    assert!(distance > 0.01 && distance < 100.0, "{distance}");
    assert_eq!(window.state().observed().probed_pixel, None, "no pixel was selected");
    in_sight(&mut window, "Unit: mm");
    choose(&mut window, "Unit", "mm");
    window.run_steps(2);
    assert!(window.query_all_by_label_contains(" mm").next().is_some());
    window.key_press(Key::Escape);
    window.run_steps(2);
    assert_eq!(window.state().observed().measured_distance, None);
}

#[test]
fn arrows_step_and_a_range_loops_back_and_forth() {
    let mut window = open(demo(2, 8, (64, 48)), SIZE);
    settle(&mut window);
    let press = |window: &mut Window, modifiers, key| {
        window.key_press_modifiers(modifiers, key);
        window.run_steps(2);
        window.state().observed().frame
    };
    assert_eq!(press(&mut window, Modifiers::NONE, Key::ArrowRight), 1);
    assert_eq!(press(&mut window, Modifiers::SHIFT, Key::ArrowRight), 7);
    assert_eq!(press(&mut window, Modifiers::COMMAND, Key::Home), 0);
    assert_eq!(press(&mut window, Modifiers::NONE, Key::ArrowLeft), 7);
    press(&mut window, Modifiers::COMMAND, Key::Home);
    for _ in 0..2 {
        press(&mut window, Modifiers::NONE, Key::ArrowRight);
    }
    press(&mut window, Modifiers::NONE, Key::I);
    for _ in 0..2 {
        press(&mut window, Modifiers::NONE, Key::ArrowRight);
    }
    press(&mut window, Modifiers::NONE, Key::O);
    assert!(window.query_by_label("Loop over all frames").is_some());
    click(&mut window, "Play back and forth");
    click(&mut window, "Play");
    let mut seen = std::collections::BTreeSet::new();
    for _ in 0..60 {
        window.step();
        std::thread::sleep(std::time::Duration::from_millis(10));
        seen.insert(window.state().observed().frame);
    }
    assert!(seen.len() > 1 && seen.iter().all(|frame| (2..=4).contains(frame)), "{seen:?}");
    click(&mut window, "Pause");
    click(&mut window, "Loop over all frames");
    assert!(window.query_by_label("Loop over all frames").is_none());
}

#[test]
fn frames_are_marked_and_the_markers_are_gone_to() {
    let mut window = open(demo(2, 8, (64, 48)), SIZE);
    settle(&mut window);
    let go = |window: &mut Window, modifiers, key| {
        window.key_press_modifiers(modifiers, key);
        window.run_steps(2);
        window.state().observed().frame
    };
    for _ in 0..2 {
        go(&mut window, Modifiers::NONE, Key::ArrowRight);
    }
    click(&mut window, "Add marker");
    assert!(window.query_by_label("Remove marker").is_some());
    go(&mut window, Modifiers::COMMAND, Key::End);
    go(&mut window, Modifiers::SHIFT, Key::M);
    assert_eq!(go(&mut window, Modifiers::COMMAND, Key::ArrowLeft), 2);
    assert_eq!(go(&mut window, Modifiers::COMMAND, Key::ArrowLeft), 7, "around the ends");
    go(&mut window, Modifiers::SHIFT, Key::M);
    assert_eq!(go(&mut window, Modifiers::COMMAND, Key::ArrowRight), 2);
    assert_eq!(go(&mut window, Modifiers::COMMAND, Key::ArrowRight), 2, "the other one is taken away");
    assert_eq!(window.state().observed().measured_distance, None, "nothing was measured");
}

#[test]
fn keys_view_along_the_axes_from_either_side() {
    let mut window = explore();
    for (modifiers, pitch) in [(Modifiers::ALT, -90.0), (Modifiers::ALT | Modifiers::SHIFT, 90.0)] {
        window.key_press_modifiers(modifiers, Key::Z);
        settle(&mut window);
        assert!((number(&window, "Pitch") - pitch).abs() < 0.1, "{}", number(&window, "Pitch"));
    }
    window.key_press_modifiers(Modifiers::ALT, Key::X);
    settle(&mut window);
    assert!(number(&window, "Pitch").abs() < 0.1, "{}", number(&window, "Pitch"));
}

#[test]
fn a_camera_is_flown_with_at_the_speed_that_brackets_set_and_rolled_by_a_number() {
    let mut window = explore();
    let flown = |window: &mut Window| {
        window.key_press(Key::Home);
        settle(window);
        let before = position(window);
        window.key_down(Key::W);
        window.run_steps(6);
        window.key_up(Key::W);
        window.run_steps(2);
        position(window).iter().zip(before).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
    };
    let normal = flown(&mut window);
    for _ in 0..3 {
        window.key_press(Key::CloseBracket);
        window.run_steps(2);
    }
    let fast = flown(&mut window);
    assert!(fast > 2.0 * normal && normal > 0.0, "{fast} and {normal}");
    let roll = number(&window, "Roll");
    window.get_by_role_and_label(Role::SpinButton, "Roll").focus();
    window.run_steps(2);
    window.key_press(Key::ArrowUp);
    window.run_steps(2);
    settle(&mut window);
    assert_ne!(number(&window, "Roll"), roll);
}

#[test]
fn a_thumbnail_has_a_menu_with_what_can_be_done_to_its_camera() {
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    open_view(&mut window, "Cameras");
    window.get_by_label("Camera left").click_secondary();
    window.run_steps(4);
    click(&mut window, "View from it");
    settle(&mut window);
    assert_eq!(position(&window), window.state().observed().camera_positions[1]);
}

#[test]
fn another_axis_is_up_for_a_capture_that_lies_on_its_side() {
    let mut window = explore();
    let before = position(&window);
    let horizon = |window: &Window| number(window, "Roll");
    in_sight(&mut window, "Up axis");
    pick(&mut window, "Up axis", "+X");
    settle(&mut window);
    assert_eq!(position(&window), before, "the eye stays");
    assert!(horizon(&window).abs() < 0.1, "the horizon is level by the new up");
    // Orbiting to the side keeps the height over the new ground.
    drag(&mut window, "Live picture", vec2(0.5, 0.5), vec2(120.0, 0.0));
    let after = position(&window);
    assert!((after[0] - before[0]).abs() < 1e-6 && after != before, "{before:?} {after:?}");
    window.key_press(Key::Home);
    window.run_steps(3);
    assert!(horizon(&window).abs() < 0.1);
    pick(&mut window, "Up axis", "As recorded");
    settle(&mut window);
    assert!(horizon(&window).abs() < 0.1);
}

#[test]
fn views_are_kept_with_their_pictures_named_gone_to_and_removed() {
    let mut window = explore();
    window.set_size(vec2(SIZE[0], 1200.0));
    window.run_steps(4);
    settle(&mut window);
    let home = position(&window);
    window.key_press_modifiers(Modifiers::COMMAND, Key::D);
    settle(&mut window);
    assert!(window.query_by_label("Go to View 1").is_some());
    drag(&mut window, "Live picture", vec2(0.5, 0.5), vec2(90.0, 20.0));
    let away = position(&window);
    assert_ne!(away, home);
    click(&mut window, "Keep view");
    settle(&mut window);
    window.get_by_label("Name of kept view 2").focus();
    window.run_steps(2);
    window.key_press_modifiers(Modifiers::COMMAND, Key::A);
    window.get_by_label("Name of kept view 2").type_text("door");
    window.run_steps(3);
    click(&mut window, "Go to View 1");
    settle(&mut window);
    let apart = |window: &Window, place: [f64; 3]| -> f64 {
        position(window).iter().zip(place).map(|(a, b)| (a - b).abs()).sum()
    };
    assert!(apart(&window, home) < 1e-9);
    window.key_press_modifiers(Modifiers::ALT, Key::ArrowLeft);
    settle(&mut window);
    assert_eq!(position(&window), away);
    click(&mut window, "Remove View 1");
    window.run_steps(3);
    assert!(window.query_by_label("Go to View 1").is_none());
    click(&mut window, "Go to door");
    settle(&mut window);
    assert!(apart(&window, away) < 1e-9);
}
