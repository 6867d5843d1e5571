//! One page on any number of captures: what each setting and each rival gives, where it breaks, and how failure looks.
//!
//! ```text
//! CaptureResults (sweep, stress test, pictures) ─ together: ranks and mean differences ─▶ page: HTML with everything embedded
//! ```

mod markup;
mod page;
mod results;
mod sections;
mod together;

pub use page::page;
pub use results::{CaptionedPicture, CaptureResults};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sweep::{Point, Series};
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
