//! What views show in numbers leaves the window as text.

use egui_kittest::kittest::Queryable;

use super::driver::{
    SIZE, Window, click, copied, demo, look_at, open, open_view, settle, shows, small_demo, wait,
};
use egui::{Key, vec2};

/// Clicks a button that copies a table, and gives the lines that it leaves on the clipboard.
fn copied_table(window: &mut Window, name: &str) -> Vec<String> {
    window.get_all_by_label(&format!("Copy CSV of the {name}")).next().unwrap().click();
    let text = copied(window).unwrap_or_else(|| panic!("{name}: nothing was copied"));
    assert!(shows(window, &format!("The {name} is on the clipboard as CSV.")), "{name}");
    text.lines().map(str::to_owned).collect()
}

#[test]
fn the_tables_of_pixel_matrix_and_cameras_are_copied_with_a_line_of_names() {
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    look_at(&mut window, "Source picture", vec2(0.5, 0.6));
    settle(&mut window);
    let pixel = copied_table(&mut window, "pixel table");
    assert!(pixel[0].starts_with("camera,visible,depth_expected,") && pixel.len() == 4, "{pixel:?}");
    open_view(&mut window, "Matrix");
    let replaced = copied_table(&mut window, "matrix of replaced samples");
    assert_eq!(replaced[0], "camera,replaced_by,samples");
    assert_eq!(replaced.len(), 1 + 3 * 2, "{replaced:?}");
    let agreement = copied_table(&mut window, "matrix of agreement");
    assert!(agreement[0].starts_with("camera,against,what,samples,"), "{agreement:?}");
    assert!(agreement.iter().any(|line| line.starts_with("front,left,static,")), "{agreement:?}");
    open_view(&mut window, "Report");
    window.get_by_label("Copy CSV of the camera table").scroll_to_me();
    window.run_steps(3);
    let cameras = copied_table(&mut window, "camera table");
    assert!(cameras[0].starts_with("camera,pixels,kept,") && cameras.len() == 4, "{cameras:?}");
}

/// Measures a point of a sweep and stops.
fn with_a_point() -> Window {
    let mut window = open(demo(2, 1, (32, 24)), SIZE);
    settle(&mut window);
    open_view(&mut window, "Sweep");
    measure(&mut window, "Run a sweep…");
    wait(&mut window, "a point", |window| {
        shows(window, "click one to apply it") || shows(window, "click it")
    });
    window.key_press(Key::Escape);
    settle(&mut window);
    window
}

#[test]
fn a_sweep_is_copied() {
    let mut window = with_a_point();
    let sweep = copied_table(&mut window, "sweep");
    assert!(sweep[0].starts_with("label,series,kernel,psnr_filled_db,") && sweep.len() > 1, "{sweep:?}");
}

/// What the cross in the window's corner does.
fn close(window: &mut Window) {
    let viewport = window.input_mut().viewports.entry(egui::ViewportId::ROOT).or_default();
    viewport.events.push(egui::ViewportEvent::Close);
    window.run_steps(3);
}

#[test]
fn a_sweep_that_would_be_lost_can_be_saved_from_the_question() {
    let mut window = with_a_point();
    close(&mut window);
    assert!(shows(&window, "This would be lost: the sweep ("));
    for choice in ["Save sweep…", "Discard and close", "Cancel closing"] {
        assert!(window.query_by_label(choice).is_some(), "{choice}");
    }
    click(&mut window, "Cancel closing");
    assert!(!shows(&window, "This would be lost") && window.query_by_label("Sweep chart").is_some());
}
