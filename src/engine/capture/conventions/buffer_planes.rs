//! Numbers that may be a depth buffer whose planes the capture does not say.
//!
//! Purpose: graphics libraries keep depth as numbers between 0 and 1 that are even in the reciprocal of depth. Read as distances they
//! hardly differ, and then agree under readings that mean nothing.

use super::agreement::Comparison;
use super::reading::Reading;
use crate::capture::depth_claim::{DepthMeasure, DepthPlanes};

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
