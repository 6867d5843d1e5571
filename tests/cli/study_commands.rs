//! `overlook sweep`, `stress` and `tune` as a user calls them: the files they leave, how they go on, and what they refuse.

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::command::{overlook, scene};
use crate::said::{fail, succeed};
use serde_json::Value;

fn json(path: &Path) -> Value {
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

fn json_of(text: &str) -> Value {
    serde_json::from_str(text).unwrap()
}

fn is_picture(path: &Path) {
    let picture = image::open(path).unwrap();
    assert!(picture.width() > 400 && picture.height() > 300);
}

/// Every point of a document has what scripts may rely on.
fn has_promised_keys(document: &Value) {
    let points = document["points"].as_array().unwrap();
    assert!(!points.is_empty());
    for point in points {
        assert!(point["label"].as_str().is_some_and(|label| !label.is_empty()), "{point}");
        assert!(point["settings"]["pruning"]["depth_tolerance"].is_number(), "{point}");
        for key in ["psnr_db", "psnr_db_se", "ssim", "coverage", "milliseconds"] {
            assert!(point[key].as_f64().is_some_and(f64::is_finite), "{key} of {point}");
        }
        for key in ["samples", "bytes"] {
            assert!(point[key].as_u64().is_some_and(|count| count > 0), "{key} of {point}");
        }
        assert!(point["pareto"].is_boolean(), "{point}");
    }
}

const SWEEP: [&str; 7] =
    ["sweep", "scene", "--vary", "pruning.depth_tolerance=0.5,2", "--kernel", "block", "--out"];

#[test]
fn a_sweep_leaves_a_table_a_document_and_a_chart_and_goes_on_from_its_journal() {
    let folder = scene("2", "48x36");
    let folder = folder.path();
    let table = succeed(folder, &[&SWEEP[..], &["sweep"]].concat());
    let document = json(&folder.join("sweep/sweep.json"));
    assert_eq!(document["truth"], "the capture's own views; 2 frames");
    let points = document["points"].as_array().unwrap();
    let labels: Vec<&str> = points.iter().map(|point| point["label"].as_str().unwrap()).collect();
    for label in ["default", "pruning.depth_tolerance = 0.5", "random, as many samples, block"] {
        assert!(labels.contains(&label) && table.contains(label), "{label} is not among {labels:?}");
    }
    let csv = std::fs::read_to_string(folder.join("sweep/sweep.csv")).unwrap();
    assert_eq!(csv.lines().count(), points.len() + 1);
    assert!(csv.lines().next().unwrap().contains("settings.pruning.depth_tolerance"));
    is_picture(&folder.join("sweep/pareto.png"));
    let drawn = std::fs::read(folder.join("sweep/pareto.svg")).unwrap();
    let drawn = resvg::usvg::Tree::from_data(&drawn, &resvg::usvg::Options::default()).unwrap();
    assert!(drawn.root().has_children(), "a chart for print");
    let rivals =
        ["triangle mesh per camera", "TSDF volume, voxels of 2 px", "nearest camera", "layered depth image"];
    assert!(rivals.iter().all(|rival| labels.contains(rival)), "{labels:?}");
    let page = std::fs::read_to_string(folder.join("sweep/report.html")).unwrap();
    assert!(page.contains("<svg") && page.contains("data:image/png;base64") && !page.contains("<script"));

    // A journal that lost its last line measures that point again and nothing else: times of the others stay what they were.
    let journal = folder.join("sweep/sweep.journal");
    let text = std::fs::read_to_string(&journal).unwrap();
    let kept: Vec<&str> = text.lines().collect();
    std::fs::write(&journal, kept[..kept.len() - 1].join("\n") + "\n").unwrap();
    let printed = succeed(folder, &[&SWEEP[..], &["sweep", "--json"]].concat());
    let printed: Value = serde_json::from_str(&printed).unwrap();
    assert_eq!(printed, json(&folder.join("sweep/sweep.json")), "one document, the one in the file");
    has_promised_keys(&printed);
    assert!(points.iter().any(|point| point["pareto"] == true), "something is on the front");
    let times = |document: &Value| -> Vec<Value> {
        document["points"]
            .as_array()
            .unwrap()
            .iter()
            .map(|point| point["seconds_preprocess"].clone())
            .collect()
    };
    let (before, after) = (times(&document), times(&json(&folder.join("sweep/sweep.json"))));
    let changed = before.iter().zip(&after).filter(|(before, after)| before != after).count();
    assert_eq!((before.len(), after.len()), (points.len(), points.len()));
    assert!(changed <= 1, "{changed} points were measured again");
}

#[test]
fn a_budget_stops_a_study_with_what_is_known_and_the_same_command_goes_on() {
    let folder = scene("1", "32x24");
    let folder = folder.path();
    for (command, name) in [
        (["sweep", "scene", "--set", "render.kernel=block"], "sweep"),
        (["stress", "scene", "--only", "exposure"], "stress"),
    ] {
        let lines = || {
            let csv = std::fs::read_to_string(folder.join(format!("{name}/{name}.csv"))).unwrap();
            csv.lines().count() - 1
        };
        for known in 1..3 {
            let arguments = [&command[..], &["--budget", "0", "--out", name]].concat();
            let output = overlook(folder, &arguments).output().unwrap();
            let said = String::from_utf8_lossy(&output.stderr);
            assert!(output.status.success() && said.contains("the budget is spent with "), "{said}");
            assert_eq!(lines(), known, "{name}");
        }
    }
    let refused = fail(folder, &["stress", "scene", "--budget", "3 days", "--out", "stress"], 2);
    assert!(refused.contains("3min"), "{refused}");
    succeed(folder, &["stress", "scene", "--only", "exposure", "--budget", "1h", "--out", "stress"]);
    let document = json(&folder.join("stress/stress.json"));
    let dials: Vec<f64> =
        document["points"].as_array().unwrap().iter().map(|point| point["dial"].as_f64().unwrap()).collect();
    assert!(dials.is_sorted() && dials.len() > 20, "{dials:?}");
}

#[test]
fn a_report_puts_captures_on_one_page_and_other_programs_figures_and_pictures_are_taken_in() {
    let folder = scene("2", "48x36");
    let folder = folder.path();
    std::fs::create_dir(folder.join("empty")).unwrap();
    let refused = fail(folder, &["report", "empty"], 1);
    assert!(refused.contains("overlook sweep") && refused.trim().lines().count() == 1, "{refused}");
    let sweep = ["sweep", "scene", "--frames", "1", "--vary", "render.kernel=block", "--out"];
    let refused = fail(folder, &[&sweep[..], &["one", "--rival", "RVS=26"]].concat(), 2);
    assert!(refused.contains("name=dB,ms,bytes"), "{refused}");
    succeed(folder, &[&sweep[..], &["one", "--rival", "RVS=26.5,301,5200000"]].concat());
    succeed(folder, &[&sweep[..], &["two"]].concat());
    succeed(folder, &["report", "one", "two", "--out", "both.html"]);
    let page = std::fs::read_to_string(folder.join("both.html")).unwrap();
    for wanted in ["All 2 captures together", "RVS", "26.50", "--frames 1"] {
        assert!(page.contains(wanted), "{wanted}");
    }
    let evaluate = ["evaluate", "scene", "--json", "--pictures"];
    let pictures =
        json_of(&succeed(folder, &[&evaluate[..], &["scene/novel", "--error-maps", "maps"]].concat()));
    let own = &pictures["pictures"][0];
    assert_eq!(own["name"], "novel");
    assert_eq!(
        [&own["flip"], &own["flicker_steps"]].map(Value::as_f64),
        [Some(0.0); 2],
        "the truth is perfect"
    );
    let classes = &pictures["mean"]["error_by_class"];
    let share: f64 =
        ["unseen", "edge", "inner"].iter().map(|class| classes[class]["of_error"].as_f64().unwrap()).sum();
    assert!((share - 1.0).abs() < 1e-9, "{classes}");
    assert!(folder.join("maps/novel").is_dir());
    let refused = fail(folder, &[&evaluate[..], &["empty"]].concat(), 1);
    assert!(refused.contains("has no picture of view"), "{refused}");
}

#[test]
fn stress_names_the_point_of_failure_of_every_method() {
    let folder = scene("2", "48x36");
    let folder = folder.path();
    let stress = "stress|scene|--only|camera pose|--frames|1|--set|render.kernel=block|--out|stress";
    let stress: Vec<&str> = stress.split('|').collect();
    let printed = succeed(folder, &[&stress[..], &["--json"]].concat());
    let printed: Value = serde_json::from_str(&printed).unwrap();
    let document = json(&folder.join("stress/stress.json"));
    assert_eq!(printed, document, "one document, the one in the file");
    has_promised_keys(&printed);
    let journal = std::fs::read_to_string(folder.join("stress/stress.journal")).unwrap();
    // Everything is known by now, so that nothing is measured for the table.
    let table = succeed(folder, &stress);
    assert!(table.contains("camera pose, degrees"), "{table}");
    assert_eq!(std::fs::read_to_string(folder.join("stress/stress.journal")).unwrap(), journal);
    assert_eq!(json(&folder.join("stress/stress.json")), document);
    let failures = document["failures"].as_array().unwrap();
    assert_eq!(failures.len(), 7, "ours, without defenses, the paper's, and four of others");
    let breaking = document["breaking"].as_array().unwrap();
    assert_eq!(breaking.len(), 1, "one picture for each disturbance");
    assert!(folder.join("stress").join(breaking[0]["file"].as_str().unwrap()).is_file());
    assert!(document["points"].as_array().unwrap().iter().all(|point| point["disturbance"] == "camera pose"));
    is_picture(&folder.join("stress/stress.png"));
    let unknown = fail(folder, &["stress", "scene", "--only", "rain", "--out", "stress"], 2);
    assert!(unknown.contains("camera pose"), "names what there is: {unknown}");
}

#[test]
fn tune_writes_settings_that_preprocess_takes_and_refuses_a_budget_that_cannot_be_kept() {
    let folder = scene("2", "48x36");
    let folder = folder.path();
    let tune = ["tune", "scene", "--frames", "1", "--all-cameras", "--journal", "tuning", "--out"];
    let words = succeed(folder, &[&tune[..], &["tuned.toml"]].concat());
    assert!(words.contains("Chosen: "), "{words}");
    let toml = std::fs::read_to_string(folder.join("tuned.toml")).unwrap();
    assert!(toml.starts_with("# Of "), "the file says why: {toml}");
    let journal = folder.join("tuning/tune.journal");
    let measured = std::fs::read_to_string(&journal).unwrap();
    let again = overlook(folder, &[&tune[..], &["tuned.toml"]].concat()).output().unwrap();
    assert_eq!(String::from_utf8(again.stdout).unwrap(), words);
    assert_eq!(std::fs::read_to_string(&journal).unwrap(), measured, "a journal grows by what is new");
    succeed(folder, &["preprocess", "scene", "--settings", "tuned.toml", "--out", "tuned.ovl"]);
    let refused = fail(folder, &[&tune[..], &["none.toml", "--max-bytes", "10"]].concat(), 1);
    assert!(refused.contains("10 bytes") && !folder.join("none.toml").exists(), "{refused}");
}

#[test]
fn the_fewest_views_are_chosen_with_a_curve_a_chart_and_a_page_and_preprocess_takes_them_alone() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    succeed(
        folder,
        &["demo", "orrery", "--out", "scene", "--cameras", "6", "--frames", "1", "--size", "64x48"],
    );
    let tune = ["tune", "scene", "--fewest-views", "views", "--show", "90"];
    let table = succeed(folder, &tune);
    assert!(table.contains("shown %") && table.contains(" of 6 show"), "{table}");
    let document = json(&folder.join("views/views.json"));
    let needed = document["needed"].as_u64().unwrap() as usize;
    let shown: Vec<f64> =
        document["order"].as_array().unwrap().iter().map(|view| view["shown"].as_f64().unwrap()).collect();
    assert!((1..6).contains(&needed) && shown.is_sorted() && shown[needed - 1] >= 0.9, "{document}");
    assert!(needed == 1 || shown[needed - 2] < 0.9, "not one too many: {shown:?}");
    let counts: Vec<u64> = document["accuracy"]
        .as_array()
        .unwrap()
        .iter()
        .map(|count| count["views"].as_u64().unwrap())
        .collect();
    assert!(counts.first() == Some(&1) && counts.last() == Some(&6) && counts.is_sorted(), "{counts:?}");
    is_picture(&folder.join("views/views.png"));
    let page = std::fs::read_to_string(folder.join("views/report.html")).unwrap();
    assert!(page.contains("The fewest views") && page.contains("<svg"));
    let printed = json_of(&succeed(folder, &[&tune[..], &["--json"]].concat()));
    assert_eq!(printed, document, "the same every time");
    let names = std::fs::read_to_string(folder.join("views/views.txt")).unwrap();
    assert_eq!(names.lines().count(), needed);
    succeed(folder, &["preprocess", "scene", "--only", "views/views.txt", "--out", "few.ovl"]);
    let info = json_of(&succeed(folder, &["info", "few.ovl", "--json"]));
    assert_eq!(info["cameras"].as_array().map(Vec::len), Some(needed), "{info}");
    std::fs::write(folder.join("other.txt"), "nobody\n").unwrap();
    let refused = fail(folder, &["preprocess", "scene", "--only", "other.txt", "--out", "none.ovl"], 1);
    assert!(refused.contains("other.txt") && refused.contains("nobody"), "{refused}");
    fail(folder, &["tune", "scene", "--show", "90", "--out", "tuned.toml"], 2);
}

