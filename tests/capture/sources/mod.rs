//! Folders as their programs write them open as what was seen: one analytic scene, written in the layout of every source.

mod colmap;
mod phones;
mod renderers;
mod rigs;
mod simulators;
mod up;

use crate::analytic_scene as scene;
use std::fmt::Write;

use crate::folder::Folder;
use glam::{DAffine3, DQuat};
use image::{DynamicImage, ImageBuffer, ImageFormat, Luma, Rgb};
use overlook_engine::capture::{self, Camera, Capture, Intrinsics, Source};
use overlook_engine::error::Result;
use overlook_engine::settings::CaptureSettings;
use serde_json::json;

const VIEWS: usize = 3;
/// With pixel centers at +0.5.
const LENS: Intrinsics = Intrinsics { fy: 58.0, cx: 32.5, cy: 23.0, ..Intrinsics::centered(64, 48, 60.0) };

fn picture(image: &DynamicImage, format: ImageFormat) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    image.write_to(&mut bytes, format).unwrap();
    bytes.into_inner()
}

fn color(camera: &Camera, format: ImageFormat) -> Vec<u8> {
    let Intrinsics { width, height, .. } = camera.intrinsics;
    let image: ImageBuffer<Rgb<u8>, _> = ImageBuffer::from_raw(width, height, scene::colors(camera)).unwrap();
    picture(&image.into(), format)
}

/// Depth in whole units, `per_unit` of them a meter.
fn whole(camera: &Camera, per_meter: f64) -> Vec<u16> {
    scene::depths(camera).iter().map(|depth| (depth * per_meter).round() as u16).collect()
}

fn depth_png(camera: &Camera, per_meter: f64) -> Vec<u8> {
    let Intrinsics { width, height, .. } = camera.intrinsics;
    let image: ImageBuffer<Luma<u16>, _> =
        ImageBuffer::from_raw(width, height, whole(camera, per_meter)).unwrap();
    picture(&image.into(), ImageFormat::Png)
}

fn cameras(lens: Intrinsics) -> Vec<Camera> {
    (0..VIEWS).map(|step| scene::camera(step, lens)).collect()
}

fn text(numbers: &[f64]) -> String {
    numbers.iter().map(f64::to_string).collect::<Vec<_>>().join(" ")
}

fn lines_of_four(numbers: &[f64]) -> String {
    numbers.chunks(4).map(|row| text(row) + "\n").collect()
}

fn quaternion(pose: &DAffine3) -> [f64; 7] {
    let q = DQuat::from_mat3(&pose.matrix3);
    let t = pose.translation;
    [t.x, t.y, t.z, q.x, q.y, q.z, q.w]
}

fn open(folder: &Folder) -> Result<Capture> {
    capture::open(&folder.path(""), &CaptureSettings::default())
}

/// Opens the folder, checks the scene, and that the manifest that it amounts to opens as the same capture.
fn check(folder: &Folder, source: &str) {
    check_coarse(folder, source, 1.0);
}

/// The same if a pixel of depth is `depth_pixel` pixels of color wide.
fn check_coarse(folder: &Folder, source: &str, depth_pixel: f64) {
    let found = Source::find(&folder.path("")).unwrap();
    assert!(found.description().source.contains(source), "{:?}", found.description());
    let capture = found.open(&CaptureSettings::default()).unwrap();
    scene::check(&capture, VIEWS, depth_pixel);
    let manifest = folder.path("elsewhere/again.json");
    std::fs::create_dir(manifest.parent().unwrap()).unwrap();
    found.write_manifest(&manifest).unwrap();
    assert!(found.write_manifest(&manifest).is_err(), "what is there is not replaced");
    let again = capture::open(&manifest, &CaptureSettings::default()).unwrap();
    assert_eq!(again.cameras, capture.cameras);
    assert_eq!(again.frame(1, 0).unwrap(), capture.frame(1, 0).unwrap());
}

/// Checks that one picture is left out for this reason, and that the others open.
fn check_one_left_out(folder: &Folder, reason: &str) {
    let source = Source::find(&folder.path("")).unwrap();
    let said = source.description().lines().join("\n");
    assert!(said.contains(&format!("left out: 1 {reason}")), "{said}");
    assert_eq!(source.open(&CaptureSettings::default()).unwrap().cameras.len(), VIEWS - 1);
}

fn refusal(folder: &Folder) -> String {
    let said = open(folder).map(drop).unwrap_err().to_string();
    assert!(!said.contains('\n'), "{said}");
    said
}

