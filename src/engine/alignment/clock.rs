//! Clocks: how late the pictures of each camera are, in frames.
//!
//! Purpose: a late camera sees moving surfaces in other places than the rest do. Source: two cameras see a moving surface at some
//! distance from each other, which passes zero linearly where both look at the same moment; so one Newton step finds the fraction of
//! a frame (as in temporal alignment of image sequences: Y. Caspi and M. Irani, *Spatio-Temporal Alignment of Sequences*, PAMI 2002).
//! What differs: the residuals are those of poses, point to plane and brightness, and their rate of change is measured between the
//! frames before and after.
//!
//! Only differences between cameras are known: the clock of most cameras stays. Whole frames are corrected, fractions are reported.

use rayon::prelude::*;

use super::judge::Judgment;
use super::normal_equations::NormalEquations;
use super::reference_view::{ReferenceView, still_pixels};
use super::residuals::PairOfViews;
use super::solver::{Problem, TUKEY, loss};
use super::surface_samples::{SurfaceSample, surface_samples};
use super::tangent_plane::SurfaceBend;
use crate::capture::Capture;
use crate::error::Result;
use crate::job::Job;
use crate::median::{MEDIAN_PER_SIGMA, median};

/// Delays that are looked for where the first look finds any, frames.
const MOST_FRAMES: i64 = 4;
/// Moments at which cameras are compared, as shares of the capture, once they are known to differ.
const MOMENTS: [f64; 2] = [0.25, 0.75];
/// Samples of a picture that are searched for motion.
const SAMPLES: usize = 12_000;
/// Distances beyond this are other surfaces, footprints.
const GATE: f64 = 20.0;
/// The resolution at which brightness is compared: coarse, as it changes linearly only over a part of its texture.
const LEVEL: usize = 2;
/// A pair with fewer moving samples gives no delay.
const LEAST_SAMPLES: usize = 30;
/// The least uncertainty of residuals: footprints, and brightness.
const LEAST_SIGMAS: [f64; 2] = [0.1, 0.01];
/// A sample whose residuals change less from frame to frame does not move.
const LEAST_RATES: [f64; 2] = [0.3, 0.02];
/// Delays below this do not show, frames.
const LEAST_DELAY: f64 = 0.1;
/// Standard errors are multiplied with this, as neighboring samples are not independent.
const INFLATION: f64 = 3.0;
/// The first look finds no delay where all cameras agree within this, frames.
const IN_TIME: f64 = 0.08;

/// What was found of one camera's clock.
#[derive(Clone, Debug, Default)]
pub(crate) struct ClockCorrection {
    /// How much later than those of most cameras its pictures were taken, and the standard error, frames.
    pub(crate) delay: f64,
    pub(crate) standard_error: f64,
    /// Whole frames by which its pictures are moved; 0 where that does not pay.
    pub(crate) shift: i64,
    pub(crate) judgment: Judgment,
}

impl ClockCorrection {
    /// Whether the delay is neither too small to show nor chance.
    pub(crate) fn shows(&self) -> bool {
        self.delay.abs() > LEAST_DELAY && self.delay.abs() > 3.0 * self.standard_error
    }
}

/// The frames around one moment.
#[derive(Clone, Copy)]
struct FrameWindow {
    /// The moment's own frame.
    at: i64,
    /// Frames before and after it that are looked at.
    before: i64,
    after: i64,
}

impl FrameWindow {
    fn frames(self) -> std::ops::RangeInclusive<i64> {
        self.at - self.before..=self.at + self.after
    }

    fn len(self) -> usize {
        (self.before + 1 + self.after) as usize
    }
}

/// Distance and brightness of a moving sample beside what another camera saw at one frame; NaN where it is not seen.
type FrameResiduals = [f32; 2];

/// Not seen.
const UNSEEN: FrameResiduals = [f32::NAN; 2];

