//! The docket of a frame: for every sample those of other cameras that may stand for it, found once for a range of tolerances.
//!
//! Where a sample lies in the other cameras' pictures, how far it is from the surface found there, how much normals and colors
//! differ: no tolerance touches any of that. Whoever turns a threshold prunes the same frame again and again; from the docket
//! that is a walk over lists instead of a search in every picture. What differs from [`crate::preprocess::pruning`]: nothing in the verdicts.
//!
//! ```text
//! sample ─▶ claimants, best first: (verdict if it stands, the tolerances from which on it does)
//! ```
//!
//! A list leaves out whom a better claimant covers: one that holds whenever the other does, and that nothing is better than,
//! so that it is surely kept. Nearly always one is left.

use super::candidate::{Claimant, Tolerances, tolerances};
use crate::preprocess::registration::LANES;
use crate::settings::{PruningSettings, Settings};

/// How far a tolerance may be turned, either way, before the lists have to be made anew.
const RANGE: f32 = 4.0;

/// The claimants of every sample of a frame.
#[derive(Debug)]
pub(crate) struct CandidateLists {
    pub(crate) reach: ToleranceRange,
    /// Per camera, per band of rows.
    pub(crate) lists: Vec<Vec<Lists>>,
}

impl CandidateLists {
    /// Bytes that it takes in memory.
    pub(crate) fn bytes(&self) -> usize {
        let of_lists = |lists: &Lists| {
            size_of_val(&*lists.first) + size_of_val(&*lists.counts) + size_of_val(&*lists.claimants)
        };
        self.lists.iter().flatten().map(of_lists).sum()
    }
}

/// Which settings a docket serves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ToleranceRange {
    pub(crate) least: Tolerances,
    pub(crate) most: Tolerances,
    overlap: bool,
}

impl ToleranceRange {
    /// Tolerances around those of `settings`.
    pub(crate) fn around(settings: &PruningSettings) -> Self {
        Self {
            least: tolerances(&scaled(settings, 1.0 / RANGE)),
            most: tolerances(&scaled(settings, RANGE)),
            overlap: settings.overlap,
        }
    }

    /// Whether a docket that reaches so far serves `settings`.
    pub(crate) fn serves(&self, settings: &PruningSettings) -> bool {
        let wanted = tolerances(settings);
        let within = (0..3).all(|i| self.least[i] <= wanted[i] && wanted[i] <= self.most[i]);
        within && self.overlap == settings.overlap
    }
}

fn scaled(settings: &PruningSettings, factor: f32) -> PruningSettings {
    let mut scaled = settings.clone();
    scaled.depth_tolerance *= factor;
    scaled.normal_tolerance = (settings.normal_tolerance * factor).min(180.0);
    scaled.color_tolerance *= factor;
    scaled
}

/// The most tolerant settings that a docket around `settings` serves.
pub(crate) fn most_tolerant(settings: &Settings) -> Settings {
    Settings { pruning: scaled(&settings.pruning, RANGE), ..settings.clone() }
}

/// The claimants of the samples of some rows of one camera.
#[derive(Debug, Default)]
pub(crate) struct Lists {
    /// Where those of each sixteen pixels of a row begin, row by row.
    pub(crate) first: Vec<u32>,
    /// Per pixel, how many claimants it has, with flags.
    pub(crate) counts: Vec<u16>,
    pub(crate) claimants: Vec<Claimant>,
}

/// Set in a count where the two rate models may name different winners.
pub(crate) const DISPUTABLE: u16 = 1 << 15;
/// Set in a count where the sample's own color is mixed.
pub(crate) const IS_MIXED: u16 = 1 << 14;
/// The rest of a count.
pub(crate) const COUNT: u16 = IS_MIXED - 1;

impl Lists {
    /// The claimants of a pixel, by its place in the band, of a picture of `width` columns.
    pub(crate) fn of(&self, place: usize, width: usize) -> &[Claimant] {
        let columns = width.div_ceil(LANES);
        let (row, x) = (place / width, place % width);
        let before = &self.counts[place - x % LANES..place];
        let skipped: usize = before.iter().map(|count| usize::from(count & COUNT)).sum();
        let first = self.first[row * columns + x / LANES] as usize + skipped;
        &self.claimants[first..first + usize::from(self.counts[place] & COUNT)]
    }
}
