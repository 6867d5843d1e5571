//! MPEG immersive video: what is exported is read by the formulas of TMIV and RVS alone, and what is written by them is read.

use crate::command;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicUsize;
use std::sync::atomic::Ordering::Relaxed;

use crate::scene::{Scene, arc};
use glam::{DAffine3, DMat3, DVec2, DVec3};
use overlook_engine::capture::miv::write_sequence;
use overlook_engine::capture::{self, Camera, Capture, CaptureParts, Frame, FrameSource};
use overlook_engine::color::srgb_from_linear;
use overlook_engine::error::{Error, Result};
use overlook_engine::job::Job;
use overlook_engine::settings::CaptureSettings;
use serde_json::{Value, json};

const FRAMES: usize = 2;
/// The far plane of the sequence that others wrote.
const FAR: f64 = 40.0;

fn recorded() -> Capture {
    Scene::still_life().record(arc(3, 64), FRAMES)
}

/// A point, by the formulas of the format alone; `None` at infinity and where there is no depth.
fn point(folder: &Path, sequence: &Value, camera: usize, frame: usize, at: (usize, usize)) -> Option<DVec3> {
    let content = sequence["Content_name"].as_str().unwrap();
    let camera = &sequence["cameras"][camera];
    let name = camera["Name"].as_str().unwrap();
    let number = |value: &Value| value.as_f64().unwrap();
    let [width, height] = [0, 1].map(|index| camera["Resolution"][index].as_u64().unwrap() as usize);
    let bits = camera["BitDepthDepth"].as_u64().unwrap();
    let video = folder.join(content).join(format!("{name}_depth_{width}x{height}_yuv420p{bits}le.yuv"));
    let bytes = std::fs::read(video).unwrap();
    let byte = frame * width * height * 3 / 2 * 2 + 2 * (at.1 * width + at.0);
    let level = u16::from_le_bytes([bytes[byte], bytes[byte + 1]]);
    if level == 0 && camera["HasInvalidDepth"] == json!(true) {
        return None;
    }
    let share = f64::from(level) / f64::from((1_u32 << bits) - 1);
    let near = number(&camera["Depth_range"][0]);
    let far = camera["Depth_range"][1].as_f64().unwrap_or(f64::INFINITY);
    let x = 1.0 / (1.0 / far + share * (1.0 / near - 1.0 / far));
    // u = cx − fx · Y / X, v = cy − fy · Z / X, pixel centers at +0.5.
    let y = (number(&camera["Principle_point"][0]) - at.0 as f64 - 0.5) * x / number(&camera["Focal"][0]);
    let z = (number(&camera["Principle_point"][1]) - at.1 as f64 - 0.5) * x / number(&camera["Focal"][1]);
    let [yaw, pitch, roll] = [0, 1, 2].map(|index| number(&camera["Rotation"][index]).to_radians());
    let turned = DMat3::from_rotation_z(yaw) * DMat3::from_rotation_y(pitch) * DMat3::from_rotation_x(roll);
    let position = DVec3::from([0, 1, 2].map(|index| number(&camera["Position"][index])));
    x.is_finite().then(|| turned * DVec3::new(x, y, z) + position)
}

/// The point of a pixel of a capture.
fn own_point(capture: &Capture, camera: usize, frame: usize, at: (usize, usize)) -> Option<DVec3> {
    let inverse = f64::from(capture.frame(camera, frame).unwrap().inverse_depth[at]);
    let pixel = DVec2::new(at.0 as f64 + 0.5, at.1 as f64 + 0.5);
    (inverse > 0.0).then(|| capture.cameras[camera].unproject(pixel, inverse.recip()))
}

fn footprint(camera: &Camera, point: DVec3) -> f64 {
    camera.project(point).map_or(f64::NAN, |(_, depth)| depth / camera.intrinsics.fx)
}