/// The residuals of one moving sample at every frame that was looked at.
#[derive(Clone, Copy)]
struct Track<'a> {
    residuals: &'a [FrameResiduals],
    judges: bool,
}

/// All moving samples of one camera that another one sees at some frame.
struct PairTracks {
    pair: [usize; 2],
    /// Frames that were looked at.
    frames: usize,
    /// By sample, then by frame.
    residuals: Vec<FrameResiduals>,
    /// By sample.
    judges: Vec<bool>,
}

/// How much later the source of a pair was taken than its target.
struct PairDelay {
    frames: f64,
    weight: f64,
}

/// Finds clocks. The problem has the poses that were found; `capture` is what it was made of.
///
/// # Errors
/// Whatever the capture gives (naming file and frame), and `Cancelled`.
pub(crate) fn align_clocks(problem: &Problem, capture: &Capture, job: &Job) -> Result<Vec<ClockCorrection>> {
    let cameras = capture.cameras.len();
    let none = vec![ClockCorrection::default(); cameras];
    if first_look_finds_none(problem, capture, job)? {
        return Ok(none);
    }
    let frames = capture.frame_count() as i64;
    // Moments are a quarter of the capture away from its ends.
    let reach = (MOST_FRAMES + 1).min(frames / 4).max(1);
    let windows =
        MOMENTS.map(|share| FrameWindow { at: (share * frames as f64) as i64, before: reach, after: reach });
    let pairs = tracks(problem, capture, &windows, job)?;
    let found: Vec<([usize; 2], PairDelay)> =
        pairs.iter().filter_map(|pair| Some((pair.pair, pair.widest_difference(reach)?))).collect();
    let mut clocks = solved(&found, cameras);
    let shifts: Vec<i64> = clocks.iter().map(|clock| clock.delay.round() as i64).collect();
    for (camera, clock) in clocks.iter_mut().enumerate().filter(|(camera, _)| shifts[*camera] != 0) {
        clock.judgment = judged(camera, &shifts, &pairs, reach);
        let is_sure = clock.delay.abs() > 3.0 * clock.standard_error;
        clock.shift = if is_sure && clock.judgment.pays() { shifts[camera] } else { 0 };
    }
    Ok(clocks)
}

/// Whether two successive frames show that cameras are in time: the two in the middle, or the first two if nothing moves there.
fn first_look_finds_none(problem: &Problem, capture: &Capture, job: &Job) -> Result<bool> {
    for at in [capture.frame_count() as i64 / 2, 0] {
        let first = tracks(problem, capture, &[FrameWindow { at, before: 0, after: 1 }], job)?;
        let found: Vec<([usize; 2], f64)> = first
            .iter()
            .filter_map(|pair| Some((pair.pair, pair.difference(0, [0, 1])?.frames.abs())))
            .collect();
        if !found.is_empty() {
            // A surface that is hidden in one of the frames looks late in single pairs. A late camera is late in most of its pairs.
            let is_in_time = |camera: usize| {
                let of_camera = found.iter().filter(|(pair, _)| pair.contains(&camera));
                let mut off: Vec<f64> = of_camera.map(|(_, off)| *off).collect();
                median(&mut off).is_none_or(|off| off < IN_TIME)
            };
            return Ok((0..problem.views.len()).all(is_in_time));
        }
    }
    Ok(true)
}

