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

use rayon::prelude::*;

use super::coverage::{Unsettled, settle_all};
use super::decision::{LevelVerdicts, Rule, Verdict};
use super::find_best::{AskOthers, BetweenParts, FindBest, SearchBand, conclude, find_thin};
use super::pass::{PruningPass, Statuses, UNDECIDED, all_may_be_witnesses, has_deeper, mark_undecided};
use crate::capture::overlap::OverlapGraph;
use crate::error::Result;
use crate::job::Job;
use crate::preprocess::layers::{CameraLayer, RatedSamples};
use crate::preprocess::temporal::SpanLevel;
use crate::settings::Settings;
use crate::simd;

/// Rows that one task works on.
pub(crate) const BAND_ROWS: usize = 16;

/// Decides every sample of `level`; samples of other levels take part with their `statuses`, which stay as they are.
///
/// Levels are decided in ascending order, from the span of all frames down to the frame.
///
/// # Errors
/// `Cancelled`.
pub(crate) fn prune(
    pairs: &OverlapGraph<'_>,
    layers: &[CameraLayer],
    statuses: &Statuses,
    level: SpanLevel,
    settings: &Settings,
    job: &Job,
) -> Result<Vec<LevelVerdicts>> {
    let samples: Vec<RatedSamples> =
        layers.par_iter().map(|layer| RatedSamples::of_level(layer, level)).collect();
    samples.par_iter().zip(statuses).for_each(|(samples, statuses)| {
        mark_undecided(samples, statuses, settings.pruning.mixed_pixels);
    });
    let count = samples.iter().map(RatedSamples::len).sum();
    let may_be_witnesses = all_may_be_witnesses(statuses, level, count, settings);
    let pass = PruningPass {
        has_deeper: has_deeper(layers, level),
        ..PruningPass::new(pairs, layers, statuses, level, &may_be_witnesses, settings)
    };
    let mut searches: Vec<Search<'_>> =
        samples.iter().enumerate().map(|(camera, samples)| Search::new(camera, samples, false)).collect();
    find(&pass, &mut searches, true, job)?;
    let mut unsettled: Vec<Unsettled<'_>> = searches.into_iter().map(Search::into_unsettled).collect();
    settle_all(&pass, &mut unsettled, job)?;
    let decided = unsettled.into_iter().zip(&samples).map(|(unsettled, samples)| {
        let mut decided = unsettled.decided;
        decided.count_mixed(&samples.ranks, settings.pruning.mixed_pixels);
        decided
    });
    Ok(decided.collect())
}

/// The samples of one camera while their best candidates are looked for.
pub(crate) struct Search<'a> {
    pub(crate) camera: usize,
    samples: &'a RatedSamples,
    pub(crate) decided: LevelVerdicts,
    between: Vec<BetweenParts>,
}

impl<'a> Search<'a> {
    /// Nothing is found yet. Where the layers of other cameras are there only part by part, `in_parts`, more is kept between them.
    pub(crate) fn new(camera: usize, samples: &'a RatedSamples, in_parts: bool) -> Self {
        let decided = LevelVerdicts {
            pixels: samples.pixels.clone(),
            verdicts: vec![Verdict::without_witness(Rule::NoSample); samples.len()],
            ..LevelVerdicts::default()
        };
        let between = vec![BetweenParts::default(); if in_parts { samples.len() } else { 0 }];
        Self { camera, samples, decided, between }
    }

    /// Some samples that would be kept by these verdicts, if the others do not contradict them.
    pub(crate) fn of_asked(camera: usize, samples: &'a RatedSamples, verdicts: Vec<Verdict>) -> Self {
        let search = Self::new(camera, samples, true);
        Self { decided: LevelVerdicts { verdicts, ..search.decided }, ..search }
    }

    /// Whether other cameras contradict each sample, once all have voted.
    pub(crate) fn contradicted(&self, pass: &PruningPass<'_>) -> Vec<bool> {
        let samples = self.between.iter().zip(&self.samples.packed_colors);
        samples.map(|(known, color)| pass.votes.is_contradicted(known.votes, color.is_flying())).collect()
    }

