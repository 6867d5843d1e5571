//! Drives the whole window as a person does, off screen: open, look, turn thresholds, cancel, save, open again, fail.

use super::driver::{
    SIZE, Window, choose, click, demo, drag, drop_on, open, open_store, pick, save_store, settle, show_holes,
    shows, small_capture, small_demo, type_path, wait,
};
use std::path::Path;

use egui::Key;
use egui_kittest::kittest::{NodeT, Queryable};
use overlook::app::Start;
use overlook_engine::settings::{Fill, Settings};

#[test]
fn a_demo_opens_and_both_views_show_it() {
    let mut window = open(small_demo(), SIZE);
    wait(&mut window, "the first live picture", |window| window.state().observed().live_coverage.is_some());
    settle(&mut window);
    let (report, current) = window.state().observed().report.unwrap();
    assert!(current && report.samples_kept < report.samples_in);
    assert_eq!(report.samples_in, 3 * 4 * 96 * 72);
    let (_, coverage) = window.state().observed().live_coverage.unwrap();
    assert!(coverage > 0.1, "{coverage}");
    assert!(shows(&window, "Samples kept") && shows(&window, "dB vs unpruned"));
    assert!(window.state().observed().notices.is_empty());
}

#[test]
fn a_changed_threshold_previews_at_once_and_reruns_the_capture() {
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    let before = window.state().observed().report.unwrap().0.samples_kept;
    pick(&mut window, "Pruning method", "Off");
    assert!(!window.state().observed().report.unwrap().1, "the old numbers are marked as out of date");
    assert!(shows(&window, "out of date"));
    settle(&mut window);
    let (report, current) = window.state().observed().report.unwrap();
    assert!(current && report.samples_kept > before);
    click(&mut window, "Reset Pruning method");
    settle(&mut window);
    assert_eq!(window.state().observed().report.unwrap().0.samples_kept, before);
}

/// What the live view shows, without its frame.
fn live_picture(window: &mut Window) -> image::RgbaImage {
    let area = window.get_by_label("Live picture").rect();
    let picture = window.render().unwrap();
    let (left, top) = (area.left() as u32 + 8, area.top() as u32 + 8);
    let (width, height) = (area.width() as u32 - 16, area.height() as u32 - 16);
    image::imageops::crop_imm(&picture, left, top, width, height).to_image()
}

/// Pixels that differ between two pictures, as a share of all.
fn changed(before: &image::RgbaImage, after: &image::RgbaImage) -> f64 {
    let changed = before.pixels().zip(after.pixels()).filter(|(a, b)| a != b).count();
    changed as f64 / f64::from(before.width() * before.height())
}

/// What the legend says of holes that are filled, and of holes that are hatched.
const FILLED: &str = "filled (invented)";
const HATCHED: &str = "hole: no sample reached it";

/// The number in per cent that a legend tells of something; 0 where it does not speak of it.
fn told_percent(window: &Window, name: &str) -> f64 {
    let mut labels = window.query_all_by_label_contains(name).filter_map(|node| {
        let text = node.accesskit_node().value().or_else(|| node.accesskit_node().label())?;
        text.strip_prefix(name)?.trim().strip_suffix(" %")?.parse().ok()
    });
    labels.next().unwrap_or(0.0)
}

