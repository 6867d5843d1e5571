//! Which rows of pictures with an orientation tag a manifest means, where sizes do not tell.
//!
//! Some programs read pictures as they are shown, others ignore the tag. Under the right reading views show one surface in one color. If
//! neither reading is clearly better, none is taken, and reading a picture gives the error that names the key.

use glam::DVec2;

use super::cameras::CameraFiles;
use super::load::{self, NeededPlanes};
use super::placed_entry::PlacedEntry;
use crate::capture::camera::Camera;
use crate::capture::frame::Frame;
use crate::capture::pictures::{PictureRows, is_open};
use crate::capture::sighting::tolerances::TAKEN_OVER;
use crate::capture::sighting::{Landing, Sighting};
use crate::color::srgb_from_linear;
use crate::median::median_f32;

/// Pairs of cameras that are compared.
const PAIRS: usize = 4;
/// About this many points of each camera are compared with the other.
const POINTS: usize = 4000;
/// With fewer points that both cameras see nothing is decided.
const FEWEST_POINTS: usize = 48;
/// How many times as far apart colors have to be under the other reading.
const CLEARLY: f32 = 1.5;

/// Decides for all pictures of a capture, if any of the cameras' first leaves it open.
pub(super) fn decide(recording: &mut CameraFiles) {
    let firsts: Vec<(&Camera, &PlacedEntry)> =
        recording.cameras.iter().zip(recording.entries.iter().filter_map(|frames| frames.first())).collect();
    let is_open = |(camera, entry): &(&Camera, &PlacedEntry)| {
        entry.files.rows.is_none() && is_open(&entry.files.color, camera.intrinsics.size(), &entry.place)
    };
    if !firsts.iter().any(is_open) {
        return;
    }
    let [stored, shown] = [PictureRows::AsStored, PictureRows::AsShown].map(|rows| apart(&firsts, rows));
    let (Some(stored), Some(shown)) = (stored, shown) else { return };
    let rows = if stored * CLEARLY < shown {
        PictureRows::AsStored
    } else if shown * CLEARLY < stored {
        PictureRows::AsShown
    } else {
        return;
    };
    for entry in recording.entries.iter_mut().flatten() {
        entry.files.rows.get_or_insert(rows);
    }
}

/// How far apart the colors are in which two cameras show one surface, median; `None` where too few points are seen by both.
fn apart(cameras: &[(&Camera, &PlacedEntry)], rows: PictureRows) -> Option<f32> {
    let frame = |(camera, entry): &(&Camera, &PlacedEntry)| {
        let mut files = entry.files.clone();
        files.rows.get_or_insert(rows);
        load::frame(&files, camera, &entry.place, NeededPlanes::Geometry { normals: false }).ok()
    };
    let mut differences = Vec::new();
    let step = (cameras.len() / PAIRS).max(1);
    for pair in cameras.windows(2).step_by(step).take(PAIRS) {
        let (Some(a), Some(b)) = (frame(&pair[0]), frame(&pair[1])) else { continue };
        add_differences([pair[0].0, pair[1].0], [&a, &b], &mut differences);
    }
    if differences.len() < FEWEST_POINTS { None } else { median_f32(&mut differences) }
}

fn add_differences(cameras: [&Camera; 2], frames: [&Frame; 2], differences: &mut Vec<f32>) {
    let ([camera, other], [frame, seen]) = (cameras, frames);
    let (width, height) = frame.size();
    let step = (width * height / POINTS).isqrt().max(1);
    for (x, y) in (0..height).step_by(step).flat_map(|y| (0..width).step_by(step).map(move |x| (x, y))) {
        let inverse = f64::from(frame.inverse_depth[(x, y)]);
        if inverse <= 0.0 {
            continue;
        }
        let point = camera.unproject(DVec2::new(x as f64 + 0.5, y as f64 + 0.5), 1.0 / inverse);
        let Some(landing) = Landing::of(point, other, seen.size()) else { continue };
        if landing.compare(seen.inverse_depth[landing.pixel], TAKEN_OVER) != Sighting::Same {
            continue;
        }
        let colors = frame.color[(x, y)].iter().zip(&seen.color[landing.pixel]);
        let encoded =
            colors.map(|(a, b)| (srgb_from_linear(a.to_f32()) - srgb_from_linear(b.to_f32())).abs());
        differences.push(encoded.sum());
    }
}
