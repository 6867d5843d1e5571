//! Numbers between 0 and 1 that no key explains: a depth buffer whose planes the capture does not say, or depth divided by something.
//!
//! Purpose: graphics libraries keep depth as numbers between 0 and 1 that are even in the reciprocal of depth; programs that save pictures
//! divide depth by the farthest one. Both have two unknowns: the depths at two of the numbers. Read otherwise than meant they hardly
//! differ, and agree within a percent under readings that mean nothing. So the depths are fitted continuously, under both, to far less
//! than a percent, and one is sure only where the other does not fit.

use rayon::prelude::*;

use super::agreement::Comparison;
use super::reading::{PixelRay, Reading};
use super::search::NOT_CHANCE;
use super::views::{ComparedView, POINTS};
use crate::capture::depth_claim::{DepthMeasure, DepthPlanes};
use crate::capture::sighting::Landing;

/// Tolerances of the fit, from coarse to fine, as shares of the spread of inverse depths.
const TOLERANCES: [f64; 5] = [0.3, 0.1, 0.03, 0.01, 0.003];
/// Both are compared at the finest tolerance at which the better one keeps this share of its agreement: as fine as depth is.
const KEPT_AGREEMENT: f64 = 0.5;
/// Points of each pair in the search, and in the fit.
const FEW: usize = 24;
const SOME: usize = 80;
/// Places of the grid that are refined.
const REFINED: usize = 6;
/// Readings with this share of the best one's agreement are as good.
const AS_GOOD: f64 = 0.97;
/// Neighbors within this ratio are on one surface.
const ONE_SURFACE: f64 = 1.06;

/// Whether all numbers are between 0 and 1, and the capture says no planes.
pub(super) fn may_be_buffer(comparison: &Comparison) -> bool {
    let mut values = comparison.views.iter().flat_map(|view| &view.points).map(|point| point.value);
    comparison.claimed.planes.is_none() && values.all(|value| value > 0.0 && value <= 1.0)
}

/// What numbers between 0 and 1 are found to mean.
pub(super) struct FoundBetween {
    pub(super) reading: Reading,
    /// How many times as well it fits as the other meaning, at most 99.
    pub(super) margin: f64,
}

/// The best meaning of numbers between 0 and 1 under the claimed poses; `None` where views agree under none.
pub(super) fn between_planes(comparison: &Comparison) -> Option<FoundBetween> {
    let fits = [true, false].map(|is_inverse| Fit::best(comparison, is_inverse));
    let shares = fits
        .each_ref()
        .map(|fit| TOLERANCES.map(|tolerance| fit.as_ref().map_or(0.0, |fit| fit.share(tolerance, POINTS))));
    let is_kept =
        |nth: usize| shares.iter().any(|share| share[nth] >= KEPT_AGREEMENT * share[1].max(NOT_CHANCE));
    let compared = (0..TOLERANCES.len()).rev().find(|nth| is_kept(*nth))?;
    let [inverse, even] = shares.each_ref().map(|share| share[compared]);
    let is_inverse = inverse >= even;
    let [best, other] = if is_inverse { [inverse, even] } else { [even, inverse] };
    let fit = fits.into_iter().nth(usize::from(!is_inverse)).flatten()?;
    let is_chance = shares[usize::from(!is_inverse)][1] < NOT_CHANCE;
    let margin = (best / other.max(1e-3)).min(99.0);
    (!is_chance).then(|| FoundBetween { reading: fit.reading(TOLERANCES[compared]), margin })
}

/// A meaning of numbers: inverse depth, or depth, is even in them.
struct Fit<'a> {
    comparison: &'a Comparison,
    is_inverse: bool,
    /// Two numbers, most of all being between them.
    numbers: [f64; 2],
    /// The logarithms of the depths there.
    log_depths: [f64; 2],
}

