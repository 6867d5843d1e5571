//! Regions of space: what several cameras see of one region is off for one reason.
//!
//! Purpose: neighboring samples are not independent, and neither are those of several cameras at one place: their textures and edges
//! are the same. Standard errors are those of regions, whatever is correlated within each. Source: K.-Y. Liang and S. L. Zeger,
//! *Longitudinal Data Analysis Using Generalized Linear Models*, Biometrika 1986.

use std::collections::{BTreeMap, HashMap};

use super::normal_equations::Factor;
use super::reference_view::ReferenceView;
use super::residuals::{GAIN, Term, UNKNOWNS};
use super::solver::{Problem, Weighing, robust_weight};
use super::surface_samples::SurfaceSample;

/// Side of a region, in typical depths.
const SIDE: f64 = 0.1;

/// Sets the region of each sample, and returns how many there are.
pub(super) fn set_regions(
    views: &[ReferenceView],
    samples: &mut [Vec<SurfaceSample>],
    inverse_depth: f64,
) -> usize {
    let mut numbers: HashMap<[i64; 3], usize> = HashMap::new();
    for (view, samples) in views.iter().zip(samples) {
        for sample in samples {
            let point = view.camera.unproject(sample.pixel, 1.0 / sample.inverse_depth);
            let cell = (point * inverse_depth / SIDE).to_array().map(|along| along.floor() as i64);
            let next = numbers.len();
            sample.region = *numbers.entry(cell).or_insert(next);
        }
    }
    numbers.len()
}

/// What each region asks of the unknowns of the cameras that see it: its share of the right side of the normal equations.
pub(super) struct RegionShares(Vec<BTreeMap<usize, [f64; UNKNOWNS]>>);

impl RegionShares {
    pub(super) fn new(problem: &Problem, weighing: &Weighing) -> Self {
        let mut shares = vec![BTreeMap::<usize, [f64; UNKNOWNS]>::new(); problem.regions];
        for (pair, weighed) in problem.pairs.iter().zip(&weighing.pairs) {
            let views = problem.pair(*pair);
            for sample in problem.samples[pair[0]].iter().filter(|sample| !sample.judges) {
                let Some(terms) = views.terms(sample, weighing.level, weighed.gate) else { continue };
                for (term, sigma) in [terms.distance, terms.color].into_iter().zip(weighed.sigmas) {
                    let Some(Term { residual, source, target }) = term else { continue };
                    let pull = -robust_weight(residual, sigma) * residual;
                    for (camera, by_unknown) in pair.iter().zip([source, target]) {
                        let share = shares[sample.region].entry(*camera).or_default();
                        share.iter_mut().zip(by_unknown).for_each(|(sum, slope)| *sum += pull * slope);
                    }
                }
            }
        }
        Self(shares)
    }

    /// Standard errors of the unknowns of a camera's pose: how differently single regions would have it.
    pub(super) fn pose_errors(&self, factor: &Factor, camera: usize) -> [f64; GAIN] {
        let columns: [Vec<f64>; GAIN] =
            std::array::from_fn(|unknown| factor.inverse_column(camera * UNKNOWNS + unknown));
        columns.map(|column| {
            let asked = |share: &BTreeMap<usize, [f64; UNKNOWNS]>| -> f64 {
                let of_camera = |(camera, share): (&usize, &[f64; UNKNOWNS])| -> f64 {
                    column[camera * UNKNOWNS..].iter().zip(share).map(|(a, b)| a * b).sum()
                };
                share.iter().map(of_camera).sum()
            };
            self.0.iter().map(|share| asked(share).powi(2)).sum::<f64>().sqrt()
        })
    }
}
