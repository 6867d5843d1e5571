//! `overlook bench` as a script meets it: one JSON document with figures that can be true. How fast anything is, no test says.

use std::collections::BTreeSet;
use std::process::{Command, Output};
use std::time::Instant;

use crate::skip::skip;
use overlook_engine::demo::{Demo, DemoSpec};
use overlook_engine::job::Job;
use overlook_engine::preprocess::inspect_frame;
use overlook_engine::render::gpu::{AdapterChoice, GpuRenderer};
use overlook_engine::settings::{CaptureSettings, Kernel, Settings};
use serde_json::Value;

fn bench(arguments: &[&str]) -> Output {
    bench_with("cpu", arguments)
}

fn bench_with(backend: &str, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_overlook"))
        .args(["bench", "--quick", "--threads", "2", "--backend", backend])
        .args(arguments)
        .env_remove("RUST_LOG")
        .output()
        .unwrap()
}

fn measured(arguments: &[&str]) -> Value {
    let output = bench(arguments);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

fn positive(object: &Value, key: &str) -> f64 {
    let value = object[key].as_f64().unwrap_or_else(|| panic!("no number '{key}' in {object}"));
    assert!(value.is_finite() && value > 0.0, "{key} = {value} in {object}");
    value
}

fn close(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-9 * a.abs().max(b.abs())
}

fn stages(document: &Value) -> &Vec<Value> {
    document["stages"].as_array().unwrap()
}

fn name(stage: &Value) -> &str {
    stage["name"].as_str().unwrap()
}

/// How many samples the stages of a quick run work on, counted here: nine cameras of 160×120 over three frames.
struct Counts {
    recorded: u64,
    pruned: u64,
}

impl Counts {
    const PIXELS: u64 = 160 * 120;
    const ONE_FRAME: u64 = 9 * Self::PIXELS;
    const ALL_FRAMES: u64 = 3 * Self::ONE_FRAME;
    /// Frames of one camera that the temporal split is measured on.
    const SPLIT_FRAMES: u64 = 32;

    fn new() -> Self {
        let size = Some((160, 120));
        let spec =
            DemoSpec { scene: "nine-cameras".into(), cameras: None, frames: Some(3), size, noise: None };
        let capture = Demo::new(&spec).unwrap().capture(&CaptureSettings::default());
        let shown = inspect_frame(&capture, None, &Settings::default(), 0, &Job::new()).unwrap();
        Self { recorded: capture.pixel_count(), pruned: shown.samples.sample_count() }
    }

    /// Samples that a stage works on; `None` for the still vantage, which paints what moves.
    fn of(&self, stage: &str) -> Option<u64> {
        match stage {
            "preprocess/scan" => Some(Self::ALL_FRAMES),
            "preprocess/split" => Some(Self::SPLIT_FRAMES * Self::PIXELS),
            // Twenty-four views of half as many columns and rows.
            "preprocess/prune-views" => Some(24 * Self::PIXELS / 4),
            "store/decode-foreground" => Some(Self::ONE_FRAME),
            still if still.contains("/still-vantage/") => None,
            picture if picture.starts_with("picture/") => None,
            of_pruned if of_pruned.starts_with("store/") || of_pruned.contains("/pruned/") => {
                Some(self.pruned)
            }
            _ => Some(Self::ONE_FRAME),
        }
    }
}

#[test]
fn every_stage_is_measured_with_one_thread_and_with_all_and_held_against_a_limit() {
    let started = Instant::now();
    let document = measured(&["--json"]);
    let elapsed_ms = started.elapsed().as_secs_f64() * 1e3;
    let counts = Counts::new();
    assert_eq!(counts.recorded, Counts::ALL_FRAMES);
    assert_eq!(document["samples_pruned"], counts.pruned);
    assert_eq!(document["version"], env!("CARGO_PKG_VERSION"));
    assert_eq!(document["samples"], 9 * 160 * 120);
    assert!(document["machine"]["threads_available"].as_u64().unwrap() >= 1);

    let limits = document["limits"].as_array().unwrap();
    let threads: Vec<_> = limits.iter().map(|limit| limit["threads"].as_u64().unwrap()).collect();
    assert_eq!(threads, [1, 2]);
    for limit in limits {
        positive(limit, "read_gb_per_s");
        positive(limit, "scatter_mpts_per_s");
        assert!(limit["gpu_copy_gb_per_s"].is_null());
    }

    let (mut met, mut busy_ms) = (BTreeSet::new(), 0.0);
    for stage in stages(&document) {
        let threads = stage["threads"].as_u64().unwrap();
        assert!(met.insert((name(stage), threads)), "{} with {threads} threads twice", name(stage));
        let (median_ms, rate) = (positive(stage, "median_ms"), positive(stage, "mpts_per_s"));
        assert!(stage["spread_ms"].as_f64().unwrap() >= 0.0 && stage["repeats"].as_u64().unwrap() >= 2);
        if let Some(samples) = counts.of(name(stage)) {
            assert!(close(rate, samples as f64 / (median_ms * 1e-3) * 1e-6), "of {samples} samples: {stage}");
        }
        // Half of the repeats take the median or longer.
        busy_ms += median_ms * (positive(stage, "repeats") / 2.0).ceil();
        let limit = limits.iter().find(|limit| limit["threads"] == threads).unwrap();
        let (reached, limit) = match stage["limit"].as_str().unwrap() {
            "scatter" => (rate, &limit["scatter_mpts_per_s"]),
            "read" => (positive(stage, "bytes") / median_ms / 1e6, &limit["read_gb_per_s"]),
            other => panic!("there is no limit '{other}'"),
        };
        assert!(close(positive(stage, "fraction_of_limit"), reached / limit.as_f64().unwrap()), "{stage}");
    }
    // By the clock of the test: a quarter of the time in a development build, the rest being the scene, repeats before the first that
    // counts and the machine's limits. A tenth of that is asked for, so that a wrong unit shows and a busy machine does not.
    assert!((0.025..1.0).contains(&(busy_ms / elapsed_ms)), "{busy_ms} of {elapsed_ms} ms");
    let with = |threads| met.iter().filter(move |(_, found)| *found == threads).map(|(name, _)| *name);
    assert!(with(1).eq(with(2)), "one thread and all");
    for part in ["preprocess/scan", "preprocess/normals/plane", "preprocess/re-prune-frame", "store/read"] {
        assert!(with(1).any(|name| name == part), "{part}");
    }
    for motion in ["rest", "orbit", "play", "play-and-orbit"] {
        for scene in ["nine-cameras", "orrery-no-sky"] {
            let named = format!("picture/{motion}/{scene}/160x120");
            assert!(with(1).any(|name| name == named), "{named}");
        }
    }
    for kernel in Kernel::ALL {
        for set in ["unpruned/160x120", "unpruned/320x180", "pruned/160x120", "still-vantage/320x180"] {
            assert!(with(1).any(|name| name == format!("render/{kernel}/{set}")), "{kernel} {set}");
        }
    }
}

#[test]
fn painting_says_what_it_painted_and_a_still_vantage_keeps_its_background() {
    let document = measured(&["--json", "--only", "render/block"]);
    assert!(stages(&document).iter().all(|stage| name(stage).starts_with("render/block/")));
    for stage in stages(&document) {
        assert_eq!(stage["backend"], "cpu");
        assert_eq!(stage["kernel"], "block");
        let size = format!("{}x{}", stage["width"], stage["height"]);
        assert!(name(stage).ends_with(&size), "{stage}");
        assert!((0.9..=1.0).contains(&positive(stage, "coverage")), "{stage}");
        assert!((6.0..32.0).contains(&positive(stage, "bytes_per_sample")), "{stage}");
        let still = name(stage).contains("still-vantage");
        assert_eq!(stage["background_reused"], still, "{stage}");
        assert_eq!(stage.get("speedup_over_full_repaint").is_some(), still);
        let share = positive(stage, "samples") / document["samples"].as_f64().unwrap();
        if still {
            positive(stage, "speedup_over_full_repaint");
            assert!((0.05..0.2).contains(&share), "{share} of the samples change");
        } else if !name(stage).contains("/pruned/") {
            assert_eq!(share, 1.0, "{stage}");
        }
    }
}

#[test]
fn the_table_shows_what_was_asked_for() {
    let output = bench(&["--only", "normals/cross", "--only", "preprocess/pack"]);
    let text = String::from_utf8(output.stdout).unwrap();
    let lines = |part: &str| text.lines().filter(|line| line.contains(part)).count();
    assert_eq!((lines("preprocess/normals/cross"), lines("preprocess/pack")), (2, 2), "{text}");
    assert_eq!((lines("plane"), lines("render/")), (0, 0), "{text}");
}

#[test]
fn a_stage_that_does_not_exist_is_named_beside_those_that_do() {
    let output = bench(&["--only", "teapot", "--json"]);
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1));
    assert!(output.stdout.is_empty());
    assert!(
        stderr.lines().count() == 1 && stderr.contains("teapot") && stderr.contains("store/write"),
        "{stderr}"
    );
}

