//! Replica as NICE-SLAM renders it.
//!
//! Source: Zhu et al.: NICE-SLAM, CVPR 2022, and its data loader: `results/frame%06d.jpg`, `results/depth%06d.png`, `traj.txt` with
//! 16 numbers a line, camera to world, x right, y down, z forward; `cam_params.json`, also one folder above, with the lens and depth
//! units per meter.

use serde::Deserialize;

use super::place::Place;
use super::reader::{Description, Reader, Reading};
use super::text::TextFile;
use super::views::{OPENCV_POSES, colors_in, entry, json, lens, number_in, pose_of_rows, recording};
use crate::capture::transforms::Keys;
use crate::error::Result;

/// Replica's rendering.
pub(super) struct Replica;

#[derive(Deserialize)]
struct Parameters {
    camera: Camera,
}

#[derive(Clone, Copy, Deserialize)]
struct Camera {
    fx: f64,
    fy: f64,
    cx: f64,
    cy: f64,
    scale: f64,
}

/// What all scenes were rendered with.
const DEFAULT: Camera = Camera { fx: 600.0, fy: 600.0, cx: 599.5, cy: 339.5, scale: 6553.5 };

impl Reader for Replica {
    fn source(&self) -> &'static str {
        "Replica (NICE-SLAM)"
    }

    fn marks(&self) -> &'static str {
        "traj.txt and results/ (Replica)"
    }

    fn recognizes(&self, place: &Place) -> bool {
        let is_ours = place.file.as_deref().is_none_or(|file| file == "traj.txt");
        is_ours && place.has_all(&["traj.txt", "results"])
    }

    fn read(&self, place: &Place) -> Result<Reading> {
        let mut inputs = vec![place.join("traj.txt")];
        let beside = [place.join("cam_params.json"), place.folder.join("..").join("cam_params.json")];
        let camera = match beside.iter().find(|path| path.is_file()) {
            Some(path) => {
                inputs.push(path.clone());
                json::<Parameters>(path)?.camera
            }
            None => DEFAULT,
        };
        let Camera { fx, fy, cx, cy, scale } = camera;
        let mut description = Description {
            source: self.source().to_owned(),
            poses: OPENCV_POSES.to_owned(),
            depth: format!("planar z in 1/{scale} m, 16-bit PNG; 0 is no depth"),
            lens: format!("{fx} {fy} {cx} {cy}"),
            ..Description::default()
        };
        let trajectory = TextFile::read(&inputs[0])?;
        let poses: Vec<[f64; 16]> = trajectory.lines().map(|line| line.numbers(0)).collect::<Result<_>>()?;
        let mut frames = Vec::new();
        for name in colors_in(&place.join("results")).into_iter().filter(|name| name.starts_with("frame")) {
            let number = number_in(&name);
            let digits = name.trim_start_matches("frame").split('.').next().unwrap_or_default();
            let depth = format!("results/depth{digits}.png");
            let pose =
                number.and_then(|number| poses.get(number as usize)).and_then(|rows| pose_of_rows(rows));
            match pose.filter(|_| place.join(&depth).is_file()) {
                Some(pose) => frames.push(entry(format!("results/{name}"), Some(depth), &pose)),
                None => description.skip("without depth or a rigid pose", name),
            }
        }
        let keys = Keys { depth_unit_scale_factor: Some(1.0 / scale), ..lens(fx, fy, cx, cy, 0.0) };
        recording(place, keys, frames, description, inputs)
    }
}