/// The lens that TUM's third sensor has, for pictures of its size cut to a tenth would be another: so in full size.
fn tum_lens() -> Intrinsics {
    Intrinsics { fy: 539.2, cx: 320.6, cy: 248.1, ..Intrinsics::centered(640, 480, 535.4) }
}

fn write_tum(folder: &Folder) {
    let (mut rgb, mut depth) = (String::from("# color images\n"), String::from("# depth maps\n"));
    let mut truth = String::from("# file: 'rgbd_dataset_freiburg3_test.bag'\n");
    for (step, camera) in cameras(tum_lens()).iter().enumerate() {
        let time = 100.0 + step as f64;
        folder.put(&format!("rgb/{step}.png"), &color(camera, ImageFormat::Png));
        folder.put(&format!("depth/{step}.png"), &depth_png(camera, 5000.0));
        writeln!(rgb, "{time} rgb/{step}.png").unwrap();
        writeln!(depth, "{} depth/{step}.png", time + 0.015).unwrap();
        writeln!(truth, "{} {}", time - 0.001, text(&quaternion(&camera.world_from_camera))).unwrap();
        writeln!(truth, "{} {}", time + 0.001, text(&quaternion(&camera.world_from_camera))).unwrap();
    }
    rgb.push_str("200 rgb/late.png\n");
    folder.put("rgb.txt", format!("# file: 'rgbd_dataset_freiburg3_test.bag'\n{rgb}").as_bytes());
    folder.put("depth.txt", depth.as_bytes());
    folder.put("groundtruth.txt", truth.as_bytes());
}

#[test]
fn tum_pairs_stamps_and_leaves_out_what_has_no_partner() {
    let folder = Folder::new();
    write_tum(&folder);
    let description = Source::find(&folder.path("")).unwrap().description().clone();
    assert_eq!((description.found, description.skipped[0].count), (VIEWS + 1, 1));
    assert_eq!(description.skipped[0].first, "rgb/late.png");
    check(&folder, "TUM");
    folder.put("groundtruth.txt", b"# truth\n100 1 2 3 0 0\n");
    assert!(refusal(&folder).contains("groundtruth.txt, line 2: there are 6 fields where 8 are expected"));
    folder.put("groundtruth.txt", b"100 1 2 x 0 0 0 1\n");
    assert!(refusal(&folder).contains("line 1: 'x' is no number"));
    folder.put("groundtruth.txt", b"100,5 1,0 2,25 -3,5 0,0 0,0 0,0 1,0\n");
    assert!(refusal(&folder).contains("line 1: numbers have decimal commas; write them with points"));
}

/// The sensor's default lens.
fn sensor() -> Intrinsics {
    Intrinsics::centered(640, 480, 525.0)
}

#[test]
fn redwood_poses_are_read_from_a_log_of_any_line_length_and_from_json() {
    let folder = Folder::new();
    let mut log = String::new();
    let mut parameters = Vec::new();
    for (step, camera) in cameras(LENS).iter().enumerate() {
        folder.put(&format!("color/{step:05}.jpg"), &color(camera, ImageFormat::Jpeg));
        folder.put(&format!("depth/{step:05}.png"), &depth_png(camera, 1000.0));
        let pose = scene::rows(&camera.world_from_camera);
        let pose = if step == 1 { text(&pose) + "\n" } else { lines_of_four(&pose) };
        write!(log, "{step} {step} {}\n{pose}", step + 1).unwrap();
        let w2c = scene::rows(&camera.world_from_camera.inverse());
        let columns: Vec<f64> = (0..16).map(|i| w2c[i % 4 * 4 + i / 4]).collect();
        parameters.push(json!({ "extrinsic": columns }));
    }
    let matrix = [LENS.fx, 0.0, 0.0, 0.0, LENS.fy, 0.0, LENS.cx - 0.5, LENS.cy - 0.5, 1.0];
    let lens = json!({"width": 64, "height": 48, "intrinsic_matrix": matrix});
    folder.put("trajectory.log", log.as_bytes());
    let refused = refusal(&folder);
    let size = "is of 640×480 pixels, while these pictures have 64×48";
    assert!(refused.contains(size) && refused.contains("it is 52.5 0 31.5 0 52.5 23.5"), "{refused}");
    let stated = text(&[LENS.fx, 0.0, LENS.cx - 0.5, 0.0, LENS.fy, LENS.cy - 0.5, 0.0, 0.0, 1.0]);
    folder.put("camera-intrinsics.txt", stated.as_bytes());
    scene::check(&open(&folder).unwrap(), VIEWS, 1.0);
    std::fs::remove_file(folder.path("camera-intrinsics.txt")).unwrap();
    folder.put("camera_intrinsic.json", lens.to_string().as_bytes());
    check(&folder, "Redwood");
    folder.put("trajectory.log", &log.as_bytes()[..log.len() - 9]);
    assert!(
        refusal(&folder).contains("trajectory.log: 15 numbers too many behind pose 2"),
        "{}",
        refusal(&folder)
    );
    std::fs::remove_file(folder.path("trajectory.log")).unwrap();
    folder.put("camera_trajectory.json", json!({ "parameters": parameters }).to_string().as_bytes());
    scene::check(&open(&folder).unwrap(), VIEWS, 1.0);
    folder.put("camera_trajectory.json", b"{\"parameters\": [");
    assert!(refusal(&folder).contains("line 1 column"));
}

