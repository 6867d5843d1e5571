//! Structural similarity over several scales.
//!
//! Source: Wang, Simoncelli and Bovik, *Multi-scale Structural Similarity for Image Quality Assessment*, 2003: contrast and
//! structure at five scales, luminance at the coarsest alone, each scale the mean of 2×2 pixels of the finer one, weighted
//! by the exponents of the paper's experiment. What differs: a picture too small for the window at some scale is compared
//! at the scales that fit, with their exponents scaled up to the same sum; where the contrast term is negative, it counts as 0.

use super::ssim::{WINDOW, similarity};
use overlook_engine::grid::Grid;

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
