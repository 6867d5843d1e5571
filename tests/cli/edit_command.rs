//! Edit lists on the command line: preprocess, edit, render and export obey one list, and say what is wrong with it.

use std::path::Path;

use serde_json::Value;

use crate::command::{overlook, scene, succeed};

/// A box around the middle of the scene, of which one part comes back; a list of one edit that deletes nothing; and one that asks what
/// a store does not know.
const CLEAN: &str = r#"version = 1

[[edit]]
name = "the middle"
do = "delete"
region = { box = { center = [0, 0, 0.5], half_size = [1.2, 1.2, 0.8] } }

[[edit]]
name = "but for its top"
do = "restore"
region = { half_space = { point = [0, 0, 0.9], normal = [0, 0, 1] } }
"#;
const NOTHING: &str = "version = 1\n[[edit]]\ndo = \"delete\"\nregion = { any = [] }\n";
const ASKING: &str = "version = 1\n[[edit]]\ndo = \"delete\"\nregion = { confirmed_by_fewer_than = 1 }\n";

fn bytes(folder: &Path, name: &str) -> Vec<u8> {
    std::fs::read(folder.join(name)).unwrap()
}

fn json(folder: &Path, arguments: &[&str]) -> Value {
    serde_json::from_slice(&succeed(overlook(folder, arguments)).stdout).unwrap()
}

#[test]
fn one_list_gives_the_same_from_the_capture_from_the_store_and_in_every_picture() {
    let folder = scene("2", "64x48");
    let folder = folder.path();
    std::fs::write(folder.join("clean.toml"), CLEAN).unwrap();
    std::fs::write(folder.join("nothing.toml"), NOTHING).unwrap();
    succeed(overlook(folder, &["preprocess", "scene", "--out", "all.ovl"]));
    succeed(overlook(folder, &["edit", "all.ovl", "--edits", "nothing.toml", "--out", "same.ovl"]));
    assert_eq!(bytes(folder, "same.ovl"), bytes(folder, "all.ovl"));

    let arguments = ["edit", "all.ovl", "--edits", "clean.toml", "--out", "clean.ovl", "--json"];
    let said = json(folder, &arguments);
    let count = |name: &str| said[name].as_u64().unwrap();
    assert!(count("samples_deleted") > 0 && count("samples_deleted") < count("samples_before"), "{said}");
    succeed(overlook(folder, &["edit", "clean.ovl", "--edits", "nothing.toml", "--out", "again.ovl"]));
    assert_eq!(bytes(folder, "again.ovl"), bytes(folder, "clean.ovl"));

    let render = |store: &str, out: &str, edits: &[&str]| {
        let arguments = [&["render", store, "--views", "scene/novel/transforms.json", "--out", out], edits];
        succeed(overlook(folder, &arguments.concat()));
    };
    render("all.ovl", "by_list", &["--edits", "clean.toml"]);
    render("clean.ovl", "by_store", &[]);
    let mut pictures = 0;
    for entry in walk(&folder.join("by_list")) {
        let beside = entry.strip_prefix(folder.join("by_list")).unwrap().to_owned();
        assert_eq!(std::fs::read(&entry).unwrap(), bytes(folder, &format!("by_store/{}", beside.display())));
        pictures += 1;
    }
    assert!(pictures > 1);
    for (store, out, edits) in
        [("all.ovl", "a.ply", &["--edits", "clean.toml"][..]), ("clean.ovl", "b.ply", &[])]
    {
        let arguments = [&["export", "points", store, "--frame", "0", "--out", out], edits].concat();
        succeed(overlook(folder, &arguments));
    }
    assert_eq!(bytes(folder, "a.ply"), bytes(folder, "b.ply"));

    let arguments = ["preprocess", "scene", "--edits", "clean.toml", "--out", "pruned.ovl", "--json"];
    let pruned = json(folder, &arguments);
    let pixels = pruned["pixels"].as_object().unwrap();
    let parts: u64 =
        pixels.iter().filter(|(name, _)| *name != "pixels").map(|(_, it)| it.as_u64().unwrap()).sum();
    assert_eq!(Some(parts), pixels["pixels"].as_u64(), "{pixels:?}");
    assert!(pixels["cut"].as_u64().unwrap() > 0);
    // What the whole list leaves of it is all of it, within the precision of the store.
    let arguments = ["edit", "pruned.ovl", "--edits", "clean.toml", "--out", "twice.ovl", "--json"];
    let twice = json(folder, &arguments);
    assert!(
        twice["samples_deleted"].as_u64().unwrap() * 1000 < twice["samples_before"].as_u64().unwrap(),
        "{twice}"
    );
    let info = String::from_utf8(succeed(overlook(folder, &["info", "pruned.ovl"])).stdout).unwrap();
    assert!(info.contains("cut by hand: "), "{info}");
}

