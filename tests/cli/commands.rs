//! The program as a person or a script meets it: exit codes, one clear line of trouble, JSON, and the whole chain.

use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

fn overlook(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_overlook"))
        .args(arguments)
        .current_dir(folder)
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .env_remove("RUST_LOG")
        .output()
        .unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

fn success(folder: &Path, arguments: &[&str]) -> String {
    let output = overlook(folder, arguments);
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {}", text(&output.stderr));
    text(&output.stdout)
}

fn json(folder: &Path, arguments: &[&str]) -> Value {
    let stdout = success(folder, arguments);
    serde_json::from_str(&stdout).unwrap_or_else(|error| panic!("{arguments:?}: {error}\n{stdout}"))
}

/// The one line on stderr of a command that fails on bad input.
fn trouble(folder: &Path, arguments: &[&str]) -> String {
    let output = overlook(folder, arguments);
    let stderr = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{arguments:?}: {stderr}");
    assert!(output.stdout.is_empty());
    assert!(stderr.starts_with("overlook: ") && stderr.lines().count() == 1, "{arguments:?}: {stderr}");
    stderr
}

fn assert_keys(document: &Value, keys: &[&str]) {
    for key in keys {
        assert!(document.get(key).is_some(), "no key '{key}' in {document}");
    }
}

#[test]
fn bad_usage_exits_with_2() {
    let folder = tempfile::tempdir().unwrap();
    for arguments in [
        ["preprocess"].as_slice(),
        &["preprocess", "x", "--out", "y", "--nonsense"],
        &["preprocess", "x", "--out", "y", "--set", "pruning.nonsense=1"],
        &["preprocess", "x", "--out", "y", "--set", "pruning.rate"],
        &["render", "x", "--views", "y", "--out", "z", "--kernel", "sphere"],
        &["demo", "atlantis", "--out", "x"],
        &["demo", "orrery", "--out", "x", "--size", "big"],
        &["demo", "orrery", "--out", "x", "--cameras", "0"],
        &["demo", "orrery", "--out", "x", "--noise", "-1"],
        &["render", "x", "--views", "y", "--out", "z", "--set", "pruning.rate=paper"],
        &["export", "pictures", "x", "--path", "y", "--out", "z", "--set", "store.precision=bits8"],
        &["export", "video", "x", "--path", "y", "--out", "z", "--set", "spans.levels=off"],
        &["export", "store", "x", "--out", "z", "--set", "render.kernel=block"],
        &["evaluate", "x", "--views", "y", "--hold-out", "z"],
        &["info", "x", "--threads", "0"],
    ] {
        let output = overlook(folder.path(), arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(output.stdout.is_empty() && !output.stderr.is_empty());
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "nothing was written");
}

#[test]
fn bad_input_exits_with_1_and_one_line_that_names_it() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("broken.ovl"), b"FORM\0\0\0\x09OVLK").unwrap();
    std::fs::write(folder.path().join("bad.toml"), "[pruning]\nrat = 1\n").unwrap();
    for arguments in [
        ["info", "missing"].as_slice(),
        &["preprocess", "missing", "--out", "o.ovl"],
        &["evaluate", "missing", "--hold-out", "cam0"],
        &["render", "missing", "--views", "v", "--out", "d"],
        &["missing"],
    ] {
        assert!(trouble(folder.path(), arguments).contains("missing"));
    }
    // Where results go is looked at before anything else.
    for arguments in [
        ["preprocess", "x", "--out", "no/where.ovl"].as_slice(),
        &["tune", "x", "--out", "no/where.toml"],
        &["export", "store", "x", "--out", "no/where.ovl"],
        &["export", "video", "x", "--path", "y", "--out", "no/where.mp4"],
        &["export", "points", "x", "--static", "--out", "no/where.ply"],
    ] {
        assert!(trouble(folder.path(), arguments).contains("folder no does not exist"));
    }
    for arguments in [
        ["render", "x", "--views", "y", "--out", "bad.toml/pictures"].as_slice(),
        &["export", "pictures", "x", "--path", "y", "--out", "bad.toml"],
        &["export", "points", "x", "--out", "bad.toml"],
    ] {
        assert!(trouble(folder.path(), arguments).contains("bad.toml: is a file"));
    }
    assert!(trouble(folder.path(), &["preprocess", "x", "--out", "."]).contains("is a folder"));
    assert!(trouble(folder.path(), &["info", "broken.ovl"]).contains("broken.ovl"));
    assert!(
        trouble(folder.path(), &["preprocess", "x", "--out", "y", "--settings", "bad.toml"])
            .contains("bad.toml")
    );
}

