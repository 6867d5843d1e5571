//! Finds the color lens that all cameras of one sensor share, and judges it by cameras that took no part.
//!
//! Purpose: see [`super::color_lens`]. Source: Gauss–Newton with Tukey's biweight from coarse pictures to fine ones, started from
//! several focal lengths, since brightness has local minima; errors of the unknowns from the spread of what single cameras ask for
//! (H. White, *A Heteroskedasticity-Consistent Covariance Matrix Estimator*, 1980). What differs: models of one, seven and nine
//! unknowns are tried in turn, and each is kept only where pairs with cameras that took no part get better by it.
//!
//! Which samples of two cameras show one surface point, so that their colors determine the color lens.
//!
//! Purpose: see [`super::color_lens_search`]. Source: none; a sample counts where the other camera's depth confirms it.
//!
//! The share of each pair of cameras in the normal equations of a color lens.
//!
//! Purpose: see [`super::color_lens_search`]. Source: iteratively reweighted least squares with Tukey's biweight, whose width is
//! measured pair by pair.

use glam::DVec2;
use rayon::prelude::*;

use super::color_lens::{BrightnessDifference, ColorLens, Matches, Sensing, UNKNOWNS};
use super::judge::{Judgment, is_of_one_device};
use super::normal_equations::NormalEquations;
use super::reference_view::ReferenceView;
use super::solver::{Problem, TUKEY, loss};
use crate::capture::Intrinsics;
use crate::capture::sighting::tolerances::NOISY_PIXEL;
use crate::capture::sighting::{Sighting, compare};
use crate::error::Result;
use crate::job::Job;
use crate::median::{MEDIAN_PER_SIGMA, median};

/// Fewer cameras do not judge a lens that they share.
pub(crate) const LEAST_CAMERAS: usize = 4;
/// One camera of this many takes no part, the second one first.
const JUDGES: usize = 4;
/// Matches of a pair, at least, and of all pairs, at most; and at the coarsest resolution, where a pixel is an eighth.
const LEAST_MATCHES: usize = 40;
const MOST_MATCHES: usize = 40_000;
const MOST_COARSE_MATCHES: usize = 10_000;
/// Focal lengths of color to start from, relative to what is claimed.
const START_RATIOS: [f64; 7] = [1.0, 0.95, 1.05, 0.9, 1.1, 0.85, 1.15];
/// Standard deviations of the unknowns, as they are known beforehand; in the order of [`UNKNOWNS`].
const TRUST: [f64; UNKNOWNS] = [0.1, 0.02, 0.02, 0.02, 0.03, 0.03, 0.03, 0.02, 0.02];
/// Unknowns of the models in turn.
const MODELS: [&[usize]; 3] = [&[0], &[0, 1, 2, 3, 4, 5, 6], &[0, 1, 2, 3, 4, 5, 6, 7, 8]];
/// Resolutions and steps at each, of the first model and of those that start from it.
const FIRST_STAGES: [(usize, usize); 3] = [(2, 5), (1, 4), (0, 4)];
const FURTHER_STAGES: [(usize, usize); 4] = [(3, 6), (2, 5), (1, 5), (0, 5)];
/// Steps at the coarsest resolution from every start.
const START_STEPS: usize = 5;
const COARSEST: usize = 3;
/// A change that moves colors by less, in pixels, does not show.
const LEAST_MOVE_PX: f64 = 0.4;
/// The search ends at once where the first step from the claimed lens moves colors by no more, pixels.
const SETTLED_PX: f64 = 0.3;
/// The claimed lens is right where a step from it at resolutions 1 and 2 moves colors by no more than this, in pixels, and pictures
/// agree under it as renderers' do. A lens that is 2 % off moves three times as far and agrees half as well, on every texture tried.
const RIGHT_PX: [f64; 2] = [0.08, 0.15];
const RIGHT_LOSS: f64 = 0.06;
/// Standard error that all pairs have in common, so that their spread does not show it: how far colors may be moved by what lies beside
/// edges, and by interpolation, pixels.
const COMMON_ERROR_PX: f64 = 0.2;
/// Width of the loss that judges: the spread of standardized brightness within one surface, whatever the lens.
const JUDGED_SIGMA: f64 = 0.3;
/// A better start has a loss that is lower by this share.
const BETTER_START: f64 = 0.03;
/// A model pays where the loss of the judging pairs falls by this many standard errors, and by this share. Pairs come in both
/// directions: half of them are independent.
const STANDARD_ERRORS: f64 = 3.0;
const LEAST_FALL: f64 = 0.005;
/// The final lens pays where the loss of the judging pairs is lower than under the claimed lens by this share. A smaller fall may
/// come from wrong poses, which a lens can make up for in part.
const LEAST_FALL_IN_ALL: f64 = 0.1;
/// A pair counts for a lens where at least this share of its matches is in the pictures.
const LEAST_SEEN: f64 = 0.5;

