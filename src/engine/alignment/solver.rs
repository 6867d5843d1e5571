//! Gauss–Newton over all cameras at once.
//!
//! Purpose: the poses under which cameras agree best. Source: iteratively reweighted least squares with
//! Tukey's biweight, whose width is measured by the median of the residuals; from coarse pictures and wide gates to fine ones.
//! What differs: a weak pull toward the claimed values holds unknowns that no residual determines.

use glam::{DAffine3, DMat3, DQuat, DVec3};
use rayon::prelude::*;

use super::normal_equations::NormalEquations;
use super::reference_view::ReferenceView;
use super::residuals::{GAIN, PairOfViews, ProblemScale, Term, UNKNOWNS};
use super::surface_samples::SurfaceSample;
use crate::error::Result;
use crate::job::Job;
use crate::median::{MEDIAN_PER_SIGMA, median};

/// Everything that is solved for.
#[derive(Clone)]
pub(crate) struct Problem {
    pub(crate) views: Vec<ReferenceView>,
    pub(crate) samples: Vec<Vec<SurfaceSample>>,
    /// Cameras whose samples are carried, and where to.
    pub(crate) pairs: Vec<[usize; 2]>,
    pub(crate) scale: ProblemScale,
    /// Logarithm of each camera's gain of brightness.
    pub(crate) log_gains: Vec<f64>,
    /// What has been added to each camera's unknowns of the pose, in the order of [`UNKNOWNS`], up to now.
    pub(crate) moved: Vec<[f64; 6]>,
    /// Cameras whose poses may change.
    pub(crate) is_free: Vec<bool>,
    /// Regions that samples lie in.
    pub(crate) regions: usize,
    /// Whether the depth of targets is left out.
    pub(crate) color_alone: bool,
}

/// One stage of the search: how coarse it is, and how long.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SolverStage {
    /// Distances beyond this, in footprints, are other surfaces.
    pub(crate) gate: f64,
    /// Resolution of the brightness that is compared.
    pub(crate) level: usize,
    /// Steps at most.
    pub(crate) steps: usize,
}

impl SolverStage {
    /// The least standard deviation of distances, footprints. Before flat scenes most distances stay exact while a camera slides
    /// along them. The few that tell would be strays: coarse stages count them.
    fn least_sigma(&self) -> f64 {
        if self.level > 0 { self.gate / 30.0 } else { 0.0 }
    }
}

/// How the residuals of one pair are weighed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PairWeighing {
    /// Distances beyond this, in footprints, are other surfaces.
    pub(crate) gate: f64,
    /// Standard deviations of distances, footprints, and of brightness.
    pub(crate) sigmas: [f64; 2],
}

/// How residuals are weighed: pair by pair, so that those of one wrong camera are not taken for strays of the others.
#[derive(Clone, Debug)]
pub(crate) struct Weighing {
    /// Resolution of the brightness that is compared.
    pub(crate) level: usize,
    /// In the order of [`Problem::pairs`].
    pub(crate) pairs: Vec<PairWeighing>,
}

/// Residuals beyond this many standard deviations do not count: Tukey's constant for 95 % efficiency.
pub(crate) const TUKEY: f64 = 4.685;
/// Standard deviations are never taken for less: rounding of pictures and of positions.
const LEAST_SIGMAS: [f64; 2] = [0.02, 0.004];
/// The most that a standard deviation is taken for, and its value with fewer than [`LEAST_READINGS`] residuals.
const WIDEST: [f64; 2] = [20.0, 0.3];
const LEAST_READINGS: usize = 20;
/// Distances up to this may be of one surface whatever the noise, footprints.
const LEAST_GATE: f64 = 2.0;
/// How far the capture may be wrong: standard deviations of the pull toward it, footprints and logarithm of gain.
const TRUST: [f64; 2] = [1.0, 0.5];
/// Pull of the mean toward where it was: only relative poses are known.
const MEAN_WEIGHT: f64 = 1e4;

/// One pair's share of the normal equations.
struct PairEquations {
    matrix: [[f64; 2 * UNKNOWNS]; 2 * UNKNOWNS],
    right: [f64; 2 * UNKNOWNS],
    terms: f64,
}

impl PairEquations {
    fn new() -> Self {
        Self { matrix: [[0.0; 2 * UNKNOWNS]; 2 * UNKNOWNS], right: [0.0; 2 * UNKNOWNS], terms: 0.0 }
    }

    fn add(&mut self, term: &Term, sigma: f64) {
        let weight = robust_weight(term.residual, sigma);
        if weight == 0.0 {
            return;
        }
        let mut all = [0.0; 2 * UNKNOWNS];
        all[..UNKNOWNS].copy_from_slice(&term.source);
        all[UNKNOWNS..].copy_from_slice(&term.target);
        for row in 0..2 * UNKNOWNS {
            let weighted = weight * all[row];
            for column in 0..2 * UNKNOWNS {
                self.matrix[row][column] += weighted * all[column];
            }
            self.right[row] -= weighted * term.residual;
        }
        self.terms += 1.0;
    }
}

