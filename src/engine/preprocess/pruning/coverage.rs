//! The coverage guarantee: a sample is dropped once a candidate is known to be kept; and kept once all are known to be dropped,
//! unless more cameras look past it than confirm it.

use rayon::prelude::*;

use super::decision::{Candidate, LevelVerdicts, Rule, Verdict, may_be_witness};
use super::pass::{DROPPED, KEPT, PendingSample, PruningPass, SearchBand, UNDECIDED};
use crate::preprocess::registration::{IN_VIEW, PixelRun, SourceRun, TargetRun};
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
            let rank = pass.layers[band.camera].ranks[band.pixels[index] as usize];
            let index = index as u32;
            band.pending.push(PendingSample { index, rank, others: None, is_contradicted: None });
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
            let ask = || pass.votes.contradicts(pass.pairs, pass.layers, band.camera, pixel);
            if sample.is_contradicted.unwrap_or_else(ask) {
                *verdict = Verdict::without_witness(Rule::Contradicted);
                pass.set_status(band.camera, pixel, DROPPED);
                return false;
            }
            *verdict = Verdict::without_witness(Rule::Coverage);
            pass.set_status(band.camera, pixel, KEPT);
            return false;
        };
        *verdict = Verdict::dropped_for(pass.settings.pruning.method, sample.rank, next);
    }
}

/// Samples that are decided as one piece of work.
const CHUNK: usize = 4096;

/// Samples of one camera that wait for others.
#[derive(Default)]
pub(crate) struct Waiting {
    /// By chunk.
    chunks: Vec<(usize, Vec<PendingSample>)>,
    /// Camera and pixel of what is waited for.
    awaited: Vec<(u16, u32)>,
}

impl Waiting {
    /// Whether anything that is waited for is decided by now.
    pub(crate) fn may_go_on(&self, pass: &PruningPass<'_>) -> bool {
        let is_decided = |&(camera, pixel): &(u16, u32)| pass.status(usize::from(camera), pixel) != UNDECIDED;
        self.awaited.iter().any(is_decided)
    }

    /// Finds all that may be asked for on the way to a decision, so that it can be made without any layer. `pixels` are those of the
    /// camera's samples.
    pub(crate) fn prepare(&mut self, pass: &PruningPass<'_>, camera: usize, pixels: &[u32]) {
        let prepare = |(chunk, samples): &mut (usize, Vec<PendingSample>)| {
            for sample in samples {
                let pixel = pixels[*chunk * CHUNK + sample.index as usize];
                sample.others.get_or_insert_with(|| all_but_the_best(pass, camera, pixel));
                let ask = || pass.votes.contradicts(pass.pairs, pass.layers, camera, pixel);
                sample.is_contradicted.get_or_insert_with(ask);
            }
        };
        self.chunks.par_iter_mut().for_each(prepare);
    }

    /// Samples that wait.
    pub(crate) fn len(&self) -> usize {
        self.awaited.len()
    }
}

/// Decides the samples of a camera as far as possible: all for the first time, or those that are `waiting`. Gives those that still wait.
pub(crate) fn settle(
    pass: &PruningPass<'_>,
    camera: usize,
    decided: &mut LevelVerdicts,
    waiting: Option<Waiting>,
) -> Waiting {
    let is_first = waiting.is_none();
    let mut pending: Vec<Vec<PendingSample>> = Vec::new();
    pending.resize_with(decided.pixels.len().div_ceil(CHUNK), Vec::new);
    for (chunk, samples) in waiting.unwrap_or_default().chunks {
        pending[chunk] = samples;
    }
    let chunks = decided.pixels.par_chunks_mut(CHUNK).zip(decided.verdicts.par_chunks_mut(CHUNK));
    let of_chunk = |((pixels, verdicts), pending)| {
        let mut band = SearchBand { camera, rows: 0..0, pixels, verdicts, pending };
        if is_first {
            resolve(pass, &mut band);
        }
        if !band.pending.is_empty() {
            simd::run(ResolvePending { pass, band: &mut band });
        }
        let awaited = band.pending.iter().map(|sample| {
            let verdict = band.verdicts[sample.index as usize];
            (verdict.witness_camera, verdict.witness_pixel)
        });
        let awaited: Vec<_> = awaited.collect();
        (band.pending, awaited)
    };
    let settled: Vec<_> = chunks.zip(pending).map(of_chunk).collect();
    let mut still = Waiting::default();
    for (chunk, (pending, awaited)) in settled.into_iter().enumerate() {
        if !pending.is_empty() {
            still.chunks.push((chunk, pending));
            still.awaited.extend(awaited);
        }
    }
    still
}

/// All candidates of a sample but the best, worst first.
#[inline(always)]
fn all_but_the_best(pass: &PruningPass<'_>, camera: usize, pixel: u32) -> Vec<Candidate> {
    let layer = &pass.layers[camera];
    let (x, y) = (pixel as usize % layer.width, pixel as usize / layer.width);
    let sample = Candidate::new(layer, camera, pixel);
    let point = PixelRun::<1>::new(layer, x, y, 1);
    let mut candidates = Vec::new();
    for (other, registration) in pass.pairs.others(camera) {
        let target = &pass.layers[other];
        if target.geometry.is_empty() {
            continue;
        }
        let reprojected = registration.reproject(&point, target.width);
        if reprojected.bits[0] & IN_VIEW == 0 {
            continue;
        }
        // Whether it is better is known at once, whether it is the same surface takes long.
        let candidate = Candidate::new(target, other, reprojected.pixel[0]);
        // Samples of this level stay candidates after they are dropped: they are passed over later.
        let is_own_level = candidate.level == pass.level;
        let is_kept = pass.status(other, candidate.pixel) == KEPT;
        let point = SourceRun { layer, run: &point };
        let seen = TargetRun { layer: target, reprojected: &reprojected };
        if may_be_witness(is_own_level, is_kept, pass.settings.pruning.across_spans)
            && candidate.is_better_than(&sample)
            && pass.limits.compare(registration, point, seen, [1]).is_same(0)
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
