//! Renderers that write their cameras into the headers of OpenEXR files, and no manifest.

use exr::meta::attribute::{AttributeValue, Text};
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, SmallVec, WritableImage,
};
use glam::{DMat3, DVec3};

use super::*;

/// A file of the scene's color, and depth in units of which `per_meter` are one meter.
fn exr_of(camera: &Camera, depth: &str, per_meter: f64, attributes: &[(&str, AttributeValue)]) -> Vec<u8> {
    let Intrinsics { width, height, .. } = camera.intrinsics;
    let colors = scene::colors(camera);
    let plane = |index: usize| {
        FlatSamples::F32(
            colors.iter().skip(index).step_by(3).map(|value| f32::from(*value) / 255.0).collect(),
        )
    };
    let depths = scene::depths(camera).iter().map(|z| (z * per_meter) as f32).collect();
    let mut channels: Vec<_> = ["R", "G", "B"]
        .iter()
        .enumerate()
        .map(|(index, name)| AnyChannel::new(*name, plane(index)))
        .collect();
    channels.push(AnyChannel::new(depth, FlatSamples::F32(depths)));
    let mut layer = Layer::new(
        (width as usize, height as usize),
        LayerAttributes::default(),
        Encoding::SMALL_LOSSLESS,
        AnyChannels::sort(SmallVec::from_vec(channels)),
    );
    for (name, value) in attributes {
        match (*name, value) {
            ("worldToNDC", AttributeValue::Matrix4x4(matrix)) => {
                layer.attributes.world_to_normalized_device = Some(*matrix);
            }
            _ => drop(layer.attributes.other.insert(Text::from(*name), value.clone())),
        }
    }
    let mut bytes = std::io::Cursor::new(Vec::new());
    Image::from_layer(layer).write().to_buffered(&mut bytes).unwrap();
    bytes.into_inner()
}

/// Lens of a camera of which only a focal length is known.
const CENTERED: Intrinsics = Intrinsics { fx: 60.0, fy: 60.0, cx: 32.0, cy: 24.0, ..LENS };

/// A camera that is turned about its axis, as hands and cranes turn it.
fn rolled(step: usize) -> Camera {
    let mut camera = scene::camera(step, CENTERED);
    camera.world_from_camera *= DAffine3::from_rotation_z(0.1 * step as f64);
    camera
}

fn text_attribute(name: &'static str, value: f64) -> (&'static str, AttributeValue) {
    (name, AttributeValue::Text(Text::from(value.to_string().as_str())))
}

/// Unreal's attributes of a camera, the scene's world with x right, y forward, z up being the engine's y, x, z.
fn unreal(camera: &Camera) -> Vec<(&'static str, AttributeValue)> {
    // The engine's axes forward, right, up of the scene's world; and of the camera's right, down, forward.
    let engine = |p: DVec3| DVec3::new(p.y, p.x, p.z);
    let axes = camera.world_from_camera.matrix3;
    let (forward, right, up) = (engine(axes.z_axis), engine(axes.x_axis), engine(-axes.y_axis));
    let (yaw, pitch) = (forward.y.atan2(forward.x), forward.z.asin());
    // Without roll, right is level.
    let level = DVec3::new(-yaw.sin(), yaw.cos(), 0.0);
    let roll = (-right.z).atan2(up.z);
    assert!(right.dot(level) > 0.9);
    let at = engine(camera.position_in_world()) * 100.0;
    vec![
        text_attribute("unreal/camera/curPos/x", at.x),
        text_attribute("unreal/camera/curPos/y", at.y),
        text_attribute("unreal/camera/curPos/z", at.z),
        text_attribute("unreal/camera/curRot/yaw", yaw.to_degrees()),
        text_attribute("unreal/camera/curRot/pitch", pitch.to_degrees()),
        text_attribute("unreal/camera/curRot/roll", roll.to_degrees()),
        text_attribute("unreal/camera/FinalImage/focalLength", 22.5),
        text_attribute("unreal/camera/FinalImage/sensorWidth", 24.0),
    ]
}

/// Opens the folder and brings its world, of which y is `up`, back to the scene's.
fn check_turned(folder: &Folder, source: &str, scene_from_world: DMat3) {
    let found = Source::find(&folder.path("")).unwrap();
    assert!(found.description().source.contains(source), "{:?}", found.description());
    let capture = found.open(&CaptureSettings::default()).unwrap();
    assert!((scene_from_world * capture.up_in_world).abs_diff_eq(DVec3::Z, 1e-12));
    let capture = capture.with_changed_cameras(|_, camera| {
        camera.world_from_camera = DAffine3::from_mat3(scene_from_world) * camera.world_from_camera;
    });
    scene::check(&capture, VIEWS, 1.0);
}

