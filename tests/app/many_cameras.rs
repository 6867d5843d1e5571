//! Thirty-two cameras, and three hundred: told apart, sorted by what matters, and every panel within the window.

use egui::{Key, vec2};
use egui_kittest::kittest::{NodeT, Queryable};

use super::driver::{SIZE, Window, choose, click, copy_table, demo, look_at, open, open_view, settle, shows};

/// Panels that list cameras.
const PANELS: [&str; 3] = ["Pixel", "Cameras", "Report"];

/// Opens every panel that lists cameras, and checks that none of their widgets reaches beyond the window.
fn every_panel_fits(window: &mut Window) {
    for panel in PANELS {
        open_view(window, panel);
        let beyond = |rect: egui::Rect| rect.right() > SIZE[0] + 1.0 || rect.bottom() > SIZE[1] + 1.0;
        for name in ["Live picture", "Commands"] {
            let rect = window.get_by_label(name).rect();
            assert!(!beyond(rect) && rect.width() > 20.0, "{panel}, {name}: {rect:?}");
        }
    }
}

#[test]
fn of_thirty_two_cameras_those_that_matter_come_first_and_the_rest_are_others() {
    let mut window = open(demo(32, 1, (48, 36)), SIZE);
    settle(&mut window);
    look_at(&mut window, "Source picture", vec2(0.5, 0.6));
    settle(&mut window);
    every_panel_fits(&mut window);
    choose(&mut window, "Source shows", "Kept by");
    settle(&mut window);
    let others =
        window.query_all_by_label_contains("others (").next().expect("some have no room of their own");
    others.click();
    window.run_steps(3);
    assert!(window.query_all_by_label_contains("extra").count() > 3, "the list names them");
    open_view(&mut window, "Pixel");
    // The pixel itself is the first row; those that cannot see the point are not in view above it.
    let rows: Vec<f32> = ["this pixel", "visible", "out of view"]
        .into_iter()
        .filter_map(|says| window.query_all_by_label(says).map(|row| row.rect().top()).reduce(f32::min))
        .collect();
    assert!(rows.len() > 1 && rows.is_sorted(), "{rows:?}");
}

#[test]
fn a_name_under_the_pointer_isolates_its_camera() {
    let mut window = open(demo(5, 1, (96, 72)), SIZE);
    settle(&mut window);
    choose(&mut window, "Source shows", "Kept by");
    settle(&mut window);
    let whole = source_colors(&mut window);
    let entry = window
        .query_all_by_label_contains(" %")
        .find(|entry| {
            let label = entry.accesskit_node().value().unwrap_or_default();
            ["left ", "right ", "high ", "front ", "close "].iter().any(|name| label.starts_with(name))
        })
        .expect("the legend names the camera");
    let at = entry.rect().center();
    window.hover_at(at);
    window.run_steps(3);
    settle(&mut window);
    let alone = source_colors(&mut window);
    assert!(alone < whole, "{alone} of {whole} pixels have a color");
    window.hover_at(egui::pos2(5.0, 5.0));
    window.run_steps(3);
    settle(&mut window);
    assert_eq!(source_colors(&mut window), whole);
}

/// Pixels of the source picture on the screen that are not gray.
fn source_colors(window: &mut Window) -> usize {
    let area = window.get_by_label("Source picture").rect();
    let shot = window.render().unwrap();
    let [x, y, width, height] = [area.min.x, area.min.y, area.width(), area.height()].map(|side| side as u32);
    let part = image::imageops::crop_imm(&shot, x, y, width, height).to_image();
    part.pixels()
        .filter(|pixel| pixel.0[..3].iter().max().unwrap() - pixel.0[..3].iter().min().unwrap() > 24)
        .count()
}

#[test]
fn a_camera_that_is_chosen_is_scrolled_to_in_the_list_of_which_only_what_is_in_view_is_drawn() {
    let mut window = open(demo(60, 1, (16, 12)), SIZE);
    settle(&mut window);
    click(&mut window, "Workspace: Explore");
    settle(&mut window);
    let row = "Camera extra54";
    assert!(window.query_by_label(row).is_none() && shows(&window, "Show all 60"));
    click(&mut window, "Commands");
    window.get_by_label("Command").type_text("show camera 'extra54'");
    window.run_steps(3);
    window.key_press(Key::Enter);
    window.run_steps(12);
    let place = window.get_by_label(row).rect();
    assert!(place.bottom() < SIZE[1], "{place}");
    let rows = window.query_all_by_label_contains("Camera extra").count();
    assert!((3..40).contains(&rows), "{rows} rows");
}

#[test]
fn three_hundred_views_fit_into_every_panel_and_only_what_is_in_view_is_drawn() {
    let mut window = open(demo(300, 1, (16, 12)), SIZE);
    settle(&mut window);
    look_at(&mut window, "Source picture", vec2(0.5, 0.6));
    settle(&mut window);
    every_panel_fits(&mut window);
    open_view(&mut window, "Cameras");
    let cards = window.query_all_by_label_contains("Camera extra").count();
    assert!((3..60).contains(&cards), "{cards} cards");
    open_view(&mut window, "Pixel");
    let rows = window.query_all_by_label_contains("Go to the point in").count();
    assert!((3..40).contains(&rows), "{rows} rows");
    open_view(&mut window, "Report");
    assert!(window.query_all_by_label("Matrix of 300 cameras").next().is_some());
    copy_table(&mut window, "Report", "CSV", "matrix of replaced samples");
    window.run_steps(3);
    assert!(shows(&window, "The matrix of replaced samples is on the clipboard as CSV."));
}
