//! `--backend` as a script meets it: what was asked for paints, or one line says why not.
//!
//! Where the machine has no adapter a test says so and passes; with `OVERLOOK_REQUIRE_GPU=1` it fails instead.

use std::path::Path;
use std::process::{Command, Output};

use crate::skip::skip;
use overlook_engine::render::gpu::{AdapterChoice, GpuRenderer};
use serde_json::Value;

fn overlook(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_overlook"));
    command.args(arguments).current_dir(folder).env_remove("RUST_LOG");
    command
}

fn run(mut command: Command) -> Output {
    let output = command.output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    output
}

/// A small store and the views of its truth.
fn store() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let demo = ["demo", "orrery", "--out", "demo", "--cameras", "2", "--frames", "2", "--size", "48x36"];
    run(overlook(here, &demo));
    run(overlook(here, &["preprocess", "demo", "--out", "scene.ovl"]));
    folder
}

fn painting<'a>(backend: &'a str, out: &'a str) -> [&'a str; 11] {
    let views = "demo/novel/transforms.json";
    let kernel = "block";
    [
        "render",
        "scene.ovl",
        "--views",
        views,
        "--out",
        out,
        "--kernel",
        kernel,
        "--backend",
        backend,
        "--json",
    ]
}

fn rendered(folder: &Path, backend: &str) -> Value {
    let output = run(overlook(folder, &painting(backend, backend)));
    serde_json::from_slice(&output.stdout).unwrap()
}

#[test]
fn the_gpu_paints_where_it_is_asked_for_and_says_so() {
    let adapter = match GpuRenderer::new(AdapterChoice::Any) {
        Ok(renderer) => renderer.adapter_name().to_owned(),
        Err(error) => {
            skip(Some("OVERLOOK_REQUIRE_GPU"), &format!("nothing was painted: {error}"));
            return;
        }
    };
    let folder = store();
    let (gpu, cpu) = (rendered(folder.path(), "gpu"), rendered(folder.path(), "cpu"));
    let pairs = gpu["views"].as_array().unwrap().iter().zip(cpu["views"].as_array().unwrap());
    for (gpu, cpu) in pairs {
        assert_eq!((gpu["backend"].as_str(), gpu["adapter"].as_str()), (Some("gpu"), Some(adapter.as_str())));
        assert_eq!((cpu["backend"].as_str(), cpu.get("adapter")), (Some("cpu"), None));
        assert_eq!(gpu["samples"], cpu["samples"]);
        let psnr = [gpu, cpu].map(|view| view["psnr_db"].as_f64().unwrap());
        assert!((psnr[0] - psnr[1]).abs() < 0.05, "{psnr:?}");
    }
    assert!(gpu.get("notice").is_none());
}

/// The Vulkan loader finds the drivers that a variable names, and here it names none.
#[cfg(target_os = "linux")]
#[test]
fn without_an_adapter_the_gpu_is_refused_in_one_line_and_auto_paints_on_the_cpu() {
    let without_drivers = |mut command: Command| {
        command.env("VK_DRIVER_FILES", "/nowhere.json").env("VK_ICD_FILENAMES", "/nowhere.json");
        command
    };
    let folder = store();
    let here = folder.path();
    let output = without_drivers(overlook(here, &painting("gpu", "gpu"))).output().unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{stderr}");
    assert!(stderr.lines().count() == 1 && stderr.contains("no adapter"), "{stderr}");
    let output = run(without_drivers(overlook(here, &painting("auto", "auto"))));
    let document: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(document["views"][0]["backend"], "cpu");
    assert!(output.stderr.is_empty(), "{}", String::from_utf8_lossy(&output.stderr));

    // A sweep from settings that need none must not label the CPU's times with the GPU's name, nor find out last.
    let sweep = ["sweep", "demo", "--backend", "cpu", "--vary", "render.backend=cpu,gpu", "--out", "sweep"];
    let output = without_drivers(overlook(here, &sweep)).output().unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{stderr}");
    assert!(stderr.lines().count() == 1 && stderr.contains("no adapter"), "{stderr}");
    let journal = std::fs::read_to_string(here.join("sweep/sweep.journal")).unwrap();
    assert_eq!(journal.lines().count(), 1, "nothing was measured");
}
