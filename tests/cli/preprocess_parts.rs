//! Preprocessing cut by runs of frames: the joined store has the bytes of one piece, a part whose pictures change is refused by name.

use std::path::{Path, PathBuf};

use crate::command::scene;
use crate::said::{fail, succeed};
use overlook_engine::capture::transforms::write_capture;
use overlook_engine::demo::{Demo, DemoSpec};
use overlook_engine::job::Job;
use overlook_engine::settings::CaptureSettings;

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
    is_same_in_parts(folder.path(), &["--set", "capture.memory=16"], 1);
    let folder = demo("orrery", &["--cameras", "2", "--frames", "3", "--size", "48x36"]);
    is_same_in_parts(folder.path(), &["--set", "store.normals=true"], 5);
}

#[test]
fn a_store_in_parts_obeys_a_list_of_edits_to_the_bytes_of_one_piece() {
    let folder = demo("nine-cameras", &["--cameras", "4", "--frames", "12", "--size", "60x44"]);
    let folder = folder.path();
    let info = succeed(folder, &["info", "scene", "--json"]);
    let info: serde_json::Value = serde_json::from_str(&info).unwrap();
    let camera = info["cameras"][1]["name"].as_str().unwrap();
    let outline = "[[10, 10], [40, 10], [40, 30], [10, 30]]";
    let list = format!(
        "version = 1\n\
         [[edit]]\ndo = \"delete\"\nregion = {{ sphere = {{ center = [0, 0, 0.5], radius = 0.6 }} }}\nframes = [2, 7]\n\
         [[edit]]\ndo = \"delete\"\nregion = {{ pixels = {{ camera = {camera:?}, frame = 3, outline = {outline} }} }}\n\
         [[edit]]\ndo = \"delete\"\nregion = {{ confirmed_by_fewer_than = 1 }}\nframes = [5, 5]\nreach = \"span\"\n\
         [[edit]]\ndo = \"leave_out\"\nregion = {{ cameras = [{camera:?}] }}\n"
    );
    std::fs::write(folder.join("list.toml"), list).unwrap();
    is_same_in_parts(folder, &["--edits", "list.toml"], 3);
    let cut = succeed(folder, &["preprocess", "scene", "--out", "w.ovl", "--edits", "list.toml", "--json"]);
    let cut: serde_json::Value = serde_json::from_str(&cut).unwrap();
    let cut = &cut["report"]["cut"][0];
    assert!(cut["pixels"].as_u64() > Some(0) && cut["samples"].as_u64() > Some(0), "{cut}");
    let without = ["preprocess", "scene", "--out", "parts.ovl", "--stage", "scan", "--part", "1/3"];
    let said = fail(folder, &without, 1);
    assert!(said.contains("parts.ovl.measured: was made from another state of the edits"), "{said}");
}

#[test]
fn parts_share_the_one_correction_of_the_rig() {
    let folder = demo("orrery", &["--cameras", "6", "--frames", "6", "--size", "160x120"]);
    let folder = folder.path();
    let manifest = folder.join("scene/transforms.json");
    let mut moved: serde_json::Value = serde_json::from_slice(&std::fs::read(&manifest).unwrap()).unwrap();
    let first = moved["frames"][0]["camera"].clone();
    for frame in moved["frames"].as_array_mut().unwrap().iter_mut().filter(|frame| frame["camera"] == first) {
        let y = &mut frame["transform_matrix"][1][3];
        *y = (y.as_f64().unwrap() + 0.05).into();
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
    // Frames 4 to 7 belong to the second part; the first, the two in the middle and the last two are those that noise and clocks were
    // measured on.
    let manifest: serde_json::Value =
        serde_json::from_slice(&std::fs::read(folder.join("scene/transforms.json")).unwrap()).unwrap();
    let frames = manifest["frames"].as_array().unwrap();
    let of_first = frames.iter().filter(|frame| frame["camera"] == frames[0]["camera"]);
    let pictures: Vec<PathBuf> =
        of_first.map(|frame| folder.join("scene").join(frame["file_path"].as_str().unwrap())).collect();
    assert_eq!(pictures.len(), 12);
    std::fs::copy(&pictures[8], &pictures[4]).unwrap();
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

/// Records five cameras of the orrery into `scene`. The second is late by one frame: its pictures show what the others see a frame
/// later. Returns the pictures of that camera.
fn record_late(folder: &Path) -> Vec<PathBuf> {
    const FRAMES: i64 = 32;
    let demo = Demo::new(&DemoSpec::new("orrery").cameras(5).frames(96).size((160, 120))).unwrap();
    let capture = demo.capture(&CaptureSettings::default()).with_frame_numbers((0..=FRAMES).collect());
    write_capture(&folder.join("scene"), &capture, &[], &Job::new()).unwrap();
    let manifest = folder.join("scene/transforms.json");
    let mut late: serde_json::Value = serde_json::from_slice(&std::fs::read(&manifest).unwrap()).unwrap();
    let entries = late["frames"].as_array_mut().unwrap();
    let name = capture.cameras[1].name.as_str();
    let is_late = |entry: &serde_json::Value| entry["camera"] == name;
    let files: Vec<serde_json::Value> =
        entries.iter().filter(|entry| is_late(entry)).map(|entry| entry["file_path"].clone()).collect();
    for (entry, file) in entries.iter_mut().filter(|entry| is_late(entry)).zip(&files[1..]) {
        entry["file_path"] = file.clone();
    }
    entries.retain(|entry| entry["time"] != FRAMES);
    std::fs::write(&manifest, late.to_string()).unwrap();
    files[1..].iter().map(|file| folder.join("scene").join(file.as_str().unwrap())).collect()
}

#[test]
fn a_part_whose_frames_are_moved_in_time_is_refused_where_a_picture_changed_that_they_show() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let pictures = record_late(folder);
    let clock = ["--set", "align.clock=on", "--set", "align.poses=off", "--set", "align.exposure=off"];
    is_same_in_parts(folder, &clock, 5);
    let whole = [&["preprocess", "scene", "--out", "whole.ovl", "--json"][..], &clock].concat();
    let report: serde_json::Value = serde_json::from_str(&succeed(folder, &whole)).unwrap();
    assert_eq!(report["report"]["alignment"]["cameras"][1]["clock"]["shifted"], 1);
    // The fourth part begins with frame 19, which shows what the late camera recorded as frame 18, the last one of the third part.
    std::fs::copy(&pictures[17], &pictures[18]).unwrap();
    let stage = |arguments: &[&'static str]| {
        [&["preprocess", "scene", "--out", "parts.ovl", "--stage"][..], arguments, &clock].concat()
    };
    succeed(folder, &stage(&["scan", "--part", "3/5"]));
    let said = fail(folder, &stage(&["scan", "--join", "5"]), 1);
    assert!(
        said.contains(
            "parts.ovl.scan.part-4-of-5: was made from another state of the pictures of its frames"
        ),
        "{said}"
    );
    succeed(folder, &stage(&["scan", "--part", "4/5"]));
    succeed(folder, &stage(&["scan", "--join", "5"]));
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
