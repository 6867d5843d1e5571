//! Depth that contradicts the positions recorded beside it.
//!
//! A depth channel does not state its measure and unit. A position in the world needs neither, and a position on its pixel's ray is
//! understood. If a manifest leaves open which of them is read, positions decide.

use rayon::prelude::*;

use super::cameras::CameraFiles;
use super::exr_picture::{DecodedPlanes, DepthChannels, ExrPicture};
use super::files::PictureFiles;
use super::placed_entry::PlacedEntry;
use crate::capture::camera::Camera;
use crate::capture::exr::DepthKind;
use crate::capture::pictures::{PictureFormat, format_of};
use crate::error::Result;
use crate::median::median;

/// How far depth may be off positions in the median, relative, where filters and rounding alone set them apart.
const SAME_RELATIVE: f64 = 0.01;

/// Reads positions in place of depth, with a warning, where the two differ in the first frame of any camera.
pub(crate) fn prefer_to_contradicting_depth(recording: &mut CameraFiles, warnings: &mut Vec<String>) {
    let cameras: Vec<(&Camera, &[PlacedEntry])> =
        recording.cameras.iter().zip(recording.entries.iter().map(Vec::as_slice)).collect();
    let of_camera = |(camera, entries): &(&Camera, &[PlacedEntry])| {
        let first = entries.iter().find(|entry| !entry.is_left_out)?;
        // A frame that cannot be read gives its error when it is loaded.
        distance(&first.files, camera, &first.place).ok().flatten()
    };
    let distances: Vec<Option<f64>> = cameras.par_iter().map(of_camera).collect();
    let is_off = |distance: &Option<f64>| distance.is_some_and(|distance| distance > SAME_RELATIVE);
    if !distances.iter().any(is_off) {
        return;
    }
    let farthest = distances.iter().flatten().copied().fold(0.0, f64::max);
    let mut names = Vec::new();
    for (index, entries) in recording.entries.iter_mut().enumerate() {
        if distances[index].is_none() {
            continue;
        }
        names.push(recording.cameras[index].name.as_str());
        for entry in entries.iter_mut().filter(|entry| entry.files.leaves_depth_open()) {
            entry.files.depth_kind = Some(DepthKind::WorldPosition);
        }
    }
    warnings.push(format!(
        "depth of {} is off the positions recorded beside it, by {:.0} % in the middle, and these lie on the pixels' rays; depth is taken from the positions (to insist on the depth channel, give depth_kind, as \"planar_z\")",
        names.join(", "),
        100.0 * farthest
    ));
}

/// How far depth is off positions, relative, median, less rounding; `None` if only one of them is there, the manifest names the one
/// that is meant, or positions are not understood.
fn distance(files: &PictureFiles, camera: &Camera, place: &str) -> Result<Option<f64>> {
    let (path, wishes) = match &files.depth {
        Some(path) => (path, files.wishes_of_depth_file()),
        None => (&files.color, files.wishes_of_color_file()),
    };
    if !files.leaves_depth_open() || format_of(path, place)? != PictureFormat::Exr {
        return Ok(None);
    }
    if files.depth_camera.is_some() || files.distortion.is_some() {
        return Ok(None);
    }
    let picture = ExrPicture::open(path, files, wishes, camera, place)?;
    let (Some(depth), Some(position)) = (picture.names.depth, picture.names.position) else {
        return Ok(None);
    };
    if picture.names.depth_is_ray_distance {
        return Ok(None);
    }
    let read = |channels: DepthChannels| {
        DecodedPlanes::decode(&picture, &channels.indices())?.take_depth(channels, &picture, camera)
    };
    let positions = read(DepthChannels::Position(position))?;
    let depths = read(DepthChannels::One(depth, DepthKind::PlanarZ))?;
    let rounding = 2.0 * f64::from(positions.step_relative + depths.step_relative);
    let pairs = positions.inverse_depth.iter().zip(&depths.inverse_depth);
    let hits = pairs.filter(|(position, depth)| **position > 0.0 && **depth > 0.0);
    let mut off: Vec<f64> = hits.map(|(position, depth)| off(*position, *depth)).collect();
    Ok(median(&mut off).map(|median| (median - rounding).max(0.0)))
}

/// By which share of the true depth another one is off, both inverse.
fn off(truth: f32, other: f32) -> f64 {
    (f64::from(truth) / f64::from(other) - 1.0).abs()
}
