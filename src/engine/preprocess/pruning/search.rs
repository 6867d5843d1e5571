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
//! see the rectangle in which they lie. The conditions of the rules are in `decision.rs`.

use std::sync::atomic::{AtomicU8, Ordering};

use rayon::prelude::*;

use super::coverage::{ResolvePending, resolve};
use super::decision::{LevelVerdicts, is_dropped_as_mixed, may_be_witness};
use super::find_best::FindBest;
use super::pass::{BAND_ROWS, DROPPED, KEPT, PruningPass, SearchBand, Statuses, UNDECIDED};
use crate::error::Result;
use crate::job::Job;
use crate::preprocess::agreement::VoteTest;
use crate::preprocess::layers::CameraLayer;
use crate::preprocess::registration::{CameraPairs, SameSurface};
use crate::preprocess::temporal::{NO_SAMPLE, ROOT, SpanLevel};
use crate::settings::{MixedPixels, Settings};
use crate::simd;

/// Decides every sample of `level`; samples of other levels take part with their `statuses`, which stay as they are.
///
/// Levels are decided in ascending order, from the span of all frames down to the frame.
///
/// # Errors
/// `Cancelled`.
pub fn prune(
    pairs: &CameraPairs<'_>,
    layers: &[CameraLayer],
    statuses: &Statuses,
    level: SpanLevel,
    settings: &Settings,
    job: &Job,
) -> Result<Vec<LevelVerdicts>> {
    let each = || layers.par_iter().zip(statuses);
    let mark = |(layer, statuses): (&CameraLayer, &Vec<AtomicU8>)| {
        mark_undecided(layer, statuses, level, settings.pruning.mixed_pixels)
    };
    let counts: Vec<Vec<usize>> = each().map(mark).collect();
    let mut decided: Vec<LevelVerdicts> =
        counts.iter().map(|counts| LevelVerdicts::of_size(counts.iter().sum())).collect();
    let samples: usize = decided.iter().map(|decided| decided.pixels.len()).sum();
    let is_dense = samples > layers.iter().map(|layer| layer.level.len()).sum::<usize>() / DENSE_SHARE;
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
    find_best(&pass, &mut bands, job)?;
    bands.par_iter_mut().for_each(|band| resolve(&pass, band));
    while bands.iter().any(|band| !band.pending.is_empty()) {
        job.check()?;
        bands.par_iter_mut().for_each(|band| simd::run(ResolvePending { pass: &pass, band }));
    }
    if settings.pruning.mixed_pixels != MixedPixels::Keep {
        decided.par_iter_mut().zip(layers).for_each(|(decided, layer)| decided.count_mixed(layer));
    }
    Ok(decided)
}

/// Finds the best candidate of every sample of some bands.
fn find_best(pass: &PruningPass<'_>, bands: &mut [SearchBand<'_>], job: &Job) -> Result<()> {
    bands.par_iter_mut().try_for_each(|band| {
        job.check()?;
        simd::run(FindBest { pass, band });
        Ok(())
    })
}

/// The pass over a capture with samples of all frames only, before anything is decided.
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
pub(crate) fn find(pass: &PruningPass<'_>, cameras: &[usize], job: &Job) -> Result<Vec<LevelVerdicts>> {
    let mark = |&camera: &usize| {
        let mixed_pixels = pass.settings.pruning.mixed_pixels;
        mark_undecided(&pass.layers[camera], &pass.statuses[camera], pass.level, mixed_pixels)
    };
    let counts: Vec<Vec<usize>> = cameras.par_iter().map(mark).collect();
    let mut decided: Vec<LevelVerdicts> =
        counts.iter().map(|counts| LevelVerdicts::of_size(counts.iter().sum())).collect();
    let each = cameras.iter().zip(counts.iter().zip(&mut decided));
    let mut bands: Vec<_> =
        each.flat_map(|(&camera, (counts, decided))| bands(pass.layers, camera, counts, decided)).collect();
    find_best(pass, &mut bands, job)?;
    Ok(decided)
}

/// Pixels that are passed over at once.
const RUN: usize = 64;

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
                    let is_dropped = is_dropped_as_mixed(mixed_pixels, layer.ranks[first + i]);
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
    decided: &'a mut LevelVerdicts,
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
            pending: Vec::new(),
        });
    }
    bands
}