fn walk(folder: &Path) -> Vec<std::path::PathBuf> {
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    entries.flat_map(|path| if path.is_dir() { walk(&path) } else { vec![path] }).collect()
}

/// Keeps what is in a small ball far away.
const NOTHING_LEFT: &str =
    "version = 1\n[[edit]]\ndo = \"keep_only\"\nregion = { sphere = { center = [1e6, 0, 0], radius = 1 } }\n";

/// Edits frames that are not there.
const LATER: &str = "version = 1\n[[edit]]\ndo = \"delete\"\nframes = [100, 200]\nregion = { sphere = { center = [0, 0, 0], radius = 1 } }\n";

#[test]
fn a_list_that_asks_for_votes_needs_the_capture_and_a_wrong_one_gives_one_line() {
    let folder = scene("1", "64x48");
    let folder = folder.path();
    for (name, text) in [
        ("asking.toml", ASKING),
        ("nobody.toml", "version = 1\n[[edit]]\ndo = \"leave_out\"\nregion = { cameras = [\"nobody\"] }\n"),
        ("newer.toml", "version = 9\n"),
        ("broken.toml", "version = 1\n[[edit]]\ndo = \"erase\"\n"),
        ("nothing.toml", NOTHING_LEFT),
        ("later.toml", LATER),
    ] {
        std::fs::write(folder.join(name), text).unwrap();
    }
    succeed(overlook(folder, &["preprocess", "scene", "--out", "all.ovl"]));
    let said = |arguments: &[&str]| {
        let output = overlook(folder, arguments).output().unwrap();
        assert_eq!(output.status.code(), Some(1), "{arguments:?}");
        let text = String::from_utf8(output.stderr).unwrap();
        let errors = text.lines().filter(|line| line.starts_with("overlook: ") && !line.contains("warning"));
        assert_eq!(errors.count(), 1, "{text}");
        text
    };
    let edit = |list: &str| said(&["edit", "all.ovl", "--edits", list, "--out", "out.ovl"]);
    assert!(edit("asking.toml").contains("--capture"));
    assert!(edit("nobody.toml").contains("no camera 'nobody'"));
    assert!(edit("newer.toml").contains("version 9"));
    assert!(edit("broken.toml").contains("broken.toml, line 3"));
    assert!(said(&["preprocess", "scene", "--edits", "nobody.toml", "--out", "out.ovl"]).contains("nobody"));
    for command in [&["edit", "all.ovl"], &["preprocess", "scene"]] {
        let refused = said(&[command, &["--edits", "nothing.toml", "--out", "out.ovl"][..]].concat());
        assert!(refused.contains("the edits leave no sample"), "{refused}");
    }
    assert!(!folder.join("out.ovl").exists());
    let later = overlook(folder, &["edit", "all.ovl", "--edits", "later.toml", "--out", "later.ovl"]);
    let warned = String::from_utf8(succeed(later).stderr).unwrap();
    assert!(warned.contains("does nothing: it is of frames 100 to 200, and there are 0 to 0"), "{warned}");
    let arguments =
        ["edit", "all.ovl", "--edits", "asking.toml", "--capture", "scene", "--out", "out.ovl", "--json"];
    assert!(json(folder, &arguments)["samples_deleted"].as_u64().unwrap() > 0);
}

