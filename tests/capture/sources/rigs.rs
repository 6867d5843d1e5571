//! Rigs of several cameras: some with separate color and depth cameras, some with depth that is none.

use glam::{DMat3, DVec2, DVec3};

use super::*;

/// Breakdancers' planes; the scene is put between them.
const SCALE: f64 = 30.5;
const BEHIND: f64 = 0.75;

/// The world of Microsoft's captures, x right, y up, z forward, from the scene's, x right, y forward, z up.
fn msr_world() -> DAffine3 {
    let turn = DMat3::from_cols(DVec3::X, DVec3::Z, DVec3::Y);
    DAffine3 { matrix3: turn * SCALE, translation: DVec3::new(0.0, 0.0, SCALE * BEHIND) }
}

/// Writes the scene as Microsoft Research's Breakdancers; the calibration is of this text where it is given.
fn write_msr(folder: &Folder) -> String {
    let lens = Intrinsics { fy: 23.5, cx: 24.2, cy: 17.6, ..Intrinsics::centered(48, 36, 24.0) };
    let world = msr_world();
    let mut calibration = String::new();
    for (index, camera) in cameras(lens).iter().enumerate() {
        folder.put(&format!("cam{index}/color-cam{index}-f000.jpg"), &color(camera, ImageFormat::Jpeg));
        let level = |(pixel, z): (usize, f64)| {
            let at = DVec2::new((pixel % 48) as f64 + 0.5, (pixel / 48) as f64 + 0.5);
            let world_z = world.transform_point3(camera.unproject(at, z)).z;
            let share = (1.0 / world_z - 1.0 / 120.0) / (1.0 / 44.0 - 1.0 / 120.0);
            [(255.0 * share).round() as u8; 3]
        };
        let levels: Vec<u8> = scene::depths(camera).into_iter().enumerate().flat_map(level).collect();
        let image: ImageBuffer<Rgb<u8>, _> = ImageBuffer::from_raw(48, 36, levels).unwrap();
        folder
            .put(&format!("cam{index}/depth-cam{index}-f000.png"), &picture(&image.into(), ImageFormat::Png));
        // Both worlds and both cameras' axes are mirror images of each other: a rotation is left.
        let rotation = DMat3::from_diagonal(DVec3::new(1.0, -1.0, 1.0))
            * camera.world_from_camera.matrix3.transpose()
            * (world.matrix3 / SCALE).transpose();
        let position = world.transform_point3(camera.position_in_world());
        let pose = scene::rows(&DAffine3 { matrix3: rotation, translation: -(rotation * position) });
        // Rows count from the bottom, and pixel centers are whole numbers.
        let (cx, cy) = (lens.cx - 0.5, 35.0 - (lens.cy - 0.5));
        writeln!(calibration, "{index}\n{} 0 {cx}\n0 {} {cy}\n0 0 1\n0\n0", lens.fx, lens.fy).unwrap();
        writeln!(calibration, "{}", lines_of_four(&pose[..12])).unwrap();
    }
    folder.put("calibParams-breakdancers.txt", calibration.as_bytes());
    calibration
}

#[test]
fn microsofts_depth_is_z_of_a_left_handed_world_in_levels() {
    let folder = Folder::new();
    let calibration = write_msr(&folder);
    let found = Source::find(&folder.path("")).unwrap();
    assert!(found.description().source.contains("Microsoft"), "{:?}", found.description());
    // A left-handed world is mirrored along y.
    let mirror = DAffine3::from_scale(DVec3::new(1.0, -1.0, 1.0));
    let capture = found.open(&CaptureSettings::default()).unwrap();
    scene::check_elsewhere(&capture, VIEWS, 1.0, &(mirror * msr_world()).inverse());
    let finding = capture::conventions::check(&capture).unwrap();
    assert_eq!(finding.warning(), None);

    folder.put("calibParams-breakdancers.txt", &calibration.as_bytes()[..calibration.len() - 40]);
    assert!(refusal(&folder).contains("numbers too many behind camera 2"), "{}", refusal(&folder));
    folder.put("calibParams-breakdancers.txt", calibration.replacen("0\n0\n", "0\n0.1\n", 1).as_bytes());
    assert!(refusal(&folder).contains("camera 0, counted from 0, has distortion"), "{}", refusal(&folder));
    std::fs::remove_file(folder.path("calibParams-breakdancers.txt")).unwrap();
    folder.put("calibParams-other.txt", calibration.as_bytes());
    assert!(refusal(&folder).contains("near and far plane"), "{}", refusal(&folder));
    std::fs::remove_file(folder.path("calibParams-other.txt")).unwrap();
    std::fs::remove_dir_all(folder.path("cam1")).unwrap();
    folder.put("calibParams-breakdancers.txt", calibration.as_bytes());
    assert!(refusal(&folder).contains("camera 1 has no pair"), "{}", refusal(&folder));
}