#[test]
#[cfg(target_os = "linux")]
fn without_a_display_one_line_names_the_commands_that_work() {
    let folder = tempfile::tempdir().unwrap();
    let line = trouble(folder.path(), &[]);
    for command in ["demo", "info", "preprocess", "render", "evaluate"] {
        assert!(line.contains(command), "{line}");
    }
}

#[test]
fn help_and_settings_explain_themselves() {
    let folder = tempfile::tempdir().unwrap();
    let help = success(folder.path(), &["--help"]);
    for word in ["Examples:", "preprocess", "evaluate", "settings", "--threads"] {
        assert!(help.contains(word), "{help}");
    }
    assert!(success(folder.path(), &["--version"]).contains(env!("CARGO_PKG_VERSION")));
    let settings = success(folder.path(), &["settings", "--set", "pruning.method=off"]);
    assert!(settings.contains("[pruning]") && settings.contains("method = \"off\""));
}

/// Everything that can be done with a small capture, in the order a person would.
#[test]
fn the_whole_chain_runs_from_a_demo_to_scores() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let size = ["--cameras", "3", "--frames", "4", "--size", "64x48"];
    success(here, &[&["demo", "orrery", "--out", "scene"], size.as_slice()].concat());

    let info = json(here, &["info", "scene", "--json"]);
    assert_eq!((&info["kind"], &info["frames"]), (&Value::from("capture"), &Value::from(4)));
    assert_eq!(info["cameras"].as_array().unwrap().len(), 3);
    assert_eq!((&info["cameras"][2]["width"], &info["cameras"][2]["height"]), (&64.into(), &48.into()));

    let made = json(
        here,
        &["preprocess", "scene", "--out", "scene.ovl", "--measure-decode", "--threads", "2", "--json"],
    );
    assert_keys(&made, &["peak_rss_bytes", "pruned", "seconds_decode_only", "seconds_total"]);
    assert_eq!(made["samples_in"], 3 * 4 * 64 * 48);
    assert_eq!(made["bytes_raw"], 3 * 4 * 64 * 48 * 7);
    assert_eq!(made["threads"], 2);
    assert!(made["samples_kept"].as_u64().unwrap() < made["samples_in"].as_u64().unwrap());
    assert_eq!(made["bytes_store"], std::fs::metadata(here.join("scene.ovl")).unwrap().len());

    success(here, &["preprocess", "scene", "--out", "again.ovl", "--threads", "1"]);
    let bytes = |name: &str| std::fs::read(here.join(name)).unwrap();
    assert!(bytes("scene.ovl") == bytes("again.ovl"), "the same bytes with one and with two threads");

    let info = json(here, &["info", "scene.ovl", "--json"]);
    assert_keys(&info, &["spans", "settings", "cameras", "frames"]);
    assert_eq!(info["kind"], "store");
    assert_eq!((&info["samples"], &info["bytes"]), (&made["samples_kept"], &made["bytes_store"]));

    let views = "scene/novel/transforms.json";
    let painted = json(
        here,
        &["render", "scene.ovl", "--views", views, "--out", "pictures", "--kernel", "point", "--json"],
    );
    let scored = json(here, &["evaluate", "scene", "--set", "render.kernel=point", "--json"]);
    for document in [&painted, &scored] {
        let keys = ["psnr_db", "ssim", "coverage", "milliseconds", "samples"];
        assert_keys(&document["mean"], &keys);
        for view in document["views"].as_array().unwrap() {
            assert_keys(view, &keys);
        }
    }
    // Through the file or not: the same samples, the same pictures.
    assert_eq!(painted["mean"]["psnr_db"], scored["mean"]["psnr_db"]);
    filling_is_the_default_and_keeps_the_mask(here, views, &painted);
    assert_keys(&scored, &["no_pruning", "first_camera", "samples_kept", "bytes_memory", "bytes_store"]);
    what_the_store_gives_up_shows_in_the_scores(here, views);
    for view in painted["views"].as_array().unwrap() {
        let exr = here.join("pictures").join(view["file_path"].as_str().unwrap());
        let png = image::open(exr.with_extension("png")).unwrap();
        assert_eq!((png.width(), png.height()), (64, 48));
        assert!(exr.is_file());
    }
}