#[test]
fn a_list_that_a_store_has_behind_it_changes_nothing_more() {
    let folder = scene("1", "64x48");
    let folder = folder.path();
    let info = json(folder, &["info", "scene", "--json"]);
    let camera = info["cameras"][0]["name"].as_str().unwrap();
    let seen = format!(
        "version = 1\n[[edit]]\ndo = \"delete\"\nregion = {{ pixels = {{ camera = {camera:?}, frame = 0, \
         outline = [[16, 12], [48, 12], [48, 36], [16, 36]] }} }}\n"
    );
    std::fs::write(folder.join("seen.toml"), seen).unwrap();
    succeed(overlook(folder, &["preprocess", "scene", "--out", "all.ovl"]));
    let edit = |store: &str, out: &str| {
        json(folder, &["edit", store, "--edits", "seen.toml", "--out", out, "--json"])["samples_deleted"]
            .clone()
    };
    assert!(edit("all.ovl", "once.ovl").as_u64() > Some(0));
    assert_eq!(edit("once.ovl", "twice.ovl"), 0);
    assert_eq!(bytes(folder, "twice.ovl"), bytes(folder, "once.ovl"));
}

#[test]
fn every_command_that_makes_something_of_a_store_or_of_recorded_pictures_obeys_a_list() {
    let folder = scene("1", "64x48");
    let folder = folder.path();
    std::fs::write(folder.join("clean.toml"), CLEAN).unwrap();
    std::fs::write(folder.join("asking.toml"), ASKING).unwrap();
    succeed(overlook(folder, &["preprocess", "scene", "--out", "all.ovl"]));
    succeed(overlook(folder, &["edit", "all.ovl", "--edits", "clean.toml", "--out", "clean.ovl"]));
    let again = |store: &str, out: &str, edits: &[&str]| {
        let arguments = ["export", "store", store, "--out", out, "--set", "store.precision=bits8"];
        succeed(overlook(folder, &[&arguments[..], edits].concat()));
        bytes(folder, out)
    };
    assert_eq!(again("all.ovl", "a.ovl", &["--edits", "clean.toml"]), again("clean.ovl", "b.ovl", &[]));

    let of_capture: [&[&str]; 2] = [
        &["export", "figure", "scene", "--overlay", "depth", "--no-legend", "--out"],
        &["place", "scene", "--cameras", "2", "--out"],
    ];
    for (arguments, name) in of_capture.into_iter().zip(["depth.png", "placed.json"]) {
        let with = |name: &str, edits: &[&str]| {
            std::fs::create_dir_all(folder.join(name).parent().unwrap()).unwrap();
            overlook(folder, &[arguments, &[name], edits].concat()).output().unwrap()
        };
        for (folder, edits) in [("whole/", &[][..]), ("edited/", &["--edits", "clean.toml"])] {
            let output = with(&format!("{folder}{name}"), edits);
            assert!(output.status.success(), "{output:?}");
        }
        let all = |kind: &str| -> Vec<Vec<u8>> {
            let mut files = walk(&folder.join(kind));
            files.retain(|file| file.starts_with(folder.join(kind).join(name)));
            files.sort();
            files.iter().map(|file| std::fs::read(file).unwrap()).collect()
        };
        // The best places of two cameras may be the same without what the list cuts.
        let differ = name == "placed.json" || all("whole") != all("edited");
        assert!(!all("whole").is_empty() && differ, "{name}");
        let refused = with(&format!("refused/{name}"), &["--edits", "asking.toml"]);
        let said = String::from_utf8(refused.stderr).unwrap();
        assert!(
            !refused.status.success() && said.contains("edit 1") && said.contains("use the store"),
            "{said}"
        );
    }
}
