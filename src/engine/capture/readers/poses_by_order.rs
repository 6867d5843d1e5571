//! Sources with one list of poses: the first is of the first picture of color and of depth.

use std::path::Path;

use glam::{DAffine3, DMat4};
use serde::Deserialize;

use super::posed_folder::{Benchmark, Found, PRIME_SENSE, posed};
use super::reader::Reader;
use super::text::{TextFile, TextLine};
use super::views::{
    MILLIMETERS, OPENCV_POSES, colors_in, entry, json, pictures_in, pose_of_quaternion, pose_of_rows,
};
use crate::error::{Error, Result};
use crate::plural::counted;

/// Adds the pictures of color in a folder. `pose` has a picture's number from 0 on, and whether it has depth.
fn add_in_order(
    found: &mut Found<'_>,
    folder: &str,
    pose: impl Fn(usize, bool) -> std::result::Result<DAffine3, &'static str>,
) {
    let depths = pictures_in(&found.place.join("depth"), &[".png", ".pgm"]);
    for (index, color) in colors_in(&found.place.join(folder)).into_iter().enumerate() {
        let depth = depths.get(index).map(|depth| format!("depth/{depth}"));
        let pose = pose(index, depth.is_some());
        let picture = pose.map(|pose| entry(format!("{folder}/{color}"), depth, &pose));
        found.add(color, picture);
    }
}

/// RGB-D sequences of `Open3D` and Redwood.
///
/// Source: `Open3D`'s `FileLOG.cpp`, `FileJSON.cpp` and its reconstruction system: `color/` or `image/`, `depth/` in millimeters,
/// `trajectory.log` (for each frame three whole numbers and 4×4 numbers, camera to world) or `camera_trajectory.json` (world to
/// camera, column by column); x right, y down, z forward. Pixel centers are at whole numbers.
pub(super) const REDWOOD: Reader = Reader {
    source: "Open3D / Redwood RGB-D",
    marks: "trajectory.log or camera_trajectory.json beside color/ (or image/) and depth/ (Open3D, Redwood)",
    stands_for_folder: |file| LOGS.contains(&file),
    is_here: |place| place.first_of(&LOGS).is_some() && place.has("depth"),
    poses: OPENCV_POSES,
    depth: MILLIMETERS,
    lens: "",
    read: |place, description| posed(place, description, find_redwood),
};

/// Names of files of poses.
const LOGS: [&str; 3] = ["trajectory.log", "camera_trajectory.json", "Extrinsics_Open3D.log"];
/// Names of files of the lens.
const LENSES: [&str; 3] = ["camera_intrinsic.json", "intrinsic.json", "camera_intrinsics.json"];

/// `PinholeCameraIntrinsic` of `Open3D`, and what its recorders write beside it.
#[derive(Deserialize)]
struct RedwoodIntrinsics {
    /// Column by column.
    intrinsic_matrix: Vec<f64>,
    #[serde(default)]
    depth_scale: Option<f64>,
}

#[derive(Deserialize)]
struct RedwoodTrajectory {
    parameters: Vec<RedwoodPose>,
}

#[derive(Deserialize)]
struct RedwoodPose {
    /// World to camera, column by column.
    extrinsic: Vec<f64>,
}

fn find_redwood(found: &mut Found<'_>) -> Result<()> {
    let place = found.place;
    let log = place.join(place.file.as_deref().or_else(|| place.first_of(&LOGS)).unwrap_or(LOGS[0]));
    found.inputs.push(log.clone());
    let is_json = log.extension().is_some_and(|ending| ending == "json");
    let poses = if is_json { poses_of_json(&log)? } else { poses_of_log(&log)? };
    let folder = place.first_of(&["color", "image", "rgb"]).unwrap_or("color");
    add_in_order(found, folder, |index, has_depth| {
        let (_, pose) = poses.iter().find(|(number, _)| *number == index).ok_or("without a pose")?;
        if has_depth { pose.ok_or("without a rigid pose") } else { Err("without depth") }
    });
    set_redwood_lens(found)
}

fn set_redwood_lens(found: &mut Found<'_>) -> Result<()> {
    let Some(name) = found.place.first_of(&LENSES) else {
        return found.set_lens_of(&PRIME_SENSE, 1.0 / 1000.0);
    };
    let path = found.place.join(name);
    let RedwoodIntrinsics { intrinsic_matrix, depth_scale } = found.json(&path)?;
    let [fx, _, _, _, fy, _, cx, cy, _] = intrinsic_matrix[..] else {
        let count = counted(intrinsic_matrix.len(), "number");
        let what = format!("intrinsic_matrix has {count}; 9 are expected, column by column");
        return Err(Error::invalid(path.display(), what));
    };
    found.description.lens = format!("{name}: {fx} {fy} {cx} {cy}");
    let scale = depth_scale.unwrap_or(1000.0);
    if scale != 1000.0 {
        found.description.depth = format!("planar z in 1/{scale} m, 16-bit PNG; 0 is no depth");
    }
    found.set_lens([fx, fy, cx, cy], 1.0 / scale);
    Ok(())
}

