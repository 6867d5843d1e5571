//! The decision on a sample: the twelve rules that keep or drop it, and the conditions that they are made of.
//!
//! ```text
//! no depth ─▶ NoSample    mixed, and of the sky or all such are dropped ─▶ MixedDropped    pruning is off ─▶ PruningOff
//! else, of the samples of other cameras that show the same surface point and may be its witness:
//!     the best of those that are better and kept ─▶ LowerRate, Tie, LaterCamera, MixedYields, UnsureYields
//!     none, and more cameras look past it than confirm it ─▶ Contradicted
//!     none ─▶ Coverage, BestRate, OnlyWitness
//! ```
//!
//! [`decide`] states the whole decision on one sample. The search over pictures and the replay of candidate lists reach it
//! for many samples at once and in stages; all three are made of the predicates below, and a test compares their verdicts.
//! Whether two samples show the same surface point is decided in [`crate::preprocess::registration`].

use crate::preprocess::layers::{CameraLayer, has_unknown_normal, is_blended_sky, is_mixed};
use crate::preprocess::temporal::{NO_SAMPLE, SpanLevel};
use crate::samples::{PixelVerdict, Span, SpanVerdicts};
use crate::settings::{MixedPixels, PruningMethod, PruningSettings};

/// Why a sample was kept or dropped. A *candidate* is a sample of another camera that shows the same surface point, may be a
/// witness and is better; the *witness* is the best candidate that is kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[repr(u8)]
pub enum Rule {
    /// Not a sample: the pixel has no depth.
    NoSample,
    /// Kept: no other camera has a sample of the point that may be a witness.
    OnlyWitness,
    /// Kept: others have, but none of them is better.
    BestRate,
    /// Kept: a better sample of the point exists, but it was dropped itself or may not be a witness.
    Coverage,
    /// Kept: pruning is off.
    PruningOff,
    /// Dropped: the witness samples the point at a higher rate.
    LowerRate,
    /// Dropped: the rates are equal, and the witness belongs to an earlier camera.
    Tie,
    /// Dropped: the first camera wins, and the witness belongs to an earlier one.
    LaterCamera,
    /// Dropped: it is a mixed pixel, whose color is blended across a silhouette or whose depth is of neither side, and the witness
    /// is not.
    MixedYields,
    /// Dropped: the normal is unknown, so that the rate is a guess, and the witness's is known.
    UnsureYields,
    /// Dropped: it is a mixed pixel of the sky, or of anything where the settings drop all of them. There is no witness.
    MixedDropped,
    /// Dropped: more cameras look past the point than confirm it; its own confirms it, but looks past it if the sample flies. There is
    /// no witness.
    Contradicted,
}

/// Whether a sample of `rank` and `camera` is better than another: the smaller rank wins, of equals the earlier camera.
#[inline(always)]
pub(crate) fn is_better(rank: u32, camera: u32, other_rank: u32, other_camera: u32) -> bool {
    (rank < other_rank) | ((rank == other_rank) & (camera < other_camera))
}

/// Whether a sample may be the witness of others: one of the level that is decided and not dropped beforehand, or, where the
/// settings allow it, a kept one of a longer span.
#[inline(always)]
pub(crate) fn may_be_witness(is_own_level: bool, is_kept: bool, across_spans: bool) -> bool {
    is_own_level | (is_kept & across_spans)
}

/// Whether a sample is dropped before anything is compared, because it is a mixed pixel.
#[inline(always)]
pub(crate) fn is_dropped_as_mixed(mixed_pixels: MixedPixels, rank: u32) -> bool {
    match mixed_pixels {
        MixedPixels::Drop => is_mixed(rank),
        // No surface is lost with it: the sky is continued over it from all around, without the color of what is before it.
        MixedPixels::Yield => is_blended_sky(rank),
        MixedPixels::Keep => false,
    }
}

/// By which rule a sample of `rank` is dropped for a witness of `witness_rank`, which is better.
#[inline(always)]
pub(crate) fn rule_of_dropped(method: PruningMethod, rank: u32, witness_rank: u32) -> Rule {
    if method == PruningMethod::FirstCamera {
        Rule::LaterCamera
    } else if is_mixed(rank) && !is_mixed(witness_rank) {
        Rule::MixedYields
    } else if has_unknown_normal(rank) && !has_unknown_normal(witness_rank) {
        Rule::UnsureYields
    } else if witness_rank == rank {
        Rule::Tie
    } else {
        Rule::LowerRate
    }
}