#[test]
fn holes_are_filled_and_the_key_the_toolbar_and_the_palette_hatch_them() {
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    let (filled, coverage) = (live_picture(&mut window), window.state().observed().live_coverage);
    let holes = 1.0 - coverage.unwrap().1;
    assert!(shows(&window, FILLED) && !shows(&window, HATCHED));
    // What is invented and what is the background are told apart; together they are the holes.
    let told = told_percent(&window, FILLED) + told_percent(&window, "background ");
    assert!((told - 100.0 * holes).abs() < 0.11, "{told} of {holes}");
    window.key_press(Key::H);
    settle(&mut window);
    assert!(shows(&window, HATCHED) && !shows(&window, FILLED));
    let hatched = live_picture(&mut window);
    assert!(changed(&filled, &hatched) > 0.5 * holes, "{holes} are holes");
    for turn in ["key", "toolbar", "palette"] {
        let choose_by = |window: &mut Window, choice: &str| match turn {
            "key" => window.key_press(Key::H),
            "toolbar" => show_holes(window, choice),
            _ => {
                window.key_press_modifiers(egui::Modifiers::COMMAND, Key::P);
                window.run_steps(2);
                window.get_by_label("Command").type_text(&format!("holes {choice}"));
                window.run_steps(2);
                window.key_press(Key::Enter);
            }
        };
        for (choice, expected) in [("Fill", &filled), ("Show", &hatched)] {
            choose_by(&mut window, choice);
            settle(&mut window);
            assert_eq!(changed(&live_picture(&mut window), expected), 0.0, "{choice} by {turn}");
            assert_eq!(window.state().observed().live_coverage, coverage);
        }
    }
    assert_eq!(*window.state().observed().settings, Settings::default(), "what is exported stays filled");
}

#[test]
fn holes_that_the_settings_leave_are_hatched_and_the_toolbar_fills_them_again() {
    // Tall enough for the last of the settings.
    let mut window = open(small_demo(), [SIZE[0], 2100.0]);
    settle(&mut window);
    let (filled, coverage) = (live_picture(&mut window), window.state().observed().live_coverage);
    pick(&mut window, "Hole filling", "None");
    settle(&mut window);
    assert_eq!(window.state().observed().settings.render.fill, Fill::None);
    assert!(shows(&window, HATCHED) && !shows(&window, FILLED));
    assert!(changed(&filled, &live_picture(&mut window)) > 0.05);
    assert_eq!(window.state().observed().live_coverage, coverage);
    show_holes(&mut window, "Fill");
    settle(&mut window);
    assert_eq!(window.state().observed().settings.render.fill, Fill::PushPull);
    assert_eq!(changed(&filled, &live_picture(&mut window)), 0.0);
    window.key_press_modifiers(egui::Modifiers::COMMAND, Key::Z);
    settle(&mut window);
    assert_eq!(window.state().observed().settings.render.fill, Fill::None, "a setting is undone");
    assert!(shows(&window, HATCHED));
}

#[test]
fn cancelled_work_stops_and_can_be_rerun() {
    let mut window = open(demo(4, 200, (160, 120)), SIZE);
    wait(&mut window, "the first live picture", |window| window.state().observed().live_coverage.is_some());
    wait(&mut window, "the long work", |window| window.query_by_label("Cancel").is_some());
    window.key_press(Key::Escape);
    wait(&mut window, "the long work to stop", |window| window.query_by_label("Recompute").is_some());
    assert!(window.state().observed().report.is_none());
    click(&mut window, "Recompute");
    wait(&mut window, "the long work again", |window| window.query_by_label("Cancel").is_some());
    click(&mut window, "Cancel");
    wait(&mut window, "the long work to stop", |window| window.query_by_label("Recompute").is_some());
}

#[test]
fn time_plays_steps_and_is_scrubbed() {
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    window.key_press(Key::Period);
    window.run_steps(2);
    assert_eq!(window.state().observed().frame, 1);
    window.key_press(Key::Comma);
    window.run_steps(2);
    assert_eq!(window.state().observed().frame, 0);
    let width = window.get_by_label("Timeline").rect().width();
    drag(&mut window, "Timeline", egui::Vec2::splat(0.5), egui::vec2(width * 0.4, 0.0));
    assert_eq!(window.state().observed().frame, 3);
    settle(&mut window);
    click(&mut window, "Play");
    wait(&mut window, "time to pass", |window| window.state().observed().frame != 3);
    click(&mut window, "Pause");
    settle(&mut window);
}

