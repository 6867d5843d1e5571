//! Orthographic cameras of manifests: the words that say it, what their numbers mean, and what is refused in one line.

use crate::captures::{Folder, SIZE, entry, flat, plain};
use crate::command;
use crate::said::{fail, succeed};
use crate::scene::{Scene, camera};
use exr::prelude::FlatSamples;
use glam::{DVec2, DVec3};
use overlook_engine::capture::transforms::{self, write_capture};
use overlook_engine::capture::{Camera, Capture, Intrinsics, Projection};
use overlook_engine::error::Result;
use overlook_engine::job::Job;
use overlook_engine::settings::CaptureSettings;
use serde_json::{Value, json};

fn refusal(opened: Result<Capture>) -> String {
    opened.map(drop).unwrap_err().to_string()
}

/// An entry without a lens.
fn bare(name: &str, keys: &Value) -> Value {
    let mut entry = entry("a.exr", name, 0);
    for key in ["fl_x", "fl_y", "camera_angle_x"] {
        entry.as_object_mut().unwrap().remove(key);
    }
    for (key, value) in keys.as_object().unwrap() {
        entry[key] = value.clone();
    }
    entry
}

#[test]
fn the_words_of_several_programs_say_that_a_camera_is_orthographic() {
    let folder = Folder::new();
    folder.put("a.exr", &plain(flat(4.0)));
    let longer = SIZE.0.max(SIZE.1) as f64;
    for (keys, expected) in [
        (json!({"camera_model": "ORTHOGRAPHIC", "fl_x": 2.5}), 2.5),
        (json!({"camera_model": "orthographic", "fl_y": 2.5}), 2.5),
        (json!({"orthographic": true, "fl_x": 2.5}), 2.5),
        (
            json!({"camera_type": "ORTHO", "ortho_scale": 3.0, "camera_angle_x": 0.7, "camera_angle_y": 0.5}),
            longer / 3.0,
        ),
    ] {
        let capture = folder.open(json!({}), &[bare("a", &keys)]).unwrap();
        let lens = capture.cameras[0].intrinsics;
        assert_eq!(lens.projection, Projection::Orthographic, "{keys}");
        assert_eq!((lens.fx, lens.fy), (expected, expected), "{keys}");
        assert_eq!(capture.frame(0, 0).unwrap().inverse_depth[(0, 0)], 0.25);
        let corner = capture.cameras[0].unproject(DVec2::ZERO, 4.0);
        let opposite = capture.cameras[0].unproject(DVec2::new(SIZE.0 as f64, 0.0), 9.0);
        let across = (opposite - corner).reject_from(capture.cameras[0].forward_in_world()).length();
        assert!((across - SIZE.0 as f64 / expected).abs() < 1e-9, "{across}");
    }
    let both = [
        bare("a", &json!({"camera_model": "ORTHOGRAPHIC", "fl_x": 2.5})),
        bare("b", &json!({"camera_model": "PINHOLE", "fl_x": 6.0})),
    ];
    let capture = folder.open(json!({}), &both).unwrap();
    let kinds: Vec<Projection> = capture.cameras.iter().map(|camera| camera.intrinsics.projection).collect();
    assert_eq!(kinds, [Projection::Orthographic, Projection::Perspective]);
}

#[test]
fn distances_along_parallel_rays_are_planar_and_heights_count_from_each_pixels_own_ray() {
    let folder = Folder::new();
    folder.put("a.exr", &plain(flat(4.0)));
    let lens = json!({"camera_model": "ORTHOGRAPHIC", "fl_x": 2.5});
    let capture = folder.open(json!({"depth_kind": "ray_distance"}), &[bare("a", &lens)]).unwrap();
    let frame = capture.frame(0, 0).unwrap();
    assert!(frame.inverse_depth.as_slice().iter().all(|depth| *depth == 0.25));
    // From above, tilted: every pixel's ray starts at a height of its own.
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let mut tilted = bare("a", &lens);
    tilted["transform_matrix"] =
        json!([[1, 0, 0, 0], [0, half, -half, 0], [0, half, half, 10], [0, 0, 0, 1]]);
    folder.put("a.exr", &plain(FlatSamples::F32(vec![1.0; SIZE.0 * SIZE.1])));
    let capture = folder.open(json!({"depth_kind": "world_z"}), &[tilted]).unwrap();
    let frame = capture.frame(0, 0).unwrap();
    for (x, y) in [(0, 0), (SIZE.0 - 1, SIZE.1 - 1), (2, 1)] {
        let pixel = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
        let depth = 1.0 / f64::from(frame.inverse_depth[(x, y)]);
        assert!((capture.cameras[0].unproject(pixel, depth).z - 1.0).abs() < 1e-5);
    }
}

