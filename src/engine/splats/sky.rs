//! The sky as a far dome: no format of splats has a place at infinity.

use glam::{DVec3, Vec3};

use super::gaussian::Gaussian;
use super::space::Space;
use crate::error::Result;
use crate::render::sky_map;
use crate::samples::SampleSet;

/// Splats of the dome, two degrees apart: as fine as the sky is known.
const SPLATS: usize = 10_000;

/// Width of a splat over its distance from the next: narrower ones let what is behind them show through between them.
const OVERLAP: f64 = 2.0;

/// The dome is this many times as far off as the farthest sample.
const DISTANCE: f64 = 8.0;

/// A turn by the golden angle, radians: points on a spiral by it lie evenly on the sphere.
const GOLDEN_ANGLE: f64 = 2.399_963_229_728_653;

/// The sky at the first frame, continued into all directions, around the middle of the cameras; nothing where no sample is at infinity.
/// Samples farther off than `farthest`, in world units, count as such.
///
/// # Errors
/// Those of the sky's map.
pub(super) fn dome(set: &SampleSet, farthest: f64, space: &Space) -> Result<Vec<Gaussian>> {
    let directions: Vec<DVec3> = (0..SPLATS)
        .map(|nth| {
            let z = 1.0 - (2 * nth + 1) as f64 / SPLATS as f64;
            let (sin, cos) = (nth as f64 * GOLDEN_ANGLE).sin_cos();
            let across = (1.0 - z * z).sqrt();
            DVec3::new(across * cos, across * sin, z)
        })
        .collect();
    let looked: Vec<Vec3> =
        directions.iter().map(|direction| direction.as_vec3().normalize_or_zero()).collect();
    let Some(colors) = sky_map(set, 0, &looked)? else { return Ok(Vec::new()) };
    let count = set.cameras.len().max(1) as f64;
    let middle = set.cameras.iter().map(|camera| camera.position_in_world() / count).sum::<DVec3>();
    let radius = DISTANCE * reach(set, middle, farthest);
    let width = OVERLAP * radius * (4.0 * std::f64::consts::PI / SPLATS as f64).sqrt();
    let splats = directions.into_iter().zip(colors);
    let splats = splats.map(|(direction, color)| {
        Gaussian::facing(middle + direction * radius, -direction, width, color, space)
    });
    Ok(splats.collect())
}

/// How far the farthest sample is from a point.
fn reach(set: &SampleSet, middle: DVec3, farthest: f64) -> f64 {
    let points = set.images.iter().flat_map(|image| image.placed(&set.cameras[image.camera as usize]));
    let near = points.filter(|placed| placed.depth < farthest);
    near.map(|placed| placed.point_in_world.distance(middle)).fold(0.0, f64::max)
}
