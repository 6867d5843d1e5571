//! How far pairs of cameras are apart about what both see, by the median.

use rayon::prelude::*;

use super::poses::WIDE_LOOK;
use super::solver::Problem;
use crate::capture::Camera;
use crate::median::median;

impl Problem {
    /// The median distance (footprints) and difference of brightness of each pair. The gate is wider than the solver's, in which all
    /// pairs that are far apart would look the same. A pair without a sample in sight has the gate as its distance, and 0 as its
    /// difference of brightness.
    pub(super) fn pair_medians(&self) -> Vec<[f64; 2]> {
        let of_pair = |pair: &[usize; 2]| {
            let [mut distances, mut brightness] = self.magnitudes(*pair, &WIDE_LOOK, 1);
            [median(&mut distances).unwrap_or(WIDE_LOOK.gate), median(&mut brightness).unwrap_or_default()]
        };
        self.pairs.par_iter().map(of_pair).collect()
    }

    /// The same with the cameras that the capture claims, and without gains.
    pub(super) fn pair_medians_as_claimed(&mut self, claimed: &[Camera]) -> Vec<[f64; 2]> {
        let mut cameras = claimed.to_vec();
        let mut gains = vec![0.0; claimed.len()];
        self.swap(&mut cameras, &mut gains);
        let medians = self.pair_medians();
        self.swap(&mut cameras, &mut gains);
        medians
    }

    fn swap(&mut self, cameras: &mut [Camera], gains: &mut Vec<f64>) {
        for (view, camera) in self.views.iter_mut().zip(cameras) {
            std::mem::swap(&mut view.camera, camera);
        }
        std::mem::swap(&mut self.log_gains, gains);
    }
}
