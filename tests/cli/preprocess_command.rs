//! The output of `overlook preprocess` beside the store.

use std::path::Path;

use crate::command::{overlook, scene, succeed};
use crate::said;
use exr::prelude::{ReadChannels, ReadLayers, WritableImage};
use serde_json::Value;

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

/// Changes the depth of each pixel of a picture, given its index.
fn change_depth(path: &Path, change: impl Fn(usize, f32) -> f32) {
    let mut picture = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_file(path)
        .unwrap();
    let channels = &mut picture.layer_data.channel_data.list;
    let depth = channels.iter_mut().find(|channel| channel.name.eq("Z")).unwrap();
    let exr::prelude::FlatSamples::F32(values) = &mut depth.sample_data else { panic!("depth is f32") };
    values.iter_mut().enumerate().for_each(|(index, value)| *value = change(index, *value));
    picture.write().to_file(path).unwrap();
}

/// The same of all pictures of the capture `scene` in a folder.
fn change_all_depth(folder: &Path, change: impl Fn(usize, f32) -> f32) {
    let manifest = std::fs::read_to_string(folder.join("scene/transforms.json")).unwrap();
    let manifest: Value = serde_json::from_str(&manifest).unwrap();
    for entry in manifest["frames"].as_array().unwrap() {
        change_depth(&folder.join("scene").join(entry["file_path"].as_str().unwrap()), &change);
    }
}

#[test]
fn preprocess_says_what_info_says_of_another_unit_on_exact_and_on_noisy_depth() {
    let demo = ["demo", "orrery", "--out", "scene", "--cameras", "4", "--frames", "1", "--size", "64x48"];
    for noise in [0.0, 0.01] {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path();
        succeed(overlook(folder, &demo));
        let off = |index: usize| noise * ((index.wrapping_mul(7919) % 2001) as f32 / 1000.0 - 1.0);
        change_all_depth(
            folder,
            |index, depth| if depth < 1e9 { 1000.0 * depth * (1.0 + off(index)) } else { depth },
        );
        let info = succeed(overlook(folder, &["info", "scene", "--json"]));
        let info: Value = serde_json::from_slice(&info.stdout).unwrap();
        let sentence = info["conventions"]["sentence"].as_str().unwrap();
        assert!(sentence.contains("write \"depth_unit_scale_factor\": 0.001"), "{noise}: {sentence}");
        let said = text(&succeed(overlook(folder, &["preprocess", "scene", "--out", "scene.ovl"])).stderr);
        assert!(said.contains(&format!("overlook: warning: {sentence}\n")), "{noise}: {said}");
        assert!(!said.contains("agrees with no other"), "{noise}: no camera is to blame: {said}");
    }
}

#[test]
fn pixels_without_depth_are_told_and_pass_for_no_redundancy_between_cameras() {
    let folder = scene("2", "24x16");
    let folder = folder.path();
    let whole = text(&succeed(overlook(folder, &["preprocess", "scene", "--out", "whole.ovl"])).stdout);
    assert!(!whole.contains("without depth"), "{whole}");

    change_all_depth(folder, |index, depth| if index < 100 { f32::NAN } else { depth });
    let keep = ["preprocess", "scene", "--out", "scene.ovl", "--set", "pruning.method=off"];
    let told = text(&succeed(overlook(folder, &keep)).stdout);
    let line = format!("  without depth {:>10}\n", 4 * 100);
    let dropped = told.lines().filter(|line| line.starts_with("  dropped")).count();
    assert!(told.contains(&line) && dropped == 1, "nothing but time is dropped: {told}");
    let info = text(&succeed(overlook(folder, &["info", "scene.ovl"])).stdout);
    assert!(info.contains(&line), "{info}");
    let info = succeed(overlook(folder, &["info", "scene.ovl", "--json"]));
    let info: Value = serde_json::from_slice(&info.stdout).unwrap();
    let sizes = &info["sizes"];
    assert_eq!(sizes["after_time"], sizes["after_pruning"], "no camera stands for another: {sizes}");
    let repeated = info["report"]["pruned"]["static"].as_u64().unwrap();
    assert_eq!(sizes["after_time"], 7 * (2 * 2 * 24 * 16 - 400 - repeated));
}

#[test]
fn a_capture_that_says_it_has_no_noise_is_not_measured_for_any() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let size = ["--cameras", "2", "--frames", "3", "--size", "96x72", "--noise", "0.05", "--out", "scene"];
    said::succeed(folder, &[&["demo", "orrery"], size.as_slice()].concat());
    let noise = || {
        let said = said::succeed(folder, &["preprocess", "scene", "--out", "scene.ovl"]);
        let line = said.lines().find(|line| line.contains("color noise ")).map(str::to_owned);
        let number = |line: String| {
            line.split_once("color noise ").unwrap().1.split(' ').next().unwrap().parse().unwrap()
        };
        line.map_or(0.0, number)
    };
    let measured: f64 = noise();
    assert!(measured > 1.0, "{measured}");
    let manifest = folder.join("scene/transforms.json");
    let text = std::fs::read_to_string(&manifest).unwrap();
    std::fs::write(&manifest, text.replacen('{', "{ \"noise_free\": true,", 1)).unwrap();
    assert!(noise() < 1e-9);
}