#[test]
fn what_is_exported_gives_the_same_points_by_the_formats_own_formulas() {
    let folder = tempfile::tempdir().unwrap();
    let capture = recorded();
    write_sequence(folder.path(), "still", &capture, &Job::new()).unwrap();
    let sequence: Value =
        serde_json::from_slice(&std::fs::read(folder.path().join("still.json")).unwrap()).unwrap();
    let read = capture::open(folder.path(), &CaptureSettings::default()).unwrap();
    assert_eq!((read.cameras.len(), read.frame_count()), (3, FRAMES));
    let mut compared = 0;
    for (index, camera) in capture.cameras.iter().enumerate() {
        for frame in 0..FRAMES {
            for at in (0..64 * 64).step_by(37).map(|pixel| (pixel % 64, pixel / 64)) {
                let own = own_point(&capture, index, frame, at);
                let theirs = point(folder.path(), &sequence, index, frame, at);
                let again = own_point(&read, index, frame, at);
                assert_eq!((own.is_some(), own.is_some()), (theirs.is_some(), again.is_some()), "{at:?}");
                let (Some(own), Some(theirs), Some(again)) = (own, theirs, again) else { continue };
                let near = 0.1 * footprint(camera, own);
                assert!(own.distance(theirs) < near && own.distance(again) < near, "{index} {at:?}");
                compared += 1;
            }
        }
        let (written, back) = (capture.frame(index, 0).unwrap(), read.frame(index, 0).unwrap());
        // Color is halved both ways, luma is not.
        let luma = |color: &[half::f16; 3]| {
            let [red, green, blue] = color.map(|value| srgb_from_linear(value.to_f32()));
            0.299 * red + 0.587 * green + 0.114 * blue
        };
        let off = |(a, b): (&[half::f16; 3], &[half::f16; 3])| (luma(a) - luma(b)).abs();
        let pairs = written.color.as_slice().iter().zip(back.color.as_slice());
        let mean = pairs.map(off).sum::<f32>() / (64.0 * 64.0);
        assert!(mean < 2.0 / 1023.0, "two steps of 10 bits: {mean}");
    }
    assert!(compared > 300, "{compared}");
}

#[test]
fn a_world_whose_up_is_not_z_is_turned() {
    let folder = tempfile::tempdir().unwrap();
    let turn = DAffine3::from_rotation_x(-std::f64::consts::FRAC_PI_2);
    let up_in_world = turn.transform_vector3(DVec3::Z);
    let parts = CaptureParts { up_in_world, ..(*recorded()).clone() };
    let capture = Capture::new(parts, 64 << 20).with_changed_cameras(|_, camera| {
        camera.world_from_camera = turn * camera.world_from_camera;
    });
    write_sequence(folder.path(), "turned", &capture, &Job::new()).unwrap();
    let read = capture::open(folder.path(), &CaptureSettings::default()).unwrap();
    for (read, original) in read.cameras.iter().zip(recorded().cameras.iter()) {
        assert!(read.world_from_camera.abs_diff_eq(original.world_from_camera, 1e-6));
    }
}

