//! Scalar values on the command line: colors by value, with their scalar bar, in all that is written; edits by value.

use std::collections::HashSet;
use std::path::Path;
use std::process::Output;

use glam::DVec2;
use overlook_engine::capture::exr::ExrFile;
use overlook_engine::capture::pictures::parse_npy;
use overlook_engine::capture::{open, transforms};
use overlook_engine::render::{BACKGROUND_COLOR, ValueColors};
use overlook_engine::settings::{CaptureSettings, Colormap, ValueScale};
use serde_json::{Value, json};

use crate::command::{overlook, scene, succeed};
use crate::page_reader;

const SIZE: (usize, usize) = (64, 48);
const RANGE: [f32; 2] = [0.0, 2.0];

/// A folder with a small capture whose pixels have the height of their points as a value, and half of it by another name of the same
/// file; its store; and a path of two views at two frames.
fn stored() -> tempfile::TempDir {
    let folder = scene("2", "64x48");
    let here = folder.path().join("scene");
    let capture = open(&here.join("transforms.json"), &CaptureSettings::default()).unwrap();
    let mut manifest: Value =
        serde_json::from_slice(&std::fs::read(here.join("transforms.json")).unwrap()).unwrap();
    for entry in manifest["frames"].as_array_mut().unwrap() {
        let named = |camera: &overlook_engine::capture::Camera| camera.name == entry["camera"];
        let camera = capture.cameras.iter().position(named).unwrap();
        let number = entry["time"].as_f64().unwrap() as i64;
        let frame = capture.frame(camera, capture.frame_numbers.binary_search(&number).unwrap()).unwrap();
        let height = |(pixel, inverse): (usize, &f32)| {
            let center = DVec2::new((pixel % SIZE.0) as f64 + 0.5, (pixel / SIZE.0) as f64 + 0.5);
            let point = capture.cameras[camera].unproject(center, 1.0 / f64::from(*inverse));
            if *inverse > 0.0 { point.z as f32 } else { f32::NAN }
        };
        let heights: Vec<f32> = frame.inverse_depth.as_slice().iter().enumerate().map(height).collect();
        let file = |factor: f32, name: &str| {
            let mut header =
                format!("{{'descr': '<f4', 'fortran_order': False, 'shape': ({}, {}), }}", SIZE.1, SIZE.0);
            header.extend(std::iter::repeat_n(' ', 117 - header.len()));
            let mut bytes = [b"\x93NUMPY\x01\x00\x76\x00", header.as_bytes(), b"\n"].concat();
            bytes.extend(heights.iter().flat_map(|height| (factor * height).to_le_bytes()));
            let path = format!("{camera}_{number}_{name}.npy");
            std::fs::write(here.join(&path), bytes).unwrap();
            path
        };
        entry["value_file_paths"] = json!({"z/m": file(1.0, "whole"), "z:m": file(0.5, "half")});
    }
    manifest["values"] = json!([{"name": "z/m", "unit": "m", "range": RANGE}, {"name": "z:m"}]);
    std::fs::write(here.join("transforms.json"), manifest.to_string()).unwrap();
    succeed(overlook(folder.path(), &["preprocess", "scene", "--out", "scene.ovl"]));
    let views = std::fs::read(here.join("novel/transforms.json")).unwrap();
    let mut views: Value = serde_json::from_slice(&views).unwrap();
    let first = views["frames"][0].clone();
    views["frames"] = json!([first.clone(), first]);
    let frames = views["frames"].as_array_mut().unwrap();
    for (number, view) in capture.frame_numbers.iter().zip(frames) {
        view["time"] = json!(number);
    }
    std::fs::write(folder.path().join("path.json"), views.to_string()).unwrap();
    folder
}

fn run(folder: &Path, arguments: &[&str]) -> Output {
    let output = overlook(folder, arguments).output().unwrap();
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    output
}

fn array(path: &Path) -> Vec<f32> {
    let read = parse_npy(&std::fs::read(path).unwrap(), "array").unwrap();
    assert_eq!(read.size, SIZE);
    read.values
}

fn picture(path: &Path) -> image::RgbaImage {
    image::open(path).unwrap().to_rgba8()
}

fn colors(range: [f32; 2]) -> ValueColors {
    ValueColors::new(Colormap::Viridis, ValueScale::Linear, range).unwrap()
}

/// Pixels of the picture, without what lies below it, that have the colors of these values.
fn colored_like(picture: &image::RgbaImage, values: &[f32], colors: &ValueColors) -> usize {
    let pixels = picture.pixels().zip(values);
    let is_like = |pixel: &image::Rgba<u8>, value: f32| {
        pixel.0[..3] == colors.color(value) || value.is_nan() && pixel.0[..3] == BACKGROUND_COLOR
    };
    pixels.filter(|(pixel, value)| pixel[3] < 255 || is_like(pixel, **value)).count()
}

