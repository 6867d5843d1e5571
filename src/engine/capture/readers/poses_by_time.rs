//! Sources whose time stamps match color, depth and poses.

use std::path::Path;

use super::posed_folder::{Benchmark, Found, PRIME_SENSE, posed};
use super::reader::{Description, Reader};
use super::text::TextFile;
use super::views::{INTRINSICS, entry, pose_of_quaternion};
use crate::capture::trajectory::{Trajectory, nearest};
use crate::capture::transforms::LensKeys;
use crate::error::{Error, Result};

/// The TUM RGB-D benchmark, and data sets in its layout.
///
/// Source: Sturm, Engelhard, Endres, Burgard, Cremers: A Benchmark for the Evaluation of RGB-D SLAM Systems, IROS 2012, and its
/// file formats: `rgb.txt` and `depth.txt` (`timestamp path`), `groundtruth.txt` (`timestamp tx ty tz qx qy qz qw`: camera to
/// world; x right, y down, z forward; meters), depth in 16-bit PNG in 1/5000 m. Color and depth are paired by the nearest stamp
/// within 20 ms. What differs: the pose is interpolated between the two around the color's stamp.
pub(super) const TUM: Reader = Reader {
    source: "TUM RGB-D",
    marks: "rgb.txt, depth.txt and groundtruth.txt (TUM)",
    stands_for_folder: |file| LISTS.contains(&file),
    is_here: |place| place.has_all(&["rgb.txt", "depth.txt"]),
    poses: "camera to world; camera x right, y down, z forward; meters; interpolated at the color's stamp",
    depth: "planar z in 1/5000 m, 16-bit PNG; 0 is no depth",
    lens: "",
    read: |place, description| posed(place, description, find_tum),
};

/// How far the stamps of color and depth may be apart, seconds: the benchmark's own limit.
const PAIR_LIMIT: f64 = 0.02;
/// How far a pose's stamp may be from the color's, seconds.
const POSE_LIMIT: f64 = 0.08;
/// Meters per unit of depth.
const DEPTH_UNIT: f64 = 1.0 / 5000.0;

/// Lists of pictures and of poses, with their stamps.
const LISTS: [&str; 3] = ["rgb.txt", "depth.txt", "groundtruth.txt"];

/// The benchmark's own calibration by the names of its sensors: the lens `fx fy cx cy` with pixel centers at whole numbers, and its
/// distortion `k1 k2 p1 p2 k3`.
const SENSORS: [(&str, [f64; 4], [f64; 5]); 3] = [
    ("freiburg1", [517.3, 516.5, 318.6, 255.3], [0.2624, -0.9531, -0.0054, 0.0026, 1.1633]),
    ("freiburg2", [520.9, 521.0, 325.1, 249.7], [0.2312, -0.7849, -0.0033, -0.0001, 0.9172]),
    ("freiburg3", [535.4, 539.2, 320.1, 247.6], [0.0; 5]),
];

/// A picture and when it was taken, in seconds.
struct Stamped {
    time: f64,
    file_path: String,
}

fn find_tum(found: &mut Found<'_>) -> Result<()> {
    let place = found.place;
    let [rgb, depth, truth] = LISTS.map(|name| place.join(name));
    if !truth.is_file() {
        let what = "there is no groundtruth.txt with the camera's path; estimate the path with a SLAM program and save it in that format (timestamp tx ty tz qx qy qz qw)";
        return Err(Error::invalid(place.folder.display(), what));
    }
    let (colors, name) = stamped(&rgb)?;
    let (depths, _) = stamped(&depth)?;
    let trajectory = trajectory(&truth, &mut found.description)?;
    found.inputs = vec![rgb, depth, truth];
    let depth_times: Vec<f64> = depths.iter().map(|depth| depth.time).collect();
    for Stamped { time, file_path } in colors {
        let depth = nearest(&depth_times, time, PAIR_LIMIT).ok_or("without depth within 20 ms");
        let picture = depth.and_then(|depth| {
            let pose = trajectory.at(time, POSE_LIMIT).ok_or("without a pose within 80 ms")?;
            Ok(entry(file_path.clone(), Some(depths[depth].file_path.clone()), &pose))
        });
        found.add(file_path, picture);
    }
    let folder_name = place.folder.file_name().unwrap_or_default().to_string_lossy();
    set_lens(found, &format!("{folder_name} {name}").to_ascii_lowercase())
}

/// The pictures of a list by time, and the text of the list's comments.
fn stamped(path: &Path) -> Result<(Vec<Stamped>, String)> {
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

fn trajectory(path: &Path, description: &mut Description) -> Result<Trajectory> {
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

/// Takes the lens of the sensor that is among the names, which are in small letters.
fn set_lens(found: &mut Found<'_>, names: &str) -> Result<()> {
    let is_named = |(sensor, _, _): &(&str, [f64; 4], [f64; 5])| {
        names.contains(sensor) || names.contains(&sensor.replace("freiburg", "fr"))
    };
    let Some((name, lens, bent)) = SENSORS.into_iter().find(is_named) else {
        return found.set_lens_of(&PRIME_SENSE, DEPTH_UNIT);
    };
    found.set_lens_of(&Benchmark { name, lens, ..PRIME_SENSE }, DEPTH_UNIT)?;
    let is_stated = found.here_or_above(INTRINSICS).is_some();
    if bent != [0.0; 5] && !is_stated {
        found.description.lens = format!("{}, distortion {bent:?}", found.description.lens);
        let [k1, k2, p1, p2, k3] = bent;
        found.keys.camera_model = Some("OPENCV".to_owned());
        found.keys.lens = LensKeys::of(&[("k1", k1), ("k2", k2), ("p1", p1), ("p2", p2), ("k3", k3)]);
    }
    Ok(())
}
