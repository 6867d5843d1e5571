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

use std::ops::Range;
use std::sync::atomic::{AtomicU8, Ordering};

use rayon::prelude::*;

use super::contest::{Contest, Witnesses};
use super::facet::MIXED;
use super::layer::{Layer, Level, NO_SAMPLE};
use super::registration::{Block, LANES, Outcome, Registration, SameSurface};
use super::{Rule, Verdict};
use crate::capture::Camera;
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
const BAND_ROWS: usize = 16;

/// All cameras and every way between two of them.
pub struct Rig<'a> {
    cameras: &'a [Camera],
    /// `[source * cameras + target]`.
    registrations: Vec<Registration>,
}

impl<'a> Rig<'a> {
    /// All pairs of `cameras`.
    #[must_use]
    pub fn new(cameras: &'a [Camera]) -> Self {
        let registrations = cameras
            .iter()
            .flat_map(|source| cameras.iter().map(move |target| Registration::new(source, target)))
            .collect();
        Self { cameras, registrations }
    }

    /// From camera `source` to camera `target`.
    #[must_use]
    pub fn registration(&self, source: usize, target: usize) -> &Registration {
        &self.registrations[source * self.cameras.len() + target]
    }

    /// The cameras.
    #[must_use]
    pub fn cameras(&self) -> &'a [Camera] {
        self.cameras
    }
}

/// The verdicts on one camera's samples of one level.
#[derive(Clone, Debug, Default)]
pub struct Decided {
    /// Pixels that were decided, `y * width + x`, ascending.
    pub pixels: Vec<u32>,
    /// One verdict per pixel.
    pub verdicts: Vec<Verdict>,
    /// Where the other rate model would have named another camera, by pixel.
    pub disputes: Vec<Dispute>,
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
    let pass = Pass {
        rig,
        layers,
        statuses,
        decide,
        settings,
        limits: SameSurface::new(settings),
        all_stand: layers
            .par_iter()
            .zip(statuses)
            .map(|(layer, statuses)| all_stand(layer, statuses, decide, settings.pruning.across_spans))
            .collect(),
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
        bands.par_iter_mut().for_each(|band| pass.settle_waiting(band));
    }
    let disputes: Vec<(usize, Vec<Dispute>)> =
        bands.into_iter().map(|band| (band.camera, band.disputes)).collect();
    for (camera, disputes) in disputes {
        decided[camera].disputes.extend(disputes);
    }
    Ok(decided)
}

/// Marks the samples of level `decide` as undecided, mixed ones as dropped where they are to be. Gives how many there are in
/// each band of rows.
fn open(layer: &Layer, statuses: &[AtomicU8], decide: Level, mixed_pixels: MixedPixels) -> Vec<usize> {
    let band = (BAND_ROWS * layer.width).max(1);
    let mut counts = Vec::with_capacity(layer.level.len().div_ceil(band));
    for (band_of, (levels, statuses)) in layer.level.chunks(band).zip(statuses.chunks(band)).enumerate() {
        let mut count = 0;
        for (i, (&level, status)) in levels.iter().zip(statuses).enumerate() {
            if level == decide {
                count += 1;
                let drop =
                    mixed_pixels == MixedPixels::Drop && layer.facets[band_of * band + i].rank & MIXED != 0;
                status.store(if drop { DROPPED } else { UNDECIDED }, Ordering::Relaxed);
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
        stand &= (level == NO_SAMPLE) | (stands & ((level == decide) | across_spans));
    }
    stand
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
    rig: &'a Rig<'a>,
    pub(super) layers: &'a [Layer],
    statuses: &'a Statuses,
    decide: Level,
    settings: &'a Settings,
    limits: SameSurface,
    /// Per camera, see [`all_stand`].
    pub(super) all_stand: Vec<bool>,
}

/// Some rows of one camera: the samples to decide and what is known of each. Until it is settled, a verdict names the
/// sample's best candidate as if that one were kept.
struct Band<'a> {
    camera: usize,
    rows: Range<usize>,
    pixels: &'a mut [u32],
    verdicts: &'a mut [Verdict],
    disputes: Vec<Dispute>,
    waiting: Vec<Waiting>,
}

/// A sample whose candidate is undecided yet.
struct Waiting {
    /// Index into the band's pixels.
    index: u32,
    /// All candidates, worst first; found only where the best was dropped. The verdict names the one that is waited for.
    others: Option<Vec<Candidate>>,
}

/// A better sample of a point, in the order in which they win.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Candidate {
    rank: u32,
    camera: u16,
    pixel: u32,
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
        let columns = layer.width.div_ceil(LANES);
        let witnesses: Vec<Witnesses> = if pruning { pass.witnesses(band) } else { Vec::new() };
        let mut next = 0;
        for row in band.rows.clone() {
            for at in 0..columns {
                let lanes = lanes_at_level(layer, at * LANES, row, pass.decide);
                if lanes == 0 {
                    continue;
                }
                let contest = if pruning {
                    let block = Block::new(layer, at * LANES, row, lanes);
                    Some(Contest::hold(pass, band.camera, &block, &witnesses[at]))
                } else {
                    None
                };
                for lane in (0..LANES).filter(|lane| lanes >> lane & 1 == 1) {
                    let pixel = row * layer.width + at * LANES + lane;
                    let verdict = match &contest {
                        Some(contest) => {
                            pass.first_verdict(band.camera, pixel, contest, lane, &mut band.disputes)
                        }
                        None => pass.verdict_without_pruning(band.camera, pixel),
                    };
                    band.pixels[next] = pixel as u32;
                    band.verdicts[next] = verdict;
                    next += 1;
                }
            }
        }
    }
}