#[test]
fn an_orthographic_picture_shows_the_values_of_the_points_that_it_shows() {
    let folder = stored();
    let here = folder.path();
    let arguments = ["render", "scene.ovl", "--views", "path.json", "--out", "out", "--orthographic", "6"];
    let by_value = ["--color-by", "z/m", "--values", "--backend", "cpu"];
    // Two views of one name would be refused.
    let mut views: Value = serde_json::from_slice(&std::fs::read(here.join("path.json")).unwrap()).unwrap();
    views["frames"][1]["file_path"] = json!("other.png");
    std::fs::write(here.join("path.json"), views.to_string()).unwrap();
    run(here, &[&arguments[..], &by_value].concat());
    let whole = array(&here.join("out/other.z%2Fm.npy"));
    let half = array(&here.join("out/other.z%3Am.npy"));
    assert!(whole.iter().zip(&half).all(|(whole, half)| half.is_nan() || (0.5 * whole - half).abs() < 1e-6));
    assert_eq!(colored_like(&picture(&here.join("out/other.png")), &whole, &colors(RANGE)), whole.len());

    let exr = ExrFile::open(&here.join("out/other.exr"), "exr").unwrap();
    let depth = exr.channels().iter().position(|channel| channel.name == "Z").unwrap();
    let depths = exr.decode(&[depth], exr.window(None).unwrap()).unwrap().remove(0).into_single();
    let camera = &transforms::open_views(&here.join("path.json")).unwrap()[1].camera;
    let per_pixel = 6.0 / SIZE.0 as f64;
    let (mut near, mut all) = (0, 0);
    for (pixel, (value, depth)) in
        whole.iter().zip(&depths).enumerate().filter(|(_, (value, _))| !value.is_nan())
    {
        let [x, y] = [(pixel % SIZE.0, SIZE.0), (pixel / SIZE.0, SIZE.1)]
            .map(|(at, side)| (at as f64 + 0.5 - side as f64 / 2.0) * per_pixel);
        let point = glam::DVec3::new(x, y, f64::from(*depth));
        let height = camera.world_from_camera.transform_point3(point).z;
        all += 1;
        near += usize::from((height - f64::from(*value)).abs() < 2.0 * per_pixel);
    }
    assert!(all > 500 && near * 100 > 97 * all, "{near} of {all}");
}

#[test]
fn films_pictures_and_figures_are_colored_by_value_in_one_range_with_a_scalar_bar_below() {
    let folder = stored();
    let here = folder.path();
    let export = |what: &str, out: &str, more: &[&str]| {
        let arguments =
            ["export", what, "scene.ovl", "--path", "path.json", "--backend", "cpu", "--out", out];
        run(here, &[&arguments[..], more].concat())
    };
    export("pictures", "plain", &[]);
    export("pictures", "barred", &["--color-by", "z/m", "--range", "2%,98%"]);
    export("pictures", "bare", &["--color-by", "z/m", "--range", "0,1", "--no-scalar-bar"]);
    let [first, second] = ["0000", "0001"].map(|name| picture(&here.join(format!("barred/{name}.png"))));
    let (width, height) = (SIZE.0 as u32, SIZE.1 as u32);
    assert!(
        first.width() == width && first.height() > height + 20 && first.dimensions() == second.dimensions()
    );
    let below = |picture: &image::RgbaImage| {
        image::imageops::crop_imm(picture, 0, height, width, picture.height() - height).to_image()
    };
    assert_eq!(below(&first), below(&second), "the first picture's range is that of all");
    let shades: HashSet<[u8; 4]> = below(&first).pixels().map(|pixel| pixel.0).collect();
    assert!(shades.len() > 40 && below(&first).pixels().all(|pixel| pixel[3] == 255));

    let bare = picture(&here.join("bare/0000.png"));
    assert_eq!(bare.dimensions(), (width, height));
    let layers = ExrFile::open(&here.join("bare/0000.exr"), "exr").unwrap();
    let names =
        ["value.z/m", "R"].map(|name| layers.channels().iter().position(|it| it.name == name).unwrap());
    let window = layers.window(None).unwrap();
    let [values, red] = names.map(|name| layers.decode(&[name], window).unwrap().remove(0).into_single());
    assert_eq!(colored_like(&bare, &values, &colors([0.0, 1.0])), values.len());
    export("pictures", "open", &["--color-by", "z/m", "--range", "0,1", "--no-scalar-bar", "--transparent"]);
    let open = picture(&here.join("open/0000.png"));
    for ((open, bare), value) in open.pixels().zip(bare.pixels()).zip(&values) {
        assert!(if value.is_nan() { open[3] == 0 } else { open == bare }, "{value}: {open:?} {bare:?}");
    }
    let plain = ExrFile::open(&here.join("plain/0000.exr"), "exr").unwrap();
    let own = plain.channels().iter().position(|it| it.name == "R").unwrap();
    let window = plain.window(None).unwrap();
    assert_eq!(plain.decode(&[own], window).unwrap().remove(0).into_single(), red);

    export("video", "film.mp4", &["--color-by", "z/m"]);
    let film = std::fs::read(here.join("film.mp4")).unwrap();
    // The entry of the sample table, not the brand that the file begins with.
    let after = |bytes: &'_ [u8], name: &[u8]| bytes.windows(4).position(|it| it == name).unwrap() + 4;
    let table = &film[after(&film, b"stsd")..];
    let entry = &table[after(table, b"avc1") + 24..][..4];
    let [columns, rows] = [&entry[..2], &entry[2..]].map(|side| u32::from(side[0]) << 8 | u32::from(side[1]));
    assert_eq!((columns, rows), first.dimensions());

    let figure = ["export", "figure", "scene.ovl", "--color-by", "z/m", "--width", "640px"];
    run(here, &[&figure[..], &["--out", "figure.svg"]].concat());
    run(here, &[&figure[..], &["--out", "bare.svg", "--no-legend", "--orthographic", "5"]].concat());
    let [barred, bare] =
        ["figure.svg", "bare.svg"].map(|name| std::fs::read_to_string(here.join(name)).unwrap());
    for words in ["z/m (m)", ">0.5<", ">1.5<", ">2.0<"] {
        assert!(barred.contains(words) && !bare.contains(words), "{words}");
    }
}

