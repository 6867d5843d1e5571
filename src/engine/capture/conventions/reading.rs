//! A reading: what the numbers of a capture's poses and depth mean.
//!
//! Numbers that may be a depth buffer whose planes the capture does not say.
//!
//! Purpose: graphics libraries keep depth as numbers between 0 and 1 that are even in the reciprocal of depth. Read as distances they
//! hardly differ, and then agree under readings that mean nothing.

use glam::{DAffine3, DVec2, DVec3};
use serde::{Deserialize, Serialize};

use super::agreement::Comparison;
use crate::capture::camera::Intrinsics;
use crate::capture::depth_claim::{DepthMeasure, DepthPlanes};
use crate::capture::pose_convention::PoseConvention;

/// The ray through a point of a picture, in camera space.
#[derive(Clone, Copy, Debug)]
pub(super) struct PixelRay {
    /// From the camera to planar z 1.
    pub to_unit_z: DVec3,
    /// Its length.
    pub length: f64,
}

impl PixelRay {
    /// The ray along the camera's axis.
    pub(super) const AXIS: Self = Self { to_unit_z: DVec3::Z, length: 1.0 };

    /// The ray through an image position.
    pub(super) fn through(lens: &Intrinsics, pixel: DVec2) -> Self {
        Self::new(lens.ray_in_camera(pixel))
    }

    /// The ray that goes through a point at planar z 1.
    pub(super) fn new(to_unit_z: DVec3) -> Self {
        Self { to_unit_z, length: to_unit_z.length() }
    }
}

/// How lenses are read otherwise than claimed: all cameras' alike.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LensReading {
    /// Focal lengths, as multiples of those claimed.
    pub focal: f64,
    /// Principal points beside those claimed, as shares of the width and the height of the picture.
    pub center: [f64; 2],
}

impl Default for LensReading {
    fn default() -> Self {
        Self { focal: 1.0, center: [0.0; 2] }
    }
}

impl LensReading {
    /// A claimed lens, read this way.
    #[must_use]
    pub fn of(&self, claimed: &Intrinsics) -> Intrinsics {
        Intrinsics {
            fx: claimed.fx * self.focal,
            fy: claimed.fy * self.focal,
            cx: claimed.cx + self.center[0] * f64::from(claimed.width),
            cy: claimed.cy + self.center[1] * f64::from(claimed.height),
            ..*claimed
        }
    }

    /// What differs from the claimed lens, a phrase each; none where it is as claimed.
    #[must_use]
    pub fn words(&self) -> Vec<String> {
        let mut words = Vec::new();
        if self.focal != 1.0 {
            words.push(format!("focal lengths are {:.3} times those claimed", self.focal));
        }
        if self.center != [0.0; 2] {
            let [x, y] = self.center.map(|shift| 100.0 * shift);
            words.push(format!(
                "principal points are {x:+.0} % of the width and {y:+.0} % of the height from those claimed"
            ));
        }
        words
    }

    fn is_claimed(&self) -> bool {
        *self == Self::default()
    }
}

/// One way to read poses, depth and lenses.
#[serde_with::skip_serializing_none]
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Reading {
    /// What the matrices mean.
    pub pose: PoseConvention,
    /// What depth measures.
    pub measure: DepthMeasure,
    /// World units per unit of the depth file.
    pub unit: f64,
    /// The planes of a depth buffer, of nothing else.
    pub planes: Option<DepthPlanes>,
    /// What the lenses are beside those claimed.
    #[serde(default, skip_serializing_if = "LensReading::is_claimed")]
    pub lens: LensReading,
}

impl Reading {
    /// Planar z of a pixel with the number `value` and the ray `ray`.
    pub(super) fn planar_z(
        &self,
        value: f64,
        ray: PixelRay,
        world_from_camera: &DAffine3,
        near_clip: f64,
    ) -> f64 {
        let scaled = value * self.unit;
        match self.measure {
            DepthMeasure::PlanarZ => scaled,
            DepthMeasure::RayDistance => scaled / ray.length,
            DepthMeasure::RayDistanceFromNearClip => scaled / ray.length + near_clip,
            DepthMeasure::InversePlanarZ => scaled.recip(),
            DepthMeasure::InverseRayDistance => (scaled * ray.length).recip(),
            DepthMeasure::WorldZ => {
                let eye = world_from_camera.translation.z;
                (scaled - eye) / world_from_camera.transform_vector3(ray.to_unit_z).z
            }
            DepthMeasure::ZBuffer => self.between_planes(1.0 - scaled),
            DepthMeasure::ReversedZBuffer => self.between_planes(scaled),
        }
    }

