//! Pruning a frame from its candidate lists: what [`crate::preprocess::pruning`] decides, without searching.

use std::sync::atomic::{AtomicU8, Ordering};

use rayon::prelude::*;

use super::candidate_lists::{
    BandCandidates, COUNT, CandidateLists, CandidateValidity, Codes, IS_MIXED, ListedCandidate, codes,
    tolerances,
};
use crate::capture::overlap::OverlapGraph;
use crate::error::Result;
use crate::job::Job;
use crate::preprocess::agreement::VoteTest;
use crate::preprocess::layers::CameraLayer;
use crate::preprocess::pruning::{
    BAND_ROWS, DROPPED, KEPT, Rule, Statuses, UNDECIDED, Verdict, is_dropped_as_mixed, may_be_witness,
    rule_of_kept,
};
use crate::preprocess::registration::{Outcome, SameSurface};
use crate::preprocess::temporal::SpanLevel;
use crate::settings::Settings;
use crate::simd::LANES;

/// The layers of a frame, and what can be listed of them before the settings are known.
#[derive(Clone, Copy)]
pub(crate) struct FrameLists<'a> {
    pub(crate) lists: &'a CandidateLists,
    pub(crate) pairs: &'a OverlapGraph<'a>,
    /// One per camera.
    pub(crate) layers: &'a [CameraLayer],
}

/// Decides every sample of `level` of a frame whose lists serve the settings. `verdicts` has one for each pixel of
/// each camera; those of other levels stay as they are.
pub(crate) fn prune(
    frame: FrameLists<'_>,
    statuses: &Statuses,
    level: SpanLevel,
    settings: &Settings,
    verdicts: &mut [Vec<Verdict>],
    job: &Job,
) -> Result<()> {
    let FrameLists { lists, pairs, layers } = frame;
    let limits = SameSurface::new(settings).at_level(level);
    let codes = codes(tolerances(&settings.pruning));
    let votes = VoteTest::new(settings, level);
    let context = ReplayContext { lists, pairs, layers, statuses, level, settings, limits, votes, codes };
    let mut bands: Vec<ReplayBand<'_>> = Vec::new();
    for (camera, (layer, verdicts)) in layers.iter().zip(verdicts).enumerate() {
        let size = (BAND_ROWS * layer.width).max(1);
        bands.extend(verdicts.chunks_mut(size).enumerate().map(|(index, verdicts)| ReplayBand {
            camera,
            index,
            first: index * size,
            verdicts,
            pending: Vec::new(),
        }));
    }
    bands.par_iter_mut().try_for_each(|band| {
        job.check()?;
        context.find_best(band);
        Ok(())
    })?;
    bands.retain(|band| !band.pending.is_empty());
    while bands.iter().any(|band| !band.pending.is_empty()) {
        job.check()?;
        bands.par_iter_mut().for_each(|band| context.resolve(band));
    }
    Ok(())
}

/// What all bands share.
struct ReplayContext<'a> {
    lists: &'a CandidateLists,
    pairs: &'a OverlapGraph<'a>,
    layers: &'a [CameraLayer],
    statuses: &'a Statuses,
    level: SpanLevel,
    settings: &'a Settings,
    limits: SameSurface,
    votes: VoteTest,
    codes: Codes,
}

/// Some rows of one camera. Until a sample is resolved, its verdict names its best candidate as if that one were kept.
struct ReplayBand<'a> {
    camera: usize,
    index: usize,
    /// Its first pixel.
    first: usize,
    /// Verdicts on all its pixels.
    verdicts: &'a mut [Verdict],
    /// Indices of samples whose candidate may be dropped itself.
    pending: Vec<u32>,
}

