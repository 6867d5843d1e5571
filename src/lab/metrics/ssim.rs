//! Structural similarity.
//!
//! Source: Wang, Bovik, Sheikh and Simoncelli, *Image Quality Assessment: From Error Visibility to Structural Similarity*,
//! 2004: an 11×11 Gaussian window of σ 1.5, K₁ = 0.01, K₂ = 0.03, biased (weighted) variances, the mean over all windows
//! that lie inside the picture. It is computed on luma with 8-bit scale, as the authors' own code does. What differs: luma
//! is not rounded to whole steps, and a picture smaller than the window is compared in the largest window that fits.
//!
//! Structural similarity over several scales.
//!
//! Source: Wang, Simoncelli and Bovik, *Multi-scale Structural Similarity for Image Quality Assessment*, 2003: contrast and
//! structure at five scales, luminance at the coarsest alone, each scale the mean of 2×2 pixels of the finer one, weighted
//! by the exponents of the paper's experiment. What differs: a picture too small for the window at some scale is compared
//! at the scales that fit, with their exponents scaled up to the same sum; where the contrast term is negative, it counts as 0.

use rayon::prelude::*;

use overlook_engine::grid::Grid;

/// Columns and rows of the window.
pub(super) const WINDOW: usize = 11;
const SIGMA: f64 = 1.5;
const C1: f64 = (0.01 * 255.0) * (0.01 * 255.0);
const C2: f64 = (0.03 * 255.0) * (0.03 * 255.0);

/// Means over the windows that count.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Similarity {
    /// Luminance times contrast and structure: the index itself (Wang et al., eq. 13).
    pub(super) whole: f64,
    /// Contrast and structure alone, which is what the finer scales of MS-SSIM look at.
    pub(super) contrast: f64,
}

/// Mean structural similarity of two pictures of one size with values from 0 to 255, over the windows whose middle pixel
/// `(x, y)` counts; 1 for pictures without pixels, 0 where no window counts.
///
/// # Panics
/// If the sizes differ: the caller has compared them.
#[must_use]
pub fn ssim(a: &Grid<f32>, b: &Grid<f32>, counts: impl Fn(usize, usize) -> bool + Sync) -> f64 {
    if a.is_empty() { 1.0 } else { similarity(a, b, counts).map_or(0.0, |similarity| similarity.whole) }
}

/// As [`ssim`], with its parts; `None` where no window counts.
pub(super) fn similarity(
    a: &Grid<f32>,
    b: &Grid<f32>,
    counts: impl Fn(usize, usize) -> bool + Sync,
) -> Option<Similarity> {
    assert_eq!(a.size(), b.size(), "pictures of one size");
    let (width, height) = a.size();
    if a.is_empty() {
        return None;
    }
    let (weights_x, weights_y) = (window(width), window(height));
    let rows = height - weights_y.len() + 1;
    let columns = width - weights_x.len() + 1;
    // Sums per row, added up in order: the same bits whatever the number of threads.
    let row_sums: Vec<[f64; 3]> = (0..rows)
        .into_par_iter()
        .map(|top| {
            let moments = column_moments(a, b, top, &weights_y);
            let counted =
                (0..columns).filter(|left| counts(left + weights_x.len() / 2, top + weights_y.len() / 2));
            counted.fold([0.0; 3], |[whole, contrast, count], left| {
                let index = in_window(&moments[left..], &weights_x);
                [whole + index.whole, contrast + index.contrast, count + 1.0]
            })
        })
        .collect();
    let [whole, contrast, count] =
        row_sums.iter().fold([0.0; 3], |sum, row| std::array::from_fn(|part| sum[part] + row[part]));
    (count > 0.0).then(|| Similarity { whole: whole / count, contrast: contrast / count })
}

/// Gaussian weights that sum to 1: eleven, or the largest odd number that fits into `length`.
fn window(length: usize) -> Vec<f64> {
    let radius = (WINDOW.min(length) - 1) / 2;
    let weight = |i: usize| {
        let distance = i as f64 - radius as f64;
        (-distance * distance / (2.0 * SIGMA * SIGMA)).exp()
    };
    let weights: Vec<f64> = (0..=2 * radius).map(weight).collect();
    let sum: f64 = weights.iter().sum();
    weights.into_iter().map(|weight| weight / sum).collect()
}

/// For each column: weighted means over the window's rows of a, b, a², b² and ab.
fn column_moments(a: &Grid<f32>, b: &Grid<f32>, top: usize, weights: &[f64]) -> Vec<[f64; 5]> {
    let mut moments = vec![[0.0; 5]; a.width()];
    for (row, weight) in weights.iter().enumerate() {
        for ((sum, x), y) in moments.iter_mut().zip(a.row(top + row)).zip(b.row(top + row)) {
            let (x, y) = (f64::from(*x), f64::from(*y));
            for (sum, value) in sum.iter_mut().zip([x, y, x * x, y * y, x * y]) {
                *sum += weight * value;
            }
        }
    }
    moments
}