#[test]
fn what_tune_found_is_told_even_where_its_folder_went_away_meanwhile() {
    let folder = scene("2", "48x36");
    let folder = folder.path();
    std::fs::create_dir(folder.join("gone")).unwrap();
    let tune = ["tune", "scene", "--frames", "1", "--all-cameras", "--journal", "tuning", "--out"];
    let child = Command::new(env!("CARGO_BIN_EXE_overlook"))
        .current_dir(folder)
        .args([&tune[..], &["gone/tuned.toml"]].concat())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // The journal is begun after the folder was looked at and before anything is measured.
    let asked = Instant::now();
    while !folder.join("tuning/tune.journal").exists() {
        assert!(asked.elapsed() < Duration::from_mins(1), "nothing happens");
        std::thread::sleep(Duration::from_millis(1));
    }
    std::fs::remove_dir(folder.join("gone")).unwrap();
    let lost = child.wait_with_output().unwrap();
    let [told, said] = [lost.stdout, lost.stderr].map(|bytes| String::from_utf8(bytes).unwrap());
    assert_eq!(lost.status.code(), Some(1), "{said}");
    assert!(told.contains("Chosen: ") && said.contains("gone/tuned.toml"), "{told}{said}");
}

#[test]
fn a_camera_that_alone_sees_the_views_may_go_missing_and_the_rest_of_the_stress_is_measured() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let size = ["--cameras", "1", "--frames", "2", "--size", "48x36"];
    succeed(folder, &[&["demo", "orrery", "--out", "scene"], &size[..]].concat());
    let stress =
        ["stress", "scene", "--only", "missing camera", "--set", "render.kernel=block", "--out", "stress"];
    for run in ["the first", "one that goes on"] {
        let output = overlook(folder, &stress).output().unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        let of_it: Vec<_> = said.lines().filter(|line| line.contains("is left out: ")).collect();
        let [line] = of_it[..] else { panic!("{run}: {said}") };
        assert!(line.contains("warning: 'missing camera' at 100 % of frames is left out"), "{run}: {said}");
        assert!(output.status.success(), "{run}: {said}");
        let document = json(&folder.join("stress/stress.json"));
        has_promised_keys(&document);
        assert_eq!(document["failures"][0]["last_dial"], 50.0, "{run}");
        is_picture(&folder.join("stress/stress.png"));
    }
}

