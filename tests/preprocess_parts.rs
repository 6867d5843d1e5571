//! Preprocessing cut by runs of frames: the joined store has the bytes of one piece, a part whose pictures change is refused by name.

#[path = "common/command.rs"]
mod command;
#[path = "common/said.rs"]
mod said;

use std::path::{Path, PathBuf};

use command::scene;
use said::{fail, succeed};

fn demo(name: &str, more: &[&str]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    succeed(folder.path(), &[&["demo", name, "--out", "scene"][..], more].concat());
    folder
}

/// Does all stages in `of` parts, the last part first.
fn in_parts(folder: &Path, more: &[&str], of: usize) {
    let stage = |arguments: &[&str]| {
        let preprocess = ["preprocess", "scene", "--out", "parts.ovl", "--stage"];
        succeed(folder, &[&preprocess[..], arguments, more].concat())
    };
    let all = of.to_string();
    stage(&["measure"]);
    for name in ["scan", "prune"] {
        for part in (1..=of).rev() {
            stage(&[name, "--part", &format!("{part}/{of}")]);
        }
        stage(&[name, "--join", &all]);
    }
}

fn is_same_in_parts(folder: &Path, more: &[&str], of: usize) {
    succeed(folder, &[&["preprocess", "scene", "--out", "whole.ovl"][..], more].concat());
    in_parts(folder, more, of);
    let [whole, joined] = ["whole.ovl", "parts.ovl"].map(|name| std::fs::read(folder.join(name)).unwrap());
    assert!(whole == joined, "{more:?} in {of} parts");
    succeed(folder, &["verify", "parts.ovl"]);
}

#[test]
fn a_store_in_parts_has_the_bytes_of_one_piece_whatever_the_number_of_frames_and_parts() {
    let folder = demo("nine-cameras", &["--cameras", "3", "--frames", "22", "--size", "60x44"]);
    is_same_in_parts(folder.path(), &[], 6);
    is_same_in_parts(folder.path(), &["--set", "capture.cache=16"], 1);
    let folder = demo("orrery", &["--cameras", "2", "--frames", "3", "--size", "48x36"]);
    is_same_in_parts(folder.path(), &["--set", "store.normals=true"], 5);
}

#[test]
fn parts_share_the_one_correction_of_the_rig() {
    let folder = demo("orrery", &["--cameras", "6", "--frames", "6", "--size", "160x120"]);
    let folder = folder.path();
    let manifest = folder.join("scene/transforms.json");
    let mut moved: serde_json::Value = serde_json::from_slice(&std::fs::read(&manifest).unwrap()).unwrap();
    let first = moved["frames"][0]["camera"].clone();
    for frame in moved["frames"].as_array_mut().unwrap().iter_mut().filter(|frame| frame["camera"] == first) {
        let x = &mut frame["transform_matrix"][0][3];
        *x = (x.as_f64().unwrap() + 0.05).into();
    }
    std::fs::write(&manifest, moved.to_string()).unwrap();
    let align = ["--set", "align.poses=auto", "--set", "align.exposure=auto"];
    is_same_in_parts(folder, &align, 2);
    let info =
        succeed(folder, &[&["preprocess", "scene", "--out", "whole.ovl", "--json"][..], &align].concat());
    let info: serde_json::Value = serde_json::from_str(&info).unwrap();
    assert!(info["report"]["alignment"]["cameras"].is_array(), "the pose was mended");
}

#[test]
fn a_part_whose_picture_changed_is_refused_by_name_and_made_again() {
    let folder = scene("12", "48x36");
    let folder = folder.path();
    in_parts(folder, &[], 3);
    let store = std::fs::read(folder.join("parts.ovl")).unwrap();
    let stage = |arguments: &[&'static str]| {
        [&["preprocess", "scene", "--out", "parts.ovl", "--stage"][..], arguments].concat()
    };
    // Frames 4 to 7 belong to the second part; the first, the middle and the last two are those that noise was measured on.
    let manifest: serde_json::Value =
        serde_json::from_slice(&std::fs::read(folder.join("scene/transforms.json")).unwrap()).unwrap();
    let frames = manifest["frames"].as_array().unwrap();
    let of_first = frames.iter().filter(|frame| frame["camera"] == frames[0]["camera"]);
    let pictures: Vec<PathBuf> =
        of_first.map(|frame| folder.join("scene").join(frame["file_path"].as_str().unwrap())).collect();
    assert_eq!(pictures.len(), 12);
    std::fs::copy(&pictures[8], &pictures[7]).unwrap();
    let said = fail(folder, &stage(&["prune", "--join", "3"]), 1);
    assert!(
        said.contains(
            "parts.ovl.scan.part-2-of-3: was made from another state of the pictures of its frames"
        ),
        "{said}"
    );
    assert!(said.contains("--stage scan --part 2/3"), "{said}");

    succeed(folder, &stage(&["scan", "--part", "2/3"]));
    let said = fail(folder, &stage(&["prune", "--part", "1/3"]), 1);
    assert!(
        said.contains("parts.ovl.spans-of-3: was made from another state of the parts of the scan"),
        "{said}"
    );
    in_parts(folder, &[], 3);
    let joined = std::fs::read(folder.join("parts.ovl")).unwrap();
    succeed(folder, &["preprocess", "scene", "--out", "whole.ovl"]);
    assert!(joined == std::fs::read(folder.join("whole.ovl")).unwrap() && joined != store);

    std::fs::copy(&pictures[1], &pictures[0]).unwrap();
    let said = fail(folder, &stage(&["scan", "--part", "1/3"]), 1);
    assert!(said.contains("parts.ovl.measured: was made from another state of the pictures"), "{said}");
}

#[test]
fn stages_that_are_missing_are_named_and_nonsense_is_refused() {
    let folder = scene("2", "48x36");
    let folder = folder.path();
    let stage =
        |arguments: &[&'static str]| [&["preprocess", "scene", "--out", "parts.ovl"][..], arguments].concat();
    let said = fail(folder, &stage(&["--stage", "scan", "--part", "1/2"]), 1);
    assert!(said.contains("parts.ovl.measured: is missing; make it with --stage measure"), "{said}");
    succeed(folder, &stage(&["--stage", "measure"]));
    let said = fail(folder, &stage(&["--stage", "scan", "--join", "2"]), 1);
    assert!(
        said.contains("parts.ovl.scan.part-1-of-2: is missing; make it with --stage scan --part 1/2"),
        "{said}"
    );
    for nonsense in [&["--part", "1/2"][..], &["--stage", "prune"], &["--stage", "measure", "--join", "2"]] {
        let said = fail(folder, &stage(nonsense), 2);
        assert!(said.contains("--part"), "{said}");
    }
    succeed(folder, &stage(&["--stage", "measure", "--set", "spans.levels=paper"]));
    let said = fail(folder, &stage(&["--stage", "scan", "--part", "1/2", "--set", "spans.levels=paper"]), 1);
    assert!(said.contains("spans.levels"), "{said}");
}
