//! Work cut into parts by the command line: joined results are those of one piece, a part of other inputs is refused by name, and
//! one that was cut short goes on.

use std::collections::BTreeMap;
use std::path::Path;

use crate::command::scene;
use crate::said::{fail, succeed};
use serde_json::Value;

/// All files of results below a folder, by their names: neither parts nor journals.
fn results(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let (path, name) = entry.map(|entry| (entry.path(), entry.file_name())).unwrap();
        let name = name.into_string().unwrap();
        if path.is_dir() {
            found.extend(results(&path).into_iter().map(|(inner, bytes)| (format!("{name}/{inner}"), bytes)));
        } else if !name.contains(".part-") && !name.contains(".journal") {
            found.insert(name, std::fs::read(path).unwrap());
        }
    }
    found
}

fn are_same(one: &BTreeMap<String, Vec<u8>>, other: &BTreeMap<String, Vec<u8>>) {
    assert_eq!(one.keys().collect::<Vec<_>>(), other.keys().collect::<Vec<_>>());
    for (name, bytes) in one {
        assert!(other[name] == *bytes, "{name} differs");
    }
}

/// Copies the points of all parts into the journal of a run in one piece: clocks never run alike twice.
fn take_times(folder: &Path, name: &str, of: usize) {
    let journal = folder.join(format!("{name}.journal"));
    let mut text = std::fs::read_to_string(&journal).unwrap().lines().next().unwrap().to_owned() + "\n";
    for part in 1..=of {
        let lines = std::fs::read_to_string(folder.join(format!("{name}.part-{part}-of-{of}"))).unwrap();
        let count = lines.lines().count();
        text.extend(lines.lines().skip(1).take(count - 2).flat_map(|line| [line, "\n"]));
    }
    std::fs::write(journal, text).unwrap();
}

/// A document without what depends on a clock, and on what was compared by it.
fn timeless(mut document: Value) -> Value {
    fn strip(value: &mut Value) {
        match value {
            Value::Object(map) => {
                map.retain(|key, _| {
                    !["milliseconds", "milliseconds_se", "seconds_preprocess", "pareto", "peak"]
                        .contains(&key.as_str())
                });
                map.values_mut().for_each(strip);
            }
            Value::Array(list) => list.iter_mut().for_each(strip),
            _ => {}
        }
    }
    strip(&mut document);
    document
}

