//! Settings over several captures: ranks, and differences to the default.
//!
//! Captures differ far more than settings do. So a setting is compared with the default of the same capture, and what is averaged over
//! captures is that difference; the captures are the draws, and their number less one the degrees of freedom.

use super::results::CaptureResults;
use crate::sweep::{Point, Series};
use crate::trial::{MeanEstimate, PairedDifference};

/// One setting or rival, measured on every capture.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Overall {
    pub(super) label: String,
    pub(super) series: Series,
    /// Mean over captures of its rank by accuracy among what was measured on all, 1 the best.
    pub(super) rank: f64,
    /// Accuracy less that of the default, dB.
    pub(super) ahead_db: MeanEstimate,
    /// The smallest of these differences, and the capture that it is of.
    pub(super) least: (f64, String),
    /// Geometric mean of its bytes, and of its milliseconds, as shares of the default's.
    pub(super) bytes: f64,
    pub(super) milliseconds: f64,
}

/// Everything that was measured on every capture with a sweep, the best first. Empty for fewer than two.
pub(super) fn overall(captures: &[CaptureResults]) -> Vec<Overall> {
    let swept: Vec<&CaptureResults> =
        captures.iter().filter(|capture| reference(capture).is_some()).collect();
    if swept.len() < 2 {
        return Vec::new();
    }
    let is_everywhere = |label: &str| swept.iter().all(|capture| find(capture, label).is_some());
    let labels: Vec<&Point> = swept[0].points.iter().filter(|point| is_everywhere(&point.label)).collect();
    let mut rows: Vec<Overall> =
        labels.iter().filter_map(|point| of_label(&point.label, point.series, &swept, &labels)).collect();
    rows.sort_by(|a, b| b.ahead_db.mean.total_cmp(&a.ahead_db.mean));
    rows
}

fn of_label(label: &str, series: Series, swept: &[&CaptureResults], labels: &[&Point]) -> Option<Overall> {
    let (mut ranks, mut ahead, mut bytes, mut times) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    let mut least = (f64::INFINITY, String::new());
    for capture in swept {
        let (point, default) = (find(capture, label)?, reference(capture)?);
        let better = |other: &&&Point| {
            find(capture, &other.label).is_some_and(|other| other.psnr_filled_db > point.psnr_filled_db)
        };
        ranks.push(1.0 + labels.iter().filter(better).count() as f64);
        let paired = PairedDifference::between(&point.views, &default.views);
        let difference =
            paired.map_or(point.psnr_filled_db - default.psnr_filled_db, |paired| paired.db.mean);
        ahead.push(difference);
        if difference < least.0 {
            least = (difference, capture.name.clone());
        }
        bytes.push((point.bytes_of_samples() as f64 / default.bytes_of_samples() as f64).ln());
        times.push((point.milliseconds / default.milliseconds).ln());
    }
    Some(Overall {
        label: label.to_owned(),
        series,
        rank: MeanEstimate::of(&ranks).mean,
        ahead_db: MeanEstimate::of(&ahead),
        least,
        bytes: MeanEstimate::of(&bytes).mean.exp(),
        milliseconds: MeanEstimate::of(&times).mean.exp(),
    })
}

/// The point of the default settings.
pub(super) fn reference(capture: &CaptureResults) -> Option<&Point> {
    capture.points.iter().find(|point| point.series == Series::Reference)
}

fn find<'a>(capture: &'a CaptureResults, label: &str) -> Option<&'a Point> {
    capture.points.iter().find(|point| point.label == label)
}

#[cfg(test)]
mod tests {
    use super::super::tests::capture;
    use super::*;

    #[test]
    fn settings_are_ranked_by_their_mean_difference_to_the_default_of_each_capture() {
        let rows = overall(&[capture("a", 20.0, 21.0), capture("b", 40.0, 36.0)]);
        let labels: Vec<&str> = rows.iter().map(|row| row.label.as_str()).collect();
        assert_eq!(
            labels,
            ["default, gather", "other", "TSDF volume"],
            "what one capture alone has is left out"
        );
        assert_eq!((rows[0].ahead_db.mean, rows[0].rank), (0.0, 1.5));
        assert_eq!((rows[2].ahead_db.mean, rows[2].ahead_db.standard_error), (-1.5, 2.5));
        assert_eq!((rows[2].least.0, rows[2].least.1.as_str()), (-4.0, "b"));
        assert!((rows[1].bytes - 0.5).abs() < 1e-12 && (rows[2].bytes - 2.0).abs() < 1e-12);
        assert!(overall(&[capture("a", 20.0, 21.0)]).is_empty(), "one capture says nothing of others");
    }
}
