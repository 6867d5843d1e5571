//! COLMAP's dense workspaces.

use overlook_engine::capture::Projection;
use std::fmt::Write;

use super::*;

/// Every image has its own size and lens, as undistorted images have.
fn lens(step: usize) -> Intrinsics {
    let [width, height] = [[64, 48], [64, 47], [96, 72]][step];
    let focal = [60.0, 61.0, 90.0][step];
    let (cx, cy) = (f64::from(width) / 2.0 + 0.5, f64::from(height) / 2.0 - 0.25);
    Intrinsics { width, height, fx: focal, fy: focal - 1.0, cx, cy, projection: Projection::Perspective }
}

/// A lens of half the pixels, where maps are made no larger than so much.
fn halved(lens: Intrinsics) -> Intrinsics {
    let Intrinsics { width, height, fx, fy, cx, cy, .. } = lens;
    Intrinsics {
        fy: fy / 2.0,
        cx: cx / 2.0,
        cy: cy / 2.0,
        ..Intrinsics::centered(width / 2, height / 2, fx / 2.0)
    }
}

fn name(step: usize) -> String {
    format!("{}/shot {step}.jpg", ["left", "left", "right"][step])
}

fn map(lens: Intrinsics, channels: &[Vec<f64>]) -> Vec<u8> {
    let mut bytes = format!("{}&{}&{}&", lens.width, lens.height, channels.len()).into_bytes();
    bytes.extend(channels.iter().flatten().flat_map(|value| (*value as f32).to_le_bytes()));
    bytes
}

/// The pose as COLMAP has it: world to camera, quaternion with w first.
fn pose(camera: &Camera) -> [f64; 7] {
    let [x, y, z, qx, qy, qz, qw] = quaternion(&camera.world_from_camera.inverse());
    [qw, qx, qy, qz, x, y, z]
}

fn write_maps(folder: &Folder, root: &str, with_normals: bool) {
    for step in 0..VIEWS {
        let camera = scene::camera(step, lens(step));
        folder.put(&format!("{root}images/{}", name(step)), &color(&camera, ImageFormat::Jpeg));
        // The last map is smaller than its image.
        let seen = if step == 2 { scene::camera(step, halved(lens(step))) } else { camera };
        let mut depth = scene::depths(&seen);
        depth[5] = 0.0;
        let maps = format!("{root}stereo/depth_maps/{}", name(step));
        folder.put(&format!("{maps}.geometric.bin"), &map(seen.intrinsics, &[depth.clone()]));
        depth.fill(1e6);
        folder.put(&format!("{maps}.photometric.bin"), &map(seen.intrinsics, &[depth]));
        if with_normals {
            let turn = seen.world_from_camera.matrix3.transpose();
            let normals: Vec<_> = scene::normals(&seen).into_iter().map(|normal| turn * normal).collect();
            let channel = |axis: usize| normals.iter().map(|normal| normal[axis]).collect();
            let path = format!("{root}stereo/normal_maps/{}.geometric.bin", name(step));
            folder.put(&path, &map(seen.intrinsics, &[channel(0), channel(1), channel(2)]));
        }
    }
}

fn write_binary(folder: &Folder, model: &str) {
    let mut cameras = (VIEWS as u64).to_le_bytes().to_vec();
    let mut images = (VIEWS as u64).to_le_bytes().to_vec();
    for step in 0..VIEWS {
        let lens = lens(step);
        cameras.extend((step as i32 + 1).to_le_bytes());
        cameras.extend(1_i32.to_le_bytes());
        cameras.extend([lens.width, lens.height].iter().flat_map(|side| u64::from(*side).to_le_bytes()));
        cameras.extend([lens.fx, lens.fy, lens.cx, lens.cy].iter().flat_map(|value| value.to_le_bytes()));
        images.extend((step as i32 + 40).to_le_bytes());
        images.extend(pose(&scene::camera(step, lens)).iter().flat_map(|value| value.to_le_bytes()));
        images.extend((step as i32 + 1).to_le_bytes());
        images.extend(name(step).as_bytes());
        images.push(0);
        images.extend(2_u64.to_le_bytes());
        images.extend([3.0_f64, 4.0].iter().flat_map(|value| value.to_le_bytes()));
        images.extend((-1_i64).to_le_bytes());
        images.extend([0; 24]);
    }
    folder.put(&format!("{model}cameras.bin"), &cameras);
    folder.put(&format!("{model}images.bin"), &images);
    folder.put(&format!("{model}points3D.bin"), &0_u64.to_le_bytes());
}

