//! 7-Scenes and data sets in its layout (`BundleFusion`, `tsdf-fusion-python`).
//!
//! Source: Shotton et al.: Scene Coordinate Regression Forests, CVPR 2013, and its files: `frame-%06d.color.png`, `.depth.png` in
//! millimeters with 0 and 65535 for no depth, `.pose.txt` of 4×4 numbers, camera to world; x right, y down, z forward.

use super::place::{Place, names_in};
use super::reader::{Description, Reader, Reading};
use super::text::TextFile;
use super::views::{MILLIMETERS, OPENCV_POSES, entry, lens, pose_of_rows, recording};
use crate::capture::transforms::Keys;
use crate::error::{Error, Result};
use crate::plural::counted;

/// Name of the file of the lens, where there is one.
const INTRINSICS: &str = "camera-intrinsics.txt";

/// 7-Scenes.
pub(super) struct SevenScenes;

impl Reader for SevenScenes {
    fn source(&self) -> &'static str {
        "7-Scenes"
    }

    fn marks(&self) -> &'static str {
        "frame-*.pose.txt, or seq-*/ of these (7-Scenes)"
    }

    fn recognizes(&self, place: &Place) -> bool {
        let is_ours = place.file.as_deref().is_none_or(is_pose);
        is_ours && !folders(place).is_empty()
    }

    fn read(&self, place: &Place) -> Result<Reading> {
        let mut description = Description {
            source: self.source().to_owned(),
            poses: OPENCV_POSES.to_owned(),
            depth: format!("{MILLIMETERS}, and so is 65535"),
            ..Description::default()
        };
        let (mut frames, mut inputs) = (Vec::new(), Vec::new());
        for folder in folders(place) {
            let at =
                |name: &str| if folder.is_empty() { name.to_owned() } else { format!("{folder}/{name}") };
            for name in names_in(&place.join(&folder))?.iter().filter(|name| is_pose(name)) {
                let base = at(name.trim_end_matches(".pose.txt"));
                let path = place.join(&at(name));
                let rows = TextFile::read(&path)?.numbers()?;
                inputs.push(path.clone());
                if rows.len() != 16 {
                    let what =
                        format!("it has {} where a pose has 4 lines of 4", counted(rows.len(), "number"));
                    return Err(Error::invalid(path.display(), what));
                }
                let endings =
                    [".color.png", ".color.jpg", ".color.jpeg"].map(|ending| format!("{base}{ending}"));
                let Some(color) = endings.into_iter().find(|color| place.join(color).is_file()) else {
                    description.skip("poses without color", at(name));
                    continue;
                };
                match pose_of_rows(&rows) {
                    Some(pose) => frames.push(entry(color, Some(format!("{base}.depth.png")), &pose)),
                    None => description.skip("without a rigid pose", color),
                }
            }
        }
        let near = [place.join(INTRINSICS), place.folder.join("..").join(INTRINSICS)];
        let mut numbers = [585.0, 585.0, 320.0, 240.0];
        description.lens = format!("nominal: {numbers:?}, as the data set says of both cameras");
        if let Some(path) = near.iter().find(|path| path.is_file()) {
            let [fx, _, cx, _, fy, cy, ..] = TextFile::read(path)?.numbers()?[..] else {
                return Err(Error::invalid(path.display(), "there are no 3×3 numbers"));
            };
            numbers = [fx, fy, cx, cy];
            inputs.push(path.clone());
            description.lens = format!("{INTRINSICS}: {numbers:?}");
        }
        let [fx, fy, cx, cy] = numbers;
        let lens = lens(fx, fy, cx, cy, 0.0);
        let keys = Keys { depth_unit_scale_factor: Some(1e-3), depth_invalid_value: Some(65535.0), ..lens };
        recording(place, keys, frames, description, inputs)
    }
}

fn is_pose(name: &str) -> bool {
    name.ends_with(".pose.txt")
}

/// Folders with poses: the place itself, or its sequences.
fn folders(place: &Place) -> Vec<String> {
    if place.names().any(is_pose) {
        return vec![String::new()];
    }
    let has_poses =
        |name: &&str| names_in(&place.join(name)).is_ok_and(|names| names.iter().any(|name| is_pose(name)));
    place.names().filter(|name| name.starts_with("seq")).filter(has_poses).map(str::to_owned).collect()
}