/// What was found of the color lens of all cameras that claim one lens.
#[derive(Clone, Debug)]
pub(crate) struct LensCorrection {
    /// The lens that the capture claims for color and depth.
    pub(crate) claimed: Intrinsics,
    /// The color lens that was found.
    pub(crate) found: ColorLens,
    /// Unknowns that were free; the others stay as claimed.
    pub(crate) free: &'static [usize],
    /// Standard errors of the unknowns: of the logarithm of the focal length, radians, units, pixels.
    pub(crate) standard_errors: [f64; UNKNOWNS],
    /// How far colors move, root mean square, pixels.
    pub(crate) moved_px: f64,
    pub(crate) judgment: Judgment,
}

/// The color lenses that pay, one for every lens that enough cameras claim.
#[derive(Default)]
pub(crate) struct FoundLenses {
    pub(crate) kept: Vec<LensCorrection>,
    /// Those that no device has.
    pub(crate) refused: Vec<LensCorrection>,
}

/// Looks for the color lens of every lens that is claimed.
///
/// # Errors
/// `Cancelled`.
pub(crate) fn find_color_lenses(problem: &Problem, job: &Job) -> Result<FoundLenses> {
    let mut claimed: Vec<Intrinsics> = Vec::new();
    for view in &problem.views {
        if !claimed.contains(&view.camera.intrinsics) {
            claimed.push(view.camera.intrinsics);
        }
    }
    let mut found = Vec::new();
    for lens in claimed {
        if let Some(search) = LensSearch::new(problem, lens) {
            found.extend(search.run(job)?);
        }
    }
    let distance = 1.0 / problem.scale.inverse_depth;
    let is_plausible =
        |lens: &LensCorrection| is_of_one_device(&lens.found.unknowns(&lens.claimed, distance));
    let (kept, refused) = found.into_iter().partition(is_plausible);
    Ok(FoundLenses { kept, refused })
}

/// All pairs of cameras that claim one lens.
struct LensSearch<'a> {
    claimed: Intrinsics,
    distance: f64,
    /// Pairs that find the lens, and pairs that judge it.
    fitting: Vec<Matches<'a>>,
    judging: Vec<Matches<'a>>,
}

impl<'a> LensSearch<'a> {
    /// `None` where too few cameras claim the lens, or too few of their pairs match.
    fn new(problem: &'a Problem, claimed: Intrinsics) -> Option<Self> {
        let cameras: Vec<usize> = (0..problem.views.len())
            .filter(|camera| problem.views[*camera].camera.intrinsics == claimed)
            .collect();
        if cameras.len() < LEAST_CAMERAS {
            return None;
        }
        let judges: Vec<usize> = cameras.into_iter().skip(1).step_by(JUDGES).collect();
        let pairs = problem.pairs.par_iter().map(|pair| {
            let is_shared = pair.iter().all(|camera| problem.views[*camera].camera.intrinsics == claimed);
            let judge = pair.iter().any(|camera| judges.contains(camera));
            let matches = is_shared.then(|| matches(problem, *pair, judge))?;
            Some((judge, matches))
        });
        let pairs: Vec<_> = pairs.collect();
        let (judging, fitting): (Vec<_>, Vec<_>) = pairs
            .into_iter()
            .flatten()
            .filter(|(_, pair)| pair.levels.iter().filter(|levels| **levels > 0).count() >= LEAST_MATCHES)
            .partition(|pair| pair.0);
        let [fitting, judging] =
            [fitting, judging].map(|pairs| pairs.into_iter().map(|(_, pair)| pair).collect::<Vec<_>>());
        (fitting.len() >= 2 && judging.len() >= 2).then(|| Self {
            claimed,
            distance: 1.0 / problem.scale.inverse_depth,
            fitting,
            judging,
        })
    }

    fn sensing(&self, level: usize) -> Sensing {
        let seen = |pair: &Matches| pair.levels.iter().filter(|levels| level < **levels).count();
        let all: usize = self.fitting.iter().map(seen).sum();
        let most = if level == COARSEST { MOST_COARSE_MATCHES } else { MOST_MATCHES };
        Sensing {
            level,
            stride: all.div_ceil(most).max(1),
            distance: self.distance,
            depth_focal: self.claimed.fx,
        }
    }