/// The SSIM index of one window (Wang et al., eq. 13).
fn in_window(columns: &[[f64; 5]], weights: &[f64]) -> Similarity {
    let mut moments = [0.0; 5];
    for (column, weight) in columns.iter().zip(weights) {
        for (sum, value) in moments.iter_mut().zip(column) {
            *sum += weight * value;
        }
    }
    let [mean_a, mean_b, square_a, square_b, product] = moments;
    let variances = (square_a - mean_a * mean_a) + (square_b - mean_b * mean_b);
    let covariance = product - mean_a * mean_b;
    let luminance = (2.0 * mean_a * mean_b + C1) / (mean_a * mean_a + mean_b * mean_b + C1);
    let contrast = (2.0 * covariance + C2) / (variances + C2);
    Similarity { whole: luminance * contrast, contrast }
}

/// Exponents of the scales, the finest first (Wang et al., 2003, section 3.2).
const EXPONENTS: [f64; 5] = [0.0448, 0.2856, 0.3001, 0.2363, 0.1333];

/// Multi-scale structural similarity, 0 to 1, of two pictures of one size with values from 0 to 255, over the windows
/// whose middle pixel counts: at a coarser scale, where at least half of its four pixels do. 1 for pictures without
/// pixels, 0 where no window counts.
///
/// # Panics
/// If the sizes differ: the caller has compared them.
#[must_use]
pub fn ms_ssim(a: &Grid<f32>, b: &Grid<f32>, counts: &Grid<bool>) -> f64 {
    if a.is_empty() {
        return 1.0;
    }
    let side = a.width().min(a.height());
    let scales = (1..EXPONENTS.len()).take_while(|scale| side >> scale >= WINDOW).count() + 1;
    let sum: f64 = EXPONENTS[..scales].iter().sum();
    let (mut a, mut b, mut counts) = (a.clone(), b.clone(), counts.clone());
    let mut product = 1.0;
    for (scale, exponent) in EXPONENTS[..scales].iter().enumerate() {
        let Some(similarity) = similarity(&a, &b, |x, y| counts[(x, y)]) else { return 0.0 };
        let is_coarsest = scale + 1 == scales;
        let term = if is_coarsest { similarity.whole } else { similarity.contrast };
        product *= term.max(0.0).powf(exponent / sum);
        if !is_coarsest {
            (a, b) = (halved(&a), halved(&b));
            counts = halved(&counts.map(|counts| f32::from(u8::from(*counts)))).map(|share| *share >= 0.5);
        }
    }
    product
}

/// Means of 2×2 pixels; an odd last column or row is repeated.
fn halved(grid: &Grid<f32>) -> Grid<f32> {
    let (width, height) = grid.size();
    Grid::from_fn(width.div_ceil(2), height.div_ceil(2), |x, y| {
        let (x0, y0) = (2 * x, 2 * y);
        let (x1, y1) = ((x0 + 1).min(width - 1), (y0 + 1).min(height - 1));
        0.25 * (grid[(x0, y0)] + grid[(x1, y0)] + grid[(x0, y1)] + grid[(x1, y1)])
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_pictures_score_perfectly_and_others_do_not() {
        let a = Grid::from_fn(40, 30, |x, y| ((7 * x + 13 * y) % 256) as f32);
        let b = a.map(|value| (value * 1.1).min(255.0));
        let all = |_, _| true;
        assert!((ssim(&a, &a, all) - 1.0).abs() < 1e-12);
        assert!(ssim(&a, &b, all) < 1.0 && ssim(&a, &b, all) == ssim(&b, &a, all));
        assert_eq!(ssim(&a, &b, |_, _| false), 0.0);
    }

    #[test]
    fn pictures_smaller_than_the_window_are_compared_as_well() {
        for (width, height) in [(1, 1), (2, 40), (10, 3), (11, 11)] {
            let a = Grid::from_fn(width, height, |x, y| (20 * x + 3 * y) as f32);
            assert!((ssim(&a, &a, |_, _| true) - 1.0).abs() < 1e-12);
            assert!(ssim(&a, &a.map(|value| 255.0 - value), |_, _| true) < 0.9);
        }
        assert_eq!(ssim(&Grid::filled(0, 0, 0.0), &Grid::filled(0, 0, 0.0), |_, _| true), 1.0);
    }

    #[test]
    fn equal_pictures_score_one_at_any_size_and_others_less() {
        for (width, height) in [(1, 1), (12, 30), (64, 48), (180, 177)] {
            let a = Grid::from_fn(width, height, |x, y| ((17 * x + 29 * y) % 256) as f32);
            let all = Grid::filled(width, height, true);
            assert!((ms_ssim(&a, &a, &all) - 1.0).abs() < 1e-12);
            assert!(ms_ssim(&a, &a.map(|value| 255.0 - value), &all) < 0.9);
            assert_eq!(ms_ssim(&a, &a, &Grid::filled(width, height, false)), 0.0);
        }
    }
}
