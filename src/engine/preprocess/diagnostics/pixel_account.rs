//! What became of every pixel of a capture, in numbers that add up.

use serde::Serialize;

use super::report::{Report, STATIC_RULE};
use crate::preprocess::pruning::Rule;

/// What became of all pixels of all frames of all cameras. Each is counted once: the shares add up to [`PixelAccount::pixels`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct PixelAccount {
    /// All of them.
    pub pixels: u64,
    /// Kept as samples.
    pub kept: u64,
    /// Repetitions over time, which a kept or dropped sample of several frames stands for.
    pub repeated: u64,
    /// Dropped for a kept sample of another camera that shows the same point.
    pub redundant: u64,
    /// Dropped because color or depth is blended across an edge.
    pub mixed: u64,
    /// Dropped because more cameras look past them than confirm them.
    pub contradicted: u64,
    /// Without depth: neither kept nor dropped.
    pub without_depth: u64,
    /// Cut by hand: pixels before pruning, and those that deleted samples stood for.
    pub cut: u64,
}

impl PixelAccount {
    /// What became of the pixels of one frame, by the rule that decided each. Nothing repeats in it, and what is cut by hand before pruning has
    /// no depth there.
    #[must_use]
    pub fn of_frame(rules: impl Iterator<Item = Rule>) -> Self {
        let mut account = Self::default();
        for rule in rules {
            account.pixels += 1;
            let part = match rule {
                Rule::NoSample => &mut account.without_depth,
                Rule::MixedYields | Rule::MixedDropped => &mut account.mixed,
                Rule::Contradicted => &mut account.contradicted,
                rule if rule.keeps() => &mut account.kept,
                _ => &mut account.redundant,
            };
            *part += 1;
        }
        account
    }

    /// What is not kept, whatever the reason.
    #[must_use]
    pub fn not_kept(&self) -> u64 {
        self.pixels.saturating_sub(self.kept)
    }

    /// What a kept sample represents: over time, or of another camera.
    #[must_use]
    pub fn represented(&self) -> u64 {
        self.repeated + self.redundant
    }

    /// The sum of all shares, which is [`PixelAccount::pixels`].
    #[must_use]
    pub fn sum(&self) -> u64 {
        let Self { pixels: _, kept, repeated, redundant, mixed, contradicted, without_depth, cut } = *self;
        kept + repeated + redundant + mixed + contradicted + without_depth + cut
    }
}

impl Report {
    /// What became of every pixel.
    #[must_use]
    pub fn pixel_account(&self) -> PixelAccount {
        let of = |name: &str| self.pruned.get(name).copied().unwrap_or_default();
        let [mixed_yields, mixed_dropped, contradicted] =
            [Rule::MixedYields, Rule::MixedDropped, Rule::Contradicted].map(|rule| of(rule.name()));
        let (repeated, mixed) = (of(STATIC_RULE), mixed_yields + mixed_dropped);
        let dropped: u64 = self.pruned.values().sum();
        PixelAccount {
            pixels: self.samples_in,
            kept: self.samples_kept,
            repeated,
            redundant: dropped.saturating_sub(repeated + mixed + contradicted),
            mixed,
            contradicted,
            without_depth: self.without_depth(),
            cut: self.cut.iter().map(|cut| cut.pixels + cut.sample_pixels).sum(),
        }
    }
}
