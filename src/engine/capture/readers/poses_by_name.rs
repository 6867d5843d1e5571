//! Sources whose file names match color, depth and poses.

use std::collections::BTreeMap;

use glam::DAffine3;
use serde::Deserialize;

use super::place::{SourceFolder, names_in};
use super::posed_folder::{Benchmark, Found, posed};
use super::reader::Reader;
use super::text::TextFile;
use super::views::{MILLIMETERS, OPENCV_POSES, colors_in, entry, lens, number_in, pose_of_rows, stem};
use crate::capture::transforms::{DepthCameraKeys, Keys, PictureEntry};
use crate::error::{Error, Result};

/// `ScanNet` as its own reader exports it.
///
/// Source: Dai et al.: `ScanNet`, CVPR 2017, and its `SensReader`: `color/N.jpg`, `depth/N.png` in millimeters and of its own size,
/// `pose/N.txt` of 4×4 numbers, camera to world, x right, y down, z forward, `-inf` where tracking was lost,
/// `intrinsic/intrinsic_color.txt` and `intrinsic_depth.txt`. Depth is registered to color in space, not in size.
pub(super) const SCANNET: Reader = Reader {
    source: "ScanNet export",
    marks: "color/, depth/, pose/ and intrinsic/ (ScanNet)",
    stands_for_folder: |_| false,
    is_here: |place| place.has_all(&["color", "depth", "pose", "intrinsic"]),
    poses: OPENCV_POSES,
    depth: MILLIMETERS,
    lens: "",
    read: |place, description| posed(place, description, find_scannet),
};

fn find_scannet(found: &mut Found<'_>) -> Result<()> {
    let mut lens_of = |name: &str| {
        let path = found.place.join(&format!("intrinsic/{name}"));
        let numbers = found.numbers(&path)?;
        // Four or three numbers a line.
        let columns = if numbers.len() >= 16 { 4 } else { 3 };
        if numbers.len() < 9 {
            return Err(Error::invalid(path.display(), "there is no matrix of 3×3 or 4×4 numbers"));
        }
        Ok([numbers[0], numbers[columns + 1], numbers[2], numbers[columns + 2]])
    };
    let [color, depth] = [lens_of("intrinsic_color.txt")?, lens_of("intrinsic_depth.txt")?];
    let words = |[fx, fy, cx, cy]: [f64; 4]| format!("{fx} {fy} {cx} {cy}");
    found.description.lens = format!("color {}; depth {}", words(color), words(depth));
    found.set_lens(color, 1e-3);
    let ([fl_x, fl_y, cx, cy], pixel_center_offset) = (depth.map(Some), Some(0.0));
    let depth_camera =
        DepthCameraKeys { fl_x, fl_y, cx, cy, pixel_center_offset, ..DepthCameraKeys::default() };
    found.keys.depth_camera = Some(Box::new(depth_camera));
    for name in colors_in(&found.place.join("color")) {
        let stem = stem(&name);
        let (path, depth) = (found.place.join(&format!("pose/{stem}.txt")), format!("depth/{stem}.png"));
        if !path.is_file() || !found.has_file(&depth) {
            found.add(name, Err("without a pose or depth"));
            continue;
        }
        let pose = found.numbers(&path).ok().and_then(|rows| pose_of_rows(&rows));
        let picture = pose.map(|pose| entry(format!("color/{name}"), Some(depth), &pose));
        found.add(name, picture.ok_or("taken while tracking was lost"));
    }
    Ok(())
}

/// 7-Scenes and data sets in its layout (`BundleFusion`, `tsdf-fusion-python`).
///
/// Source: Shotton et al.: Scene Coordinate Regression Forests, CVPR 2013, and its files: `frame-%06d.color.png`, `.depth.png` in
/// millimeters with 0 and 65535 for no depth, `.pose.txt` of 4×4 numbers, camera to world; x right, y down, z forward.
pub(super) const SEVEN_SCENES: Reader = Reader {
    source: "7-Scenes",
    marks: "frame-*.pose.txt, or seq-*/ of these (7-Scenes)",
    stands_for_folder: is_pose,
    is_here: |place| !sequences(place).is_empty(),
    poses: OPENCV_POSES,
    depth: "planar z in millimeters, 16-bit PNG; 0 is no depth, and so is 65535",
    lens: "",
    read: |place, description| posed(place, description, find_seven_scenes),
};

