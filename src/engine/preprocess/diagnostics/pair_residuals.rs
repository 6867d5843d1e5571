//! Do two cameras agree? How far apart they put surfaces that both should see.
//!
//! Purpose: a camera whose pose is wrong disagrees with all others about what never moves; one whose clock is wrong, only
//! about what moves. Both show here, pair by pair, before they show as ghosts in a picture.
//!
//! Source: the paper takes calibrated and synchronized cameras for granted. Distances are those of
//! [`crate::preprocess::registration`], in footprints: from a sample to the tangent plane of what the other camera saw in its place. What
//! differs: there is no tolerance. Where the other camera sees something much nearer, the sample is hidden and counts for nothing;
//! where it sees something farther, it looks through the surface, and the distance counts however large it is. Samples are on a
//! lattice, and what most of them do not exceed is blind to silhouettes and to single wrong pixels.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::pair_table::{PairTable, compared_pairs, keeps_all_pairs};
use crate::capture::INVALID_INVERSE_DEPTH;
use crate::capture::overlap::{OverlapGraph, Registration};
use crate::preprocess::layers::{CameraLayer, is_mixed};
use crate::preprocess::noise::{bin_of_rank, rank_of_share};
use crate::preprocess::pruning::lanes_at;
use crate::preprocess::registration::{
    IN_VIEW, Outcome, PixelRun, RequiredTolerances, SameSurface, SourceRun, TargetRun, lanes_of,
};
use crate::preprocess::temporal::ROOT;
use crate::samples::Span;
use crate::simd::{self, LANES, VectorLoop};

/// A surface that is nearer than a sample by more than this, in footprints, hides it. With a much larger bound, samples hidden by a
/// surface close to them would count as disagreement.
const HIDING_FOOTPRINTS: f32 = 2.0;

/// The share of the samples that do not exceed [`Residual::most_footprints`]: on the silhouettes of correct captures up to one in
/// ten is off.
const MOST: f64 = 0.85;

/// Pairs with fewer samples have no residual.
const MIN_SAMPLES: u64 = 48;

/// About this many samples of each camera are compared with another one. With many cameras there are fewer, so that the total does not grow.
const LATTICE_SAMPLES: usize = 8192;
const FEWEST_LATTICE_SAMPLES: usize = 1024;
/// The number of samples falls with more cameras than this.
const FEW_CAMERAS: usize = 9;

/// Moving samples are searched for this many times as densely.
const MOVING_DENSITY: usize = 4;

/// Moving samples are compared at no more than this many frames, spread over all.
const FRAMES: usize = 8;

/// A sample whose inverse depth changes by a smaller share did not move.
const MOVED_RELATIVE: f32 = 0.02;

/// How far samples of one camera are from the surfaces that another camera saw, over samples that nothing hides from it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Residual {
    /// Samples that were compared.
    pub samples: u64,
    /// Distance to the tangent plane of what the other camera saw there, in footprints of the coarser of the two, median.
    pub median_footprints: f32,
    /// The distance that 85 % of the samples do not exceed.
    pub most_footprints: f32,
    /// Difference of color where both see the surface, the widest channel, 8-bit sRGB steps, median. Noise is not taken out.
    pub median_color_steps: f32,
}

/// How one camera's samples fit what another saw.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PairResiduals {
    /// Residual of samples that are the same over all frames: large where a pose is wrong. `None` where too few are seen by both.
    pub lasting: Option<Residual>,
    /// Residual of what is nearer or farther than some frames before: where clocks differ it is large and `lasting` small. `None` where
    /// too few are seen by both.
    pub moving: Option<Residual>,
    /// Samples at some distance that are the same over all frames and were looked for, where no pair at all can be compared.
    #[serde(default, skip_serializing_if = "is_none")]
    pub unmatched: u64,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes a reference")]
fn is_none(count: &u64) -> bool {
    *count == 0
}