#[test]
fn what_an_orthographic_camera_cannot_have_is_refused_in_one_line() {
    let folder = Folder::new();
    folder.put("a.exr", &plain(flat(0.5)));
    for (keys, said) in [
        (json!({"camera_angle_x": 0.7}), "camera_angle_x is no angle of view of an orthographic camera"),
        (json!({}), "give fl_x, pixels per world unit, or ortho_scale"),
        (json!({"ortho_scale": "wide"}), "fl_x is NaN"),
        (json!({"fl_x": 0.0}), "fl_x is 0"),
        (json!({"fl_x": 2.5, "k1": 0.1}), "an orthographic camera with 'k1'"),
        (json!({"fl_x": 2.5, "depth_kind": "z_buffer", "depth_range": [1, 9]}), "even in z; write planar_z"),
        (json!({"fl_x": 2.5, "depth_camera": {"fl_x": 3.0}}), "depth_camera is not read"),
    ] {
        let mut keys = keys;
        keys["camera_model"] = "ORTHOGRAPHIC".into();
        let refused = refusal(folder.open(json!({}), &[bare("a", &keys)]));
        assert!(refused.contains(said) && refused.lines().count() == 1, "{keys}: {refused}");
    }
}

/// A capture of two orthographic cameras and one in perspective.
fn mixed() -> Vec<Camera> {
    let lens = Intrinsics { cx: 20.25, fy: 12.0, ..Intrinsics::orthographic(40, 32, 4.0) };
    let parallel = |name: &str, eye: DVec3| Camera::look_at(name, lens, eye, DVec3::ZERO, DVec3::Z);
    vec![
        parallel("front", DVec3::new(0.0, -5.0, 3.0)),
        camera("pinhole", DVec3::new(1.0, -5.0, 3.0), DVec3::ZERO, 32),
        parallel("side", DVec3::new(4.0, -1.0, 3.0)),
    ]
}

#[test]
fn a_written_capture_reads_as_it_was() {
    let folder = tempfile::tempdir().unwrap();
    let capture = Scene::still_life().record(mixed(), 1);
    write_capture(folder.path(), &capture, &[], &Job::new()).unwrap();
    let read = transforms::open(folder.path(), &CaptureSettings::default()).unwrap();
    for (index, camera) in capture.cameras.iter().enumerate() {
        assert_eq!(read.cameras[index].intrinsics, camera.intrinsics);
        assert!(read.cameras[index].world_from_camera.abs_diff_eq(camera.world_from_camera, 1e-12));
        let [read, written] = [&read, &capture].map(|capture| capture.frame(index, 0).unwrap());
        assert_eq!(read.color, written.color);
        let pairs = read.inverse_depth.as_slice().iter().zip(written.inverse_depth.as_slice());
        assert!(pairs.into_iter().all(|(read, written)| (read - written).abs() <= 1e-6 * written));
    }
}

#[test]
fn every_stage_works_or_says_in_one_line_why_not() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    write_capture(&here.join("capture"), &Scene::still_life().record(mixed(), 1), &[], &Job::new()).unwrap();
    let info: Value = serde_json::from_str(&succeed(here, &["info", "capture", "--json"])).unwrap();
    assert_eq!(info["cameras"][0]["orthographic"], json!(true));
    assert_eq!(info["cameras"][1].get("orthographic"), None);
    let made = command::succeed(command::overlook(here, &["preprocess", "capture", "--out", "scene.ovl"]));
    let said = String::from_utf8(made.stdout).unwrap();
    assert!(
        said.contains("camera 'front' is orthographic, and only cameras in perspective are aligned"),
        "{said}"
    );
    succeed(here, &["info", "scene.ovl"]);
    succeed(here, &["render", "scene.ovl", "--views", "capture", "--out", "pictures"]);
    succeed(here, &["evaluate", "capture", "--hold-out", "side"]);
    succeed(here, &["export", "points", "scene.ovl", "--out", "points.ply"]);
    succeed(here, &["export", "splats", "scene.ovl", "--format", "ply", "--out", "splats.ply"]);
    let refused = |arguments: &[&str], what: &str| {
        let said = fail(here, arguments, 1);
        assert!(said.contains(what), "{said}");
    };
    refused(
        &["export", "page", "scene.ovl", "--out", "page.html"],
        "a page draws cameras in perspective alone",
    );
    refused(
        &["place", "capture", "--cameras", "3", "--out", "placed.json"],
        "cameras are placed by coarse captures",
    );
}
