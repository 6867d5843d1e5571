//! Scenes in the format of the BOP benchmark, as `BlenderProc` writes them.
//!
//! Source: BOP's data format: `scene_camera.json` has for every image `cam_K` (9 numbers row by row), `depth_scale` (millimeters per
//! unit of the depth file), and optionally `cam_R_w2c` and `cam_t_w2c` (millimeters), world to camera; x right, y down, z forward;
//! `rgb/%06d.png` or `.jpg`, `depth/%06d.png`. Pixel centers lie at whole numbers. What differs: read in meters.

use std::collections::BTreeMap;

use glam::DAffine3;
use serde::Deserialize;

use super::place::Place;
use super::reader::{Description, Reader, Reading};
use super::views::{entry, json, lens, pose_of_rows, recording};
use crate::capture::transforms::{Keys, PictureEntry};
use crate::error::{Error, Result};

const CAMERAS: &str = "scene_camera.json";

/// Of the BOP benchmark.
pub(super) struct Bop;

#[derive(Deserialize)]
struct ImageFile {
    #[serde(rename = "cam_K")]
    lens: [f64; 9],
    depth_scale: f64,
    #[serde(rename = "cam_R_w2c")]
    rotation: Option<[f64; 9]>,
    #[serde(rename = "cam_t_w2c")]
    translation: Option<[f64; 3]>,
}

impl Reader for Bop {
    fn source(&self) -> &'static str {
        "BOP (BlenderProc)"
    }

    fn marks(&self) -> &'static str {
        "scene_camera.json beside rgb/ and depth/ (BOP, BlenderProc)"
    }

    fn recognizes(&self, place: &Place) -> bool {
        place.file.as_deref().is_none_or(|file| file == CAMERAS) && place.has(CAMERAS)
    }

    fn read(&self, place: &Place) -> Result<Reading> {
        let path = place.join(CAMERAS);
        let images: BTreeMap<u64, ImageFile> = json(&path)?;
        let mut description = Description {
            source: self.source().to_owned(),
            poses: "world to camera; camera x right, y down, z forward; millimeters, read as meters"
                .to_owned(),
            depth: "planar z, 16-bit PNG, depth_scale millimeters each; 0 is no depth".to_owned(),
            lens: "cam_K of every image".to_owned(),
            ..Description::default()
        };
        if images.values().all(|image| image.rotation.is_none()) {
            let what = "no image has cam_R_w2c and cam_t_w2c, which say where the camera stood; write them (BlenderProc: bproc.writer.write_bop does), or estimate poses with COLMAP";
            return Err(Error::unsupported(path.display(), what));
        }
        let mut frames = Vec::new();
        for (number, image) in &images {
            let depth = format!("depth/{number:06}.png");
            let colors = ["png", "jpg"].map(|ending| format!("rgb/{number:06}.{ending}"));
            let color = colors.into_iter().find(|color| place.join(color).is_file());
            let (Some(color), true) = (color, place.join(&depth).is_file()) else {
                description.skip("without a picture or depth", number.to_string());
                continue;
            };
            let Some(pose) = pose(image) else {
                description.skip("without a rigid pose", color);
                continue;
            };
            let [fx, _, cx, _, fy, cy, ..] = image.lens;
            let keys =
                Keys { depth_unit_scale_factor: Some(image.depth_scale * 1e-3), ..lens(fx, fy, cx, cy, 0.0) };
            frames.push(PictureEntry { keys, ..entry(color, Some(depth), &pose) });
        }
        recording(place, Keys::default(), frames, description, vec![path])
    }
}

/// World from camera in meters.
fn pose(image: &ImageFile) -> Option<DAffine3> {
    let ([a, b, c, d, e, f, g, h, i], [x, y, z]) = (image.rotation?, image.translation?);
    let [x, y, z] = [x, y, z].map(|millimeters| millimeters * 1e-3);
    pose_of_rows(&[a, b, c, x, d, e, f, y, g, h, i, z]).map(|camera_from_world| camera_from_world.inverse())
}
