//! `overlook export splats`: each sample as a flat Gaussian where it was seen, in four formats.

use std::path::Path;
use std::process::Output;

use glam::{DVec2, DVec3, Vec3};
use overlook_engine::capture::Camera;
use overlook_engine::color::srgb_from_linear;
use overlook_engine::job::Job;
use overlook_engine::samples::{OctNormal, SampleImage, SampleSet};
use overlook_engine::store;
use overlook_engine::store::file;

use crate::builder::{moving_set, small_report};
use crate::command::{overlook, scene, succeed};
use crate::splat_reader::{self, ReadSpan, ReadSplat};

fn export(folder: &Path, arguments: &[&str]) -> Output {
    overlook(folder, &[&["export", "splats", "scene.ovl"], arguments].concat()).output().unwrap()
}

fn said(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// What was said on stdout.
fn exported(folder: &Path, arguments: &[&str]) -> String {
    let output = export(folder, arguments);
    assert!(output.status.success(), "{}", said(&output.stderr));
    said(&output.stdout)
}

/// A folder with the store of a small demo, with its sky, its moving parts and its normals; and its samples.
fn demo() -> (tempfile::TempDir, SampleSet) {
    let folder = scene("4", "96x72");
    let arguments = ["preprocess", "scene", "--out", "scene.ovl", "--set", "store.normals=true"];
    succeed(overlook(folder.path(), &arguments));
    let set = store::read(&folder.path().join("scene.ovl"), &Job::new()).unwrap().0;
    (folder, set)
}

fn stored(set: &SampleSet) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    file::write(&folder.path().join("scene.ovl"), set, &small_report(), &Job::new()).unwrap();
    folder
}

/// A sample as the store has it: its place, its normal where one is known, its camera, its color, whether it is doubtful.
struct Expected<'a> {
    point: DVec3,
    depth: f64,
    normal: DVec3,
    camera: &'a Camera,
    color: Vec3,
    is_doubtful: bool,
}

/// The samples of an image that are not at infinity.
fn expected<'a>(image: &'a SampleImage, set: &'a SampleSet) -> Vec<Expected<'a>> {
    let camera = &set.cameras[image.camera as usize];
    let depths = image.inverse_depths();
    let samples = image.samples().filter(|sample| depths[sample.index] > 0.0);
    let of = |sample: overlook_engine::samples::Sample| {
        let depth = 1.0 / f64::from(depths[sample.index]);
        let pixel = DVec2::new(sample.x as f64 + 0.5, sample.y as f64 + 0.5);
        let color =
            image.color[sample.index].map(|channel| srgb_from_linear(channel.to_f32().clamp(0.0, 1.0)));
        let normal =
            image.normal.as_ref().map_or(Vec3::ZERO, |normals| OctNormal::decode(normals[sample.index]));
        Expected {
            point: camera.unproject(pixel, depth),
            depth,
            normal: normal.as_dvec3(),
            camera,
            color: Vec3::from(color),
            is_doubtful: image.is_doubtful(sample.x, sample.y),
        }
    };
    samples.map(of).collect()
}

/// How exact a format is: of places and, as a share, of radii; of colors; and as the cosine of an angle.
#[derive(Clone, Copy)]
struct Exactness {
    place: f64,
    radius: f64,
    color: f32,
    cosine: f64,
}

const FLOATS: Exactness = Exactness { place: 1e-5, radius: 1e-3, color: 1e-4, cosine: 0.9999 };
const SPZ: Exactness = Exactness { place: 1e-4, radius: 0.05, color: 0.012, cosine: 0.9999 };

/// The splats of samples: what keeps surfaces opaque behind them is more opaque than any.
fn of_samples<'a>(splats: impl IntoIterator<Item = &'a ReadSplat>) -> Vec<&'a ReadSplat> {
    splats.into_iter().filter(|splat| splat.opacity < 0.995).collect()
}