fn matrix_of_opencv(name: &str, rows: usize, numbers: &[f64]) -> String {
    let columns = numbers.len() / rows;
    let numbers: Vec<String> = numbers.iter().map(f64::to_string).collect();
    let (first, rest) = numbers.split_at(numbers.len() / 2);
    // OpenCV breaks long lines.
    let data = format!("{},\n       {}", first.join(", "), rest.join(", "));
    format!("{name}: !!opencv-matrix\n   rows: {rows}\n   cols: {columns}\n   dt: d\n   data: [ {data} ]\n")
}

#[test]
fn easymocap_poses_are_world_to_camera_and_depth_is_asked_for() {
    let folder = Folder::new();
    let names = "%YAML:1.0\n---\nnames:\n   - \"0\"\n   - \"1\"\n   - \"2\"\n";
    let (mut intrinsics, mut extrinsics) = (names.to_owned(), names.to_owned());
    for (name, camera) in cameras(LENS).iter().enumerate() {
        folder.put(&format!("images/{name}/000004.jpg"), &color(camera, ImageFormat::Jpeg));
        let k = [LENS.fx, 0.0, LENS.cx - 0.5, 0.0, LENS.fy, LENS.cy - 0.5, 0.0, 0.0, 1.0];
        intrinsics += &matrix_of_opencv(&format!("K_{name}"), 3, &k);
        intrinsics += &matrix_of_opencv(&format!("dist_{name}"), 1, &[0.0; 5]);
        let camera_from_world = camera.camera_from_world();
        let (axis, angle) = DQuat::from_mat3(&camera_from_world.matrix3).to_axis_angle();
        extrinsics += &matrix_of_opencv(&format!("R_{name}"), 3, &(axis * angle).to_array());
        if name != 1 {
            let m = camera_from_world.matrix3.transpose().to_cols_array();
            extrinsics += &matrix_of_opencv(&format!("Rot_{name}"), 3, &m);
        }
        extrinsics += &matrix_of_opencv(&format!("T_{name}"), 3, &camera_from_world.translation.to_array());
    }
    folder.put("intri.yml", intrinsics.as_bytes());
    folder.put("extri.yml", extrinsics.as_bytes());
    assert!(refusal(&folder).contains("a rig of color cameras holds no depth"), "{}", refusal(&folder));
    for (name, camera) in cameras(LENS).iter().enumerate() {
        folder.put(&format!("depth/{name}/000004.png"), &depth_png(camera, 1000.0));
    }
    check(&folder, "EasyMocap");

    folder.put("extri.yml", extrinsics.replace("Rot_2", "Rot_0").as_bytes());
    assert!(refusal(&folder).contains("the matrix Rot_0 is there twice"), "{}", refusal(&folder));
    folder.put("extri.yml", extrinsics.replace("Rot_2", "Rot_1").as_bytes());
    assert!(refusal(&folder).contains("R_1 and Rot_1 are two rotations"), "{}", refusal(&folder));
    folder.put("extri.yml", extrinsics.replace("T_1", "T_7").as_bytes());
    assert!(refusal(&folder).contains("extri.yml: there is no T_1"), "{}", refusal(&folder));
    folder.put("extri.yml", &extrinsics.as_bytes()[..extrinsics.len() - 3]);
    assert!(refusal(&folder).contains("the matrix T_2 has no end"), "{}", refusal(&folder));
    folder.put("extri.yml", extrinsics.as_bytes());
    folder.put("intri.yml", intrinsics.replacen("60", "x", 1).as_bytes());
    assert!(refusal(&folder).contains("'x' is no number"), "{}", refusal(&folder));
}