#[test]
fn seven_scenes_is_read_from_its_sequences_and_65535_is_no_depth() {
    let folder = Folder::new();
    let lens = Intrinsics { fx: 585.0, fy: 585.0, cx: 320.5, cy: 240.5, ..sensor() };
    for (step, camera) in cameras(lens).iter().enumerate() {
        let base = format!("seq-01/frame-{step:06}");
        folder.put(&format!("{base}.color.png"), &color(camera, ImageFormat::Png));
        let mut depth = whole(camera, 1000.0);
        depth[0] = 65535;
        let image: ImageBuffer<Luma<u16>, _> = ImageBuffer::from_raw(640, 480, depth).unwrap();
        folder.put(&format!("{base}.depth.png"), &picture(&image.into(), ImageFormat::Png));
        let pose = lines_of_four(&scene::rows(&camera.world_from_camera));
        folder.put(&format!("{base}.pose.txt"), pose.as_bytes());
    }
    check(&folder, "7-Scenes");
    assert!(open(&folder).unwrap().frame(0, 0).unwrap().inverse_depth[(0, 0)] < 0.0);
    folder.put("seq-01/frame-000001.pose.txt", b"1 0 0 0\n0 1 0 0\n");
    check_one_left_out(
        &folder,
        "poses that are not 4 lines of 4 numbers (first: seq-01/frame-000001.pose.txt)",
    );
}

#[test]
fn scannet_depth_has_a_lens_and_a_size_of_its_own_and_lost_poses_are_left_out() {
    let folder = Folder::new();
    let small = Intrinsics { cx: 20.2, cy: 15.1, ..Intrinsics::centered(40, 30, 36.0) };
    for (step, camera) in cameras(LENS).iter().enumerate() {
        folder.put(&format!("color/{}.jpg", step * 9), &color(camera, ImageFormat::Jpeg));
        folder.put(&format!("depth/{}.png", step * 9), &depth_png(&scene::camera(step, small), 1000.0));
        let pose = lines_of_four(&scene::rows(&camera.world_from_camera));
        folder.put(&format!("pose/{}.txt", step * 9), pose.as_bytes());
    }
    folder.put("color/99.jpg", &color(&scene::camera(0, LENS), ImageFormat::Jpeg));
    folder.put("depth/99.png", &depth_png(&scene::camera(0, small), 1000.0));
    folder.put("pose/99.txt", "-inf -inf -inf -inf\n".repeat(4).as_bytes());
    for (name, lens) in [("color", LENS), ("depth", small)] {
        let k = [lens.fx, 0.0, lens.cx - 0.5, 0.0, 0.0, lens.fy, lens.cy - 0.5, 0.0];
        let k = [k.as_slice(), &[0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0]].concat();
        folder.put(&format!("intrinsic/intrinsic_{name}.txt"), lines_of_four(&k).as_bytes());
    }
    let description = Source::find(&folder.path("")).unwrap().description().clone();
    assert_eq!((description.skipped.len(), description.skipped[0].first.as_str()), (1, "99.jpg"));
    check_coarse(&folder, "ScanNet", LENS.fx / small.fx);
}