/// Compares a splat with its sample. `to_world` takes the axes of the file to those of the world.
fn check(splat: &ReadSplat, sample: &Expected<'_>, to_world: fn(Vec3) -> Vec3, exactness: Exactness) {
    let place = to_world(splat.center).as_dvec3();
    assert!(place.distance(sample.point) < exactness.place * sample.depth, "{place} {}", sample.point);
    assert!((splat.color - sample.color).abs().max_element() < exactness.color, "{splat:?} {}", sample.color);
    let opacity = if sample.is_doubtful { 0.5 } else { 0.99 };
    assert!((splat.opacity - opacity).abs() < 0.01, "{}", splat.opacity);
    assert!((splat.rotation.length() - 1.0).abs() < 1e-3);
    let axis = |axis: Vec3| to_world(splat.rotation * axis).as_dvec3();
    let (long, normal) = (axis(Vec3::X), axis(Vec3::Z));
    // The side that the camera saw is out.
    let sight = (sample.point - sample.camera.position_in_world()).normalize_or_zero();
    assert!(normal.dot(sight) < 0.02, "{normal} {sight}");
    let [longer, shorter, thickness] = splat.radii.to_array().map(f64::from);
    if sample.normal == DVec3::ZERO {
        return;
    }
    assert!(normal.dot(sample.normal).abs() > exactness.cosine, "{normal} {}", sample.normal);
    let lens = &sample.camera.intrinsics;
    let cosine = sample.normal.dot(sight).abs();
    // Two fifths of a pixel on its surface: its area is that of a pixel face on, over the cosines of slant and of the angle off the axis.
    let off_axis = (sample.camera.world_from_camera.matrix3.transpose() * sight).z;
    if cosine > 0.2 {
        let area = 0.16 * sample.depth * sample.depth / (lens.fx * lens.fy) * off_axis / cosine;
        assert!((longer * shorter / area - 1.0).abs() < 2.0 * exactness.radius, "{longer} {shorter} {area}");
        assert!(thickness < 0.011 * shorter || exactness.radius > 0.01, "{thickness} {shorter}");
    }
    assert!(longer <= 10.0 * shorter * (1.0 + 2.0 * exactness.radius));
    if (0.2..0.7).contains(&cosine) && off_axis > 0.9 {
        let slant = (sight - sample.normal * sight.dot(sample.normal)).normalize_or_zero();
        assert!(long.dot(slant).abs() > 0.8, "it is long along the slant: {}", long.dot(slant));
    }
}

/// Down-forward axes back to z up.
fn from_ply(file: Vec3) -> Vec3 {
    Vec3::new(file.x, file.z, -file.y)
}

/// y-up axes back to z up.
fn from_y_up(file: Vec3) -> Vec3 {
    Vec3::new(file.x, -file.z, file.y)
}

#[test]
fn a_frame_as_ply_and_spz_has_each_sample_as_a_flat_ellipse_on_its_surface() {
    let (folder, set) = demo();
    let number = set.frame_numbers[2].to_string();
    let samples: Vec<Expected<'_>> = set.images_at(2).flat_map(|image| expected(image, &set)).collect();
    assert!(samples.len() > 3000 && samples.iter().any(|sample| sample.normal != DVec3::ZERO));
    let out = ["--sky", "out", "--out", "scene.ply"];
    let told = exported(folder.path(), &[&["--format", "ply", "--frame", &number], &out[..]].concat());
    assert!(
        told.starts_with("Wrote ") && told.contains("of the sky") && told.trim().lines().count() == 1,
        "{told}"
    );
    let (splats, header) = splat_reader::ply(&folder.path().join("scene.ply"));
    assert!(header.contains(&format!("element vertex {}", splats.len())));
    let fronts = of_samples(&splats);
    let backs = splats.len() - fronts.len();
    assert_eq!(fronts.len(), samples.len());
    assert!((samples.len() / 10..=samples.len() / 4).contains(&backs), "{backs}");
    assert!(told.contains(" of them behind surfaces"), "{told}");
    fronts.into_iter().zip(&samples).for_each(|(splat, sample)| check(splat, sample, from_ply, FLOATS));

    let told = exported(
        folder.path(),
        &["--format", "spz", "--frame", &number, "--sky", "out", "--out", "scene.spz"],
    );
    assert!(told.contains("positions within"), "{told}");
    let splats = splat_reader::spz(&folder.path().join("scene.spz"));
    let fronts = of_samples(&splats);
    assert_eq!(fronts.len(), samples.len());
    fronts.into_iter().zip(&samples).for_each(|(splat, sample)| check(splat, sample, from_y_up, SPZ));
}