/// Distances and colors while they are gathered.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct ResidualHistograms {
    footprints: LogHistogram,
    color_steps: LogHistogram,
    /// Samples at some distance, wherever the other camera looks.
    asked: u64,
}

/// `[source * cameras + target]`: of samples of all frames, and of things that moved; `None` of a camera itself, and where the target
/// sees nothing of what the source saw.
pub(crate) type PairHistograms = Vec<Option<Box<[ResidualHistograms; 2]>>>;

impl ResidualHistograms {
    pub(crate) fn add(&mut self, other: &Self) {
        self.footprints.add(&other.footprints);
        self.color_steps.add(&other.color_steps);
        self.asked += other.asked;
    }

    fn residual(&self) -> Option<Residual> {
        let samples = self.footprints.total();
        (samples >= MIN_SAMPLES).then(|| Residual {
            samples,
            median_footprints: self.footprints.within(0.5),
            most_footprints: self.footprints.within(MOST),
            median_color_steps: self.color_steps.within(0.5),
        })
    }
}

/// Gathers residuals while preprocessing runs.
pub(crate) struct Residuals<'a> {
    camera_pairs: &'a OverlapGraph<'a>,
    frames: usize,
    readings: PairHistograms,
    /// Which pairs are compared, as [`PairHistograms`]: with many cameras each is compared with a few others.
    is_compared: Vec<bool>,
    /// Per camera: samples that were looked for in cameras that see none of them.
    asked_unseen: Vec<u64>,
    /// Per camera: inverse depth on the lattice when it was last looked at.
    before: Vec<Vec<[f32; LANES]>>,
}

impl<'a> Residuals<'a> {
    pub(crate) fn new(camera_pairs: &'a OverlapGraph<'a>, frames: usize) -> Self {
        let pairs = camera_pairs.cameras().len().pow(2);
        let readings = (0..pairs).map(|_| None).collect();
        let before = vec![Vec::new(); camera_pairs.cameras().len()];
        let asked_unseen = vec![0; camera_pairs.cameras().len()];
        let is_compared = compared_pairs(camera_pairs);
        Self { camera_pairs, frames, readings, is_compared, asked_unseen, before }
    }

    /// Notes that samples are looked for which are the same over all frames, wherever other cameras look.
    pub(crate) fn note_asked(&mut self, lattice: &[LatticeRuns]) {
        self.asked_unseen = lattice.iter().map(LatticeRuns::asked).collect();
    }

    /// The frame before a run with which the first compared frame of the run is compared; `None` if there is no such frame.
    pub(crate) fn frame_before(frames: usize, run: Span) -> Option<usize> {
        let apart = frames_apart(frames);
        let first = (run.start as usize).next_multiple_of(apart);
        (run.start > 0 && first < run.end as usize).then(|| first - apart)
    }

    /// Whether samples of a frame are compared with those of an earlier one.
    pub(crate) fn looks_at(&self, frame: usize) -> bool {
        frame.is_multiple_of(frames_apart(self.frames))
    }

    /// What is nearer or farther in a layer of `camera` than it was when that camera was last looked at; the layer holds all samples of
    /// a frame. Samples that change their light alone are left out: there may be many.
    pub(crate) fn moving(&self, camera: usize, layer: &CameraLayer) -> LookedAt {
        let before = &self.before[camera];
        let look = |(at, (column, row)): (usize, (usize, usize))| {
            let now = lanes_of(&layer.inverse_depth, layer.width, (column, row), INVALID_INVERSE_DEPTH);
            let moved = before.get(at).map_or(0, |before| moved_lanes(before, &now));
            let passing = lanes_at(layer, (column, row), |level| level != ROOT);
            ((column, row, moved & passing), now)
        };
        let cameras = self.camera_pairs.cameras().len();
        let (blocks, now): (Vec<_>, Vec<_>) =
            lattice(layer, asked_of_each(cameras) * MOVING_DENSITY).enumerate().map(look).unzip();
        LookedAt { lattice: LatticeRuns::of(layer, blocks.into_iter()), now }
    }

