//! RESULTS.md and its data were measured with the default settings, and their small figures are measured again and compared. The
//! headline of README.md counts only what a program measured that makes the same pictures as this one.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use overlook_engine::job::Job;
use overlook_engine::settings::{Kernel, Settings};
use overlook_lab::sweep::{self, Point, Series, SweepPlan};
use overlook_lab::truth::Truth;
use serde_json::Value;

use super::command::{overlook, succeed};
use super::small_capture;

/// The command that measures everything again and writes the page.
const RENEW: &str = "assets/results/make.py target/release/overlook";

fn file(path: &str) -> String {
    std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(path)).unwrap()
}

fn results() -> Value {
    serde_json::from_str(&file("assets/results/results.json")).unwrap()
}

/// The value of every setting by its path, out of lines of TOML.
fn values<'a>(lines: impl Iterator<Item = &'a str>) -> BTreeMap<String, String> {
    let (mut section, mut values) = ("", BTreeMap::new());
    for line in lines {
        if let Some(name) = line.strip_prefix('[').and_then(|line| line.strip_suffix(']')) {
            section = name;
        } else if let Some((name, value)) = line.split_once(" = ") {
            values.insert(format!("{section}.{name}"), value.to_owned());
        }
    }
    values
}

#[test]
fn the_results_page_is_of_the_settings_that_the_program_comes_with() {
    let results = results();
    let measured = values(results["settings"].as_array().unwrap().iter().map(|line| line.as_str().unwrap()));
    let defaults = Settings::default().to_toml();
    let defaults = values(defaults.lines());
    assert!(defaults.len() > 30, "{defaults:?}");
    let paths = measured.keys().chain(defaults.keys().filter(|path| !measured.contains_key(*path)));
    let said = |value: Option<&String>| value.map_or("no such setting", String::as_str).to_owned();
    let differing: Vec<String> = paths
        .filter(|path| measured.get(*path) != defaults.get(*path))
        .map(|path| {
            format!("{path}: page {}, program {}", said(measured.get(path)), said(defaults.get(path)))
        })
        .collect();
    assert!(
        differing.is_empty(),
        "RESULTS.md is of other default settings; '{RENEW}' renews it\n{}",
        differing.join("\n")
    );
}

#[test]
fn the_results_page_is_made_of_its_data() {
    let (results, page) = (results(), file("RESULTS.md"));
    let fingerprint = results["settings_fingerprint"].as_str().unwrap();
    let captures = results["captures"].as_array().unwrap();
    assert!(captures.len() >= 5, "{} captures", captures.len());
    let rows = captures.iter().map(|capture| {
        let ours = &capture["methods"]["ours"];
        let [surfaces, seen] = ["db_surfaces", "db_seen"].map(|name| ours[name].as_f64().unwrap_or(f64::NAN));
        let decibels = format!("| **ours** | {surfaces:.2} | {seen:.2} |").replace("NaN", "–");
        let mark = if capture["accuracy"]["pictures"] == results["pictures"] { "" } else { " †" };
        format!("| `{}`{mark} {decibels}", capture["name"].as_str().unwrap())
    });
    for wanted in rows.chain([format!("`{fingerprint}`")]) {
        assert!(
            page.contains(&wanted),
            "RESULTS.md lacks '{wanted}'; 'assets/results/make.py --write-only' writes it from its data"
        );
    }
    assert!(page.lines().count() <= 200, "the page has {} lines", page.lines().count());
}

/// All OpenEXR pictures below a folder, in the order of their names.
fn pictures(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(pictures(&path));
        } else if path.extension().is_some_and(|extension| extension == "exr") {
            found.push(path);
        }
    }
    found.sort();
    found
}

/// CRC-32 of the pictures that the program makes of the small capture, in the order of their names. `make.py` computes the same.
fn hash_of_pictures() -> String {
    let folder = tempfile::tempdir().unwrap();
    let capture = small_capture::folder();
    let views = capture.join("novel/transforms.json");
    let [capture, views] = [&capture, &views].map(|path| path.to_str().unwrap());
    succeed(overlook(folder.path(), &["preprocess", capture, "--out", "hashed.ovl"]));
    let render = ["render", "hashed.ovl", "--views", views, "--out", "hashed", "--backend", "cpu"];
    succeed(overlook(folder.path(), &render));
    let pictures = pictures(&folder.path().join("hashed"));
    assert!(pictures.len() >= 12, "{pictures:?}");
    let mut hasher = crc32fast::Hasher::new();
    for picture in pictures {
        hasher.update(&std::fs::read(picture).unwrap());
    }
    format!("{:08x}", hasher.finalize())
}

