//! Numbers and words beside the pictures: one whole in each panel, warnings that lead somewhere, fields that take what is typed.

use super::driver::{
    SIZE, Window, changed_capture, choose, click, do_command, measure, open, open_store, open_view, pick,
    save_store, settle, shows, small_demo, wait,
};
use egui::{Event, Key};
use egui_kittest::kittest::{NodeT, Queryable};
use overlook::app::Start;

/// The text of the one label that holds `part`.
fn text_with(window: &Window, part: &str) -> String {
    let mut found = window.query_all_by_label_contains(part);
    let node = found.next().unwrap_or_else(|| panic!("nothing says {part:?}"));
    node.accesskit_node().value().or_else(|| node.accesskit_node().label()).unwrap()
}

/// The number before a percent sign.
fn percent_in(text: &str) -> f64 {
    let before = text.split('%').next().unwrap().trim_end();
    before.rsplit(|c: char| !c.is_ascii_digit() && c != '.').next().unwrap().parse().unwrap()
}

#[test]
fn the_line_below_the_source_picture_and_its_legend_tell_one_share_of_kept_pixels() {
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    let below = percent_in(&text_with(&window, "pixels are kept ("));
    choose(&mut window, "Source shows", "Kept by");
    settle(&mut window);
    assert!(!shows(&window, "pixels are kept ("), "the share is told once");
    let mut shares: Vec<f64> = Vec::new();
    for name in ["kept ", "front ", "left ", "right ", "dropped ", "no depth "] {
        let entries = window.query_all_by_label_contains(name);
        let texts = entries.filter_map(|node| node.accesskit_node().value());
        shares.extend(
            texts.filter(|text| text.ends_with('%') && text.starts_with(name)).map(|text| percent_in(&text)),
        );
    }
    assert_eq!(shares[0], below, "{shares:?}");
    let sum: f64 = shares.iter().sum();
    assert!((sum - 100.0).abs() < 0.3, "all pixels are counted once: {shares:?}");
}

#[test]
fn a_camera_in_a_wrong_place_is_called_a_pose_error_that_leads_to_the_matrix() {
    let folder = tempfile::tempdir().unwrap();
    let capture = changed_capture(folder.path(), |manifest| {
        for frame in manifest["frames"].as_array_mut().unwrap() {
            if frame["camera"] == "cam1" {
                let y = &mut frame["transform_matrix"][1][3];
                *y = serde_json::json!(y.as_f64().unwrap() + 0.3);
            }
        }
    });
    let mut window = open(Start::Path(capture), SIZE);
    settle(&mut window);
    assert!(!shows(&window, "Check the capture: "), "the pose was corrected");
    click(&mut window, "Commands");
    window.get_by_label("Command").type_text("correct poses off");
    window.run_steps(3);
    click(&mut window, "Do: Correct poses: Off");
    settle(&mut window);
    let warning = text_with(&window, "Check the capture: ");
    assert_eq!(warning, "Check the capture: pose error");
    assert!(shows(&window, "cam1"), "the camera is named");
    window.get_all_by_label("Show in Report").next().unwrap().click();
    window.run_steps(3);
    settle(&mut window);
    assert!(window.state().observed().views_in_sight.contains(&"Report"));
    assert!(shows(&window, "Pose error: "), "the report says the same");
    assert!(
        !window.state().observed().notices.iter().any(|notice| notice.contains("pose error")),
        "and the warning is gone"
    );
}

#[test]
fn a_typed_name_takes_the_place_of_the_one_that_is_proposed_and_enter_saves_it_with_its_ending() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    do_command(&mut window, "Save settings");
    window.run_steps(3);
    // No click and no selecting: the caret is in the field, and what it holds is selected.
    window.event(Event::Text(folder.path().join("mine").display().to_string()));
    window.run_steps(3);
    window.key_press(Key::Enter);
    window.run_steps(3);
    let file = folder.path().join("mine.toml");
    wait(&mut window, "the file", |_| file.is_file());
    assert!(window.query_by_label("Path").is_none());
}

#[test]
fn of_a_stores_settings_those_of_rendering_come_first() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    let path = save_store(&mut window, folder.path());
    let top = |window: &Window, name: &str| window.get_by_label(name).rect().top();
    assert!(
        window
            .query_by_label("Kernel")
            .is_none_or(|_| top(&window, "Pruning method") < top(&window, "Kernel"))
    );
    open_store(&mut window, &path);
    open_view(&mut window, "Settings");
    let panel = window.get_by_label("Kernel").rect();
    assert!(panel.top() < 0.5 * SIZE[1] && panel.bottom() < SIZE[1], "{panel}");
    pick(&mut window, "Kernel", "Point");
    settle(&mut window);
    assert_eq!(window.state().observed().settings.render.kernel, overlook_engine::settings::Kernel::Point);
}

#[test]
fn the_sweep_names_its_axes_and_its_kernels() {
    let mut window = open(super::driver::demo(2, 1, (32, 24)), SIZE);
    settle(&mut window);
    open_view(&mut window, "Sweep");
    measure(&mut window, "Run a sweep…");
    wait(&mut window, "a point", |window| shows(window, "settings; click one to apply it"));
    for name in ["X axis", "Y axis", "Export Sweep"] {
        assert!(window.query_by_label(name).is_some(), "{name}");
    }
    assert!(shows(&window, "Gather") || shows(&window, "Interpolate cameras"), "the kernel of the points");
    window.key_press(Key::Escape);
    settle(&mut window);
}