/// The second frame of the scene as other programs write it: gray depth of 16 bits between finite planes, 0 for none, texture of 8
/// bits, one picture before the sequence begins, and a viewport.
fn written_by_others() -> (tempfile::TempDir, Capture) {
    let folder = tempfile::tempdir().unwrap();
    let capture = recorded();
    let (near, far) = (0.5, FAR);
    let mut cameras = vec![json!({"Name": "viewport", "Projection": "Equirectangular"})];
    std::fs::create_dir(folder.path().join("Still")).unwrap();
    for (index, camera) in capture.cameras.iter().enumerate() {
        let frame = capture.frame(index, 1).unwrap();
        // Forward, left and up of the camera in the world, as yaw, pitch and roll.
        let matrix = camera.world_from_camera.matrix3;
        let (forward, left, up) = (matrix.z_axis, -matrix.x_axis, -matrix.y_axis);
        let rotation = [
            forward.y.atan2(forward.x).to_degrees(),
            (-forward.z).asin().to_degrees(),
            left.z.atan2(up.z).to_degrees(),
        ];
        let lens = camera.intrinsics;
        cameras.push(json!({
            "Name": format!("v{index}"), "Position": camera.position_in_world().to_array(), "Rotation": rotation,
            "Resolution": [64, 64], "Projection": "Perspective", "Focal": [lens.fx, lens.fy],
            "Principle_point": [lens.cx, lens.cy], "Depth_range": [near, far], "BitDepthColor": 8,
            "BitDepthDepth": 16, "ColorSpace": "YUV420", "DepthColorSpace": "YUV400", "HasInvalidDepth": true,
        }));
        let level = |inverse: f32| {
            let share = (f64::from(inverse) - 1.0 / far) / (1.0 / near - 1.0 / far);
            if inverse > 0.0 { (share * 65_535.0).round().clamp(1.0, 65_535.0) as u16 } else { 0 }
        };
        let depth: Vec<u8> =
            frame.inverse_depth.as_slice().iter().flat_map(|inverse| level(*inverse).to_le_bytes()).collect();
        let texture = vec![128_u8; 64 * 64 * 3 / 2];
        let path = |kind: &str| folder.path().join(format!("Still/v{index}_{kind}.yuv"));
        let before = [vec![7; depth.len()], depth].concat();
        std::fs::write(path("depth_64x64_yuv400p16le"), before).unwrap();
        std::fs::write(path("texture_64x64_yuv420p"), [texture.clone(), texture].concat()).unwrap();
    }
    let sequence = json!({
        "Version": "4.0", "Content_name": "Still", "BoundingBox_center": [0, 0, 0], "Fps": 30, "Frames_number": 97,
        "frameRanges": [{"maxNumberOfFrames": 17, "startFrame": 1}], "lengthsInMeters": true, "cameras": cameras,
    });
    std::fs::write(folder.path().join("Still.json"), sequence.to_string()).unwrap();
    (folder, capture)
}

fn open(folder: &tempfile::TempDir) -> Result<Capture> {
    capture::open(folder.path(), &CaptureSettings::default())
}

#[test]
fn points_of_two_views_of_a_sequence_of_others_meet() {
    let (folder, original) = written_by_others();
    let read = open(&folder).unwrap();
    assert_eq!((read.cameras.len(), read.frame_numbers.as_slice()), (3, [1].as_slice()));
    let names: Vec<&str> = read.cameras.iter().map(|camera| camera.name.as_str()).collect();
    assert_eq!(names, ["v0", "v1", "v2"]);
    let mut compared = 0;
    for (index, camera) in original.cameras.iter().enumerate() {
        for at in (0..64 * 64).step_by(29).map(|pixel| (pixel % 64, pixel / 64)) {
            let (own, again) = (own_point(&original, index, 1, at), own_point(&read, index, 0, at));
            let Some((own, again)) = own.zip(again) else { continue };
            // What lies beyond the far plane was written as lying on it.
            if camera.project(own).is_none_or(|(_, depth)| depth > 0.9 * FAR) {
                continue;
            }
            assert!(own.distance(again) < 0.1 * footprint(camera, own), "{index} {at:?}: {own} {again}");
            compared += 1;
        }
    }
    assert!(compared > 150, "{compared}");
    let gray = read.frame(0, 0).unwrap().color[(3, 3)].map(half::f16::to_f32);
    assert!(gray.iter().all(|value| (value - 0.216).abs() < 0.01), "{gray:?}");
}

#[test]
fn what_is_wrong_with_a_sequence_is_told_in_one_line() {
    type Damage = fn(&mut Value);
    let damages: [(Damage, &str); 6] = [
        (|it| it["cameras"][1]["Projection"] = json!("Equirectangular"), "'v0' is 'Equirectangular'"),
        (|it| it["cameras"][2]["Depth_range"] = json!([2, 1]), "Depth_range of camera 'v1'"),
        (|it| it["sourceCameraNames"] = json!(["v9"]), "'v9'"),
        (|it| it["cameras"][1]["BitDepthDepth"] = json!(10), "v0_depth_64x64_yuv400p10le.yuv"),
        (|it| it["frameRanges"][0]["startFrame"] = json!(2), "before picture 2"),
        (|it| it["cameras"][1]["Resolution"] = json!("large"), "Still.json"),
    ];
    for (damage, expected) in damages {
        let (folder, _) = written_by_others();
        let path = folder.path().join("Still.json");
        let mut sequence: Value = serde_json::from_slice(&std::fs::read(&path).unwrap()).unwrap();
        damage(&mut sequence);
        std::fs::write(&path, sequence.to_string()).unwrap();
        let error = open(&folder).map(|_| ()).unwrap_err().to_string();
        assert!(error.contains(expected) && !error.contains('\n'), "{expected}: {error}");
    }
}