/// The nominal lens, as published for both cameras.
const KINECT: Benchmark =
    Benchmark { name: "7-Scenes", size: (640, 480), lens: [585.0, 585.0, 320.0, 240.0] };

fn is_pose(name: &str) -> bool {
    name.ends_with(".pose.txt")
}

/// Folders with poses: the place itself, or its sequences.
fn sequences(place: &SourceFolder) -> Vec<String> {
    if place.names().any(is_pose) {
        return vec![String::new()];
    }
    let has_poses =
        |name: &&str| names_in(&place.join(name)).is_ok_and(|names| names.iter().any(|name| is_pose(name)));
    place.names().filter(|name| name.starts_with("seq")).filter(has_poses).map(str::to_owned).collect()
}

fn find_seven_scenes(found: &mut Found<'_>) -> Result<()> {
    for folder in sequences(found.place) {
        let at = |name: &str| if folder.is_empty() { name.to_owned() } else { format!("{folder}/{name}") };
        for name in names_in(&found.place.join(&folder))?.iter().filter(|name| is_pose(name)) {
            let base = at(name.trim_end_matches(".pose.txt"));
            let path = found.place.join(&at(name));
            let Some(rows) = found.numbers(&path).ok().filter(|rows| rows.len() == 16) else {
                found.add(at(name), Err("poses that are not 4 lines of 4 numbers"));
                continue;
            };
            let endings = ["png", "jpg", "jpeg"].map(|ending| format!("{base}.color.{ending}"));
            let Some(color) = endings.into_iter().find(|color| found.has_file(color)) else {
                found.add(at(name), Err("poses without color"));
                continue;
            };
            let depth = format!("{base}.depth.png");
            let picture = pose_of_rows(&rows).map(|pose| entry(color.clone(), Some(depth), &pose));
            found.add(color, picture.ok_or("without a rigid pose"));
        }
    }
    found.set_lens_of(&KINECT, 1e-3)?;
    found.keys.depth_invalid_value = Some(65535.0);
    Ok(())
}

/// Replica as NICE-SLAM renders it.
///
/// Source: Zhu et al.: NICE-SLAM, CVPR 2022, and its data loader: `results/frame%06d.jpg`, `results/depth%06d.png`, `traj.txt` with
/// 16 numbers a line, camera to world, x right, y down, z forward; `cam_params.json`, also one folder above, with the lens and depth
/// units per meter.
pub(super) const REPLICA: Reader = Reader {
    source: "Replica (NICE-SLAM)",
    marks: "traj.txt and results/ (Replica)",
    stands_for_folder: |file| file == "traj.txt",
    is_here: |place| place.has_all(&["traj.txt", "results"]),
    poses: OPENCV_POSES,
    depth: "",
    lens: "",
    read: |place, description| posed(place, description, find_replica),
};

#[derive(Deserialize)]
struct ReplicaParameters {
    camera: ReplicaCamera,
}

#[derive(Deserialize)]
struct ReplicaCamera {
    fx: f64,
    fy: f64,
    cx: f64,
    cy: f64,
    scale: f64,
}

/// What all scenes were rendered with.
const ALL_SCENES: Benchmark =
    Benchmark { name: "Replica", size: (1200, 680), lens: [600.0, 600.0, 599.5, 339.5] };
/// Units of their depth in a meter.
const UNITS_OF_ALL: f64 = 6553.5;