#[test]
fn movie_render_queue_needs_no_manifest() {
    let folder = Folder::new();
    for step in 0..VIEWS {
        let camera = rolled(step);
        let bytes = exr_of(&camera, "FinalImageMovieRenderQueue_WorldDepth.R", 100.0, &unreal(&camera));
        folder.put(&format!("Camera{step}/shot.0007.exr"), &bytes);
    }
    // x right, y down, z forward, of a scene that has x right, y forward, z up.
    let scene_from_world = DMat3::from_cols(DVec3::X, DVec3::NEG_Z, DVec3::Y);
    check_turned(&folder, "Unreal", scene_from_world);
    let mut attributes = unreal(&rolled(0));
    attributes.retain(|(name, _)| !name.ends_with("yaw"));
    folder.put(
        "Camera0/shot.0007.exr",
        &exr_of(&rolled(0), "FinalImageMovieRenderQueue_WorldDepth.R", 100.0, &attributes),
    );
    check_one_left_out(&folder, "whose header cannot be read (first: Camera0/shot.0007.exr)");
}

#[test]
fn one_camera_that_flies_is_a_recording_and_several_are_refused() {
    let folder = Folder::new();
    let bytes = |step: usize| {
        exr_of(&rolled(step), "FinalImageMovieRenderQueue_WorldDepth.R", 100.0, &unreal(&rolled(step)))
    };
    for step in 0..VIEWS {
        folder.put(&format!("fly.{step:04}.exr"), &bytes(step));
    }
    assert!(Source::find(&folder.path("")).unwrap().description().is_recording);
    assert_eq!(open(&folder).unwrap().cameras.len(), VIEWS);
    for step in 0..VIEWS {
        folder.put(&format!("other.{step:04}.exr"), &bytes(0));
    }
    assert!(refusal(&folder).contains("the camera moved since frame 0"), "{}", refusal(&folder));
}

/// The matrix whose rows are before points: where world points go, `x` and `y` being of x, y and z of the camera.
fn world_to_picture(camera: &Camera, x: DVec3, y: DVec3) -> AttributeValue {
    let camera_from_world = camera.world_from_camera.inverse();
    let column = |f: DVec3| {
        let normal = camera_from_world.matrix3.transpose() * f;
        [normal.x, normal.y, normal.z, f.dot(camera_from_world.translation)]
    };
    let columns = [column(x), column(y), column(DVec3::Z), column(DVec3::Z)];
    let mut matrix = [0.0; 16];
    for (index, value) in matrix.iter_mut().enumerate() {
        *value = columns[index % 4][index / 4] as f32;
    }
    AttributeValue::Matrix4x4(matrix)
}

#[test]
fn arnold_and_karma_state_the_whole_projection() {
    let lens = Intrinsics { fy: LENS.fx, ..LENS };
    let (w, h) = (64.0, 48.0);
    let x = DVec3::new(lens.fx, 0.0, lens.cx) / w;
    let y = DVec3::Z - DVec3::new(0.0, lens.fx, lens.cy) / h;
    let double = |f: DVec3| 2.0 * f - DVec3::Z;
    for (name, depth, x, y) in [
        ("worldToScreen", "Z", double(x), double(y)),
        ("worldToScreen", "Z", double(x), double(y) * h / w),
        ("worldToNDC", "depth.V", x, y),
    ] {
        let folder = Folder::new();
        // y is up in these worlds.
        let turn = DAffine3::from_rotation_x(-std::f64::consts::FRAC_PI_2);
        for step in 0..VIEWS {
            let camera = scene::camera(step, lens);
            let mut turned = camera.clone();
            turned.world_from_camera = turn * camera.world_from_camera;
            let attribute = (name, world_to_picture(&turned, x, y));
            folder.put(
                &format!("cam{}_.0001.exr", ["a", "b", "c"][step]),
                &exr_of(&camera, depth, 1.0, &[attribute]),
            );
        }
        check_turned(&folder, "headers", turn.matrix3.transpose());
    }
    let folder = Folder::new();
    let attribute = ("worldToScreen", AttributeValue::Matrix4x4([0.0; 16]));
    folder.put("a.exr", &exr_of(&scene::camera(0, lens), "Z", 1.0, &[attribute]));
    assert!(refusal(&folder).contains("a.exr: worldToScreen in the header is no perspective camera's"));
}