/// Follows the moving samples of every camera through the frames of some windows of one length in the others. A window that reaches
/// beyond the capture is left out.
fn tracks(
    problem: &Problem,
    capture: &Capture,
    windows: &[FrameWindow],
    job: &Job,
) -> Result<Vec<PairTracks>> {
    let frames = capture.frame_count() as i64;
    let length = windows.first().map_or(0, |window| window.len());
    let of_pair = |pair: &[usize; 2]| PairTracks {
        pair: *pair,
        frames: length,
        residuals: Vec::new(),
        judges: Vec::new(),
    };
    let mut pairs: Vec<PairTracks> = problem.pairs.iter().map(of_pair).collect();
    let cameras = 0..capture.cameras.len();
    for window in windows {
        if *window.frames().start() < 0 || *window.frames().end() >= frames {
            continue;
        }
        let moving = cameras.clone().into_par_iter().map(|camera| {
            job.check()?;
            moving_samples(problem, capture, camera, *window)
        });
        let moving: Vec<Vec<SurfaceSample>> = moving.collect::<Result<_>>()?;
        let room = |&[source, _]: &[usize; 2]| Vec::with_capacity(moving[source].len() * length);
        let mut by_frame: Vec<Vec<FrameResiduals>> = problem.pairs.iter().map(room).collect();
        // Of all cameras together, one frame is held at a time.
        for frame in window.frames() {
            let targets = cameras.clone().into_par_iter().map(|camera| {
                job.check()?;
                let lens = problem.views[camera].camera.clone();
                Ok(ReferenceView::of_level(lens, &*capture.frame(camera, frame as usize)?, LEVEL))
            });
            let targets: Vec<ReferenceView> = targets.collect::<Result<_>>()?;
            by_frame.par_iter_mut().zip(&problem.pairs).for_each(|(residuals, &[source, target])| {
                let views = [&problem.views[source], &targets[target]];
                let poses = views.map(|view| view.camera.world_from_camera);
                let gains = [source, target].map(|camera| problem.log_gains[camera]);
                let pair = PairOfViews::new(views, poses, gains, problem.scale, false);
                residuals.extend(moving[source].iter().map(|sample| residuals_in(&pair, sample)));
            });
        }
        pairs
            .par_iter_mut()
            .zip(by_frame)
            .for_each(|(pair, by_frame)| pair.add(&moving[pair.pair[0]], &by_frame));
    }
    Ok(pairs)
}

/// What moves in a camera at the moment of a window.
fn moving_samples(
    problem: &Problem,
    capture: &Capture,
    camera: usize,
    window: FrameWindow,
) -> Result<Vec<SurfaceSample>> {
    let own = capture.frame(camera, window.at as usize)?;
    let beside = [window.at - 1, window.at + 1].into_iter().filter(|frame| window.frames().contains(frame));
    let still = beside.map(|frame| Ok(still_pixels(&own, &*capture.frame(camera, frame as usize)?)));
    let still: Vec<_> = still.collect::<Result<_>>()?;
    let moves = |sample: &SurfaceSample| {
        let (x, y) = (sample.pixel.x as usize, sample.pixel.y as usize);
        still.iter().any(|still| !still[(x, y)])
    };
    // A surface that moves by several pixels is compared with the plane through its pixels: distances from it change most evenly.
    let flat = |sample: SurfaceSample| SurfaceSample {
        inverse_depth: sample.inverse_depth + sample.bend.mean,
        bend: SurfaceBend::default(),
        ..sample
    };
    // The outline of what moves tells its delay as well as its texture does.
    let view = ReferenceView::without_extent(problem.views[camera].camera.clone(), own, None);
    let mut moving: Vec<_> = surface_samples(&view, SAMPLES).into_iter().filter(moves).map(flat).collect();
    // They are in the memory of all that were searched.
    moving.shrink_to_fit();
    Ok(moving)
}

/// What is between a moving sample and what another camera saw.
fn residuals_in(pair: &PairOfViews<'_>, sample: &SurfaceSample) -> FrameResiduals {
    pair.terms(sample, LEVEL, GATE).map_or(UNSEEN, |terms| {
        [terms.distance, terms.color].map(|term| term.map_or(f32::NAN, |term| term.residual as f32))
    })
}

impl PairTracks {
    /// Adds those of some moving samples of the source that are seen at any frame. Their residuals are given by frame, then by sample.
    fn add(&mut self, moving: &[SurfaceSample], by_frame: &[FrameResiduals]) {
        for (at, sample) in moving.iter().enumerate() {
            let of_sample = by_frame[at..].iter().step_by(moving.len());
            if of_sample.clone().flatten().any(|residual| !residual.is_nan()) {
                self.residuals.extend(of_sample);
                self.judges.push(sample.judges);
            }
        }
        // There are many pairs, and nearly half of what a list grows to is empty.
        self.residuals.shrink_to_fit();
    }

