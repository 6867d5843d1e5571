//! How close a picture is to the truth.
//!
//! Sources: PSNR as usual, on sRGB-encoded values. SSIM from Wang, Bovik, Sheikh and Simoncelli, *Image Quality
//! Assessment: From Error Visibility to Structural Similarity*, 2004: an 11×11 Gaussian window of σ 1.5, K₁ = 0.01,
//! K₂ = 0.03, biased (weighted) variances, the mean over all windows that lie inside the picture. It is computed on luma
//! with 8-bit scale, as the authors' own code does. What differs: luma is not rounded to whole steps, and a picture
//! smaller than the window is compared in the largest window that fits.

use rayon::prelude::*;

use crate::capture::Frame;
use crate::color::srgb_from_linear;
use crate::error::{Error, Result};
use crate::grid::Grid;
use crate::render::{NO_IMAGE, Picture};

/// The PSNR given for equal pictures, dB: JSON knows no infinity. 8-bit pictures that differ in one value of one pixel
/// among a million already reach 107 dB.
pub const MAX_PSNR_DB: f64 = 120.0;

/// How close one picture is to the truth.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Scores {
    /// Peak signal-to-noise ratio over the pixels that got a sample, dB; read it together with `coverage`. Where no pixel
    /// got one, the same as `psnr_all_db`. Filling holes does not change it.
    pub psnr_db: f64,
    /// The same over all pixels, dB: holes are black, or whatever they were filled with, so that it is this number that tells
    /// what filling is worth. Sky that no camera ever saw weighs heavily in it.
    pub psnr_all_db: f64,
    /// Structural similarity of luma, -1 to 1, over windows whose middle got a sample; 0 where none did. Such windows reach
    /// into holes, filled or not.
    pub ssim: f64,
    /// Share of the true pixels (those with a depth or at infinity) that got a sample, 0 to 1; 1 where there are none.
    /// A filled hole got none.
    pub coverage: f64,
}

/// Compares a picture with the truth.
///
/// # Errors
/// [`Error::Invalid`] where the two differ in size.
pub fn score(picture: &Picture, truth: &Frame) -> Result<Scores> {
    if picture.color.size() != truth.size() {
        let ((width, height), (true_width, true_height)) = (picture.color.size(), truth.size());
        return Err(Error::invalid(
            "truth",
            format!("the true picture is {true_width}×{true_height} but the vantage is {width}×{height}"),
        ));
    }
    let painted = display_values(picture.color.as_slice());
    let true_linear: Vec<_> =
        truth.color.as_slice().iter().map(|color| color.map(half::f16::to_f32)).collect();
    let true_values = display_values(&true_linear);

    let covered = |index: &usize| picture.image.as_slice()[*index] != NO_IMAGE;
    let real: Vec<usize> =
        (0..truth.inverse_depth.len()).filter(|&i| truth.inverse_depth.as_slice()[i] >= 0.0).collect();
    let reached = real.iter().filter(|index| covered(index)).count();
    let (width, height) = truth.size();
    let luma_grid = |values: &[[f32; 3]]| Grid::from_vec(width, height, values.iter().map(luma).collect());
    let psnr_all_db = psnr_db(&painted, &true_values, 0..painted.len()).unwrap_or(MAX_PSNR_DB);
    Ok(Scores {
        psnr_db: psnr_db(&painted, &true_values, (0..painted.len()).filter(covered)).unwrap_or(psnr_all_db),
        psnr_all_db,
        ssim: ssim(&luma_grid(&painted), &luma_grid(&true_values), |x, y| covered(&(y * width + x))),
        coverage: if real.is_empty() { 1.0 } else { reached as f64 / real.len() as f64 },
    })
}

/// Linear Rec.709 as a display shows it: sRGB-encoded and clipped to 0 to 1.
#[must_use]
pub fn display_values(linear: &[[f32; 3]]) -> Vec<[f32; 3]> {
    linear.par_iter().map(|color| color.map(|value| srgb_from_linear(value).clamp(0.0, 1.0))).collect()
}

/// Luma of an encoded color (0 to 1), 8-bit scale: 0 to 255. The weights are Rec.601's, as in the SSIM authors' code.
#[must_use]
pub fn luma(encoded: &[f32; 3]) -> f32 {
    255.0 * (0.299 * encoded[0] + 0.587 * encoded[1] + 0.114 * encoded[2])
}

/// Peak signal-to-noise ratio in dB over the pixels named, for values whose peak is 1, at most [`MAX_PSNR_DB`]; `None`
/// where no pixel is named.
#[must_use]
pub fn psnr_db(a: &[[f32; 3]], b: &[[f32; 3]], pixels: impl Iterator<Item = usize>) -> Option<f64> {
    let mut count = 0_u64;
    let mut sum = 0.0;
    for pixel in pixels {
        for channel in 0..3 {
            let difference = f64::from(a[pixel][channel]) - f64::from(b[pixel][channel]);
            sum += difference * difference;
        }
        count += 3;
    }
    (count > 0).then(|| (10.0 * (count as f64 / sum).log10()).min(MAX_PSNR_DB))
}

const WINDOW: usize = 11;
const SIGMA: f64 = 1.5;
const C1: f64 = (0.01 * 255.0) * (0.01 * 255.0);
const C2: f64 = (0.03 * 255.0) * (0.03 * 255.0);