    fn run(&self, job: &Job) -> Result<Option<LensCorrection>> {
        let claimed = ColorLens::of_depth(self.claimed);
        let Some(start) = self.start(claimed, job)? else { return Ok(None) };
        let mut kept: Option<(ColorLens, &'static [usize], Judgment)> = None;
        let mut from = claimed.scaled(start.intrinsics.fx / self.claimed.fx);
        for (index, free) in MODELS.into_iter().enumerate() {
            let stages: &[(usize, usize)] =
                if index == 0 { &FIRST_STAGES } else { &FURTHER_STAGES[index - 1..] };
            let found = self.refined(from, free, stages, job)?;
            let before = kept.as_ref().map_or(claimed, |kept| kept.0);
            if pays(&self.judged(&before, &found)) {
                kept = Some((found, free, self.judged(&claimed, &found)));
            }
            from = if index == 0 { start } else { found };
        }
        let Some((found, free, judgment)) = kept else { return Ok(None) };
        // What judged joins in once it has judged.
        let found = self.refined_by_all(found, free, job)?;
        let moved_px = self.moved_px(&claimed, &found);
        let is_large = judgment.before - judgment.after > LEAST_FALL_IN_ALL * judgment.before;
        Ok((is_large && moved_px > LEAST_MOVE_PX).then(|| LensCorrection {
            claimed: self.claimed,
            found,
            free,
            standard_errors: self.standard_errors(&found, free),
            moved_px,
            judgment,
        }))
    }

    /// Where to start from; `None` where nothing is wrong: the claimed lens is the best of all starts, and a step at the finest
    /// resolution does not show.
    fn start(&self, claimed: ColorLens, job: &Job) -> Result<Option<ColorLens>> {
        if self.is_right(&claimed, job)? {
            return Ok(None);
        }
        let coarse = self.sensing(COARSEST);
        let mut best = (claimed, self.mean_loss(&claimed, &coarse));
        let claimed_loss = best.1;
        for ratio in START_RATIOS {
            let stages = [(COARSEST, START_STEPS)];
            let found = self.refined(claimed.scaled(ratio), MODELS[1], &stages, job)?;
            let loss = self.mean_loss(&found, &coarse);
            if loss < best.1 * (1.0 - BETTER_START) {
                best = (found, loss);
            }
        }
        if best.1 < claimed_loss {
            return Ok(Some(best.0));
        }
        let looked = self.refined(claimed, MODELS[1], &[(1, 1)], job)?;
        Ok((self.moved_px(&claimed, &looked) > SETTLED_PX).then_some(claimed))
    }

    /// Whether nothing else needs to be tried. A lens that is wrong by more than the width of the texture may look settled, but then
    /// its pictures do not agree.
    fn is_right(&self, claimed: &ColorLens, job: &Job) -> Result<bool> {
        for (level, most_px) in [1, 2].into_iter().zip(RIGHT_PX) {
            let looked = self.refined(*claimed, MODELS[1], &[(level, 1)], job)?;
            if self.moved_px(claimed, &looked) > most_px {
                return Ok(false);
            }
        }
        Ok(self.mean_loss(claimed, &self.sensing(1)) < RIGHT_LOSS)
    }

    /// Mean loss over the pairs that find the lens; a pair that is hardly seen counts as wrong.
    fn mean_loss(&self, lens: &ColorLens, sensing: &Sensing) -> f64 {
        let of_pair = |pair: &Matches| {
            let differences = pair.differences(lens, sensing);
            let count = pair.count(sensing);
            if (differences.len() as f64) < LEAST_SEEN * count as f64 {
                return (count as f64, count as f64);
            }
            let sum: f64 = differences.iter().map(|difference| loss(difference.value, JUDGED_SIGMA)).sum();
            (sum, differences.len() as f64)
        };
        let pairs: Vec<(f64, f64)> = self.fitting.par_iter().map(of_pair).collect();
        let (sum, count) = pairs.iter().fold((0.0, 0.0), |(sum, count), pair| (sum + pair.0, count + pair.1));
        sum / count.max(1.0)
    }

    /// Refines a lens by the pairs that find it. A stage is a resolution and its steps at most; it ends where nothing changes.
    fn refined(
        &self,
        mut lens: ColorLens,
        free: &[usize],
        stages: &[(usize, usize)],
        job: &Job,
    ) -> Result<ColorLens> {
        for (level, steps) in stages {
            let sensing = self.sensing(*level);
            for _ in 0..*steps {
                job.check()?;
                let shares = shares(&self.fitting, &lens, &sensing);
                let Some(step) = self.step(&mut lens, free, &shares) else { break };
                if step.iter().all(|part| part.abs() < SETTLED) {
                    break;
                }
            }
        }
        Ok(lens)
    }

    /// Refines a lens by all pairs at the finest resolution.
    fn refined_by_all(&self, mut lens: ColorLens, free: &[usize], job: &Job) -> Result<ColorLens> {
        const STEPS: usize = 4;
        let sensing = self.sensing(0);
        for _ in 0..STEPS {
            job.check()?;
            let shares = self.shares_of_all(&lens, &sensing);
            if self.step(&mut lens, free, &shares).is_none() {
                break;
            }
        }
        Ok(lens)
    }

    /// Moves a lens by one step of Gauss–Newton, and returns the step; `None` where the equations are singular.
    fn step(
        &self,
        lens: &mut ColorLens,
        free: &[usize],
        shares: &[LensEquations],
    ) -> Option<[f64; UNKNOWNS]> {
        let equations = self.equations(lens, free, shares);
        let step = spread(free, &equations.factor()?.solve(&equations.right));
        *lens = lens.moved(&step, &self.claimed, self.distance);
        Some(step)
    }

    fn shares_of_all(&self, lens: &ColorLens, sensing: &Sensing) -> Vec<LensEquations> {
        let mut all = shares(&self.fitting, lens, sensing);
        all.extend(shares(&self.judging, lens, sensing));
        all
    }

    /// The normal equations of the free unknowns, with the pull toward the claimed lens.
    fn equations(&self, lens: &ColorLens, free: &[usize], shares: &[LensEquations]) -> NormalEquations {
        let now = lens.unknowns(&self.claimed, self.distance);
        let mut equations = NormalEquations::new(free.len());
        for (row, &unknown) in free.iter().enumerate() {
            let pull = TRUST[unknown].powi(-2);
            equations.add(row, row, pull);
            equations.right[row] -= pull * now[unknown];
        }
        for share in shares {
            for (row, &unknown) in free.iter().enumerate() {
                equations.right[row] += share.right[unknown];
                for (column, &other) in free.iter().enumerate().take(row + 1) {
                    equations.add(row, column, share.matrix[unknown][other]);
                }
            }
        }
        equations
    }

    /// Standard errors from the step that each pair alone would take. Residuals of one pair have one cause where a pose is wrong.
    fn standard_errors(&self, lens: &ColorLens, free: &[usize]) -> [f64; UNKNOWNS] {
        let shares = self.shares_of_all(lens, &self.sensing(0));
        let mut errors = [0.0; UNKNOWNS];
        let Some(factor) = self.equations(lens, free, &shares).factor() else { return errors };
        for share in &shares {
            let right: Vec<f64> = free.iter().map(|unknown| share.right[*unknown]).collect();
            let asked = spread(free, &factor.solve(&right));
            for (error, asked) in errors.iter_mut().zip(asked) {
                *error += asked * asked;
            }
        }
        let in_units = [1.0, 1.0, 1.0, 1.0, self.distance, self.distance, self.distance];
        let units = in_units.into_iter().chain([self.claimed.fx; 2]);
        // Both directions of a pair hold the same information.
        for (error, unit) in errors.iter_mut().zip(units) {
            *error = (2.0 * *error).sqrt().hypot(COMMON_ERROR_PX / self.claimed.fx) * unit;
        }
        errors
    }

    /// How far colors move from one lens to another, root mean square over all points, pixels.
    fn moved_px(&self, before: &ColorLens, after: &ColorLens) -> f64 {
        let points = self.fitting.iter().flat_map(|pair| pair.points.iter().step_by(8));
        let moves =
            points.filter_map(|[own, _]| Some(before.image(*own)?.distance_squared(after.image(*own)?)));
        let (sum, count) = moves.fold((0.0, 0.0), |(sum, count), square| (sum + square, count + 1.0_f64));
        (sum / count.max(1.0)).sqrt()
    }

    /// Judges two lenses by the pairs with cameras that took no part, at the matches that both lenses show.
    fn judged(&self, before: &ColorLens, after: &ColorLens) -> Judgment {
        let sensing = Sensing { stride: 1, ..self.sensing(1) };
        let of_pair = |pair: &Matches| {
            let [before, after] = [before, after].map(|lens| pair.differences(lens, &sensing));
            let both = common(&before, &after);
            let count = both.len() as f64;
            (count >= LEAST_SEEN * pair.count(&sensing) as f64).then(|| {
                let mean = |which: usize| {
                    both.iter().map(|values| loss(values[which], JUDGED_SIGMA)).sum::<f64>() / count
                };
                [mean(0), mean(1)]
            })
        };
        let losses: Vec<Option<[f64; 2]>> = self.judging.par_iter().map(of_pair).collect();
        let mut judgment = Judgment::of(&losses.into_iter().flatten().collect::<Vec<_>>());
        judgment.standard_error *= std::f64::consts::SQRT_2;
        judgment
    }
}

/// A step below this, in the scale of the unknowns, changes nothing.
const SETTLED: f64 = 2e-5;

fn pays(judgment: &Judgment) -> bool {
    let fall = judgment.before - judgment.after;
    judgment.samples >= 2
        && fall > STANDARD_ERRORS * judgment.standard_error
        && fall > LEAST_FALL * judgment.before
}

/// The values of free unknowns among all of them.
fn spread(free: &[usize], values: &[f64]) -> [f64; UNKNOWNS] {
    let mut all = [0.0; UNKNOWNS];
    for (unknown, value) in free.iter().zip(values) {
        all[*unknown] = *value;
    }
    all
}

/// Samples of the first camera that the second one's depth confirms. Beside edges of depth pictures tell most of a lens that is wrong:
/// they count, unless the matches are to judge. What lies behind without depth never counts.
pub(super) fn matches(problem: &Problem, pair: [usize; 2], judge: bool) -> Matches<'_> {
    let views = pair.map(|camera| &problem.views[camera]);
    let [own, other] = views;
    let other_from_own = other.camera.camera_from_world() * own.camera.world_from_camera;
    let confirmed = problem.samples[pair[0]].iter().filter_map(|sample| {
        let point = own.camera.intrinsics.ray_in_camera(sample.pixel) / sample.inverse_depth;
        let there = other_from_own.transform_point3(point);
        let image = other.camera.intrinsics.project(there)?;
        let levels = if judge {
            sample.pure_levels.min(other.pure_levels_at(image))
        } else {
            own.measured_levels_at(sample.pixel).min(other.measured_levels_at(image))
        };
        is_confirmed(other, image, there.z).then_some(([point, there], levels))
    });
    let (points, levels) = confirmed.unzip();
    Matches { views, points, levels }
}

