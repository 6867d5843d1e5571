//! A sweep that other machines do is shown as its parts arrive.

use std::path::Path;

use egui_kittest::kittest::Queryable;
use overlook_engine::settings::Settings;
use overlook_lab::sweep::{Point, Series};
use overlook_lab::trial::{Trial, TrialResult};

use super::driver::{SIZE, click, demo, open, open_view, settle, shows, told, type_path, wait};

/// A line of a part: what a setting gave.
fn line(label: &str, depth_tolerance: f32) -> String {
    let mut settings = Settings::default();
    settings.pruning.depth_tolerance = depth_tolerance;
    let trial = Trial::new(label, settings);
    let point = Point::new(&trial, Series::Variation, &TrialResult::default());
    let (bytes, psnr_filled_db) = (1000 + label.len() as u64, 20.0 + f64::from(depth_tolerance));
    serde_json::to_string(&Point { bytes, psnr_filled_db, milliseconds: 3.0, ..point }).unwrap()
}

/// A file of a part as machines leave it: it appears whole.
fn arrive(folder: &Path, name: &str, lines: &[String]) {
    let unnamed = folder.join("unnamed");
    let text = format!("{{\"of\":\"sweep\"}}\n{}\n{:020} 00000000\n", lines.join("\n"), 0);
    std::fs::write(&unnamed, text).unwrap();
    std::fs::rename(unnamed, folder.join(name)).unwrap();
}

#[test]
fn a_sweep_that_others_do_is_shown_part_by_part_and_the_window_says_what_is_missing() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let mut window = open(demo(2, 2, (32, 24)), SIZE);
    settle(&mut window);
    open_view(&mut window, "Sweep");
    type_path(&mut window, "Follow parts", "Follow parts at path…", folder, "Follow this path");
    wait(&mut window, "the folder", |window| shows(window, ": no part yet"));
    assert!(shows(&window, "No sweep yet"));
    arrive(folder, "sweep.part-2-of-3", &[line("one", 1.0), line("two", 2.0)]);
    wait(&mut window, "the first part", |window| shows(window, "sweep: 1 of 3 parts, 2 missing"));
    assert!(shows(&window, "2 settings; click one to apply it"));
    assert!(window.query_by_label("Sweep chart").is_some());
    // A part under way, and preprocessing in the same folder.
    arrive(folder, "sweep.part-1-of-3.journal", &[line("three", 3.0)]);
    arrive(folder, "scene.ovl.scan.part-1-of-6", &[]);
    wait(&mut window, "a point of a part under way", |window| shows(window, "3 settings; click one"));
    assert!(
        shows(&window, "sweep: 1 of 3 parts, 2 missing") && shows(&window, "scan: 1 of 6 parts, 5 missing")
    );
    std::fs::remove_file(folder.join("sweep.part-1-of-3.journal")).unwrap();
    arrive(folder, "sweep.part-1-of-3", &[line("three", 3.0), line("four", 4.0)]);
    arrive(folder, "sweep.part-3-of-3", &[line("five", 5.0)]);
    wait(&mut window, "all parts", |window| shows(window, "sweep: all 3 parts"));
    assert!(shows(&window, "5 settings; click one to apply it"), "each point once");
    click(&mut window, "Stop following");
    arrive(folder, "sweep.part-1-of-1", &[line("six", 6.0)]);
    wait(&mut window, "the offer to follow", |window| window.query_by_label("Follow parts").is_some());
    assert!(shows(&window, "5 settings; click one to apply it"), "what has arrived stays");
    settle(&mut window);
}

#[test]
fn a_folder_that_cannot_be_followed_is_told_and_the_path_is_shown_again() {
    let folder = tempfile::tempdir().unwrap();
    let missing = folder.path().join("missing");
    let mut window = open(demo(2, 1, (32, 24)), SIZE);
    settle(&mut window);
    open_view(&mut window, "Sweep");
    type_path(&mut window, "Follow parts", "Follow parts at path…", &missing, "Follow this path");
    wait(&mut window, "the trouble", |window| told(window, "Could not follow the parts"));
    assert!(window.query_by_label("Path").is_some());
    click(&mut window, "Cancel this path");
    assert!(window.query_by_label("Follow parts").is_some());
    settle(&mut window);
}