impl<'a> Fit<'a> {
    /// The best of its kind; `None` where all numbers are one.
    fn best(comparison: &'a Comparison, is_inverse: bool) -> Option<Self> {
        let mut values: Vec<f64> =
            comparison.views.iter().flat_map(|view| &view.points).map(|point| point.value).collect();
        values.sort_by(f64::total_cmp);
        let at = |share: f64| values.get((share * values.len() as f64) as usize).copied();
        let numbers = [at(0.1)?, at(0.9)?];
        let poses = comparison.poses(&comparison.claimed);
        let apart =
            comparison.pairs.iter().map(|(a, b)| poses[*a].translation.distance(poses[*b].translation));
        let baseline = apart.fold(0.0, f64::max);
        if numbers[1] <= numbers[0] || baseline <= 0.0 {
            return None;
        }
        let fit = |log_depths| Self { comparison, is_inverse, numbers, log_depths };
        let nears = (0..50).map(|step| (0.2 * baseline).ln() + 0.14 * f64::from(step));
        let ratios = [1.05, 1.1, 1.2, 1.35, 1.5, 1.75, 2.0, 2.5, 3.0, 4.0, 6.0, 10.0, 20.0_f64].map(f64::ln);
        let places =
            nears.flat_map(|near| ratios.iter().flat_map(move |by| [[near, near + by], [near + by, near]]));
        let places: Vec<[f64; 2]> = places.collect();
        let of_place = |place: &[f64; 2]| (fit(*place).share(TOLERANCES[0], FEW), *place);
        let mut grid: Vec<(f64, [f64; 2])> = places.par_iter().map(of_place).collect();
        grid.sort_by(|a, b| b.0.total_cmp(&a.0));
        grid.truncate(REFINED);
        let refined: Vec<Self> = grid.into_par_iter().map(|(_, place)| fit(place).refined()).collect();
        let total =
            |fit: &Self| -> f64 { TOLERANCES[1..].iter().map(|tolerance| fit.share(*tolerance, SOME)).sum() };
        let shares: Vec<f64> = refined.iter().map(total).collect();
        let best = (0..shares.len()).max_by(|a, b| shares[*a].total_cmp(&shares[*b]))?;
        refined.into_iter().nth(best)
    }

    /// A better one near it: steps along both unknowns, ever shorter, at ever finer tolerances.
    fn refined(mut self) -> Self {
        const WAYS: [[f64; 2]; 8] = [
            [1.0, 0.0],
            [-1.0, 0.0],
            [0.0, 1.0],
            [0.0, -1.0],
            [1.0, 1.0],
            [-1.0, -1.0],
            [1.0, -1.0],
            [-1.0, 1.0],
        ];
        for tolerance in TOLERANCES {
            let mut step = 0.5 * tolerance;
            let mut best = self.share(tolerance, SOME);
            while step > 0.02 * tolerance {
                let from = self.log_depths;
                let mut found = (best, from);
                for way in WAYS {
                    self.log_depths = [from[0] + step * way[0], from[1] + step * way[1]];
                    let share = self.share(tolerance, SOME);
                    if share > found.0 {
                        found = (share, self.log_depths);
                    }
                }
                self.log_depths = found.1;
                if found.0 > best {
                    best = found.0;
                } else {
                    step *= 0.5;
                }
            }
        }
        self
    }

    /// Depth, or inverse depth, at 0 and at 1.
    fn ends(&self) -> [f64; 2] {
        let at = self.log_depths.map(|log| if self.is_inverse { (-log).exp() } else { log.exp() });
        let slope = (at[1] - at[0]) / (self.numbers[1] - self.numbers[0]);
        let start = at[0] - slope * self.numbers[0];
        [start, start + slope]
    }

    fn share(&self, tolerance: f64, points: usize) -> f64 {
        let [start, end] = self.ends();
        let is_inverse = self.is_inverse;
        share(self.comparison, tolerance, points, |value| {
            let at = start + value * (end - start);
            if is_inverse { at } else { at.recip() }
        })
    }

    /// The reading with the roundest numbers that fit as well at a tolerance.
    fn reading(&self, finest: f64) -> Reading {
        let claimed = self.comparison.claimed;
        let [start, end] = self.ends();
        let planes = |measure, near: f64, far: Option<f64>| Reading {
            measure,
            unit: 1.0,
            planes: Some(DepthPlanes { near, far }),
            ..claimed
        };
        let mut readings = Vec::new();
        if self.is_inverse {
            let (measure, near, far) = if start > end {
                (DepthMeasure::ZBuffer, start.recip(), end.recip())
            } else {
                (DepthMeasure::ReversedZBuffer, end.recip(), start.recip())
            };
            // Infinity is as good as a plane that is too far to tell.
            let fars = [1, 2, 3, 4].map(|digits| Some(rounded(far, digits)));
            let is_apart = |plane: &Option<f64>| plane.is_none_or(|plane| plane > near);
            let fars: Vec<Option<f64>> = std::iter::once(None).chain(fars).filter(is_apart).collect();
            for near in [1, 2, 3, 4, 6].map(|digits| rounded(near, digits)) {
                readings.extend(fars.iter().map(|far| planes(measure, near, *far)));
            }
        } else {
            let digits = [1, 2, 3, 4];
            readings.extend(digits.map(|digits| Reading {
                measure: DepthMeasure::PlanarZ,
                unit: rounded(end, digits),
                planes: None,
                ..claimed
            }));
            let even = digits.map(|digits| {
                planes(DepthMeasure::EvenBetweenPlanes, rounded(start, digits), Some(rounded(end, digits)))
            });
            readings.extend(even);
        }
        let enough = AS_GOOD * self.share(finest, POINTS);
        let share = |reading: &Reading| {
            let value =
                |value| reading.planar_z(value, PixelRay::AXIS, &glam::DAffine3::IDENTITY, 0.0).recip();
            share(self.comparison, finest, POINTS, value)
        };
        let shares: Vec<f64> = readings.iter().map(share).collect();
        let good = (0..readings.len()).find(|index| shares[*index] >= enough);
        let best = || (0..readings.len()).max_by(|a, b| shares[*a].total_cmp(&shares[*b])).unwrap_or(0);
        readings[good.unwrap_or_else(best)]
    }
}

