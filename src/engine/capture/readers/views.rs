//! From poses and file names to entries of a manifest.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use glam::{DAffine3, DMat3, DQuat, DVec3, DVec4};

use super::place::{SourceFolder, names_in};
use super::reader::{Description, ReadSource, SaidBy};
use crate::capture::transforms::{Keys, Manifest, ManifestOrigin, PictureEntry, opengl_matrix};
use crate::error::{Error, Result};
use crate::whole_file;

/// How far a quaternion's length, squared, may be from 1, and the axes of a matrix from orthonormal.
const RIGID_TOLERANCE: f64 = 1e-2;

/// Length of the mean of the cameras' up below which they do not agree on one.
const LEAST_AGREEMENT: f64 = 0.1;

/// The pose of a unit quaternion `x y z w` and a translation; `None` where the quaternion is not of length 1, or a number is not
/// finite, as trackers write that are lost.
pub(super) fn pose_of_quaternion(xyzw: [f64; 4], translation: [f64; 3]) -> Option<DAffine3> {
    let quaternion = DVec4::from(xyzw);
    let is_unit = (quaternion.length_squared() - 1.0).abs() < RIGID_TOLERANCE;
    let translation = DVec3::from(translation);
    (is_unit && translation.is_finite())
        .then(|| DAffine3::from_rotation_translation(DQuat::from_vec4(quaternion).normalize(), translation))
}

/// The pose of 12 or 16 numbers row by row; `None` where it is not rigid, or a number is not finite.
pub(super) fn pose_of_rows(rows: &[f64]) -> Option<DAffine3> {
    let [a, b, c, x, d, e, f, y, g, h, i, z, ..] = *rows else { return None };
    let matrix = DMat3::from_cols(DVec3::new(a, d, g), DVec3::new(b, e, h), DVec3::new(c, f, i));
    let is_rigid = (matrix.transpose() * matrix).abs_diff_eq(DMat3::IDENTITY, RIGID_TOLERANCE)
        && matrix.determinant() > 0.0;
    let translation = DVec3::new(x, y, z);
    // Newton's iteration for the nearest rotation.
    let turn = |matrix: DMat3| (matrix + matrix.inverse().transpose()) * 0.5;
    (is_rigid && translation.is_finite())
        .then(|| DAffine3::from_mat3_translation(turn(turn(turn(matrix))), translation))
}

/// An entry without keys of its own. `world_from_camera` has our axes: x right, y down, z forward.
pub(super) fn entry(color: String, depth: Option<String>, world_from_camera: &DAffine3) -> PictureEntry {
    PictureEntry {
        file_path: color,
        depth_file_path: depth,
        transform_matrix: opengl_matrix(world_from_camera),
        ..PictureEntry::default()
    }
}

/// The pose of our axes (x right, y down, z forward) from one of OpenGL's (x right, y up, looking along −z).
pub(super) fn from_opengl(world_from_camera: &DAffine3) -> DAffine3 {
    *world_from_camera * DAffine3::from_scale(DVec3::new(1.0, -1.0, -1.0))
}

/// The mean of the cameras' up, unit length; `None` without cameras, or where it is undecided.
pub(super) fn mean_up(frames: &[PictureEntry]) -> Option<DVec3> {
    let up = |frame: &PictureEntry| {
        let rows = &frame.transform_matrix;
        DVec3::from_array(std::array::from_fn(|row| {
            rows.get(row).and_then(|row| row.get(1)).copied().unwrap_or(0.0)
        }))
    };
    let sum: DVec3 = frames.iter().map(up).sum();
    (sum.length() > LEAST_AGREEMENT * frames.len() as f64).then(|| sum.normalize_or_zero())
}

/// The axis of the world, with its sign, that is nearest to a direction.
pub(super) fn nearest_axis(direction: DVec3) -> DVec3 {
    let axis =
        DVec3::AXES.into_iter().max_by(|a, b| a.dot(direction).abs().total_cmp(&b.dot(direction).abs()));
    axis.map_or(DVec3::Z, |axis| axis * axis.dot(direction).signum())
}

/// The keys of a pinhole of the picture's size. `pixel_center_offset` is the first pixel's center in the units of the principal
/// point: 0.5, or 0 as in `OpenCV`.
pub(super) fn lens(fx: f64, fy: f64, cx: f64, cy: f64, pixel_center_offset: f64) -> Keys {
    Keys {
        fl_x: Some(fx),
        fl_y: Some(fy),
        cx: Some(cx),
        cy: Some(cy),
        pixel_center_offset: Some(pixel_center_offset),
        ..Keys::default()
    }
}

/// Makes each entry a camera of its own at frame 0, named as its picture where no two are named alike.
pub(super) fn name_as_views(entries: &mut [PictureEntry]) {
    let stem = |entry: &PictureEntry| {
        let name = entry.file_path.rsplit('/').next().unwrap_or_default();
        let stem = name.rsplit_once('.').map_or(name, |(stem, _)| stem);
        stem.replace(char::is_control, "_")
    };
    let stems: BTreeSet<String> = entries.iter().map(stem).collect();
    let are_distinct = stems.len() == entries.len();
    for (index, entry) in entries.iter_mut().enumerate() {
        let name = if are_distinct { stem(entry) } else { format!("view{index}") };
        entry.keys.camera = Some(name);
        entry.keys.frame = Some(0.0);
    }
}

