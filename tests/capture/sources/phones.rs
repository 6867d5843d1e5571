//! Apps of phones with a depth sensor: small depth beside large color, confidence, `ARKit`'s axes.

use glam::DVec3;

use super::*;

/// Depth has half the pixels of color.
const SMALL: Intrinsics = Intrinsics { fy: 29.0, cx: 16.25, cy: 11.5, ..Intrinsics::centered(32, 24, 30.0) };

/// Up of `ARKit`'s world is y: the scene lies on its back, and cameras look along −z.
fn arkit(camera: &Camera) -> DAffine3 {
    let turn = DAffine3::from_rotation_x(-std::f64::consts::FRAC_PI_2);
    turn * camera.world_from_camera * DAffine3::from_scale(DVec3::new(1.0, -1.0, -1.0))
}

/// Opens the folder, and turns its world back to that of the scene.
fn check_arkit(folder: &Folder, source: &str) {
    let found = Source::find(&folder.path("")).unwrap();
    assert!(found.description().source.contains(source) && found.description().is_recording);
    let capture = found.open(&CaptureSettings::default()).unwrap();
    assert_eq!(capture.up_in_world, DVec3::Y);
    let turn = DAffine3::from_rotation_x(std::f64::consts::FRAC_PI_2);
    let capture = capture.with_changed_cameras(|_, camera| {
        camera.world_from_camera = turn * camera.world_from_camera;
    });
    scene::check(&capture, VIEWS, LENS.fx / SMALL.fx);
}

fn confidence(values: [u8; 2]) -> Vec<u8> {
    // The last row is what the sensor is unsure of.
    let [low, high] = values;
    let level = |index: usize| if index < 32 * 23 { high } else { low };
    let image: ImageBuffer<Luma<u8>, _> =
        ImageBuffer::from_raw(32, 24, (0..32 * 24).map(level).collect()).unwrap();
    picture(&image.into(), ImageFormat::Png)
}

/// An EXR file of half floats in one channel `R`.
fn exr_of_r(camera: &Camera) -> Vec<u8> {
    use exr::prelude::*;
    let samples = scene::depths(camera).into_iter().map(f16::from_f64).collect();
    let channel = AnyChannel::new("R", FlatSamples::F16(samples));
    let layer = Layer::new(
        (32, 24),
        LayerAttributes::default(),
        Encoding::SMALL_LOSSLESS,
        AnyChannels::sort(SmallVec::from_vec(vec![channel])),
    );
    let mut bytes = std::io::Cursor::new(Vec::new());
    Image::from_layer(layer).write().to_buffered(&mut bytes).unwrap();
    bytes.into_inner()
}

#[test]
fn record3d_poses_are_counted_by_the_names_of_files() {
    let folder = Folder::new();
    let mut poses = vec![[0.0, 0.0, 0.0, 1.0, 9.0, 9.0, 9.0]; VIEWS + 3];
    for step in 0..VIEWS {
        folder.put(
            &format!("EXR_RGBD/rgb/{}.jpg", step + 2),
            &color(&scene::camera(step, LENS), ImageFormat::Jpeg),
        );
        folder.put(&format!("EXR_RGBD/depth/{}.exr", step + 2), &exr_of_r(&scene::camera(step, SMALL)));
        let [x, y, z, qx, qy, qz, qw] = quaternion(&arkit(&scene::camera(step, LENS)));
        poses[step + 2] = [qx, qy, qz, qw, x, y, z];
    }
    folder.put("EXR_RGBD/rgb/1.jpg", &color(&scene::camera(0, LENS), ImageFormat::Jpeg));
    let k = [LENS.fx, 0.0, 0.0, 0.0, LENS.fy, 0.0, LENS.cx, LENS.cy, 1.0];
    let metadata = |poses: &[[f64; 7]]| {
        json!({"w": 64, "h": 48, "dw": 32, "dh": 24, "fps": 60, "K": k, "poses": poses, "cameraType": 1})
            .to_string()
    };
    folder.put("EXR_RGBD/metadata.json", metadata(&poses).as_bytes());
    assert_eq!(Source::find(&folder.path("")).unwrap().description().skipped[0].first, "1.jpg");
    check_arkit(&folder, "Record3D");
    folder.put("EXR_RGBD/metadata.json", metadata(&poses[..2]).as_bytes());
    assert!(refusal(&folder).contains("all poses are the same"), "{}", refusal(&folder));
    folder.put("EXR_RGBD/metadata.json", b"{\"K\": [1,");
    assert!(refusal(&folder).contains("metadata.json: EOF") && refusal(&folder).contains("line 1"));
}