/// A number with so many digits.
fn rounded(value: f64, digits: usize) -> f64 {
    format!("{value:.*e}", digits - 1).parse().unwrap_or(value)
}

/// How many points of one view lie on the surface that another one sees, as a share of all that are carried, where numbers mean
/// this inverse depth. One that is off by less counts more.
fn share(comparison: &Comparison, tolerance: f64, points: usize, inverse_depth: impl Fn(f64) -> f64) -> f64 {
    let mut all: Vec<f64> = comparison
        .views
        .iter()
        .flat_map(|view| view.points.iter().take(points).map(|point| inverse_depth(point.value)))
        .filter(|inverse| *inverse > 0.0 && inverse.is_finite())
        .collect();
    all.sort_by(f64::total_cmp);
    // Surfaces that are all equally far agree with each other, and mean nothing.
    let spread = match (all.get(all.len() / 4), all.get(all.len() * 3 / 4)) {
        (Some(low), Some(high)) if high > low => high - low,
        _ => return 0.0,
    };
    let poses = comparison.poses(&comparison.claimed);
    let (mut agree, mut tried) = (0.0, 0);
    for &(from, to) in &comparison.pairs {
        let (source, target) = (&comparison.views[from], &comparison.views[to]);
        let target_from_source = poses[to].inverse() * poses[from];
        for point in source.points.iter().take(points) {
            tried += 1;
            let inverse = inverse_depth(point.value);
            if !(inverse > 0.0 && inverse.is_finite()) {
                continue;
            }
            let ray = PixelRay::through(&source.intrinsics, point.pixel);
            let there = target_from_source.transform_point3(ray.to_unit_z / inverse);
            let landing = Landing::through(&target.intrinsics, there, target.intrinsics.size());
            let Some(landing) = landing.filter(|_| there.z > 0.0) else { continue };
            if let Some(seen) = surface_at(target, landing.position, &inverse_depth) {
                let off = (there.z.recip() - seen) / (spread * tolerance);
                agree += (1.0 - off * off).max(0.0);
            }
        }
    }
    agree / f64::from(tried.max(1))
}

/// The inverse depth of the surface at an image position, between the centers of four pixels; `None` at an edge.
fn surface_at(view: &ComparedView, at: glam::DVec2, inverse_depth: &impl Fn(f64) -> f64) -> Option<f64> {
    let (width, height) = view.intrinsics.size();
    let (x, y) = (at.x - 0.5, at.y - 0.5);
    if x < 0.0 || y < 0.0 {
        return None;
    }
    let (column, row) = (x as usize, y as usize);
    if column + 1 >= width || row + 1 >= height {
        return None;
    }
    let of = |dx: usize, dy: usize| inverse_depth(f64::from(view.values[(row + dy) * width + column + dx]));
    let corners = [of(0, 0), of(1, 0), of(0, 1), of(1, 1)];
    let [low, high] = [f64::min, f64::max].map(|pick| corners.into_iter().fold(corners[0], pick));
    // NaN is no surface.
    if !(corners.iter().all(|corner| corner.is_finite()) && low > 0.0 && high <= ONE_SURFACE * low) {
        return None;
    }
    let (right, down) = (x.fract(), y.fract());
    let above = corners[0] + (corners[1] - corners[0]) * right;
    let below = corners[2] + (corners[3] - corners[2]) * right;
    Some(above + (below - above) * down)
}
