//! Pruning (the paper, §3.2): of all samples of one surface point the best-sampled one stays.
//!
//! Source: Interactive Dynamic Environments Using Image-Based Modeling and Rendering, §3.2, "keeping those pixels that have
//! the highest sampling rate". What differs: **coverage is guaranteed**. A sample is dropped only if a sample that is
//! *kept* stands for it. Pairwise comparison alone does not give that: A may be dropped for B, and B for C, where C does
//! not see A's point. Here every sample waits until all better samples of its point are decided; it is dropped if one of
//! them was kept, and kept otherwise. "Better" is a total order (rank, then camera index), so the waiting has no cycles
//! and the answer is the same whatever order or thread it is worked out in.
//!
//! ```text
//! candidates of p = samples of other cameras that show p's point and are better than p
//! p is dropped  ⇔  some candidate is kept
//! ```
//!
//! Nearly always the best candidate is kept, so only that one is looked for at first, for sixteen samples at a time; where it
//! turns out dropped, all candidates are found and tried in their order. Rectangles of samples that a camera cannot see are
//! not held against it.

use std::cmp::Reverse;
use std::sync::atomic::{AtomicU8, Ordering};

use rayon::prelude::*;

use super::best_candidate::{BestCandidates, OtherCamera, PendingRun, Way, hold_row, lanes_at, rivals};
use super::coverage::{SettleWaiting, settle};
use super::decision::{Decided, Dispute, Rule, Verdict};
use super::pass::{BAND_ROWS, Pass, SearchBand};
use super::status::{DROPPED, KEPT, Statuses, UNDECIDED};
use crate::error::Result;
use crate::job::Job;
use crate::preprocess::layers::{CameraLayer, MIXED};
use crate::preprocess::registration::{CameraPairs, LANES, PixelRun, SameSurface};
use crate::preprocess::temporal::{NO_SAMPLE, SpanLevel};
use crate::settings::{MixedPixels, PruningMethod, Settings};
use crate::simd::{self, VectorLoop};

/// Decides every sample of level `decide`; samples of other levels take part as `statuses` says and stay as they are.
///
/// Levels are decided in ascending order, from the span of all frames down to the frame.
///
/// # Errors
/// `Cancelled`.
pub fn prune(
    rig: &CameraPairs<'_>,
    layers: &[CameraLayer],
    statuses: &Statuses,
    decide: SpanLevel,
    settings: &Settings,
    job: &Job,
) -> Result<Vec<Decided>> {
    let counts: Vec<Vec<usize>> = layers
        .par_iter()
        .zip(statuses)
        .map(|(layer, statuses)| open(layer, statuses, decide, settings.pruning.mixed_pixels))
        .collect();
    let mut decided: Vec<Decided> =
        counts.iter().map(|counts| Decided::of_size(counts.iter().sum())).collect();
    let (samples, pixels) = (
        decided.iter().map(|decided| decided.pixels.len()).sum::<usize>(),
        layers.iter().map(|layer| layer.level.len()).sum::<usize>(),
    );
    let pass = Pass {
        rig,
        layers,
        statuses,
        decide,
        settings,
        limits: SameSurface::new(settings).at_level(decide),
        all_stand: layers
            .par_iter()
            .zip(statuses)
            .map(|(layer, statuses)| {
                samples > pixels / FEW && all_stand(layer, statuses, decide, settings.pruning.across_spans)
            })
            .collect(),
        has_deeper: layers.par_iter().map(|layer| has_deeper(layer, decide)).collect(),
    };
    let mut bands = bands(layers, &counts, &mut decided);
    bands.par_iter_mut().try_for_each(|band| {
        job.check()?;
        simd::run(FindBest { pass: &pass, band });
        Ok(())
    })?;
    bands.par_iter_mut().for_each(|band| settle(&pass, band));
    while bands.iter().any(|band| !band.waiting.is_empty()) {
        job.check()?;
        bands.par_iter_mut().for_each(|band| simd::run(SettleWaiting { pass: &pass, band }));
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

/// Pixels that are passed over at once.
const RUN: usize = 64;

/// Where fewer than one in so many pixels are to be decided, looking whether all others stand does not pay.
const FEW: usize = 8;

/// Marks the samples of level `decide` as undecided, mixed ones as dropped where they are to be. Gives how many there are in
/// each band of rows.
fn open(
    layer: &CameraLayer,
    statuses: &[AtomicU8],
    decide: SpanLevel,
    mixed_pixels: MixedPixels,
) -> Vec<usize> {
    let band = (BAND_ROWS * layer.width).max(1);
    let mut counts = Vec::with_capacity(layer.level.len().div_ceil(band));
    for (band_of, (levels, statuses)) in layer.level.chunks(band).zip(statuses.chunks(band)).enumerate() {
        let mut count = 0;
        let runs = levels.chunks(RUN).zip(statuses.chunks(RUN)).enumerate();
        // Most levels have few samples: runs without any are passed over sixteen or more bytes at a time.
        for (run, (levels, statuses)) in runs.filter(|(_, (levels, _))| levels.contains(&decide)) {
            let first = band_of * band + run * RUN;
            for (i, (&level, status)) in levels.iter().zip(statuses).enumerate() {
                if level == decide {
                    count += 1;
                    let drop = mixed_pixels == MixedPixels::Drop && layer.ranks[first + i].rank & MIXED != 0;
                    status.store(if drop { DROPPED } else { UNDECIDED }, Ordering::Relaxed);
                }
            }
        }
        counts.push(count);
    }
    counts
}

/// Whether every sample of the layer may stand for others, so that nobody needs to ask.
fn all_stand(layer: &CameraLayer, statuses: &[AtomicU8], decide: SpanLevel, across_spans: bool) -> bool {
    let mut stand = true;
    for (&level, status) in layer.level.iter().zip(statuses) {
        let status = status.load(Ordering::Relaxed);
        let stands = (status == UNDECIDED) | (status == KEPT);
        stand &= (level > decide) | (stands & ((level == decide) | across_spans));
    }
    stand
}

fn has_deeper(layer: &CameraLayer, decide: SpanLevel) -> bool {
    let mut deeper = false;
    for &level in &layer.level {
        deeper |= (level > decide) & (level != NO_SAMPLE);
    }
    deeper
}

/// The rows of every camera, cut into bands that hold something to decide.
fn bands<'a>(
    layers: &[CameraLayer],
    counts: &[Vec<usize>],
    decided: &'a mut [Decided],
) -> Vec<SearchBand<'a>> {
    let mut bands = Vec::new();
    for (camera, (decided, counts)) in decided.iter_mut().zip(counts).enumerate() {
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
                waiting: Vec::new(),
            });
        }
    }
    bands
}

