//! One pruning pass: the samples that are decided together, and their statuses meanwhile.

use std::ops::Range;
use std::sync::atomic::{AtomicU8, Ordering};

use super::decision::{Candidate, Verdict, is_dropped_as_mixed, may_be_witness};
use crate::preprocess::agreement::VoteTest;
use crate::preprocess::layers::CameraLayer;
use crate::preprocess::registration::{CameraPairs, SameSurface};
use crate::preprocess::temporal::SpanLevel;
use crate::settings::Settings;

/// No sample at the pixel that could be a witness.
pub(crate) const ABSENT: u8 = 0;
/// Waiting for better samples to be decided.
pub(crate) const UNDECIDED: u8 = 1;
/// Stays.
pub(crate) const KEPT: u8 = 2;
/// Was dropped.
pub(crate) const DROPPED: u8 = 3;

/// Whether each pixel of each camera holds a kept sample: [`ABSENT`], [`KEPT`] or [`DROPPED`].
pub(crate) type Statuses = Vec<Vec<AtomicU8>>;

/// Statuses in which nothing is decided yet.
#[must_use]
pub fn no_statuses(layers: &[CameraLayer]) -> Statuses {
    layers.iter().map(|layer| layer.level.iter().map(|_| AtomicU8::new(ABSENT)).collect()).collect()
}

/// Rows that one task works on.
pub(crate) const BAND_ROWS: usize = 16;

/// What all bands share while the samples of one level are decided.
pub(crate) struct PruningPass<'a> {
    pub(crate) pairs: &'a CameraPairs<'a>,
    pub(crate) layers: &'a [CameraLayer],
    pub(crate) statuses: &'a Statuses,
    /// The level that is decided.
    pub(crate) level: SpanLevel,
    pub(crate) settings: &'a Settings,
    pub(crate) limits: SameSurface,
    /// Whether other cameras contradict a sample.
    pub(crate) votes: VoteTest,
    /// Per camera, whether every sample that counts may be a witness, so that single statuses need no look.
    pub(crate) all_may_be_witnesses: Vec<bool>,
    /// Per camera, whether it holds samples of deeper levels than the one that is decided.
    pub(crate) has_deeper: Vec<bool>,
    /// Whether there are no samples of other levels: which samples may be witnesses is then known without a look at what is decided.
    pub(crate) is_only_level: bool,
}

/// Some rows of one camera: the samples to decide, and the verdict on each so far. Until it is resolved, a verdict names the
/// sample's best candidate as if that one were kept.
pub(crate) struct SearchBand<'a> {
    pub(crate) camera: usize,
    pub(crate) rows: Range<usize>,
    pub(crate) pixels: &'a mut [u32],
    pub(crate) verdicts: &'a mut [Verdict],
    pub(crate) pending: Vec<PendingSample>,
}

/// A sample whose candidate is undecided yet.
pub(crate) struct PendingSample {
    /// Index into the band's pixels.
    pub(crate) index: u32,
    /// Its rank.
    pub(crate) rank: u32,
    /// All candidates but the best, worst first; found only where the best was dropped. The verdict names the one that is
    /// waited for.
    pub(crate) others: Option<Vec<Candidate>>,
    /// Whether other cameras contradict it, if that was found out before it mattered.
    pub(crate) is_contradicted: Option<bool>,
}

impl PruningPass<'_> {
    pub(crate) fn status(&self, camera: usize, pixel: u32) -> u8 {
        self.statuses[camera][pixel as usize].load(Ordering::Relaxed)
    }

    pub(crate) fn set_status(&self, camera: usize, pixel: u32, status: u8) {
        self.statuses[camera][pixel as usize].store(status, Ordering::Relaxed);
    }

    /// See [`may_be_witness`], as far as is known before anything of this level is decided.
    #[inline(always)]
    pub(crate) fn may_be_witness(&self, camera: usize, pixel: u32) -> bool {
        if self.is_only_level {
            let rank = self.layers[camera].ranks[pixel as usize];
            return !is_dropped_as_mixed(self.settings.pruning.mixed_pixels, rank);
        }
        let status = self.status(camera, pixel);
        let is_own_level = self.layers[camera].level[pixel as usize] == self.level;
        let across_spans = self.settings.pruning.across_spans;
        may_be_witness(is_own_level & (status != DROPPED), status == KEPT, across_spans)
    }
}