fn what_the_store_gives_up_shows_in_the_scores(here: &Path, views: &str) {
    let [exact, rounded] = ["store.precision=lossless", "store.precision=bits8"].map(|text| ["--set", text]);
    let point = ["--kernel", "point", "--json"];
    let lossless = &json(here, &[["evaluate", "scene"].as_slice(), &exact, &point].concat());
    let scored = json(here, &[["evaluate", "scene"].as_slice(), &rounded, &point].concat());
    success(here, &[["preprocess", "scene", "--out", "exact.ovl"].as_slice(), &exact].concat());
    success(here, &[["export", "store", "exact.ovl", "--out", "rounded.ovl"].as_slice(), &rounded].concat());
    let render = ["render", "rounded.ovl", "--views", views, "--out", "rounded"];
    let painted = json(here, &[render.as_slice(), &point].concat());
    assert_eq!(scored["mean"]["psnr_db"], painted["mean"]["psnr_db"]);
    assert_ne!(scored["mean"]["psnr_db"], lossless["mean"]["psnr_db"]);
    for method in [&["bytes_store"][..], &["no_pruning", "bytes_store"]] {
        let bytes =
            |document: &Value| method.iter().fold(document.clone(), |it, key| it[*key].clone()).as_u64();
        assert!(bytes(&scored).unwrap() < bytes(lossless).unwrap());
    }
}

/// `filled` is what `render` says of `views` by default; its pictures are in `pictures`.
fn filling_is_the_default_and_keeps_the_mask(here: &Path, views: &str, filled: &Value) {
    let unfilled = ["--kernel", "point", "--fill", "none", "--json"];
    let render = ["render", "scene.ovl", "--views", views, "--out", "unfilled"];
    let plain = json(here, &[render.as_slice(), &unfilled].concat());
    let scored = json(here, &[["evaluate", "scene"].as_slice(), &unfilled].concat());
    assert_eq!(plain["mean"]["psnr_all_db"], scored["mean"]["psnr_all_db"]);
    for key in ["psnr_db", "coverage"] {
        assert_eq!(filled["mean"][key], plain["mean"][key]);
    }
    assert!(filled["mean"]["psnr_all_db"].as_f64() > plain["mean"]["psnr_all_db"].as_f64());
    // Alpha is of what there is to see, in both formats; OpenEXR says beside it what was sampled.
    let name = filled["views"][0]["file_path"].as_str().unwrap();
    let transparent = |folder: &str| {
        let png = image::open(here.join(folder).join(name).with_extension("png")).unwrap().to_rgba8();
        png.pixels().filter(|pixel| pixel.0[3] == 0).count()
    };
    let channel = |folder: &str, name_of_channel: &str| -> Vec<f32> {
        let file = exr::prelude::read_first_flat_layer_from_file(here.join(folder).join(name)).unwrap();
        let channels = file.layer_data.channel_data.list;
        let found = channels.iter().find(|channel| channel.name == *name_of_channel).unwrap();
        found.sample_data.values_as_f32().collect()
    };
    let holes =
        |folder: &str, name: &str| channel(folder, name).iter().filter(|share| **share == 0.0).count();
    assert_eq!((holes("pictures", "A"), holes("unfilled", "A")), (0, holes("unfilled", "sampled.V")));
    assert_eq!((transparent("pictures"), transparent("unfilled")), (0, holes("unfilled", "A")));
    let pixels = channel("pictures", "A").len();
    assert!(holes("pictures", "sampled.V") > pixels / 50);
    let [red, green, blue, sampled] = ["R", "G", "B", "sampled.V"].map(|name| channel("pictures", name));
    let is_dark = |at: &usize| sampled[*at] == 0.0 && red[*at] + green[*at] + blue[*at] == 0.0;
    assert_eq!((0..pixels).filter(is_dark).count(), 0, "filled pixels are dark");
}

