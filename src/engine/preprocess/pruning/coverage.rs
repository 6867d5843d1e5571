//! The coverage guarantee: a sample is dropped once a candidate is known to be kept; and kept once all are known to be dropped,
//! unless more cameras look past it than confirm it.

use rayon::prelude::*;

use super::decision::{Candidate, LevelVerdicts, Rule, Verdict, may_be_witness};
use super::pass::{DROPPED, KEPT, PruningPass, UNDECIDED};
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
    /// By chunk, once they were resolved.
    pending: Option<Vec<Vec<PendingSample>>>,
}

/// A sample whose candidate is undecided yet.
struct PendingSample {
    /// Index among the camera's samples.
    index: usize,
    /// All candidates but the best, worst first; found only where the best was dropped. The verdict names the one that is
    /// waited for.
    others: Option<Vec<Candidate>>,
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
                    pending.push(PendingSample { index: chunk * CHUNK + nth, others: None });
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

/// Drops every sample whose best candidate is kept, and those that others contradict; gives the others that are not decided to `wait`,
/// by their place among `pixels`.
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
    pending: &'a mut Vec<PendingSample>,
}

impl VectorLoop for ResolvePending<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { pass, camera, samples, first, verdicts, pending } = self;
        let all: Vec<usize> = pass.pairs.others(camera).map(|(other, _)| other).collect();
        pending.retain_mut(|PendingSample { index, others }| {
            let find = || {
                let mut found = candidates(pass, camera, samples, *index, &all);
                leave_out_best(&mut found);
                found
            };
            let pixel = samples.pixels[*index];
            let sample = WaitingSample { camera, pixel, rank: samples.ranks[*index] };
            let verdict = &mut verdicts[*index - first];
            let tried = sample.tried(pass, verdict, || others.get_or_insert_with(find).pop());
            if tried == Tried::NoneLeft {
                if pass.votes.contradicts(pass.pairs, pass.layers, camera, pixel) {
                    *verdict = Verdict::without_witness(Rule::Contradicted);
                    pass.set_status(camera, pixel, DROPPED);
                } else {
                    pass.set_status(camera, pixel, KEPT);
                }
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

/// Samples of one camera for which all candidates are found, so that these are tried without any layer.
pub(crate) struct Prepared {
    pub(crate) camera: usize,
    /// Among the camera's samples, ascending.
    indices: Vec<u32>,
    samples: RatedSamples,
    /// Candidates of each; once all are found, all but the best, worst first.
    others: Vec<Vec<Candidate>>,
}

impl Prepared {
    /// Nothing is found yet of the samples of a camera at `indices`, ascending.
    pub(crate) fn new(camera: usize, samples: &RatedSamples, indices: Vec<u32>) -> Self {
        let others = vec![Vec::new(); indices.len()];
        Self { camera, samples: samples.at(&indices), indices, others }
    }

    /// Samples.
    pub(crate) fn len(&self) -> usize {
        self.indices.len()
    }

    /// Leaves out of some indices those of samples that are prepared already.
    pub(crate) fn leave_out(&self, indices: &mut Vec<u32>) {
        indices.retain(|index| self.indices.binary_search(index).is_err());
    }

    /// Adds the candidates in the layers of some other cameras, which are there.
    pub(crate) fn compare(&mut self, pass: &PruningPass<'_>, targets: &[usize]) {
        let (camera, samples) = (self.camera, &self.samples);
        let others = self.others.par_iter_mut().with_min_len(CHUNK / 8).enumerate();
        others.for_each(|(index, others)| others.extend(candidates(pass, camera, samples, index, targets)));
    }

    /// Ends the preparation.
    pub(crate) fn end(&mut self) {
        self.others.par_iter_mut().for_each(leave_out_best);
    }

    /// Decides the samples as far as possible, and keeps those that wait. Gives the samples that are kept if others do not contradict
    /// them, ascending.
    pub(crate) fn settle(&mut self, pass: &PruningPass<'_>, decided: &mut LevelVerdicts) -> Vec<u32> {
        let camera = self.camera;
        let (mut left, mut none_left) = (Vec::new(), Vec::new());
        for (at, (&index, others)) in self.indices.iter().zip(&mut self.others).enumerate() {
            let (pixel, rank) = (self.samples.pixels[at], self.samples.ranks[at]);
            if pass.status(camera, pixel) != UNDECIDED {
                continue;
            }
            let sample = WaitingSample { camera, pixel, rank };
            match sample.tried(pass, &mut decided.verdicts[index as usize], || others.pop()) {
                Tried::Dropped => {}
                Tried::Waits => left.push(at as u32),
                Tried::NoneLeft => none_left.push(index),
            }
        }
        if left.len() < self.indices.len() {
            self.samples = self.samples.at(&left);
            let at = |place: &u32| *place as usize;
            self.indices = left.iter().map(|place| self.indices[at(place)]).collect();
            self.others = left.iter().map(|place| std::mem::take(&mut self.others[at(place)])).collect();
        }
        none_left
    }
}

/// Leaves all candidates but the best, worst first.
fn leave_out_best(candidates: &mut Vec<Candidate>) {
    candidates.sort_unstable_by(|a, b| b.cmp(a));
    candidates.pop();
}

/// The candidates of a sample in the layers of some other cameras.
#[inline(always)]
fn candidates(
    pass: &PruningPass<'_>,
    camera: usize,
    samples: &RatedSamples,
    index: usize,
    targets: &[usize],
) -> Vec<Candidate> {
    let (rank, pixel, level) = (samples.ranks[index], samples.pixels[index], samples.level);
    let sample = Candidate { rank, camera: camera as u16, pixel, level };
    let point = PixelRun::<1>::of_sample(samples, index);
    let mut candidates = Vec::new();
    for (other, registration) in pass.pairs.others_among(camera, targets) {
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
        let point = SourceRun { layer: &pass.layers[camera], run: &point };
        let seen = TargetRun { layer: target, reprojected: &reprojected };
        if may_be_witness(is_own_level, is_kept, pass.settings.pruning.across_spans)
            && candidate.is_better_than(&sample)
            && pass.limits.compare(registration, point, seen, [1]).is_same(0)
        {
            candidates.push(candidate);
        }
    }
    candidates
}