#[test]
fn gltf_and_usd_hold_each_sample_once_and_show_at_every_frame_those_of_the_store() {
    let (folder, set) = demo();
    exported(folder.path(), &["--format", "glb", "--out", "scene.glb", "--fps", "10", "--sky", "out"]);
    exported(folder.path(), &["--format", "usda", "--out", "scene.usda", "--sky", "out"]);
    let path = |name: &str| folder.path().join(name);
    let (glb, usda) = (splat_reader::glb(&path("scene.glb")).0, splat_reader::usda(&path("scene.usda")).0);
    let of_set: usize = set.images.iter().map(|image| expected(image, &set).len()).sum();
    for (spans, frames_per_time) in [(&glb, 0.1), (&usda, 1.0)] {
        assert_eq!(spans.iter().map(|span| of_samples(&span.splats).len()).sum::<usize>(), of_set);
        assert!(spans.len() > 4 && spans.iter().any(|span| span.changes.is_empty()));
        for frame in 0..4 {
            // Within the frame, so that no rounding of its first moment matters.
            let seen: Vec<&ReadSpan> =
                spans.iter().filter(|span| span.is_seen((frame as f32 + 0.5) * frames_per_time)).collect();
            let splats = of_samples(seen.iter().flat_map(|span| &span.splats));
            let samples: Vec<Expected<'_>> =
                set.images_at(frame).flat_map(|image| expected(image, &set)).collect();
            assert_eq!(splats.len(), samples.len(), "frame {frame}");
            splats
                .into_iter()
                .zip(&samples)
                .for_each(|(splat, sample)| check(splat, sample, from_y_up, FLOATS));
        }
    }
    // What a program that knows no splats shows: linear colors.
    let (json, binary) = splat_reader::glb_parts(&path("scene.glb"));
    let accessor = json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"].as_u64().unwrap() as usize;
    let accessor = &json["accessors"][accessor];
    assert_eq!((&accessor["componentType"], &accessor["normalized"]), (&5123.into(), &true.into()));
    let view = &json["bufferViews"][accessor["bufferView"].as_u64().unwrap() as usize];
    let first = view["byteOffset"].as_u64().unwrap() as usize;
    for (splat, bytes) in glb[0].splats.iter().zip(binary[first..].chunks(8)) {
        let red = f32::from(u16::from_le_bytes([bytes[0], bytes[1]])) / 65_535.0;
        assert!((srgb_from_linear(red) - splat.color.x).abs() < 2e-4);
    }
    for used in ["KHR_gaussian_splatting", "KHR_node_visibility", "KHR_animation_pointer"] {
        assert!(json["extensionsUsed"].as_array().unwrap().contains(&used.into()), "{used}");
    }
}

#[test]
fn every_frame_gets_a_file_of_a_format_that_holds_one_and_a_budget_holds_for_each() {
    let folder = stored(&moving_set());
    let told = exported(folder.path(), &["--format", "ply", "--out", "frames", "--at-most-splats", "2k"]);
    assert!(told.contains("10 files") && told.contains("merged from"), "{told}");
    let set = moving_set();
    for number in &set.frame_numbers {
        let (splats, _) = splat_reader::ply(&folder.path().join(format!("frames/{number:04}.ply")));
        assert!((1..=2000).contains(&splats.len()), "{}", splats.len());
    }
    assert_eq!(std::fs::read_dir(folder.path().join("frames")).unwrap().count(), 10);
}

#[test]
fn the_sky_becomes_a_dome_around_everything() {
    let (folder, set) = demo();
    let samples: usize = set.images_at(0).map(|image| expected(image, &set).len()).sum();
    let first = set.frame_numbers[0].to_string();
    let told = exported(folder.path(), &["--format", "ply", "--frame", &first, "--out", "scene.ply"]);
    assert!(told.contains("10,000 of them the sky as a far dome"), "{told}");
    let (splats, _) = splat_reader::ply(&folder.path().join("scene.ply"));
    let (of_scene, dome) = splats.split_at(splats.len() - 10_000);
    assert_eq!(of_samples(of_scene).len(), samples);
    let farthest = of_scene.iter().map(|splat| splat.center.length()).fold(0.0, f32::max);
    for splat in dome {
        assert!(splat.center.length() > 2.0 * farthest && splat.radii.is_finite());
        assert!(
            (splat.rotation * Vec3::Z).dot(splat.center.normalize_or_zero()) < -0.5,
            "it faces the scene"
        );
    }
}