/// A lens of the sensor: k1 and k4, p1 and p2.
const BENT: [f64; 4] = [0.05, 0.02, 0.002, -0.001];

/// Where the sensor's lens puts a ray.
fn bend(ray: DVec2) -> DVec2 {
    let [k1, k4, p1, p2] = BENT;
    let (r, xy) = (ray.length_squared(), ray.x * ray.y);
    let tangential = DVec2::new(
        2.0 * p1 * xy + p2 * (r + 2.0 * ray.x * ray.x),
        p1 * (r + 2.0 * ray.y * ray.y) + 2.0 * p2 * xy,
    );
    ray * ((1.0 + k1 * r) / (1.0 + k4 * r)) + tangential
}

/// Depth of a bent lens in millimeters, in TIFF.
fn bent_depth(camera: &Camera) -> Vec<u8> {
    let lens = camera.intrinsics;
    let (width, height) = lens.size();
    let (center, focal) = (DVec2::new(lens.cx, lens.cy), DVec2::new(lens.fx, lens.fy));
    let depth = |pixel: usize| {
        let at = (DVec2::new((pixel % width) as f64 + 0.5, (pixel / width) as f64 + 0.5) - center) / focal;
        let straight = (0..50).fold(at, |ray, _| ray - (bend(ray) - at));
        (1000.0 * scene::depth(camera, center + focal * straight)).round() as u16
    };
    let depths: Vec<u16> = (0..width * height).map(depth).collect();
    let mut tiff = std::io::Cursor::new(Vec::new());
    let mut encoder = tiff::encoder::TiffEncoder::new(&mut tiff).unwrap();
    encoder.write_image::<tiff::encoder::colortype::Gray16>(lens.width, lens.height, &depths).unwrap();
    tiff.into_inner()
}