/// By which rule a sample without a witness is kept: whether any sample of its point is better, and whether any may be a
/// witness.
#[inline(always)]
pub(crate) fn rule_of_kept(has_better: bool, is_seen: bool) -> Rule {
    match (has_better, is_seen) {
        (true, _) => Rule::Coverage,
        (false, true) => Rule::BestRate,
        (false, false) => Rule::OnlyWitness,
    }
}

/// A sample that may win against another, in the order in which samples win.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Candidate {
    pub(crate) rank: u32,
    pub(crate) camera: u16,
    pub(crate) pixel: u32,
    pub(crate) level: SpanLevel,
}

impl Candidate {
    /// The sample of `camera` at `pixel` of its layer.
    pub(crate) fn new(layer: &CameraLayer, camera: usize, pixel: u32) -> Self {
        let index = pixel as usize;
        Self { rank: layer.ranks[index], camera: camera as u16, pixel, level: layer.level[index] }
    }

    /// See [`is_better`].
    pub(crate) fn is_better_than(&self, other: &Self) -> bool {
        is_better(self.rank, u32::from(self.camera), other.rank, u32::from(other.camera))
    }
}

/// The verdict on `sample`, given every sample of another camera that shows its surface point, and for each whether it is
/// kept; and whether the other cameras contradict it.
pub(crate) fn decide(
    sample: &Candidate,
    others: &[(Candidate, bool)],
    is_contradicted: bool,
    settings: &PruningSettings,
) -> Verdict {
    if sample.level == NO_SAMPLE {
        return Verdict::without_witness(Rule::NoSample);
    }
    if is_dropped_as_mixed(settings.mixed_pixels, sample.rank) {
        return Verdict::without_witness(Rule::MixedDropped);
    }
    if settings.method == PruningMethod::Off {
        return Verdict::without_witness(Rule::PruningOff);
    }
    let may_be_witness = |(other, is_kept): &&(Candidate, bool)| {
        let dropped_before = is_dropped_as_mixed(settings.mixed_pixels, other.rank);
        let is_own_level = other.level == sample.level && !dropped_before;
        may_be_witness(is_own_level, *is_kept, settings.across_spans)
    };
    let better = || others.iter().filter(|(other, _)| other.is_better_than(sample));
    let kept = better().filter(may_be_witness).filter(|(_, is_kept)| *is_kept);
    if let Some((witness, _)) = kept.min_by_key(|(other, _)| *other) {
        return Verdict::dropped_for(settings.method, sample.rank, *witness);
    }
    if is_contradicted {
        return Verdict::without_witness(Rule::Contradicted);
    }
    let is_seen = others.iter().any(|other| may_be_witness(&other));
    Verdict::without_witness(rule_of_kept(better().next().is_some(), is_seen))
}

impl Rule {
    /// Every rule.
    pub const ALL: [Self; 12] = [
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
        Self::Contradicted,
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
            Self::Contradicted => "contradicted",
        }
    }

    /// The rule as a sentence for people.
    #[must_use]
    pub fn sentence(self) -> &'static str {
        match self {
            Self::NoSample => "No sample: the pixel has no depth.",
            Self::OnlyWitness => "Kept: no other camera has a sample of this point throughout its span.",
            Self::BestRate => {
                "Kept: of all reliable samples of this point, it has the highest sampling rate."
            }
            Self::Coverage => {
                "Kept: the better sample cannot replace it. That one was dropped for a sample that does not show this point, or it lives in a longer span and is not compared."
            }
            Self::PruningOff => "Kept: pruning is off.",
            Self::LowerRate => "Dropped: the witness samples this point more densely.",
            Self::Tie => "Dropped: equal rates, and the witness belongs to an earlier camera.",
            Self::LaterCamera => "Dropped: an earlier camera shows this point.",
            Self::MixedYields => {
                "Dropped: its color or depth is blended across a depth edge, and the witness is clean."
            }
            Self::UnsureYields => "Dropped: its normal is not known, and the witness's is.",
            Self::MixedDropped => "Dropped: its color or depth is blended across a depth edge.",
            Self::Contradicted => "Dropped: more cameras contradict this point than confirm it.",
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
    /// Level of the witness, see [`FrameInspection::path`](crate::preprocess::inspect::FrameInspection::path); [`NO_SAMPLE`] without a witness.
    pub witness_level: SpanLevel,
    /// Camera of the witness; [`Verdict::NO_CAMERA`] without a witness.
    pub witness_camera: u16,
    /// Pixel of the witness, `y * width + x`; 0 without a witness, and [`Verdict::NO_PIXEL`] where nobody knows.
    pub witness_pixel: u32,
}

