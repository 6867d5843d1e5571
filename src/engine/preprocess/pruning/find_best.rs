//! The best candidate of every sample of a band, sixteen samples at a time, and the verdict if that candidate is kept.
//!
//! A sample without a candidate would be kept: here the other cameras vote on it. Where the layers of the other cameras are not there
//! all at once, the search goes through them part by part, and those samples are asked for their votes afterwards.

use std::cmp::Reverse;
use std::ops::Range;

use super::best_candidate::{
    BestCandidates, ColumnBounds, ComparedRun, OtherCamera, UndecidedRun, compare_runs, other_cameras,
};
use super::decision::{Rule, Verdict};
use super::pass::{DROPPED, KEPT, PruningPass};
use crate::preprocess::agreement::VotedRun;
use crate::preprocess::layers::{Rank, RatedSamples, SampleRun};
use crate::preprocess::registration::{PixelRun, SourceRun};
use crate::samples::VoteCounts;
use crate::settings::PruningMethod;
use crate::simd::{LANES, VectorLoop};

/// Rows are compared together until they have this many runs. With fewer, the data of another camera has left the cache before the
/// next row needs it; with more, the runs themselves do not fit.
const RUNS_TOGETHER: usize = 64;

/// Some rows of one camera: the samples to decide, and the verdict on each so far. Until it is resolved, a verdict names the
/// sample's best candidate as if that one were kept.
pub(crate) struct SearchBand<'a> {
    pub(crate) camera: usize,
    pub(crate) rows: Range<usize>,
    pub(crate) samples: &'a RatedSamples,
    /// Index of the band's first sample.
    pub(crate) first: usize,
    pub(crate) verdicts: &'a mut [Verdict],
    /// What is known beside the verdicts between two parts of a search; empty where there is one part.
    pub(crate) between: &'a mut [BetweenParts],
}

/// What is known of a sample between two parts of a search.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct BetweenParts {
    /// That of its best candidate so far.
    pub(crate) rank: Rank,
    pub(crate) votes: VoteCounts,
    /// Whether it is of a thing one pixel wide, as far as it was asked.
    pub(crate) is_thin: bool,
}

/// Finds the best candidate of every sample of a band in the layers that are there.
pub(super) struct FindBest<'a, 'b> {
    pub(super) pass: &'a PruningPass<'a>,
    pub(super) band: &'a mut SearchBand<'b>,
    /// Whether no other layers were searched before.
    pub(super) is_first: bool,
}

impl VectorLoop for FindBest<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { pass, band, is_first } = self;
        let runs = band.runs();
        let pruning = pass.settings.pruning.method != PruningMethod::Off;
        let mut others = if pruning { others_of_band(pass, band, &runs) } else { Vec::new() };
        let mut undecided = Vec::new();
        let mut compared = Vec::new();
        for (at, run) in runs.iter().enumerate() {
            let block = PixelRun::of_samples(band.samples, run);
            let mut best = BestCandidates::new(&block, band.camera);
            if !is_first {
                resume(band, run, &mut best);
            }
            undecided.push(UndecidedRun { run: *run, block, best });
            let ends_row = runs.get(at + 1).is_none_or(|next| next.row != run.row);
            if at + 1 < runs.len() && !(ends_row && undecided.len() >= RUNS_TOGETHER) {
                continue;
            }
            // One camera after the other, so that its picture is read along its rows.
            compared.resize_with(compared.len().max(undecided.len()), || ComparedRun::NOWHERE);
            for other in &mut others {
                compare_runs(pass, (band.camera, band.samples), &mut undecided, other, &mut compared);
            }
            others.sort_by_key(|other| Reverse(other.improved));
            for run in &undecided {
                if band.between.is_empty() {
                    conclude_run(pass, band, run, &others);
                } else {
                    suspend(pass, band, run);
                }
            }
            undecided.clear();
        }
    }
}

impl SearchBand<'_> {
    pub(super) fn runs(&self) -> Vec<SampleRun> {
        self.samples.runs(self.first..self.first + self.verdicts.len())
    }
}

/// The lanes of a run that hold a sample, each with the sample's index in the band.
#[inline(always)]
fn samples_of(run: &SampleRun, first: usize) -> impl Iterator<Item = (usize, usize)> + use<> {
    let (lanes, start) = (run.lanes, run.first - first);
    (0..LANES)
        .filter(move |lane| lanes >> lane & 1 == 1)
        .enumerate()
        .map(move |(nth, lane)| (lane, start + nth))
}