/// Finds the best candidate of every sample of a band.
struct FindBest<'a, 'b> {
    pass: &'a Pass<'a>,
    band: &'a mut SearchBand<'b>,
}

impl VectorLoop for FindBest<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { pass, band } = self;
        let layer = &pass.layers[band.camera];
        let pruning = pass.settings.pruning.method != PruningMethod::Off;
        let lanes = lanes_of_band(band, layer, pass.decide);
        let mut rivals = if pruning { rivals_of(pass, band, &lanes) } else { Vec::new() };
        let mut entries = Vec::new();
        let mut ways: Vec<Way> = (0..layer.width.div_ceil(LANES)).map(|_| Way::NOWHERE).collect();
        let mut next = 0;
        for (row, lanes) in band.rows.clone().zip(lanes.chunks_exact(layer.width.div_ceil(LANES))) {
            entries.clear();
            for (at, &lanes) in lanes.iter().enumerate().filter(|(_, lanes)| **lanes != 0) {
                let block = PixelRun::new(layer, at * LANES, row, lanes);
                entries.push(PendingRun {
                    at,
                    lanes,
                    contest: BestCandidates::new(&block, band.camera),
                    block,
                });
            }
            // One rival after the other, so that its picture is read along its rows.
            for rival in &mut rivals {
                hold_row(pass, band.camera, &mut entries, rival, &mut ways);
            }
            rivals.sort_by_key(|rival| Reverse(rival.told));
            for PendingRun { at, lanes, contest, .. } in &entries {
                for lane in (0..LANES).filter(|lane| lanes >> lane & 1 == 1) {
                    let pixel = row * layer.width + at * LANES + lane;
                    let verdict = if pruning {
                        first_verdict(pass, band.camera, pixel, contest, lane, &mut band.disputes)
                    } else {
                        verdict_without_pruning(pass, band.camera, pixel)
                    };
                    band.pixels[next] = pixel as u32;
                    band.verdicts[next] = verdict;
                    next += 1;
                }
            }
        }
    }
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
fn rivals_of<'a>(pass: &Pass<'a>, band: &SearchBand<'_>, lanes: &[u32]) -> Vec<OtherCamera<'a>> {
    rivals(pass.rig, pass.layers, (band.camera, band.rows.clone()), lanes, |other| {
        pass.limits
            .between(&pass.layers[band.camera], &pass.layers[other])
            .with_deeper(pass.has_deeper[other])
    })
}

fn verdict_without_pruning(pass: &Pass<'_>, camera: usize, pixel: usize) -> Verdict {
    if pass.status(camera, pixel as u32) == DROPPED {
        return Verdict::without_witness(Rule::MixedDropped);
    }
    pass.set_status(camera, pixel as u32, KEPT);
    Verdict::without_witness(Rule::PruningOff)
}

/// The verdict on a sample if its best candidate is kept. Keeps the sample where there is none.
#[inline(always)]
fn first_verdict(
    pass: &Pass<'_>,
    camera: usize,
    pixel: usize,
    contest: &BestCandidates,
    lane: usize,
    disputes: &mut Vec<Dispute>,
) -> Verdict {
    if pass.status(camera, pixel as u32) == DROPPED {
        return Verdict::without_witness(Rule::MixedDropped);
    }
    let winners = contest.winners(lane);
    if winners[0] != winners[1] {
        disputes.push(Dispute { pixel: pixel as u32, camera: winners[0], other_camera: winners[1] });
    }
    if let Some(best) = contest.best(lane) {
        return pass.dropped_for(contest.own_rank(lane), best);
    }
    pass.set_status(camera, pixel as u32, KEPT);
    Verdict::without_witness(match (contest.passed_over_a_better(lane), contest.is_seen(lane)) {
        (true, _) => Rule::Coverage,
        (false, true) => Rule::BestRate,
        (false, false) => Rule::OnlyWitness,
    })
}