    fn tracks(&self) -> impl Iterator<Item = Track<'_>> {
        let residuals = self.residuals.chunks_exact(self.frames);
        residuals.zip(&self.judges).map(|(residuals, judges)| Track { residuals, judges: *judges })
    }

    /// How late the source is beside the target's frame `offset` after its own. The first residual is of the frame `reach` before it.
    /// `None` where too little moves.
    fn difference_beside(&self, offset: i64, reach: i64) -> Option<PairDelay> {
        let middle = (reach + offset) as usize;
        let found = self.difference(middle, [middle - 1, middle + 1])?;
        Some(PairDelay { frames: offset as f64 + found.frames, ..found })
    }

    /// How late the source is by the residuals at `now`, which change as they do between two others; `None` where too little moves.
    fn difference(&self, now: usize, [from, to]: [usize; 2]) -> Option<PairDelay> {
        let (mut products, mut squares, mut counted) = (0.0, 0.0, 0);
        for kind in [0, 1] {
            let fitting = self.tracks().filter(|track| !track.judges);
            let moving: Vec<[f64; 2]> = fitting
                .filter_map(|track| {
                    let [before, now, after] = [from, now, to].map(|at| track.residual(at, kind));
                    let rate = (after? - before?) / (to - from) as f64;
                    (rate.abs() > LEAST_RATES[kind]).then_some([now?, rate])
                })
                .collect();
            let Some(start) = weighted_median(&moving) else { continue };
            counted += moving.len();
            let (product, square) = least_squares(&moving, start, LEAST_SIGMAS[kind]);
            products += product;
            squares += square;
        }
        (counted >= LEAST_SAMPLES && squares > 0.0)
            .then(|| PairDelay { frames: products / squares, weight: squares })
    }

    /// As [`PairTracks::difference_beside`], beside the frame of the target that fits best.
    fn widest_difference(&self, reach: i64) -> Option<PairDelay> {
        let offsets = 1 - reach..reach;
        let best = offsets.min_by(|a, b| self.loss(*a, reach).total_cmp(&self.loss(*b, reach)))?;
        let found = self.difference_beside(best, reach)?;
        // One more step where the fraction leads to another frame.
        let nearest = (found.frames.round() as i64).clamp(1 - reach, reach - 1);
        if nearest == best { Some(found) } else { self.difference_beside(nearest, reach) }
    }

    /// Mean loss of the samples that fit, beside the target's frame `offset` after the source's own.
    fn loss(&self, offset: i64, reach: i64) -> f64 {
        let fitting = self.tracks().filter(|track| !track.judges);
        let losses: Vec<f64> = fitting.map(|track| track.loss((reach + offset) as usize)).collect();
        losses.iter().sum::<f64>() / losses.len().max(1) as f64
    }
}

impl Track<'_> {
    /// The distance of the sample, or its brightness, beside the target's frame at a place in the window; `None` where it is not seen.
    fn residual(self, at: usize, kind: usize) -> Option<f64> {
        let residual = self.residuals[at][kind];
        (!residual.is_nan()).then_some(f64::from(residual))
    }

    /// From 0 to 2.
    fn loss(self, at: usize) -> f64 {
        let wide = [GATE / TUKEY, 0.1];
        let of = |kind: usize| self.residual(at, kind).map_or(1.0, |off| loss(off, wide[kind]));
        of(0) + of(1)
    }
}