#[test]
fn results_that_cannot_be_written_end_the_run_with_the_place() {
    let folder = scene("2", "48x36");
    let folder = folder.path();
    std::fs::write(folder.join("taken"), "a file").unwrap();
    let said = fail(folder, &[&SWEEP[..], &["taken"]].concat(), 1);
    assert!(said.contains("taken"), "{said}");
    for command in [
        ["sweep", "nowhere", "--out"].as_slice(),
        &["stress", "nowhere", "--out"],
        &["tune", "nowhere", "--out", "t.toml", "--journal"],
    ] {
        let said = fail(folder, &[command, &["taken"]].concat(), 1);
        assert!(said.contains("taken: is a file; name a folder"), "{said}");
    }
    let missing = fail(folder, &["sweep", "nowhere", "--out", "sweep"], 1);
    assert!(missing.contains("nowhere"), "{missing}");
}

#[test]
fn files_of_one_name_are_told_apart_and_one_that_changes_nothing_is_named() {
    let folder = scene("2", "48x36");
    let folder = folder.path();
    for (name, text) in [
        ("a/s.toml", "[pruning]\ndepth_tolerance = 2.0\n"),
        ("b/s.toml", "[pruning]\ndepth_tolerance = 0.5\n"),
        ("same.toml", ""),
    ] {
        std::fs::create_dir_all(folder.join(name).parent().unwrap()).unwrap();
        std::fs::write(folder.join(name), text).unwrap();
    }
    let files =
        ["--with", "a/s.toml", "--with", "b/s.toml", "--with", "same.toml", "--frames", "1", "--json"];
    let output =
        overlook(folder, &[&["sweep", "scene", "--out", "sweep"], &files[..]].concat()).output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(
        said,
        "overlook: warning: 'same' has the same settings as 'default', and gets no row of its own\n"
    );
    let document: Value = serde_json::from_slice(&output.stdout).unwrap();
    let points = document["points"].as_array().unwrap();
    let labels: Vec<_> = points.iter().take(4).map(|point| point["label"].as_str().unwrap()).collect();
    assert_eq!(labels[..3], ["default", "a/s.toml", "b/s.toml"]);
}

