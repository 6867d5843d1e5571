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
use std::ops::Range;
use std::sync::atomic::{AtomicU8, Ordering};

use rayon::prelude::*;

use super::contest::{Contest, Entry, Rival, Way, hold_row, lanes_at, rivals};
use super::facet::{MIXED, UNSURE};
use super::layer::{Layer, Level, NO_SAMPLE};
use super::registration::{Block, LANES, SameSurface};
pub use super::rig::Rig;
use super::settle::{Candidate, SettleWaiting, Waiting};
use super::{Rule, Verdict};
use crate::error::Result;
use crate::job::Job;
use crate::settings::{MixedPixels, PruningMethod, Settings};
use crate::simd::{self, Work};

/// No sample at the pixel that could stand for another.
pub const ABSENT: u8 = 0;
/// Waiting for better samples to be decided.
pub(super) const UNDECIDED: u8 = 1;
/// Stays.
pub const KEPT: u8 = 2;
/// Was dropped.
pub const DROPPED: u8 = 3;

/// Rows that one task works on.
pub(super) const BAND_ROWS: usize = 16;

/// The verdicts on one camera's samples of one level.
#[derive(Clone, Debug, Default)]
pub struct Decided {
    /// Pixels that were decided, `y * width + x`, ascending.
    pub pixels: Vec<u32>,
    /// One verdict per pixel.
    pub verdicts: Vec<Verdict>,
    /// Where the other rate model would have named another camera, by pixel.
    pub disputes: Vec<Dispute>,
    /// Samples whose color was found to be blended across a silhouette.
    pub mixed: u64,
    /// How many of them are kept.
    pub mixed_kept: u64,
}

/// A sample of whose point the two rate models name different cameras as the best-sampled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Dispute {
    /// The pixel, `y * width + x`.
    pub pixel: u32,
    /// The camera that the model in use names.
    pub camera: u16,
    /// The camera that the other model names.
    pub other_camera: u16,
}

/// Whether each pixel of each camera holds a kept sample: [`ABSENT`], [`KEPT`] or [`DROPPED`].
pub type Statuses = Vec<Vec<AtomicU8>>;

/// Statuses in which nothing is decided yet.
#[must_use]
pub fn no_statuses(layers: &[Layer]) -> Statuses {
    layers.iter().map(|layer| layer.level.iter().map(|_| AtomicU8::new(ABSENT)).collect()).collect()
}