/// The best candidates as an earlier part of the search left them.
#[inline(always)]
fn resume(band: &SearchBand<'_>, run: &SampleRun, best: &mut BestCandidates) {
    for (lane, index) in samples_of(run, band.first) {
        best.resume(lane, band.verdicts[index], band.between[index].rank);
    }
}

/// Notes the best candidates for the next part of the search.
#[inline(always)]
fn suspend(pass: &PruningPass<'_>, band: &mut SearchBand<'_>, run: &UndecidedRun) {
    let UndecidedRun { run, best, .. } = run;
    for (lane, index) in samples_of(run, band.first) {
        if let Some(candidate) = best.candidate(lane) {
            band.verdicts[index] =
                Verdict::dropped_for(pass.settings.pruning.method, best.own_rank[lane], candidate);
            band.between[index].rank = candidate.rank;
        } else {
            band.verdicts[index] = Verdict::without_witness(best.rule_of_kept(lane));
        }
    }
}

/// The verdicts on the samples of a run that was compared with all cameras.
#[inline(always)]
fn conclude_run(
    pass: &PruningPass<'_>,
    band: &mut SearchBand<'_>,
    undecided: &UndecidedRun,
    others: &[OtherCamera<'_>],
) {
    let contradicted = contradicted_lanes(pass, band, undecided, others);
    let UndecidedRun { run, best, .. } = undecided;
    for (lane, index) in samples_of(run, band.first) {
        let verdict = if let Some(candidate) = best.candidate(lane) {
            Verdict::dropped_for(pass.settings.pruning.method, best.own_rank[lane], candidate)
        } else {
            Verdict::without_witness(best.rule_of_kept(lane))
        };
        let pixel = band.samples.pixels[band.first + index];
        band.verdicts[index] =
            first_verdict(pass, band.camera, pixel, verdict, contradicted >> lane & 1 == 1);
    }
}

/// The verdict on a sample if its best candidate is kept. Keeps the sample if it has no candidate.
#[inline(always)]
fn first_verdict(
    pass: &PruningPass<'_>,
    camera: usize,
    pixel: u32,
    found: Verdict,
    is_contradicted: bool,
) -> Verdict {
    if pass.status(camera, pixel) == DROPPED {
        return Verdict::without_witness(Rule::MixedDropped);
    }
    if found.witness_camera != Verdict::NO_CAMERA {
        return found;
    }
    if is_contradicted {
        return Verdict::without_witness(Rule::Contradicted);
    }
    pass.set_status(camera, pixel, KEPT);
    if pass.settings.pruning.method == PruningMethod::Off {
        return Verdict::without_witness(Rule::PruningOff);
    }
    found
}

/// Gives the verdicts on all samples of a band, once all layers were searched: those on samples without a candidate only where the
/// others have voted on these, or do not vote.
pub(super) fn conclude(pass: &PruningPass<'_>, band: &mut SearchBand<'_>, have_voted: bool) {
    for index in 0..band.verdicts.len() {
        if have_voted || !pass.votes.is_on() || !is_asked(pass, band, index) {
            let at = band.first + index;
            let is_flying = band.samples.packed_colors[at].is_flying();
            let is_contradicted = pass.votes.is_contradicted(band.between[index].votes, is_flying);
            let pixel = band.samples.pixels[at];
            band.verdicts[index] =
                first_verdict(pass, band.camera, pixel, band.verdicts[index], is_contradicted);
        }
    }
}

/// The samples of a run that would be kept if other cameras did not contradict them.
#[inline(always)]
fn contradicted_lanes(
    pass: &PruningPass<'_>,
    band: &SearchBand<'_>,
    undecided: &UndecidedRun,
    others: &[OtherCamera<'_>],
) -> u32 {
    if !pass.votes.is_on() {
        return 0;
    }
    let UndecidedRun { run, block, best } = undecided;
    let layer = &pass.layers[band.camera];
    let pixel = block.row * band.samples.width + block.column;
    let (mut asked, mut flying) = (0, 0);
    for (lane, index) in samples_of(run, band.first) {
        let is_asked =
            best.candidate(lane).is_none() && pass.status(band.camera, (pixel + lane) as u32) != DROPPED;
        asked |= u32::from(is_asked) << lane;
        flying |= u32::from(band.samples.packed_colors[band.first + index].is_flying()) << lane;
    }
    if asked == 0 {
        return 0;
    }
    flying &= asked;
    let voters = || others.iter().filter(|other| other.may_see[run.nth]);
    let mut left = voters().count() as u32;
    let mut votes = VotedRun::NONE;
    for other in voters() {
        // The remaining cameras need not vote on samples that all of them together cannot contradict.
        asked &= pass.votes.contradicted(&votes, flying, left);
        if asked == 0 {
            return 0;
        }
        left -= 1;
        let target = &pass.layers[other.camera];
        let source = SourceRun::of_samples(layer, block, band.samples, run.first, run.lanes);
        let is_thin = |lane| pass.votes.is_thin(layer, pixel + lane, other.registration);
        pass.votes.add(other.registration, source, target, asked, is_thin, &mut votes);
    }
    asked & pass.votes.contradicted(&votes, flying, 0)
}

/// Whether other cameras are to vote on a sample: it has no candidate in any layer.
fn is_asked(pass: &PruningPass<'_>, band: &SearchBand<'_>, index: usize) -> bool {
    band.verdicts[index].witness_camera == Verdict::NO_CAMERA
        && pass.status(band.camera, band.samples.pixels[band.first + index]) != DROPPED
}

/// Notes which samples of a band are thin, if other cameras are to vote on them. The layer of the band's camera is there.
pub(super) fn find_thin(pass: &PruningPass<'_>, band: &mut SearchBand<'_>) {
    let own = pass.pairs.registration(band.camera, band.camera);
    for index in 0..band.verdicts.len() {
        if is_asked(pass, band, index) {
            let pixel = band.samples.pixels[band.first + index] as usize;
            band.between[index].is_thin = pass.votes.is_thin(&pass.layers[band.camera], pixel, own);
        }
    }
}

/// Lets the cameras whose layers are there vote on samples of a band without a candidate.
pub(super) struct AskOthers<'a, 'b> {
    pub(super) pass: &'a PruningPass<'a>,
    pub(super) band: &'a mut SearchBand<'b>,
}

impl VectorLoop for AskOthers<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { pass, band } = self;
        let runs = band.runs();
        let others = others_of_band(pass, band, &runs);
        let layer = &pass.layers[band.camera];
        for run in &runs {
            let mut asked = 0;
            let mut thin = 0_u32;
            for (lane, index) in samples_of(run, band.first) {
                asked |= u32::from(is_asked(pass, band, index)) << lane;
                thin |= u32::from(band.between[index].is_thin) << lane;
            }
            if asked == 0 {
                continue;
            }
            let block = PixelRun::of_samples(band.samples, run);
            let mut votes = VotedRun::NONE;
            for other in others.iter().filter(|other| other.may_see[run.nth]) {
                let source = SourceRun::of_samples(layer, &block, band.samples, run.first, run.lanes);
                let is_thin = |lane: usize| thin >> lane & 1 == 1;
                let target = &pass.layers[other.camera];
                pass.votes.add(other.registration, source, target, asked, is_thin, &mut votes);
            }
            for (lane, index) in samples_of(run, band.first) {
                let votes = votes.counts(lane);
                let all = &mut band.between[index].votes;
                all.confirm += votes.confirm;
                all.look_past += votes.look_past;
            }
        }
    }
}

/// The other cameras that may see something of the band.
#[inline(always)]
fn others_of_band<'a>(
    pass: &PruningPass<'a>,
    band: &SearchBand<'_>,
    runs: &[SampleRun],
) -> Vec<OtherCamera<'a>> {
    let mut bounds = ColumnBounds::new(band.samples.width);
    for run in runs {
        let count = run.lanes.count_ones() as usize;
        for facet in &band.samples.geometry[run.first..run.first + count] {
            bounds.add(run.nth, facet.inverse_depth);
        }
    }
    other_cameras(pass.pairs, pass.layers, band.camera, band.rows.clone(), &bounds, |other| {
        let limits = pass.limits.between(&pass.layers[band.camera], &pass.layers[other]);
        limits.with_deeper(pass.has_deeper)
    })
}
