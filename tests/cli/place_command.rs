//! `overlook place`: poses of cameras by a coarse capture, and the surface that none of them sees.

use std::path::Path;

use overlook_engine::capture::transforms::open_views;
use serde_json::Value;

use crate::command::{overlook, scene, succeed};

fn placed(folder: &Path, arguments: &[&str]) -> String {
    let command = [&["place", "scene", "--out", "placed.json"], arguments].concat();
    String::from_utf8(succeed(overlook(folder, &command)).stdout).unwrap()
}

fn refused(folder: &Path, arguments: &[&str]) -> String {
    let output = overlook(folder, arguments).output().unwrap();
    assert!(!output.status.success(), "{arguments:?}");
    String::from_utf8(output.stderr).unwrap()
}

#[test]
fn placed_cameras_are_written_as_viewpoints_and_what_they_do_not_see_as_points() {
    let folder = scene("2", "96x72");
    let here = folder.path();
    let arguments = ["--cameras", "3", "--size", "192x144", "--unseen", "unseen.ply"];
    let said: Value = serde_json::from_str(&placed(here, &[&arguments[..], &["--json"]].concat())).unwrap();
    let views = open_views(&here.join("placed.json")).unwrap();
    let cameras = said["cameras"].as_array().unwrap();
    assert_eq!((views.len(), cameras.len()), (3, 3));
    for (view, told) in views.iter().zip(cameras) {
        assert_eq!(view.camera.name, told["name"].as_str().unwrap());
        assert_eq!(view.camera.intrinsics.size(), (192, 144));
        let told = told["position_in_world"].as_array().unwrap();
        for (at, told) in view.camera.position_in_world().to_array().iter().zip(told) {
            assert!((at - told.as_f64().unwrap()).abs() < 1e-9);
        }
    }
    let header = std::fs::read(here.join("unseen.ply")).unwrap();
    let header = String::from_utf8_lossy(&header[..200]).into_owned();
    let points: u64 =
        header.split("element vertex ").nth(1).unwrap().lines().next().unwrap().parse().unwrap();
    assert_eq!(points > 0, said["unseen"].as_f64().unwrap() > 0.0, "{header}");

    let table = placed(here, &arguments);
    assert_eq!(table.lines().filter(|line| line.contains("  placed")).count(), 3, "{table}");
    assert!(table.contains("The 2 cameras of the capture see"), "{table}");
    assert!(table.contains("Wrote placed.json") && table.contains("to unseen.ply"), "{table}");
    // The program renders from there.
    succeed(overlook(here, &["preprocess", "scene", "--out", "scene.ovl"]));
    succeed(overlook(here, &["render", "scene.ovl", "--views", "placed.json", "--out", "shown"]));
    assert!(here.join("shown/placed3/0000.png").is_file());
}

#[test]
fn what_cannot_be_placed_is_said_in_one_line_and_nothing_is_written() {
    let folder = scene("1", "48x36");
    let here = folder.path();
    let place = ["place", "scene", "--out", "placed.json"];
    for (arguments, said) in [
        (&["--cameras", "0"][..], "no camera"),
        (&["--rate=-1"], "rate"),
        (&["--within", "1,1,1,0,0,0"], "box"),
        (&["--within", "1,2"], "six numbers"),
        (&["--ring", "--within", "0,0,0,1,1,1"], "cannot be used with"),
        (&["--unseen", "none/unseen.ply"], "does not exist"),
    ] {
        let error = refused(here, &[&place, arguments].concat());
        assert!(error.contains(said), "{arguments:?}: {error}");
    }
    assert!(!here.join("placed.json").exists());
    let error = refused(here, &["place", "scene", "--out", "scene/transforms.json"]);
    assert!(error.contains("is what is read"), "{error}");
}
