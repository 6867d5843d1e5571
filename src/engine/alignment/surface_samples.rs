//! Samples of smooth surfaces on a lattice, with the plane through each.
//!
//! Purpose: a sample that is carried into other cameras needs the position and the direction of its surface: see
//! [`super::tangent_plane`]. What differs from the normals of preprocessing: the window grows with the noise, and samples that do not
//! fit are dropped.

use glam::{DVec2, DVec3};

use super::reference_view::{LEVELS, ReferenceView};
use super::tangent_plane::{SurfaceBend, TangentPlane, tangent_plane};
use crate::median::median;

/// A point of a surface that one camera saw.
#[derive(Clone, Debug)]
pub(crate) struct SurfaceSample {
    /// Image position, pixels.
    pub(crate) pixel: DVec2,
    /// Inverse depth of the plane at the sample, 1/unit.
    pub(crate) inverse_depth: f64,
    /// Unit length, in camera space, away from the camera.
    pub(crate) normal_in_camera: DVec3,
    /// How the surface bends away from the plane.
    pub(crate) bend: SurfaceBend,
    /// At each resolution.
    pub(crate) brightness: [f64; LEVELS],
    /// How many resolutions, the finest first, show nothing but the surface around the sample.
    pub(crate) pure_levels: usize,
    /// The region of space that it lies in, by number; the same in all cameras.
    pub(crate) region: usize,
    /// Whether the sample judges corrections rather than taking part in finding them.
    pub(crate) judges: bool,
}

/// How far from a sample the plane is fitted, pixels: with exact depth and with noise.
const RADII: [usize; 2] = [1, 4];
/// Depth is noisy where most planes through 3×3 pixels are off by more, in footprints.
const NOISY_FOOTPRINTS: f64 = 0.1;
/// No plane where fewer of the pixels have depth.
const LEAST_VALID: [f64; 2] = [0.8, 0.35];

/// Places on a lattice of about `count` pixels, column and row, from whose surroundings a plane is fitted, and whether their samples judge.
fn places(view: &ReferenceView, count: usize, radius: usize) -> impl Iterator<Item = (usize, usize, bool)> {
    let (width, height) = view.frame.size();
    let step = (width * height / count.max(1)).isqrt().max(2);
    let margin = radius + 2;
    let rows = (step / 2..height).step_by(step).enumerate();
    let places = rows.flat_map(move |(row, y)| {
        let columns = (step / 2..width).step_by(step).enumerate();
        columns.map(move |(column, x)| (x, y, (row + column) % 2 == 1))
    });
    places.filter(move |&(x, y, _)| {
        x >= margin && y >= margin && x + margin < width && y + margin < height && view.is_still(x, y)
    })
}

/// How far depth is off smooth surfaces, in footprints, and how far rounding takes it; `None` for a coarser lattice. Seen at about `count`
/// places.
fn noise_footprints(view: &ReferenceView, count: usize) -> Option<[f64; 2]> {
    let exact = places(view, count, RADII[0]).filter_map(|(x, y, _)| plane_in(view, x, y, 0));
    let focal = view.camera.intrinsics.fx;
    let mut off: Vec<f64> = exact.map(|plane| plane.deviation_relative * focal).collect();
    let with_depth =
        places(view, count, RADII[0]).filter(|&(x, y, _)| view.frame.inverse_depth[(x, y)] > 0.0).count();
    // Depth of a coarser lattice, too, has few whole windows of 3×3 pixels.
    let is_sparse = 2 * off.len() < with_depth;
    let off = median(&mut off).filter(|_| !is_sparse)?;
    Some([off, f64::from(view.frame.depth_step_relative) * focal])
}

/// Whether depth has no noise but rounding.
pub(crate) fn has_exact_depth(view: &ReferenceView, count: usize) -> bool {
    noise_footprints(view, count).is_some_and(|[off, rounding]| off <= NOISY_FOOTPRINTS.max(rounding))
}

/// Whether depth is that of a sensor: noisy, or of a coarser lattice. Seen at about `count` places.
pub(crate) fn has_noisy_depth(view: &ReferenceView, count: usize) -> bool {
    noise_footprints(view, count).is_none_or(|[off, _]| off > NOISY_FOOTPRINTS)
}

/// About `count` samples of a view.
pub(crate) fn surface_samples(view: &ReferenceView, count: usize) -> Vec<SurfaceSample> {
    let window = usize::from(has_noisy_depth(view, count));
    let samples = places(view, count, RADII[window]).filter_map(|(x, y, judges)| {
        let plane = plane_in(view, x, y, window)?;
        let pixel = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
        let mut brightness = [0.0; LEVELS];
        for (level, value) in brightness.iter_mut().enumerate() {
            *value = view.brightness_at(level, pixel.x, pixel.y)?[0];
        }
        let normal_in_camera = plane.normal_in_camera(&view.camera.intrinsics, pixel)?;
        Some(SurfaceSample {
            pixel,
            inverse_depth: plane.inverse_depth,
            normal_in_camera,
            bend: plane.bend,
            brightness,
            pure_levels: view.pure_levels_at(pixel),
            region: 0,
            judges,
        })
    });
    samples.collect()
}

fn plane_in(view: &ReferenceView, x: usize, y: usize, window: usize) -> Option<TangentPlane> {
    tangent_plane(&view.frame.inverse_depth, x, y, RADII[window], LEAST_VALID[window])
}
