//! The TUM RGB-D benchmark, and data sets in its layout.
//!
//! Source: Sturm, Engelhard, Endres, Burgard, Cremers: A Benchmark for the Evaluation of RGB-D SLAM Systems, IROS 2012, and its
//! file formats: `rgb.txt` and `depth.txt` (`timestamp path`), `groundtruth.txt` (`timestamp tx ty tz qx qy qz qw`: camera to
//! world; x right, y down, z forward; meters), depth in 16-bit PNG in 1/5000 m. Color and depth are paired by the nearest stamp
//! within 20 ms. What differs: the pose is interpolated between the two around the color's stamp.

use super::place::Place;
use super::reader::{Description, Reader, Reading};
use super::text::TextFile;
use super::views::{entry, lens, pose_of_quaternion, recording};
use crate::capture::recording::{Trajectory, nearest};
use crate::capture::transforms::{Keys, LensKeys};
use crate::error::{Error, Result};

/// How far the stamps of color and depth may be apart, seconds: the benchmark's own limit.
const PAIR_LIMIT: f64 = 0.02;
/// How far a pose's stamp may be from the color's, seconds.
const POSE_LIMIT: f64 = 0.08;
/// Meters per unit of depth.
const DEPTH_UNIT: f64 = 1.0 / 5000.0;

/// Lists of pictures with their stamps.
const LISTS: [&str; 3] = ["rgb.txt", "depth.txt", "groundtruth.txt"];

/// The TUM RGB-D benchmark.
pub(super) struct Tum;

/// A picture and when it was taken, in seconds.
struct Stamped {
    time: f64,
    file_path: String,
}

impl Reader for Tum {
    fn source(&self) -> &'static str {
        "TUM RGB-D"
    }

    fn marks(&self) -> &'static str {
        "rgb.txt, depth.txt and groundtruth.txt (TUM)"
    }

    fn recognizes(&self, place: &Place) -> bool {
        let is_ours = place.file.as_deref().is_none_or(|file| LISTS.contains(&file));
        is_ours && place.has_all(&["rgb.txt", "depth.txt"])
    }

    fn read(&self, place: &Place) -> Result<Reading> {
        let truth = place.join("groundtruth.txt");
        if !truth.is_file() {
            let what = "there is no groundtruth.txt, which says where the camera was; estimate its path with a SLAM program and save it in that format (timestamp tx ty tz qx qy qz qw)";
            return Err(Error::invalid(place.folder.display(), what));
        }
        let mut description = Description {
            source: self.source().to_owned(),
            poses: "camera to world; camera x right, y down, z forward; meters; interpolated at the color's stamp".into(),
            depth: "planar z in 1/5000 m, 16-bit PNG; 0 is no depth".into(),
            ..Description::default()
        };
        let (colors, name) = stamped(&place.join("rgb.txt"))?;
        let (depths, _) = stamped(&place.join("depth.txt"))?;
        let trajectory = trajectory(&truth, &mut description)?;
        let depth_times: Vec<f64> = depths.iter().map(|depth| depth.time).collect();
        let mut frames = Vec::new();
        for color in colors {
            let Some(depth) = nearest(&depth_times, color.time, PAIR_LIMIT) else {
                description.skip("without depth within 20 ms", color.file_path);
                continue;
            };
            let Some(pose) = trajectory.at(color.time, POSE_LIMIT) else {
                description.skip("without a pose within 80 ms", color.file_path);
                continue;
            };
            frames.push(entry(color.file_path, Some(depths[depth].file_path.clone()), &pose));
        }
        let folder_name = place.folder.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let (lens, words) = lens_of(&format!("{folder_name} {name}"));
        description.lens = words;
        let keys = Keys { depth_unit_scale_factor: Some(DEPTH_UNIT), ..lens };
        recording(place, keys, frames, description, LISTS.map(|name| place.join(name)).to_vec())
    }
}

/// The pictures of a list by time, and the text of the list's comments.
fn stamped(path: &std::path::Path) -> Result<(Vec<Stamped>, String)> {
    let file = TextFile::read(path)?;
    let mut list = Vec::new();
    for line in file.lines() {
        let [time] = line.numbers(0)?;
        let Some(name) = line.fields.get(1) else {
            return Err(line.error("there is no path behind the stamp"));
        };
        if !time.is_finite() {
            return Err(line.error("the stamp is no time"));
        }
        list.push(Stamped { time, file_path: (*name).to_owned() });
    }
    list.sort_by(|a, b| a.time.total_cmp(&b.time));
    let comments = file.text().lines().filter(|line| line.starts_with('#')).collect();
    Ok((list, comments))
}

fn trajectory(path: &std::path::Path, description: &mut Description) -> Result<Trajectory> {
    let mut poses = Vec::new();
    for line in TextFile::read(path)?.lines() {
        let [time, x, y, z, qx, qy, qz, qw] = line.numbers(0)?;
        match pose_of_quaternion([qx, qy, qz, qw], [x, y, z]).filter(|_| time.is_finite()) {
            Some(pose) => poses.push((time, pose)),
            None => description.skip("poses that are no pose", format!("line {}", line.number)),
        }
    }
    if poses.is_empty() {
        return Err(Error::invalid(path.display(), "there is no pose in it"));
    }
    Ok(Trajectory::new(poses))
}

/// The lens by the number of the benchmark's sensor, which the name of the sequence has: the benchmark's own calibration, with
/// pixel centers at whole numbers.
fn lens_of(names: &str) -> (Keys, String) {
    let names = names.to_ascii_lowercase();
    let has =
        |number: u32| names.contains(&format!("freiburg{number}")) || names.contains(&format!("fr{number}"));
    let (sensor, [fx, fy, cx, cy], bent) = match (has(1), has(2), has(3)) {
        (true, ..) => ("freiburg1", [517.3, 516.5, 318.6, 255.3], [0.2624, -0.9531, -0.0054, 0.0026, 1.1633]),
        (_, true, _) => {
            ("freiburg2", [520.9, 521.0, 325.1, 249.7], [0.2312, -0.7849, -0.0033, -0.0001, 0.9172])
        }
        (_, _, true) => ("freiburg3", [535.4, 539.2, 320.1, 247.6], [0.0; 5]),
        _ => ("the default of the sensor", [525.0, 525.0, 319.5, 239.5], [0.0; 5]),
    };
    let [k1, k2, p1, p2, k3] = bent;
    let mut keys = lens(fx, fy, cx, cy, 0.0);
    if bent != [0.0; 5] {
        keys.camera_model = Some("OPENCV".to_owned());
        keys.lens = LensKeys::of(&[("k1", k1), ("k2", k2), ("p1", p1), ("p2", p2), ("k3", k3)]);
    }
    (keys, format!("{sensor}: {fx} {fy} {cx} {cy}, distortion {bent:?}"))
}
