//! `overlook export figure`: pictures for print, and orthographic pictures, whose lengths can be read off.

use std::path::Path;
use std::process::Output;

use overlook_engine::capture::transforms;
use overlook_engine::job::Job;
use overlook_engine::store::file;

use crate::builder::{moving_set, small_report};
use crate::command::{overlook, scene, succeed};

fn figure(folder: &Path, arguments: &[&str]) -> Output {
    overlook(folder, &[&["export", "figure"], arguments].concat()).output().unwrap()
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// A folder with a small capture and its store.
fn stored() -> tempfile::TempDir {
    let folder = scene("2", "48x36");
    succeed(overlook(folder.path(), &["preprocess", "scene", "--out", "scene.ovl"]));
    folder
}

#[test]
fn a_figure_has_its_size_its_words_and_its_resolution_in_every_format() {
    let folder = stored();
    let here = folder.path();
    let caption = ["--caption", "What the first camera keeps.", "--width", "60mm", "--dpi", "254"];
    for out in ["a.png", "a.svg", "a.pdf"] {
        let arguments = [&["scene", "--overlay", "kept-by", "--out", out], &caption[..]].concat();
        let output = figure(here, &arguments);
        assert!(output.status.success(), "{}", said(&output));
    }
    let png = std::fs::read(here.join("a.png")).unwrap();
    assert_eq!(image::load_from_memory(&png).unwrap().width(), 600);
    // 10,000 pixels a meter, as the chunk pHYs says them.
    let resolution = png.windows(4).position(|name| name == b"pHYs").unwrap();
    assert_eq!(png[resolution + 4..resolution + 8], 10_000_u32.to_be_bytes());
    let svg = std::fs::read_to_string(here.join("a.svg")).unwrap();
    assert!(svg.contains("width=\"60.000mm\"") && svg.contains("data:image/png;base64,"));
    for words in ["What the first camera keeps.", "kept ", " m, at "] {
        assert!(svg.contains(words), "{words}");
    }
    let pdf = std::fs::read(here.join("a.pdf")).unwrap();
    let holds = |text: &str| pdf.windows(text.len()).any(|part| part == text.as_bytes());
    assert!(pdf.starts_with(b"%PDF-1.7") && holds("/MediaBox [0 0 170.0") && holds("/FontFile2"));
}

#[test]
fn a_view_of_a_store_is_drawn_at_the_size_of_the_figure_and_an_orthographic_one_is_to_scale() {
    let folder = stored();
    let here = folder.path();
    let view =
        ["scene.ovl#frame=0", "--width", "640px", "--theme", "dark", "--unit", "cm", "--out", "view.svg"];
    let out = figure(here, &view);
    assert!(out.status.success(), "{}", said(&out));
    let svg = std::fs::read_to_string(here.join("view.svg")).unwrap();
    assert!(svg.contains("viewBox=\"0 0 640 ") && svg.contains(" cm, at ") && svg.contains("#171b21"));
    let out = figure(here, &["scene.ovl", "--orthographic", "8", "--width", "400px", "--out", "plan.svg"]);
    assert!(out.status.success(), "{}", said(&out));
    let svg = std::fs::read_to_string(here.join("plan.svg")).unwrap();
    assert!(svg.contains(">2 m</text>") && !svg.contains(", at "), "a quarter of 8 m, at any distance");
    // 2 of 8 units are a quarter of 400 pixels.
    let is_bar = |line: &&str| line.starts_with("<path") && line.contains("stroke=\"#ffffff\"");
    let bar = svg.lines().find(is_bar).unwrap();
    let numbers: Vec<f64> = bar
        .split(|letter: char| !(letter.is_ascii_digit() || letter == '.'))
        .filter_map(|number| number.parse().ok())
        .collect();
    assert!((numbers[2] - numbers[0] - 100.0).abs() < 0.2, "{bar}");
}

#[test]
fn orthographic_pictures_and_films_have_depths_from_the_viewpoint() {
    let folder = stored();
    let here = folder.path();
    let views = "scene/novel/transforms.json";
    let render = ["render", "scene.ovl", "--views", views, "--backend", "cpu", "--out"];
    succeed(overlook(here, &[&render[..], &["near"]].concat()));
    succeed(overlook(here, &[&render[..], &["flat", "--orthographic", "6"]].concat()));
    let view = transforms::open_views_of(&here.join(views), false).unwrap().remove(0);
    let depths = |folder: &str| -> Vec<f32> {
        let path = here.join(folder).join(&view.file_path).with_extension("exr");
        let read = exr::prelude::read_first_flat_layer_from_file(path).unwrap();
        let depth = read.layer_data.channel_data.list.iter().find(|channel| channel.name == *"Z");
        let values = depth.unwrap().sample_data.values_as_f32();
        let mut finite: Vec<f32> =
            values.filter(|depth| depth.is_finite() && *depth > 0.0 && *depth < 1e5).collect();
        finite.sort_by(f32::total_cmp);
        finite
    };
    let [near, flat] = ["near", "flat"].map(depths);
    let middle = |depths: &[f32]| depths[depths.len() / 2];
    assert!(middle(&flat) > 0.4 * middle(&near) && middle(&flat) < 2.5 * middle(&near));
    let film = ["export", "pictures", "scene.ovl", "--path", views, "--frame", "0", "--backend", "cpu"];
    succeed(overlook(here, &[&film[..], &["--orthographic", "6", "--out", "film"]].concat()));
    assert!(std::fs::read_dir(here.join("film")).unwrap().count() >= 2);
}

#[test]
fn what_cannot_be_a_figure_is_refused_in_one_line_and_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    file::write(&here.join("scene.ovl"), &moving_set(), &small_report(), &Job::new()).unwrap();
    let whole = std::fs::read(here.join("scene.ovl")).unwrap();
    std::fs::write(here.join("cut.ovl"), &whole[..whole.len() / 2]).unwrap();
    for (scene, arguments, code, why) in [
        ("cut.ovl", ["--out", "a.pdf"].as_slice(), 1, "copy it again"),
        ("missing.ovl", &["--out", "a.pdf"], 1, "no such file"),
        ("missing", &["--out", "a.pdf"], 1, "missing"),
        ("scene.ovl", &["--out", "a.jpg"], 1, "name it .pdf, .svg or .png"),
        ("scene.ovl", &["--out", "nowhere/a.pdf"], 1, "does not exist"),
        ("scene.ovl", &["--frame", "77", "--out", "a.pdf"], 1, "no frame 77"),
        ("scene.ovl", &["--camera", "nobody", "--out", "a.pdf"], 1, "no camera 'nobody'"),
        ("scene.ovl", &["--overlay", "depth", "--out", "a.pdf"], 1, "holds no recorded pictures"),
        ("scene.ovl", &["--width", "120", "--out", "a.pdf"], 2, "with its unit"),
        ("scene.ovl", &["--orthographic", "0", "--out", "a.pdf"], 2, "above 0"),
        ("scene.ovl", &["--dpi", "5", "--out", "a.pdf"], 2, "30..=2400"),
    ] {
        let output = figure(here, &[&[scene], arguments].concat());
        let told = said(&output);
        assert_eq!(output.status.code(), Some(code), "{scene} {arguments:?}: {told}");
        assert!(told.contains(why) && (code == 2 || told.trim().lines().count() == 1), "{told}");
    }
    let mut left: Vec<_> = std::fs::read_dir(here).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    left.sort();
    assert_eq!(left, ["cut.ovl", "scene.ovl"]);
}