/// The number of each frame, and its pose, world from camera; `None` where it is not rigid.
type Poses = Vec<(usize, Option<DAffine3>)>;

fn poses_of_log(path: &Path) -> Result<Poses> {
    const NUMBERS: usize = 3 + 16;
    // LiveScan3D writes the 16 numbers into one line.
    let numbers = TextFile::read(path)?.numbers()?;
    if numbers.is_empty() || numbers.len() % NUMBERS != 0 {
        let (whole, rest) = (numbers.len() / NUMBERS, counted(numbers.len() % NUMBERS, "number"));
        let what = format!(
            "{rest} too many behind pose {whole}, counted from 0; a pose has 3 whole numbers and 16 more"
        );
        return Err(Error::invalid(path.display(), what));
    }
    Ok(numbers.chunks_exact(NUMBERS).map(|pose| (pose[0] as usize, pose_of_rows(&pose[3..]))).collect())
}

fn poses_of_json(path: &Path) -> Result<Poses> {
    let rows_of = |matrix: DMat4| matrix.transpose().to_cols_array();
    let pose = |(index, parameters): (usize, RedwoodPose)| {
        let columns = <[f64; 16]>::try_from(parameters.extrinsic).ok();
        let camera_from_world = columns.and_then(|m| pose_of_rows(&rows_of(DMat4::from_cols_array(&m))));
        let pose = camera_from_world.and_then(|pose| pose_of_rows(&rows_of(pose.inverse().into())));
        (index, pose)
    };
    Ok(json::<RedwoodTrajectory>(path)?.parameters.into_iter().enumerate().map(pose).collect())
}

/// A folder of color, a folder of depth, and one line a frame for its pose.
///
/// Source: the data of Gao, Zhang: 14 Lectures on Visual SLAM, chapter 5 (`pose.txt`: `tx ty tz qx qy qz qw`, camera to world, x
/// right, y down, z forward; depth in millimeters), and many like it, which write 12 or 16 numbers of a matrix instead.
pub(super) const POSE_LIST: Reader = Reader {
    source: "RGB-D folder with a list of poses",
    marks: "pose.txt beside color/ and depth/ (Kinect folders)",
    stands_for_folder: |file| LISTS.contains(&file),
    is_here: |place| {
        [LISTS, COLORS].iter().all(|names| place.first_of(names).is_some()) && place.has("depth")
    },
    poses: OPENCV_POSES,
    depth: "planar z in millimeters, 16-bit PGM or PNG; 0 is no depth",
    lens: "",
    read: |place, description| posed(place, description, find_pose_list),
};

/// Names of the files of poses.
const LISTS: [&str; 2] = ["pose.txt", "poses.txt"];
/// The lens of the book's Kinect.
const BOOK: Benchmark =
    Benchmark { name: "the book's Kinect", lens: [518.0, 519.0, 325.5, 253.5], ..PRIME_SENSE };
/// Names of the folders of color.
const COLORS: [&str; 2] = ["color", "rgb"];

fn find_pose_list(found: &mut Found<'_>) -> Result<()> {
    let path = found.place.join(found.place.first_of(&LISTS).unwrap_or(LISTS[0]));
    let poses: Vec<_> =
        TextFile::read(&path)?.lines().map(|line| pose_of_line(&line)).collect::<Result<_>>()?;
    found.inputs.push(path);
    let folder = found.place.first_of(&COLORS).unwrap_or(COLORS[0]);
    add_in_order(found, folder, |index, has_depth| {
        poses.get(index).copied().flatten().filter(|_| has_depth).ok_or("without depth or a pose")
    });
    found.set_lens_of(&BOOK, 1e-3)
}

/// `None` where it is not rigid.
fn pose_of_line(line: &TextLine<'_>) -> Result<Option<DAffine3>> {
    Ok(match line.fields.len() {
        7 => {
            let [x, y, z, qx, qy, qz, qw] = line.numbers(0)?;
            pose_of_quaternion([qx, qy, qz, qw], [x, y, z])
        }
        12 => pose_of_rows(&line.numbers::<12>(0)?),
        16 => pose_of_rows(&line.numbers::<16>(0)?),
        count => {
            let count = counted(count, "number");
            let what = format!("the line has {count}; a pose has 7 (tx ty tz qx qy qz qw), 12 or 16");
            return Err(line.error(what));
        }
    })
}