/// Mean structural similarity of two pictures of one size with values from 0 to 255, over the windows whose middle pixel
/// `(x, y)` counts; 1 for pictures without pixels, 0 where no window counts.
///
/// # Panics
/// If the sizes differ: the caller has compared them.
#[must_use]
pub fn ssim(a: &Grid<f32>, b: &Grid<f32>, counts: impl Fn(usize, usize) -> bool + Sync) -> f64 {
    assert_eq!(a.size(), b.size(), "pictures of one size");
    let (width, height) = a.size();
    if a.is_empty() {
        return 1.0;
    }
    let (weights_x, weights_y) = (window(width), window(height));
    let rows = height - weights_y.len() + 1;
    let columns = width - weights_x.len() + 1;
    // Sums per row, added up in order: the same bits whatever the number of threads.
    let row_sums: Vec<(f64, usize)> = (0..rows)
        .into_par_iter()
        .map(|top| {
            let moments = column_moments(a, b, top, &weights_y);
            let counted =
                (0..columns).filter(|left| counts(left + weights_x.len() / 2, top + weights_y.len() / 2));
            counted.fold((0.0, 0), |(sum, count), left| {
                (sum + similarity(&moments[left..], &weights_x), count + 1)
            })
        })
        .collect();
    let (sum, count) = row_sums.iter().fold((0.0, 0), |(sum, count), row| (sum + row.0, count + row.1));
    if count == 0 { 0.0 } else { sum / count as f64 }
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
fn similarity(columns: &[[f64; 5]], weights: &[f64]) -> f64 {
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
    luminance * (2.0 * covariance + C2) / (variances + C2)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A deterministic pair: a gradient with stripes, and the same with a pattern on top.
    fn pair() -> (Grid<f32>, Grid<f32>) {
        let value = |x: usize, y: usize| ((7 * x + 13 * y + (x * y) / 5) % 256) as f32;
        let a = Grid::from_fn(40, 30, value);
        let b = Grid::from_fn(40, 30, |x, y| {
            (value(x, y) + ((x * x + 3 * y) % 31) as f32 - 15.0).clamp(0.0, 255.0)
        });
        (a, b)
    }

    /// Reference values from scikit-image 0.26.0:
    ///
    /// ```python
    /// import numpy as np; from skimage.metrics import structural_similarity as s, peak_signal_noise_ratio as p
    /// y, x = np.mgrid[0:30, 0:40]; a = ((7*x + 13*y + (x*y)//5) % 256).astype(float)
    /// b = np.clip(a + (x*x + 3*y) % 31 - 15.0, 0, 255)
    /// print(s(a, b, gaussian_weights=True, sigma=1.5, use_sample_covariance=False, data_range=255), p(a, b, data_range=255))
    /// ```
    #[test]
    fn values_agree_with_an_independent_implementation() {
        let (a, b) = pair();
        assert!(
            (ssim(&a, &b, |_, _| true) - 0.973_635_499_819).abs() < 1e-9,
            "{}",
            ssim(&a, &b, |_, _| true)
        );
        let unit = |grid: &Grid<f32>| grid.as_slice().iter().map(|v| [v / 255.0; 3]).collect::<Vec<_>>();
        let psnr = psnr_db(&unit(&a), &unit(&b), 0..a.len()).unwrap();
        assert!((psnr - 29.316_196).abs() < 1e-4, "{psnr}");
    }

    #[test]
    fn equal_pictures_score_perfectly_and_others_do_not() {
        let (a, b) = pair();
        assert!((ssim(&a, &a, |_, _| true) - 1.0).abs() < 1e-12);
        assert!(ssim(&a, &b, |_, _| true) < 1.0 && ssim(&a, &b, |_, _| true) == ssim(&b, &a, |_, _| true));
        assert_eq!(psnr_db(&[[0.5; 3]], &[[0.5; 3]], 0..1), Some(MAX_PSNR_DB));
        assert_eq!(psnr_db(&[[0.5; 3]], &[[0.6; 3]], 0..0), None);
        let decibels = psnr_db(&[[0.5; 3]], &[[0.6; 3]], 0..1).unwrap();
        assert!((decibels - 20.0).abs() < 1e-4);
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
    fn holes_count_as_black_and_against_coverage_but_only_where_there_is_truth() {
        let mut picture = Picture {
            color: Grid::filled(4, 1, [1.0; 3]),
            inverse_depth: Grid::filled(4, 1, 0.5),
            image: Grid::filled(4, 1, 0),
        };
        let truth = Frame {
            color: Grid::filled(4, 1, [half::f16::ONE; 3]),
            inverse_depth: Grid::from_vec(4, 1, vec![0.5, 0.0, 0.5, -1.0]),
            normal_in_world: None,
            depth_step_relative: 0.0,
        };
        assert_eq!(score(&picture, &truth).unwrap().coverage, 1.0);
        for hole in [1, 3] {
            picture.color[(hole, 0)] = [0.0; 3];
            picture.image[(hole, 0)] = NO_IMAGE;
        }
        let scores = score(&picture, &truth).unwrap();
        assert!((scores.coverage - 2.0 / 3.0).abs() < 1e-12);
        assert!((scores.psnr_all_db - 10.0 * 2.0_f64.log10()).abs() < 1e-5);
        assert_eq!(scores.psnr_db, MAX_PSNR_DB);
        picture.color = Grid::filled(2, 2, [0.0; 3]);
        assert!(score(&picture, &truth).is_err());
    }
}
