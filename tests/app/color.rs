//! Color in both views, and what is saved of them.

use std::path::Path;

use super::driver::{
    SIZE, Window, changed_capture, choose, click, drag, fold, open, open_share, settle, share_path, share_to,
    small_demo, wait, wait_for_shared,
};
use egui::accesskit::Role;
use egui::{Key, vec2};
use egui_kittest::kittest::{NodeT, Queryable};

/// A window in the workspace that has the Color panel beside the live view.
fn with_colors() -> Window {
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    super::driver::open_view(&mut window, "Color");
    window
}

/// Mean of the pixels of a part of the window, 0 to 255, while no view marks the pixel under the pointer.
fn brightness(window: &mut Window, name: &str) -> f64 {
    window.hover_at(egui::pos2(SIZE[0] / 2.0, 12.0));
    window.run_steps(3);
    let area = window.get_by_label(name).rect();
    let [x, y, width, height] = [area.min.x, area.min.y, area.width(), area.height()].map(|side| side as u32);
    let whole = image::DynamicImage::ImageRgba8(window.render().unwrap());
    let part = whole.crop_imm(x, y, width, height).to_luma8();
    part.pixels().map(|pixel| f64::from(pixel.0[0])).sum::<f64>() / f64::from(width * height)
}

/// Turns a slider up by some steps of its key.
fn turn_up(window: &mut Window, name: &str, steps: usize) {
    window.get_by_role_and_label(Role::Slider, name).focus();
    window.run_steps(2);
    for _ in 0..steps {
        window.key_press(Key::ArrowRight);
        window.run_steps(1);
    }
    settle(window);
}

fn saved(window: &mut Window, pictures: &str, path: &Path) {
    open_share(window, "Pictures");
    choose(window, "Pictures of", pictures);
    share_to(window, path, "Save");
    wait(window, "the file", |_| path.is_file());
}

#[test]
fn exposure_brightens_both_views_alike_and_is_reset() {
    let mut window = with_colors();
    let before = ["Source picture", "Live picture"].map(|name| brightness(&mut window, name));
    turn_up(&mut window, "Exposure", 12);
    let after = ["Source picture", "Live picture"].map(|name| brightness(&mut window, name));
    assert!(before.iter().zip(after).all(|(before, after)| after > 1.2 * before), "{before:?} {after:?}");
    fold(&mut window, "Tone curve and channel");
    choose(&mut window, "Channel", "R");
    choose(&mut window, "Tone curve", "Filmic");
    settle(&mut window);
    window.get_by_label("Reset colors").scroll_to_me();
    window.run_steps(3);
    click(&mut window, "Reset colors");
    settle(&mut window);
    let reset = ["Source picture", "Live picture"].map(|name| brightness(&mut window, name));
    assert_eq!(reset, before);
    fold(&mut window, "Histogram of the source");
    assert!(window.query_by_label("Histogram of the live view").is_some());
    assert_eq!(window.get_all_by_label("Histogram of the source").count(), 2, "the line and what it opens");
    assert!(window.query_all_by_label_contains("at white").count() == 2);
}

#[test]
fn pictures_are_saved_with_alpha_and_with_depth_and_lead_to_a_figure() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = with_colors();
    window.get_by_label("Background: Transparent").scroll_to_me();
    window.run_steps(3);
    choose(&mut window, "Background", "Transparent");
    settle(&mut window);
    let [png, exr] = ["a.png", "a.exr"].map(|name| folder.path().join(name));
    saved(&mut window, "This view", &png);
    wait_for_shared(&mut window);
    let picture = image::open(&png).unwrap().to_rgba8();
    assert!(picture.pixels().any(|pixel| pixel.0[3] == 255));
    saved(&mut window, "This view", &exr);
    wait_for_shared(&mut window);
    let bytes = std::fs::read(&exr).unwrap();
    assert!(bytes.starts_with(b"\x76\x2F\x31\x01"));
    for channel in [b"A\0", b"Z\0"] {
        assert!(bytes.windows(2).take(400).any(|window| window == channel), "{channel:?}");
    }
    open_share(&mut window, "Pictures");
    click(&mut window, "Share a figure of this view");
    assert!(window.query_by_label("Caption of the figure").is_some());
}

#[test]
fn a_camera_path_is_exported_as_exr_pictures_with_depth() {
    let folder = tempfile::tempdir().unwrap();
    let pictures = folder.path().join("linear");
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    super::driver::open_view(&mut window, "Camera path");
    for _ in 0..2 {
        window.key_press(Key::K);
        window.run_steps(2);
    }
    share_path(&mut window, &[("Pictures of", "Camera path"), ("Format", "EXR")], &pictures);
    wait_for_shared(&mut window);
    for name in ["0001.exr", "0002.exr", "0003.exr"] {
        let bytes = std::fs::read(pictures.join(name)).unwrap();
        assert!(bytes.windows(2).take(400).any(|window| window == b"Z\0"), "{name} has depth");
    }
}

fn number(window: &Window, name: &str) -> f64 {
    window.query_all_by_label(name).find_map(|node| node.accesskit_node().numeric_value()).unwrap()
}

#[test]
fn the_range_of_a_value_is_dragged_on_its_histogram_and_taken_from_the_values() {
    let folder = tempfile::tempdir().unwrap();
    let values = serde_json::json!([{ "name": "red", "channel": "ViewLayer.Combined.R", "range": [0, 2] }]);
    let capture = changed_capture(folder.path(), |manifest| manifest["values"] = values);
    let mut window = open(overlook::app::Start::Path(capture), [SIZE[0], 1200.0]);
    settle(&mut window);
    super::driver::open_view(&mut window, "Color");
    window.get_by_label("Value").scroll_to_me();
    assert!(window.query_by_label("Histogram of red").is_none(), "the picture is not colored by it");
    window.get_all_by_label("Show").last().unwrap().click();
    window.run_steps(3);
    settle(&mut window);
    let range = |window: &Window| ["Range from", "Range to"].map(|name| number(window, name));
    assert_eq!(range(&window), [0.0, 2.0]);
    drag(&mut window, "Histogram of red", vec2(0.99, 0.7), vec2(-80.0, 0.0));
    let [low, high] = range(&window);
    assert!(low == 0.0 && high < 1.9, "{low} {high}");
    click(&mut window, "Range: Full");
    settle(&mut window);
    let full = range(&window);
    click(&mut window, "Range: 2–98 %");
    settle(&mut window);
    let most = range(&window);
    assert!(
        full[0] >= 0.0 && full[0] <= most[0] && most[0] < most[1] && most[1] < full[1],
        "{full:?} {most:?}"
    );
    click(&mut window, "Select this range of red");
    settle(&mut window);
    assert!(super::driver::shows(&window, "range of red"), "its samples are selected");
}