    /// Planar z of a number from 0 at the far plane to 1 at the near one; NaN outside.
    fn between_planes(&self, nearness: f64) -> f64 {
        let planes = self.planes.filter(|_| nearness > 0.0 && nearness < 1.0);
        planes.map_or(f64::NAN, |planes| planes.inverse_depth(nearness).recip())
    }
}

/// Both orders of the planes.
const MEASURES: [DepthMeasure; 2] = [DepthMeasure::ZBuffer, DepthMeasure::ReversedZBuffer];

/// Numbers within this ratio of each other are as good as one: any reading that puts them far enough away agrees.
const HARDLY_DIFFERENT: f64 = 1.06;
/// The share of the numbers at either end that may differ more.
const ENDS: f64 = 0.05;

/// Whether all numbers are between 0 and 1, and the capture says no planes.
pub(super) fn may_be_buffer(comparison: &Comparison) -> bool {
    let mut values = comparison.views.iter().flat_map(|view| &view.points).map(|point| point.value);
    comparison.claimed.planes.is_none() && values.all(|value| value > 0.0 && value <= 1.0)
}

/// Whether numbers are so close together that only the planes of a depth buffer give them a meaning.
pub(super) fn hardly_differ(comparison: &Comparison) -> bool {
    let points = comparison.views.iter().flat_map(|view| &view.points);
    let mut values: Vec<f64> = points.map(|point| point.value).collect();
    values.sort_by(f64::total_cmp);
    let end = (values.len() as f64 * ENDS) as usize;
    let inner = values.get(end..values.len() - end).unwrap_or_default();
    matches!((inner.first(), inner.last()), (Some(low), Some(high)) if high / low < HARDLY_DIFFERENT)
}

/// Readings of the claimed poses as a depth buffer whose planes are round numbers, as programs set them.
pub(super) fn round_planes(claimed: &Reading) -> Vec<Reading> {
    let decimals = |digits: &[f64], powers: std::ops::RangeInclusive<i32>| -> Vec<f64> {
        powers.flat_map(|power| digits.iter().map(move |digit| decimal(*digit, power))).collect()
    };
    let nears = decimals(&[1.0, 2.0, 2.5, 3.0, 5.0], -3..=0);
    let mut fars: Vec<Option<f64>> = decimals(&[1.0, 2.0, 5.0], 0..=4).into_iter().map(Some).collect();
    fars.push(None);
    between(claimed, nears.iter().flat_map(|near| fars.iter().map(|far| (*near, *far))))
}

/// Readings with any planes.
pub(super) fn any_planes(claimed: &Reading) -> Vec<Reading> {
    const STEP: f64 = 1.05;
    const RATIOS: [f64; 7] = [3.0, 10.0, 30.0, 100.0, 300.0, 1e3, 1e4];
    let steps = (1e4_f64.ln() / STEP.ln()) as i32;
    let nears = (0..=steps).map(|step| 1e-3 * STEP.powi(step));
    between(claimed, nears.flat_map(|near| with_ratios(near, &RATIOS)))
}

/// Readings with planes near those of a reading.
pub(super) fn planes_near(reading: &Reading) -> Vec<Reading> {
    let Some(DepthPlanes { near, far }) = reading.planes else { return Vec::new() };
    let ratio = far.map_or(1e5, |far| far / near);
    let ratios = [0.5, 0.7, 0.85, 1.0, 1.2, 1.4, 2.0].map(|factor| factor * ratio);
    let nears = (-6..=6).map(|step| near * (1.0 + 0.01 * f64::from(step)));
    let all = between(reading, nears.flat_map(|near| with_ratios(near, &ratios)));
    all.into_iter().filter(|near| near.measure == reading.measure).collect()
}

/// A near plane with far planes at these multiples of it, and at infinity.
fn with_ratios(near: f64, ratios: &[f64]) -> Vec<(f64, Option<f64>)> {
    let far = ratios.iter().map(|ratio| Some(near * ratio));
    far.chain([None]).map(|far| (near, far)).collect()
}

fn between(reading: &Reading, planes: impl Iterator<Item = (f64, Option<f64>)>) -> Vec<Reading> {
    let apart = planes.filter(|(near, far)| far.is_none_or(|far| far > 1.5 * near));
    let read = |(near, far): (f64, Option<f64>)| {
        let planes = Some(DepthPlanes { near, far });
        MEASURES.map(|measure| Reading { measure, unit: 1.0, planes, ..*reading })
    };
    apart.flat_map(read).collect()
}

/// The decimal that is meant, rather than a product that is nearly it.
fn decimal(digit: f64, power: i32) -> f64 {
    format!("{digit}e{power}").parse().unwrap_or(digit)
}