/// Which of sixteen pixels hold a sample of the level.
#[inline(always)]
fn lanes_at_level(layer: &Layer, column: usize, row: usize, level: Level) -> u32 {
    let first = row * layer.width + column;
    let count = LANES.min(layer.width - column);
    let found = &layer.level[first..first + count];
    // Of a known length, which takes one instruction.
    let levels = <[Level; LANES]>::try_from(found).unwrap_or_else(|_| {
        let mut levels = [NO_SAMPLE; LANES];
        levels[..count].copy_from_slice(found);
        levels
    });
    let mut lanes = 0;
    for (lane, &found) in levels.iter().enumerate() {
        lanes |= u32::from(found == level) << lane;
    }
    lanes
}

impl Pass<'_> {
    pub(super) fn status(&self, camera: usize, pixel: u32) -> u8 {
        self.statuses[camera][pixel as usize].load(Ordering::Relaxed)
    }

    fn set_status(&self, camera: usize, pixel: u32, status: u8) {
        self.statuses[camera][pixel as usize].store(status, Ordering::Relaxed);
    }

    /// Whether a sample may stand for others, as far as is known before anything of this level is decided.
    #[inline(always)]
    pub(super) fn may_stand(&self, camera: usize, pixel: u32) -> bool {
        let status = self.status(camera, pixel);
        let foreign = self.layers[camera].level[pixel as usize] != self.decide;
        (status == UNDECIDED || status == KEPT) && (self.settings.pruning.across_spans || !foreign)
    }

    /// For every sixteen columns of the band, the other cameras that may see something of it.
    #[inline(always)]
    fn witnesses(&self, band: &Band<'_>) -> Vec<Witnesses<'_>> {
        let layer = &self.layers[band.camera];
        let rows = [band.rows.start, band.rows.end - 1];
        let blocks: Vec<[f32; 2]> = (0..layer.width.div_ceil(LANES))
            .map(|at| depth_bounds(layer, at * LANES, band.rows.clone(), self.decide))
            .collect();
        let whole = blocks
            .iter()
            .fold([f32::INFINITY, 0.0_f32], |all, block| [all[0].min(block[0]), all[1].max(block[1])]);
        let of_the_band: Vec<usize> = (0..self.layers.len())
            .filter(|&other| {
                other != band.camera
                    && !self.layers[other].facets.is_empty()
                    && self.rig.registration(band.camera, other).may_see([0, layer.width - 1], rows, whole)
            })
            .collect();
        let blocks = blocks.iter().enumerate();
        blocks
            .map(|(at, &bounds)| {
                if bounds[0] > bounds[1] {
                    return Witnesses::new();
                }
                let columns = [at * LANES, (at * LANES + LANES).min(layer.width) - 1];
                let seen = of_the_band.iter().copied().filter(|&other| {
                    self.rig.registration(band.camera, other).may_see(columns, rows, bounds)
                });
                seen.map(|other| {
                    let limits = self.limits.between(layer, &self.layers[other]);
                    (other, self.rig.registration(band.camera, other), limits)
                })
                .collect()
            })
            .collect()
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
        let winners = contest.winners(lane).map(|winner| winner.unwrap_or(camera as u32) as u16);
        if winners[0] != winners[1] {
            disputes.push(Dispute { pixel: pixel as u32, camera: winners[0], other_camera: winners[1] });
        }
        if let Some(best) = contest.best(lane) {
            let best = Candidate { rank: best.rank, camera: best.camera as u16, pixel: best.pixel };
            return self.dropped_for(self.layers[camera].facets[pixel].rank, best);
        }
        self.set_status(camera, pixel as u32, KEPT);
        Verdict::without_witness(if contest.is_seen(lane) { Rule::BestRate } else { Rule::OnlyWitness })
    }

    #[inline(always)]
    fn dropped_for(&self, rank: u32, witness: Candidate) -> Verdict {
        let rule = if self.settings.pruning.method == PruningMethod::FirstCamera {
            Rule::LaterCamera
        } else if rank & MIXED != 0 && witness.rank & MIXED == 0 {
            Rule::MixedYields
        } else if witness.rank == rank {
            Rule::Tie
        } else {
            Rule::LowerRate
        };
        Verdict {
            rule,
            witness_level: self.layers[witness.camera as usize].level[witness.pixel as usize],
            witness_camera: witness.camera,
            witness_pixel: witness.pixel,
        }
    }

    /// Decides every sample of the band whose best candidate is decided; the others wait.
    fn settle(&self, band: &mut Band<'_>) {
        for index in 0..band.pixels.len() {
            let verdict = band.verdicts[index];
            if verdict.witness_camera == Verdict::NO_CAMERA {
                continue;
            }
            if self.status(verdict.witness_camera as usize, verdict.witness_pixel) == KEPT {
                self.set_status(band.camera, band.pixels[index], DROPPED);
            } else {
                band.waiting.push(Waiting { index: index as u32, others: None });
            }
        }
    }

    /// Decides what can be decided of the samples that wait.
    fn settle_waiting(&self, band: &mut Band<'_>) {
        let mut waiting = std::mem::take(&mut band.waiting);
        waiting.retain_mut(|sample| self.still_waits(band, sample));
        band.waiting = waiting;
    }

    fn still_waits(&self, band: &mut Band<'_>, sample: &mut Waiting) -> bool {
        let pixel = band.pixels[sample.index as usize];
        let verdict = &mut band.verdicts[sample.index as usize];
        loop {
            match self.status(verdict.witness_camera as usize, verdict.witness_pixel) {
                KEPT => {
                    self.set_status(band.camera, pixel, DROPPED);
                    return false;
                }
                UNDECIDED => return true,
                _ => {}
            }
            let others = sample.others.get_or_insert_with(|| self.all_but_the_best(band.camera, pixel));
            let Some(next) = others.pop() else {
                *verdict = Verdict::without_witness(Rule::Coverage);
                self.set_status(band.camera, pixel, KEPT);
                return false;
            };
            *verdict = self.dropped_for(self.layers[band.camera].facets[pixel as usize].rank, next);
        }
    }

    /// All candidates of a sample but the best, worst first.
    fn all_but_the_best(&self, camera: usize, pixel: u32) -> Vec<Candidate> {
        let layer = &self.layers[camera];
        let (x, y) = (pixel as usize % layer.width, pixel as usize / layer.width);
        let rank = layer.facets[pixel as usize].rank;
        let mut candidates = Vec::new();
        for other in (0..self.layers.len()).filter(|other| *other != camera) {
            let target = &self.layers[other];
            if target.facets.is_empty() {
                continue;
            }
            let registration = self.rig.registration(camera, other);
            let Outcome::Same(found) = registration.test(layer, target, x, y, &self.limits) else { continue };
            let found_rank = target.facets[found as usize].rank;
            let own_level = target.level[found as usize] == self.decide;
            // What is dropped by now is still a candidate; it will be passed over.
            if (own_level || self.may_stand(other, found)) && (found_rank, other) < (rank, camera) {
                candidates.push(Candidate { rank: found_rank, camera: other as u16, pixel: found });
            }
        }
        candidates.sort_unstable_by(|a, b| b.cmp(a));
        candidates.pop();
        candidates
    }
}

