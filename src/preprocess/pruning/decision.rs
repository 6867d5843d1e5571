//! What pruning decides: the rules, the verdict on a sample, and the verdicts of one level.

use crate::preprocess::layers::{CameraLayer, MIXED};
use crate::preprocess::temporal::{NO_SAMPLE, SpanLevel};

/// Why a sample was kept or dropped.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[repr(u8)]
pub enum Rule {
    /// Not a sample: the pixel has no depth.
    NoSample,
    /// Kept: no other camera sees this surface point.
    OnlyWitness,
    /// Kept: every other camera that sees the point samples it less densely (or equally, and comes later), or its sample is
    /// blended or its normal unknown, and this one's is not.
    BestRate,
    /// Kept: a better sample exists but was itself dropped for one that does not see this point (coverage guarantee), or is
    /// one of a longer span where those may not stand.
    Coverage,
    /// Kept: pruning is off.
    PruningOff,
    /// Dropped: the witness samples the point at a higher rate.
    LowerRate,
    /// Dropped: equal rates, and the witness belongs to an earlier camera.
    Tie,
    /// Dropped: an earlier camera shows the point (first-camera-wins).
    LaterCamera,
    /// Dropped: blended across a silhouette, and the witness is clean.
    MixedYields,
    /// Dropped: the normal is unknown, so that the rate is a guess, and the witness's is known.
    UnsureYields,
    /// Dropped: blended across a silhouette, and the settings drop all such samples. There is no witness.
    MixedDropped,
}

impl Rule {
    /// Every rule.
    pub const ALL: [Self; 11] = [
        Self::NoSample,
        Self::OnlyWitness,
        Self::BestRate,
        Self::Coverage,
        Self::PruningOff,
        Self::LowerRate,
        Self::Tie,
        Self::LaterCamera,
        Self::MixedYields,
        Self::UnsureYields,
        Self::MixedDropped,
    ];

    /// Name in reports and JSON.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::NoSample => "no_sample",
            Self::OnlyWitness => "only_witness",
            Self::BestRate => "best_rate",
            Self::Coverage => "coverage",
            Self::PruningOff => "pruning_off",
            Self::LowerRate => "lower_rate",
            Self::Tie => "tie",
            Self::LaterCamera => "later_camera",
            Self::MixedYields => "mixed_yields",
            Self::UnsureYields => "unsure_yields",
            Self::MixedDropped => "mixed_dropped",
        }
    }

    /// The rule as a sentence for people.
    #[must_use]
    pub fn sentence(self) -> &'static str {
        match self {
            Self::NoSample => "No sample: the pixel has no depth.",
            Self::OnlyWitness => "Kept: no other camera has a sample of this point throughout its span.",
            Self::BestRate => "Kept: no clean sample of this point with a known normal is denser.",
            Self::Coverage => {
                "Kept: the better sample does not stand: it was dropped for one that does not see this point, or lives in a longer span, which is not asked."
            }
            Self::PruningOff => "Kept: pruning is off.",
            Self::LowerRate => "Dropped: the witness samples this point more densely.",
            Self::Tie => "Dropped: equal rates, and the witness belongs to an earlier camera.",
            Self::LaterCamera => "Dropped: an earlier camera shows this point.",
            Self::MixedYields => {
                "Dropped: its color is blended across a silhouette, and the witness is clean."
            }
            Self::UnsureYields => "Dropped: its normal is not known, and the witness's is.",
            Self::MixedDropped => "Dropped: its color is blended across a silhouette.",
        }
    }

    /// Whether samples under this rule stay.
    #[must_use]
    pub fn keeps(self) -> bool {
        matches!(self, Self::OnlyWitness | Self::BestRate | Self::Coverage | Self::PruningOff)
    }
}

/// The verdict on one pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Verdict {
    /// The rule that decided.
    pub rule: Rule,
    /// Level of the witness, see [`FrameInspection::path`](crate::preprocess::inspect::FrameInspection::path); [`NO_SAMPLE`] where there is none.
    pub witness_level: SpanLevel,
    /// Camera of the witness; [`Verdict::NO_CAMERA`] where there is none.
    pub witness_camera: u16,
    /// Pixel of the witness, `y * width + x`; 0 where there is none.
    pub witness_pixel: u32,
}

impl Verdict {
    /// In place of a witness's camera where there is no witness.
    pub const NO_CAMERA: u16 = u16::MAX;

    /// A verdict without a witness.
    #[must_use]
    pub fn without_witness(rule: Rule) -> Self {
        Self { rule, witness_level: NO_SAMPLE, witness_camera: Self::NO_CAMERA, witness_pixel: 0 }
    }

    /// Whether the sample stays.
    #[must_use]
    pub fn is_kept(self) -> bool {
        self.rule.keeps()
    }
}

/// The verdicts on one camera's samples of one level.
#[derive(Clone, Debug, Default)]
pub struct Decided {
    /// Pixels that were decided, `y * width + x`, ascending.
    pub pixels: Vec<u32>,
    /// One verdict per pixel.
    pub verdicts: Vec<Verdict>,
    /// Where the other rate model would have named another camera, by pixel.
    pub disputes: Vec<Dispute>,
    /// Samples whose color was found to be blended across a silhouette.
    pub mixed: u64,
    /// How many of them are kept.
    pub mixed_kept: u64,
}

/// A sample of whose point the two rate models name different cameras as the best-sampled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Dispute {
    /// The pixel, `y * width + x`.
    pub pixel: u32,
    /// The camera that the model in use names.
    pub camera: u16,
    /// The camera that the other model names.
    pub other_camera: u16,
}

impl Decided {
    pub(crate) fn of_size(count: usize) -> Self {
        Self {
            pixels: vec![0; count],
            verdicts: vec![Verdict::without_witness(Rule::NoSample); count],
            disputes: Vec::new(),
            mixed: 0,
            mixed_kept: 0,
        }
    }

    pub(crate) fn count_mixed(&mut self, layer: &CameraLayer) {
        for (pixel, verdict) in self.pixels.iter().zip(&self.verdicts) {
            let is_mixed = layer.ranks[*pixel as usize].rank & MIXED != 0;
            self.mixed += u64::from(is_mixed);
            self.mixed_kept += u64::from(is_mixed & verdict.is_kept());
        }
    }
}
