//! The candidate lists of a frame: for every sample those of other cameras that may be its witness, found once for a range of
//! tolerances.
//!
//! Where a sample is in the other cameras' pictures, how far it is from the surface found there, how much normals and colors
//! differ: no tolerance changes any of that. Pruning the same frame again with another threshold then goes over the lists
//! instead of searching every picture, with the same verdicts as [`crate::preprocess::pruning`].
//!
//! ```text
//! sample ─▶ candidates, best first: (verdict if it is the witness, the tolerances from which on it shows the point)
//! ```
//!
//! Dominated candidates are dropped: a better one is valid at every tolerance at which this one is, and is certainly kept.
//! Nearly always one is left.

use super::candidate::{ListedCandidate, Tolerances, tolerances};
use crate::settings::{AgreementRule, PruningSettings, Settings};
use crate::simd::LANES;

/// The factor by which a tolerance may change, either way, before the lists have to be built again.
const RANGE: f32 = 4.0;

/// The candidates of every sample of a frame.
#[derive(Debug)]
pub(crate) struct CandidateLists {
    pub(crate) range: ToleranceRange,
    /// Per camera, per band of rows.
    pub(crate) bands: Vec<Vec<BandCandidates>>,
}

impl CandidateLists {
    /// Bytes that the lists take in memory.
    pub(crate) fn bytes(&self) -> usize {
        let of_band = |band: &BandCandidates| {
            size_of_val(&*band.first) + size_of_val(&*band.counts) + size_of_val(&*band.candidates)
        };
        self.bands.iter().flatten().map(of_band).sum()
    }
}

/// The settings that candidate lists serve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ToleranceRange {
    pub(crate) least: Tolerances,
    pub(crate) most: Tolerances,
    overlap: bool,
    agreement: AgreementRule,
}

impl ToleranceRange {
    /// Tolerances around those of `settings`.
    pub(crate) fn around(settings: &PruningSettings) -> Self {
        Self {
            least: tolerances(&scaled(settings, 1.0 / RANGE)),
            most: tolerances(&scaled(settings, RANGE)),
            overlap: settings.overlap,
            agreement: settings.agreement,
        }
    }

    /// Whether lists of this range serve `settings`.
    pub(crate) fn serves(&self, settings: &PruningSettings) -> bool {
        let wanted = tolerances(settings);
        let within = (0..3).all(|i| self.least[i] <= wanted[i] && wanted[i] <= self.most[i]);
        within && self.overlap == settings.overlap && self.agreement == settings.agreement
    }
}

fn scaled(settings: &PruningSettings, factor: f32) -> PruningSettings {
    let mut scaled = settings.clone();
    scaled.depth_tolerance *= factor;
    scaled.normal_tolerance = (settings.normal_tolerance * factor).min(180.0);
    scaled.color_tolerance *= factor;
    scaled
}

/// The most tolerant settings that lists around `settings` serve.
pub(crate) fn most_tolerant(settings: &Settings) -> Settings {
    Settings { pruning: scaled(&settings.pruning, RANGE), ..settings.clone() }
}

/// The settings that lists around `settings` serve with which other cameras contradict most samples.
pub(crate) fn least_tolerant(settings: &Settings) -> Settings {
    let pruning = PruningSettings { agreement_margin: 1, ..scaled(&settings.pruning, 1.0 / RANGE) };
    Settings { pruning, ..settings.clone() }
}

/// The candidates of the samples of some rows of one camera.
#[derive(Debug, Default)]
pub(crate) struct BandCandidates {
    /// Where the candidates of each sixteen pixels of a row begin, row by row.
    pub(crate) first: Vec<u32>,
    /// Per pixel, how many candidates it has, and [`IS_MIXED`].
    pub(crate) counts: Vec<u16>,
    pub(crate) candidates: Vec<ListedCandidate>,
}

/// Set in a count where the sample's own color is mixed.
pub(crate) const IS_MIXED: u16 = 1 << 15;
/// The bits of the count itself.
pub(crate) const COUNT: u16 = IS_MIXED - 1;

impl BandCandidates {
    /// The candidates of the pixel at `index` of the band, in a picture of `width` columns.
    pub(crate) fn of(&self, index: usize, width: usize) -> &[ListedCandidate] {
        let columns = width.div_ceil(LANES);
        let (row, x) = (index / width, index % width);
        let before = &self.counts[index - x % LANES..index];
        let skipped: usize = before.iter().map(|count| usize::from(count & COUNT)).sum();
        let first = self.first[row * columns + x / LANES] as usize + skipped;
        &self.candidates[first..first + usize::from(self.counts[index] & COUNT)]
    }
}