/// Decides every sample of level `decide`; samples of other levels take part as `statuses` says and stay as they are.
///
/// Levels are decided in ascending order, from the span of all frames down to the frame.
///
/// # Errors
/// `Cancelled`.
pub fn prune(
    rig: &Rig<'_>,
    layers: &[Layer],
    statuses: &Statuses,
    decide: Level,
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
    bands.par_iter_mut().for_each(|band| pass.settle(band));
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
fn open(layer: &Layer, statuses: &[AtomicU8], decide: Level, mixed_pixels: MixedPixels) -> Vec<usize> {
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
fn all_stand(layer: &Layer, statuses: &[AtomicU8], decide: Level, across_spans: bool) -> bool {
    let mut stand = true;
    for (&level, status) in layer.level.iter().zip(statuses) {
        let status = status.load(Ordering::Relaxed);
        let stands = (status == UNDECIDED) | (status == KEPT);
        stand &= (level > decide) | (stands & ((level == decide) | across_spans));
    }
    stand
}

fn has_deeper(layer: &Layer, decide: Level) -> bool {
    let mut deeper = false;
    for &level in &layer.level {
        deeper |= (level > decide) & (level != NO_SAMPLE);
    }
    deeper
}

/// The rows of every camera, cut into bands that hold something to decide.
fn bands<'a>(layers: &[Layer], counts: &[Vec<usize>], decided: &'a mut [Decided]) -> Vec<Band<'a>> {
    let mut bands = Vec::new();
    for (camera, (decided, counts)) in decided.iter_mut().zip(counts).enumerate() {
        let (mut pixels, mut verdicts) = (&mut decided.pixels[..], &mut decided.verdicts[..]);
        for (index, &count) in counts.iter().enumerate().filter(|(_, count)| **count > 0) {
            let first_row = index * BAND_ROWS;
            let (own_pixels, rest) = pixels.split_at_mut(count);
            pixels = rest;
            let (own_verdicts, rest) = verdicts.split_at_mut(count);
            verdicts = rest;
            bands.push(Band {
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

/// What all bands share.
pub(super) struct Pass<'a> {
    pub(super) rig: &'a Rig<'a>,
    pub(super) layers: &'a [Layer],
    pub(super) statuses: &'a Statuses,
    pub(super) decide: Level,
    settings: &'a Settings,
    pub(super) limits: SameSurface,
    /// Per camera, see [`all_stand`].
    pub(super) all_stand: Vec<bool>,
    /// Per camera, whether it holds samples of deeper levels than the one that is decided.
    has_deeper: Vec<bool>,
}

/// Some rows of one camera: the samples to decide and what is known of each. Until it is settled, a verdict names the
/// sample's best candidate as if that one were kept.
pub(super) struct Band<'a> {
    pub(super) camera: usize,
    rows: Range<usize>,
    pub(super) pixels: &'a mut [u32],
    pub(super) verdicts: &'a mut [Verdict],
    disputes: Vec<Dispute>,
    pub(super) waiting: Vec<Waiting>,
}

/// Finds the best candidate of every sample of a band.
struct FindBest<'a, 'b> {
    pass: &'a Pass<'a>,
    band: &'a mut Band<'b>,
}

impl Work for FindBest<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { pass, band } = self;
        let layer = &pass.layers[band.camera];
        let pruning = pass.settings.pruning.method != PruningMethod::Off;
        let lanes = band.lanes(layer, pass.decide);
        let mut rivals = if pruning { pass.rivals(band, &lanes) } else { Vec::new() };
        let mut entries = Vec::new();
        let mut ways: Vec<Way> = (0..layer.width.div_ceil(LANES)).map(|_| Way::NOWHERE).collect();
        let mut next = 0;
        for (row, lanes) in band.rows.clone().zip(lanes.chunks_exact(layer.width.div_ceil(LANES))) {
            entries.clear();
            for (at, &lanes) in lanes.iter().enumerate().filter(|(_, lanes)| **lanes != 0) {
                let block = Block::new(layer, at * LANES, row, lanes);
                entries.push(Entry { at, lanes, contest: Contest::new(&block, band.camera), block });
            }
            // One rival after the other, so that its picture is read along its rows.
            for rival in &mut rivals {
                hold_row(pass, band.camera, &mut entries, rival, &mut ways);
            }
            rivals.sort_by_key(|rival| Reverse(rival.told));
            for Entry { at, lanes, contest, .. } in &entries {
                for lane in (0..LANES).filter(|lane| lanes >> lane & 1 == 1) {
                    let pixel = row * layer.width + at * LANES + lane;
                    let verdict = if pruning {
                        pass.first_verdict(band.camera, pixel, contest, lane, &mut band.disputes)
                    } else {
                        pass.verdict_without_pruning(band.camera, pixel)
                    };
                    band.pixels[next] = pixel as u32;
                    band.verdicts[next] = verdict;
                    next += 1;
                }
            }
        }
    }
}

impl Band<'_> {
    /// For each row and each sixteen pixels of it, which of them hold a sample of the level.
    #[inline(always)]
    fn lanes(&self, layer: &Layer, level: Level) -> Vec<u32> {
        let mut all = Vec::with_capacity(self.rows.len() * layer.width.div_ceil(LANES));
        for row in self.rows.clone() {
            for column in (0..layer.width).step_by(LANES) {
                all.push(lanes_at(layer, (column, row), |found| found == level));
            }
        }
        all
    }
}

