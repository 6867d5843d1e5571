//! Simulators and generators of training data.

use glam::DVec2;

use super::*;

const CENTERED: Intrinsics = Intrinsics { fy: 60.0, cx: 32.0, cy: 24.0, ..LENS };

fn opengl(camera: &Camera) -> DAffine3 {
    camera.world_from_camera * DAffine3::from_scale(glam::DVec3::new(1.0, -1.0, -1.0))
}

/// Distances along the rays.
fn distances(camera: &Camera) -> Vec<f32> {
    let (width, _) = camera.intrinsics.size();
    let ray = |index: usize| {
        let pixel = DVec2::new((index % width) as f64 + 0.5, (index / width) as f64 + 0.5);
        camera.intrinsics.ray_in_camera(pixel).length()
    };
    scene::depths(camera).iter().enumerate().map(|(index, depth)| (depth * ray(index)) as f32).collect()
}

fn npy(values: &[f32]) -> Vec<u8> {
    let header = "{'descr': '<f4', 'fortran_order': False, 'shape': (48, 64), }";
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend(values.iter().flat_map(|value| value.to_le_bytes()));
    bytes
}

#[test]
fn bop_is_in_millimeters_from_world_to_camera() {
    let folder = Folder::new();
    let mut images = json!({});
    for (step, camera) in cameras(LENS).iter().enumerate() {
        let number = step * 3;
        folder.put(
            &format!("rgb/{number:06}.{}", ["png", "jpg", "png"][step]),
            &color(camera, [ImageFormat::Png, ImageFormat::Jpeg, ImageFormat::Png][step]),
        );
        folder.put(&format!("depth/{number:06}.png"), &depth_png(camera, 10_000.0));
        let rows = scene::rows(&camera.world_from_camera.inverse());
        let rotation: Vec<f64> = rows[..12].chunks(4).flat_map(|row| row[..3].to_vec()).collect();
        let translation: Vec<f64> = rows[..12].chunks(4).map(|row| row[3] * 1000.0).collect();
        let k = [LENS.fx, 0.0, LENS.cx - 0.5, 0.0, LENS.fy, LENS.cy - 0.5, 0.0, 0.0, 1.0];
        images[number.to_string()] =
            json!({"cam_K": k, "depth_scale": 0.1, "cam_R_w2c": rotation, "cam_t_w2c": translation});
    }
    folder.put("scene_camera.json", images.to_string().as_bytes());
    check(&folder, "BOP");
    folder.put("scene_camera.json", b"{\"0\": {\"cam_K\": [1,0,1,0,1,1,0,0,1], \"depth_scale\": 1}}");
    assert!(refusal(&folder).contains("no image has cam_R_w2c"), "{}", refusal(&folder));
    folder.put("scene_camera.json", b"{\n\"0\": {\"cam_K\": [1]}}");
    assert!(
        refusal(&folder).contains("scene_camera.json: ") && refusal(&folder).contains("line 2"),
        "{}",
        refusal(&folder)
    );
}

#[test]
fn isaac_has_matrices_behind_rows_and_either_kind_of_distance() {
    let folder = Folder::new();
    for (step, camera) in cameras(LENS).iter().enumerate() {
        folder.put(&format!("Camera_{step}/rgb_0000.png"), &color(camera, ImageFormat::Png));
        let planar: Vec<f32> = scene::depths(camera).iter().map(|depth| *depth as f32).collect();
        let (name, values) = if step == 1 { ("image_plane", planar) } else { ("camera", distances(camera)) };
        folder.put(&format!("Camera_{step}/distance_to_{name}_0000.npy"), &npy(&values));
        // Poses are in centimeters here.
        let mut pose = opengl(camera);
        pose.translation *= 100.0;
        let w2c = scene::rows(&pose.inverse());
        let view: Vec<f64> = (0..16).map(|index| w2c[index % 4 * 4 + index / 4]).collect();
        let mut projection = [0.0; 16];
        (projection[0], projection[5]) = (LENS.fx / 32.0, LENS.fy / 24.0);
        (projection[8], projection[9]) = (1.0 - LENS.cx / 32.0, LENS.cy / 24.0 - 1.0);
        (projection[11], projection[14]) = (-1.0, 1.0);
        let camera = json!({
            "cameraViewTransform": view, "cameraProjection": projection, "renderProductResolution": [64, 48],
            "metersPerSceneUnit": 0.01,
        });
        folder.put(&format!("Camera_{step}/camera_params_0000.json"), camera.to_string().as_bytes());
    }
    check(&folder, "Isaac");
    folder.put("Camera_1/camera_params_0000.json", b"{\"cameraViewTransform\": 1}");
    check_one_left_out(&folder, "whose camera cannot be read (first: Camera_1/camera_params_0000.json)");
}

