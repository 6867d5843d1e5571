//! `overlook export page`: one file that holds every sample, and asks for nothing else.

use std::path::Path;
use std::process::Output;

use overlook_engine::color::srgb8_from_linear;
use overlook_engine::job::Job;
use overlook_engine::samples::SampleSet;
use overlook_engine::store;
use overlook_engine::store::file;

use crate::builder::{moving_set, small_report, small_set};
use crate::command::{overlook, scene, succeed};
use crate::page_reader::{header, images};

/// A folder with the store of a set.
fn stored(set: &SampleSet) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    file::write(&folder.path().join("scene.ovl"), set, &small_report(), &Job::new()).unwrap();
    folder
}

fn export(folder: &Path, arguments: &[&str]) -> Output {
    let command = [&["export", "page", "scene.ovl", "--out", "scene.html"], arguments].concat();
    overlook(folder, &command).output().unwrap()
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn page(folder: &Path, arguments: &[&str]) -> String {
    let output = export(folder, arguments);
    assert!(output.status.success(), "{}", said(&output));
    std::fs::read_to_string(folder.join("scene.html")).unwrap()
}

/// A folder with the store of a small demo, its sky and its moving parts.
fn demo() -> tempfile::TempDir {
    let folder = scene("4", "96x72");
    succeed(overlook(folder.path(), &["preprocess", "scene", "--out", "scene.ovl"]));
    folder
}

/// Compares a page with the samples of its store: pixels and spans are equal, colors are those of a display, and inverse depths err by
/// no more than the store grants.
fn check_samples(page: &str, set: &SampleSet) {
    let mut read = images(page);
    read.sort_by_key(|image| (image.camera, image.span));
    let mut expected: Vec<_> = set.images.iter().collect();
    expected.sort_by_key(|image| (image.camera, image.span));
    assert_eq!(read.len(), expected.len());
    for (read, image) in read.iter().zip(expected) {
        let at = (read.camera as u32, read.span, read.level);
        assert_eq!(at, (image.camera, [image.span.start, image.span.end], 0));
        let intrinsics = set.cameras[read.camera].intrinsics;
        let tolerance = set.settings.store.depth_precision / intrinsics.fx.max(intrinsics.fy) as f32;
        let depths = image.inverse_depths();
        assert_eq!(read.samples.len(), image.len());
        for (sample, found) in image.samples().zip(&read.samples) {
            let depth = depths[sample.index];
            assert_eq!(found.pixel, [sample.x, sample.y]);
            assert!(
                (found.inverse_depth - depth).abs() <= tolerance * depth || depth < f32::MIN_POSITIVE,
                "{depth} became {}",
                found.inverse_depth
            );
            assert_eq!(
                found.color,
                image.color[sample.index].map(|channel| srgb8_from_linear(channel.to_f32()))
            );
            assert_eq!(found.is_doubtful, image.is_doubtful(sample.x, sample.y));
        }
    }
}

#[test]
fn a_page_holds_every_sample_once_with_its_span_where_it_was_seen() {
    for set in [small_set(), moving_set()] {
        let folder = stored(&set);
        check_samples(&page(folder.path(), &[]), &set);
    }
    let folder = demo();
    let set = store::read(&folder.path().join("scene.ovl"), &Job::new()).unwrap().0;
    let page = page(folder.path(), &[]);
    check_samples(&page, &set);
    let header = header(&page);
    assert_eq!(header["frames"].as_array().unwrap().len(), 4);
    assert_eq!(header["cameras"][1]["name"], set.cameras[1].name.as_str());
    assert!(header["sky"]["share"].as_f64().unwrap() > 0.0, "the demo has a sky");
}

#[test]
fn a_page_asks_for_nothing_and_says_what_its_author_wrote_as_text() {
    let folder = stored(&moving_set());
    let title = "Growth <b>&</b> \"decay\" </script>";
    let text = "First line.\n\n<img src=x onerror=alert(1)>";
    let page = page(folder.path(), &["--title", title, "--text", text, "--fps", "12"]);
    for forbidden in
        ["http:", "https:", "src=", "@import", "url(", "fetch(", "XMLHttpRequest", "import(", "//cdn"]
    {
        let found = page.replace("<img src=x", "").replace("\\u003cimg src=x", "");
        assert!(!found.contains(forbidden), "{forbidden}");
    }
    assert!(
        page.contains("<title>Growth &lt;b&gt;&amp;&lt;/b&gt; &quot;decay&quot; &lt;/script&gt;</title>")
    );
    let header = header(&page);
    assert_eq!(header["title"], title);
    assert_eq!(header["paragraphs"], serde_json::json!(["First line.", "<img src=x onerror=alert(1)>"]));
    assert_eq!(header["frames_per_second"], 12.0);
    assert!(!page.contains("<img"), "the text is no markup");
    assert_eq!(page.matches("<!-- ").count(), 0, "every slot of the template is filled");
}

#[test]
fn a_page_can_follow_a_saved_path() {
    let folder = stored(&moving_set());
    let key = |time: i64, x: f64| {
        format!(
            r#"{{"file_path":"{time}.exr","time":{time},"transform_matrix":[[1,0,0,{x}],[0,1,0,0],[0,0,1,0],[0,0,0,1]]}}"#
        )
    };
    // Frames of this set are numbered −4, −1, 2 and so on.
    let manifest =
        format!(r#"{{"w":40,"h":30,"fl_x":30,"fl_y":30,"frames":[{},{}]}}"#, key(-1, 0.0), key(5, 2.0));
    std::fs::write(folder.path().join("path.json"), manifest).unwrap();
    let path = header(&page(folder.path(), &["--path", "path.json"]))["path"].clone();
    assert_eq!(path["first_frame"], 1);
    let places: Vec<f64> =
        path["poses"].as_array().unwrap().iter().map(|pose| pose[9].as_f64().unwrap()).collect();
    assert_eq!(places, [0.0, 1.0, 2.0]);
    assert_eq!(path["lens"][0], 40.0);
}

#[test]
fn a_budget_is_kept_by_merging_samples_and_one_that_is_too_small_is_refused() {
    let folder = demo();
    let fine = page(folder.path(), &[]);
    let samples = |page: &str| images(page).iter().map(|image| image.samples.len()).sum::<usize>();
    let overhead = fine.split("class=\"chunk\">").next().unwrap().len();
    let most = overhead + (fine.len() - overhead) / 2;
    let coarse = page(folder.path(), &["--at-most", &most.to_string()]);
    assert!(coarse.len() <= most && coarse.len() * 100 > most * 90, "{} of {most}", coarse.len());
    assert!(samples(&coarse) < samples(&fine));
    let read = images(&coarse);
    assert!(read.iter().any(|image| image.level == 0) && read.iter().any(|image| image.level > 0));
    // A generous one changes nothing.
    assert_eq!(page(folder.path(), &["--at-most", "9M"]), fine);

    std::fs::remove_file(folder.path().join("scene.html")).unwrap();
    let output = export(folder.path(), &["--at-most", "10k"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(said(&output).contains("more than the 10000") && said(&output).trim().lines().count() == 1);
    assert!(!folder.path().join("scene.html").exists());
}

#[test]
fn what_cannot_be_a_page_is_refused_in_one_line_and_leaves_nothing() {
    let folder = stored(&moving_set());
    let here = folder.path();
    let mut empty = moving_set();
    empty.images.clear();
    file::write(&here.join("empty.ovl"), &empty, &small_report(), &Job::new()).unwrap();
    std::fs::copy(here.join("scene.ovl"), here.join("other.ovl")).unwrap();
    let whole = std::fs::read(here.join("scene.ovl")).unwrap();
    std::fs::write(here.join("cut.ovl"), &whole[..whole.len() / 2]).unwrap();
    for (store, out, why) in [
        ("empty.ovl", "scene.html", "no sample"),
        ("cut.ovl", "scene.html", "copy it again"),
        ("missing.ovl", "scene.html", "no such file"),
        ("scene.ovl", "scene.ovl", "is what is read"),
        ("scene.ovl", "other.ovl", "is a store"),
        ("scene.ovl", "nowhere/scene.html", "does not exist"),
        ("scene.ovl", ".", "is a folder"),
    ] {
        let output = overlook(here, &["export", "page", store, "--out", out]).output().unwrap();
        assert_eq!(output.status.code(), Some(1), "{store} to {out}");
        assert!(
            said(&output).contains(why) && said(&output).trim().lines().count() == 1,
            "{}",
            said(&output)
        );
    }
    let mut left: Vec<_> = std::fs::read_dir(here).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    left.sort();
    assert_eq!(left, ["cut.ovl", "empty.ovl", "other.ovl", "scene.ovl"]);
    assert_eq!(std::fs::read(here.join("other.ovl")).unwrap(), whole);
}

#[test]
fn damaged_parts_of_a_store_are_named_and_left_out_of_the_page() {
    let folder = stored(&moving_set());
    let path = folder.path().join("scene.ovl");
    let place = file::Store::open(&path).unwrap().info().images[0];
    let mut bytes = std::fs::read(&path).unwrap();
    let at = place.offset as usize + 8 + place.length as usize - 3;
    bytes[at] ^= 0xff;
    std::fs::write(&path, bytes).unwrap();
    let output = export(folder.path(), &[]);
    assert!(output.status.success(), "{}", said(&output));
    assert!(said(&output).contains("warning") && said(&output).contains("missing"), "{}", said(&output));
    assert!(folder.path().join("scene.html").exists());
}
