//! Agreement between cameras: how noisy they are beside each other, which samples the others contradict, and the mean position and
//! color that confirming cameras give a surface.
//!
//! ```text
//! layers ─▶ measure: noise between cameras ─▶ votes on each sample: confirms, looks past, cannot tell ─▶ consensus
//! ```

mod consensus;
mod measure;
mod smooth_depth;
mod votes;

use crate::samples::VoteCounts;
pub(crate) use consensus::{AgreedSample, Consensus};
pub(crate) use measure::{NoiseLattice, measure_noise_between, where_most_are_noisy};
pub(crate) use smooth_depth::SmoothDepths;
pub(crate) use votes::{VoteTest, VotedRun};

/// Whether other cameras agree with a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SampleAgreement {
    /// At least one other camera confirms it, and not too many look past it.
    Confirmed,
    /// The cameras that look past it outnumber those that confirm it, its own among them, by the margin of the settings.
    Contradicted,
    /// No other camera confirms it, and too few look past it to contradict it.
    Alone,
}

impl SampleAgreement {
    /// The outcome of `counts` for a sample, flying or not. A sample is contradicted by a margin of `margin` cameras.
    #[must_use]
    pub fn of(counts: VoteCounts, margin: u32, is_flying: bool) -> Self {
        if counts.contradict(margin, is_flying) {
            Self::Contradicted
        } else if counts.confirm > 0 {
            Self::Confirmed
        } else {
            Self::Alone
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_camera_confirms_a_sample_and_one_more_than_its_own_and_the_confirming_ones_contradict_it() {
        let of = |confirm, look_past, margin| {
            SampleAgreement::of(VoteCounts { confirm, look_past }, margin, false)
        };
        assert_eq!(of(0, 0, 1), SampleAgreement::Alone);
        assert_eq!(of(0, 1, 1), SampleAgreement::Alone);
        assert_eq!(of(0, 2, 1), SampleAgreement::Contradicted);
        assert_eq!(of(1, 2, 1), SampleAgreement::Confirmed);
        assert_eq!(of(1, 3, 1), SampleAgreement::Contradicted);
        assert_eq!(of(0, 2, 2), SampleAgreement::Alone);
        let flying = |confirm, look_past| SampleAgreement::of(VoteCounts { confirm, look_past }, 1, true);
        assert_eq!(flying(0, 0), SampleAgreement::Contradicted, "its own camera looks past it");
        assert_eq!(flying(1, 0), SampleAgreement::Confirmed);
        assert_eq!(flying(1, 1), SampleAgreement::Contradicted);
    }
}