#[test]
fn a_held_out_camera_is_left_out_and_scored() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    success(here, &["demo", "orrery", "--out", "scene", "--frames", "2", "--size", "48x32"]);
    let info = json(here, &["info", "scene", "--json"]);
    let camera = info["cameras"][1]["name"].as_str().unwrap();
    success(here, &["preprocess", "scene", "--out", "rest.ovl", "--hold-out", camera]);
    let rest = json(here, &["info", "rest.ovl", "--json"]);
    let names: Vec<_> =
        rest["cameras"].as_array().unwrap().iter().map(|c| c["name"].as_str().unwrap()).collect();
    assert!(!names.contains(&camera) && names.len() + 1 == info["cameras"].as_array().unwrap().len());

    let twice = ["--hold-out", camera, "--hold-out", camera, "--json"];
    let scored = json(here, &[&["evaluate", "scene"], &twice[..]].concat());
    assert_eq!(scored["hold_out"], serde_json::json!([camera]), "named twice, left out once");
    assert_eq!(scored["views"].as_array().unwrap().len(), 2);
    assert!(scored["mean"]["coverage"].as_f64().unwrap() > 0.2);
    assert!(trouble(here, &["evaluate", "scene", "--hold-out", "nobody"]).contains("nobody"));

    // Without truth to compare with, the way out is named.
    std::fs::remove_dir_all(here.join("scene/novel")).unwrap();
    let output = overlook(here, &["evaluate", "scene"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("--hold-out"));
}

#[test]
fn a_store_of_a_capture_with_fractional_times_takes_frames_by_their_number_alone() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    success(
        here,
        &["demo", "orrery", "--out", "scene", "--cameras", "1", "--frames", "3", "--size", "16x16"],
    );
    let read = |name: &str| -> Value {
        serde_json::from_str(&std::fs::read_to_string(here.join(name)).unwrap()).unwrap()
    };
    let mut manifest = read("scene/transforms.json");
    for entry in manifest["frames"].as_array_mut().unwrap() {
        entry["time"] = (entry["time"].as_f64().unwrap() / 2.0).into();
    }
    std::fs::write(here.join("scene/transforms.json"), manifest.to_string()).unwrap();
    success(here, &["preprocess", "scene", "--out", "scene.ovl"]);
    let mut views = read("scene/novel/transforms.json");
    let mut last = views["frames"][0].clone();
    last["time"] = 1.into();
    views["frames"] = serde_json::json!([last]);
    std::fs::write(here.join("views.json"), views.to_string()).unwrap();
    for command in [
        &["render", "scene.ovl", "--views", "views.json", "--out", "pictures"][..],
        &["export", "pictures", "scene.ovl", "--path", "views.json", "--out", "pictures"],
    ] {
        let line = trouble(here, command);
        assert!(line.contains("time 1 names no frame") && line.contains("\"frame\""), "{line}");
        assert!(!here.join("pictures").exists());
    }
    let entry = views["frames"][0].as_object_mut().unwrap();
    entry.remove("time");
    entry.insert("frame".to_owned(), 2.into());
    std::fs::write(here.join("views.json"), views.to_string()).unwrap();
    success(here, &["render", "scene.ovl", "--views", "views.json", "--out", "pictures"]);
}