#[test]
fn scenes_far_from_the_origin_keep_millimeters_and_say_their_offset() {
    let mut set = moving_set();
    set.up_in_world = DVec3::Z;
    let far = DVec3::new(447_512.25, 5_411_850.5, 312.0);
    for camera in &mut set.cameras {
        camera.world_from_camera.translation += far;
    }
    let folder = stored(&set);
    let expected = expected(&set.images[0], &set);
    let told = exported(folder.path(), &["--format", "ply", "--frame", "-4", "--out", "scene.ply"]);
    assert!(told.contains("less the offset ("), "{told}");
    let (splats, header) = splat_reader::ply(&folder.path().join("scene.ply"));
    let offset = header.iter().find_map(|line| line.strip_prefix("comment offset ")).unwrap();
    let offset: Vec<f64> = offset.split(' ').map(|part| part.parse().unwrap()).collect();
    let near = |file: DVec3, at: usize| (file - expected[at].point).length() < 1e-4;
    for (at, splat) in of_samples(&splats).into_iter().enumerate() {
        let moved = splat.center.as_dvec3() + DVec3::from_slice(&offset);
        assert!(near(DVec3::new(moved.x, moved.z, -moved.y), at));
    }
    for format in ["glb", "usda"] {
        let out = format!("scene.{format}");
        let told = exported(folder.path(), &["--format", format, "--frame", "-4", "--out", &out]);
        assert!(!told.contains("offset"), "the file says it: {told}");
        let path = folder.path().join(out);
        let (spans, moved) =
            if format == "glb" { splat_reader::glb(&path) } else { splat_reader::usda(&path) };
        assert!(spans.len() == 1 && spans[0].changes.is_empty(), "one frame does not change");
        for (at, splat) in of_samples(&spans[0].splats).into_iter().enumerate() {
            let moved = splat.center.as_dvec3() + moved;
            assert!(near(DVec3::new(moved.x, -moved.z, moved.y), at), "{format}");
        }
    }
}

#[test]
fn what_cannot_become_splats_is_refused_in_one_line_and_leaves_nothing() {
    let folder = stored(&moving_set());
    let here = folder.path();
    let mut empty = moving_set();
    empty.images.clear();
    file::write(&here.join("empty.ovl"), &empty, &small_report(), &Job::new()).unwrap();
    std::fs::copy(here.join("scene.ovl"), here.join("other.ovl")).unwrap();
    let whole = std::fs::read(here.join("scene.ovl")).unwrap();
    std::fs::write(here.join("cut.ovl"), &whole[..whole.len() / 2]).unwrap();
    for (store, format, arguments, why) in [
        ("empty.ovl", "glb", ["--out", "a.glb"].as_slice(), "no sample"),
        ("empty.ovl", "ply", &["--out", "frames"], "no sample"),
        ("cut.ovl", "usda", &["--out", "a.usda"], "copy it again"),
        ("missing.ovl", "ply", &["--out", "frames"], "no such file"),
        ("scene.ovl", "ply", &["--frame", "77", "--out", "a.ply"], "no frame 77"),
        ("scene.ovl", "spz", &["--frame", "-4", "--out", "scene.ovl"], "is what is read"),
        ("scene.ovl", "glb", &["--out", "other.ovl"], "is a store"),
        ("scene.ovl", "glb", &["--out", "nowhere/a.glb"], "does not exist"),
        ("scene.ovl", "glb", &["--out", "."], "is a folder"),
        ("scene.ovl", "ply", &["--out", "other.ovl"], "is a file"),
        ("scene.ovl", "glb", &["--at-most-splats", "5", "--out", "a.glb"], "more than the 5"),
    ] {
        let command = [&["export", "splats", store, "--format", format], arguments].concat();
        let output = overlook(here, &command).output().unwrap();
        let told = said(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{command:?}: {told}");
        assert!(told.contains(why) && told.trim().lines().count() == 1, "{told}");
    }
    let mut left: Vec<_> = std::fs::read_dir(here).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    left.sort();
    assert_eq!(left, ["cut.ovl", "empty.ovl", "other.ovl", "scene.ovl"]);
}