#[test]
fn a_graphics_adapter_is_measured_where_it_is_asked_for_and_held_against_its_memory() {
    if let Err(error) = GpuRenderer::new(AdapterChoice::Any) {
        skip(Some("OVERLOOK_REQUIRE_GPU"), &format!("nothing was measured: {error}"));
        return;
    }
    let output = bench_with("gpu", &["--only", "gpu/point/pruned/160x120", "--json"]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let document: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(stages(&document).len(), 2, "one thread and all: {document}");
    for stage in stages(&document) {
        assert_eq!(
            (name(stage), &stage["backend"]),
            ("render/gpu/point/pruned/160x120", &Value::from("gpu"))
        );
        let limits = document["limits"].as_array().unwrap();
        let limit = limits.iter().find(|limit| limit["threads"] == stage["threads"]).unwrap();
        let gb_per_s = positive(stage, "mpts_per_s") * positive(stage, "bytes_per_sample") * 1e-3;
        assert_eq!(stage["limit"], "copy");
        assert!(close(positive(stage, "fraction_of_limit"), gb_per_s / positive(limit, "gpu_copy_gb_per_s")));
        assert!(stage["coverage"].as_f64().unwrap() > 0.5);
    }
}

#[test]
fn narrower_instructions_are_used_where_they_are_asked_for() {
    let document =
        measured(&["--only", "render/point/pruned/160x120", "--instructions", "portable", "--json"]);
    assert_eq!(document["machine"]["instructions"], "portable");
    let output = bench(&["--instructions", "mmx"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("avx2"));
}