/// The delay of most of the motion: the median of `−residual / rate`, weighted by the rate.
fn weighted_median(moving: &[[f64; 2]]) -> Option<f64> {
    let mut delays: Vec<[f64; 2]> = moving.iter().map(|[now, rate]| [-now / rate, rate.abs()]).collect();
    delays.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let total: f64 = delays.iter().map(|delay| delay[1]).sum();
    let mut sum = 0.0;
    delays
        .iter()
        .find(|delay| {
            sum += delay[1];
            2.0 * sum >= total
        })
        .map(|delay| delay[0])
}

/// Sums of the weighted least squares for the delay, from where `start` is: its right side and its matrix.
fn least_squares(moving: &[[f64; 2]], start: f64, least_sigma: f64) -> (f64, f64) {
    const ROUNDS: usize = 4;
    let mut delay = start;
    let (mut product, mut square) = (0.0, 0.0);
    for _ in 0..ROUNDS {
        let left = |[now, rate]: &[f64; 2]| now + delay * rate;
        let mut magnitudes: Vec<f64> = moving.iter().map(|moved| left(moved).abs()).collect();
        let sigma = (median(&mut magnitudes).unwrap_or_default() / MEDIAN_PER_SIGMA).max(least_sigma);
        (product, square) = (0.0, 0.0);
        for moved in moving {
            let relative = left(moved) / (TUKEY * sigma);
            if relative.abs() < 1.0 {
                let weight = ((1.0 - relative * relative) / sigma).powi(2);
                product -= weight * moved[0] * moved[1];
                square += weight * moved[1] * moved[1];
            }
        }
        if square <= 0.0 {
            break;
        }
        delay = product / square;
    }
    (product, square)
}

/// The clocks that fit the differences best. The camera in the middle is taken to be right. Nothing is judged yet.
fn solved(found: &[([usize; 2], PairDelay)], cameras: usize) -> Vec<ClockCorrection> {
    /// Holds the mean, which no difference determines: far less than any difference weighs.
    const PULL: f64 = 1e-6;
    let mut equations = NormalEquations::new(cameras);
    for (pair, PairDelay { frames, weight }) in found {
        equations.add_difference(*pair, *frames, *weight);
    }
    for camera in 0..cameras {
        equations.add(camera, camera, PULL);
    }
    let mut clocks = vec![ClockCorrection::default(); cameras];
    let told: Vec<bool> =
        (0..cameras).map(|camera| found.iter().any(|(pair, _)| pair.contains(&camera))).collect();
    let Some(factor) = equations.factor() else { return clocks };
    let delays = factor.solve(&equations.right);
    let mut known: Vec<f64> =
        (0..cameras).filter(|camera| told[*camera]).map(|camera| delays[camera]).collect();
    let right = median(&mut known).unwrap_or(0.0);
    for (camera, clock) in clocks.iter_mut().enumerate().filter(|(camera, _)| told[*camera]) {
        clock.delay = delays[camera] - right;
        let weights = found.iter().filter(|(pair, _)| pair.contains(&camera));
        let weight: f64 = weights.map(|(_, difference)| difference.weight).sum();
        clock.standard_error = INFLATION / weight.max(f64::MIN_POSITIVE).sqrt();
    }
    clocks
}

/// Judges one camera's whole frames by the samples that took no part in finding them. The other cameras have theirs.
fn judged(camera: usize, shifts: &[i64], pairs: &[PairTracks], reach: i64) -> Judgment {
    let mut losses = Vec::new();
    for of_pair in pairs.iter().filter(|pair| pair.pair.contains(&camera)) {
        let pair = of_pair.pair;
        let [source, target] = pair.map(|index| shifts[index]);
        let [source_before, target_before] =
            pair.map(|index| if index == camera { 0 } else { shifts[index] });
        let at =
            |difference: i64| usize::try_from(reach + difference).ok().filter(|at| *at <= 2 * reach as usize);
        let Some((before, now)) = at(source_before - target_before).zip(at(source - target)) else {
            continue;
        };
        let judging = of_pair.tracks().filter(|track| track.judges);
        losses.extend(judging.map(|track| [track.loss(before), track.loss(now)]));
    }
    Judgment::of(&losses)
}