#[test]
fn replica_takes_its_unit_from_the_parameters_above() {
    let folder = Folder::new();
    let mut trajectory = String::new();
    for (step, camera) in cameras(LENS).iter().enumerate() {
        folder.put(&format!("results/frame{step:06}.jpg"), &color(camera, ImageFormat::Jpeg));
        folder.put(&format!("results/depth{step:06}.png"), &depth_png(camera, 6553.5));
        trajectory += &(text(&scene::rows(&camera.world_from_camera)) + "\n");
    }
    let parameters = json!({"camera": {"w": 64, "h": 48, "fx": LENS.fx, "fy": LENS.fy, "cx": LENS.cx - 0.5, "cy": LENS.cy - 0.5, "scale": 6553.5}});
    folder.put("cam_params.json", parameters.to_string().as_bytes());
    folder.put("traj.txt", trajectory.as_bytes());
    check(&folder, "Replica");
    folder.put("traj.txt", b"1 2 3\n");
    assert!(refusal(&folder).contains("traj.txt, line 1"));
}

#[test]
fn a_list_of_poses_beside_depth_in_pgm_is_a_recording() {
    let folder = Folder::new();
    let lens = Intrinsics { fx: 518.0, fy: 519.0, cx: 326.0, cy: 254.0, ..sensor() };
    let mut poses = String::new();
    for (step, camera) in cameras(lens).iter().enumerate() {
        folder.put(&format!("color/{}.png", step + 9), &color(camera, ImageFormat::Png));
        let samples = whole(camera, 1000.0).into_iter().flat_map(u16::to_be_bytes);
        let pgm: Vec<u8> = b"P5 640 480 65535\n".iter().copied().chain(samples).collect();
        folder.put(&format!("depth/{}.pgm", step + 9), &pgm);
        poses += &(text(&quaternion(&camera.world_from_camera)) + "\n");
    }
    folder.put("pose.txt", poses.as_bytes());
    check(&folder, "list of poses");
    folder.put("pose.txt", b"1 2 3\n");
    assert!(refusal(&folder).contains("pose.txt, line 1: the line has 3 numbers"));
    folder.put("pose.txt", poses.as_bytes());
    folder.put("depth/9.pgm", b"P5 640 480 65535\n12");
    let said = open(&folder).unwrap().warnings.join("\n");
    assert!(said.contains("left out: 1 that cannot be read"), "{said}");
    assert!(said.contains("2 bytes of samples where 614400 are needed"), "{said}");
}

/// A manifest of nerfstudio's of the scene, with depth in files of this ending.
fn manifest(folder: &Folder, keys: serde_json::Value, ending: &str) -> Result<Capture> {
    let entries: Vec<_> = cameras(LENS)
        .iter()
        .enumerate()
        .map(|(step, camera)| {
            folder.put(&format!("images/{step}.jpg"), &color(camera, ImageFormat::Jpeg));
            let rows = scene::rows(&camera.world_from_camera);
            let opengl = |row: &[f64]| vec![row[0], -row[1], -row[2], row[3]];
            let matrix: Vec<_> = rows.chunks(4).map(opengl).collect();
            json!({
                "file_path": format!("images\\{step}"), "depth_path": format!("depths\\{step}.{ending}"),
                "transform_matrix": matrix, "w": 64, "h": 48, "fl_x": LENS.fx, "fl_y": LENS.fy, "cx": LENS.cx,
                "cy": LENS.cy,
            })
        })
        .collect();
    let mut manifest = keys;
    manifest["frames"] = entries.into();
    folder.put("transforms.json", manifest.to_string().as_bytes());
    open(folder)
}

#[test]
fn nerfstudio_depth_may_be_smaller_in_numpy_or_tiff_and_its_unit_a_divisor() {
    let small = Intrinsics {
        fy: LENS.fy / 2.0,
        cx: LENS.cx / 2.0,
        cy: LENS.cy / 2.0,
        ..Intrinsics::centered(32, 24, LENS.fx / 2.0)
    };
    let folder = Folder::new();
    for step in 0..VIEWS {
        let camera = scene::camera(step, small);
        let meters: Vec<f32> = scene::depths(&camera).iter().map(|depth| *depth as f32).collect();
        let header = "{'descr': '<f4', 'fortran_order': False, 'shape': (24, 32), }";
        let mut npy = b"\x93NUMPY\x01\x00".to_vec();
        npy.extend((header.len() as u16).to_le_bytes());
        npy.extend(header.as_bytes());
        npy.extend(meters.iter().flat_map(|depth| depth.to_le_bytes()));
        folder.put(&format!("depths/{step}.npy"), &npy);
        let mut tiff = std::io::Cursor::new(Vec::new());
        let mut encoder = tiff::encoder::TiffEncoder::new(&mut tiff).unwrap();
        encoder.write_image::<tiff::encoder::colortype::Gray32Float>(32, 24, &meters).unwrap();
        folder.put(&format!("depths/{step}.tiff"), &tiff.into_inner());
        folder.put(&format!("depths/{step}.png"), &depth_png(&camera, 4000.0));
    }
    scene::check(&manifest(&folder, json!({"depth_unit_scale_factor": 1}), "npy").unwrap(), VIEWS, 2.0);
    scene::check(&manifest(&folder, json!({"depth_scale": 1.0}), "tiff").unwrap(), VIEWS, 2.0);
    scene::check(&manifest(&folder, json!({"depth_scale": 4000.0}), "png").unwrap(), VIEWS, 2.0);
    scene::check(&manifest(&folder, json!({"depth_integer_scale": 0.00025}), "png").unwrap(), VIEWS, 2.0);
}