fn json(path: &Path) -> Value {
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

#[test]
fn a_sweep_in_parts_gives_the_files_of_one_piece() {
    let folder = scene("2", "48x36");
    let folder = folder.path();
    let sweep = |more: &[&'static str]| {
        let sweep = [
            "sweep",
            "scene",
            "--vary",
            "pruning.depth_tolerance=0.5,2",
            "--kernel",
            "block",
            "--out",
            "out",
        ];
        [&sweep[..], more].concat()
    };
    for part in ["3/3", "1/3", "2/3"] {
        let said = succeed(folder, &[&sweep(&["--part"])[..], &[part]].concat());
        assert!(said.contains("--join 3") && said.contains(&format!("Part {part} is complete")), "{said}");
    }
    succeed(folder, &sweep(&["--join", "3"]));
    let joined = results(&folder.join("out"));
    assert!(joined.contains_key("report.html") && joined.contains_key("worst1.png"), "{:?}", joined.keys());

    let in_parts = json(&folder.join("out/sweep.json"));
    succeed(folder, &sweep(&[]));
    assert_eq!(
        timeless(in_parts),
        timeless(json(&folder.join("out/sweep.json"))),
        "but for times one piece gives the same"
    );
    take_times(&folder.join("out"), "sweep", 3);
    succeed(folder, &sweep(&[]));
    are_same(&joined, &results(&folder.join("out")));

    // Parts of other settings and of another capture are refused by name.
    let said =
        fail(folder, &[&sweep(&["--join", "3"])[..], &["--set", "pruning.normal_tolerance=20"]].concat(), 1);
    assert!(
        said.contains("sweep.part-1-of-3: was made from another state of the list of settings"),
        "{said}"
    );
    let manifest = folder.join("scene/transforms.json");
    let text = std::fs::read_to_string(&manifest).unwrap();
    std::fs::write(&manifest, text + "\n").unwrap();
    succeed(folder, &sweep(&["--part", "1/3"]));
    let said = fail(folder, &sweep(&["--join", "3"]), 1);
    assert!(
        said.contains("sweep.part-2-of-3") && said.contains("another state of the capture or its truth"),
        "{said}"
    );
    assert!(said.contains("--part 2/3"), "{said}");
}

#[test]
fn a_stress_test_in_parts_gives_the_files_of_one_piece() {
    let folder = scene("1", "48x36");
    let folder = folder.path();
    let stress = |more: &[&'static str]| {
        let stress =
            ["stress", "scene", "--only", "camera pose", "--set", "render.kernel=block", "--out", "out"];
        [&stress[..], more].concat()
    };
    for part in ["1/2", "2/2"] {
        succeed(folder, &stress(&["--part", part]));
    }
    succeed(folder, &stress(&["--join", "2"]));
    let joined = results(&folder.join("out"));
    succeed(folder, &stress(&[]));
    take_times(&folder.join("out"), "stress", 2);
    succeed(folder, &stress(&[]));
    are_same(&joined, &results(&folder.join("out")));
    let said = fail(folder, &stress(&["--join", "3"]), 1);
    assert!(said.contains("stress.part-1-of-3: is missing"), "{said}");
}

#[test]
fn tuning_in_parts_finds_the_settings_of_one_piece() {
    let folder = scene("2", "48x36");
    let folder = folder.path();
    let tune = |more: &[&'static str]| {
        let tune = ["tune", "scene", "--frames", "1", "--all-cameras", "--set", "render.kernel=block"];
        [&tune[..], more].concat()
    };
    let whole = succeed(folder, &tune(&["--out", "whole.toml"]));
    for part in ["2/2", "1/2"] {
        succeed(folder, &tune(&["--out", "joined.toml", "--journal", "tuning", "--part", part]));
    }
    let joined = succeed(folder, &tune(&["--out", "joined.toml", "--journal", "tuning", "--join", "2"]));
    assert_eq!(joined.replace("joined.toml", "whole.toml"), whole);
    let [joined, whole] = ["joined.toml", "whole.toml"].map(|name| std::fs::read(folder.join(name)).unwrap());
    assert!(joined == whole);
    let journal = std::fs::read_to_string(folder.join("tuning/tune.journal")).unwrap();
    assert!(!journal.contains("\"label\":\"no pruning\""), "what parts measured is not measured again");
}

#[test]
fn views_painted_in_parts_are_those_of_one_piece_and_a_part_goes_on_where_it_was_cut() {
    let folder = scene("3", "48x36");
    let folder = folder.path();
    succeed(folder, &["preprocess", "scene", "--out", "scene.ovl"]);
    let render = |out: &'static str, more: &[&'static str]| {
        let render =
            ["render", "scene.ovl", "--views", "scene/novel/transforms.json", "--json", "--out", out];
        [&render[..], more].concat()
    };
    let whole = succeed(folder, &render("whole", &[]));
    for part in ["1/4", "2/4", "3/4", "4/4"] {
        succeed(folder, &[&render("parts", &[])[..], &["--part", part]].concat());
    }
    let joined = succeed(folder, &render("parts", &["--join", "4"]));
    let value = |text: &str| timeless(serde_json::from_str(text).unwrap());
    assert_eq!(value(&joined), value(&whole), "scores, means and flicker");
    assert!(value(&whole)["mean"]["flicker_steps"].is_number());
    are_same(&results(&folder.join("whole")), &results(&folder.join("parts")));

    // A part that fails at its second view has the first one in its journal, and does not paint it again.
    let (part, journal) = ("parts/render.part-1-of-4", "parts/render.part-1-of-4.journal");
    let lines = |name: &str| -> Vec<String> {
        std::fs::read_to_string(folder.join(name)).unwrap().lines().skip(1).map(str::to_owned).collect()
    };
    let second: Value = serde_json::from_str(&lines(part)[1]).unwrap();
    let manifest = json(&folder.join("scene/novel/transforms.json"));
    let file_path = &manifest["frames"][second["view"].as_u64().unwrap() as usize]["file_path"];
    let picture = folder.join("parts").join(file_path.as_str().unwrap()).with_extension("exr");
    std::fs::remove_file(folder.join(part)).unwrap();
    std::fs::remove_file(&picture).unwrap();
    std::fs::create_dir(&picture).unwrap();
    fail(folder, &render("parts", &["--part", "1/4"]), 1);
    assert!(!folder.join(part).exists());
    let first = lines(journal)[0].clone();
    std::fs::remove_dir(&picture).unwrap();
    succeed(folder, &render("parts", &["--part", "1/4"]));
    assert!(lines(part)[0] == first && !folder.join(journal).exists());
    are_same(&results(&folder.join("whole")), &results(&folder.join("parts")));

    std::fs::write(&picture, "no picture").unwrap();
    let said = fail(folder, &render("parts", &["--join", "4"]), 1);
    assert!(said.contains("changed since its part was made"), "{said}");
}

