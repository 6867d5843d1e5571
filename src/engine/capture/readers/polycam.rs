//! Polycam's raw data.
//!
//! Source: `PolyCam/polyform`, and the files that the app writes: `keyframes/` of `images/` and `cameras/`, and of
//! `corrected_images/` and `corrected_cameras/`, whose lens distortion is undone; `depth/` in millimeters, of its own size;
//! `confidence/` of 0, 127, 255. A camera is a JSON file of `fx fy cx cy width height` and `t_00` to `t_23`, camera to world;
//! x right, y up, looking along −z; world y up, meters.

use serde_json::{Map, Value};

use super::place::SourceFolder;
use super::reader::{Description, ReadSource, Reader};
use super::views::{
    ARKIT_POSES, MILLIMETERS, entry, from_opengl, json, lens, pictures_in, pose_of_rows, recording, stem,
};
use crate::capture::transforms::{Keys, PictureEntry};
use crate::error::Result;

/// Polycam.
pub(super) const POLYCAM: Reader = Reader {
    source: "Polycam raw data",
    marks: "keyframes/ with cameras/, images/ and depth/ (Polycam)",
    stands_for_folder: |_| false,
    is_here: |place| root(place).is_some(),
    poses: ARKIT_POSES,
    depth: "",
    lens: "",
    read,
};

fn read(place: &SourceFolder, mut description: Description) -> Result<ReadSource> {
    let root = root(place).unwrap_or_default();
    let has = |name: &str| place.join(&format!("{root}{name}")).is_dir();
    let is_corrected = has("corrected_cameras") && has("corrected_images");
    let prefix = if is_corrected { "corrected_" } else { "" };
    description.depth = format!("{MILLIMETERS}, of its own size; what the sensor is unsure of is left out");
    description.lens =
        if is_corrected { "of every picture, its distortion undone" } else { "of every picture" }.into();
    let mut inputs = Vec::new();
    let mut frames = Vec::new();
    for name in pictures_in(&place.join(&format!("{root}{prefix}cameras")), &[".json"]) {
        let stem = stem(&name);
        let in_folder = |folder: &str, ending: &str| {
            let path = format!("{root}{folder}/{stem}.{ending}");
            place.join(&path).is_file().then_some(path)
        };
        let color =
            ["jpg", "jpeg", "png"].iter().find_map(|ending| in_folder(&format!("{prefix}images"), ending));
        let (Some(color), Some(depth)) = (color, in_folder("depth", "png")) else {
            description.skip("cameras without a picture or depth", name);
            continue;
        };
        let path = place.join(&format!("{root}{prefix}cameras/{name}"));
        let Some((rows, keys)) = json(&path).ok().and_then(|camera| rows_and_lens(&camera)) else {
            description.skip("whose camera cannot be read", name);
            continue;
        };
        let Some(pose) = pose_of_rows(&rows) else {
            description.skip("without a rigid pose", color);
            continue;
        };
        frames.push(PictureEntry {
            confidence_file_path: in_folder("confidence", "png"),
            keys,
            ..entry(color, Some(depth), &from_opengl(&pose))
        });
        inputs.push(path);
    }
    let (depth_unit_scale_factor, up) = (Some(1e-3), Some([0.0, 1.0, 0.0]));
    let keys = Keys { depth_unit_scale_factor, up, noise_free: Some(false), ..Keys::default() };
    recording(place, keys, frames, description, inputs)
}

/// The rows of a camera's pose, and its lens; `None` where a number is missing.
fn rows_and_lens(camera: &Map<String, Value>) -> Option<(Vec<f64>, Keys)> {
    let number = |key: &str| camera.get(key).and_then(Value::as_f64);
    let cells = (0..3).flat_map(|row| (0..4).map(move |column| format!("t_{row}{column}")));
    let rows: Vec<f64> = cells.map(|cell| number(&cell)).collect::<Option<_>>()?;
    let lens = lens(number("fx")?, number("fy")?, number("cx")?, number("cy")?, 0.5);
    Some((rows, Keys { w: Some(number("width")?), h: Some(number("height")?), ..lens }))
}

/// The folder of the keyframes below the source's: `""`, or a path that ends in `/`.
fn root(place: &SourceFolder) -> Option<String> {
    let is_root = |root: &&&str| {
        let has = |name: &str| place.join(&format!("{root}{name}")).is_dir();
        has("depth") && (has("cameras") && has("images") || has("corrected_cameras"))
    };
    ["", "keyframes/"].iter().find(is_root).map(|root| (*root).to_owned())
}