fn write_text(folder: &Folder, model: &str) {
    let mut cameras = String::from("# Camera list with one line of data per camera:\n");
    let mut images = String::from("# Image list with two lines of data per image:\n");
    for step in 0..VIEWS {
        let Intrinsics { width, height, fx, fy, cx, cy, .. } = lens(step);
        writeln!(cameras, "{} PINHOLE {width} {height} {fx} {fy} {cx} {cy}", step + 1).unwrap();
        let pose = text(&pose(&scene::camera(step, lens(step))));
        writeln!(images, "{} {pose} {} {}", step + 40, step + 1, name(step)).unwrap();
        images.push_str(["3.5 4.5 -1 5.5 6.5 12\n", "\n", ""][step]);
    }
    folder.put(&format!("{model}cameras.txt"), cameras.as_bytes());
    folder.put(&format!("{model}images.txt"), images.as_bytes());
}

#[test]
fn a_dense_workspace_opens_with_normals_and_every_image_of_its_own_size() {
    let folder = Folder::new();
    write_maps(&folder, "", true);
    write_binary(&folder, "sparse/");
    check_coarse(&folder, "COLMAP", 2.0);
    let capture = open(&folder).unwrap();
    assert!(capture.has_normals);
    let (frame, camera) = (capture.frame(0, 0).unwrap(), scene::camera(0, lens(0)));
    let normals = frame.normal_in_world.as_ref().unwrap();
    for (found, real) in normals.as_slice().iter().zip(scene::normals(&camera)) {
        let found = glam::Vec3::from(*found).as_dvec3();
        assert!(found.length() < 0.5 || found.dot(real) > 0.999, "{found} {real}");
    }
    assert!(frame.inverse_depth[(5, 0)] < 0.0, "0 is no depth");
    assert!(capture.up_in_world.z > 0.9, "{}", capture.up_in_world);
    let source = Source::find(&folder.path("")).unwrap();
    assert!(source.description().up_is_estimated, "COLMAP stores none");
}

#[test]
fn text_models_and_numbered_folders_are_found_from_every_place() {
    let folder = Folder::new();
    write_maps(&folder, "dense/0/", false);
    write_text(&folder, "dense/0/sparse/");
    write_binary(&folder, "sparse/0/");
    for place in ["", "dense", "dense/0", "dense/0/sparse", "dense/0/sparse/images.txt"] {
        let capture = capture::open(&folder.path(place), &CaptureSettings::default()).unwrap();
        scene::check(&capture, VIEWS, 2.0);
        assert!(!capture.has_normals);
    }
}

#[test]
fn a_sparse_model_alone_says_how_depth_is_computed() {
    let folder = Folder::new();
    write_binary(&folder, "sparse/0/");
    let said = refusal(&folder);
    assert!(said.contains("colmap image_undistorter") && said.contains("patch_match_stereo"), "{said}");
}

#[test]
fn damaged_models_and_maps_name_file_and_byte_or_line() {
    let folder = Folder::new();
    write_maps(&folder, "", false);
    write_binary(&folder, "sparse/");
    let whole = std::fs::read(folder.path("sparse/images.bin")).unwrap();
    folder.put("sparse/images.bin", &whole[..whole.len() - 3]);
    assert!(refusal(&folder).contains("sparse/images.bin: byte "), "{}", refusal(&folder));
    folder.put("sparse/images.bin", &whole);
    let path = format!("stereo/depth_maps/{}.geometric.bin", name(1));
    let map = std::fs::read(folder.path(&path)).unwrap();
    folder.put(&path, &map[..map.len() - 1]);
    let said = open(&folder).unwrap().warnings.join("\n");
    assert!(said.contains("left out: 1 that cannot be read"), "{said}");
    assert!(said.contains(&path) && said.contains("bytes of values"), "{said}");
    folder.put("sparse/cameras.bin", &0_u64.to_le_bytes());
    assert!(refusal(&folder).contains("is of camera 1, which cameras does not list"), "{}", refusal(&folder));
    for name in ["cameras.bin", "images.bin"] {
        std::fs::remove_file(folder.path(&format!("sparse/{name}"))).unwrap();
    }
    write_text(&folder, "sparse/");
    folder.put("sparse/cameras.txt", b"# \n1 PINHOLE 64 48 60\n");
    assert!(refusal(&folder).contains("cameras.txt, line 2: there are 1 parameters"), "{}", refusal(&folder));
}
