//! The inspector, driven as a person does: pixels are argued about, views dock, numbers can be read.

use super::driver::{
    SIZE, Window, choose, click, demo, drag, look_at, measure, open, open_store, open_view, pick, save_store,
    settle, shows, small_demo, wait,
};
use egui::{Key, vec2};
use egui_kittest::kittest::Queryable;

#[test]
fn a_pixel_clicked_in_the_source_is_argued_about_by_every_camera() {
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    assert!(shows(&window, "No pixel selected"));
    look_at(&mut window, "Source picture", vec2(0.5, 0.6));
    settle(&mut window);
    let kept = window.state().observed().probed_pixel.unwrap();
    for camera in ["front", "left", "right"] {
        assert!(window.query_by_label(&format!("Go to the point in {camera}")).is_some(), "{camera}");
    }
    assert!(shows(&window, "this pixel") && shows(&window, "Spans of the pixel: "));
    // Kept: pointing elsewhere changes nothing until it is let go of.
    window.hover_at(window.get_by_label("Source picture").rect().min + vec2(120.0, 60.0));
    settle(&mut window);
    assert_eq!(window.state().observed().probed_pixel.unwrap(), kept);
    click(&mut window, "Unpin pixel");
    window.hover_at(window.get_by_label("Source picture").rect().min + vec2(122.0, 64.0));
    settle(&mut window);
    assert_ne!(window.state().observed().probed_pixel.unwrap(), kept);
}

/// The pixels of a picture in the window.
fn seen(window: &mut Window, picture: &str) -> image::RgbaImage {
    let area = window.get_by_label(picture).rect();
    let [x, y, width, height] = [area.min.x, area.min.y, area.width(), area.height()].map(|side| side as u32);
    image::imageops::crop_imm(&window.render().unwrap(), x, y, width, height).to_image()
}

#[test]
fn the_pixel_under_the_pointer_is_marked_in_the_other_picture_until_the_pointer_leaves_its_own() {
    let away = egui::pos2(5.0, 5.0);
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    for (own, other) in [("Source picture", "Live picture"), ("Live picture", "Source picture")] {
        window.hover_at(away);
        settle(&mut window);
        let bare = seen(&mut window, other);
        let area = window.get_by_label(own).rect();
        window.hover_at(area.center());
        wait(&mut window, "the pixel", |window| window.state().observed().probed_pixel.is_some());
        settle(&mut window);
        assert!(seen(&mut window, other) != bare, "marked in the {other}");
        window.hover_at(away);
        settle(&mut window);
        assert!(seen(&mut window, other) == bare, "the mark in the {other} stays");
    }
    // Beside the picture, in its own view, nothing is pointed at.
    let bare = seen(&mut window, "Live picture");
    let area = window.get_by_label("Source picture").rect();
    let picture = vec2(96.0, 72.0) * (area.width() / 96.0).min(area.height() / 72.0);
    let beside = area.center()
        + (area.size() + picture) / 4.0
            * vec2(
                f32::from(u8::from(area.width() > picture.x + 1.0)),
                f32::from(u8::from(area.height() > picture.y + 1.0)),
            );
    assert!(beside != area.center(), "the picture fills its view");
    window.hover_at(beside);
    settle(&mut window);
    assert!(seen(&mut window, "Live picture") == bare, "marked from beside the picture");
}

#[test]
fn a_row_of_the_argument_shows_the_point_in_that_camera() {
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    look_at(&mut window, "Source picture", vec2(0.5, 0.7));
    settle(&mut window);
    let kept = window.state().observed().probed_pixel.unwrap();
    click(&mut window, "Go to the point in left");
    settle(&mut window);
    assert_eq!(window.state().observed().source_camera, 1);
    assert_eq!(window.state().observed().probed_pixel.unwrap(), kept, "the pixel that is argued about stays");
    click(&mut window, "Cameras");
    settle(&mut window);
    click(&mut window, "Camera right");
    assert_eq!(window.state().observed().source_camera, 2);
}

#[test]
fn a_pixel_clicked_in_the_live_view_leads_to_the_camera_that_painted_it() {
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    look_at(&mut window, "Live picture", vec2(0.45, 0.6));
    settle(&mut window);
    let (camera, x, y) = window.state().observed().probed_pixel.unwrap();
    assert!(camera < 3 && x < 96 && y < 72);
    assert!(shows(&window, "Kept:"), "what is painted was kept");
    window.key_press(Key::Escape);
    // The pointer still rests on it.
    wait(&mut window, "the pixel under the pointer", |window| window.query_by_label("Pin pixel").is_some());
}

#[test]
fn views_open_from_the_menu_and_the_layout_is_reset() {
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    for (view, holds) in
        [("Time", "Span map"), ("Stress test", "No stress test yet"), ("Report", "What was dropped, and why")]
    {
        open_view(&mut window, view);
        assert!(shows(&window, holds), "{view}");
    }
    for holds in ["Which camera replaces which", "of samples in memory"] {
        assert!(shows(&window, holds), "{holds}");
    }
    click(&mut window, "Panels");
    click(&mut window, "Reset layout");
    settle(&mut window);
    assert!(window.query_by_label("Stress test").is_none());
    click(&mut window, "Help");
    click(&mut window, "Log");
    assert!(shows(&window, "Pruned the capture"));
    click(&mut window, "Close help");
}

