//! A histogram of magnitudes of any size.

use serde::{Deserialize, Serialize};

use crate::preprocess::noise::{bin_of_rank, rank_of_share};

/// Counts numbers by their magnitude, sixteen bins to an octave, so that memory is bounded.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct LogHistogram {
    /// Empty until there is a number.
    counts: Vec<u32>,
}

impl LogHistogram {
    /// Low bits of an `f32` that the bin does not depend on.
    const SHIFT: u32 = 19;
    /// Smaller values count as 0.
    const SMALLEST: f32 = 1.0 / 4096.0;
    /// Larger values count as this.
    const LARGEST: f32 = 4096.0;
    /// The bin before that of [`LogHistogram::SMALLEST`].
    const FIRST: u32 = (Self::SMALLEST.to_bits() >> Self::SHIFT) - 1;
    const BINS: usize = ((Self::LARGEST.to_bits() >> Self::SHIFT) - Self::FIRST) as usize + 1;

    /// Counts a number; NaN counts as the largest.
    pub(crate) fn count(&mut self, value: f32) {
        self.counts.resize(Self::BINS, 0);
        let bin = (value.abs().min(Self::LARGEST).to_bits() >> Self::SHIFT).saturating_sub(Self::FIRST);
        self.counts[bin as usize] += 1;
    }

    /// Adds the counts of another histogram.
    pub(crate) fn add(&mut self, other: &Self) {
        self.counts.resize(self.counts.len().max(other.counts.len()), 0);
        for (count, other) in self.counts.iter_mut().zip(&other.counts) {
            *count += other;
        }
    }

    /// How many numbers were counted.
    pub(crate) fn total(&self) -> u64 {
        self.counts.iter().copied().map(u64::from).sum()
    }

    /// The magnitude, to the middle of its bin, that a share of the numbers does not exceed; 0 where there is none.
    pub(crate) fn within(&self, share: f64) -> f32 {
        let rank = rank_of_share(self.total(), share).max(1);
        let bin = bin_of_rank(self.counts.iter().copied().map(u64::from), rank);
        bin.filter(|bin| *bin > 0).map_or(0.0, |bin| {
            f32::from_bits(((bin as u32 + Self::FIRST) << Self::SHIFT) | 1 << (Self::SHIFT - 1))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spread_tells_shares_to_a_twentieth() {
        let mut spread = LogHistogram::default();
        assert_eq!(spread.within(0.5), 0.0);
        (0..1000).for_each(|i| spread.count(i as f32 / 100.0));
        for share in [0.1, 0.5, 0.85, 1.0] {
            let found = spread.within(share);
            assert!((found / (10.0 * share as f32) - 1.0).abs() < 0.05, "{share}: {found}");
        }
        let mut far = LogHistogram::default();
        for value in [0.0, -0.0, f32::INFINITY] {
            far.count(value);
        }
        assert_eq!((far.within(0.5), far.total()), (0.0, 3));
        assert!(far.within(1.0) >= LogHistogram::LARGEST);
    }
}