fn find_replica(found: &mut Found<'_>) -> Result<()> {
    let path = found.place.join("traj.txt");
    found.inputs.push(path.clone());
    let trajectory = TextFile::read(&path)?;
    let poses: Vec<[f64; 16]> = trajectory.lines().map(|line| line.numbers(0)).collect::<Result<_>>()?;
    let colors = colors_in(&found.place.join("results"));
    for name in colors.into_iter().filter(|name| name.starts_with("frame")) {
        let digits = name.trim_start_matches("frame").split('.').next().unwrap_or_default();
        let depth = format!("results/depth{digits}.png");
        let rows = number_in(&name).and_then(|number| poses.get(number as usize));
        let pose = rows.and_then(|rows| pose_of_rows(rows)).filter(|_| found.has_file(&depth));
        let picture = pose.map(|pose| entry(format!("results/{name}"), Some(depth), &pose));
        found.add(name, picture.ok_or("without depth or a rigid pose"));
    }
    let camera = found.here_or_above("cam_params.json");
    let camera = camera.map(|path| found.json::<ReplicaParameters>(&path)).transpose()?;
    let scale = camera.as_ref().map_or(UNITS_OF_ALL, |it| it.camera.scale);
    found.description.depth = format!("planar z in 1/{scale} m, 16-bit PNG; 0 is no depth");
    let Some(ReplicaParameters { camera: ReplicaCamera { fx, fy, cx, cy, .. } }) = camera else {
        return found.set_lens_of(&ALL_SCENES, 1.0 / scale);
    };
    found.description.lens = format!("{fx} {fy} {cx} {cy}");
    found.set_lens([fx, fy, cx, cy], 1.0 / scale);
    Ok(())
}

/// Scenes in the format of the BOP benchmark, as `BlenderProc` writes them.
///
/// Source: BOP's data format: `scene_camera.json` has for every image `cam_K` (9 numbers row by row), `depth_scale` (millimeters per
/// unit of the depth file), and optionally `cam_R_w2c` and `cam_t_w2c` (millimeters), world to camera; x right, y down, z forward;
/// `rgb/%06d.png` or `.jpg`, `depth/%06d.png`. Pixel centers are at whole numbers. What differs: read in meters.
pub(super) const BOP: Reader = Reader {
    source: "BOP (BlenderProc)",
    marks: "scene_camera.json beside rgb/ and depth/ (BOP, BlenderProc)",
    stands_for_folder: |file| file == CAMERAS,
    is_here: |place| place.has(CAMERAS),
    poses: "world to camera; camera x right, y down, z forward; millimeters, read as meters",
    depth: "planar z, 16-bit PNG, depth_scale millimeters each; 0 is no depth",
    lens: "",
    read: |place, description| posed(place, description, find_bop),
};

const CAMERAS: &str = "scene_camera.json";

#[derive(Deserialize)]
struct BopImage {
    #[serde(rename = "cam_K")]
    lens: [f64; 9],
    depth_scale: f64,
    #[serde(rename = "cam_R_w2c")]
    rotation: Option<[f64; 9]>,
    #[serde(rename = "cam_t_w2c")]
    translation: Option<[f64; 3]>,
}

impl BopImage {
    fn keys(&self) -> Keys {
        let [fx, _, cx, _, fy, cy, ..] = self.lens;
        Keys { depth_unit_scale_factor: Some(self.depth_scale * 1e-3), ..lens(fx, fy, cx, cy, 0.0) }
    }

    /// World from camera in meters.
    fn pose(&self) -> Option<DAffine3> {
        let ([a, b, c, d, e, f, g, h, i], [x, y, z]) = (self.rotation?, self.translation?);
        let [x, y, z] = [x, y, z].map(|millimeters| millimeters * 1e-3);
        let camera_from_world = pose_of_rows(&[a, b, c, x, d, e, f, y, g, h, i, z])?;
        Some(camera_from_world.inverse())
    }
}

fn find_bop(found: &mut Found<'_>) -> Result<()> {
    let path = found.place.join(CAMERAS);
    let images: BTreeMap<u64, BopImage> = found.json(&path)?;
    found.description.lens = String::from("cam_K of every image");
    if images.values().all(|image| image.rotation.is_none()) {
        let what = "no image has cam_R_w2c and cam_t_w2c, the camera's pose; write them (BlenderProc: bproc.writer.write_bop does), or estimate poses with COLMAP";
        return Err(Error::unsupported(path.display(), what));
    }
    for (number, image) in &images {
        let depth = format!("depth/{number:06}.png");
        let colors = ["png", "jpg"].map(|ending| format!("rgb/{number:06}.{ending}"));
        let color = colors.into_iter().find(|color| found.has_file(color));
        let Some(color) = color.filter(|_| found.has_file(&depth)) else {
            found.add(number.to_string(), Err("without a picture or depth"));
            continue;
        };
        let picture = image.pose().map(|pose| entry(color.clone(), Some(depth), &pose));
        let picture = picture.map(|picture| PictureEntry { keys: image.keys(), ..picture });
        found.add(color, picture.ok_or("without a rigid pose"));
    }
    Ok(())
}
