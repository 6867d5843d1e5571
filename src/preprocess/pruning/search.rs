//! Pruning (the paper, §3.2): of all samples of one surface point the best-sampled one stays.
//!
//! Source: Interactive Dynamic Environments Using Image-Based Modeling and Rendering, §3.2, "keeping those pixels that have
//! the highest sampling rate". What differs: **coverage is guaranteed**. A sample is dropped only if a sample that is
//! *kept* represents it. Pairwise comparison alone does not give that: A may be dropped for B, and B for C, where C does
//! not see A's point. Here every sample waits until all better samples of its point are decided; it is dropped if one of
//! them was kept, and kept otherwise. "Better" is a total order (rank, then camera index), so the waiting has no cycles
//! and the answer is the same whatever order or thread it is worked out in.
//!
//! ```text
//! candidates of p = samples of other cameras that show p's point and are better than p
//! p is dropped  ⇔  some candidate is kept, or else more cameras look past p than confirm it
//! ```
//!
//! A sample that the others contradict is therefore never kept, and represents none. Votes are counted only for samples that would
//! be kept: all others are dropped anyway, for a witness that is not contradicted.
//!
//! Nearly always the best candidate is kept, so that only this one is looked for at first, for sixteen samples at a time. Where
//! it turns out dropped, all candidates are found and tried in their order. Samples are not compared with a camera that cannot
//! see the rectangle in which they lie, nor with one that has nothing better there than what was found already. The conditions of the rules are in `decision.rs`.

use std::cmp::Reverse;
use std::sync::atomic::{AtomicU8, Ordering};

use rayon::prelude::*;

use super::best_candidate::{
    BestCandidates, ComparedRun, OtherCamera, UndecidedRun, compare_runs, lanes_at, other_cameras,
};
use super::coverage::{ResolvePending, resolve};
use super::decision::{Decided, Dispute, Rule, Verdict, is_dropped_as_mixed, may_be_witness, rule_of_kept};
use super::pass::{BAND_ROWS, DROPPED, KEPT, PruningPass, SearchBand, Statuses, UNDECIDED};
use super::rank_bounds::RankBounds;
use crate::error::Result;
use crate::job::Job;
use crate::preprocess::agreement::{VoteTest, VotedRun};
use crate::preprocess::layers::{CameraLayer, Ranks};
use crate::preprocess::registration::{CameraPairs, LANES, PixelRun, SameSurface};
use crate::preprocess::temporal::{NO_SAMPLE, ROOT, SpanLevel};
use crate::settings::{MixedPixels, PruningMethod, Settings};
use crate::simd::{self, VectorLoop};

/// Decides every sample of `level`; samples of other levels take part as `statuses` says and stay as they are.
///
/// Levels are decided in ascending order, from the span of all frames down to the frame.
///
/// # Errors
/// `Cancelled`.
pub(crate) fn prune(
    pairs: &CameraPairs<'_>,
    layers: &[CameraLayer],
    statuses: &Statuses,
    level: SpanLevel,
    settings: &Settings,
    job: &Job,
) -> Result<Vec<Decided>> {
    let each = || layers.par_iter().zip(statuses);
    let mark = |(layer, statuses): (&CameraLayer, &Vec<AtomicU8>)| {
        mark_undecided(layer, statuses, level, settings.pruning.mixed_pixels)
    };
    let counts: Vec<Vec<usize>> = each().map(mark).collect();
    let mut decided: Vec<Decided> =
        counts.iter().map(|counts| Decided::of_size(counts.iter().sum())).collect();
    let samples: usize = decided.iter().map(|decided| decided.pixels.len()).sum();
    let pixels: usize = layers.iter().map(|layer| layer.level.len()).sum();
    let is_dense = samples > pixels / DENSE_SHARE;
    let all_may_be_witnesses = each().map(|(layer, statuses)| {
        is_dense && all_may_be_witnesses(layer, statuses, level, settings.pruning.across_spans)
    });
    let pass = PruningPass {
        pairs,
        layers,
        statuses,
        level,
        settings,
        limits: SameSurface::new(settings).at_level(level),
        votes: VoteTest::new(settings, level),
        all_may_be_witnesses: all_may_be_witnesses.collect(),
        has_deeper: layers.par_iter().map(|layer| has_deeper(layer, level)).collect(),
        is_only_level: false,
    };
    let cameras = counts.iter().zip(&mut decided).enumerate();
    let mut bands: Vec<_> =
        cameras.flat_map(|(camera, (counts, decided))| bands(layers, camera, counts, decided)).collect();
    // Where fewer samples are compared than there are pixels, bounds would take longer than what they save.
    let pays = samples * layers.len() > pixels;
    let bounds: Vec<_> = if pays { layers.par_iter().map(RankBounds::of).collect() } else { Vec::new() };
    find_best(&pass, &bounds, &mut bands, job)?;
    bands.par_iter_mut().for_each(|band| resolve(&pass, band));
    while bands.iter().any(|band| !band.pending.is_empty()) {
        job.check()?;
        bands.par_iter_mut().for_each(|band| simd::run(ResolvePending { pass: &pass, band }));
    }
    let disputes: Vec<_> = bands.into_iter().map(|band| (band.camera, band.disputes)).collect();
    for (camera, disputes) in disputes {
        decided[camera].disputes.extend(disputes);
    }
    if settings.pruning.mixed_pixels != MixedPixels::Keep {
        decided.par_iter_mut().zip(layers).for_each(|(decided, layer)| decided.count_mixed(layer));
    }
    Ok(decided)
}

