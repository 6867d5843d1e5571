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
//!
//! A listed candidate: a sample of another camera that may show the point of a sample, and the tolerances from which on it does.
//!
//! Tolerances are compared as codes of 16 bits, which grow with them. Where the codes are one apart or less, the same-surface
//! test itself decides, so that the verdicts are those of [`crate::preprocess::pruning`] bit for bit.

use crate::preprocess::pruning::{Rule, Verdict};
use crate::preprocess::registration::RequiredTolerances;
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

/// Depth in footprints, one less the cosine of the turn between the normals, color in 8-bit steps.
pub(crate) type Tolerances = [f32; 3];

/// The tolerances that `settings` grant.
pub(crate) fn tolerances(settings: &PruningSettings) -> Tolerances {
    let turn = 1.0 - settings.normal_tolerance.to_radians().cos();
    [settings.depth_tolerance, turn, settings.color_tolerance]
}

/// Codes of [`Tolerances`].
pub(crate) type Codes = [u16; 3];

/// The smallest tolerance whose code is not 0 has this exponent: 2⁻¹⁵.
const LEAST_EXPONENT: u32 = 127 - 15;

/// Bits of a float's fraction that a code leaves out.
const LEFT_OUT: u32 = 12;

/// A code of five bits of exponent and eleven of fraction: it never falls where the tolerance rises.
#[inline(always)]
pub(crate) fn code(tolerance: f32) -> u32 {
    // As numbers that are not negative, floats are in the order of their bits.
    let bits = tolerance.max(0.0).to_bits() >> LEFT_OUT;
    bits.saturating_sub(LEAST_EXPONENT << (23 - LEFT_OUT)).min(u32::from(u16::MAX))
}

/// The codes of `tolerances`.
pub(crate) fn codes(tolerances: Tolerances) -> Codes {
    tolerances.map(|tolerance| code(tolerance) as u16)
}

/// The codes of what one of a block's samples requires.
#[inline(always)]
pub(crate) fn codes_of<const N: usize>(required: &RequiredTolerances<N>, lane: usize) -> Codes {
    codes([required.depth[lane], required.turn[lane], required.color[lane]])
}

/// Quotients are rounded: a required tolerance may have the code beside that of the smallest tolerance that suffices.
const ROUNDING: u16 = 1;

/// Whether a candidate shows the point under some limits, as far as the codes tell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum CandidateValidity {
    Valid,
    Invalid,
    /// So near the limit that the same-surface test has to decide.
    NearLimit,
}

/// A sample of another camera that shows the point of a sample, at least at the largest tolerances.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ListedCandidate {
    /// The verdict on the sample if this one is its witness; [`Rule::BestRate`] where this one is the worse of both.
    pub(crate) verdict: Verdict,
    /// From which tolerances on both show the same point.
    pub(crate) required: Codes,
    /// Whether it is surely kept, as no other is better.
    pub(crate) is_sure: bool,
}

impl ListedCandidate {
    /// Whether it is the better one of both.
    #[inline(always)]
    pub(crate) fn is_better(&self) -> bool {
        self.verdict.rule != Rule::BestRate
    }

    /// Whether both show the same point within `limits`.
    #[inline(always)]
    pub(crate) fn validity(&self, limits: Codes) -> CandidateValidity {
        let [mut surely, mut maybe] = [true; 2];
        for (&required, &limit) in self.required.iter().zip(&limits) {
            surely &= required.saturating_add(ROUNDING) < limit;
            maybe &= required <= limit.saturating_add(ROUNDING);
        }
        match (surely, maybe) {
            (true, _) => CandidateValidity::Valid,
            (false, false) => CandidateValidity::Invalid,
            (false, true) => CandidateValidity::NearLimit,
        }
    }

    /// Whether this one shows the point wherever `other` does, within limits of `least` and more.
    #[inline(always)]
    pub(crate) fn covers(&self, other: &Self, least: Codes) -> bool {
        const MARGIN: u16 = 2 * ROUNDING + 1;
        let mut pairs = self.required.iter().zip(&other.required).zip(&least);
        // Where the other may be valid, the limit is at least what it requires less the rounding; then this one surely is.
        pairs.all(|((required, other), least)| required.saturating_add(MARGIN) <= *other.max(least))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_code_never_falls_where_the_tolerance_rises_and_tells_apart_what_differs_by_a_thousandth() {
        let mut tolerance = 1e-4_f32;
        while tolerance < 300.0 {
            assert!(code(tolerance * 1.001) > code(tolerance), "{tolerance}");
            assert!(code(tolerance * 1.001) <= code(tolerance) + 5);
            tolerance *= 1.000_37;
        }
        assert_eq!([code(0.0), code(-1.0), code(f32::INFINITY)], [0, 0, 65535]);
    }

    #[test]
    fn a_candidate_that_covers_another_is_surely_valid_wherever_the_other_may_be() {
        let candidate = |required| ListedCandidate {
            verdict: Verdict::without_witness(Rule::Tie),
            required,
            is_sure: true,
        };
        let least = [40, 40, 40];
        for required in 30..60 {
            for other_need in 30..60 {
                let (one, other) = (candidate([required, 0, 0]), candidate([other_need, 0, 0]));
                if !one.covers(&other, least) {
                    continue;
                }
                for limit in 40..70 {
                    let limits = [limit, 100, 100];
                    assert!(
                        other.validity(limits) == CandidateValidity::Invalid
                            || one.validity(limits) == CandidateValidity::Valid
                    );
                }
            }
        }
        assert!(candidate([36, 0, 0]).covers(&candidate([0, 0, 0]), least));
        assert!(!candidate([40, 0, 0]).covers(&candidate([0, 0, 0]), least));
    }
}
