//! What `overlook preprocess` tells beside the store, and what must not cost the store.

#[path = "common/command.rs"]
mod command;

use std::path::Path;

use command::{overlook, scene, succeed};
use exr::prelude::{ReadChannels, ReadLayers, WritableImage};
use serde_json::Value;

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

#[test]
#[cfg(unix)]
fn a_form_that_cannot_be_measured_is_a_warning_and_the_store_is_written() {
    use std::os::unix::fs::PermissionsExt;
    let folder = scene("2", "24x16");
    let folder = folder.path();
    std::fs::create_dir(folder.join("bin")).unwrap();
    let told = "echo no such codec >&2; echo >&2; exit 3";
    // One that ends at once, one that first takes all it is given, and one that can make depth alone.
    let depth_alone =
        format!("case \"$*\" in *ffv1*) for last; do :; done; cat > \"$last\";; *) {told};; esac");
    for (script, measures_depth) in
        [(told.to_owned(), false), (format!("cat > taken; {told}"), false), (depth_alone, true)]
    {
        let program = folder.join("bin/ffmpeg");
        let script = format!("#!/bin/sh\nPATH=/usr/bin:/bin\n[ \"$1\" = -version ] && exit 0\n{script}\n");
        std::fs::write(&program, script).unwrap();
        std::fs::set_permissions(&program, std::fs::Permissions::from_mode(0o755)).unwrap();
        let mut command =
            overlook(folder, &["preprocess", "scene", "--out", "scene.ovl", "--measure-rivals"]);
        command.env("PATH", folder.join("bin"));
        let said = text(&succeed(command).stderr);
        let expected: Vec<_> = ["color", "depth"][..2 - usize::from(measures_depth)]
            .iter()
            .map(|of| {
                format!(
                    "overlook: warning: lossless video of {of} is not measured: ffmpeg failed: no such codec"
                )
            })
            .collect();
        let of_it = said.lines().filter(|line| line.contains("measured") || line.contains("ffmpeg"));
        assert_eq!(of_it.collect::<Vec<_>>(), expected, "{said}");
        let info = succeed(overlook(folder, &["info", "scene.ovl", "--json"]));
        let info: Value = serde_json::from_slice(&info.stdout).unwrap();
        let rivals = &info["provenance"]["rivals"];
        assert!(rivals["zip_exr"].as_u64().is_some_and(|bytes| bytes > 0), "{rivals}");
        assert!(rivals["video_color"].is_null() && info["sizes"]["lossless_video"].is_null(), "{rivals}");
        let depth = measures_depth.then_some(2 * 2 * 24 * 16 * 2);
        assert_eq!(rivals["video_depth"].as_u64(), depth);
        std::fs::remove_file(folder.join("scene.ovl")).unwrap();
    }
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