/// The smallest and largest inverse depth of the samples of a level in sixteen columns of some rows; the smallest is larger
/// where there is none.
#[inline(always)]
fn depth_bounds(layer: &Layer, column: usize, rows: Range<usize>, level: Level) -> [f32; 2] {
    let count = LANES.min(layer.width - column);
    let (mut smallest, mut largest) = ([f32::INFINITY; LANES], [0.0_f32; LANES]);
    for row in rows {
        let lanes = lanes_at_level(layer, column, row, level);
        if lanes == 0 {
            continue;
        }
        let first = row * layer.width + column;
        for (lane, &w) in layer.inverse_depth[first..first + count].iter().enumerate() {
            let wanted = lanes >> lane & 1 == 1;
            smallest[lane] = smallest[lane].min(if wanted { w } else { f32::INFINITY });
            largest[lane] = largest[lane].max(if wanted { w } else { 0.0 });
        }
    }
    [smallest.iter().copied().fold(f32::INFINITY, f32::min), largest.iter().copied().fold(0.0, f32::max)]
}

impl Decided {
    fn of_size(count: usize) -> Self {
        Self {
            pixels: vec![0; count],
            verdicts: vec![Verdict::without_witness(Rule::NoSample); count],
            disputes: Vec::new(),
        }
    }
}