#[test]
fn sources_that_another_program_has_to_convert_say_how() {
    for (name, advice) in [
        ("a.mkv", "azure_kinect_mkv_reader.py"),
        ("a.bag", "rs-convert"),
        ("a.sens", "reader.py --filename"),
        ("a.r3d", "as \"EXR + RGB\", and open the folder EXR_RGBD"),
        ("A.SVO2", "export_svo.py FILE.svo2 FOLDER 4"),
        ("a.svo", "export_svo.py FILE.svo FOLDER 4"),
        ("a.mcap", "ROS 2"),
        ("a.db3", "ROS 2"),
        ("a.oni", "OpenNI"),
        ("a.mov", "holds no depth"),
        ("a.mp4", "ffmpeg -i FILE.mp4"),
    ] {
        let folder = Folder::new();
        folder.put(name, b"12345678");
        let said = refusal(&folder);
        assert!(said.contains(advice) && said.contains(name) && !said.contains('\n'), "{said}");
    }
    let folder = Folder::new();
    folder.put("odometry.csv", b"");
    folder.put("rgb.mp4", b"");
    assert!(refusal(&folder).contains("ffmpeg -i rgb.mp4"));
    let said = refusal(&Folder::new());
    assert!(
        said.contains("looked for: transforms.json; ") && said.contains("; rgb.txt, depth.txt"),
        "{said}"
    );
}

#[test]
fn a_table_of_cinema_leaves_out_short_and_repeated_rows_and_may_have_semicolons() {
    let folder = Folder::new();
    let centered = Intrinsics::centered(64, 48, 60.0);
    let angle = 2.0 * (24.0_f64 / 60.0).atan().to_degrees();
    let head = "time,position_x,position_y,position_z,focal_point_x,focal_point_y,focal_point_z,view_angle,FILE,FILE_depth";
    let mut rows = vec![head.to_owned()];
    for (step, camera) in cameras(centered).iter().enumerate() {
        folder.put(&format!("{step}.png"), &color(camera, ImageFormat::Png));
        let mut depth = b"\x93NUMPY\x01\x00\x46\x00".to_vec();
        depth.extend(
            format!("{:<70}", "{'descr': '<f4', 'fortran_order': False, 'shape': (48, 64), }").bytes(),
        );
        depth.extend(scene::depths(camera).iter().flat_map(|z| (*z as f32).to_le_bytes()));
        folder.put(&format!("{step}.npy"), &depth);
        let (eye, ahead) = (camera.position_in_world(), camera.world_from_camera.matrix3.z_axis);
        let numbers = [eye.to_array(), (eye + ahead).to_array()].concat();
        let numbers: Vec<String> = numbers.iter().map(f64::to_string).collect();
        rows.push(format!("0,{},{angle},{step}.png,{step}.npy", numbers.join(",")));
    }
    rows.push(rows[1].clone());
    rows.push("0,1,2".to_owned());
    folder.put("data.csv", rows.join("\n").as_bytes());
    let said = Source::find(&folder.path("")).unwrap().description().lines().join("\n");
    assert!(said.contains("left out: 1 of a place and a time that another row has (first: 0.png)"), "{said}");
    assert!(said.contains("(first: data.csv, line 6)"), "{said}");
    assert_eq!(open(&folder).unwrap().cameras.len(), VIEWS);
    let spreadsheet = rows[..=VIEWS].join("\n").replace(',', ";").replace('.', ",").replace(",png", ".png");
    folder.put("data.csv", spreadsheet.replace(",npy", ".npy").as_bytes());
    assert_eq!(open(&folder).unwrap().cameras.len(), VIEWS);
}