/// Tukey's weight of a residual: the reciprocal of the variance for small ones, 0 for strays.
pub(crate) fn robust_weight(residual: f64, sigma: f64) -> f64 {
    let relative = (residual / (TUKEY * sigma)).abs().min(1.0);
    (1.0 - relative * relative).powi(2) / (sigma * sigma)
}

/// Tukey's loss of a residual, from 0 to 1.
pub(crate) fn loss(residual: f64, sigma: f64) -> f64 {
    let relative = (residual / (TUKEY * sigma)).abs().min(1.0);
    1.0 - (1.0 - relative * relative).powi(3)
}

impl Problem {
    pub(crate) fn pair(&self, pair: [usize; 2]) -> PairOfViews<'_> {
        self.pair_at(pair, pair.map(|camera| self.views[camera].camera.world_from_camera))
    }

    /// A pair with other poses.
    pub(crate) fn pair_at(&self, pair: [usize; 2], world_from_cameras: [DAffine3; 2]) -> PairOfViews<'_> {
        let gains = pair.map(|camera| self.log_gains[camera]);
        let views = pair.map(|camera| &self.views[camera]);
        PairOfViews::new(views, world_from_cameras, gains, self.scale, self.color_alone)
    }

    /// The poses of all cameras.
    pub(crate) fn poses(&self) -> Vec<DAffine3> {
        self.views.iter().map(|view| view.camera.world_from_camera).collect()
    }

    /// Puts cameras where they claim to be.
    pub(crate) fn put_back(&mut self, claimed: &[DAffine3], is_put_back: impl Fn(usize) -> bool) {
        for camera in (0..self.views.len()).filter(|camera| is_put_back(*camera)) {
            self.views[camera].camera.world_from_camera = claimed[camera];
            self.moved[camera] = [0.0; 6];
        }
    }

    /// Magnitudes of a pair's distances (footprints) and differences of brightness, of every `step`-th sample that is seen.
    pub(crate) fn magnitudes(&self, pair: [usize; 2], stage: &SolverStage, step: usize) -> [Vec<f64>; 2] {
        let views = self.pair(pair);
        let mut found = [Vec::new(), Vec::new()];
        for sample in self.samples[pair[0]].iter().step_by(step) {
            if let Some(terms) = views.terms(sample, stage.level, stage.gate) {
                found[0].extend(terms.distance.map(|term| term.residual.abs()));
                found[1].extend(terms.color.map(|term| term.residual.abs()));
            }
        }
        found
    }

    /// How residuals are weighed, as wide as they are now.
    pub(crate) fn weighing(&self, stage: &SolverStage) -> Weighing {
        let of_pair = |pair: &[usize; 2]| {
            // A part of the samples is enough to measure the width.
            let mut found = self.magnitudes(*pair, stage, 2);
            let widest = [0.3 * stage.gate.min(WIDEST[0]), WIDEST[1]];
            let least = [LEAST_SIGMAS[0].max(stage.least_sigma()), LEAST_SIGMAS[1]];
            let mut sigmas = widest;
            for (kind, magnitudes) in found.iter_mut().enumerate() {
                if magnitudes.len() >= LEAST_READINGS {
                    let sigma = median(magnitudes).unwrap_or_default() / MEDIAN_PER_SIGMA;
                    sigmas[kind] = sigma.clamp(least[kind], widest[kind]);
                }
            }
            PairWeighing { gate: stage.gate.min((TUKEY * sigmas[0]).max(LEAST_GATE)), sigmas }
        };
        Weighing { level: stage.level, pairs: self.pairs.par_iter().map(of_pair).collect() }
    }

    /// Where each of a camera's unknowns is among those that are solved for.
    fn places(&self, camera: usize) -> [Option<usize>; UNKNOWNS] {
        std::array::from_fn(|unknown| {
            (unknown == GAIN || self.is_free[camera]).then_some(camera * UNKNOWNS + unknown)
        })
    }

    /// The normal equations of all pairs.
    pub(crate) fn equations(&self, weighing: &Weighing) -> NormalEquations {
        let of_pair = |(pair, weighed): (&[usize; 2], &PairWeighing)| {
            let views = self.pair(*pair);
            let mut share = PairEquations::new();
            for sample in self.samples[pair[0]].iter().filter(|sample| !sample.judges) {
                let Some(terms) = views.terms(sample, weighing.level, weighed.gate) else { continue };
                for (term, sigma) in [terms.distance, terms.color].into_iter().zip(weighed.sigmas) {
                    if let Some(term) = term {
                        share.add(&term, sigma);
                    }
                }
            }
            share
        };
        let shares: Vec<PairEquations> = self.pairs.par_iter().zip(&weighing.pairs).map(of_pair).collect();
        let mut equations = NormalEquations::new(self.views.len() * UNKNOWNS);
        for (pair, share) in self.pairs.iter().zip(&shares) {
            let places: Vec<Option<usize>> = pair.iter().flat_map(|camera| self.places(*camera)).collect();
            for (row, place) in places.iter().enumerate() {
                let Some(place) = *place else { continue };
                equations.right[place] += share.right[row];
                for (column, other) in places.iter().enumerate() {
                    if let Some(other) = other.filter(|other| *other <= place) {
                        equations.add(place, other, share.matrix[row][column]);
                    }
                }
            }
        }
        self.add_priors(&mut equations);
        equations
    }

    fn add_priors(&self, equations: &mut NormalEquations) {
        let cameras = self.views.len();
        let pull = [1.0 / (TRUST[0] * TRUST[0]), 1.0 / (TRUST[1] * TRUST[1])];
        for unknown in 0..equations.size() {
            let (camera, of_camera) = (unknown / UNKNOWNS, unknown % UNKNOWNS);
            let is_gain = of_camera == GAIN;
            let (pull, off) = if is_gain {
                (pull[1], self.log_gains[camera])
            } else {
                (pull[0], self.moved[camera][of_camera])
            };
            equations.add(unknown, unknown, pull);
            equations.right[unknown] -= pull * off;
        }
        // The mean of all gains is fixed, and that of all poses where none is fixed.
        let weight = MEAN_WEIGHT / cameras as f64;
        for a in 0..cameras {
            for b in 0..=a {
                equations.add(a * UNKNOWNS + GAIN, b * UNKNOWNS + GAIN, weight);
            }
        }
        if self.is_free.iter().any(|free| !free) {
            return;
        }
        let axes: Vec<DMat3> = self.views.iter().map(|view| view.camera.world_from_camera.matrix3).collect();
        for a in 0..cameras {
            for b in 0..=a {
                let product = axes[a].transpose() * axes[b];
                for row in 0..3 {
                    for column in 0..3 {
                        if a == b && column > row {
                            continue;
                        }
                        let value = weight * product.col(column)[row];
                        for part in [0, 3] {
                            equations.add(a * UNKNOWNS + part + row, b * UNKNOWNS + part + column, value);
                        }
                    }
                }
            }
        }
    }

    /// Moves all cameras by a solution.
    fn step(&mut self, step: &[f64]) {
        for camera in 0..self.views.len() {
            let own: [f64; UNKNOWNS] = std::array::from_fn(|unknown| step[camera * UNKNOWNS + unknown]);
            self.log_gains[camera] += own[GAIN];
            if self.is_free[camera] {
                let pose = &mut self.views[camera].camera.world_from_camera;
                *pose = moved(pose, &own[..GAIN], self.scale);
                for (total, part) in self.moved[camera].iter_mut().zip(own) {
                    *total += part;
                }
            }
        }
    }

    /// Steps until nothing moves any more.
    ///
    /// # Errors
    /// `Cancelled`.
    pub(crate) fn iterate(&mut self, stage: &SolverStage, job: &Job) -> Result<()> {
        for _ in 0..stage.steps {
            job.check()?;
            let equations = self.equations(&self.weighing(stage));
            let Some(factor) = equations.factor() else { break };
            let step = factor.solve(&equations.right);
            self.step(&step);
            let poses = step.chunks(UNKNOWNS).flat_map(|own| &own[..GAIN]);
            let largest = poses.fold(0.0_f64, |a, b| a.max(b.abs()));
            if largest < SETTLED[usize::from(stage.level > 0)] {
                break;
            }
        }
        Ok(())
    }
}

/// A step below this, in footprints, changes nothing in the finest picture, and nothing in coarser ones that finer ones do not decide.
const SETTLED: [f64; 2] = [0.003, 0.05];

/// A pose moved by rotation and translation in camera space, which count in footprints.
pub(crate) fn moved(pose: &DAffine3, step: &[f64], scale: ProblemScale) -> DAffine3 {
    let rotation = DVec3::from_slice(&step[..3]) / scale.focal;
    let translation = DVec3::from_slice(&step[3..6]) / (scale.focal * scale.inverse_depth);
    let mut moved =
        *pose * DAffine3::from_rotation_translation(DQuat::from_scaled_axis(rotation), translation);
    make_rigid(&mut moved);
    moved
}

/// Takes out the shear that rounding adds up to.
pub(crate) fn make_rigid(pose: &mut DAffine3) {
    let (_, rotation, _) = pose.to_scale_rotation_translation();
    pose.matrix3 = DMat3::from_quat(rotation.normalize());
}