/// Finds the best candidate of every sample of some bands, with bounds on the ranks of each camera if they are known.
fn find_best(
    pass: &PruningPass<'_>,
    bounds: &[RankBounds],
    bands: &mut [SearchBand<'_>],
    job: &Job,
) -> Result<()> {
    bands.par_iter_mut().try_for_each(|band| {
        job.check()?;
        simd::run(FindBest { pass, bounds, band });
        Ok(())
    })
}

/// What a pass over samples of all frames shares where there are no others, before anything is decided.
pub(crate) fn pass_over_views<'a>(
    pairs: &'a CameraPairs<'a>,
    layers: &'a [CameraLayer],
    statuses: &'a Statuses,
    settings: &'a Settings,
) -> PruningPass<'a> {
    let is_any_dropped = settings.pruning.mixed_pixels != MixedPixels::Keep;
    PruningPass {
        pairs,
        layers,
        statuses,
        level: ROOT,
        settings,
        limits: SameSurface::new(settings).at_level(ROOT),
        votes: VoteTest::new(settings, ROOT),
        all_may_be_witnesses: vec![!is_any_dropped; layers.len()],
        has_deeper: vec![false; layers.len()],
        is_only_level: true,
    }
}

/// As [`prune`] for some cameras of a [`pass_over_views`], up to the verdicts as if all candidates were kept.
///
/// # Errors
/// `Cancelled`.
pub(crate) fn find(pass: &PruningPass<'_>, cameras: &[usize], job: &Job) -> Result<Vec<Decided>> {
    let mark = |&camera: &usize| {
        let mixed_pixels = pass.settings.pruning.mixed_pixels;
        mark_undecided(&pass.layers[camera], &pass.statuses[camera], pass.level, mixed_pixels)
    };
    let counts: Vec<Vec<usize>> = cameras.par_iter().map(mark).collect();
    let mut decided: Vec<Decided> =
        counts.iter().map(|counts| Decided::of_size(counts.iter().sum())).collect();
    let each = cameras.iter().zip(counts.iter().zip(&mut decided));
    let mut bands: Vec<_> =
        each.flat_map(|(&camera, (counts, decided))| bands(pass.layers, camera, counts, decided)).collect();
    let bounds: Vec<_> = pass.layers.par_iter().map(RankBounds::of).collect();
    find_best(pass, &bounds, &mut bands, job)?;
    let disputes: Vec<_> = bands.into_iter().map(|band| (band.camera, band.disputes)).collect();
    let mut at = 0;
    for (camera, disputes) in disputes {
        at += cameras[at..].iter().position(|other| *other == camera).unwrap_or(0);
        decided[at].disputes.extend(disputes);
    }
    Ok(decided)
}

/// Pixels that are passed over at once.
const RUN: usize = 64;

/// Rows are compared together until they have so many runs: few enough that these and what other cameras saw there stay in the cache.
const RUNS_TOGETHER: usize = 64;

/// If fewer than one in this many pixels are to be decided, testing whether all samples may be witnesses does not pay.
const DENSE_SHARE: usize = 8;

/// Marks the samples of `level` as undecided, mixed ones as dropped where they are to be. Gives how many there are in each band
/// of rows.
fn mark_undecided(
    layer: &CameraLayer,
    statuses: &[AtomicU8],
    level: SpanLevel,
    mixed_pixels: MixedPixels,
) -> Vec<usize> {
    let band = (BAND_ROWS * layer.width).max(1);
    let mut counts = Vec::with_capacity(layer.level.len().div_ceil(band));
    for (band_of, (levels, statuses)) in layer.level.chunks(band).zip(statuses.chunks(band)).enumerate() {
        let mut count = 0;
        let runs = levels.chunks(RUN).zip(statuses.chunks(RUN)).enumerate();
        // Most levels have few samples: runs without any are passed over sixteen or more bytes at a time.
        for (run, (levels, statuses)) in runs.filter(|(_, (levels, _))| levels.contains(&level)) {
            let first = band_of * band + run * RUN;
            for (i, (&found, status)) in levels.iter().zip(statuses).enumerate() {
                if found == level {
                    count += 1;
                    let is_dropped = is_dropped_as_mixed(mixed_pixels, layer.ranks[first + i].rank);
                    status.store(if is_dropped { DROPPED } else { UNDECIDED }, Ordering::Relaxed);
                }
            }
        }
        counts.push(count);
    }
    counts
}

