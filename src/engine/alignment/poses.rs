//! Poses: found from coarse to fine, kept where samples that took no part agree that they are better.

use glam::{DAffine3, DQuat, DVec3};
use rayon::prelude::*;

use super::judge::Judgment;
use super::normal_equations::eigen;
use super::plausibility;
use super::regions::RegionShares;
use super::residuals::{GAIN, UNKNOWNS};
use super::solver::{Problem, SolverStage, Weighing, make_rigid, moved};
use crate::capture::Camera;
use crate::error::Result;
use crate::job::Job;

/// From errors of tens of footprints to hundredths.
const STAGES: [SolverStage; 5] = [
    SolverStage { gate: 60.0, level: 3, steps: 4 },
    SolverStage { gate: 30.0, level: 3, steps: 5 },
    SolverStage { gate: 15.0, level: 2, steps: 5 },
    SolverStage { gate: 8.0, level: 1, steps: 5 },
    SolverStage { gate: 8.0, level: 0, steps: 8 },
];

/// The stage that decides whether anything is wrong at all.
const FIRST_LOOK: SolverStage = SolverStage { gate: 15.0, level: 0, steps: 1 };

/// The stage that measures how far apart two cameras are: as far as poses are looked for, in full resolution.
pub(super) const WIDE_LOOK: SolverStage = SolverStage { level: 0, ..STAGES[0] };

/// A pose that moves samples by less than this, in footprints, does not show.
const LEAST_MOVE: f64 = 0.05;

/// All poses stay if none would move samples by more than this, in footprints. Point-sampled texture makes colors agree better by
/// as much in an exact rig.
const LEAST_WORST_MOVE: f64 = 0.25;

/// What was found of one camera's pose.
#[derive(Clone, Debug)]
pub(crate) struct PoseCorrection {
    pub(crate) kept: bool,
    /// Whether it would pay, but the pictures do not determine the pose in some direction.
    pub(crate) is_weak: bool,
    /// Whether it would pay, but is farther off than the poses of rigs are.
    pub(crate) is_implausible: bool,
    /// How far samples of the camera move, root mean square, footprints.
    pub(crate) footprints: f64,
    /// Standard errors of rotation (radians) and translation (units), per axis, the largest.
    pub(crate) standard_errors: [f64; 2],
    pub(crate) judgment: Judgment,
}

impl Problem {
    /// How residuals are weighed in the end.
    pub(crate) fn finest_weighing(&self) -> Weighing {
        self.weighing(&STAGES[STAGES.len() - 1])
    }

    /// Whether nothing would move where it shows.
    pub(crate) fn is_settled(&self) -> bool {
        let equations = self.equations(&self.weighing(&FIRST_LOOK));
        let Some(factor) = equations.factor() else { return true };
        let step = factor.solve(&equations.right);
        (0..self.views.len()).all(|camera| {
            let pose = &self.views[camera].camera.world_from_camera;
            let after = moved(pose, &step[camera * UNKNOWNS..][..GAIN], self.scale);
            self.displacement(camera, pose, &after) < LEAST_MOVE
        })
    }

    /// How far samples of a camera move from one pose to another, root mean square, footprints.
    pub(crate) fn displacement(&self, camera: usize, before: &DAffine3, after: &DAffine3) -> f64 {
        let change = before.inverse() * *after;
        let lens = &self.views[camera].camera.intrinsics;
        let samples = &self.samples[camera];
        let square = |sample: &super::surface_samples::SurfaceSample| {
            let point = lens.ray_in_camera(sample.pixel) / sample.inverse_depth;
            let footprint = 1.0 / (sample.inverse_depth * lens.fx);
            ((change.transform_point3(point) - point) / footprint).length_squared()
        };
        let sum: f64 = samples.iter().map(square).sum();
        (sum / samples.len().max(1) as f64).sqrt()
    }

    /// Searches poses from coarse to fine.
    pub(crate) fn solve(&mut self, job: &Job) -> Result<Weighing> {
        STAGES.iter().try_for_each(|stage| self.iterate(stage, job))?;
        Ok(self.finest_weighing())
    }
}