    /// Notes what each camera showed; gives the samples that are to be compared.
    pub(crate) fn note(&mut self, looked: Vec<LookedAt>) -> Vec<LatticeRuns> {
        let noted = looked.into_iter().zip(&mut self.before).map(|(looked, before)| {
            *before = looked.now;
            looked.lattice
        });
        noted.collect()
    }

    /// Compares samples of some cameras with what some others saw, whose layers are there. `kind` 0 is samples of all frames, 1 is things
    /// that moved.
    pub(crate) fn compare(
        &mut self,
        kind: usize,
        lattice: &[LatticeRuns],
        sources: &[usize],
        targets: &[usize],
        layers: &[CameraLayer],
    ) {
        let cameras = layers.len();
        let of_source = |source: &usize| {
            let (source, is_compared) = (*source, &self.is_compared);
            let others = self.camera_pairs.others_among(source, targets);
            others
                .filter(move |(target, _)| is_compared[source * cameras + *target])
                .map(move |(target, registration)| (source, target, registration))
        };
        let compared: Vec<_> = sources.iter().flat_map(of_source).collect();
        let read = compared.into_par_iter().map(|(source, target, registration)| {
            let (runs, source_layer, target_layer) = (&lattice[source].0, &layers[source], &layers[target]);
            let compare = Compare { registration, source: source_layer, target: target_layer, runs };
            (source * cameras + target, simd::run(compare))
        });
        for (pair, reading) in read.collect::<Vec<_>>() {
            self.readings[pair].get_or_insert_default()[kind].add(&reading);
        }
    }

    /// What was gathered.
    pub(crate) fn into_readings(mut self) -> PairHistograms {
        // If no cameras at all can be compared, pairs count their unmatched samples: all, or one of each camera.
        if !is_any_compared(&self.readings) {
            let cameras = self.asked_unseen.len();
            for (pair, readings) in self.readings.iter_mut().enumerate() {
                let (source, target) = (pair / cameras, pair % cameras);
                let asked = self.asked_unseen[source];
                let is_told = keeps_all_pairs(cameras) || target == (source + 1) % cameras;
                if source != target && is_told && asked > 0 && readings.is_none() {
                    readings.get_or_insert_default()[0].asked = asked;
                }
            }
        }
        self.readings
    }
}

fn is_any_compared(readings: &PairHistograms) -> bool {
    readings.iter().flatten().flat_map(|pair| pair.iter()).any(|reading| reading.residual().is_some())
}

/// The residuals of this many cameras, `(source, target)`.
pub(crate) fn residuals_of(readings: &PairHistograms, cameras: usize) -> PairTable<PairResiduals> {
    let is_any_compared = is_any_compared(readings);
    let of_pair = |pair: &Option<Box<[ResidualHistograms; 2]>>| {
        let Some([lasting, moving]) = pair.as_deref() else { return PairResiduals::default() };
        PairResiduals {
            lasting: lasting.residual(),
            moving: moving.residual(),
            unmatched: if is_any_compared { 0 } else { lasting.asked },
        }
    };
    if !keeps_all_pairs(cameras) {
        let known = readings.iter().enumerate().filter(|(_, pair)| pair.is_some());
        let placed = known.map(|(at, pair)| (at / cameras, at % cameras, of_pair(pair)));
        return PairTable::of_some(cameras, placed);
    }
    let mut pairs = readings.iter().map(of_pair);
    let rows: Vec<Vec<PairResiduals>> =
        (0..cameras).map(|_| pairs.by_ref().take(cameras).collect()).collect();
    rows.into()
}

/// The distance between frames at which moving samples are compared.
fn frames_apart(frames: usize) -> usize {
    frames.div_ceil(FRAMES).max(1)
}