#[test]
fn kubric_measures_along_rays() {
    let folder = Folder::new();
    let (mut positions, mut quaternions) = (Vec::new(), Vec::new());
    for (step, camera) in cameras(CENTERED).iter().enumerate() {
        folder.put(&format!("rgba_{step:05}.png"), &color(camera, ImageFormat::Png));
        let mut tiff = std::io::Cursor::new(Vec::new());
        let mut encoder = tiff::encoder::TiffEncoder::new(&mut tiff).unwrap();
        encoder.write_image::<tiff::encoder::colortype::Gray32Float>(64, 48, &distances(camera)).unwrap();
        folder.put(&format!("depth_{step:05}.tiff"), &tiff.into_inner());
        let [x, y, z, qx, qy, qz, qw] = quaternion(&opengl(camera));
        positions.push([x, y, z]);
        quaternions.push([qw, qx, qy, qz]);
    }
    let metadata = json!({"camera": {"positions": positions, "quaternions": quaternions, "focal_length": 30.0, "sensor_width": 32.0}});
    folder.put("metadata.json", metadata.to_string().as_bytes());
    check(&folder, "Kubric");
    assert!(Source::find(&folder.path("")).unwrap().description().is_recording);
    folder.put("metadata.json", b"{\"camera\": {}}");
    assert!(refusal(&folder).contains("metadata.json: missing field `positions`"), "{}", refusal(&folder));
}

#[test]
fn as_many_views_are_read_as_are_asked_for_spread_evenly_over_all() {
    let folder = Folder::new();
    let (mut positions, mut quaternions) = (Vec::new(), Vec::new());
    for (index, step) in [0, 0, 0, 0, 0, 2, 4].into_iter().enumerate() {
        let camera = scene::camera(step, CENTERED);
        folder.put(&format!("rgba_{index:05}.png"), &color(&camera, ImageFormat::Png));
        let mut tiff = std::io::Cursor::new(Vec::new());
        let mut encoder = tiff::encoder::TiffEncoder::new(&mut tiff).unwrap();
        encoder.write_image::<tiff::encoder::colortype::Gray32Float>(64, 48, &distances(&camera)).unwrap();
        folder.put(&format!("depth_{index:05}.tiff"), &tiff.into_inner());
        let [x, y, z, qx, qy, qz, qw] = quaternion(&opengl(&camera));
        positions.push([x, y, z]);
        quaternions.push([qw, qx, qy, qz]);
    }
    let metadata = json!({"camera": {"positions": positions, "quaternions": quaternions, "focal_length": 30.0, "sensor_width": 32.0}});
    folder.put("metadata.json", metadata.to_string().as_bytes());
    let names = |views: u32| -> Vec<String> {
        let settings = CaptureSettings { views, ..CaptureSettings::default() };
        let capture = capture::open(&folder.path(""), &settings).unwrap();
        for camera in 0..capture.cameras.len() {
            capture.frame(camera, 0).unwrap();
        }
        capture.cameras.iter().map(|camera| camera.name.clone()).collect()
    };
    assert_eq!((names(0).len(), names(9).len()), (7, 7));
    assert_eq!(names(3), ["rgba_00000", "rgba_00002", "rgba_00004"]);
}
