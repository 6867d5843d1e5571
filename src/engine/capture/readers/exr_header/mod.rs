//! Folders of `OpenEXR` pictures with cameras in their headers, without a manifest.
//!
//! A camera is a folder of pictures, or the part of their names before the number of the frame: `left.0001.exr`, `left/0001.exr`.

mod header_camera;
mod projection;
mod unreal;

use std::collections::BTreeMap;

use super::place::{SourceFolder, names_in};
use super::reader::{Description, ReadSource, Reader};
use super::views::{entry, lens, rig_or_recording, stem};
use crate::capture::exr::HeaderAttributes;
use crate::capture::transforms::{Keys, PictureEntry};
use crate::error::Result;

/// Pictures of renderers that write their camera into them.
pub(super) const EXR_HEADER: Reader = Reader {
    source: "OpenEXR with cameras in the headers",
    marks: "*.exr with unreal/camera, worldToScreen or worldToNDC in the header (Unreal, Arnold, Karma)",
    stands_for_folder: is_exr,
    is_here: |place| {
        let first = place.file.clone().or_else(|| pictures(place).first().map(|it| it.path.clone()));
        let header = first.and_then(|name| HeaderAttributes::read(&place.join(&name)).ok());
        header.is_some_and(|header| unreal::is_of(&header) || projection::is_of(&header))
    },
    poses: "world to picture, a matrix that holds pose and lens",
    depth: "planar z in world units",
    lens: "from the same matrix",
    read,
};

/// A picture: its path below the place, its camera, the number of its frame.
struct HeaderPicture {
    path: String,
    camera: String,
    number: i64,
}

fn read(place: &SourceFolder, mut description: Description) -> Result<ReadSource> {
    let pictures = pictures(place);
    let is_unreal = unreal::is_of(&HeaderAttributes::read(&place.join(&pictures[0].path))?);
    if is_unreal {
        description.source = String::from("Unreal Engine, Movie Render Queue");
        description.poses = String::from(
            "position and yaw, pitch, roll of unreal/camera; left-handed, x forward, y right, z up; centimeters, read as meters",
        );
        description.depth = String::from("planar z in centimeters, WorldDepth");
        description.lens = String::from("focalLength over sensorWidth of unreal/camera");
    }
    let (mut frames, mut first_error) = (Vec::new(), None);
    for picture in &pictures {
        let path = place.join(&picture.path);
        let read = |header: HeaderAttributes| {
            let camera = if is_unreal { unreal::camera } else { projection::camera };
            Ok((camera(&header, &path)?, header.size))
        };
        let (camera, (width, height)) = match HeaderAttributes::read(&path).and_then(read) {
            Ok(found) => found,
            Err(error) => {
                description.skip("whose header cannot be read", picture.path.clone());
                first_error.get_or_insert(error);
                continue;
            }
        };
        let [fx, fy, cx, cy] = camera.lens;
        let keys = Keys {
            camera: Some(picture.camera.clone()),
            frame: Some(picture.number as f64),
            w: Some(width as f64),
            h: Some(height as f64),
            ..lens(fx, fy, cx, cy, 0.5)
        };
        frames.push(PictureEntry { keys, ..entry(picture.path.clone(), None, &camera.world_from_camera) });
    }
    if let (Some(error), true) = (first_error, frames.is_empty()) {
        return Err(error);
    }
    let inputs = pictures.iter().map(|picture| place.join(&picture.path)).collect();
    rig_or_recording(place, keys_of_all(is_unreal), frames, description, inputs)
}

/// What holds for all pictures.
fn keys_of_all(is_unreal: bool) -> Keys {
    Keys {
        depth_unit_scale_factor: Some(if is_unreal { 0.01 } else { 1.0 }),
        // In Arnold's and Karma's worlds, y is up.
        up: Some(if is_unreal { unreal::UP } else { [0.0, 1.0, 0.0] }),
        ..Keys::default()
    }
}

fn is_exr(name: &str) -> bool {
    name.to_ascii_lowercase().ends_with(".exr")
}

/// The pictures of the place and of the folders in it, by cameras and frames.
fn pictures(place: &SourceFolder) -> Vec<HeaderPicture> {
    let mut by_camera: BTreeMap<String, Vec<HeaderPicture>> = BTreeMap::new();
    let mut add = |folder: &str, name: &str| {
        let stem = stem(name);
        let digits = stem.bytes().rev().take_while(u8::is_ascii_digit).count();
        let (start, number) = stem.split_at(stem.len() - digits);
        let start = start.trim_end_matches(['.', '_', '-', ' ']);
        let camera =
            [folder, start].into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join("/");
        let camera = if camera.is_empty() { "camera".to_owned() } else { camera };
        let path = if folder.is_empty() { name.to_owned() } else { format!("{folder}/{name}") };
        let picture = HeaderPicture { path, camera: camera.clone(), number: number.parse().unwrap_or(0) };
        by_camera.entry(camera).or_default().push(picture);
    };
    let own: Vec<&str> = place.names().filter(|name| is_exr(name)).collect();
    for name in &own {
        add("", name);
    }
    if own.is_empty() {
        for folder in place.names() {
            let names = names_in(&place.join(folder)).unwrap_or_default();
            names.iter().filter(|name| is_exr(name)).for_each(|name| add(folder, name));
        }
    }
    let mut all: Vec<HeaderPicture> = by_camera.into_values().flatten().collect();
    all.sort_by(|a, b| (&a.camera, a.number).cmp(&(&b.camera, b.number)));
    all
}
