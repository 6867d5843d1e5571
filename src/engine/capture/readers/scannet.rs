//! `ScanNet` as its own reader exports it.
//!
//! Source: Dai et al.: `ScanNet`, CVPR 2017, and its `SensReader`: `color/N.jpg`, `depth/N.png` in millimeters and of its own size,
//! `pose/N.txt` of 4×4 numbers, camera to world, x right, y down, z forward, `-inf` where tracking was lost,
//! `intrinsic/intrinsic_color.txt` and `intrinsic_depth.txt`. Depth is registered to color in space, not in size.

use super::place::Place;
use super::reader::{Description, Reader, Reading};
use super::text::TextFile;
use super::views::{MILLIMETERS, OPENCV_POSES, colors_in, entry, lens, pose_of_rows, recording, stem};
use crate::capture::transforms::{DepthCameraKeys, Keys};
use crate::error::{Error, Result};

/// `ScanNet`'s export.
pub(super) struct ScanNet;

impl Reader for ScanNet {
    fn source(&self) -> &'static str {
        "ScanNet export"
    }

    fn marks(&self) -> &'static str {
        "color/, depth/, pose/ and intrinsic/ (ScanNet)"
    }

    fn recognizes(&self, place: &Place) -> bool {
        place.file.is_none() && place.has_all(&["color", "depth", "pose", "intrinsic"])
    }

    fn read(&self, place: &Place) -> Result<Reading> {
        let mut inputs = Vec::new();
        let mut lens_of = |name: &str| {
            let path = place.join(&format!("intrinsic/{name}"));
            let numbers = TextFile::read(&path)?.numbers()?;
            // Four or three numbers a line.
            let columns = if numbers.len() >= 16 { 4 } else { 3 };
            if numbers.len() < 9 {
                return Err(Error::invalid(path.display(), "there is no matrix of 3×3 or 4×4 numbers"));
            }
            inputs.push(path);
            Ok([numbers[0], numbers[columns + 1], numbers[2], numbers[columns + 2]])
        };
        let [fx, fy, cx, cy] = lens_of("intrinsic_color.txt")?;
        let [depth_fx, depth_fy, depth_cx, depth_cy] = lens_of("intrinsic_depth.txt")?;
        let mut description = Description {
            source: self.source().to_owned(),
            poses: OPENCV_POSES.to_owned(),
            depth: MILLIMETERS.to_owned(),
            lens: format!("color {fx} {fy} {cx} {cy}; depth {depth_fx} {depth_fy} {depth_cx} {depth_cy}"),
            ..Description::default()
        };
        let mut frames = Vec::new();
        for name in colors_in(&place.join("color")) {
            let stem = stem(&name);
            let path = place.join(&format!("pose/{stem}.txt"));
            let depth = format!("depth/{stem}.png");
            if !path.is_file() || !place.join(&depth).is_file() {
                description.skip("without a pose or depth", name);
                continue;
            }
            let pose = pose_of_rows(&TextFile::read(&path)?.numbers()?);
            inputs.push(path);
            match pose {
                Some(pose) => frames.push(entry(format!("color/{name}"), Some(depth), &pose)),
                None => description.skip("of which tracking was lost", name),
            }
        }
        let depth_camera = DepthCameraKeys {
            fl_x: Some(depth_fx),
            fl_y: Some(depth_fy),
            cx: Some(depth_cx),
            cy: Some(depth_cy),
            pixel_center_offset: Some(0.0),
            ..DepthCameraKeys::default()
        };
        let keys = Keys {
            depth_unit_scale_factor: Some(1e-3),
            depth_camera: Some(Box::new(depth_camera)),
            ..lens(fx, fy, cx, cy, 0.0)
        };
        recording(place, keys, frames, description, inputs)
    }
}
