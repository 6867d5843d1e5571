//! 3D Scanner App's "All data" export.
//!
//! Source: the files that the app writes, as several programs read them: `frame_%05d.jpg` and `frame_%05d.json` of
//! `cameraPoseARFrame` (16 numbers row by row, camera to world; x right, y up, looking along −z; world y up, meters) and
//! `intrinsics` (9 numbers row by row); `depth_%05d.png` in millimeters, of its own size; `conf_%05d.png` of 0, 1, 2. There are fewer
//! JPEG files than files of depth.

use serde::Deserialize;

use super::place::SourceFolder;
use super::reader::{Description, ReadSource, Reader};
use super::views::{
    ARKIT_POSES, MILLIMETERS, digits_between, entry, from_opengl, json, lens, pose_of_rows, recording,
};
use crate::capture::transforms::{Keys, PictureEntry};
use crate::error::Result;

/// 3D Scanner App.
pub(super) const SCANNER_APP: Reader = Reader {
    source: "3D Scanner App",
    marks: "frame_*.json beside depth_*.png (3D Scanner App)",
    stands_for_folder: |file| number(file).is_some(),
    is_here: |place| {
        let is_first = |name: &str| number(name).is_some_and(|number| place.has(&depth(number)));
        place.names().any(is_first)
    },
    poses: ARKIT_POSES,
    depth: "",
    lens: "intrinsics of every picture",
    read,
};

#[derive(Default, Deserialize)]
#[serde(rename_all = "camelCase")]
struct FrameFile {
    #[serde(rename = "cameraPoseARFrame")]
    pose: Vec<f64>,
    intrinsics: Vec<f64>,
}

fn read(place: &SourceFolder, mut description: Description) -> Result<ReadSource> {
    description.depth = format!("{MILLIMETERS}, of its own size; what the sensor is unsure of is left out");
    let (mut frames, mut inputs) = (Vec::new(), Vec::new());
    for name in place.names() {
        let Some(number) = number(name) else { continue };
        let (color, depth) = (format!("frame_{number}.jpg"), depth(number));
        if !place.has(&color) || !place.has(&depth) {
            description.skip("without color or depth", name);
            continue;
        }
        let path = place.join(name);
        let frame = json::<FrameFile>(&path).unwrap_or_default();
        let ([fx, _, cx, _, fy, cy, ..], 16) = (&frame.intrinsics[..], frame.pose.len()) else {
            description.skip("whose intrinsics are not 9 numbers, or cameraPoseARFrame not 16", name);
            continue;
        };
        let Some(pose) = pose_of_rows(&frame.pose) else {
            description.skip("taken while tracking was lost", name);
            continue;
        };
        let confidence = format!("conf_{number}.png");
        frames.push(PictureEntry {
            confidence_file_path: place.has(&confidence).then_some(confidence),
            keys: lens(*fx, *fy, *cx, *cy, 0.5),
            ..entry(color, Some(depth), &from_opengl(&pose))
        });
        inputs.push(path);
    }
    let (depth_unit_scale_factor, up) = (Some(1e-3), Some([0.0, 1.0, 0.0]));
    let keys = Keys { depth_unit_scale_factor, up, noise_free: Some(false), ..Keys::default() };
    recording(place, keys, frames, description, inputs)
}

/// The digits of `frame_%05d.json`.
fn number(name: &str) -> Option<&str> {
    digits_between("frame_", name, ".json")
}

fn depth(number: &str) -> String {
    format!("depth_{number}.png")
}
