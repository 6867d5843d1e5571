//! `overlook export`: points, pictures and films that other programs read.

use std::path::Path;
use std::process::{Command, Output};

use overlook_engine::job::Job;

use crate::builder::{moving_set, small_report, small_set};

fn overlook(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_overlook")).arg("export").args(arguments).output().unwrap()
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// A folder with a store and a camera path of two keys, frames 1 to 3 of its first four.
fn scene() -> (tempfile::TempDir, String, String) {
    let folder = tempfile::tempdir().unwrap();
    let [store, path] = ["scene.ovl", "path.json"].map(|name| folder.path().join(name).display().to_string());
    let mut set = moving_set();
    set.frame_numbers = (0..10).collect();
    overlook_engine::store::file::write(Path::new(&store), &set, &small_report(), &Job::new()).unwrap();
    let pose = |x: f64| format!("[[1,0,0,{x}],[0,-1,0,-2.0],[0,0,-1,0.3],[0,0,0,1]]");
    let views = [(1, 0.1), (3, 0.2)].map(|(time, x)| {
        format!(r#"{{"file_path":"{time}.exr","time":{time},"transform_matrix":{}}}"#, pose(x))
    });
    let manifest =
        format!(r#"{{"w":31,"h":20,"fl_x":30,"fl_y":30,"cx":15.5,"cy":10,"frames":[{}]}}"#, views.join(","));
    std::fs::write(&path, manifest).unwrap();
    (folder, store, path)
}

/// Header lines and bytes of a PLY file.
fn ply(path: &Path) -> (Vec<String>, Vec<u8>) {
    let bytes = std::fs::read(path).unwrap();
    let end = bytes.windows(11).position(|window| window == b"end_header\n").unwrap() + 11;
    let header = String::from_utf8(bytes[..end].to_vec()).unwrap();
    (header.lines().map(str::to_owned).collect(), bytes[end..].to_vec())
}

#[test]
fn points_lie_where_the_samples_were_seen() {
    let (folder, store, _) = scene();
    let out = folder.path().join("points.ply");
    let output = overlook(&["points", &store, "--frame", "2", "--out", out.to_str().unwrap()]);
    assert!(output.status.success(), "{}", said(&output));
    let (header, points) = ply(&out);
    let set = moving_set();
    let image = &set.images[2];
    assert_eq!(header[0..2], ["ply", "format binary_little_endian 1.0"]);
    assert!(header.contains(&format!("element vertex {}", image.len())));
    let properties = header.iter().filter(|line| line.starts_with("property")).count();
    assert_eq!((properties, points.len()), (10, image.len() * 31));
    let camera = &set.cameras[0];
    for (sample, point) in image.samples().zip(points.chunks(31)).step_by(17) {
        let float = |nth: usize| f32::from_le_bytes(point[4 * nth..4 * nth + 4].try_into().unwrap());
        let seen = camera.world_from_camera.inverse().transform_point3(glam::DVec3::new(
            float(0).into(),
            float(1).into(),
            float(2).into(),
        ));
        let z = 1.0 / f64::from(image.inverse_depths()[sample.index]);
        let intrinsics = &camera.intrinsics;
        assert!((seen.z - z).abs() < 1e-5);
        assert!((seen.x / seen.z * intrinsics.fx + intrinsics.cx - sample.x as f64 - 0.5).abs() < 1e-3);
        assert!((seen.y / seen.z * intrinsics.fy + intrinsics.cy - sample.y as f64 - 0.5).abs() < 1e-3);
        assert_eq!([float(3), float(4), float(5)], [0.0; 3]);
        // A disk as large as a pixel: half its width over the square root of π.
        let expected = z / intrinsics.fx / std::f64::consts::PI.sqrt();
        assert!((0.8..1.01).contains(&(f64::from(float(6)) / expected)), "{} {expected}", float(6));
    }
}

#[test]
fn points_far_from_the_origin_keep_millimeters() {
    let folder = tempfile::tempdir().unwrap();
    let [store, out] = ["far.ovl", "points.ply"].map(|name| folder.path().join(name));
    let mut set = small_set();
    let place = glam::DVec3::new(447_512.25, 5_411_850.5, 312.0);
    for camera in &mut set.cameras {
        camera.world_from_camera.translation += place;
    }
    overlook_engine::store::file::write(&store, &set, &small_report(), &Job::new()).unwrap();
    let arguments = ["points", store.to_str().unwrap(), "--static", "--out", out.to_str().unwrap()];
    let output = overlook(&arguments);
    assert!(output.status.success(), "{}", said(&output));
    let (header, points) = ply(&out);
    assert!(["x", "y", "z"].iter().all(|axis| header.contains(&format!("property double {axis}"))));
    let image = &set.images[0];
    let depths = image.inverse_depths();
    let near: Vec<_> = image.samples().filter(|sample| depths[sample.index] > 0.0).collect();
    assert_eq!(points.len(), near.len() * 43);
    for (sample, point) in near.iter().zip(points.chunks(43)) {
        let double = |nth: usize| f64::from_le_bytes(point[8 * nth..8 * nth + 8].try_into().unwrap());
        let pixel = glam::DVec2::new(sample.x as f64 + 0.5, sample.y as f64 + 0.5);
        let z = 1.0 / f64::from(depths[sample.index]);
        let expected = set.cameras[image.camera as usize].unproject(pixel, z);
        assert!(expected.distance(glam::DVec3::new(double(0), double(1), double(2))) < 1e-6);
    }
}

#[test]
fn every_frame_gets_a_file_and_static_points_one() {
    let (folder, store, _) = scene();
    let out = folder.path().join("frames");
    assert!(overlook(&["points", &store, "--out", out.to_str().unwrap()]).status.success());
    assert_eq!(std::fs::read_dir(&out).unwrap().count(), 10);
    let (header, _) = ply(&out.join("0009.ply"));
    assert!(header.contains(&format!("element vertex {}", moving_set().images[9].len())));

    let small = folder.path().join("small.ovl");
    overlook_engine::store::file::write(&small, &small_set(), &small_report(), &Job::new()).unwrap();
    let out = folder.path().join("static.ply");
    let output = overlook(&["points", small.to_str().unwrap(), "--static", "--out", out.to_str().unwrap()]);
    assert!(output.status.success(), "{}", said(&output));
    let near = small_set().images[0].inverse_depths().iter().filter(|depth| **depth > 0.0).count();
    assert!(ply(&out).0.contains(&format!("element vertex {near}")));

    let output = overlook(&["points", &store, "--frame", "77", "--out", "nowhere.ply"]);
    assert!(output.status.code() == Some(1) && said(&output).contains("no frame 77"));
}

#[test]
fn no_export_replaces_what_it_is_made_from_or_another_store() {
    let (folder, store, path) = scene();
    let at = |name: &str| folder.path().join(name).display().to_string();
    let (other, picture, settings) = (at("other.ovl"), at("1.exr"), at("settings.toml"));
    std::fs::copy(&store, &other).unwrap();
    std::fs::write(&picture, "a picture of the path").unwrap();
    std::fs::write(&settings, "[render]\nkernel = \"block\"\n").unwrap();
    let files = [&store, &path, &other, &picture, &settings];
    let before = files.map(|name| std::fs::read(name).unwrap());
    for (export, out, why) in [
        (["points", &store, "--frame", "2"].as_slice(), &other, "is a store"),
        (&["points", &store, "--static"], &store, "is what is read"),
        (&["video", &store, "--path", &path], &store, "is what is read"),
        (&["video", &store, "--path", &path], &path, "is what is read"),
        (&["video", &store, "--path", &path], &picture, "is what is read"),
        (&["video", &store, "--path", &path], &other, "is a store"),
        (&["video", &store, "--path", &path, "--settings", &settings], &settings, "is what is read"),
    ] {
        let output = overlook(&[export, &["--out", out]].concat());
        assert_eq!(output.status.code(), Some(1), "{export:?} to {out}");
        assert!(said(&output).contains(why) && said(&output).contains(out.as_str()), "{}", said(&output));
    }
    assert_eq!(before, files.map(|name| std::fs::read(name).unwrap()));
}

#[test]
fn pictures_follow_the_path_frame_by_frame() {
    let (folder, store, path) = scene();
    let out = folder.path().join("pictures");
    let arguments = ["pictures", &store, "--path", &path, "--backend", "cpu", "--out", out.to_str().unwrap()];
    let output = overlook(&arguments);
    assert!(output.status.success(), "{}", said(&output));
    let mut names: Vec<String> = std::fs::read_dir(&out)
        .unwrap()
        .map(|file| file.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    assert_eq!(names, ["0001.exr", "0001.png", "0002.exr", "0002.png", "0003.exr", "0003.png"]);
    let png = image::open(out.join("0002.png")).unwrap().into_rgba8();
    assert_eq!(png.dimensions(), (31, 20));
    assert!(png.pixels().any(|pixel| pixel.0[3] == 255));
}
