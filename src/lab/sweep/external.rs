//! Figures that another program published or gave.

use serde::{Deserialize, Serialize};

use super::point::{Point, Series};
use crate::trial::{Trial, TrialResult};
use overlook_engine::error::{Error, Result};
use overlook_engine::settings::Settings;

/// What is known of another program on the same capture and truth.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ExternalPoint {
    /// Its name.
    pub name: String,
    /// Mean PSNR in dB over all pixels that some camera saw.
    pub psnr_db: f64,
    /// Milliseconds for a view.
    pub milliseconds: f64,
    /// Bytes of what it shows views from.
    pub bytes: u64,
}

impl std::str::FromStr for ExternalPoint {
    type Err = Error;

    /// Reads `name=dB,ms,bytes`.
    fn from_str(text: &str) -> Result<Self> {
        let wrong = |what: &str| {
            Error::invalid(
                format!("--rival {text}"),
                format!("{what}; write it as name=dB,ms,bytes, as in RVS=26.0,301,5200000"),
            )
        };
        let (name, figures) = text.rsplit_once('=').ok_or_else(|| wrong("there is no '='"))?;
        let figures: Vec<&str> = figures.split(',').map(str::trim).collect();
        let [psnr_db, milliseconds, bytes] = figures[..] else {
            return Err(wrong("there must be three figures"));
        };
        let positive = |text: &str, what: &str| {
            let number = text.parse::<f64>().ok().filter(|number| number.is_finite() && *number > 0.0);
            number.ok_or_else(|| wrong(&format!("'{text}' is no {what} above 0")))
        };
        let name = name.trim();
        if name.is_empty() {
            return Err(wrong("the name is missing"));
        }
        Ok(Self {
            name: name.to_owned(),
            psnr_db: positive(psnr_db, "number of dB")?,
            milliseconds: positive(milliseconds, "number of milliseconds")?,
            bytes: positive(bytes, "number of bytes")?.round() as u64,
        })
    }
}

impl ExternalPoint {
    /// As a point beside measured ones, which were scored at this many vantages.
    pub(super) fn point(&self, reference: &Settings, vantages: usize) -> Point {
        let trial = Trial::new(self.name.clone(), reference.clone());
        let measured =
            TrialResult { bytes: self.bytes, milliseconds: self.milliseconds, ..TrialResult::default() };
        Point {
            psnr_db: self.psnr_db,
            psnr_filled_db: self.psnr_db,
            vantages,
            ..Point::new(&trial, Series::External, &measured)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_of_another_program_are_read_and_nonsense_is_refused_by_what_is_wrong_with_it() {
        let read = |text: &str| text.parse::<ExternalPoint>();
        let point = read("RVS 4.0 = 26.0, 301, 5.2e6").unwrap();
        assert_eq!(
            (point.name.as_str(), point.psnr_db, point.milliseconds, point.bytes),
            ("RVS 4.0", 26.0, 301.0, 5_200_000)
        );
        for (text, what) in [
            ("RVS", "no '='"),
            ("=1,2,3", "name is missing"),
            ("RVS=1,2", "three figures"),
            ("RVS=1,2,3,4", "three figures"),
            ("RVS=NaN,2,3", "dB"),
            ("RVS=1,-2,3", "milliseconds"),
            ("RVS=1,2,0", "bytes"),
        ] {
            let said = read(text).unwrap_err().to_string();
            assert!(said.contains(what) && said.contains("name=dB,ms,bytes"), "{said}");
        }
    }
}