/// Turns and shifts all cameras together so that most of them stay where they were: the poses are known only relative to each
/// other.
pub(crate) fn hold_most(problem: &mut Problem, original: &[Camera]) {
    const ROUNDS: usize = 20;
    for _ in 0..ROUNDS {
        let offs: Vec<(DVec3, DVec3, f64)> = problem
            .views
            .iter()
            .enumerate()
            .map(|(index, view)| {
                let (now, then) = (view.camera.world_from_camera, original[index].world_from_camera);
                let turn = DQuat::from_mat3(&(then.matrix3 * now.matrix3.transpose())).to_scaled_axis();
                let off = problem.displacement(index, &now, &then);
                (turn, then.translation - now.translation, 1.0 / off.max(0.05))
            })
            .collect();
        let total: f64 = offs.iter().map(|(_, _, weight)| weight).sum();
        let turn: DVec3 = offs.iter().map(|(turn, _, weight)| *turn * *weight).sum::<DVec3>() / total;
        let weighted = |of: &dyn Fn(usize) -> DVec3| -> DVec3 {
            offs.iter().enumerate().map(|(index, (_, _, weight))| of(index) * *weight).sum::<DVec3>() / total
        };
        let center = weighted(&|index| problem.views[index].camera.position_in_world());
        let shift = weighted(&|index| offs[index].1);
        let rotation = DQuat::from_scaled_axis(turn);
        let change = DAffine3::from_translation(center + shift)
            * DAffine3::from_quat(rotation)
            * DAffine3::from_translation(-center);
        for view in &mut problem.views {
            let mut pose = change * view.camera.world_from_camera;
            make_rigid(&mut pose);
            view.camera.world_from_camera = pose;
        }
    }
}

/// Directions in which a camera's pose is known no better than this, in footprints, are weak.
const WEAK: f64 = 0.7;

/// Finds poses. Those that do not pay are as they were, bit for bit.
pub(crate) fn align_poses(problem: &mut Problem, job: &Job) -> Result<Vec<PoseCorrection>> {
    let original: Vec<Camera> = problem.views.iter().map(|view| view.camera.clone()).collect();
    let none = |problem: &Problem| vec![PoseCorrection::none(); problem.views.len()];
    if problem.pairs.is_empty() || problem.is_settled() {
        return Ok(none(problem));
    }
    let before = (problem.log_gains.clone(), problem.moved.clone());
    let weighing = problem.solve(job)?;
    // Cameras that stay hold the others.
    if problem.is_free.iter().all(|is_free| *is_free) {
        hold_most(problem, &original);
    }
    let Some(factor) = problem.equations(&weighing).factor() else {
        problem.views.iter_mut().zip(original).for_each(|(view, camera)| view.camera = camera);
        (problem.log_gains, problem.moved) = before;
        return Ok(none(problem));
    };
    let terms = problem.terms_per_sample(&weighing);
    let regions = RegionShares::new(problem, &weighing);
    let judged = (0..problem.views.len()).into_par_iter().map(|camera| {
        let now = problem.views[camera].camera.world_from_camera;
        let then = original[camera].world_from_camera;
        let block = factor.inverse_block::<GAIN>(camera * UNKNOWNS);
        let weakest = eigen(block).iter().map(|(value, _)| value.max(0.0)).fold(0.0, f64::max);
        let inflated = terms.sqrt();
        let errors = regions.pose_errors(&factor, camera);
        let largest = |start: usize| errors[start..start + 3].iter().copied().fold(0.0, f64::max);
        let footprints = problem.displacement(camera, &now, &then);
        let judgment = Judgment::of_pose(problem, &weighing, camera, then);
        let is_known = weakest.sqrt() * inflated < WEAK.max(0.3 * footprints);
        let is_wanted = judgment.pays() && footprints > LEAST_MOVE;
        let is_plausible = plausibility::is_of_a_rig(&(then.inverse() * now), problem.scale.inverse_depth);
        PoseCorrection {
            kept: is_wanted && is_known && is_plausible,
            is_weak: is_wanted && !is_known,
            is_implausible: is_wanted && is_known && !is_plausible,
            footprints,
            standard_errors: [
                largest(0) / problem.scale.focal,
                largest(3) / (problem.scale.focal * problem.scale.inverse_depth),
            ],
            judgment,
        }
    });
    let mut corrections: Vec<PoseCorrection> = judged.collect();
    let kept = corrections.iter().filter(|correction| correction.kept);
    if kept.fold(0.0, |most: f64, correction| most.max(correction.footprints)) < LEAST_WORST_MOVE {
        for correction in &mut corrections {
            correction.kept = false;
        }
    }
    for (camera, correction) in corrections.iter().enumerate() {
        if !correction.kept {
            problem.views[camera].camera = original[camera].clone();
        }
    }
    Ok(corrections)
}

impl PoseCorrection {
    fn none() -> Self {
        Self {
            kept: false,
            is_weak: false,
            is_implausible: false,
            footprints: 0.0,
            standard_errors: [0.0; 2],
            judgment: Judgment::default(),
        }
    }
}
