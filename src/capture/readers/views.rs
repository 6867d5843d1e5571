//! From poses and file names to entries of a manifest.

use std::collections::BTreeSet;

use glam::{DAffine3, DQuat, DVec3, DVec4};

use crate::capture::transforms::{Keys, PictureEntry, opengl_matrix};

/// How far a quaternion's length, squared, may be from 1.
const RIGID_TOLERANCE: f64 = 1e-2;

/// The pose of a unit quaternion `x y z w` and a translation; `None` where the quaternion is not of length 1, or a number is not
/// finite, as trackers write that are lost.
pub(super) fn pose_of_quaternion(xyzw: [f64; 4], translation: [f64; 3]) -> Option<DAffine3> {
    let quaternion = DVec4::from(xyzw);
    let is_unit = (quaternion.length_squared() - 1.0).abs() < RIGID_TOLERANCE;
    let translation = DVec3::from(translation);
    (is_unit && translation.is_finite())
        .then(|| DAffine3::from_rotation_translation(DQuat::from_vec4(quaternion).normalize(), translation))
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

/// The keys of a pinhole of the picture's size. `pixel_center_offset` is where the first pixel's center lies in the units of the
/// principal point: 0.5, or 0 as `OpenCV` has it.
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