#[test]
fn a_view_at_rest_is_painted_twice_as_fine_as_recorded_and_in_motion_no_finer() {
    let rows = |window: &Window| window.state().observed().live_coverage.map_or(0, |(size, _)| size[1]);
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    assert_eq!(rows(&window), 144, "72 rows were recorded");
    assert!(shows(&window, "samples drawn"));
    window.get_by_label("Play").click();
    wait(&mut window, "a picture in motion", |window| rows(window) != 144);
    // Where machines are busy, pictures in motion are coarser still.
    assert!((1..=72).contains(&rows(&window)), "{}", rows(&window));
    window.get_by_label("Pause").click();
    settle(&mut window);
    assert!(shows(&window, "samples drawn"));
    for coloring in ["Camera", "Agreement", "Motion"] {
        choose(&mut window, "Live view shows", coloring);
        settle(&mut window);
        assert!(shows(&window, "samples drawn"), "{coloring} is as fine as the picture");
    }
}

#[test]
fn the_live_view_orbits_jumps_and_comes_home() {
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    let home = window.state().observed().live_position.unwrap();
    drag(&mut window, "Live picture", egui::Vec2::splat(0.5), egui::vec2(60.0, 10.0));
    let orbited = window.state().observed().live_position.unwrap();
    assert_ne!(home, orbited);
    settle(&mut window);
    pick(&mut window, "Go to camera", "left");
    settle(&mut window);
    assert_ne!(orbited, window.state().observed().live_position.unwrap());
    window.key_press(Key::Home);
    settle(&mut window);
    assert_eq!(home, window.state().observed().live_position.unwrap());
    window.key_down(Key::W);
    window.run_steps(3);
    window.key_up(Key::W);
    window.run_steps(2);
    assert_ne!(home, window.state().observed().live_position.unwrap());
}

#[test]
fn every_overlay_and_coloring_can_be_chosen() {
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    for overlay in ["Kept by", "Agreement", "Sampling", "Motion", "Tiles", "Depth", "Normals", "Picture"] {
        choose(&mut window, "Source shows", overlay);
        settle(&mut window);
    }
    for coloring in ["Camera", "Agreement", "Motion", "Sampling", "Picture"] {
        choose(&mut window, "Live view shows", coloring);
        settle(&mut window);
    }
    window.hover_at(window.get_by_label("Source picture").rect().center());
    window.run_steps(3);
    assert!(shows(&window, "Kept:") || shows(&window, "Dropped:"));
    click(&mut window, "Report");
    assert!(shows(&window, "Which camera replaces which"));
    click(&mut window, "Light theme");
    settle(&mut window);
    assert!(window.state().observed().notices.is_empty());
}

#[test]
fn a_store_is_saved_and_opened_again_without_source_frames() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    let kept = window.state().observed().report.unwrap().0.samples_kept;
    let path = save_store(&mut window, folder.path());
    open_store(&mut window, &path);
    assert_eq!(window.state().observed().report.unwrap().0.samples_kept, kept);
    assert!(window.state().observed().live_coverage.unwrap().1 > 0.1);
}

#[test]
fn a_broken_file_gives_a_readable_message_and_the_window_stays_up() {
    let folder = tempfile::tempdir().unwrap();
    let truncated = folder.path().join("truncated.ovl");
    std::fs::write(&truncated, b"FORM\0\0").unwrap();
    let nonsense = folder.path().join("transforms.json");
    std::fs::write(&nonsense, b"{ this is not json").unwrap();
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    for (count, path) in [&truncated, &nonsense, &folder.path().join("missing.ovl")].into_iter().enumerate() {
        type_path(&mut window, "Open file", path, "Open this path");
        wait(&mut window, "the message", |window| window.state().observed().notices.len() > count);
        let message = window.state().observed().notices.pop().unwrap();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        assert!(message.contains(&name) && message.starts_with("Could not open"), "{message}");
        assert!(!message.contains('\n'), "{message}");
    }
    assert!(window.state().observed().scene_name.is_some(), "what was open stays open");
    assert!(window.query_by_label("Path").is_some(), "the path that is not there can be mended");
    for _ in 0..4 {
        window.key_press(Key::Escape);
        window.run_steps(2);
    }
    assert!(window.state().observed().notices.is_empty());
    window.key_press(Key::Period);
    settle(&mut window);
    assert_eq!(window.state().observed().frame, 1);
}

