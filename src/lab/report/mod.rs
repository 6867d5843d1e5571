//! One page on any number of captures: what each setting and each rival gives, where it breaks, and how failure looks.
//!
//! ```text
//! CaptureResults (sweep, stress test, pictures) ─ together: ranks and mean differences ─▶ page: HTML with everything embedded
//! ```

mod page;
mod sections;
mod together;

use crate::stress::{BreakingPoint, StressPoint};
use crate::sweep::Point;
use crate::tune::ChosenViews;
pub use page::page;

/// What was measured on one capture.
#[derive(Debug, Default)]
pub struct CaptureResults {
    /// Name of the capture.
    pub name: String,
    /// The truth in words, of the sweep or of the stress test.
    pub truth: String,
    /// The commands that measured it.
    pub commands: Vec<String>,
    /// Versions of the program that measured it.
    pub versions: Vec<String>,
    /// Points of the sweep; empty without one.
    pub points: Vec<Point>,
    /// Points of the stress test; empty without one.
    pub stress: Vec<StressPoint>,
    /// Breaking points of the stress test.
    pub failures: Vec<BreakingPoint>,
    /// The fewest views that show everything, where they were chosen.
    pub views: Option<ChosenViews>,
    /// The worst views of the sweep's default.
    pub worst: Vec<CaptionedPicture>,
    /// At the breaking points of the stress test.
    pub breaking: Vec<CaptionedPicture>,
}

/// A picture with what it shows.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CaptionedPicture {
    /// What it shows, in a sentence.
    pub caption: String,
    /// The picture as a file in PNG.
    pub png: Vec<u8>,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sweep::Series;
    use crate::trial::{Trial, TrialResult};
    use overlook_engine::settings::Settings;

    fn point(label: &str, series: Series, db: f64, bytes: u64) -> Point {
        let measured = TrialResult { bytes, milliseconds: 2.0, ..TrialResult::default() };
        let trial = Trial::new(label, Settings::default());
        Point { psnr_filled_db: db, psnr_db: db, vantages: 3, ..Point::new(&trial, series, &measured) }
    }

    pub(super) fn capture(name: &str, base_db: f64, rival_db: f64) -> CaptureResults {
        let points = vec![
            point("default, gather", Series::Reference, base_db, 1000),
            point("other", Series::Variation, base_db - 0.5, 500),
            point("TSDF volume", Series::Tsdf, rival_db, 2000),
            point(&format!("only {name}"), Series::Variation, base_db + 9.0, 1),
        ];
        CaptureResults {
            name: name.to_owned(),
            truth: "its own views".to_owned(),
            points,
            ..CaptureResults::default()
        }
    }
}
