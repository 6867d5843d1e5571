//! How certain a mean over views is.

use serde::{Deserialize, Serialize};

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
