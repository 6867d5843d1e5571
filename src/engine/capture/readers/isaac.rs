//! Isaac Sim's Replicator, `BasicWriter`.
//!
//! Source: the files that it writes: `rgb_%04d.png`, `distance_to_image_plane_%04d.npy` (planar) or `distance_to_camera_%04d.npy`
//! (along the ray) in meters, `camera_params_%04d.json` with `cameraViewTransform` and `cameraProjection`, 4×4 matrices behind points
//! that are rows, world to camera; x right, y up, looking along −z; `metersPerSceneUnit`. What differs: read in meters.

use glam::DAffine3;
use serde::Deserialize;

use super::place::{SourceFolder, names_in};
use super::reader::{Description, ReadSource, Reader};
use super::views::{digits_between, entry, from_opengl, json, lens, pose_of_rows, rig_or_recording};
use crate::capture::transforms::{Keys, PictureEntry};
use crate::error::Result;

/// Names of depth, and what it measures; planar comes first as it holds for every lens.
const DEPTHS: [(&str, &str); 2] =
    [("distance_to_image_plane_", "planar_z"), ("distance_to_camera_", "ray_distance")];

/// Isaac Sim.
pub(super) const ISAAC: Reader = Reader {
    source: "Isaac Sim Replicator",
    marks: "camera_params_*.json beside rgb_*.png and distance_to_*.npy (Isaac Sim)",
    stands_for_folder: |file| number(file).is_some(),
    is_here: |place| !folders(place).is_empty(),
    poses: "world to camera; camera x right, y up, looking along −z; units of the scene, read as meters",
    depth: "meters, NumPy; 0 is no depth, infinity that nothing was hit",
    lens: "cameraProjection of every picture",
    read,
};

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct IsaacCamera {
    camera_view_transform: [f64; 16],
    camera_projection: [f64; 16],
    render_product_resolution: [f64; 2],
    #[serde(default)]
    meters_per_scene_unit: Option<f64>,
}

fn read(place: &SourceFolder, mut description: Description) -> Result<ReadSource> {
    let (mut frames, mut inputs) = (Vec::new(), Vec::new());
    for folder in folders(place) {
        let at = |name: &str| if folder.is_empty() { name.to_owned() } else { format!("{folder}/{name}") };
        for name in names_in(&place.join(&folder))? {
            let Some(number) = number(&name) else { continue };
            let color = at(&format!("rgb_{number}.png"));
            let depths = DEPTHS.map(|(start, kind)| (at(&format!("{start}{number}.npy")), kind));
            let depth = depths.into_iter().find(|(path, _)| place.join(path).is_file());
            let (Some((depth, kind)), true) = (depth, place.join(&color).is_file()) else {
                description.skip("without a picture or depth", at(&name));
                continue;
            };
            let path = place.join(&at(&name));
            let Ok(camera) = json::<IsaacCamera>(&path) else {
                description.skip("whose camera cannot be read", at(&name));
                continue;
            };
            let keys = Keys {
                camera: Some(if folder.is_empty() { "camera".to_owned() } else { folder.clone() }),
                frame: number.parse().ok(),
                depth_kind: Some(kind.to_owned()),
                ..keys_of(&camera)
            };
            let Some(pose) = pose(&camera) else {
                description.skip("without a rigid pose", at(&name));
                continue;
            };
            frames.push(PictureEntry { keys, ..entry(color, Some(depth), &pose) });
            inputs.push(path);
        }
    }
    let keys = Keys { depth_unit_scale_factor: Some(1.0), ..Keys::default() };
    rig_or_recording(place, keys, frames, description, inputs)
}

fn keys_of(camera: &IsaacCamera) -> Keys {
    let [width, height] = camera.render_product_resolution;
    let p = &camera.camera_projection;
    let [fx, fy] = [0.5 * width * p[0], 0.5 * height * p[5]];
    let [cx, cy] = [0.5 * width * (1.0 - p[8]), 0.5 * height * (1.0 + p[9])];
    Keys { w: Some(width), h: Some(height), ..lens(fx, fy, cx, cy, 0.5) }
}

/// World from camera in meters.
fn pose(camera: &IsaacCamera) -> Option<DAffine3> {
    let m = &camera.camera_view_transform;
    let rows: Vec<f64> = (0..16).map(|index| m[index % 4 * 4 + index / 4]).collect();
    let mut pose = pose_of_rows(&rows)?.inverse();
    pose.translation *= camera.meters_per_scene_unit.filter(|unit| *unit > 0.0).unwrap_or(1.0);
    Some(from_opengl(&pose))
}

/// The digits of `camera_params_%04d.json`.
fn number(name: &str) -> Option<&str> {
    digits_between("camera_params_", name, ".json")
}

/// The folders of cameras: the place itself, or those in it.
fn folders(place: &SourceFolder) -> Vec<String> {
    if place.names().any(|name| number(name).is_some()) {
        return vec![String::new()];
    }
    let has_cameras = |name: &&str| {
        let names = names_in(&place.join(name)).unwrap_or_default();
        names.iter().any(|name| number(name).is_some())
    };
    place.names().filter(|name| !name.contains('.')).filter(has_cameras).map(str::to_owned).collect()
}
