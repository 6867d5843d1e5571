//! Camera paths from the command line: films of still scenes, frozen moments and slow motion.

use std::path::Path;

use overlook_engine::capture::transforms;
use overlook_engine::settings::CaptureSettings;
use serde_json::{Value, json};

use crate::command::{overlook, scene, succeed};

/// A store of a small scene, and the pose of its truth view.
fn stored(frames: &str) -> (tempfile::TempDir, Value) {
    let folder = scene(frames, "24x16");
    succeed(overlook(folder.path(), &["preprocess", "scene", "--out", "scene.ovl"]));
    let views = std::fs::read(folder.path().join("scene/novel/transforms.json")).unwrap();
    let views: Value = serde_json::from_slice(&views).unwrap();
    let pose = views["frames"][0]["transform_matrix"].clone();
    (folder, pose)
}

/// Writes a path of places a step apart, after `change`.
fn write_path(folder: &Path, pose: &Value, places: usize, change: impl Fn(usize, &mut Value)) {
    let frames: Vec<Value> = (0..places)
        .map(|index| {
            let mut pose = pose.clone();
            pose[0][3] = json!(pose[0][3].as_f64().unwrap() + 0.05 * index as f64);
            let mut entry = json!({"file_path": format!("p{index}.png"), "transform_matrix": pose});
            change(index, &mut entry);
            entry
        })
        .collect();
    let path = json!({"w": 24, "h": 16, "fl_x": 20, "frames": frames});
    std::fs::write(folder.join("path.json"), path.to_string()).unwrap();
}

/// The PNG pictures that a path gives.
fn pictures(folder: &Path, more: &[&str]) -> Vec<Vec<u8>> {
    let _ = std::fs::remove_dir_all(folder.join("film"));
    let arguments =
        ["export", "pictures", "scene.ovl", "--path", "path.json", "--backend", "cpu", "--out", "film"];
    succeed(overlook(folder, &[&arguments[..], more].concat()));
    let mut names: Vec<_> =
        std::fs::read_dir(folder.join("film")).unwrap().map(|file| file.unwrap().path()).collect();
    names.retain(|name| name.extension().is_some_and(|ending| ending == "png"));
    names.sort();
    names.iter().map(|name| std::fs::read(name).unwrap()).collect()
}

#[test]
fn every_place_of_a_path_through_a_scene_of_one_frame_is_a_picture() {
    let (folder, pose) = stored("1");
    let folder = folder.path();
    write_path(folder, &pose, 5, |_, _| {});
    let one_moment = pictures(folder, &[]);
    assert_eq!(one_moment.len(), 5);
    assert!(one_moment.windows(2).all(|pair| pair[0] != pair[1]), "the camera moves");
    write_path(folder, &pose, 5, |index, entry| entry["frame"] = index.into());
    assert!(pictures(folder, &[]) == one_moment, "the scene stands still whatever the time");
    assert_eq!(pictures(folder, &["--pictures", "9"]).len(), 9);
}

#[test]
fn a_moving_scene_is_held_or_slowed_down_as_a_path_or_an_option_says() {
    let (folder, pose) = stored("3");
    let folder = folder.path();
    let capture = transforms::open(&folder.join("scene"), &CaptureSettings::default()).unwrap();
    let (first, last) = (capture.frame_numbers[0], capture.frame_numbers[2]);
    // Keys at the first and the last frame: a picture for every frame, or as many as are asked for.
    write_path(folder, &pose, 2, |index, entry| entry["frame"] = [first, last][index].into());
    assert_eq!(pictures(folder, &[]).len() as i64, last - first + 1);
    assert_eq!(pictures(folder, &["--pictures", "7"]).len(), 7);
    // Several places at one frame are a frozen moment.
    write_path(folder, &pose, 4, |_, entry| entry["frame"] = last.into());
    let frozen = pictures(folder, &[]);
    assert_eq!(frozen.len(), 4);
    write_path(folder, &pose, 4, |index, entry| entry["frame"] = (first + index as i64).into());
    assert!(pictures(folder, &["--frame", &last.to_string()]) == frozen);
    write_path(folder, &pose, 4, |_, entry| entry["frame"] = (last + 9).into());
    let output =
        overlook(folder, &["export", "pictures", "scene.ovl", "--path", "path.json", "--out", "no"]).output();
    let said = String::from_utf8(output.unwrap().stderr).unwrap();
    assert!(said.contains("there is no frame") && said.lines().count() == 1, "{said}");
}

#[test]
fn a_camera_sets_off_and_arrives_slowly_where_it_is_asked_to() {
    let (folder, pose) = stored("1");
    let folder = folder.path();
    write_path(folder, &pose, 2, |_, _| {});
    let even = pictures(folder, &["--pictures", "5"]);
    let eased = pictures(folder, &["--pictures", "5", "--easing", "in-out"]);
    assert!(
        [0, 2, 4].iter().all(|index| eased[*index] == even[*index]),
        "the ends and the middle are where they were"
    );
    assert!([1, 3].iter().all(|index| eased[*index] != even[*index]));
    write_path(folder, &pose, 2, |index, entry| entry["path_easing"] = ["in-out", "linear"][index].into());
    assert!(pictures(folder, &["--pictures", "5"]) == eased, "a view says the same of the way from it");
}

#[test]
fn a_camera_is_at_its_views_at_the_times_that_the_path_says() {
    let (folder, pose) = stored("3");
    let folder = folder.path();
    write_path(folder, &pose, 3, |_, _| {});
    let views = pictures(folder, &["--pictures", "3"]);
    let seconds = [0.0, 1.0, 3.0];
    write_path(folder, &pose, 3, |index, entry| entry["path_time"] = seconds[index].into());
    let timed = pictures(folder, &["--pictures", "4"]);
    assert!([(0, 0), (1, 1), (3, 2)].into_iter().all(|(picture, view)| timed[picture] == views[view]));
    assert!(timed[2] != timed[1] && timed[2] != timed[3]);
    let seconds = [0.0, 0.125, 0.25];
    write_path(folder, &pose, 3, |index, entry| entry["path_time"] = seconds[index].into());
    assert_eq!(pictures(folder, &[]).len(), 7, "24 a second, both ends included");
}

#[test]
fn pictures_of_all_directions_meet_behind_the_camera() {
    let (folder, pose) = stored("1");
    let folder = folder.path();
    write_path(folder, &pose, 1, |_, _| {});
    let all_around = pictures(folder, &["--projection", "equirectangular", "--width", "96"]);
    let picture = image::load_from_memory(&all_around[0]).unwrap().into_rgb8();
    assert_eq!(picture.dimensions(), (96, 48));
    // The first and the last column are neighbors as any others are.
    let apart = |[a, b]: [u32; 2], y: u32| {
        let [a, b] = [a, b].map(|x| picture.get_pixel(x, y).0);
        (0..3).map(|channel| f64::from(a[channel].abs_diff(b[channel]))).sum::<f64>()
    };
    let between = |columns: [u32; 2]| (0..48).map(|y| apart(columns, y)).sum::<f64>() / 48.0;
    let inner: Vec<f64> = (0..95).map(|x| between([x, x + 1])).collect();
    let most = inner.iter().copied().fold(0.0, f64::max);
    assert!(between([95, 0]) <= most, "{} {most}", between([95, 0]));
    assert!(picture.pixels().any(|pixel| pixel.0 != picture.get_pixel(0, 0).0));
}