#[test]
fn views_without_a_true_picture_are_told_and_absurd_numbers_are_refused_before_anything_is_read() {
    let folder = scene("2", "48x36");
    let folder = folder.path();
    for arguments in [
        ["sweep", "scene", "--out", "x", "--frames", "0"].as_slice(),
        &["tune", "scene", "--out", "x.toml", "--max-bytes", "0"],
        &["tune", "scene", "--out", "x.toml", "--max-ms", "nan"],
        &["tune", "scene", "--out", "x.toml", "--max-ms", "-1"],
    ] {
        let said = fail(folder, arguments, 2);
        let flag = arguments[arguments.len() - 2];
        assert!(
            said.contains(&format!("invalid value '{}' for '{flag}", arguments[arguments.len() - 1])),
            "{said}"
        );
    }
    let noise = fail(folder, &["demo", "orrery", "--out", "x", "--noise", "-1"], 2);
    assert!(noise.contains("-1 noise cannot be recorded"), "{noise}");

    let novel = folder.join("scene/novel");
    let views = json(&novel.join("transforms.json"));
    let first = views["frames"][0]["file_path"].as_str().unwrap();
    std::fs::remove_file(novel.join(first)).unwrap();
    let output = overlook(folder, &["evaluate", "scene", "--kernel", "block"]).output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success() && said.lines().count() == 1, "{said}");
    assert!(said.contains("warning: 1 of 6 views is passed over") && said.contains(first), "{said}");

    // A frame that the capture lacks is told before anything is measured.
    let mut late = views.clone();
    late["frames"][5]["time"] = 77.into();
    std::fs::write(novel.join("late.json"), late.to_string()).unwrap();
    let said = fail(folder, &["evaluate", "scene", "--views", "scene/novel/late.json"], 1);
    assert!(said.contains("there is no frame 77; 'scene' has 2 frames from 0 to 1"), "{said}");
}

