//! What a folder does not say is asked or said, never guessed.

use exr::prelude::FlatSamples;
use overlook_engine::capture::{self, Capture};
use overlook_engine::settings::CaptureSettings;
use serde_json::{Value, json};

use crate::captures::{PIXELS, entry, flat, picture, plain};
use crate::folder::Folder;

fn warnings(capture: &Capture) -> String {
    capture.warnings.join("; ")
}

#[test]
fn frames_are_paired_by_a_number_in_the_middle_of_names_and_otherwise_said_to_be_in_order() {
    let folder = Folder::new();
    let mut entries = Vec::new();
    for (camera, numbers) in [("left", [12, 3, 2]), ("right", [2, 12, 3])] {
        for number in numbers {
            let name = format!("{number}/{camera}_rgb8.exr");
            folder.put(&name, &plain(flat(number as f32)));
            let mut entry = entry(&name, camera, 0);
            entry.as_object_mut().unwrap().remove("time");
            entries.push(entry);
        }
    }
    let capture = folder.open(json!({}), &entries).unwrap();
    assert_eq!((capture.frame_numbers.as_slice(), warnings(&capture)), (&[2, 3, 12][..], String::new()));
    for (frame, number) in [2.0, 3.0, 12.0].into_iter().enumerate() {
        for camera in 0..2 {
            assert_eq!(capture.frame(camera, frame).unwrap().inverse_depth[(0, 0)], 1.0 / number);
        }
    }
    for (index, entry) in entries.iter_mut().enumerate() {
        let name = format!("{}.exr", ["a", "b", "c", "d", "e", "f"][index]);
        folder.put(&name, &plain(flat(1.0)));
        entry["file_path"] = json!(name);
    }
    let said = warnings(&folder.open(json!({}), &entries).unwrap());
    assert!(said.contains("paired by their place in the list") && said.contains("\"frame\""), "{said}");
}

#[test]
fn colors_far_brighter_than_white_are_said_and_one_key_scales_them_all() {
    let folder = Folder::new();
    let planes = [("R", 300.0), ("G", 200.0), ("B", 100.0), ("Z", 2.0)];
    let planes = planes.map(|(name, value)| (name, flat(value))).to_vec();
    folder.put("a.exr", &picture(&[("", planes)]));
    let entries = [entry("a.exr", "a", 0)];
    let said = warnings(&folder.open(json!({}), &entries).unwrap());
    assert!(said.contains("300 times as bright as white") && said.contains("\"exposure\": -10"), "{said}");
    let scaled = folder.open(json!({"exposure": -10}), &entries).unwrap();
    assert_eq!(warnings(&scaled), "");
    let color = scaled.frame(0, 0).unwrap().color[(0, 0)].map(half::f16::to_f32);
    assert!(
        (color[0] - 300.0 / 1024.0).abs() < 1e-3 && (color[2] - 100.0 / 1024.0).abs() < 1e-3,
        "{color:?}"
    );
    let refused = folder.open(json!({"exposure": 100}), &entries).map(drop).unwrap_err().to_string();
    assert!(refused.contains("stops from -24 to 24"), "{refused}");
}

#[test]
fn focal_lengths_that_are_no_pixels_are_refused_with_what_to_multiply_them_by() {
    let folder = Folder::new();
    folder.put("a.exr", &plain(flat(2.0)));
    for focal in [0.2, 0.3] {
        let mut one = entry("a.exr", "a", 0);
        (one["fl_x"], one["fl_y"]) = (focal.into(), focal.into());
        let refused = folder.open(json!({}), &[one]).map(drop).unwrap_err().to_string();
        assert!(refused.contains("multiply a share of the width by 6"), "{refused}");
        assert!(!refused.contains('\n'), "{refused}");
    }
}

#[test]
fn a_pose_that_is_no_number_is_left_out_and_the_others_open() {
    let folder = Folder::new();
    let poses = [json!(null), json!([[null, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]])];
    for pose in
        poses.iter().map(Value::to_string).chain([String::from("[[NaN,0,0,0],[0,1,0,-Infinity],[0,0,1,0]]")])
    {
        let mut entries = Vec::new();
        for name in ["a", "b"] {
            folder.put(&format!("{name}.exr"), &plain(flat(2.0)));
            entries.push(entry(&format!("{name}.exr"), name, 0));
        }
        entries[1]["transform_matrix"] = json!("POSE");
        let manifest = json!({ "frames": entries }).to_string().replace("\"POSE\"", &pose);
        folder.put("transforms.json", manifest.as_bytes());
        let capture = capture::open(&folder.path(""), &CaptureSettings::default()).unwrap();
        assert_eq!(capture.cameras.len(), 1, "{pose}");
        assert!(warnings(&capture).contains("left out: 1 whose transform_matrix"), "{}", warnings(&capture));
    }
}

#[test]
fn the_range_of_a_value_is_that_of_all_frames() {
    let folder = Folder::new();
    let mut entries = Vec::new();
    for (frame, value) in [(0, f32::NAN), (1, 1e-9), (2, 300.0), (3, 600.0)] {
        let channel = |name, value| (name, FlatSamples::F32(vec![value; PIXELS]));
        let channels = [("R", 0.5), ("G", 0.5), ("B", 0.5), ("Z", 2.0), ("p", value)];
        let channels = channels.map(|(name, value)| channel(name, value)).to_vec();
        let name = format!("{frame}.exr");
        folder.put(&name, &picture(&[("", channels)]));
        entries.push(entry(&name, "a", frame));
    }
    let values = json!({"values": [{"name": "p"}]});
    let range =
        |entries: &[Value]| folder.open(values.clone(), entries).map(|it| it.value_channels()[0].range);
    assert_eq!(range(&entries).unwrap(), [1e-9, 600.0]);
    let refused = range(&entries[..1]).unwrap_err().to_string();
    assert!(refused.contains("'p' is missing in all pictures"), "{refused}");
}