#[test]
fn a_page_has_the_colors_of_a_value_in_its_samples_and_says_what_they_mean() {
    let folder = stored();
    let here = folder.path();
    let export = ["export", "page", "scene.ovl", "--out", "scene.html", "--color-by", "z/m"];
    run(here, &[&export[..], &["--isolate", "0,9"]].concat());
    let page = std::fs::read_to_string(here.join("scene.html")).unwrap();
    let bar = &page_reader::header(&page)["scalar_bar"];
    assert_eq!((bar["title"].as_str(), bar["ticks"][0][1].as_str()), (Some("z/m (m)"), Some("0.0")));
    let (kept, _) =
        overlook_engine::store::read(&here.join("scene.ovl"), &overlook_engine::job::Job::new()).unwrap();
    let isolated = colors(RANGE).isolating([0.0, 9.0]);
    let mut expected: Vec<[u8; 3]> = kept
        .images
        .iter()
        .flat_map(|image| image.values.channel(0).zip(image.inverse_depths()))
        .map(|(value, inverse_depth)| isolated.color_at(value, inverse_depth))
        .collect();
    let images = page_reader::images(&page);
    let mut found: Vec<[u8; 3]> =
        images.iter().flat_map(|image| &image.samples).map(|sample| sample.color).collect();
    expected.sort_unstable();
    found.sort_unstable();
    assert!(found == expected && found.len() > 1000);
    run(here, &[&export[..], &["--no-scalar-bar"]].concat());
    let page = std::fs::read_to_string(here.join("scene.html")).unwrap();
    assert!(page_reader::header(&page)["scalar_bar"].is_null());
}

#[test]
fn edits_by_value_act_on_captures_and_stores_and_mistakes_are_one_line() {
    let folder = stored();
    let here = folder.path();
    let list = |name: &str| {
        format!(
            "version = 1\n[[edit]]\ndo = \"delete\"\nregion = {{ value = {{ name = \"{name}\", from = -inf, to = 0.5 }} }}\n"
        )
    };
    std::fs::write(here.join("low.toml"), list("z/m")).unwrap();
    std::fs::write(here.join("wrong.toml"), list("depth")).unwrap();
    run(here, &["edit", "scene.ovl", "--edits", "low.toml", "--out", "edited.ovl"]);
    run(here, &["preprocess", "scene", "--edits", "low.toml", "--out", "pruned.ovl"]);
    for store in ["edited.ovl", "pruned.ovl"] {
        let (kept, _) =
            overlook_engine::store::read(&here.join(store), &overlook_engine::job::Job::new()).unwrap();
        let values: Vec<f32> = kept.images.iter().flat_map(|image| image.values.channel(0)).collect();
        assert!(values.len() > 300 && !values.iter().any(|value| *value <= 0.5), "{store}");
    }
    let page = ["export", "page", "scene.ovl", "--out", "e.html", "--color-by", "z/m", "--transparent"];
    let video = ["export", "video", "scene.ovl", "--path", "path.json", "--out", "e.mp4"];
    let video = [&video[..], &["--color-by", "z/m", "--transparent"]].concat();
    let mistakes: [(&[&str], &str); 6] = [
        (&page, "no transparent pixels"),
        (&video, "no transparent pixels"),
        (&["edit", "scene.ovl", "--edits", "wrong.toml", "--out", "e.ovl"], "there are z/m, z:m"),
        (
            &["export", "pictures", "scene.ovl", "--path", "path.json", "--out", "e", "--color-by", "p"],
            "there are z/m",
        ),
        (&["export", "figure", "scene", "--out", "e.svg", "--color-by", "z/m"], "give the store"),
        (
            &[
                "export",
                "video",
                "scene.ovl",
                "--path",
                "path.json",
                "--out",
                "e.mp4",
                "--color-by",
                "z/m",
                "--projection",
                "equirectangular",
            ],
            "--projection perspective",
        ),
    ];
    for (arguments, expected) in mistakes {
        let output = overlook(here, arguments).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(!output.status.success() && said.contains(expected), "{arguments:?}: {said}");
        assert!(!here.join(arguments[arguments.iter().position(|it| *it == "--out").unwrap() + 1]).exists());
    }
}
