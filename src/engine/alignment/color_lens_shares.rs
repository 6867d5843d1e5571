//! The share of each pair of cameras in the normal equations of a color lens.
//!
//! Purpose: see [`super::color_lens_search`]. Source: iteratively reweighted least squares with Tukey's biweight, whose width is
//! measured pair by pair.

use rayon::prelude::*;

use super::color_lens::{BrightnessDifference, ColorLens, Matches, Sensing, UNKNOWNS};
use super::solver::TUKEY;
use crate::median::{MEDIAN_PER_SIGMA, median};

/// The weight of one match: neighbors are not independent, and a wrong pose is wrong for all matches of a pair.
const INDEPENDENT: f64 = 0.05;
/// Standard deviations of differences are never taken for less.
const LEAST_SIGMA: f64 = 0.05;

/// One pair's share of the normal equations of all unknowns. The lower triangle counts.
pub(super) struct LensEquations {
    pub(super) matrix: [[f64; UNKNOWNS]; UNKNOWNS],
    pub(super) right: [f64; UNKNOWNS],
}

/// The shares of all pairs, in their order.
pub(super) fn shares(pairs: &[Matches], lens: &ColorLens, sensing: &Sensing) -> Vec<LensEquations> {
    pairs.par_iter().map(|pair| share(&pair.differences(lens, sensing))).collect()
}

fn share(differences: &[BrightnessDifference]) -> LensEquations {
    let mut share = LensEquations { matrix: [[0.0; UNKNOWNS]; UNKNOWNS], right: [0.0; UNKNOWNS] };
    let mut sizes: Vec<f64> = differences.iter().map(|difference| difference.value.abs()).collect();
    let Some(middle) = median(&mut sizes) else { return share };
    let sigma = (middle / MEDIAN_PER_SIGMA).max(LEAST_SIGMA);
    for BrightnessDifference { value, by_unknown, .. } in differences {
        let relative = value / (TUKEY * sigma);
        if relative.abs() >= 1.0 {
            continue;
        }
        let weight = INDEPENDENT * (1.0 - relative * relative).powi(2) / (sigma * sigma);
        for row in 0..UNKNOWNS {
            let weighted = weight * by_unknown[row];
            for column in 0..=row {
                share.matrix[row][column] += weighted * by_unknown[column];
            }
            share.right[row] -= weighted * value;
        }
    }
    share
}