#[test]
fn two_runs_that_write_to_one_folder_are_kept_apart_and_what_the_first_measured_stays() {
    let folder = scene("1", "24x16");
    let folder = folder.path();
    let sweep = [&SWEEP[..], &["sweep"]].concat();
    succeed(folder, &sweep);
    let journal = folder.join("sweep/sweep.journal");
    let measured = std::fs::read(&journal).unwrap();
    let other = std::fs::File::open(&journal).unwrap();
    other.lock().unwrap();
    for more in [[].as_slice(), &["--frames", "1", "--cross-validate"]] {
        let said = fail(folder, &[&sweep[..], more].concat(), 1);
        assert!(
            said.contains("sweep.journal: another run is writing here") && said.lines().count() == 1,
            "{said}"
        );
        assert_eq!(std::fs::read(&journal).unwrap(), measured);
    }
    drop(other);
    succeed(folder, &sweep);
    assert_eq!(std::fs::read(&journal).unwrap(), measured);
}

#[test]
fn a_journal_serves_the_same_views_by_any_name_and_no_other_number_of_threads() {
    let folder = scene("1", "24x16");
    let folder = folder.path();
    let sweep = |more: &[&str]| {
        succeed(folder, &[&SWEEP[..], &["sweep", "--threads"], more].concat());
        let text = std::fs::read_to_string(folder.join("sweep/sweep.journal")).unwrap();
        (text, folder.join("sweep/sweep.journal.old").exists())
    };
    let (measured, _) = sweep(&["1"]);
    assert_eq!(sweep(&["1", "--views", "scene/novel/transforms.json"]), (measured.clone(), false));
    let (anew, is_kept) = sweep(&["2"]);
    assert!(is_kept && anew != measured);
}