/// The read source of a recording by one moving camera, with paths relative to the folder.
///
/// # Errors
/// `Invalid` where no picture is left.
pub(super) fn recording(
    place: &SourceFolder,
    keys: Keys,
    mut frames: Vec<PictureEntry>,
    mut description: Description,
    inputs: Vec<PathBuf>,
) -> Result<ReadSource> {
    if frames.is_empty() {
        let path = inputs.first().unwrap_or(&place.folder);
        let why = description.skipped.first().map_or_else(String::new, |skipped| {
            format!(": {} {} (first: {})", skipped.count, skipped.reason, skipped.first)
        });
        let what = format!("no picture has color, depth and a pose{why}");
        return Err(Error::invalid(path.display(), what));
    }
    name_as_views(&mut frames);
    description.is_recording = true;
    Ok(read_source(place, Manifest { keys, frames, path_easing: None }, description, inputs))
}

/// The read source of a manifest whose paths are relative to the folder.
fn read_source(
    place: &SourceFolder,
    manifest: Manifest,
    mut description: Description,
    inputs: Vec<PathBuf>,
) -> ReadSource {
    let skipped: usize = description.skipped.iter().map(|skipped| skipped.count).sum();
    description.found = manifest.frames.len() + skipped;
    let path = inputs.first().cloned().unwrap_or_else(|| place.folder.clone());
    let origin = ManifestOrigin { path, folder: place.folder.clone() };
    ReadSource { manifest, origin, inputs, description, said_by: SaidBy::Layout }
}

/// The read source of pictures whose entries name camera and frame: static cameras, or one moving camera in a static scene.
///
/// # Errors
/// As [`recording`].
pub(super) fn rig_or_recording(
    place: &SourceFolder,
    keys: Keys,
    frames: Vec<PictureEntry>,
    mut description: Description,
    inputs: Vec<PathBuf>,
) -> Result<ReadSource> {
    if frames.is_empty() || is_one_that_moves(&frames) {
        description.notes.push("the scene is taken as static, as one camera moves through it".to_owned());
        return recording(place, keys, frames, description, inputs);
    }
    Ok(read_source(place, Manifest { keys, frames, path_easing: None }, description, inputs))
}

/// Whether all pictures are of one camera that moves.
fn is_one_that_moves(frames: &[PictureEntry]) -> bool {
    let Some(first) = frames.first() else { return false };
    let numbers = |frame: &PictureEntry| frame.transform_matrix.concat();
    let still = numbers(first);
    let moves = |frame: &PictureEntry| {
        numbers(frame).iter().zip(&still).any(|(a, b)| (a - b).abs() > 1e-6 * b.abs().max(1.0))
    };
    frames.iter().all(|frame| frame.keys.camera == first.keys.camera) && frames.iter().any(moves)
}

/// Axes of cameras as `OpenCV` has them, in the words of a description.
pub(super) const OPENCV_POSES: &str = "camera to world; camera x right, y down, z forward; meters";
/// Axes of cameras as Apple's `ARKit` has them.
pub(super) const ARKIT_POSES: &str =
    "camera to world; camera x right, y up, looking along −z; world y up, meters";
/// Depth of most sensors' exports.
pub(super) const MILLIMETERS: &str = "planar z in millimeters, 16-bit PNG; 0 is no depth";

/// Name of the file that the 3×3 numbers of a lens are in beside several sources' pictures.
pub(super) const INTRINSICS: &str = "camera-intrinsics.txt";

/// Endings of pictures of color.
const COLOR_ENDINGS: [&str; 3] = [".jpg", ".png", ".jpeg"];

/// The pictures in a folder in the order of their numbers; none if the folder does not exist.
pub(super) fn pictures_in(folder: &Path, endings: &[&str]) -> Vec<String> {
    let mut names = names_in(folder).unwrap_or_default();
    names.retain(|name| endings.iter().any(|ending| name.to_ascii_lowercase().ends_with(ending)));
    names
}

/// The pictures of color in a folder.
pub(super) fn colors_in(folder: &Path) -> Vec<String> {
    pictures_in(folder, &COLOR_ENDINGS)
}

/// A name without the last `.` and what follows.
pub(super) fn stem(name: &str) -> &str {
    name.rsplit_once('.').map_or(name, |(stem, _)| stem)
}

/// The number that a picture's name, without ending, ends in.
pub(super) fn number_in(name: &str) -> Option<u64> {
    let stem = stem(name);
    let digits = stem.bytes().rev().take_while(u8::is_ascii_digit).count();
    stem[stem.len() - digits..].parse().ok()
}

/// The digits of a name that has nothing but them between a start and an ending.
pub(super) fn digits_between<'a>(start: &str, name: &'a str, ending: &str) -> Option<&'a str> {
    let digits = name.strip_prefix(start)?.strip_suffix(ending)?;
    (!digits.is_empty() && digits.bytes().all(|byte| byte.is_ascii_digit())).then_some(digits)
}

/// A JSON file.
///
/// # Errors
/// `Io`, and `Invalid` with line and column where it is damaged or lacks something.
pub(super) fn json<T: serde::de::DeserializeOwned>(path: &Path) -> Result<T> {
    let bytes = whole_file::read_all(path)?;
    serde_json::from_slice(&bytes).map_err(|error| Error::invalid(path.display(), error.to_string()))
}
