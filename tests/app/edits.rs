//! Editing by hand with the pointer: drawing in source pictures and in the live view, and the panel of all of it.

use egui::accesskit::Role;
use egui::{Key, Modifiers, vec2};
use egui_kittest::kittest::{NodeT, Queryable};

use super::driver::{SIZE, Window, choose, click, drag, look_at, open, open_view, settle, shows, small_demo};
use super::layout_faults::faults;

/// A window with the panel of edits beside the source picture and the live view.
fn editing() -> Window {
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    open_view(&mut window, "Edits");
    window
}

/// Draws around or over something in the middle of a picture.
fn draw(window: &mut Window, picture: &str) {
    let start = window.get_by_label(picture).rect().center();
    let button = |pos, pressed| egui::Event::PointerButton {
        pos,
        button: egui::PointerButton::Primary,
        pressed,
        modifiers: Modifiers::NONE,
    };
    window.event(egui::Event::PointerMoved(start));
    window.event(button(start, true));
    window.step();
    let end = start + vec2(30.0, 24.0);
    for at in [start + vec2(12.0, 0.0), start + vec2(30.0, 0.0), end] {
        window.event(egui::Event::PointerMoved(at));
        window.step();
    }
    window.event(button(end, false));
    window.run_steps(2);
    settle(window);
}

fn press(window: &mut Window, modifiers: Modifiers, key: Key) {
    window.key_press_modifiers(modifiers, key);
    window.run_steps(3);
    settle(window);
}

#[test]
fn a_thing_is_outlined_or_brushed_over_in_a_source_picture_and_in_the_live_view_and_deleted() {
    let mut window = editing();
    for (key, picture, selected) in [
        (Key::R, "Source picture", "seen by "),
        (Key::L, "Live picture", "outline"),
        (Key::B, "Source picture", "seen by "),
        (Key::B, "Live picture", "outline"),
    ] {
        press(&mut window, Modifiers::NONE, key);
        draw(&mut window, picture);
        assert!(shows(&window, selected), "{picture}");
        assert!(shows(&window, "in memory"), "{picture}: the selection is counted");
        press(&mut window, Modifiers::NONE, Key::Delete);
        assert!(shows(&window, "deleted ("), "{picture}");
        press(&mut window, Modifiers::COMMAND, Key::Z);
        assert!(shows(&window, "No edits yet"), "{picture}");
    }
}

/// Clicks in the middle of a picture.
fn click_in(window: &mut Window, picture: &str) {
    let pos = window.get_by_label(picture).rect().center();
    window.hover_at(pos);
    window.run_steps(2);
    for pressed in [true, false] {
        let button = egui::PointerButton::Primary;
        window.event(egui::Event::PointerButton { pos, button, pressed, modifiers: Modifiers::NONE });
        window.step();
    }
    settle(window);
}

/// A number of the panel.
fn number(window: &Window, name: &str) -> f64 {
    window.query_all_by_label(name).find_map(|node| node.accesskit_node().numeric_value()).unwrap()
}

/// Types a number into a field of the panel.
fn type_number(window: &mut Window, name: &str, number: &str) {
    window.get_by_role_and_label(Role::SpinButton, name).focus();
    window.run_steps(2);
    window.key_press_modifiers(Modifiers::COMMAND, Key::A);
    window.event(egui::Event::Text(number.to_owned()));
    window.key_press(Key::Enter);
    window.run_steps(3);
}

#[test]
fn a_box_is_set_by_its_handles_and_by_numbers() {
    let mut window = editing();
    // They would lie over its handles.
    click(&mut window, "Hide cameras");
    click(&mut window, "Select Box");
    settle(&mut window);
    assert!(shows(&window, "box") && shows(&window, "in memory"));
    let here = window.state().observed().live_position;
    let middle = window.get_by_label("Move shape").rect().center();
    let sides = ["X", "Y", "Z"].into_iter().filter_map(|axis| {
        let name = format!("Drag side +{axis}");
        let handle = window.query_by_label(&name).map(|handle| handle.rect().center());
        handle.map(|at| (axis, at - middle))
    });
    let (axis, along) = sides.max_by(|a, b| a.1.length().total_cmp(&b.1.length())).unwrap();
    let of_axis =
        |window: &Window| ["Half size", "Center"].map(|name| number(window, &format!("{name} {axis}")));
    let [half, center] = of_axis(&window);
    drag(&mut window, &format!("Drag side +{axis}"), vec2(0.5, 0.5), along.normalized() * 20.0);
    settle(&mut window);
    let [wider, beside] = of_axis(&window);
    assert!(wider > half && beside != center, "the opposite side stays: {wider} {beside}");
    assert!(((wider - half) - (beside - center).abs()).abs() < 0.01 * half, "{wider} {beside}");
    let centers = |window: &Window| ["X", "Y", "Z"].map(|axis| number(window, &format!("Center {axis}")));
    let before = centers(&window);
    drag(&mut window, "Move shape", vec2(0.5, 0.5), vec2(25.0, 0.0));
    settle(&mut window);
    assert_ne!(centers(&window), before);
    assert_eq!(of_axis(&window)[0], wider, "moved as it is");
    assert_eq!(window.state().observed().live_position, here, "the view does not turn with it");
    for (name, text) in [("Half size X", "0.25"), ("Center Z", "0.5"), ("Turned Y", "30")] {
        type_number(&mut window, name, text);
        assert_eq!(number(&window, name), text.parse::<f64>().unwrap(), "{name}");
    }
    settle(&mut window);
    assert!(shows(&window, "in memory"));
}