    /// The rows of the camera, cut into bands that hold something to decide.
    fn bands(&mut self) -> Vec<SearchBand<'_>> {
        let Self { camera, samples, decided, between } = self;
        let (camera, samples) = (*camera, *samples);
        let last_row = samples.pixels.last().map_or(0, |pixel| *pixel as usize / samples.width.max(1) + 1);
        let (mut verdicts, mut between) = (&mut decided.verdicts[..], &mut between[..]);
        let mut bands = Vec::new();
        for row in (0..last_row).step_by(BAND_ROWS) {
            let rows = row..(row + BAND_ROWS).min(last_row);
            let of_band = samples.within_rows(rows.clone());
            let (own_verdicts, rest) = verdicts.split_at_mut(of_band.len());
            verdicts = rest;
            let (own_between, rest) = between.split_at_mut(of_band.len().min(between.len()));
            between = rest;
            if !of_band.is_empty() {
                let first = of_band.start;
                bands.push(SearchBand {
                    camera,
                    rows,
                    samples,
                    first,
                    verdicts: own_verdicts,
                    between: own_between,
                });
            }
        }
        bands
    }

    /// What was found, before any of it is settled.
    pub(crate) fn into_unsettled(self) -> Unsettled<'a> {
        Unsettled::new(self.camera, self.decided, self.samples)
    }
}

/// Does something with every band of some searches.
fn each_band<'s, 'a: 's>(
    searches: impl Iterator<Item = &'s mut Search<'a>>,
    job: &Job,
    work: impl Fn(&mut SearchBand<'_>) + Sync,
) -> Result<()> {
    let mut bands: Vec<SearchBand<'_>> = searches.flat_map(Search::bands).collect();
    bands.par_iter_mut().try_for_each(|band| {
        job.check()?;
        work(band);
        Ok(())
    })
}

/// Finds the best candidates in the layers that are there. A search of one part ends with the verdicts as if all candidates were kept.
///
/// # Errors
/// `Cancelled`.
pub(crate) fn find(
    pass: &PruningPass<'_>,
    searches: &mut [Search<'_>],
    is_first: bool,
    job: &Job,
) -> Result<()> {
    each_band(searches.iter_mut(), job, |band| simd::run(FindBest { pass, band, is_first }))
}

/// Finds thin samples among those without a candidate, for cameras whose own layers are there: votes depend on it.
///
/// # Errors
/// `Cancelled`.
pub(crate) fn look_at_own(pass: &PruningPass<'_>, searches: &mut [Search<'_>], job: &Job) -> Result<()> {
    each_band(searches.iter_mut(), job, |band| find_thin(pass, band))
}

/// Lets the cameras of `part`, whose layers are there, vote on samples without a candidate.
///
/// # Errors
/// `Cancelled`.
pub(crate) fn ask_others(
    pass: &PruningPass<'_>,
    searches: &mut [Search<'_>],
    part: &[usize],
    job: &Job,
) -> Result<()> {
    let seen =
        searches.iter_mut().filter(|search| pass.pairs.others_among(search.camera, part).next().is_some());
    each_band(seen, job, |band| simd::run(AskOthers { pass, band }))
}

/// The samples without a candidate whose verdicts a search in parts left open, ascending.
pub(crate) fn left_open(pass: &PruningPass<'_>, camera: usize, decided: &LevelVerdicts) -> Vec<u32> {
    let is_open = |index: &u32| {
        let (pixel, verdict) = (decided.pixels[*index as usize], &decided.verdicts[*index as usize]);
        verdict.witness_camera == Verdict::NO_CAMERA && pass.status(camera, pixel) == UNDECIDED
    };
    (0..decided.pixels.len() as u32).filter(is_open).collect()
}

/// Ends a search in parts: gives the verdicts as if all candidates were kept. Where others vote and have not done so, those on samples
/// without a candidate are left open.
///
/// # Errors
/// `Cancelled`.
pub(crate) fn conclude_all(
    pass: &PruningPass<'_>,
    searches: &mut [Search<'_>],
    have_voted: bool,
    job: &Job,
) -> Result<()> {
    each_band(searches.iter_mut(), job, |band| conclude(pass, band, have_voted))
}
