//! Image databases after the Cinema specification D: written as it says, and opened again with the same pictures.

use std::path::Path;

use overlook_engine::capture;
use overlook_engine::settings::CaptureSettings;

use super::said::{fail, succeed};

const SMALL_CAPTURE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/small_capture");

/// A database of the small capture: 3 angles about up, 2 above.
fn database(folder: &Path) -> String {
    succeed(folder, &["preprocess", SMALL_CAPTURE, "--out", "scene.ovl"]);
    let angles = ["--phi", "-20,20,3", "--theta", "10,25,2", "--size", "80x60"];
    succeed(folder, &[&["export", "cinema", "scene.ovl", "--out", "scene.cdb"], angles.as_slice()].concat())
}

fn table(folder: &Path) -> Vec<Vec<String>> {
    let text = std::fs::read_to_string(folder.join("scene.cdb/data.csv")).unwrap();
    text.lines().map(|line| line.split(',').map(str::to_owned).collect()).collect()
}

#[test]
fn a_database_is_as_the_specification_says_and_opens_again_as_a_capture_with_the_same_pictures() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let said = database(folder);
    assert!(said.contains("Wrote 24 pictures, of 6 viewpoints, to scene.cdb"), "{said}");
    let table = table(folder);
    let (columns, rows) = table.split_first().unwrap();
    // Names are unique, those of files come last and begin with FILE, and rows are as long as the first.
    let mut names = columns.clone();
    names.sort();
    names.dedup();
    assert_eq!(names.len(), columns.len());
    let first_file = columns.iter().position(|column| column.starts_with("FILE")).unwrap();
    assert!(columns[first_file..].iter().all(|column| column.starts_with("FILE")));
    assert_eq!(columns.last().unwrap(), "FILE", "viewers show the last file of a row");
    assert!(rows.len() == 24 && rows.iter().all(|row| row.len() == columns.len()));
    for row in rows {
        assert!(
            row[first_file..].iter().all(|file| folder.join("scene.cdb").join(file).is_file()),
            "{row:?}"
        );
    }

    let info = succeed(folder, &["info", "scene.cdb"]);
    assert!(info.contains("Cinema database, 24 pictures"), "{info}");
    let opened = capture::open(&folder.join("scene.cdb"), &CaptureSettings::default()).unwrap();
    assert_eq!((opened.cameras.len(), opened.frame_count()), (6, 4));
    let number = |row: &[String], name: &str| -> f64 {
        row[columns.iter().position(|column| column == name).unwrap()].parse().unwrap()
    };
    for (camera, row) in opened.cameras.iter().zip(rows) {
        let eye = camera.position_in_world();
        let told = ["position_x", "position_y", "position_z"].map(|name| number(row, name));
        assert!((eye - glam::DVec3::from_array(told)).length() < 1e-12, "{eye} {told:?}");
        let half = 0.5 * number(row, "view_angle").to_radians();
        assert!((camera.intrinsics.fy - 30.0 / half.tan()).abs() < 1e-9);
    }
    let written = image::open(folder.join("scene.cdb").join(rows[0].last().unwrap())).unwrap().to_rgb8();
    let frame = opened.frame(0, 0).unwrap();
    for (x, y, pixel) in written.enumerate_pixels() {
        let read = frame.color[(x as usize, y as usize)].map(half::f16::to_f32);
        let read = read.map(|value| (255.0 * overlook_engine::color::srgb_from_linear(value)).round() as u8);
        assert!(pixel.0.iter().zip(read).all(|(a, b)| a.abs_diff(b) <= 1), "{x} {y}: {pixel:?} {read:?}");
    }
    // What is read is one scene: its views agree with each other, so that most of them is repeated.
    let pruned = succeed(folder, &["preprocess", "scene.cdb", "--out", "again.ovl"]);
    let kept = pruned.lines().find(|line| line.starts_with("Kept")).unwrap();
    let share: f64 = kept.rsplit_once('(').unwrap().1.split(' ').next().unwrap().parse().unwrap();
    assert!(share < 40.0, "{kept}");
}

#[test]
fn a_database_that_does_not_say_where_its_cameras_stood_or_has_no_depth_says_what_is_missing() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    database(folder);
    let path = folder.join("scene.cdb/data.csv");
    let whole = std::fs::read_to_string(&path).unwrap();
    let without = |first: &str| {
        let lines = table(folder).into_iter().collect::<Vec<_>>();
        let kept: Vec<usize> = (0..lines[0].len()).filter(|at| !lines[0][*at].starts_with(first)).collect();
        let lines =
            lines.iter().map(|line| kept.iter().map(|at| line[*at].as_str()).collect::<Vec<_>>().join(","));
        lines.collect::<Vec<_>>().join("\n")
    };
    for (first, words) in
        [("position", "columns radius and view_angle"), ("FILE_depth", "give a column FILE_depth")]
    {
        let text = without(first);
        std::fs::write(&path, text).unwrap();
        let said = fail(folder, &["preprocess", "scene.cdb", "--out", "bad.ovl"], 1);
        assert!(said.contains("data.csv") && said.contains(words), "{said}");
        std::fs::write(&path, &whole).unwrap();
    }
    // Angles and a distance are enough: the cameras stand where positions say.
    let by_position = capture::open(&folder.join("scene.cdb"), &CaptureSettings::default()).unwrap();
    let lines = table(folder);
    let at = |name: &str| lines[0].iter().position(|column| column == name).unwrap();
    let point = |row: &[String], name: &str| {
        glam::DVec3::from_array(
            ["x", "y", "z"].map(|axis| row[at(&format!("{name}_{axis}"))].parse().unwrap()),
        )
    };
    let radius = (point(&lines[1], "position") - point(&lines[1], "focal_point")).length();
    let text = without("position");
    let (columns, rows) = text.split_once('\n').unwrap();
    let rows: Vec<String> = rows.lines().map(|row| format!("{radius},{row}")).collect();
    std::fs::write(&path, format!("radius,{columns}\n{}\n", rows.join("\n"))).unwrap();
    let by_angle = capture::open(&folder.join("scene.cdb"), &CaptureSettings::default()).unwrap();
    for (one, other) in by_position.cameras.iter().zip(&by_angle.cameras) {
        let apart = (one.position_in_world() - other.position_in_world()).length();
        assert!(apart < 1e-9 && one.intrinsics == other.intrinsics, "{apart}");
    }
    for wrong in ["0,360", "a,b,c", "0,90,0"] {
        let said = fail(folder, &["export", "cinema", "scene.ovl", "--out", "no.cdb", "--phi", wrong], 2);
        assert!(said.contains("FIRST,LAST,COUNT"), "{said}");
    }
    assert!(!folder.join("no.cdb").exists() && !folder.join("bad.ovl").exists());
}
