//! Two readings of one capture: what is found is told and compared, and the capture stays as it is until a person says so.

use egui::Key;
use egui_kittest::kittest::{NodeT, Queryable};
use overlook::app::Start;
use serde_json::json;

use super::driver::{
    SIZE, Window, changed_capture, click, do_command, open, settle, shows, small_capture, small_demo, wait,
};

fn is_told(window: &Window) -> bool {
    window.state().observed().notices.iter().any(|notice| notice.contains("another reading fits better"))
}

fn positions(window: &Window) -> Vec<[f64; 3]> {
    window.state().observed().camera_positions
}

#[test]
fn a_misread_capture_is_compared_side_by_side_and_opened_otherwise_only_by_a_button() {
    let folder = tempfile::tempdir().unwrap();
    let capture = changed_capture(folder.path(), |manifest| {
        manifest["transform_direction"] = json!("world_to_camera");
    });
    let manifest = std::fs::read(capture.join("transforms.json")).unwrap();
    let mut right = open(Start::Path(small_capture()), SIZE);
    settle(&mut right);
    assert!(!is_told(&right), "{:?}", right.state().observed().notices);
    let mut window = open(Start::Path(capture.clone()), SIZE);
    settle(&mut window);
    wait(&mut window, "the finding", is_told);
    let as_read = positions(&window);
    assert_ne!(as_read, positions(&right), "nothing is changed by itself");
    window.run_steps(2);
    click(&mut window, "Compare readings…");
    wait(&mut window, "the pictures", |window| shows(window, "% of the points agree"));
    for title in ["Recorded by cam", "As the capture is read", "Other reading"] {
        assert!(shows(&window, &format!("Picture: {title}")), "{title}");
    }
    assert!(shows(&window, "\"transform_direction\": \"camera_to_world\""), "the key to write");
    assert!(shows(&window, &capture.join("transforms.json").display().to_string()), "and where");
    let shares: Vec<u32> = window
        .query_all_by_label_contains("% of the points agree")
        .map(|node| {
            let text = node.accesskit_node().value().or_else(|| node.accesskit_node().label()).unwrap();
            text.split(' ').next().unwrap().parse().unwrap()
        })
        .collect();
    assert!(shares.len() == 2 && shares[1] > 2 * shares[0] + 20, "{shares:?}");
    assert_eq!(positions(&window), as_read);
    click(&mut window, "Open under the other reading");
    wait(&mut window, "the capture", |window| positions(window) != as_read);
    settle(&mut window);
    assert_eq!(positions(&window), positions(&right));
    let notices = window.state().observed().notices;
    assert!(!is_told(&window), "{notices:?}");
    assert!(notices.iter().any(|notice| notice.contains("another reading than that of its files")));
    assert_eq!(std::fs::read(capture.join("transforms.json")).unwrap(), manifest, "files stay as they are");
    do_command(&mut window, "Compare readings");
    click(&mut window, "Open as its files say");
    wait(&mut window, "the capture", |window| positions(window) == as_read);
    settle(&mut window);
}

#[test]
fn nothing_to_compare_is_said_with_its_reason_in_the_palette() {
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    window.key_press_modifiers(egui::Modifiers::COMMAND, Key::P);
    window.run_steps(3);
    window.get_by_label("Command").type_text("compare readings");
    window.run_steps(3);
    assert!(window.get_by_label("Do: Compare readings").accesskit_node().is_disabled());
    assert!(shows(&window, "A built-in scene is read as it was made."));
    window.key_press(Key::Enter);
    window.run_steps(3);
    assert!(!shows(&window, "As the capture is read"));
}