#[test]
fn one_camera_and_one_frame_are_enough() {
    let mut window = open(demo(1, 1, (64, 48)), SIZE);
    settle(&mut window);
    for overlay in ["Kept by", "Sampling", "Tiles"] {
        choose(&mut window, "Source shows", overlay);
        settle(&mut window);
    }
    window.key_press(Key::Space);
    window.key_press(Key::Num7);
    click(&mut window, "Report");
    settle(&mut window);
    assert_eq!(window.state().observed().frame, 0);
    assert!(window.state().observed().notices.is_empty());
}

#[test]
fn whatever_is_dropped_is_opened_or_the_message_says_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    let capture = small_capture();
    let [empty, text, missing, broken, bare] =
        ["empty", "notes.txt", "gone.ovl", "broken", "bare"].map(|name| folder.path().join(name));
    std::fs::create_dir(&empty).unwrap();
    std::fs::write(&text, "not a capture").unwrap();
    std::fs::create_dir(&bare).unwrap();
    std::fs::copy(capture.join("transforms.json"), bare.join("transforms.json")).unwrap();
    copy_folder(&capture, &broken);
    let picture = first_picture(&broken);
    let whole = std::fs::read(&picture).unwrap();
    std::fs::write(&picture, &whole[..whole.len() / 2]).unwrap();
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    for (path, named, advice) in [
        (&missing, "gone.ovl", "check the path"),
        (&empty, "empty", "No capture in"),
        (&text, "notes.txt", "open one of those, or the folder of a capture"),
        (&bare, "cam", ";"),
        (&broken, "cam", ";"),
    ] {
        drop_on(&mut window, path);
        wait(&mut window, named, |window| !window.state().observed().notices.is_empty());
        let message = window.state().observed().notices.pop().unwrap();
        assert!(message.starts_with("Could not") && message.contains(named), "{message}");
        assert!(message.contains(advice) && !message.contains("os error"), "{message}");
        window.key_press(Key::Escape);
        window.run_steps(3);
        assert!(window.state().observed().notices.is_empty());
    }
    assert_eq!(window.state().observed().scene_name, Some("orrery"), "what was open stays open");
    drop_on(&mut window, &capture);
    wait(&mut window, "the capture", |window| window.state().observed().scene_name == Some("small_capture"));
}

fn copy_folder(from: &Path, to: &Path) {
    std::fs::create_dir(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap() {
        let entry = entry.unwrap().path();
        let target = to.join(entry.file_name().unwrap());
        if entry.is_dir() {
            copy_folder(&entry, &target);
        } else {
            std::fs::copy(&entry, &target).unwrap();
        }
    }
}

/// The picture that a capture shows first.
fn first_picture(capture: &Path) -> std::path::PathBuf {
    let mut pictures: Vec<_> =
        std::fs::read_dir(capture.join("cam0")).unwrap().map(|entry| entry.unwrap().path()).collect();
    pictures.sort();
    pictures.remove(0)
}

#[test]
fn a_path_that_does_not_exist_at_the_start_leaves_ways_to_go_on() {
    let mut window = open(Start::Path("/no/such/capture".into()), SIZE);
    wait(&mut window, "the message", |window| !window.state().observed().notices.is_empty());
    click(&mut window, "Dismiss");
    assert!(shows(&window, "Nothing is open"));
    click(&mut window, "Demo");
    assert!(window.query_by_label("Orrery").is_some());
}