/// The smallest and the largest of some values, in the words of the page.
fn span(values: impl Iterator<Item = f64> + Clone) -> String {
    let low = values.clone().fold(f64::INFINITY, f64::min);
    let high = values.fold(f64::NEG_INFINITY, f64::max);
    let [low, high] =
        [low, high].map(|value| if value >= 9.95 { format!("{value:.0}") } else { format!("{value:.1}") });
    if low == high { low } else { format!("{low} to {high}") }
}

#[test]
fn the_headline_counts_no_row_of_a_program_with_other_pictures() {
    let (results, readme) = (results(), file("README.md"));
    let now = hash_of_pictures();
    assert_eq!(
        results["pictures"], now,
        "the program makes other pictures than the one of RESULTS.md; '{RENEW}' measures anew, and \
         'assets/results/make.py --write-only target/release/overlook' marks the rows of other programs"
    );
    let captures = results["captures"].as_array().unwrap();
    let of_this_program = |part: &'static str| {
        let now = now.as_str();
        captures.iter().filter(move |capture| capture[part]["pictures"] == now)
    };
    let dropped = of_this_program("accuracy")
        .map(|capture| 100.0 * (1.0 - capture["methods"]["ours"]["kept"].as_f64().unwrap()));
    let took = of_this_program("accuracy")
        .filter(|capture| capture["times"]["pictures"] == now.as_str())
        .map(|capture| capture["times"]["milliseconds"]["ours"].as_f64().unwrap());
    let counted =
        [format!("[{} % of the pixels]", span(dropped.clone())), format!("[{} ms]", span(took.clone()))];
    for (wanted, rows) in counted.iter().zip([dropped.count(), took.count()]) {
        assert!(
            rows == 0 || readme.contains(wanted),
            "README.md lacks '{wanted}', of {rows} rows of this program"
        );
    }
}

/// What `overlook sweep assets/small_capture` measures with the kernel `gather` and with the paper's settings.
fn measured_now() -> Vec<Point> {
    let capture = small_capture::capture();
    let truth = Truth::Views(small_capture::views());
    let mut plan = SweepPlan::grid(&Settings::default(), &[], &capture).unwrap();
    plan.trials.retain(|planned| {
        // Rivals are rendered by no kernel.
        !planned.series.is_rival()
            && (planned.trial.settings.render.kernel == Kernel::Gather || planned.series == Series::Paper)
    });
    sweep::run(&capture, &plan, &truth, &Job::new(), |_, _| ()).unwrap().points
}

#[test]
fn the_small_figures_of_the_results_page_are_what_the_program_measures() {
    let results = results();
    let captures = results["captures"].as_array().unwrap();
    let small = captures.iter().find(|capture| capture["name"] == "small_capture").unwrap();
    let published = small["points"].as_array().unwrap();
    let mut compared = 0;
    for point in measured_now() {
        let of_point = |published: &&Value| published["label"] == point.label.as_str();
        let published =
            published.iter().find(of_point).unwrap_or_else(|| panic!("no figures of '{}'", point.label));
        let figures = [
            ("db_seen", point.psnr_filled_db),
            ("db_seen_se", point.psnr_filled_db_se),
            ("ssim", point.ssim),
            ("flip", point.flip),
            ("coverage", point.coverage),
            ("samples", point.samples as f64),
            ("bytes", point.bytes as f64),
        ];
        for (name, now) in figures {
            let before = published[name].as_f64().unwrap();
            assert!(
                (now - before).abs() < 6e-5,
                "{}, {name}: published {before}, now {now}; '{RENEW}' renews it",
                point.label
            );
        }
        compared += 1;
    }
    assert!(compared >= 8, "{compared} rows");
}