impl Verdict {
    /// In place of a witness's camera where there is no witness.
    pub const NO_CAMERA: u16 = PixelVerdict::NO_WITNESS;
    /// In place of a witness's pixel where only its camera is known, as of a store.
    pub const NO_PIXEL: u32 = u32::MAX;

    /// A verdict without a witness.
    #[must_use]
    pub fn without_witness(rule: Rule) -> Self {
        Self { rule, witness_level: NO_SAMPLE, witness_camera: Self::NO_CAMERA, witness_pixel: 0 }
    }

    /// The verdict on a sample of `rank` if `witness` is kept.
    #[inline(always)]
    pub(crate) fn dropped_for(method: PruningMethod, rank: u32, witness: Candidate) -> Self {
        Self {
            rule: rule_of_dropped(method, rank, witness.rank),
            witness_level: witness.level,
            witness_camera: witness.camera,
            witness_pixel: witness.pixel,
        }
    }

    /// What a store says of a pixel; its witness is known by camera alone. `None` for a rule that this Overlook does not know.
    #[must_use]
    pub fn of_store(stored: PixelVerdict) -> Option<Self> {
        let rule = *Rule::ALL.get(usize::from(stored.rule))?;
        let is_witnessed = stored.witness != PixelVerdict::NO_WITNESS;
        let witness_pixel = if is_witnessed { Self::NO_PIXEL } else { 0 };
        Some(Self { witness_camera: stored.witness, witness_pixel, ..Self::without_witness(rule) })
    }

    /// As a number, to be put away.
    pub(crate) fn to_bits(self) -> u64 {
        let Self { rule, witness_level, witness_camera, witness_pixel } = self;
        rule as u64
            | u64::from(witness_level) << 8
            | u64::from(witness_camera) << 16
            | u64::from(witness_pixel) << 32
    }

    /// Back from [`Verdict::to_bits`].
    pub(crate) fn from_bits(bits: u64) -> Self {
        Self {
            rule: Rule::ALL[(bits & 0xff) as usize],
            witness_level: (bits >> 8) as SpanLevel,
            witness_camera: (bits >> 16) as u16,
            witness_pixel: (bits >> 32) as u32,
        }
    }

    /// Whether the sample stays.
    #[must_use]
    pub fn is_kept(self) -> bool {
        self.rule.keeps()
    }
}

/// The verdicts on one camera's samples of one level.
#[derive(Clone, Debug, Default)]
pub(crate) struct LevelVerdicts {
    /// Pixels that were decided, `y * width + x`, ascending.
    pub(crate) pixels: Vec<u32>,
    /// One verdict per pixel.
    pub(crate) verdicts: Vec<Verdict>,
    /// Mixed pixels that were found.
    pub(crate) mixed: u64,
    /// How many of them are kept.
    pub(crate) mixed_kept: u64,
}

impl LevelVerdicts {
    /// As a store has them, for a camera and span.
    pub(crate) fn stored(&self, camera: usize, span: Span) -> SpanVerdicts {
        SpanVerdicts {
            camera: camera as u32,
            span,
            pixels: self.pixels.clone(),
            rules: self.verdicts.iter().map(|verdict| verdict.rule as u8).collect(),
            witnesses: self.verdicts.iter().map(|verdict| verdict.witness_camera).collect(),
        }
    }

    /// Counts the mixed pixels by the ranks of the samples, where the settings tell them from others.
    pub(crate) fn count_mixed(&mut self, ranks: &[u32], mixed_pixels: MixedPixels) {
        if mixed_pixels == MixedPixels::Keep {
            return;
        }
        for (rank, verdict) in ranks.iter().zip(&self.verdicts) {
            let is_mixed = is_mixed(*rank);
            self.mixed += u64::from(is_mixed);
            self.mixed_kept += u64::from(is_mixed & verdict.is_kept());
        }
    }
}
