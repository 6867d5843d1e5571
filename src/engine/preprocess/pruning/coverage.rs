//! The coverage guarantee: a sample is dropped once a candidate is known to be kept; and kept once all are known to be dropped,
//! unless more cameras look past it than confirm it.

use std::ops::Range;

use rayon::prelude::*;

use super::decision::{Candidate, LevelVerdicts, Rule, Verdict, is_better, may_be_witness};
use super::pass::{DROPPED, KEPT, PruningPass, UNDECIDED};
use crate::capture::overlap::Registration;
use crate::error::Result;
use crate::job::Job;
use crate::preprocess::layers::{Rank, RatedSamples};
use crate::preprocess::registration::{IN_VIEW, PixelRun, SourceRun, TargetRun};
use crate::simd::{self, VectorLoop};

/// How many samples ahead the statuses of witnesses are prefetched.
const AHEAD: usize = 24;

/// Samples that are decided as one piece of work.
const CHUNK: usize = 4096;

/// The samples of one camera while they are decided, where the layers of all cameras are there.
pub(crate) struct Unsettled<'a> {
    camera: usize,
    pub(crate) decided: LevelVerdicts,
    samples: &'a RatedSamples,
    /// Samples whose candidate is undecided yet, by chunk, once they were resolved: indices among the camera's samples.
    pending: Option<Vec<Vec<usize>>>,
}

impl<'a> Unsettled<'a> {
    /// Verdicts as if all candidates were kept.
    pub(crate) fn new(camera: usize, decided: LevelVerdicts, samples: &'a RatedSamples) -> Self {
        Self { camera, decided, samples, pending: None }
    }

    /// Samples that wait.
    fn len(&self) -> usize {
        self.pending.as_ref().map_or(0, |pending| pending.iter().map(Vec::len).sum())
    }

    /// Decides the samples as far as possible.
    fn settle(&mut self, pass: &PruningPass<'_>) {
        let Self { camera, decided, samples, pending } = self;
        let camera = *camera;
        let of_chunks = pending.get_or_insert_with(|| {
            let chunks = decided.pixels.par_chunks(CHUNK).zip(decided.verdicts.par_chunks(CHUNK)).enumerate();
            let resolve = |(chunk, (pixels, verdicts)): (usize, (&[u32], &[Verdict]))| {
                let mut pending = Vec::new();
                resolve(pass, camera, pixels, verdicts, |nth| {
                    pending.push(chunk * CHUNK + nth);
                });
                pending
            };
            chunks.map(resolve).collect()
        });
        let chunks = decided.verdicts.par_chunks_mut(CHUNK).zip(of_chunks).enumerate();
        chunks.filter(|(_, (_, pending))| !pending.is_empty()).for_each(|(chunk, (verdicts, pending))| {
            simd::run(ResolvePending { pass, camera, samples, first: chunk * CHUNK, verdicts, pending });
        });
    }
}

/// Decides all samples of some cameras, among which are all that they wait for.
///
/// # Errors
/// `Cancelled`.
pub(crate) fn settle_all(pass: &PruningPass<'_>, cameras: &mut [Unsettled<'_>], job: &Job) -> Result<()> {
    loop {
        job.check()?;
        cameras.par_iter_mut().for_each(|unsettled| unsettled.settle(pass));
        if cameras.iter().all(|unsettled| unsettled.len() == 0) {
            return Ok(());
        }
    }
}

