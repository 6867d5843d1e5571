//! Kubric's renders.
//!
//! Source: the files that its workers write: `rgba_%05d.png`, `depth_%05d.tiff` of distances along the ray, `metadata.json` with
//! `camera.positions`, `camera.quaternions` (w, x, y, z), `focal_length` and `sensor_width` in one unit; camera to world, x right, y up,
//! looking along −z; z is up.

use serde::Deserialize;

use super::place::SourceFolder;
use super::reader::{Description, ReadSource, Reader};
use super::views::{entry, from_opengl, json, number_in, pose_of_quaternion, rig_or_recording};
use crate::capture::transforms::{Keys, PictureEntry};
use crate::error::{Error, Result};

const METADATA: &str = "metadata.json";

/// Kubric.
pub(super) const KUBRIC: Reader = Reader {
    source: "Kubric",
    marks: "metadata.json beside rgba_*.png and depth_*.tiff (Kubric)",
    stands_for_folder: |file| file == METADATA,
    is_here: |place| place.has(METADATA) && place.names().any(is_color),
    poses: "camera to world; camera x right, y up, looking along −z; z is up",
    depth: "distance along the ray, TIFF",
    lens: "",
    read,
};

#[derive(Deserialize)]
struct KubricMetadata {
    camera: KubricCamera,
}

#[derive(Deserialize)]
struct KubricCamera {
    positions: Vec<[f64; 3]>,
    /// w, x, y, z.
    quaternions: Vec<[f64; 4]>,
    focal_length: f64,
    sensor_width: f64,
}

fn read(place: &SourceFolder, mut description: Description) -> Result<ReadSource> {
    let path = place.join(METADATA);
    let KubricMetadata { camera } = json(&path)?;
    description.lens = format!("{} over a sensor of {}", camera.focal_length, camera.sensor_width);
    let is_lens = |value: f64| value.is_finite() && value > 0.0;
    if !is_lens(camera.focal_length) || !is_lens(camera.sensor_width) {
        return Err(Error::invalid(
            path.display(),
            "camera.focal_length and sensor_width have to be above 0",
        ));
    }
    let mut frames = Vec::new();
    for name in place.names().filter(|name| is_color(name)) {
        let stem = name.trim_start_matches("rgba_").trim_end_matches(".png");
        let depth = format!("depth_{stem}.tiff");
        let number = number_in(name).unwrap_or(0);
        let index = usize::try_from(number).unwrap_or(usize::MAX);
        let pose = camera.positions.get(index).zip(camera.quaternions.get(index));
        let pose = pose.and_then(|(at, [w, x, y, z])| pose_of_quaternion([*x, *y, *z, *w], *at));
        let (Some(pose), true) = (pose, place.has(&depth)) else {
            description.skip("without depth or a pose", name);
            continue;
        };
        let keys = Keys { camera: Some("camera".to_owned()), frame: Some(number as f64), ..Keys::default() };
        frames.push(PictureEntry { keys, ..entry(name.to_owned(), Some(depth), &from_opengl(&pose)) });
    }
    let keys = Keys {
        camera_angle_x: Some(2.0 * (0.5 * camera.sensor_width / camera.focal_length).atan()),
        depth_kind: Some("ray_distance".to_owned()),
        depth_unit_scale_factor: Some(1.0),
        ..Keys::default()
    };
    rig_or_recording(place, keys, frames, description, vec![path])
}

fn is_color(name: &str) -> bool {
    name.starts_with("rgba_") && name.to_ascii_lowercase().ends_with(".png")
}