#[test]
fn films_in_parts_are_those_of_one_piece() {
    let folder = scene("6", "48x36");
    let folder = folder.path();
    succeed(folder, &["preprocess", "scene", "--out", "scene.ovl"]);
    let export = |what: &'static str, out: &'static str, more: &[&'static str]| {
        let export = ["export", what, "scene.ovl", "--path", "path.json", "--out", out];
        [&export[..], more].concat()
    };
    let pose = |x: f64| serde_json::json!([[1, 0, 0, x], [0, 0, -1, -3], [0, 1, 0, 1], [0, 0, 0, 1]]);
    let view = |time: i64, x: f64| serde_json::json!({ "file_path": format!("{time}.exr"), "time": time, "transform_matrix": pose(x) });
    let path = serde_json::json!({ "w": 48, "h": 36, "fl_x": 40, "frames": [view(0, 0.0), view(5, 0.4)] });
    std::fs::write(folder.join("path.json"), path.to_string()).unwrap();
    succeed(folder, &export("pictures", "whole", &[]));
    for part in ["1/3", "2/3", "3/3"] {
        succeed(folder, &export("pictures", "parts", &["--part", part]));
    }
    succeed(folder, &export("pictures", "parts", &["--join", "3"]));
    are_same(&results(&folder.join("whole")), &results(&folder.join("parts")));
    std::fs::remove_file(folder.join("parts/0003.png")).unwrap();
    assert!(fail(folder, &export("pictures", "parts", &["--join", "3"]), 1).contains("0003.exr"));

    if std::process::Command::new("ffmpeg").arg("-version").output().is_ok() {
        succeed(folder, &export("video", "whole.mp4", &[]));
        for part in ["1/3", "2/3", "3/3"] {
            succeed(folder, &export("video", "parts.mp4", &["--part", part]));
        }
        succeed(folder, &export("video", "parts.mp4", &["--join", "3"]));
        let [whole, joined] =
            ["whole.mp4", "parts.mp4"].map(|name| std::fs::read(folder.join(name)).unwrap());
        assert!(whole == joined && !whole.is_empty());
        let said =
            fail(folder, &export("video", "parts.mp4", &["--join", "3", "--set", "render.kernel=point"]), 1);
        assert!(
            said.contains("parts.mp4.part-1-of-3") && said.contains("another state of the settings"),
            "{said}"
        );
    }
}