#[test]
fn both_views_show_which_samples_others_confirm_and_a_store_says_that_it_does_not_know() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    assert!(!shows(&window, "confirmed ") && !shows(&window, "alone "));
    choose(&mut window, "Source shows", "Agreement");
    settle(&mut window);
    // Each with its share.
    for name in ["confirmed ", "contradicted ", "alone "] {
        assert!(shows(&window, name), "{name}");
    }
    choose(&mut window, "Source shows", "Picture");
    window.key_press_modifiers(egui::Modifiers::COMMAND, Key::P);
    window.run_steps(2);
    window.get_by_label("Command").type_text("live view shows: agreement");
    window.run_steps(2);
    window.key_press(Key::Enter);
    settle(&mut window);
    for name in ["confirmed", "contradicted", "alone"] {
        assert!(window.query_by_label(name).is_some(), "{name}");
    }
    let path = save_store(&mut window, folder.path());
    open_store(&mut window, &path);
    assert!(shows(&window, "A store does not record agreement"));
}

#[test]
fn the_pixel_stays_while_time_passes_and_overlays_change() {
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    look_at(&mut window, "Source picture", vec2(0.5, 0.6));
    for overlay in ["Kept by", "Motion"] {
        choose(&mut window, "Source shows", overlay);
        window.key_press(Key::Period);
        settle(&mut window);
        wait(&mut window, "the argument", |window| shows(window, "this pixel"));
    }
    assert_eq!(window.state().observed().frame, 2);
}

#[test]
fn a_threshold_is_dragged_on_its_histogram_and_taken_back() {
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    let tolerance = |window: &Window| window.state().observed().settings.pruning.depth_tolerance;
    assert_eq!(tolerance(&window), 1.0);
    drag(&mut window, "Depth tolerance on its histogram", vec2(0.52, 0.6), vec2(60.0, 0.0));
    let dragged = tolerance(&window);
    assert!(dragged > 2.0, "{dragged}");
    settle(&mut window);
    window.key_press_modifiers(egui::Modifiers::COMMAND, Key::Z);
    window.run_steps(2);
    assert_eq!(tolerance(&window), 1.0, "the whole drag is one change");
    window.key_press_modifiers(egui::Modifiers::COMMAND, Key::Y);
    window.run_steps(2);
    assert_eq!(tolerance(&window), dragged);
    click(&mut window, "Undo");
    assert_eq!(tolerance(&window), 1.0);
    settle(&mut window);
    assert!(window.state().observed().report.unwrap().1);
}

#[test]
fn the_button_for_undo_lists_what_was_changed_and_goes_back_to_any_of_it() {
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    let start = window.state().observed().settings.clone();
    pick(&mut window, "Pruning method", "Off");
    pick(&mut window, "Presets", "Aggressive");
    window.hover_at(window.get_by_label("Undo").rect().center());
    window.run_steps(6);
    assert!(shows(&window, "Undo (Ctrl+Z): "));
    window.get_by_label("Undo").click_secondary();
    window.run_steps(4);
    assert!(shows(&window, "Undo 1: "));
    click(&mut window, "Undo 2: Pruning method: Highest sampling rate » Off");
    assert_eq!(window.state().observed().settings, &start);
    assert!(!shows(&window, "Undo 1: "), "the list closes");
    settle(&mut window);
}

#[test]
fn presets_are_taken_and_two_settings_take_turns() {
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    click(&mut window, "Settings B");
    pick(&mut window, "Presets", "Conservative");
    assert_eq!(window.state().observed().settings.pruning.normal_tolerance, 15.0);
    click(&mut window, "Settings A");
    assert_eq!(window.state().observed().settings, &overlook_engine::settings::Settings::default());
    click(&mut window, "Settings B");
    assert_eq!(window.state().observed().settings.pruning.normal_tolerance, 15.0);
    settle(&mut window);
}