/// Whether every sample of `level` and of the levels above may be a witness.
fn all_may_be_witnesses(
    layer: &CameraLayer,
    statuses: &[AtomicU8],
    level: SpanLevel,
    across_spans: bool,
) -> bool {
    let mut all = true;
    for (&found, status) in layer.level.iter().zip(statuses) {
        let status = status.load(Ordering::Relaxed);
        let is_own_level = (found == level) & (status != DROPPED);
        all &= (found > level) | may_be_witness(is_own_level, status == KEPT, across_spans);
    }
    all
}

fn has_deeper(layer: &CameraLayer, level: SpanLevel) -> bool {
    let mut deeper = false;
    for &found in &layer.level {
        deeper |= (found > level) & (found != NO_SAMPLE);
    }
    deeper
}

/// The rows of a camera, cut into bands that hold something to decide.
fn bands<'a>(
    layers: &[CameraLayer],
    camera: usize,
    counts: &[usize],
    decided: &'a mut Decided,
) -> Vec<SearchBand<'a>> {
    let mut bands = Vec::new();
    let (mut pixels, mut verdicts) = (&mut decided.pixels[..], &mut decided.verdicts[..]);
    for (index, &count) in counts.iter().enumerate().filter(|(_, count)| **count > 0) {
        let first_row = index * BAND_ROWS;
        let (own_pixels, rest) = pixels.split_at_mut(count);
        pixels = rest;
        let (own_verdicts, rest) = verdicts.split_at_mut(count);
        verdicts = rest;
        bands.push(SearchBand {
            camera,
            rows: first_row..(first_row + BAND_ROWS).min(layers[camera].height()),
            pixels: own_pixels,
            verdicts: own_verdicts,
            disputes: Vec::new(),
            pending: Vec::new(),
        });
    }
    bands
}

/// Finds the best candidate of every sample of a band.
struct FindBest<'a, 'b> {
    pass: &'a PruningPass<'a>,
    bounds: &'a [RankBounds],
    band: &'a mut SearchBand<'b>,
}

impl VectorLoop for FindBest<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { pass, bounds, band } = self;
        let layer = &pass.layers[band.camera];
        let columns = layer.width.div_ceil(LANES);
        let pruning = pass.settings.pruning.method != PruningMethod::Off;
        let lanes = lanes_of_band(band, layer, pass.level);
        let mut others = if pruning { others_of_band(pass, bounds, band, &lanes) } else { Vec::new() };
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
            // One camera after the other, so that its picture is read along its rows, and what of it was read is still near for the
            // next row.
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
                        first_verdict(pass, band.camera, pixel, best, lane, &mut band.disputes)
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

/// Which samples of a run are to be kept but for the other cameras, which contradict them.
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
        // Nobody is asked about samples that all who are left cannot contradict any more.
        asked &= pass.votes.contradicted(&votes, flying, left);
        if asked == 0 {
            return 0;
        }
        left -= 1;
        let target = &pass.layers[other.camera];
        pass.votes.add(other.registration, (layer, &run.block), target, asked, &mut votes);
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
fn others_of_band<'a>(
    pass: &PruningPass<'a>,
    bounds: &[RankBounds],
    band: &SearchBand<'_>,
    lanes: &[u32],
) -> Vec<OtherCamera<'a>> {
    let limits = |other: usize| {
        let limits = pass.limits.between(&pass.layers[band.camera], &pass.layers[other]);
        limits.with_deeper(pass.has_deeper[other])
    };
    let best_in = |other: usize, rectangle| {
        bounds.get(other).map_or(Ranks::BEST, |bounds| bounds.in_rectangle(rectangle))
    };
    other_cameras(pass.pairs, pass.layers, (band.camera, band.rows.clone()), lanes, limits, best_in)
}

fn verdict_without_pruning(pass: &PruningPass<'_>, camera: usize, pixel: usize) -> Verdict {
    if pass.status(camera, pixel as u32) == DROPPED {
        return Verdict::without_witness(Rule::MixedDropped);
    }
    pass.set_status(camera, pixel as u32, KEPT);
    Verdict::without_witness(Rule::PruningOff)
}

/// The verdict on a sample if its best candidate is kept. Keeps the sample where there is none.
#[inline(always)]
fn first_verdict(
    pass: &PruningPass<'_>,
    camera: usize,
    pixel: usize,
    best: &BestCandidates,
    lane: usize,
    disputes: &mut Vec<Dispute>,
) -> Verdict {
    if pass.status(camera, pixel as u32) == DROPPED {
        return Verdict::without_witness(Rule::MixedDropped);
    }
    let winners = best.winners(lane);
    if winners[0] != winners[1] {
        disputes.push(Dispute { pixel: pixel as u32, camera: winners[0], other_camera: winners[1] });
    }
    if let Some(candidate) = best.candidate(lane) {
        return Verdict::dropped_for(pass.settings.pruning.method, best.own_rank[lane], candidate);
    }
    pass.set_status(camera, pixel as u32, KEPT);
    Verdict::without_witness(rule_of_kept(best.passed_over[lane] != 0, best.seen[lane] != 0))
}
