//! MPEG immersive video: what others write is read by the formulas of TMIV and RVS.

use crate::scene::{Scene, arc};
use glam::{DVec2, DVec3};
use overlook_engine::capture::{self, Camera, Capture};
use overlook_engine::error::Result;
use overlook_engine::settings::CaptureSettings;
use serde_json::{Value, json};

const FRAMES: usize = 2;
/// The far plane of the sequence that others wrote.
const FAR: f64 = 40.0;

fn recorded() -> Capture {
    Scene::still_life().record(arc(3, 64), FRAMES)
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

/// Earlier versions of this program wrote cameras far from the origin so.
#[test]
fn an_offset_of_the_world_is_added_to_every_position() {
    let (folder, original) = written_by_others();
    let path = folder.path().join("Still.json");
    let mut sequence: Value = serde_json::from_slice(&std::fs::read(&path).unwrap()).unwrap();
    sequence["Overlook_world_offset"] = json!([447_512.0, 5_411_850.0, 312.0]);
    std::fs::write(&path, sequence.to_string()).unwrap();
    let offset = DVec3::new(447_512.0, 5_411_850.0, 312.0);
    for (own, read) in original.cameras.iter().zip(&open(&folder).unwrap().cameras) {
        let apart = (own.position_in_world() + offset).distance(read.position_in_world());
        assert!(apart < 1e-6, "{apart}");
    }
}