/// Whether the view has this depth at an image position, away from edges and from what moves.
fn is_confirmed(view: &ReferenceView, image: DVec2, depth: f64) -> bool {
    let surface = view.surface_at(image);
    surface.is_some_and(|(_, _, here)| compare(here, depth, NOISY_PIXEL) == Sighting::Same)
}

/// The values of differences at the same matches, which are in order.
pub(super) fn common(before: &[BrightnessDifference], after: &[BrightnessDifference]) -> Vec<[f64; 2]> {
    let mut after = after.iter().peekable();
    let mut both = Vec::with_capacity(before.len());
    for own in before {
        while after.next_if(|other| other.match_index < own.match_index).is_some() {}
        if let Some(other) = after.next_if(|other| other.match_index == own.match_index) {
            both.push([own.value, other.value]);
        }
    }
    both
}

/// The weight of one match: neighbors are not independent, and a wrong pose is wrong for all matches of a pair.
const INDEPENDENT: f64 = 0.05;
/// Standard deviations of differences are never taken for less.
const LEAST_SIGMA: f64 = 0.05;

/// One pair's share of the normal equations of all unknowns. The lower triangle counts.
pub(super) struct LensEquations {
    pub(super) matrix: [[f64; UNKNOWNS]; UNKNOWNS],
    pub(super) right: [f64; UNKNOWNS],
}