impl ReplayContext<'_> {
    fn lists(&self, band: &ReplayBand<'_>) -> &BandCandidates {
        &self.lists.bands[band.camera][band.index]
    }

    fn status(&self, candidate: Verdict) -> u8 {
        self.statuses[usize::from(candidate.witness_camera)][candidate.witness_pixel as usize]
            .load(Ordering::Relaxed)
    }

    /// The best candidate of every sample of a band; decides samples without one, or whose candidate is surely kept.
    fn find_best(&self, band: &mut ReplayBand<'_>) {
        let layer = &self.layers[band.camera];
        let (lists, columns) = (self.lists(band), layer.width.div_ceil(LANES));
        let levels = &layer.level[band.first..band.first + band.verdicts.len()];
        let statuses = &self.statuses[band.camera][band.first..band.first + band.verdicts.len()];
        for (block, &first) in lists.first.iter().enumerate() {
            let left = block % columns * LANES;
            let start = block / columns * layer.width + left;
            let indices = start..start + LANES.min(layer.width - left);
            if levels[indices.clone()].contains(&self.level) {
                self.find_in_block(band, first as usize, indices, levels, statuses);
            }
        }
    }

    #[inline(always)]
    fn find_in_block(
        &self,
        band: &mut ReplayBand<'_>,
        mut first: usize,
        indices: std::ops::Range<usize>,
        levels: &[SpanLevel],
        statuses: &[AtomicU8],
    ) {
        let lists = self.lists(band);
        for index in indices {
            let count = lists.counts[index];
            let candidates = &lists.candidates[first..first + usize::from(count & COUNT)];
            first += candidates.len();
            if levels[index] != self.level {
                continue;
            }
            let (verdict, status) = self.first_verdict(band, index, count, candidates);
            band.verdicts[index] = verdict;
            statuses[index].store(status, Ordering::Relaxed);
        }
    }

    /// The verdict on a sample if its best candidate is kept, and its status as far as that is known.
    #[inline(always)]
    fn first_verdict(
        &self,
        band: &mut ReplayBand<'_>,
        index: usize,
        count: u16,
        candidates: &[ListedCandidate],
    ) -> (Verdict, u8) {
        let mixed_pixels = self.settings.pruning.mixed_pixels;
        let rank = || self.layers[band.camera].ranks[band.first + index];
        if count & IS_MIXED != 0 && is_dropped_as_mixed(mixed_pixels, rank()) {
            return (Verdict::without_witness(Rule::MixedDropped), DROPPED);
        }
        let best = candidates.iter().find(|candidate| self.may_be_witness(band, index, candidate));
        let better = best.filter(|best| best.is_better());
        if let Some(better) = better {
            // Samples of longer spans are candidates only where they are kept already.
            if better.is_sure || better.verdict.witness_level != self.level {
                return (better.verdict, DROPPED);
            }
            band.pending.push(index as u32);
            return (better.verdict, UNDECIDED);
        }
        let pixel = (band.first + index) as u32;
        if self.votes.contradicts(self.pairs, self.layers, band.camera, pixel) {
            return (Verdict::without_witness(Rule::Contradicted), DROPPED);
        }
        let mut ahead = candidates.iter().take_while(|candidate| candidate.is_better());
        let has_better = ahead.any(|candidate| self.shows(band, index, candidate));
        let rule = rule_of_kept(has_better, best.is_some());
        (Verdict::without_witness(rule), KEPT)
    }

    /// Whether a candidate shows the sample's point and may be its witness.
    #[inline(always)]
    fn may_be_witness(&self, band: &ReplayBand<'_>, index: usize, candidate: &ListedCandidate) -> bool {
        let own_level = candidate.verdict.witness_level == self.level;
        let is_kept = || self.status(candidate.verdict) == KEPT;
        self.shows(band, index, candidate)
            && may_be_witness(own_level, !own_level && is_kept(), self.settings.pruning.across_spans)
    }

    /// Whether a candidate shows the sample's point.
    #[inline(always)]
    fn shows(&self, band: &ReplayBand<'_>, index: usize, candidate: &ListedCandidate) -> bool {
        match candidate.validity(self.codes) {
            CandidateValidity::Valid => true,
            CandidateValidity::Invalid => false,
            CandidateValidity::NearLimit => self.test_exactly(band, index, candidate),
        }
    }

    #[cold]
    #[inline(never)]
    fn test_exactly(&self, band: &ReplayBand<'_>, index: usize, candidate: &ListedCandidate) -> bool {
        let (layer, other) = (&self.layers[band.camera], usize::from(candidate.verdict.witness_camera));
        let pixel = band.first + index;
        let (x, y) = (pixel % layer.width, pixel / layer.width);
        let registration = self.pairs.registration(band.camera, other);
        let outcome = self.limits.test(registration, layer, x, y, &self.layers[other]);
        outcome == Outcome::Same(candidate.verdict.witness_pixel)
    }

    /// Decides the pending samples of a band whose candidate is decided; the others stay pending.
    fn resolve(&self, band: &mut ReplayBand<'_>) {
        let mut pending = std::mem::take(&mut band.pending);
        pending.retain(|&index| self.is_still_pending(band, index as usize));
        band.pending = pending;
    }

    fn is_still_pending(&self, band: &mut ReplayBand<'_>, index: usize) -> bool {
        let own = &self.statuses[band.camera][band.first + index];
        loop {
            match self.status(band.verdicts[index]) {
                KEPT => {
                    own.store(DROPPED, Ordering::Relaxed);
                    return false;
                }
                UNDECIDED => return true,
                _ => {}
            }
            let dropped = band.verdicts[index].witness_camera;
            let candidates = self.lists(band).of(index, self.layers[band.camera].width).iter();
            let after =
                candidates.skip_while(|candidate| candidate.verdict.witness_camera != dropped).skip(1);
            let next = after
                .take_while(|candidate| candidate.is_better())
                .find(|candidate| self.may_be_witness(band, index, candidate))
                .map(|candidate| candidate.verdict);
            if let Some(next) = next {
                band.verdicts[index] = next;
                continue;
            }
            let pixel = (band.first + index) as u32;
            let is_contradicted = self.votes.contradicts(self.pairs, self.layers, band.camera, pixel);
            let (rule, status) =
                if is_contradicted { (Rule::Contradicted, DROPPED) } else { (Rule::Coverage, KEPT) };
            band.verdicts[index] = Verdict::without_witness(rule);
            own.store(status, Ordering::Relaxed);
            return false;
        }
    }
}
