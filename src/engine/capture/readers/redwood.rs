//! RGB-D sequences of `Open3D` and Redwood.
//!
//! Source: `Open3D`'s `FileLOG.cpp`, `FileJSON.cpp` and its reconstruction system: `color/` or `image/`, `depth/` in millimeters,
//! `trajectory.log` (for each frame three whole numbers and 4×4 numbers, camera to world) or `camera_trajectory.json` (world to
//! camera, column by column); x right, y down, z forward. Pixel centers lie at whole numbers.

use serde::Deserialize;

use super::place::Place;
use super::reader::{Description, Reader, Reading};
use super::text::TextFile;
use super::views::{
    MILLIMETERS, OPENCV_POSES, colors_in, entry, json, lens, pictures_in, pose_of_rows, recording,
};
use crate::capture::transforms::Keys;
use crate::error::{Error, Result};
use crate::plural::counted;

/// Names of files of poses.
const LOGS: [&str; 3] = ["trajectory.log", "camera_trajectory.json", "Extrinsics_Open3D.log"];
/// Names of files of the lens.
const INTRINSICS: [&str; 3] = ["camera_intrinsic.json", "intrinsic.json", "camera_intrinsics.json"];

/// Of `Open3D` and Redwood.
pub(super) struct Redwood;

/// `PinholeCameraIntrinsic` of `Open3D`, and what its recorders write beside it.
#[derive(Deserialize)]
struct Intrinsics {
    /// Column by column.
    intrinsic_matrix: Vec<f64>,
    #[serde(default)]
    depth_scale: Option<f64>,
}

#[derive(Deserialize)]
struct Trajectory {
    parameters: Vec<Parameters>,
}

#[derive(Deserialize)]
struct Parameters {
    /// World to camera, column by column.
    extrinsic: Vec<f64>,
}

impl Reader for Redwood {
    fn source(&self) -> &'static str {
        "Open3D / Redwood RGB-D"
    }

    fn marks(&self) -> &'static str {
        "trajectory.log or camera_trajectory.json beside color/ (or image/) and depth/ (Open3D, Redwood)"
    }

    fn recognizes(&self, place: &Place) -> bool {
        let is_ours = place.file.as_deref().is_none_or(|file| LOGS.contains(&file));
        is_ours && LOGS.iter().any(|log| place.has(log)) && place.has("depth")
    }

    fn read(&self, place: &Place) -> Result<Reading> {
        let named =
            LOGS.into_iter().find(|log| place.file.as_deref().map_or(place.has(log), |file| file == *log));
        let log = place.join(named.unwrap_or(LOGS[0]));
        let folder = ["color", "image", "rgb"].into_iter().find(|name| place.has(name)).unwrap_or("color");
        let colors = colors_in(&place.join(folder));
        let depths = pictures_in(&place.join("depth"), &[".png", ".pgm"]);
        let mut description = Description {
            source: self.source().to_owned(),
            poses: OPENCV_POSES.to_owned(),
            depth: MILLIMETERS.to_owned(),
            ..Description::default()
        };
        let mut inputs = vec![log.clone()];
        let (lens, scale) = read_lens(place, &mut description, &mut inputs)?;
        let poses = if log.extension().is_some_and(|ending| ending == "json") {
            poses_of_json(&log)?
        } else {
            poses_of_log(&log)?
        };
        let mut frames = Vec::new();
        for (index, color) in colors.iter().enumerate() {
            let pose = poses.iter().find(|(number, _)| *number == index).map(|(_, rows)| rows);
            match (pose, depths.get(index)) {
                (Some(rows), Some(depth)) => match pose_of_rows(rows) {
                    Some(pose) => {
                        frames.push(entry(
                            format!("{folder}/{color}"),
                            Some(format!("depth/{depth}")),
                            &pose,
                        ));
                    }
                    None => description.skip("without a rigid pose", color.clone()),
                },
                (None, _) => description.skip("without a pose", color.clone()),
                (_, None) => description.skip("without depth", color.clone()),
            }
        }
        let keys = Keys { depth_unit_scale_factor: Some(1.0 / scale), ..lens };
        recording(place, keys, frames, description, inputs)
    }
}

/// The number of each frame, and its pose, camera to world, row by row.
type Poses = Vec<(usize, Vec<f64>)>;

fn poses_of_log(path: &std::path::Path) -> Result<Poses> {
    const NUMBERS: usize = 3 + 16;
    let file = TextFile::read(path)?;
    // LiveScan3D writes the 16 numbers into one line.
    let numbers = file.numbers()?;
    if numbers.is_empty() || numbers.len() % NUMBERS != 0 {
        let (whole, rest) = (numbers.len() / NUMBERS, numbers.len() % NUMBERS);
        let what = format!(
            "{} too many behind pose {whole}, counted from 0; a pose has 3 whole numbers and 16 more",
            counted(rest, "number")
        );
        return Err(Error::invalid(path.display(), what));
    }
    Ok(numbers.chunks_exact(NUMBERS).map(|pose| (pose[0] as usize, pose[3..].to_vec())).collect())
}

fn poses_of_json(path: &std::path::Path) -> Result<Poses> {
    let trajectory: Trajectory = json(path)?;
    let pose = |(index, parameters): (usize, Parameters)| {
        let e = parameters.extrinsic;
        let rows: Vec<f64> = (0..16).filter_map(|i| e.get(i % 4 * 4 + i / 4).copied()).collect();
        let Some(camera_from_world) = pose_of_rows(&rows).filter(|_| e.len() == 16) else {
            let what = format!("parameters[{index}].extrinsic is no rigid pose of 16 numbers");
            return Err(Error::invalid(path.display(), what));
        };
        let inverse = camera_from_world.inverse();
        let m = inverse.matrix3;
        let row = |i: usize| [m.x_axis[i], m.y_axis[i], m.z_axis[i], inverse.translation[i]];
        Ok((index, [row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]].concat()))
    };
    trajectory.parameters.into_iter().enumerate().map(pose).collect()
}

/// The lens, and depth units per meter.
fn read_lens(
    place: &Place,
    description: &mut Description,
    inputs: &mut Vec<std::path::PathBuf>,
) -> Result<(Keys, f64)> {
    let Some(name) = place.first_of(&INTRINSICS) else {
        description.lens = String::from("the sensor's default: 525 525 319.5 239.5");
        return Ok((lens(525.0, 525.0, 319.5, 239.5, 0.0), 1000.0));
    };
    let path = place.join(name);
    let Intrinsics { intrinsic_matrix, depth_scale } = json(&path)?;
    let [fx, _, _, _, fy, _, cx, cy, _] = intrinsic_matrix[..] else {
        let what = format!(
            "intrinsic_matrix has {}; 9 are expected, column by column",
            counted(intrinsic_matrix.len(), "number")
        );
        return Err(Error::invalid(path.display(), what));
    };
    description.lens = format!("{name}: {fx} {fy} {cx} {cy}");
    let scale = depth_scale.unwrap_or(1000.0);
    if scale != 1000.0 {
        description.depth = format!("planar z in 1/{scale} m, 16-bit PNG; 0 is no depth");
    }
    inputs.push(path);
    Ok((lens(fx, fy, cx, cy, 0.0), scale))
}