/// Columns and rows of blocks of pixels of a layer, spread evenly, that together hold about this many pixels.
fn lattice(layer: &CameraLayer, pixels: usize) -> impl Iterator<Item = (usize, usize)> + use<> {
    let (width, height) = (layer.width, layer.height());
    let step = (width * height / pixels).isqrt().max(1);
    (0..height).step_by(step).flat_map(move |row| {
        // Neighboring rows begin elsewhere, so that no column of the picture is left out.
        let first = row / step % step * LANES;
        (first..width).step_by(step * LANES).map(move |column| (column, row))
    })
}

/// About how many samples of each pair of so many cameras are compared if all pixels take part.
fn asked_of_each(cameras: usize) -> usize {
    (LATTICE_SAMPLES * FEW_CAMERAS / cameras.max(1)).clamp(FEWEST_LATTICE_SAMPLES, LATTICE_SAMPLES)
}

/// Samples of one camera that are compared with what others saw.
#[derive(Default)]
pub(crate) struct LatticeRuns(Vec<(PixelRun, u32)>);

impl LatticeRuns {
    /// Samples of a layer that are the same over all frames, for one of so many cameras.
    pub(crate) fn lasting(layer: &CameraLayer, cameras: usize) -> Self {
        let block = |(column, row)| (column, row, lanes_at(layer, (column, row), |level| level == ROOT));
        Self::of(layer, lattice(layer, asked_of_each(cameras)).map(block))
    }

    /// The runs of blocks, by column, row and lanes.
    fn of(layer: &CameraLayer, blocks: impl Iterator<Item = (usize, usize, u32)>) -> Self {
        let run = |(column, row, lanes)| (PixelRun::new(layer, column, row, lanes), lanes);
        Self(blocks.filter(|(.., lanes)| *lanes != 0).map(run).collect())
    }

    /// Samples that are compared, whatever the other camera sees.
    fn asked(&self) -> u64 {
        self.0.iter().map(|(run, lanes)| u64::from(asked_lanes(run, *lanes).count_ones())).sum()
    }
}

/// What one camera showed at a frame.
pub(crate) struct LookedAt {
    lattice: LatticeRuns,
    /// Inverse depths on the lattice.
    now: Vec<[f32; LANES]>,
}

/// The lanes of a run whose samples are compared.
#[inline(always)]
fn asked_lanes(run: &PixelRun, lanes: u32) -> u32 {
    let mut asked = 0;
    for lane in 0..LANES {
        let counts = !is_mixed(run.rank[lane]) & (run.inverse_depth[lane] > 0.0);
        asked |= u32::from(counts) << lane;
    }
    asked & lanes
}

/// Where the inverse depth changed by more than noise and rounding do.
fn moved_lanes(before: &[f32; LANES], now: &[f32; LANES]) -> u32 {
    let moved = |lane: usize| {
        let [before, now] = [before[lane], now[lane]];
        before >= 0.0 && now >= 0.0 && (before - now).abs() > MOVED_RELATIVE * before.max(now)
    };
    (0..LANES).fold(0, |lanes, lane| lanes | u32::from(moved(lane)) << lane)
}

/// Samples of one camera against what another saw.
struct Compare<'a> {
    registration: &'a Registration,
    source: &'a CameraLayer,
    target: &'a CameraLayer,
    runs: &'a [(PixelRun, u32)],
}

