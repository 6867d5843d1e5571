//! One pass of pruning: what is decided together, and what is known of it meanwhile.

use std::ops::Range;
use std::sync::atomic::Ordering;

use super::decision::{Dispute, Rule, Verdict};
use super::status::{KEPT, Statuses, UNDECIDED};
use crate::preprocess::layers::{CameraLayer, MIXED, UNSURE};
use crate::preprocess::registration::{CameraPairs, SameSurface};
use crate::preprocess::temporal::SpanLevel;
use crate::settings::{PruningMethod, Settings};

/// Rows that one task works on.
pub(crate) const BAND_ROWS: usize = 16;

/// What all bands share.
pub(crate) struct Pass<'a> {
    pub(crate) rig: &'a CameraPairs<'a>,
    pub(crate) layers: &'a [CameraLayer],
    pub(crate) statuses: &'a Statuses,
    pub(crate) decide: SpanLevel,
    pub(crate) settings: &'a Settings,
    pub(crate) limits: SameSurface,
    /// Per camera, whether every sample may stand for others, so that nobody needs to ask.
    pub(crate) all_stand: Vec<bool>,
    /// Per camera, whether it holds samples of deeper levels than the one that is decided.
    pub(crate) has_deeper: Vec<bool>,
}

/// Some rows of one camera: the samples to decide and what is known of each. Until it is settled, a verdict names the
/// sample's best candidate as if that one were kept.
pub(crate) struct SearchBand<'a> {
    pub(crate) camera: usize,
    pub(crate) rows: Range<usize>,
    pub(crate) pixels: &'a mut [u32],
    pub(crate) verdicts: &'a mut [Verdict],
    pub(crate) disputes: Vec<Dispute>,
    pub(crate) waiting: Vec<Waiting>,
}

/// A sample whose candidate is undecided yet.
pub(crate) struct Waiting {
    /// Index into the band's pixels.
    pub(crate) index: u32,
    /// All candidates, worst first; found only where the best was dropped. The verdict names the one that is waited for.
    pub(crate) others: Option<Vec<Candidate>>,
}

/// A better sample of a point, in the order in which they win.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Candidate {
    pub(crate) rank: u32,
    pub(crate) camera: u16,
    pub(crate) pixel: u32,
    pub(crate) level: SpanLevel,
}

impl Pass<'_> {
    pub(crate) fn status(&self, camera: usize, pixel: u32) -> u8 {
        self.statuses[camera][pixel as usize].load(Ordering::Relaxed)
    }

    pub(crate) fn set_status(&self, camera: usize, pixel: u32, status: u8) {
        self.statuses[camera][pixel as usize].store(status, Ordering::Relaxed);
    }

    /// Whether a sample may stand for others, as far as is known before anything of this level is decided.
    #[inline(always)]
    pub(crate) fn may_stand(&self, camera: usize, pixel: u32) -> bool {
        let status = self.status(camera, pixel);
        let foreign = self.layers[camera].level[pixel as usize] != self.decide;
        (status == UNDECIDED || status == KEPT) && (self.settings.pruning.across_spans || !foreign)
    }

    #[inline(always)]
    pub(crate) fn dropped_for(&self, rank: u32, witness: Candidate) -> Verdict {
        Verdict {
            rule: rule_between(self.settings.pruning.method, rank, witness.rank),
            witness_level: witness.level,
            witness_camera: witness.camera,
            witness_pixel: witness.pixel,
        }
    }
}

/// By which rule a sample of `rank` is dropped for one of `witness_rank`.
#[inline(always)]
pub(crate) fn rule_between(method: PruningMethod, rank: u32, witness_rank: u32) -> Rule {
    if method == PruningMethod::FirstCamera {
        Rule::LaterCamera
    } else if rank & MIXED != 0 && witness_rank & MIXED == 0 {
        Rule::MixedYields
    } else if rank & UNSURE != 0 && witness_rank & UNSURE == 0 {
        Rule::UnsureYields
    } else if witness_rank == rank {
        Rule::Tie
    } else {
        Rule::LowerRate
    }
}