impl Pass<'_> {
    pub(super) fn status(&self, camera: usize, pixel: u32) -> u8 {
        self.statuses[camera][pixel as usize].load(Ordering::Relaxed)
    }

    pub(super) fn set_status(&self, camera: usize, pixel: u32, status: u8) {
        self.statuses[camera][pixel as usize].store(status, Ordering::Relaxed);
    }

    /// The other cameras that may see something of the band.
    #[inline(always)]
    fn rivals(&self, band: &Band<'_>, lanes: &[u32]) -> Vec<Rival<'_>> {
        rivals(self.rig, self.layers, (band.camera, band.rows.clone()), lanes, |other| {
            self.limits
                .between(&self.layers[band.camera], &self.layers[other])
                .with_deeper(self.has_deeper[other])
        })
    }

    /// Whether a sample may stand for others, as far as is known before anything of this level is decided.
    #[inline(always)]
    pub(super) fn may_stand(&self, camera: usize, pixel: u32) -> bool {
        let status = self.status(camera, pixel);
        let foreign = self.layers[camera].level[pixel as usize] != self.decide;
        (status == UNDECIDED || status == KEPT) && (self.settings.pruning.across_spans || !foreign)
    }

    fn verdict_without_pruning(&self, camera: usize, pixel: usize) -> Verdict {
        if self.status(camera, pixel as u32) == DROPPED {
            return Verdict::without_witness(Rule::MixedDropped);
        }
        self.set_status(camera, pixel as u32, KEPT);
        Verdict::without_witness(Rule::PruningOff)
    }

    /// The verdict on a sample if its best candidate is kept. Keeps the sample where there is none.
    #[inline(always)]
    fn first_verdict(
        &self,
        camera: usize,
        pixel: usize,
        contest: &Contest,
        lane: usize,
        disputes: &mut Vec<Dispute>,
    ) -> Verdict {
        if self.status(camera, pixel as u32) == DROPPED {
            return Verdict::without_witness(Rule::MixedDropped);
        }
        let winners = contest.winners(lane);
        if winners[0] != winners[1] {
            disputes.push(Dispute { pixel: pixel as u32, camera: winners[0], other_camera: winners[1] });
        }
        if let Some(best) = contest.best(lane) {
            let best =
                Candidate { rank: best.rank, camera: best.camera, level: best.level, pixel: best.pixel };
            return self.dropped_for(contest.own_rank(lane), best);
        }
        self.set_status(camera, pixel as u32, KEPT);
        Verdict::without_witness(match (contest.passed_over_a_better(lane), contest.is_seen(lane)) {
            (true, _) => Rule::Coverage,
            (false, true) => Rule::BestRate,
            (false, false) => Rule::OnlyWitness,
        })
    }

    #[inline(always)]
    pub(super) fn dropped_for(&self, rank: u32, witness: Candidate) -> Verdict {
        Verdict {
            rule: rule_between(self.settings.pruning.method, rank, witness.rank),
            witness_level: witness.level,
            witness_camera: witness.camera,
            witness_pixel: witness.pixel,
        }
    }
}

/// By which rule a sample of `rank` is dropped for one of `witness_rank`.
#[inline(always)]
pub(super) fn rule_between(method: PruningMethod, rank: u32, witness_rank: u32) -> Rule {
    if method == PruningMethod::FirstCamera {
        Rule::LaterCamera
    } else if rank & MIXED != 0 && witness_rank & MIXED == 0 {
        Rule::MixedYields
    } else if rank & UNSURE != 0 && witness_rank & UNSURE == 0 {
        Rule::UnsureYields
    } else if witness_rank == rank {
        Rule::Tie
    } else {
        Rule::LowerRate
    }
}

impl Decided {
    fn of_size(count: usize) -> Self {
        Self {
            pixels: vec![0; count],
            verdicts: vec![Verdict::without_witness(Rule::NoSample); count],
            disputes: Vec::new(),
            mixed: 0,
            mixed_kept: 0,
        }
    }

    fn count_mixed(&mut self, layer: &Layer) {
        for (pixel, verdict) in self.pixels.iter().zip(&self.verdicts) {
            let is_mixed = layer.ranks[*pixel as usize].rank & MIXED != 0;
            self.mixed += u64::from(is_mixed);
            self.mixed_kept += u64::from(is_mixed & verdict.is_kept());
        }
    }
}