/// Drops samples whose best candidate is kept and samples that others contradict; the undecided rest goes to `wait`, by its place among
/// `pixels`.
fn resolve(
    pass: &PruningPass<'_>,
    camera: usize,
    pixels: &[u32],
    verdicts: &[Verdict],
    mut wait: impl FnMut(usize),
) {
    for (nth, (&pixel, verdict)) in pixels.iter().zip(verdicts).enumerate() {
        if let Some(ahead) = verdicts.get(nth + AHEAD) {
            let statuses = pass.statuses.get(ahead.witness_camera as usize);
            simd::prefetch(statuses.map_or(&[], Vec::as_slice), ahead.witness_pixel as usize);
        }
        if verdict.witness_camera == Verdict::NO_CAMERA {
            if verdict.rule == Rule::Contradicted {
                pass.set_status(camera, pixel, DROPPED);
            }
        } else if pass.status(camera, pixel) == UNDECIDED {
            if pass.status(verdict.witness_camera as usize, verdict.witness_pixel) == KEPT {
                pass.set_status(camera, pixel, DROPPED);
            } else {
                wait(nth);
            }
        }
    }
}

/// Decides what can be decided of the pending samples of a chunk of one camera.
struct ResolvePending<'a> {
    pass: &'a PruningPass<'a>,
    camera: usize,
    samples: &'a RatedSamples,
    /// Index of the first of `verdicts`.
    first: usize,
    verdicts: &'a mut [Verdict],
    pending: &'a mut Vec<usize>,
}

impl VectorLoop for ResolvePending<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { pass, camera, samples, first, verdicts, pending } = self;
        let all: Vec<usize> = pass.pairs.others(camera).map(|(other, _)| other).collect();
        pending.retain(|&index| {
            // All that are better than the next were dropped.
            let next = || candidates(pass, camera, samples, index, &all).next();
            let pixel = samples.pixels[index];
            let sample = WaitingSample { camera, pixel, rank: samples.ranks[index] };
            let verdict = &mut verdicts[index - first];
            let tried = sample.tried(pass, verdict, next);
            if tried == Tried::NoneLeft {
                let is_contradicted = pass.votes.contradicts(pass.pairs, pass.layers, camera, pixel);
                sample.end(pass, verdict, is_contradicted);
            }
            tried == Tried::Waits
        });
    }
}

/// A sample whose verdict names the candidate that is waited for.
#[derive(Clone, Copy)]
struct WaitingSample {
    camera: usize,
    pixel: u32,
    rank: Rank,
}

impl WaitingSample {
    /// Tries the candidates until one is kept or undecided, or none is left: then the verdict is that the sample is kept if others do
    /// not contradict it. `next` gives the best that is left.
    #[inline(always)]
    fn tried(
        self,
        pass: &PruningPass<'_>,
        verdict: &mut Verdict,
        mut next: impl FnMut() -> Option<Candidate>,
    ) -> Tried {
        let Self { camera, pixel, rank } = self;
        loop {
            match pass.status(verdict.witness_camera as usize, verdict.witness_pixel) {
                KEPT => {
                    pass.set_status(camera, pixel, DROPPED);
                    return Tried::Dropped;
                }
                UNDECIDED => return Tried::Waits,
                _ => {}
            }
            let Some(next) = next() else {
                *verdict = Verdict::without_witness(Rule::Coverage);
                return Tried::NoneLeft;
            };
            *verdict = Verdict::dropped_for(pass.settings.pruning.method, rank, next);
        }
    }

    /// Decides the sample once all its candidates are dropped.
    #[inline(always)]
    fn end(self, pass: &PruningPass<'_>, verdict: &mut Verdict, is_contradicted: bool) {
        if is_contradicted {
            *verdict = Verdict::without_witness(Rule::Contradicted);
        }
        pass.set_status(self.camera, self.pixel, if is_contradicted { DROPPED } else { KEPT });
    }
}

/// What became of a sample whose candidates were tried.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Tried {
    /// One of them is kept.
    Dropped,
    /// The best that is left is undecided.
    Waits,
    /// All were dropped.
    NoneLeft,
}

/// How far the verdicts of one camera are decided.
#[derive(Default)]
pub(crate) struct Resolved {
    /// Samples whose candidate is undecided. Indices, ascending.
    pub(crate) waiting: Vec<u32>,
    /// Samples whose candidate was dropped: the others have to be found. Indices, ascending.
    pub(crate) stuck: Vec<u32>,
}

