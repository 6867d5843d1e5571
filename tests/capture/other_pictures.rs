//! `overlook evaluate --pictures`: pictures that another program made of the same viewpoints.

use crate::command;
use std::path::Path;

use crate::command::{overlook, scene};
use crate::said::{fail, succeed};
use serde_json::{Value, json};

/// Evaluates `scene` with pictures of other programs.
fn evaluated(folder: &Path, pictures: &[&str]) -> (Value, String) {
    let mut arguments = vec!["evaluate", "scene", "--json", "--error-maps", "maps"];
    arguments.extend(pictures.iter().flat_map(|pictures| ["--pictures", pictures]));
    let output = command::succeed(overlook(folder, &arguments));
    (serde_json::from_slice(&output.stdout).unwrap(), String::from_utf8(output.stderr).unwrap())
}

/// The one line that an evaluation with such pictures says, which must fail.
fn trouble(folder: &Path, pictures: &str) -> String {
    fail(folder, &["evaluate", "scene", "--pictures", pictures], 1)
}

/// Renders the viewpoints of `scene` into a folder `other`, as PNG alone.
fn rendered(folder: &Path) {
    succeed(folder, &["preprocess", "scene", "--out", "scene.ovl"]);
    let render = ["render", "scene.ovl", "--views", "scene/novel/transforms.json", "--out", "other"];
    succeed(folder, &render);
    for place in std::fs::read_dir(folder.join("other")).unwrap().map(|entry| entry.unwrap().path()) {
        for file in place.read_dir().into_iter().flatten().map(|entry| entry.unwrap().path()) {
            if file.extension().is_some_and(|extension| extension == "exr") {
                std::fs::remove_file(file).unwrap();
            }
        }
    }
}

#[test]
fn our_own_pictures_score_as_we_do_by_their_names_and_by_their_poses() {
    let folder = scene("2", "48x36");
    let folder = folder.path();
    rendered(folder);
    // The same pictures under other names, beside a manifest that says where they were taken.
    std::fs::create_dir(folder.join("posed")).unwrap();
    let views = std::fs::read_to_string(folder.join("scene/novel/transforms.json")).unwrap();
    let mut views: Value = serde_json::from_str(&views).unwrap();
    let entries = views["frames"].as_array_mut().unwrap();
    for (index, entry) in entries.iter_mut().enumerate() {
        let own = entry["file_path"].as_str().unwrap().replace(".exr", ".png");
        let name = format!("r_{index}.png");
        std::fs::copy(folder.join("other").join(own), folder.join("posed").join(&name)).unwrap();
        entry["file_path"] = json!(name);
    }
    entries.reverse();
    views["color_space"] = json!("sRGB");
    std::fs::write(folder.join("posed/transforms.json"), views.to_string()).unwrap();
    std::fs::copy(folder.join("posed/r_0.png"), folder.join("other/extra.png")).unwrap();

    let (document, warnings) = evaluated(folder, &["other", "posed", "other"]);
    assert!(warnings.contains("the picture 'extra.png' shows none of the views"), "{warnings}");
    let [named, posed, again] = document["pictures"].as_array().unwrap().as_slice() else { panic!() };
    assert_eq!((&named["matched_by"], &posed["matched_by"]), (&json!("file_name"), &json!("pose")));
    assert_eq!((&again["name"], &again["psnr_db"]), (&json!("other (2)"), &named["psnr_db"]));
    for key in ["psnr_db", "psnr_all_db", "ssim", "flip", "flicker_steps"] {
        assert_eq!(named[key].as_f64().unwrap(), posed[key].as_f64().unwrap(), "{key}");
    }
    // Our holes are filled and so no holes of the PNG, which has 256 steps: all pixels together are nearly as we score them.
    let [ours, theirs] = [&document["mean"], named].map(|scores| scores["psnr_all_db"].as_f64().unwrap());
    assert!((ours - theirs).abs() < 0.05, "{ours} {theirs}");
    for program in ["overlook", "other", "posed", "other (2)"] {
        let map = image::open(folder.join("maps").join(program).join("novel0/0000.png")).unwrap();
        assert_eq!(map.height(), 36, "{program}");
    }
}

#[test]
fn one_line_says_which_picture_is_missing_or_does_not_fit() {
    let folder = scene("1", "48x36");
    let folder = folder.path();
    rendered(folder);
    let first = folder.join("other/novel0/0000.png");
    image::RgbImage::new(24, 18).save(&first).unwrap();
    let text = trouble(folder, "other");
    assert!(
        text.contains("24×18") && text.contains("48×36") && text.contains("render it at the view's size"),
        "{text}"
    );
    std::fs::remove_file(&first).unwrap();
    let text = trouble(folder, "other");
    assert!(text.contains("other: has no picture of view 'novel0/0000.exr'"), "{text}");
    let views = std::fs::read_to_string(folder.join("scene/novel/transforms.json")).unwrap();
    let mut views: Value = serde_json::from_str(&views).unwrap();
    for entry in views["frames"].as_array_mut().unwrap() {
        entry["transform_matrix"][0][3] = json!(entry["transform_matrix"][0][3].as_f64().unwrap() + 0.5);
    }
    std::fs::write(folder.join("other/transforms.json"), views.to_string()).unwrap();
    let text = trouble(folder, "other");
    assert!(text.contains("0.500 away") && text.contains("match pictures by their names"), "{text}");
}