/// The shares of all pairs, in their order.
pub(super) fn shares(pairs: &[Matches], lens: &ColorLens, sensing: &Sensing) -> Vec<LensEquations> {
    pairs.par_iter().map(|pair| share(&pair.differences(lens, sensing))).collect()
}

fn share(differences: &[BrightnessDifference]) -> LensEquations {
    let mut share = LensEquations { matrix: [[0.0; UNKNOWNS]; UNKNOWNS], right: [0.0; UNKNOWNS] };
    let mut sizes: Vec<f64> = differences.iter().map(|difference| difference.value.abs()).collect();
    let Some(middle) = median(&mut sizes) else { return share };
    let sigma = (middle / MEDIAN_PER_SIGMA).max(LEAST_SIGMA);
    for BrightnessDifference { value, by_unknown, .. } in differences {
        let relative = value / (TUKEY * sigma);
        if relative.abs() >= 1.0 {
            continue;
        }
        let weight = INDEPENDENT * (1.0 - relative * relative).powi(2) / (sigma * sigma);
        for row in 0..UNKNOWNS {
            let weighted = weight * by_unknown[row];
            for column in 0..=row {
                share.matrix[row][column] += weighted * by_unknown[column];
            }
            share.right[row] -= weighted * value;
        }
    }
    share
}
