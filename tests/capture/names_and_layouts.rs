//! Names that other systems take for the same, JSON as programs write it, and layouts that are told by name.

use crate::captures::{Folder, entry, flat, plain};
use overlook_engine::capture::{self, transforms};
use overlook_engine::settings::CaptureSettings;
use serde_json::json;

#[test]
fn names_match_whatever_their_case_and_composition_where_one_file_can_be_meant() {
    let folder = Folder::new();
    folder.put("Ra\u{308}ume/Left.EXR", &plain(flat(2.0)));
    let capture = folder.open(json!({}), &[entry("r\u{e4}ume/left.exr", "a", 0)]).unwrap();
    assert_eq!(capture.frame(0, 0).unwrap().inverse_depth[(0, 0)], 0.5);
    let places = transforms::picture_places(&folder.path("transforms.json")).unwrap();
    assert!(places.contains(&folder.path("Ra\u{308}ume/Left.EXR")), "what is read is never written over");
    folder.put("two.exr", &plain(flat(2.0)));
    folder.put("TWO.exr", &plain(flat(2.0)));
    let refused = folder.open(json!({}), &[entry("Two.exr", "a", 0)]).map(drop).unwrap_err().to_string();
    assert!(refused.contains("Two.exr is missing"), "{refused}");
}

#[test]
fn files_of_another_machines_paths_are_found_beside_the_manifest_with_a_warning() {
    let folder = Folder::new();
    folder.put("left/1.exr", &plain(flat(2.0)));
    for name in ["/no/such/home/left/1.exr", "C:\\Users\\me\\left\\1.exr"] {
        let capture = folder.open(json!({}), &[entry(name, "a", 0)]).unwrap();
        assert!(capture.frame(0, 0).is_ok());
        assert!(capture.warnings.iter().any(|warning| warning.contains("another machine")), "{name}");
    }
}

#[test]
fn manifests_open_as_windows_and_python_write_them() {
    let folder = Folder::new();
    folder.put("a.exr", &plain(flat(2.0)));
    let text = json!({"frames": [entry("a.exr", "a", 0)]}).to_string();
    let opens = |bytes: &[u8]| {
        folder.put("transforms.json", bytes);
        transforms::open(&folder.path(""), &CaptureSettings::default())
    };
    let wide: Vec<u8> =
        [0xFF, 0xFE].into_iter().chain(text.encode_utf16().flat_map(u16::to_le_bytes)).collect();
    assert!(opens(&wide).is_ok(), "UTF-16, as PowerShell's >");
    assert!(
        opens(text.replacen('{', "{\"sharpness\": NaN, ", 1).as_bytes()).is_ok(),
        "a key that is not read"
    );
    let refused =
        opens(text.replace("\"fl_x\":3.0", "\"fl_x\":NaN").as_bytes()).map(drop).unwrap_err().to_string();
    assert!(refused.contains("fl_x") && refused.contains("NaN"), "{refused}");
    let mut flat_pose = entry("a.exr", "a", 0);
    let rows: Vec<_> = flat_pose["transform_matrix"]
        .as_array()
        .unwrap()
        .iter()
        .flat_map(|row| row.as_array().unwrap().clone())
        .collect();
    flat_pose["transform_matrix"] = rows.into();
    assert!(folder.open(json!({}), &[flat_pose.clone()]).is_ok(), "sixteen numbers, row by row");
    flat_pose["transform_matrix"] = json!([1, 2, 3]);
    let refused = folder.open(json!({}), &[flat_pose]).map(drop).unwrap_err().to_string();
    assert!(refused.contains("transform_matrix") && refused.contains("rows"), "{refused}");
}

#[test]
fn layouts_that_are_not_read_are_told_by_name_in_a_sentence() {
    let folder = Folder::new();
    folder
        .put("transforms_train.json", json!({"frames": [entry("train/r_0", "a", 0)]}).to_string().as_bytes());
    folder.put("train/r_0.png", b"");
    let refusal = |folder: &Folder| {
        let refused = capture::open(&folder.path(""), &CaptureSettings::default()).map(drop).unwrap_err();
        let refused = refused.to_string();
        assert!(refused.len() < 600 && !refused.contains('\n'), "{refused}");
        refused
    };
    let refused = refusal(&folder);
    assert!(refused.contains("transforms_train.json") && refused.contains("depth_file_path"), "{refused}");
    let folder = Folder::new();
    folder.put("sequence.0/step0.frame_data.json", b"{}");
    let refused = refusal(&folder);
    assert!(refused.contains("SOLO") && refused.contains("transforms.json"), "{refused}");
}

#[test]
fn viewpoints_open_as_other_programs_list_them() {
    let folder = Folder::new();
    // At (1, 2, 3), looking along −z with y up.
    let pose = [[1.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 2.0], [0.0, 0.0, 1.0, 3.0], [0.0, 0.0, 0.0, 1.0]];
    let angle = (2.0 * (24.0_f64 / 60.0).atan()).to_degrees();
    let viewer = json!({
        "camera_type": "perspective", "render_height": 48, "render_width": 64, "seconds": 2, "fps": 24,
        "camera_path": [{"camera_to_world": pose.concat(), "fov": angle, "aspect": 1.33}],
    });
    folder.put("camera_path.json", viewer.to_string().as_bytes());
    let splats = json!([{
        "id": 0, "img_name": "a", "width": 64, "height": 48, "fx": 60, "fy": 60, "position": [1, 2, 3],
        "rotation": [[1, 0, 0], [0, -1, 0], [0, 0, -1]],
    }]);
    folder.put("cameras.json", splats.to_string().as_bytes());
    folder.put("colmap/sparse/0/cameras.txt", b"1 PINHOLE 64 48 60 60 32 24\n");
    // World to camera: half a turn about x, and what that leaves of the place.
    folder.put("colmap/sparse/0/images.txt", b"1 0 1 0 0 -1 2 3 1 a.png\n\n");
    for name in ["camera_path.json", "cameras.json", "colmap"] {
        let path = folder.path(name);
        let view = &transforms::open_views(&path).unwrap()[0];
        assert_eq!(view.camera.intrinsics.size(), (64, 48), "{name}");
        assert!((view.camera.intrinsics.fx - 60.0).abs() < 1e-6, "{name}");
        assert!(view.camera.position_in_world().abs_diff_eq(glam::DVec3::new(1.0, 2.0, 3.0), 1e-9), "{name}");
        let forward = view.camera.world_from_camera.transform_vector3(glam::DVec3::Z);
        assert!(forward.abs_diff_eq(glam::DVec3::NEG_Z, 1e-9), "{name}");
        let path = transforms::open_path(&path, false).unwrap();
        assert_eq!(path.views[0].camera.world_from_camera, view.camera.world_from_camera, "{name}");
        assert!(!path.names_frames && path.is_film == (name == "camera_path.json"), "{name}");
    }
    let mut panorama = viewer;
    panorama["camera_type"] = "equirectangular".into();
    folder.put("camera_path.json", panorama.to_string().as_bytes());
    let refused = transforms::open_views(&folder.path("camera_path.json")).map(drop).unwrap_err().to_string();
    assert!(refused.contains("equirectangular"), "{refused}");
}
