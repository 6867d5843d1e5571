//! Whether depth would fit between cameras if it were read otherwise than the capture says.
//!
//! Purpose: cameras that disagree may be noisy, or a convention that they share may be wrong. It is wrong only if another one fits
//! better: depths are distances along the ray and not along the axis, or the other way around, or have another unit. Behind narrow
//! lenses the number of points that agree hardly changes ([`crate::capture::conventions`]); their distances still show it.
//!
//! Source: none in the paper, which takes depth for granted. The samples of a lattice are carried into the other cameras under
//! each reading; how far they are off there, relative to their depth, is compared by the median.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::capture::Camera;
use crate::capture::sighting::Landing;
use crate::median::median;
use crate::preprocess::layers::CameraLayer;
use crate::preprocess::temporal::ROOT;

/// How depth might be meant, other than the capture says.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DepthReading {
    /// As distance along the pixel's ray, where it was read as depth along the optical axis.
    RayDistance,
    /// As depth along the optical axis, where it was read as distance along the pixel's ray.
    PlanarZ,
    /// In a unit that is this many times as large.
    Scaled(f64),
}

/// Units that are mistaken for each other.
const SCALES: [f64; 8] = [1e-3, 1e-2, 0.1, 0.3048, 3.280_84, 10.0, 100.0, 1000.0];

/// As it was read.
const CLAIMED: DepthReading = DepthReading::Scaled(1.0);

/// Another reading has to leave less than this share of the distances.
const BETTER: f64 = 0.5;

/// About this many samples of each camera are compared, and at least this many distances have to result.
const SAMPLES: usize = 512;
const MIN_READINGS: usize = 512;

impl DepthReading {
    /// In words.
    #[must_use]
    pub fn sentence(self) -> String {
        match self {
            Self::RayDistance => "depth fits better as distance along the ray (depth_kind)".to_owned(),
            Self::PlanarZ => "depth fits better as depth along the optical axis (depth_kind)".to_owned(),
            Self::Scaled(factor) => {
                let [times, than] = if factor < 1.0 { [1.0 / factor, 0.0] } else { [factor, 1.0] };
                let word = if than > 0.0 { "small" } else { "large" };
                format!("depth is some {times:.4} times too {word}: set depth_unit_scale_factor to {factor}")
            }
        }
    }

    /// The depth along the axis that is meant, given the one that was read and the length of the ray to depth 1.
    fn meant(self, depth: f64, ray: f64) -> f64 {
        match self {
            Self::RayDistance => depth / ray,
            Self::PlanarZ => depth * ray,
            Self::Scaled(factor) => depth * factor,
        }
    }
}

/// Relative distances between depths, under the reading that the capture claims and under others.
pub(crate) struct Misfits(Vec<(DepthReading, Vec<f64>)>);

impl Misfits {
    /// Nothing is compared yet.
    pub(crate) fn new() -> Self {
        let others = [DepthReading::RayDistance, DepthReading::PlanarZ].into_iter();
        let all = [CLAIMED].into_iter().chain(others).chain(SCALES.map(DepthReading::Scaled));
        Self(all.map(|reading| (reading, Vec::new())).collect())
    }

    /// Compares what one camera saw with what some others did.
    pub(crate) fn add(
        &mut self,
        cameras: &[Camera],
        layers: &[CameraLayer],
        source: usize,
        targets: &[usize],
    ) {
        self.0.par_iter_mut().for_each(|(reading, off)| {
            add_misfits(cameras, layers, source, targets, *reading, off);
        });
    }

    /// The reading that fits best, where one does far better than the one that the capture claims.
    pub(crate) fn better(self) -> Option<DepthReading> {
        let mut readings = self.0.into_iter();
        let claimed = misfit(readings.next()?.1)?;
        let misfits = readings.filter_map(|(reading, off)| Some((misfit(off)?, reading)));
        let best = misfits.min_by(|a, b| a.0.total_cmp(&b.0));
        best.filter(|(misfit, _)| *misfit < BETTER * claimed).map(|(_, reading)| reading)
    }
}

/// The median distance; `None` where too few samples can be compared.
fn misfit(mut off: Vec<f64>) -> Option<f64> {
    if off.len() >= MIN_READINGS { median(&mut off) } else { None }
}

fn add_misfits(
    cameras: &[Camera],
    layers: &[CameraLayer],
    source: usize,
    targets: &[usize],
    reading: DepthReading,
    off: &mut Vec<f64>,
) {
    let depth_at = |camera: usize, x: usize, y: usize| {
        let layer = &layers[camera];
        let pixel = y * layer.width + x;
        let inverse_depth = f64::from(layer.inverse_depth[pixel]);
        let center = glam::DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
        let ray = cameras[camera].intrinsics.ray_in_camera(center).length();
        (layer.level[pixel] == ROOT && inverse_depth > 0.0)
            .then(|| (center, reading.meant(inverse_depth.recip(), ray)))
    };
    let layer = &layers[source];
    let step = (layer.width * layer.height() / SAMPLES).isqrt().max(1);
    let lattice = (0..layer.height()).step_by(step);
    let lattice = lattice.flat_map(|y| (0..layer.width).step_by(step).map(move |x| (x, y)));
    for (center, depth) in lattice.filter_map(|(x, y)| depth_at(source, x, y)) {
        let point = cameras[source].unproject(center, depth);
        for &other in targets {
            let size = (layers[other].width, layers[other].height());
            let Some(landing) = Landing::of(point, &cameras[other], size) else { continue };
            let found = depth_at(other, landing.pixel.0, landing.pixel.1);
            off.extend(found.map(|(_, found)| (found / landing.depth - 1.0).abs()));
        }
    }
}
