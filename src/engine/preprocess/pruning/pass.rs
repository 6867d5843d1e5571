//! One pruning pass: the samples that are decided together, and their statuses meanwhile.

use std::sync::atomic::{AtomicU8, Ordering};

use rayon::prelude::*;

use super::decision::{is_dropped_as_mixed, may_be_witness};
use crate::capture::overlap::OverlapGraph;
use crate::preprocess::agreement::VoteTest;
use crate::preprocess::layers::{CameraLayer, RatedSamples};
use crate::preprocess::registration::SameSurface;
use crate::preprocess::temporal::{NO_SAMPLE, ROOT, SpanLevel};
use crate::settings::{MixedPixels, Settings};

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

/// Statuses in which nothing is decided yet, of pictures with this many pixels.
#[must_use]
pub(crate) fn no_statuses(pixel_counts: impl Iterator<Item = usize>) -> Statuses {
    pixel_counts.map(|count| (0..count).map(|_| AtomicU8::new(ABSENT)).collect()).collect()
}

/// Marks samples as undecided, mixed ones as dropped where they are to be.
pub(crate) fn mark_undecided(samples: &RatedSamples, statuses: &[AtomicU8], mixed_pixels: MixedPixels) {
    for (&pixel, &rank) in samples.pixels.iter().zip(&samples.ranks) {
        let is_dropped = is_dropped_as_mixed(mixed_pixels, rank);
        statuses[pixel as usize].store(if is_dropped { DROPPED } else { UNDECIDED }, Ordering::Relaxed);
    }
}

/// If fewer than one pixel in this many is to be decided, testing whether all samples may be witnesses does not pay.
const DENSE_SHARE: usize = 8;

/// What all bands share while the samples of one level are decided.
pub(crate) struct PruningPass<'a> {
    pub(crate) pairs: &'a OverlapGraph<'a>,
    /// Those that are not there are without samples, and take part in nothing.
    pub(crate) layers: &'a [CameraLayer],
    pub(crate) statuses: &'a Statuses,
    /// The level that is decided.
    pub(crate) level: SpanLevel,
    pub(crate) settings: &'a Settings,
    pub(crate) limits: SameSurface,
    /// Whether other cameras contradict a sample.
    pub(crate) votes: VoteTest,
    /// Per camera, whether every sample that counts may be a witness, so that single statuses need no look.
    pub(crate) all_may_be_witnesses: &'a [bool],
    /// Whether layers may hold samples of deeper levels than the one that is decided.
    pub(crate) has_deeper: bool,
}

impl<'a> PruningPass<'a> {
    /// A pass over one level, with the layers of all cameras and no deeper levels.
    pub(crate) fn new(
        pairs: &'a OverlapGraph<'a>,
        layers: &'a [CameraLayer],
        statuses: &'a Statuses,
        level: SpanLevel,
        all_may_be_witnesses: &'a [bool],
        settings: &'a Settings,
    ) -> Self {
        Self {
            pairs,
            layers,
            statuses,
            level,
            settings,
            limits: SameSurface::new(settings).at_level(level),
            votes: VoteTest::new(settings, level),
            all_may_be_witnesses,
            has_deeper: false,
        }
    }

    pub(crate) fn status(&self, camera: usize, pixel: u32) -> u8 {
        self.statuses[camera][pixel as usize].load(Ordering::Relaxed)
    }

    pub(crate) fn set_status(&self, camera: usize, pixel: u32, status: u8) {
        self.statuses[camera][pixel as usize].store(status, Ordering::Relaxed);
    }

    /// See [`may_be_witness`], as far as is known before anything of this level is decided.
    #[inline(always)]
    pub(crate) fn may_be_witness(&self, camera: usize, pixel: u32) -> bool {
        let status = self.status(camera, pixel);
        let is_own_level = self.layers[camera].level[pixel as usize] == self.level;
        let across_spans = self.settings.pruning.across_spans;
        may_be_witness(is_own_level & (status != DROPPED), status == KEPT, across_spans)
    }
}

/// Per camera, whether every sample of `level` and of the levels above may be a witness, once the samples of the level are marked;
/// `false` where there are so few `samples` to decide that it does not matter.
pub(crate) fn all_may_be_witnesses(
    statuses: &Statuses,
    level: SpanLevel,
    samples: usize,
    settings: &Settings,
) -> Vec<bool> {
    let pixels: usize = statuses.iter().map(Vec::len).sum();
    let is_asked = samples > pixels / DENSE_SHARE && (settings.pruning.across_spans || level == ROOT);
    let is_none_dropped =
        |statuses: &Vec<AtomicU8>| statuses.iter().all(|status| status.load(Ordering::Relaxed) != DROPPED);
    statuses.par_iter().map(|statuses| is_asked && is_none_dropped(statuses)).collect()
}

/// Whether any layer holds samples of deeper levels than `level`.
pub(crate) fn has_deeper(layers: &[CameraLayer], level: SpanLevel) -> bool {
    layers.par_iter().any(|layer| layer.level.iter().any(|found| *found > level && *found != NO_SAMPLE))
}