#[test]
fn the_check_box_of_an_edit_switches_it_off_and_on() {
    let mut window = editing();
    press(&mut window, Modifiers::NONE, Key::R);
    draw(&mut window, "Source picture");
    press(&mut window, Modifiers::NONE, Key::Delete);
    let acts = |window: &Window| shows(window, "deleted (");
    assert!(acts(&window));
    for on in [false, true, false] {
        click(&mut window, "Edit 1 acts");
        settle(&mut window);
        assert_eq!(acts(&window), on);
    }
    press(&mut window, Modifiers::COMMAND, Key::Z);
    assert!(acts(&window), "switching is undone");
    assert_eq!(window.get_all_by_label_contains("Name of edit").count(), 1, "the edit stays in the list");
}

#[test]
fn a_click_selects_a_color_and_near_and_far_are_numbers() {
    let mut window = editing();
    press(&mut window, Modifiers::NONE, Key::C);
    let color =
        |window: &Window| ["red", "green", "blue"].map(|part| number(window, &format!("Color {part}")));
    click_in(&mut window, "Live picture");
    let clicked = color(&window);
    assert!(shows(&window, "in memory") && number(&window, "Tolerance X") > 0.0);
    // The selection is shown in another color, which is not the one that is clicked on.
    click_in(&mut window, "Live picture");
    assert_eq!(color(&window), clicked);
    click_in(&mut window, "Source picture");
    assert!(shows(&window, "in memory"));
    press(&mut window, Modifiers::COMMAND, Key::I);
    assert!(shows(&window, "not color"));
    press(&mut window, Modifiers::NONE, Key::C);
    click(&mut window, "Select by rule");
    click(&mut window, "Select Near and far");
    settle(&mut window);
    assert!(shows(&window, "range of depth"));
    assert!(number(&window, "Depth from") == 0.0 && number(&window, "Depth to") > 0.0);
}

#[test]
fn a_click_selects_a_surface_which_grows_and_is_inverted_by_keys() {
    let mut window = editing();
    click(&mut window, "Select Same surface");
    click_in(&mut window, "Live picture");
    assert!(window.query_by_label("Step X").is_some(), "a surface is selected");
    press(&mut window, Modifiers::NONE, Key::G);
    assert!(shows(&window, "surface, grown"));
    press(&mut window, Modifiers::SHIFT, Key::G);
    assert!(shows(&window, "surface, grown, shrunk"));
    press(&mut window, Modifiers::COMMAND, Key::I);
    assert!(shows(&window, "not surface"));
}

#[test]
fn a_mask_is_drawn_on_a_camera_over_a_range_of_frames_and_brackets_change_the_brush() {
    let mut window = editing();
    let last = |window: &Window| window.get_by_label("Mask: last frame").rect();
    assert!(last(&window).width() > 0.0);
    click(&mut window, "Draw Mask");
    press(&mut window, Modifiers::NONE, Key::OpenBracket);
    draw(&mut window, "Source picture");
    draw(&mut window, "Source picture");
    assert_eq!(window.get_all_by_label_contains("Name of edit").count(), 1, "strokes are one mask");
    // In the live view the mask tool leaves turning as it is.
    let before = window.state().observed().live_position;
    drag(&mut window, "Live picture", vec2(0.5, 0.5), vec2(70.0, 15.0));
    settle(&mut window);
    assert_ne!(window.state().observed().live_position, before);
}

#[test]
fn the_panel_of_edits_fits_its_window_with_every_tool_in_both_themes() {
    let mut window = editing();
    look_at(&mut window, "Source picture", vec2(0.55, 0.6));
    let mut wrong = Vec::new();
    for theme in ["Light theme", "Dark theme"] {
        click(&mut window, theme);
        for tool in ["Select Brush", "Select Same surface", "Draw Mask"] {
            click(&mut window, tool);
            press(&mut window, Modifiers::NONE, Key::G);
            choose(&mut window, "Drawing selects", "All behind");
            window.hover_at(egui::pos2(1.0, 1.0));
            window.run_steps(4);
            wrong.extend(faults(&window).into_iter().map(|fault| format!("{theme}, {tool}: {fault}")));
            click(&mut window, tool);
        }
        click(&mut window, "Select Sphere");
        choose(&mut window, "Edit acts at", "Range");
        settle(&mut window);
        wrong.extend(faults(&window).into_iter().map(|fault| format!("{theme}, a sphere: {fault}")));
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