/// Decides the samples of a camera as far as the decisions on others go, without any layer.
pub(crate) fn resolve_camera(pass: &PruningPass<'_>, camera: usize, decided: &LevelVerdicts) -> Resolved {
    let chunks = decided.pixels.par_chunks(CHUNK).zip(decided.verdicts.par_chunks(CHUNK)).enumerate();
    let of_chunk = |(chunk, (pixels, verdicts)): (usize, (&[u32], &[Verdict]))| {
        let mut resolved = Resolved::default();
        resolve(pass, camera, pixels, verdicts, |nth| {
            let verdict = verdicts[nth];
            let is_waiting = pass.status(verdict.witness_camera as usize, verdict.witness_pixel) == UNDECIDED;
            let list = if is_waiting { &mut resolved.waiting } else { &mut resolved.stuck };
            list.push((chunk * CHUNK + nth) as u32);
        });
        resolved
    };
    let of_chunks: Vec<Resolved> = chunks.map(of_chunk).collect();
    of_chunks.into_iter().fold(Resolved::default(), |mut all, chunk| {
        all.waiting.extend(chunk.waiting);
        all.stuck.extend(chunk.stuck);
        all
    })
}

/// Samples of one camera while their candidates are looked for in the layers of others.
pub(crate) struct Preparing<'a> {
    camera: usize,
    samples: &'a RatedSamples,
    candidates: Vec<Vec<Candidate>>,
}

impl<'a> Preparing<'a> {
    /// Nothing is found yet of some samples of a camera.
    pub(crate) fn new(camera: usize, samples: &'a RatedSamples) -> Self {
        Self { camera, samples, candidates: vec![Vec::new(); samples.len()] }
    }

    /// Adds the candidates in the layers of some other cameras, which are there.
    pub(crate) fn compare(&mut self, pass: &PruningPass<'_>, targets: &[usize]) {
        let (camera, samples) = (self.camera, self.samples);
        if pass.pairs.others_among(camera, targets).next().is_none() {
            return;
        }
        let of_samples = self.candidates.par_iter_mut().with_min_len(CHUNK / 8).enumerate();
        of_samples.for_each(|(index, found)| {
            let is_kept = |found: &Candidate| pass.status(found.camera as usize, found.pixel) == KEPT;
            for candidate in candidates(pass, camera, samples, index, targets) {
                found.push(candidate);
                if is_kept(&candidate) {
                    break;
                }
            }
            found.sort_unstable();
            if let Some(first_kept) = found.iter().position(is_kept) {
                found.truncate(first_kept + 1);
            }
        });
    }
}

/// A sample whose candidates are found.
struct PreparedSample {
    /// Among the camera's samples.
    index: u32,
    pixel: u32,
    rank: Rank,
    /// Whether the others contradict it, should no candidate be kept.
    is_contradicted: bool,
    /// Where its candidates are: the best comes last.
    candidates: Range<usize>,
}

/// Samples of one camera for which all candidates are found, so that these are tried without any layer.
#[derive(Default)]
pub(crate) struct Prepared {
    /// By index, ascending.
    waiting: Vec<PreparedSample>,
    candidates: Vec<Candidate>,
}

impl Prepared {
    /// Samples.
    pub(crate) fn len(&self) -> usize {
        self.waiting.len()
    }

