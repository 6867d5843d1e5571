//! The coverage guarantee: a sample is dropped once a candidate is known to be kept; and kept once all are known to be dropped,
//! unless more cameras look past it than confirm it.

use super::decision::{Candidate, Rule, Verdict, may_be_witness};
use super::pass::{DROPPED, KEPT, PendingSample, PruningPass, SearchBand, UNDECIDED};
use crate::preprocess::registration::Outcome;
use crate::simd::{self, VectorLoop};

/// How many samples ahead the statuses of witnesses are prefetched.
const AHEAD: usize = 24;

/// Decides every sample of the band whose best candidate is decided; the others become pending.
pub(crate) fn resolve(pass: &PruningPass<'_>, band: &mut SearchBand<'_>) {
    for index in 0..band.pixels.len() {
        if let Some(ahead) = band.verdicts.get(index + AHEAD) {
            let statuses = pass.statuses.get(ahead.witness_camera as usize);
            simd::prefetch(statuses.map_or(&[], Vec::as_slice), ahead.witness_pixel as usize);
        }
        let verdict = band.verdicts[index];
        if verdict.witness_camera == Verdict::NO_CAMERA {
            if verdict.rule == Rule::Contradicted {
                pass.set_status(band.camera, band.pixels[index], DROPPED);
            }
            continue;
        }
        if pass.status(verdict.witness_camera as usize, verdict.witness_pixel) == KEPT {
            pass.set_status(band.camera, band.pixels[index], DROPPED);
        } else {
            band.pending.push(PendingSample { index: index as u32, others: None });
        }
    }
}

#[inline(always)]
fn is_still_pending(pass: &PruningPass<'_>, band: &mut SearchBand<'_>, sample: &mut PendingSample) -> bool {
    let pixel = band.pixels[sample.index as usize];
    let verdict = &mut band.verdicts[sample.index as usize];
    loop {
        match pass.status(verdict.witness_camera as usize, verdict.witness_pixel) {
            KEPT => {
                pass.set_status(band.camera, pixel, DROPPED);
                return false;
            }
            UNDECIDED => return true,
            _ => {}
        }
        let others = sample.others.get_or_insert_with(|| all_but_the_best(pass, band.camera, pixel));
        let Some(next) = others.pop() else {
            if pass.votes.contradicts(pass.pairs, pass.layers, band.camera, pixel) {
                *verdict = Verdict::without_witness(Rule::Contradicted);
                pass.set_status(band.camera, pixel, DROPPED);
                return false;
            }
            *verdict = Verdict::without_witness(Rule::Coverage);
            pass.set_status(band.camera, pixel, KEPT);
            return false;
        };
        let rank = pass.layers[band.camera].ranks[pixel as usize].rank;
        *verdict = Verdict::dropped_for(pass.settings.pruning.method, rank, next);
    }
}

/// All candidates of a sample but the best, worst first.
#[inline(always)]
fn all_but_the_best(pass: &PruningPass<'_>, camera: usize, pixel: u32) -> Vec<Candidate> {
    let layer = &pass.layers[camera];
    let (x, y) = (pixel as usize % layer.width, pixel as usize / layer.width);
    let sample = Candidate::new(layer, camera, pixel);
    let mut candidates = Vec::new();
    for other in (0..pass.layers.len()).filter(|other| *other != camera) {
        let target = &pass.layers[other];
        if target.geometry.is_empty() {
            continue;
        }
        let registration = pass.pairs.registration(camera, other);
        let Outcome::Same(found) = pass.limits.test(registration, (layer, x, y), target) else { continue };
        let candidate = Candidate::new(target, other, found);
        // Samples of this level that are dropped by now are candidates still; they will be passed over.
        let (is_own_level, is_kept) = (candidate.level == pass.level, pass.status(other, found) == KEPT);
        if may_be_witness(is_own_level, is_kept, pass.settings.pruning.across_spans)
            && candidate.is_better_than(&sample)
        {
            candidates.push(candidate);
        }
    }
    candidates.sort_unstable_by(|a, b| b.cmp(a));
    candidates.pop();
    candidates
}

/// Decides what can be decided of the pending samples of a band.
pub(crate) struct ResolvePending<'a, 'b> {
    pub(crate) pass: &'a PruningPass<'a>,
    pub(crate) band: &'a mut SearchBand<'b>,
}

impl VectorLoop for ResolvePending<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let mut pending = std::mem::take(&mut self.band.pending);
        pending.retain_mut(|sample| is_still_pending(self.pass, self.band, sample));
        self.band.pending = pending;
    }
}