#[test]
fn livescan3d_carries_depth_of_the_sensors_own_lens_into_its_color_camera() {
    let folder = Folder::new();
    // The whole sensors: color has 4:3, of which 16:9 shows the middle; depth has 512×512, of which 320×288 are shown.
    let color_lens = Intrinsics { fy: 128.0, cx: 65.0, cy: 37.0, ..Intrinsics::centered(128, 72, 130.0) };
    let depth_lens = Intrinsics { fy: 252.5, cx: 161.0, cy: 143.0, ..Intrinsics::centered(320, 288, 252.0) };
    let color_from_depth =
        DAffine3::from_rotation_translation(DQuat::from_rotation_x(0.02), DVec3::new(-0.032, -0.002, 0.004));
    let mut log = String::new();
    for (index, camera) in cameras(color_lens).iter().enumerate() {
        let depth_camera = Camera {
            intrinsics: depth_lens,
            world_from_camera: camera.world_from_camera * color_from_depth,
            ..camera.clone()
        };
        folder.put(&format!("client_{index}/Color_7.jpg"), &color(camera, ImageFormat::Jpeg));
        folder.put(&format!("client_{index}/Depth_7.tiff"), &bent_depth(&depth_camera));
        let [k1, k4, p1, p2] = BENT;
        let shares = |(side, rows): (f64, f64), lens: Intrinsics, (left, top): (f64, f64), bent: bool| {
            let [k1, k4, p1, p2] = if bent { [k1, k4, p1, p2] } else { [0.0; 4] };
            let [cx, cy] = [(lens.cx + left) / side, (lens.cy + top) / rows];
            json!([cx, cy, lens.fx / side, lens.fy / rows, k1, 0, 0, k4, 0, 0, 0, 0, p2, p1])
        };
        let rotation = color_from_depth.matrix3.transpose().to_cols_array();
        let identity = DMat3::IDENTITY.to_cols_array();
        let calibration = json!({"CalibrationInformation": {"Cameras": [
            {"Intrinsics": {"ModelParameterCount": 14, "ModelParameters": shares((512.0, 512.0), depth_lens, (96.0, 90.0), true)},
             "Purpose": "CALIBRATION_CameraPurposeDepth", "Rt": {"Rotation": identity, "Translation": [0, 0, 0]}},
            {"Intrinsics": {"ModelParameterCount": 14, "ModelParameters": shares((128.0, 96.0), color_lens, (0.0, 12.0), false)},
             "Purpose": "CALIBRATION_CameraPurposePhotoVideo",
             "Rt": {"Rotation": rotation, "Translation": color_from_depth.translation.to_array()}},
        ]}});
        let name = format!("client_{index}/Intrinsics_Calib_{index}.json");
        folder.put(&name, calibration.to_string().as_bytes());
        let pose: Vec<String> = scene::rows(&camera.world_from_camera).iter().map(f64::to_string).collect();
        write!(log, "0\t00012345A{index}\t{index}\r\n{}\t\r\n", pose.join("\t")).unwrap();
    }
    folder.put("Extrinsics_Open3D.log", log.as_bytes());
    check(&folder, "LiveScan3D");

    let short = log.rsplit_once('\t').unwrap().0.rsplit_once('\t').unwrap().0;
    folder.put("Extrinsics_Open3D.log", short.as_bytes());
    assert!(refusal(&folder).contains("line 5: its pose has 15 numbers"), "{}", refusal(&folder));
    folder.put("Extrinsics_Open3D.log", log.replace("A2\t2", "A2\t1").as_bytes());
    assert!(refusal(&folder).contains("sensor 1 has two poses"), "{}", refusal(&folder));
    folder.put("Extrinsics_Open3D.log", log.replace("A2\t2", "A2\t3").as_bytes());
    assert!(refusal(&folder).contains("there is no pose of sensor 2"), "{}", refusal(&folder));
    folder.put("Extrinsics_Open3D.log", log.as_bytes());
    folder.put("client_1/Depth_7.tiff", &bent_depth(&scene::camera(1, LENS)));
    assert!(
        refusal(&folder).contains("its depth pictures are 64×48, which is no mode"),
        "{}",
        refusal(&folder)
    );
    std::fs::remove_file(folder.path("client_1/Intrinsics_Calib_1.json")).unwrap();
    assert!(refusal(&folder).contains("there is no Intrinsics_Calib_*.json"), "{}", refusal(&folder));
}

#[test]
fn depthkits_manifest_has_backslashes_and_a_lens_for_every_picture() {
    let folder = Folder::new();
    let entry = |(sensor, camera): (usize, &Camera)| {
        folder.put(&format!("sensor{sensor}/rgb/000001.png"), &color(camera, ImageFormat::Png));
        folder.put(&format!("sensor{sensor}/depth/000001.png"), &depth_png(camera, 1000.0));
        let opengl = |row: &[f64]| vec![row[0], -row[1], -row[2], row[3]];
        let matrix: Vec<_> = scene::rows(&camera.world_from_camera).chunks(4).map(opengl).collect();
        json!({
            "file_path": format!("sensor{sensor}\\rgb\\000001.png"),
            "depth_file_path": format!("sensor{sensor}\\depth\\000001.png"),
            "w": LENS.width, "h": LENS.height, "fl_x": LENS.fx, "fl_y": LENS.fy, "cx": LENS.cx, "cy": LENS.cy,
            "k1": 0.0, "k2": 0.0, "p1": 0.0, "p2": 0.0, "transform_matrix": matrix,
        })
    };
    let frames: Vec<_> = cameras(LENS).iter().enumerate().map(entry).collect();
    let manifest = json!({"camera_model": "OPENCV", "frames": frames});
    folder.put("transforms.json", manifest.to_string().as_bytes());
    check(&folder, "nerfstudio");
}