#[test]
fn two_pictures_of_one_place_are_wiped_flipped_and_subtracted() {
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    open_view(&mut window, "Compare");
    wait(&mut window, "the comparison", |window| shows(window, "of pixels covered on one side only"));
    assert!(shows(&window, "PSNR ") || shows(&window, "identical where both"));
    drag(&mut window, "Comparison", vec2(0.5, 0.5), vec2(40.0, 0.0));
    choose(&mut window, "Compare by", "Flip");
    pick(&mut window, "Right side", "Points");
    settle(&mut window);
    choose(&mut window, "Compare by", "Difference");
    assert!(shows(&window, "8-bit steps"));
    click(&mut window, "Lock the range");
    assert!(window.query_by_label("Fit the range").is_some());
    for (measure, bar) in [("Signed", "brighter, 8-bit steps"), ("FLIP", "FLIP 0")] {
        choose(&mut window, "Difference in", measure);
        settle(&mut window);
        assert!(shows(&window, bar) && window.query_by_label("Lock the range").is_some(), "{measure}");
    }
    window.hover_at(window.get_by_label("Comparison").rect().center());
    window.run_steps(3);
    assert!(shows(&window, "· left ") && shows(&window, "· right "), "the pixel under the pointer");
    pick(&mut window, "Left side", "Truth");
    wait(&mut window, "the trouble", |window| shows(window, "These two cannot be compared here"));
    click(&mut window, "From");
    for vantage in ["True picture 1", "True picture 5"] {
        assert!(window.query_by_label(vantage).is_some(), "{vantage}");
    }
    window.get_by_label("Camera left, held out").click();
    window.run_steps(3);
    wait(&mut window, "the comparison", |window| !shows(window, "These two cannot be compared here"));
    settle(&mut window);
    window.hover_at(egui::pos2(5.0, 5.0));
    window.run_steps(3);
    assert!(shows(&window, "mean FLIP"));
    assert!(window.state().observed().notices.is_empty());
}

#[test]
fn in_a_small_window_what_is_compared_stands_above_and_how_below() {
    let mut window = open(small_demo(), [1024.0, 640.0]);
    settle(&mut window);
    open_view(&mut window, "Compare");
    choose(&mut window, "Compare by", "Difference");
    let row = |names: &[&str]| {
        let rects: Vec<egui::Rect> = names.iter().map(|name| window.get_by_label(name).rect()).collect();
        for pair in rects.windows(2) {
            assert!(pair[0].right() <= pair[1].left() + 0.5, "{names:?}: {pair:?}");
            assert!((pair[0].center().y - pair[1].center().y).abs() < 1.0, "{names:?}: {pair:?}");
        }
        rects[0]
    };
    let above = row(&["Left side", "Right side", "From"]);
    let below = row(&["Compare by: Wipe", "Compare by: Flip", "Compare by: Difference"]);
    row(&["Difference in: Absolute", "Difference in: Signed", "Difference in: FLIP"]);
    assert!(above.bottom() <= below.top() && above.left() - below.left() < 1.0);
}

#[test]
fn the_span_map_shows_every_level_of_the_tree_and_takes_to_its_frames() {
    let mut window = open(demo(2, 8, (48, 36)), SIZE);
    settle(&mut window);
    open_view(&mut window, "Time");
    let spans = &window.state().observed().report.unwrap().0.spans;
    let lengths: std::collections::BTreeSet<usize> = spans.iter().map(|span| span.span.len()).collect();
    assert!(lengths.len() > 2, "{lengths:?}");
    for length in lengths {
        let row = if length == 1 { "1 frame".to_owned() } else { format!("{length} frames") };
        assert!(shows(&window, &format!("Samples stored for {row}")), "{row}");
    }
    drag(&mut window, "Span map", vec2(0.95, 0.5), vec2(2.0, 0.0));
    assert_eq!(window.state().observed().frame, 7);
}

#[test]
fn a_sweep_draws_its_points_as_they_come_and_is_cancelled() {
    let mut window = open(demo(2, 2, (48, 36)), SIZE);
    settle(&mut window);
    open_view(&mut window, "Stress test");
    assert!(shows(&window, "No stress test yet"));
    open_view(&mut window, "Sweep");
    assert!(shows(&window, "No sweep yet"));
    measure(&mut window, "Run a sweep…");
    wait(&mut window, "the first points", |window| shows(window, "2 settings; click one to apply it"));
    assert!(window.query_by_label("Sweep chart").is_some());
    assert!(shows(&window, "your settings") && shows(&window, "Pareto front"));
    assert!(shows(&window, "Sweep: "), "the line at the bottom");
    pick(&mut window, "X axis", "Rendering a view, ms");
    window.key_press(Key::Escape);
    settle(&mut window);
    let notices = window.state().observed().notices;
    assert!(notices.len() == 1 && notices[0].starts_with("Sweep stopped: After "), "{notices:?}");
    let known: usize =
        notices[0]["Sweep stopped: After ".len()..].split(' ').next().unwrap().parse().unwrap();
    click(&mut window, "Resume");
    wait(&mut window, "another point", |window| {
        (known + 1..known + 20).any(|count| shows(window, &format!("{count} settings; click one")))
    });
    window.key_press(Key::Escape);
    window.key_press(Key::Escape);
    settle(&mut window);
}

#[test]
fn kernels_are_compared_on_an_opened_store() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    let path = save_store(&mut window, folder.path());
    open_store(&mut window, &path);
    open_view(&mut window, "Compare");
    pick(&mut window, "Left side", "Points");
    // Over the pictures the pointer asks for a pixel.
    window.hover_at(egui::pos2(5.0, 5.0));
    wait(&mut window, "the comparison", |window| shows(window, "of pixels covered on one side only"));
    assert!(shows(&window, "PSNR "), "two empty pictures are equal");
}