impl VectorLoop for Compare<'_> {
    type Output = ResidualHistograms;

    #[inline(always)]
    fn run(self) -> ResidualHistograms {
        let Self { registration, source, target, runs } = self;
        let mut readings = ResidualHistograms::default();
        if target.geometry.is_empty() {
            return readings;
        }
        let limits = SameSurface::geometry_within(HIDING_FOOTPRINTS);
        for (block, lanes) in runs {
            let carried = registration.reproject(block, target.width);
            let asked = asked_lanes(block, *lanes);
            readings.asked += u64::from(asked.count_ones());
            let mut relevant = [0; LANES];
            for lane in 0..LANES {
                relevant[lane] = (asked >> lane & 1) & u32::from(carried.bits[lane] & IN_VIEW != 0);
            }
            let mut required = RequiredTolerances::new(0.0);
            let source = SourceRun::of_layer(source, block);
            let target = TargetRun { layer: target, reprojected: &carried };
            let answers = limits.compare_measuring::<LANES, true>(
                registration,
                source,
                target,
                relevant,
                &mut required,
            );
            for lane in (0..LANES).filter(|lane| relevant[*lane] != 0) {
                match answers.outcome(lane) {
                    Outcome::Occluded
                    | Outcome::NoDepth
                    | Outcome::ShorterSpan
                    | Outcome::OutsideView
                    | Outcome::Behind => {}
                    Outcome::SeesPast | Outcome::NormalDiffers => {
                        readings.footprints.count(required.depth[lane]);
                    }
                    Outcome::ColorDiffers | Outcome::ValueDiffers | Outcome::Seam | Outcome::Same(_) => {
                        readings.footprints.count(required.depth[lane]);
                        readings.color_steps.count(required.color[lane]);
                    }
                }
            }
        }
        readings
    }
}

/// Counts numbers by their magnitude, sixteen bins to an octave, so that memory is bounded.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct LogHistogram {
    /// Empty until there is a number.
    counts: Vec<u32>,
}

impl LogHistogram {
    /// Low bits of an `f32` that the bin does not depend on.
    const SHIFT: u32 = 19;
    /// Smaller values count as 0.
    const SMALLEST: f32 = 1.0 / 4096.0;
    /// Larger values count as this.
    const LARGEST: f32 = 4096.0;
    /// The bin before that of [`LogHistogram::SMALLEST`].
    const FIRST: u32 = (Self::SMALLEST.to_bits() >> Self::SHIFT) - 1;
    const BINS: usize = ((Self::LARGEST.to_bits() >> Self::SHIFT) - Self::FIRST) as usize + 1;

    /// Counts a number; NaN counts as the largest.
    pub(crate) fn count(&mut self, value: f32) {
        self.counts.resize(Self::BINS, 0);
        let bin = (value.abs().min(Self::LARGEST).to_bits() >> Self::SHIFT).saturating_sub(Self::FIRST);
        self.counts[bin as usize] += 1;
    }

    /// Adds the counts of another histogram.
    pub(crate) fn add(&mut self, other: &Self) {
        self.counts.resize(self.counts.len().max(other.counts.len()), 0);
        for (count, other) in self.counts.iter_mut().zip(&other.counts) {
            *count += other;
        }
    }

    /// How many numbers were counted.
    pub(crate) fn total(&self) -> u64 {
        self.counts.iter().copied().map(u64::from).sum()
    }

    /// The magnitude, to the middle of its bin, that a share of the numbers does not exceed; 0 where there is none.
    pub(crate) fn within(&self, share: f64) -> f32 {
        let rank = rank_of_share(self.total(), share).max(1);
        let bin = bin_of_rank(self.counts.iter().copied().map(u64::from), rank);
        bin.filter(|bin| *bin > 0).map_or(0.0, |bin| {
            f32::from_bits(((bin as u32 + Self::FIRST) << Self::SHIFT) | 1 << (Self::SHIFT - 1))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spread_tells_shares_to_a_twentieth() {
        let mut spread = LogHistogram::default();
        assert_eq!(spread.within(0.5), 0.0);
        (0..1000).for_each(|i| spread.count(i as f32 / 100.0));
        for share in [0.1, 0.5, 0.85, 1.0] {
            let found = spread.within(share);
            assert!((found / (10.0 * share as f32) - 1.0).abs() < 0.05, "{share}: {found}");
        }
        let mut far = LogHistogram::default();
        for value in [0.0, -0.0, f32::INFINITY] {
            far.count(value);
        }
        assert_eq!((far.within(0.5), far.total()), (0.0, 3));
        assert!(far.within(1.0) >= LogHistogram::LARGEST);
    }
}