#[test]
fn the_command_exports_what_info_reads() {
    let folder = command::scene("2", "32x24");
    let export = ["export", "miv", "scene", "--out", "miv", "--name", "orrery"];
    command::succeed(command::overlook(folder.path(), &export));
    let info = command::succeed(command::overlook(folder.path(), &["info", "miv", "--json"]));
    let info: Value = serde_json::from_slice(&info.stdout).unwrap();
    assert_eq!((info["frames"].clone(), info["cameras"].as_array().unwrap().len()), (json!(2), 2));
    assert_eq!(info["conventions"]["is_warning"], json!(false), "{info}");
    let again = ["export", "miv", "miv", "--out", "miv", "--name", "orrery"];
    let refused = command::overlook(folder.path(), &again).output().unwrap();
    assert!(!refused.status.success(), "a capture is not written over itself");
}

/// The same recording, far from the origin.
fn recorded_at(place: DVec3) -> Capture {
    recorded().with_changed_cameras(|_, camera| camera.world_from_camera.translation += place)
}

#[test]
fn positions_far_from_the_origin_are_written_near_it_and_read_where_they_were() {
    let folder = tempfile::tempdir().unwrap();
    let capture = recorded_at(DVec3::new(447_512.25, 5_411_850.5, 312.0));
    write_sequence(folder.path(), "far", &capture, &Job::new()).unwrap();
    let sequence: Value =
        serde_json::from_slice(&std::fs::read(folder.path().join("far.json")).unwrap()).unwrap();
    for camera in sequence["cameras"].as_array().unwrap() {
        let position = DVec3::from([0, 1, 2].map(|index| camera["Position"][index].as_f64().unwrap()));
        assert!(position.length() < 100.0, "single precision holds it: {position}");
    }
    assert!(sequence["Overlook_world_offset"][1].as_f64().unwrap() > 5e6);
    let read = capture::open(folder.path(), &CaptureSettings::default()).unwrap();
    for (own, read) in capture.cameras.iter().zip(&read.cameras) {
        let apart = own.position_in_world().distance(read.position_in_world());
        assert!(apart < 1e-6, "{apart}");
    }
}

/// Frames that can be read so often.
struct Failing {
    recorded: Capture,
    left: AtomicUsize,
}

impl FrameSource for Failing {
    fn load(&self, camera: usize, frame: usize) -> Result<Frame> {
        if self.left.fetch_update(Relaxed, Relaxed, |left| left.checked_sub(1)).is_err() {
            return Err(Error::invalid(self.place(camera, frame), "the file is gone"));
        }
        Ok((*self.recorded.frame(camera, frame)?).clone())
    }

    fn place(&self, camera: usize, frame: usize) -> String {
        format!("camera {camera}, frame {frame}")
    }
}

#[test]
fn an_export_that_fails_leaves_nothing_and_spares_what_was_there() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("a/b");
    let job = Job::new();
    // Every frame is read for its extent, and once more to be written: the last of these reads fails.
    let failing = || {
        let reads = 2 * 3 * FRAMES - 1;
        let source = Arc::new(Failing { recorded: recorded(), left: AtomicUsize::new(reads) });
        Capture::new(CaptureParts { source, ..(*recorded()).clone() }, 0)
    };
    assert!(write_sequence(&out, "still", &failing(), &job).is_err());
    assert!(!folder.path().join("a").exists(), "folders that were made are removed");
    write_sequence(&out, "still", &recorded(), &job).unwrap();
    let names = || {
        let mut names: Vec<_> =
            std::fs::read_dir(out.join("still")).unwrap().map(|file| file.unwrap().file_name()).collect();
        names.sort();
        names
    };
    let before = names();
    assert!(write_sequence(&out, "still", &failing(), &job).is_err());
    assert!(out.join("still.json").is_file() && names() == before, "an earlier export stays whole");
}
