//! The best candidate of every sample of a band, sixteen samples at a time, and the verdict if that candidate is kept.
//!
//! A sample without a candidate would be kept: here the other cameras vote on it.

use std::cmp::Reverse;

use super::best_candidate::{
    BestCandidates, ComparedRun, OtherCamera, UndecidedRun, compare_runs, lanes_at, other_cameras,
};
use super::decision::{Rule, Verdict, rule_of_kept};
use super::pass::{DROPPED, KEPT, PruningPass, SearchBand};
use crate::preprocess::agreement::VotedRun;
use crate::preprocess::layers::CameraLayer;
use crate::preprocess::registration::{PixelRun, SourceRun};
use crate::preprocess::temporal::SpanLevel;
use crate::settings::PruningMethod;
use crate::simd::{LANES, VectorLoop};

/// Rows are compared together until they have this many runs. With fewer, the data of another camera has left the cache before the
/// next row needs it; with more, the runs themselves do not fit.
const RUNS_TOGETHER: usize = 64;

/// Finds the best candidate of every sample of a band.
pub(super) struct FindBest<'a, 'b> {
    pub(super) pass: &'a PruningPass<'a>,
    pub(super) band: &'a mut SearchBand<'b>,
}

impl VectorLoop for FindBest<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { pass, band } = self;
        let layer = &pass.layers[band.camera];
        let columns = layer.width.div_ceil(LANES);
        let pruning = pass.settings.pruning.method != PruningMethod::Off;
        let lanes = lanes_of_band(band, layer, pass.level);
        let mut others = if pruning { others_of_band(pass, band, &lanes) } else { Vec::new() };
        let mut undecided = Vec::new();
        let mut compared = Vec::new();
        let mut next = 0;
        for (row, lanes) in band.rows.clone().zip(lanes.chunks_exact(columns)) {
            for (nth, &lanes) in lanes.iter().enumerate().filter(|(_, lanes)| **lanes != 0) {
                let block = PixelRun::new(layer, nth * LANES, row, lanes);
                let best = BestCandidates::new(&block, band.camera);
                undecided.push(UndecidedRun { nth, lanes, block, best });
            }
            if undecided.len() < RUNS_TOGETHER && row + 1 < band.rows.end {
                continue;
            }
            // One camera after the other, so that its picture is read along its rows.
            compared.resize_with(compared.len().max(undecided.len()), || ComparedRun::NOWHERE);
            for other in &mut others {
                compare_runs(pass, band.camera, &mut undecided, other, &mut compared);
            }
            others.sort_by_key(|other| Reverse(other.improved));
            for run in &undecided {
                let UndecidedRun { lanes, best, block, .. } = run;
                let contradicted = contradicted_lanes(pass, band.camera, run, &others);
                for lane in (0..LANES).filter(|lane| lanes >> lane & 1 == 1) {
                    let pixel = block.row * layer.width + block.column + lane;
                    let verdict = if contradicted >> lane & 1 == 1 {
                        Verdict::without_witness(Rule::Contradicted)
                    } else if pruning {
                        first_verdict(pass, band.camera, pixel, best, lane)
                    } else {
                        verdict_without_pruning(pass, band.camera, pixel)
                    };
                    band.pixels[next] = pixel as u32;
                    band.verdicts[next] = verdict;
                    next += 1;
                }
            }
            undecided.clear();
        }
    }
}

/// The samples of a run that would be kept if other cameras did not contradict them.
#[inline(always)]
fn contradicted_lanes(
    pass: &PruningPass<'_>,
    camera: usize,
    run: &UndecidedRun,
    others: &[OtherCamera<'_>],
) -> u32 {
    if !pass.votes.is_on() {
        return 0;
    }
    let layer = &pass.layers[camera];
    let pixel = run.block.row * layer.width + run.block.column;
    let is_asked = |lane: &usize| {
        run.lanes >> lane & 1 == 1
            && run.best.candidate(*lane).is_none()
            && pass.status(camera, (pixel + lane) as u32) != DROPPED
    };
    let mut asked = (0..LANES).filter(is_asked).fold(0, |lanes, lane| lanes | 1 << lane);
    if asked == 0 {
        return 0;
    }
    let is_flying = |lane: usize| asked >> lane & 1 == 1 && layer.packed_colors[pixel + lane].is_flying();
    let flying = (0..LANES).filter(|lane| is_flying(*lane)).fold(0, |lanes, lane| lanes | 1 << lane);
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
        let source = SourceRun { layer, run: &run.block };
        pass.votes.add(other.registration, source, target, asked, &mut votes);
    }
    asked & pass.votes.contradicted(&votes, flying, 0)
}

/// For each row and each sixteen pixels of it, which of them hold a sample of the level.
#[inline(always)]
fn lanes_of_band(band: &SearchBand<'_>, layer: &CameraLayer, level: SpanLevel) -> Vec<u32> {
    let mut all = Vec::with_capacity(band.rows.len() * layer.width.div_ceil(LANES));
    for row in band.rows.clone() {
        for column in (0..layer.width).step_by(LANES) {
            all.push(lanes_at(layer, (column, row), |found| found == level));
        }
    }
    all
}

/// The other cameras that may see something of the band.
#[inline(always)]
fn others_of_band<'a>(pass: &PruningPass<'a>, band: &SearchBand<'_>, lanes: &[u32]) -> Vec<OtherCamera<'a>> {
    other_cameras(pass.pairs, pass.layers, band.camera, band.rows.clone(), lanes, |other| {
        pass.limits
            .between(&pass.layers[band.camera], &pass.layers[other])
            .with_deeper(pass.has_deeper[other])
    })
}

fn verdict_without_pruning(pass: &PruningPass<'_>, camera: usize, pixel: usize) -> Verdict {
    if pass.status(camera, pixel as u32) == DROPPED {
        return Verdict::without_witness(Rule::MixedDropped);
    }
    pass.set_status(camera, pixel as u32, KEPT);
    Verdict::without_witness(Rule::PruningOff)
}

/// The verdict on a sample if its best candidate is kept. Keeps the sample if it has no candidate.
#[inline(always)]
fn first_verdict(
    pass: &PruningPass<'_>,
    camera: usize,
    pixel: usize,
    best: &BestCandidates,
    lane: usize,
) -> Verdict {
    if pass.status(camera, pixel as u32) == DROPPED {
        return Verdict::without_witness(Rule::MixedDropped);
    }
    if let Some(candidate) = best.candidate(lane) {
        return Verdict::dropped_for(pass.settings.pruning.method, best.own_rank[lane], candidate);
    }
    pass.set_status(camera, pixel as u32, KEPT);
    Verdict::without_witness(rule_of_kept(best.passed_over[lane] != 0, best.seen[lane] != 0))
}