#[test]
fn a_budget_of_bytes_holds_for_the_store_of_all_frames_whatever_is_looked_at() {
    let folder = scene("3", "32x24");
    let folder = folder.path();
    let preprocessed = |more: &[&str]| {
        succeed(folder, &[&["preprocess", "scene", "--out", "scene.ovl"], more].concat());
        std::fs::metadata(folder.join("scene.ovl")).unwrap().len()
    };
    let budget = (preprocessed(&[]) * 9 / 10).to_string();
    let tune = ["tune", "scene", "--all-cameras", "--out", "tuned.toml", "--max-bytes", &budget];
    let words = succeed(folder, &[&tune[..], &["--frames", "1"]].concat());
    let bytes = preprocessed(&["--settings", "tuned.toml"]);
    assert!(bytes <= budget.parse().unwrap(), "{bytes} of {budget}: {words}");
    assert!(words.contains("The store of the whole capture takes"), "{words}");
}

#[test]
fn a_setting_that_is_varied_twice_is_refused() {
    let folder = scene("1", "24x16");
    let twice = ["--vary", "spans.noise=0.5", "--vary", " spans.noise = 2,4"];
    let said = fail(folder.path(), &[&["sweep", "scene", "--out", "sweep"], &twice[..]].concat(), 2);
    assert!(said.contains("spans.noise: is varied twice") && said.lines().count() == 1, "{said}");
}
