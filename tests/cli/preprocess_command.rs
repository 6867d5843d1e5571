//! The output of `overlook preprocess` beside the store.

use std::path::Path;

use crate::command::{overlook, scene, succeed};
use exr::prelude::{ReadChannels, ReadLayers, WritableImage};
use serde_json::Value;

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

/// Takes the depth of `pixels` out of a picture.
fn lose_depth(path: &Path, pixels: usize) {
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
    values[..pixels].fill(f32::NAN);
    picture.write().to_file(path).unwrap();
}

#[test]
fn pixels_without_depth_are_told_and_pass_for_no_redundancy_between_cameras() {
    let folder = scene("2", "24x16");
    let folder = folder.path();
    let whole = text(&succeed(overlook(folder, &["preprocess", "scene", "--out", "whole.ovl"])).stdout);
    assert!(!whole.contains("without depth"), "{whole}");

    let manifest = std::fs::read_to_string(folder.join("scene/transforms.json")).unwrap();
    let manifest: Value = serde_json::from_str(&manifest).unwrap();
    for entry in manifest["frames"].as_array().unwrap() {
        lose_depth(&folder.join("scene").join(entry["file_path"].as_str().unwrap()), 100);
    }
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