#[test]
fn polycam_takes_the_corrected_pictures_and_drops_what_the_sensor_is_unsure_of() {
    let folder = Folder::new();
    for step in 0..VIEWS {
        let (camera, stamp) = (scene::camera(step, LENS), 1_641_000_000 + step * 33);
        let at = |name: &str, ending: &str| format!("keyframes/{name}/{stamp}.{ending}");
        folder.put(&at("corrected_images", "jpg"), &color(&camera, ImageFormat::Jpeg));
        folder.put(&at("images", "jpg"), b"not looked at");
        folder.put(&at("cameras", "json"), b"not looked at");
        folder.put(&at("depth", "png"), &depth_png(&scene::camera(step, SMALL), 1000.0));
        folder.put(&at("confidence", "png"), &confidence([0, 255]));
        let rows = scene::rows(&arkit(&camera));
        let mut keys = json!({"fx": LENS.fx, "fy": LENS.fy, "cx": LENS.cx, "cy": LENS.cy, "width": 64, "height": 48, "blur_score": 90.5});
        for (index, value) in rows[..12].iter().enumerate() {
            keys[format!("t_{}{}", index / 4, index % 4)] = json!(value);
        }
        folder.put(&at("corrected_cameras", "json"), keys.to_string().as_bytes());
    }
    check_arkit(&folder, "Polycam");
    let frame = open(&folder).unwrap().frame(0, 0).unwrap();
    assert!(frame.inverse_depth[(30, 47)] < 0.0 && frame.inverse_depth[(30, 40)] > 0.0);
    folder.put("keyframes/corrected_cameras/1641000033.json", b"{\"fx\": 1}");
    check_one_left_out(&folder, "whose camera cannot be read (first: 1641000033.json)");
}

#[test]
fn scanner_app_has_a_lens_in_every_frame_and_fewer_pictures_than_depth() {
    let folder = Folder::new();
    for step in 0..VIEWS {
        let camera = scene::camera(step, LENS);
        let number = format!("{:05}", step * 6);
        folder.put(&format!("frame_{number}.jpg"), &color(&camera, ImageFormat::Jpeg));
        folder.put(&format!("depth_{number}.png"), &depth_png(&scene::camera(step, SMALL), 1000.0));
        folder.put(&format!("conf_{number}.png"), &confidence([0, 2]));
        let k = [LENS.fx, 0.0, LENS.cx, 0.0, LENS.fy, LENS.cy, 0.0, 0.0, 1.0];
        let frame = json!({"cameraPoseARFrame": scene::rows(&arkit(&camera)), "intrinsics": k, "time": 12.5});
        folder.put(&format!("frame_{number}.json"), frame.to_string().as_bytes());
        folder.put(&format!("depth_{:05}.png", step * 6 + 1), b"no color is here");
    }
    folder.put("info.json", b"{}");
    check_arkit(&folder, "3D Scanner App");
    folder.put("frame_00006.json", b"{\"cameraPoseARFrame\": [1], \"intrinsics\": []}");
    check_one_left_out(
        &folder,
        "whose intrinsics are not 9 numbers, or cameraPoseARFrame not 16 (first: frame_00006.json)",
    );
}
