//! A listed candidate: a sample of another camera that may show the point of a sample, and the tolerances from which on it does.
//!
//! Tolerances are compared as codes of 16 bits, which grow with them. Where the codes are one apart or less, the same-surface
//! test itself decides, so that the verdicts are those of [`crate::preprocess::pruning`] bit for bit.

use crate::preprocess::pruning::{Rule, Verdict};
use crate::preprocess::registration::RequiredTolerances;
use crate::settings::PruningSettings;

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