    /// Bytes in memory.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(&*self.waiting) + size_of_val(&*self.candidates)
    }

    /// Leaves out of some indices those of samples that are prepared already.
    pub(crate) fn leave_out(&self, indices: &mut Vec<u32>) {
        indices.retain(|index| self.waiting.binary_search_by_key(index, |sample| sample.index).is_err());
    }

    /// Adds samples at `indices` of the same camera, which are not among these. Their candidates were looked for in the layers of all
    /// others, and all others have voted on them.
    pub(crate) fn add(&mut self, indices: &[u32], found: Preparing<'_>, is_contradicted: &[bool]) {
        let Preparing { samples, candidates, .. } = found;
        for (at, found) in candidates.into_iter().enumerate() {
            let first = self.candidates.len();
            self.candidates.extend(found.into_iter().rev());
            self.waiting.push(PreparedSample {
                index: indices[at],
                pixel: samples.pixels[at],
                rank: samples.ranks[at],
                is_contradicted: is_contradicted[at],
                candidates: first..self.candidates.len(),
            });
        }
        self.waiting.sort_unstable_by_key(|sample| sample.index);
    }

    /// Decides the samples of `camera` as far as possible, and keeps the rest waiting.
    pub(crate) fn settle(&mut self, pass: &PruningPass<'_>, camera: usize, decided: &mut LevelVerdicts) {
        let mut left = Self::default();
        for prepared in std::mem::take(&mut self.waiting) {
            let PreparedSample { index, pixel, rank, is_contradicted, ref candidates } = prepared;
            if pass.status(camera, pixel) != UNDECIDED {
                continue;
            }
            let sample = WaitingSample { camera, pixel, rank };
            let mut others = self.candidates[candidates.clone()].iter();
            let verdict = &mut decided.verdicts[index as usize];
            match sample.tried(pass, verdict, || others.next_back().copied()) {
                Tried::Dropped => {}
                Tried::Waits => {
                    let first = left.candidates.len();
                    left.candidates.extend(others);
                    left.waiting
                        .push(PreparedSample { candidates: first..left.candidates.len(), ..prepared });
                }
                Tried::NoneLeft => sample.end(pass, verdict, is_contradicted),
            }
        }
        *self = left;
    }
}

/// The candidates of a sample in the layers of some other cameras that are not dropped, the best first. Whether a pixel is better is known
/// at once; whether it shows the same surface takes long, and is only asked of candidates that are taken.
#[inline(always)]
fn candidates<'a>(
    pass: &'a PruningPass<'_>,
    camera: usize,
    samples: &'a RatedSamples,
    index: usize,
    targets: &'a [usize],
) -> impl Iterator<Item = Candidate> + use<'a> {
    let rank = samples.ranks[index];
    let point = PixelRun::<1>::of_sample(samples, index);
    // All are reprojected before any rank is read, so that many fetches from memory are under way at once.
    let mut seen = Vec::with_capacity(targets.len());
    for (other, registration) in pass.pairs.others_among(camera, targets) {
        let target = &pass.layers[other];
        let reprojected = registration.reproject(&point, target.width);
        if !target.geometry.is_empty() && reprojected.bits[0] & IN_VIEW != 0 {
            simd::prefetch(&target.ranks, reprojected.pixel[0] as usize);
            seen.push((other, registration, reprojected.pixel[0]));
        }
    }
    let mut better = Vec::new();
    for (other, registration, pixel) in seen {
        let target = &pass.layers[other];
        if !is_better(target.ranks[pixel as usize], other as u32, rank, camera as u32) {
            continue;
        }
        let candidate = Candidate::new(target, other, pixel);
        let status = pass.status(other, candidate.pixel);
        let is_own_level = candidate.level == pass.level && status != DROPPED;
        if may_be_witness(is_own_level, status == KEPT, pass.settings.pruning.across_spans) {
            better.push((candidate, registration));
        }
    }
    better.sort_unstable_by_key(|(candidate, ..)| *candidate);
    let is_same = move |(candidate, registration): &(Candidate, &Registration)| {
        let target = &pass.layers[candidate.camera as usize];
        let reprojected = registration.reproject(&point, target.width);
        let from = SourceRun::of_samples(&pass.layers[camera], &point, samples, index, 1);
        let seen = TargetRun { layer: target, reprojected: &reprojected };
        pass.limits.compare(registration, from, seen, [1]).is_same(0)
    };
    better.into_iter().filter(is_same).map(|(candidate, _)| candidate)
}
