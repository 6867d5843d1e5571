//! One picture that cannot be used leaves the others as they are: it is left out, counted and named.

use crate::captures::{Folder, PIXELS, entry, flat, plain};
use image::{ImageBuffer, Rgb};
use overlook_engine::capture::Capture;
use overlook_engine::error::Result;
use overlook_engine::job::Job;
use overlook_engine::preprocess::preprocess;
use overlook_engine::settings::Settings;
use serde_json::{Value, json};

/// Opens four views of one moment that name neither camera nor time, after `change` spoiled them.
fn recording(change: impl FnOnce(&Folder, &mut Vec<Value>)) -> (Folder, Result<Capture>) {
    let folder = Folder::new();
    let mut entries: Vec<Value> = Vec::new();
    for (index, name) in ["a.exr", "b.exr", "c.exr", "late.exr"].iter().enumerate() {
        folder.put(name, &plain(flat(2.0)));
        let mut view = entry(name, "", 0);
        view["transform_matrix"][0][3] = (0.1 * index as f64).into();
        let keys = view.as_object_mut().unwrap();
        keys.retain(|key, _| key != "camera" && key != "time");
        entries.push(view);
    }
    change(&folder, &mut entries);
    let opened = folder.open(json!({}), &entries);
    (folder, opened)
}

/// Checks that three views are left, and that a warning counts and names the fourth.
fn assert_left_out((_folder, opened): (Folder, Result<Capture>), why: &str) {
    let capture = opened.unwrap();
    assert_eq!((capture.cameras.len(), capture.frame_count()), (3, 1));
    let said = capture.warnings.join("\n");
    assert!(said.contains("left out: 1") && said.contains("late.exr") && said.contains(why), "{said}");
    for camera in 0..3 {
        assert_eq!(capture.frame(camera, 0).unwrap().invalid_pixels(), 0);
    }
}

#[test]
fn a_view_whose_picture_is_missing_is_left_out() {
    let missing =
        |folder: &Folder, _: &mut Vec<Value>| std::fs::remove_file(folder.path("late.exr")).unwrap();
    assert_left_out(recording(missing), "picture file is missing");
}

#[test]
fn a_view_without_depth_is_left_out() {
    let without = |folder: &Folder, entries: &mut Vec<Value>| {
        ImageBuffer::from_pixel(6, 4, Rgb([9_u8, 8, 7])).save(folder.path("late.exr.png")).unwrap();
        entries[3]["file_path"] = "late.exr.png".into();
    };
    assert_left_out(recording(without), "without depth");
    let named = |_: &Folder, entries: &mut Vec<Value>| entries[3]["depth_file_path"] = "gone.exr".into();
    assert_left_out(recording(named), "depth file is missing");
    let in_exr = |folder: &Folder, _: &mut Vec<Value>| {
        let channels = ["R", "G", "B"].map(|name| (name, flat(0.5))).to_vec();
        folder.put("late.exr", &crate::captures::picture(&[("", channels)]));
    };
    assert_left_out(recording(in_exr), "cannot be read");
}

#[test]
fn a_view_with_an_impossible_pose_is_left_out() {
    let bad = [
        json!([[0, 0, 0, 0], [0, 0, 0, 0], [0, 0, 0, 0], [0, 0, 0, 1]]),
        json!([[1, 0, 0, 1e30], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]]),
        json!([[2, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]]),
        json!([[-1, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]]),
        json!([[1, 0, 0], [0, 1, 0], [0, 0, 1]]),
    ];
    for matrix in bad {
        let spoil = |_: &Folder, entries: &mut Vec<Value>| entries[3]["transform_matrix"] = matrix.clone();
        assert_left_out(recording(spoil), "transform_matrix");
    }
}

#[test]
fn a_view_that_repeats_a_pose_is_left_out() {
    let repeat = |_: &Folder, entries: &mut Vec<Value>| {
        entries[3]["transform_matrix"] = entries[0]["transform_matrix"].clone();
    };
    assert_left_out(recording(repeat), "with the pose of another");
}

#[test]
fn a_file_that_is_no_picture_is_left_out() {
    assert_left_out(recording(|folder, _| folder.put("late.exr", b"")), "cannot be read");
}

#[test]
fn where_no_picture_can_be_used_the_first_fault_is_the_refusal() {
    let all = |_: &Folder, entries: &mut Vec<Value>| {
        for entry in entries.iter_mut() {
            entry["transform_matrix"] = json!([[1, 0, 0, 0]]);
        }
    };
    let refused = recording(all).1.map(drop).unwrap_err().to_string();
    assert!(refused.contains("frames[0] (a.exr)") && refused.contains("is not 4×4"), "{refused}");
    let none = |folder: &Folder, _: &mut Vec<Value>| {
        for name in ["a", "b", "c", "late"] {
            std::fs::remove_file(folder.path(&format!("{name}.exr"))).unwrap();
        }
    };
    let refused = recording(none).1.map(drop).unwrap_err().to_string();
    assert!(refused.contains("a.exr") && refused.contains("missing"), "{refused}");
}

#[test]
fn a_picture_of_a_rig_that_is_missing_is_a_frame_without_samples() {
    let folder = Folder::new();
    let mut entries = Vec::new();
    for (camera, time) in [("left", 0), ("left", 1), ("right", 0), ("right", 1)] {
        let name = format!("{camera}{time}.exr");
        folder.put(&name, &plain(flat(2.0)));
        entries.push(entry(&name, camera, time));
    }
    std::fs::remove_file(folder.path("right1.exr")).unwrap();
    let capture = folder.open(json!({}), &entries).unwrap();
    assert_eq!((capture.cameras.len(), capture.frame_count()), (2, 2));
    assert!(capture.warnings[0].contains("left out: 1") && capture.warnings[0].contains("right1.exr"));
    assert_eq!(capture.frame(1, 1).unwrap().invalid_pixels(), PIXELS);
    assert_eq!(capture.frame(1, 0).unwrap().invalid_pixels(), 0);
    assert!(capture.files_of(1, 1).is_empty());
    let report = preprocess(&capture, &Settings::default(), &Job::new()).unwrap().report;
    assert_eq!(report.without_depth(), PIXELS as u64);
    // A pose that is no pose leaves the same gap, and a frame that no camera has is none.
    folder.put("right1.exr", &plain(flat(2.0)));
    entries[3]["transform_matrix"] = json!([[0, 0, 0, 0], [0, 0, 0, 0], [0, 0, 0, 0], [0, 0, 0, 1]]);
    let capture = folder.open(json!({}), &entries).unwrap();
    assert_eq!(capture.frame(1, 1).unwrap().invalid_pixels(), PIXELS);
    std::fs::remove_file(folder.path("left1.exr")).unwrap();
    assert_eq!(folder.open(json!({}), &entries).unwrap().frame_numbers, [0]);
}
