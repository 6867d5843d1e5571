//! The difference of two settings that were measured at the same views, vantage by vantage.
//!
//! Purpose: vantages differ in accuracy far more than settings do at any one of them. The standard error of a mean over vantages is
//! mostly that; the standard error of the mean *difference* is not.
//!
//! Source: Student's paired test (*The Probable Error of a Mean*, Biometrika 1908). What differs: frames of one vantage show much the
//! same surfaces and are no independent draws. Each vantage counts once, by the mean over the frames that both settings were scored
//! at, and the degrees of freedom are the vantages less one.

use std::collections::HashMap;

use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF as _, StudentsT};

/// Accuracy at one view.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ViewAccuracy {
    /// The view's own name.
    pub file_path: String,
    /// Views of one number are of one vantage, and follow each other.
    pub vantage: usize,
    /// PSNR in dB over all pixels that some camera saw, holes filled.
    pub psnr_filled_db: f64,
}

/// By how much one setting is more accurate than another, over the views that both were scored at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PairedDifference {
    /// Mean over vantages and its standard error, dB.
    pub db: MeanEstimate,
    /// Vantages that both were scored at.
    pub vantages: usize,
    /// Whether both are equally accurate at every view.
    is_none: bool,
}

impl PairedDifference {
    /// Accuracy at `views` less that at `others`; `None` where they have no view in common.
    #[must_use]
    pub fn between(views: &[ViewAccuracy], others: &[ViewAccuracy]) -> Option<Self> {
        let by_name: HashMap<&str, f64> =
            others.iter().map(|view| (view.file_path.as_str(), view.psnr_filled_db)).collect();
        let of_view = |view: &ViewAccuracy| Some(view.psnr_filled_db - by_name.get(view.file_path.as_str())?);
        let vantages = views.chunk_by(|before, after| before.vantage == after.vantage);
        let differences: Vec<Vec<f64>> = vantages
            .map(|of_vantage| of_vantage.iter().filter_map(of_view).collect::<Vec<_>>())
            .filter(|differences| !differences.is_empty())
            .collect();
        if differences.is_empty() {
            return None;
        }
        let means: Vec<f64> = differences.iter().map(|frames| MeanEstimate::of(frames).mean).collect();
        Some(Self {
            db: MeanEstimate::of(&means),
            vantages: means.len(),
            is_none: differences.iter().flatten().all(|difference| *difference == 0.0),
        })
    }

    /// The bound that the true difference exceeds with a probability of at most `risk`, dB. Infinite for a single vantage, unless both
    /// settings are equally accurate at all of its views.
    #[must_use]
    pub fn upper_bound_db(&self, risk: f64) -> f64 {
        if self.is_none {
            return 0.0;
        }
        let freedom = self.vantages.saturating_sub(1) as f64;
        let quantile = StudentsT::new(0.0, 1.0, freedom).map(|of| of.inverse_cdf(1.0 - risk));
        quantile.map_or(f64::INFINITY, |quantile| self.db.mean + quantile * self.db.standard_error)
    }
}

/// A mean and its standard error.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MeanEstimate {
    /// Mean over the values; over vantages, the mean of theirs.
    pub mean: f64,
    /// Standard deviation of the values, divided by the root of their number; 0 for a single one.
    pub standard_error: f64,
}

impl MeanEstimate {
    /// Mean and standard error of some values; zero without values.
    #[must_use]
    pub fn of(values: &[f64]) -> Self {
        let count = values.len().max(1) as f64;
        let mean = values.iter().sum::<f64>() / count;
        let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
        let standard_error = if values.len() < 2 { 0.0 } else { (squares / (count - 1.0) / count).sqrt() };
        Self { mean, standard_error }
    }

    /// Over the frames of several vantages. Each vantage counts once, by its mean, since its frames show much the same surfaces
    /// and have similar errors. With a single vantage, its frames count. Vantages without a frame are skipped.
    #[must_use]
    pub fn over_vantages(vantages: &[Vec<f64>]) -> Self {
        let vantages: Vec<&Vec<f64>> = vantages.iter().filter(|frames| !frames.is_empty()).collect();
        match vantages.as_slice() {
            [only] => Self::of(only),
            several => Self::of(&several.iter().map(|frames| Self::of(frames).mean).collect::<Vec<_>>()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn views(vantages: &[&[f64]]) -> Vec<ViewAccuracy> {
        let of_vantage = |(vantage, frames): (usize, &&[f64])| {
            let view = move |(frame, db): (usize, &f64)| ViewAccuracy {
                file_path: format!("{vantage}/{frame}"),
                vantage,
                psnr_filled_db: *db,
            };
            frames.iter().enumerate().map(view).collect::<Vec<_>>()
        };
        vantages.iter().enumerate().flat_map(of_vantage).collect()
    }

    #[test]
    fn a_difference_is_as_certain_as_it_is_alike_at_all_vantages() {
        let better = views(&[&[30.0, 31.0], &[40.0], &[25.0]]);
        let worse = views(&[&[29.0, 30.0], &[38.0], &[22.0]]);
        let found = PairedDifference::between(&better, &worse).unwrap();
        assert_eq!((found.vantages, found.db.mean), (3, 2.0));
        assert!((found.db.standard_error - (1.0 / 3.0_f64).sqrt()).abs() < 1e-12);
        // The 95 % quantile of Student's t with two degrees of freedom is 2.920 (any table).
        let bound_db = found.upper_bound_db(0.05);
        assert!((bound_db - (2.0 + 2.920 * found.db.standard_error)).abs() < 1e-3, "{bound_db}");
    }

    #[test]
    fn only_views_that_both_were_scored_at_count() {
        let all = views(&[&[30.0, 10.0], &[40.0]]);
        let some = [all[0].clone(), ViewAccuracy { file_path: "elsewhere".to_owned(), ..all[1].clone() }];
        let found = PairedDifference::between(&all, &some).unwrap();
        assert_eq!((found.vantages, found.db.mean), (1, 0.0));
        assert!(PairedDifference::between(&all[2..], &some).is_none());
    }

    #[test]
    fn one_vantage_bounds_nothing_unless_nothing_differs() {
        let one = views(&[&[30.0, 31.0]]);
        let other = views(&[&[30.0, 31.1]]);
        let bound_db = |views, others| PairedDifference::between(views, others).unwrap().upper_bound_db(0.05);
        assert_eq!(bound_db(&one, &other), f64::INFINITY);
        assert_eq!(bound_db(&one, &one.clone()), 0.0);
    }

    #[test]
    fn frames_of_one_vantage_do_not_make_a_mean_more_certain() {
        let two = [vec![30.0], vec![34.0]];
        let sixteen_frames_each = [vec![30.0; 16], vec![34.0; 16]];
        assert_eq!(MeanEstimate::over_vantages(&two), MeanEstimate { mean: 32.0, standard_error: 2.0 });
        assert_eq!(MeanEstimate::over_vantages(&sixteen_frames_each), MeanEstimate::over_vantages(&two));
        let one = [vec![], vec![30.0, 34.0]];
        assert_eq!(MeanEstimate::over_vantages(&one), MeanEstimate { mean: 32.0, standard_error: 2.0 });
    }
}