#[test]
fn a_view_that_would_leave_the_output_folder_is_refused_before_anything_is_painted() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    success(
        here,
        &["demo", "orrery", "--out", "scene", "--cameras", "1", "--frames", "1", "--size", "16x16"],
    );
    success(here, &["preprocess", "scene", "--out", "scene.ovl"]);
    let manifest = std::fs::read_to_string(here.join("scene/novel/transforms.json")).unwrap();
    let mut manifest: Value = serde_json::from_str(&manifest).unwrap();
    manifest["frames"][1]["file_path"] = "../../escaped.exr".into();
    std::fs::write(here.join("views.json"), manifest.to_string()).unwrap();
    let line = trouble(here, &["render", "scene.ovl", "--views", "views.json", "--out", "pictures"]);
    assert!(line.contains("escaped"), "{line}");
    assert!(!here.join("pictures").exists());

    manifest["frames"][1]["file_path"] = "a/b.exr".into();
    manifest["frames"][1]["time"] = 77.into();
    std::fs::write(here.join("views.json"), manifest.to_string()).unwrap();
    let line = trouble(here, &["render", "scene.ovl", "--views", "views.json", "--out", "pictures"]);
    assert!(line.contains("a/b.exr") && line.contains("77"), "{line}");
    assert!(!here.join("pictures").exists(), "it is told before anything is painted");
    let line = trouble(here, &["evaluate", "scene.ovl"]);
    assert!(line.contains("is a store; name the capture that it was made from"), "{line}");
    let line = trouble(here, &["render", "scene", "--views", "views.json", "--out", "pictures"]);
    assert!(line.contains("overlook preprocess scene --out scene.ovl"), "{line}");

    // Nor is the truth painted over.
    let truth = here.join("scene/novel").join(manifest["frames"][0]["file_path"].as_str().unwrap());
    let before = std::fs::read(&truth).unwrap();
    let views = "scene/novel/transforms.json";
    let line = trouble(here, &["render", "scene.ovl", "--views", views, "--out", "scene/novel"]);
    assert!(line.contains("written over") && line.contains("--out"), "{line}");
    assert!(std::fs::read(&truth).unwrap() == before && !truth.with_extension("png").exists());
    let line = trouble(here, &["export", "points", "scene.ovl", "--static", "--out", "./scene.ovl"]);
    assert!(line.contains("is what is read"), "{line}");
}

#[test]
fn no_command_writes_over_the_capture_that_it_reads() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    success(
        here,
        &["demo", "orrery", "--out", "scene", "--cameras", "2", "--frames", "1", "--size", "16x16"],
    );
    std::fs::write(here.join("kept.ovl"), b"FORM a store, by its first bytes").unwrap();
    let info = json(here, &["info", "scene", "--json"]);
    let picture = format!("scene/{}/0000.exr", info["cameras"][1]["name"].as_str().unwrap());
    let held_out = info["cameras"][1]["name"].as_str().unwrap();
    let inputs = ["scene/transforms.json", "scene/novel/transforms.json", &picture];
    let before = inputs.map(|name| std::fs::read(here.join(name)).unwrap());
    for input in inputs {
        for arguments in [
            ["preprocess", "scene", "--out", input].as_slice(),
            &["preprocess", "scene", "--hold-out", held_out, "--out", input],
            &["tune", "scene", "--out", input],
        ] {
            assert!(trouble(here, arguments).contains("is what is read; name another file with --out"));
        }
    }
    assert_eq!(before, inputs.map(|name| std::fs::read(here.join(name)).unwrap()));
    let line = trouble(here, &["tune", "scene", "--out", "kept.ovl"]);
    assert!(line.contains("is a store") && line.contains("--out"), "{line}");
}

#[test]
fn a_demo_is_recorded_anew_over_its_own_scene_and_never_over_another_capture() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let demo = |scene: &str, size: [&'static str; 6]| {
        [&["demo", scene, "--out", "scene"], &size[..]].concat().join(" ")
    };
    let small = ["--cameras", "7", "--frames", "2", "--size", "16x12"];
    let smaller = ["--cameras", "2", "--frames", "1", "--size", "12x16"];
    for size in [small, smaller, small] {
        let arguments = demo("orrery", size);
        success(here, &arguments.split(' ').collect::<Vec<_>>());
    }
    let manifest = here.join("scene/transforms.json");
    let ours = std::fs::read_to_string(&manifest).unwrap();
    let arguments = demo("four-cameras", small);
    let line = trouble(here, &arguments.split(' ').collect::<Vec<_>>());
    assert!(line.contains("is not of the scene 'four-cameras'") && line.contains("--out"), "{line}");

    // The same names elsewhere are another capture, as is what nobody can read.
    let mut moved: Value = serde_json::from_str(&ours).unwrap();
    moved["frames"][1]["transform_matrix"][0][3] = 7.5.into();
    for text in [moved.to_string(), "{}".to_owned()] {
        std::fs::write(&manifest, &text).unwrap();
        let arguments = demo("orrery", small);
        let line = trouble(here, &arguments.split(' ').collect::<Vec<_>>());
        assert!(line.contains("transforms.json: is not of the scene 'orrery'"), "{line}");
        assert_eq!(std::fs::read_to_string(&manifest).unwrap(), text);
    }
}
