//! Poses: found from coarse to fine, kept where samples that took no part agree that they are better.

use glam::{DAffine3, DQuat, DVec3};
use rayon::prelude::*;

use super::judge::{Judgment, PoseJudgment, is_of_a_rig};
use super::normal_equations::{NormalEquations, eigen};
use super::reference_view::LEVELS;
use super::regions::RegionShares;
use super::residuals::{GAIN, UNKNOWNS};
use super::solver::{Problem, SolverStage, Weighing, make_rigid, moved};
use super::surface_samples::has_noisy_depth;
use crate::capture::{Camera, Capture};
use crate::error::Result;
use crate::job::Job;

/// From errors of tens of footprints to hundredths.
pub(super) const STAGES: [SolverStage; 5] = [
    SolverStage { gate: 60.0, level: 3, steps: 4 },
    SolverStage { gate: 30.0, level: 3, steps: 5 },
    SolverStage { gate: 15.0, level: 2, steps: 5 },
    SolverStage { gate: 8.0, level: 1, steps: 5 },
    SolverStage { gate: 8.0, level: 0, steps: 8 },
];

/// The stages that decide whether anything is wrong at all: what is off by pixels shows in coarse pictures alone.
const FIRST_LOOKS: [SolverStage; 2] =
    [SolverStage { gate: 15.0, level: 0, steps: 1 }, SolverStage { gate: 30.0, level: 2, steps: 1 }];

/// The stage that measures how far apart two cameras are: as far as poses are looked for, in full resolution.
pub(super) const WIDE_LOOK: SolverStage = SolverStage { level: 0, ..STAGES[0] };

/// A pose that moves samples by less than this, in footprints, does not show.
const LEAST_MOVE: f64 = 0.05;

/// All poses stay if none would move samples by more than this, in footprints. Point-sampled texture makes colors agree better by
/// as much in an exact rig.
const LEAST_WORST_MOVE: f64 = 0.25;

/// Standard error that all regions have in common, so that their spread does not show it, in footprints: interpolation between pixels,
/// and rounding of pictures.
const COMMON_ERROR: f64 = 0.05;

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
    /// The same by distances alone.
    pub(crate) distances: Judgment,
}

impl Problem {
    /// Lets colors beside edges count in views of a sensor: its poses are off by far more than such colors are, and edges tell the most.
    /// Lenses and exposures are off by less.
    fn count_colors_beside_noisy_edges(&mut self) {
        let views = self.views.par_iter_mut().zip(&mut self.samples);
        views.filter(|(view, samples)| has_noisy_depth(view, samples.len())).for_each(|(view, samples)| {
            view.count_colors_beside_edges();
            for sample in samples {
                sample.pure_levels = LEVELS;
            }
        });
    }

    /// How residuals are weighed in the end.
    pub(crate) fn finest_weighing(&self) -> Weighing {
        self.weighing(&STAGES[STAGES.len() - 1])
    }

    /// Whether nothing would move where it shows.
    pub(crate) fn is_settled(&self) -> bool {
        FIRST_LOOKS.iter().all(|stage| {
            let equations = self.equations(&self.weighing(stage));
            let Some(factor) = equations.factor() else { return true };
            let step = factor.solve(&equations.right);
            let least = LEAST_MOVE * f64::from(1 << stage.level);
            (0..self.views.len()).all(|camera| {
                let pose = &self.views[camera].camera.world_from_camera;
                let after = moved(pose, &step[camera * UNKNOWNS..][..GAIN], self.scale);
                self.displacement(camera, pose, &after) < least
            })
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

/// Turns and shifts all cameras together so that they move least from where they were: the poses are known only relative to each other.
pub(crate) fn hold_most(problem: &mut Problem, claimed: &[DAffine3]) {
    const ROUNDS: usize = 20;
    for _ in 0..ROUNDS {
        let Some(change) = problem.move_of_all(claimed) else { return };
        for view in &mut problem.views {
            let mut pose = change * view.camera.world_from_camera;
            make_rigid(&mut pose);
            view.camera.world_from_camera = pose;
        }
    }
}

impl Problem {
    /// What brings all cameras together nearer to where they were. Turns count beside shifts, and both by their sizes rather than squares:
    /// cameras that stayed hold the others, and so do the places of cameras that all turned.
    fn move_of_all(&self, claimed: &[DAffine3]) -> Option<DAffine3> {
        let (poses, inverse_depth) = (self.poses(), self.scale.inverse_depth);
        let center = poses.iter().map(|pose| pose.translation).sum::<DVec3>() / poses.len() as f64;
        let least = LEAST_MOVE / self.scale.focal;
        let mut equations = NormalEquations::new(GAIN);
        for (now, then) in poses.iter().zip(claimed) {
            let turn = DQuat::from_mat3(&(then.matrix3 * now.matrix3.transpose())).to_scaled_axis();
            let shift = (then.translation - now.translation) * inverse_depth;
            let arm = (now.translation - center) * inverse_depth;
            let shift_by_turn = DVec3::AXES.map(|axis| axis.cross(arm));
            for (off, by) in [
                (turn, [DVec3::AXES, [DVec3::ZERO; 3]].concat()),
                (shift, [shift_by_turn, DVec3::AXES].concat()),
            ] {
                let weight = 1.0 / off.length().max(least);
                for (row, own) in by.iter().enumerate() {
                    equations.right[row] += weight * own.dot(off);
                    for (column, other) in by.iter().enumerate().take(row + 1) {
                        equations.add(row, column, weight * own.dot(*other));
                    }
                }
            }
        }
        let step = equations.factor()?.solve(&equations.right);
        let shift = DVec3::from_slice(&step[3..]) / inverse_depth;
        let turn = DAffine3::from_quat(DQuat::from_scaled_axis(DVec3::from_slice(&step)));
        Some(DAffine3::from_translation(center + shift) * turn * DAffine3::from_translation(-center))
    }
}

/// Directions in which a camera's pose is known no better than this, in footprints, are weak.
const WEAK: f64 = 0.7;

/// Finds poses. Those that do not pay are as they were, bit for bit.
pub(crate) fn align_poses(problem: &mut Problem, job: &Job) -> Result<Vec<PoseCorrection>> {
    problem.count_colors_beside_noisy_edges();
    let claimed = problem.poses();
    let may_move = problem.is_free.clone();
    if problem.pairs.is_empty() || problem.is_settled() {
        return Ok(vec![PoseCorrection::none(); claimed.len()]);
    }
    let before = (problem.log_gains.clone(), problem.moved.clone());
    let weighing = problem.solve(job)?;
    let are_all_free = may_move.iter().all(|may_move| *may_move);
    let everyone = |_: &[usize; 2]| true;
    let corrections = if PoseJudgment::new(problem, &weighing, &claimed, everyone).pays() {
        // Cameras that stay hold the others.
        if are_all_free {
            hold_most(problem, &claimed);
        }
        let weighing = problem.move_fewest(&weighing, &claimed, job)?;
        problem.judged_poses(&weighing, &claimed)
    } else {
        None
    };
    problem.is_free = may_move;
    let Some(mut corrections) = corrections else {
        problem.put_back(&claimed, |_| true);
        (problem.log_gains, problem.moved) = before;
        return Ok(vec![PoseCorrection::none(); claimed.len()]);
    };
    let kept = corrections.iter().filter(|correction| correction.kept);
    if kept.fold(0.0, |most: f64, correction| most.max(correction.footprints)) < LEAST_WORST_MOVE {
        for correction in &mut corrections {
            correction.kept = false;
        }
    }
    problem.put_back(&claimed, |camera| !corrections[camera].kept);
    Ok(corrections)
}

impl Problem {
    /// Each camera's pose beside the claimed one; `None` where the poses are not determined.
    fn judged_poses(&self, weighing: &Weighing, claimed: &[DAffine3]) -> Option<Vec<PoseCorrection>> {
        let factor = self.equations(weighing).factor()?;
        let inflated = self.terms_per_sample(weighing).sqrt();
        let regions = RegionShares::new(self, weighing);
        let now = self.poses();
        let judged = (0..claimed.len()).into_par_iter().map(|camera| {
            if now[camera] == claimed[camera] {
                return PoseCorrection::none();
            }
            let block = factor.inverse_block::<GAIN>(camera * UNKNOWNS);
            let weakest = eigen(block).iter().map(|(value, _)| value.max(0.0)).fold(0.0, f64::max);
            let errors = regions.pose_errors(&factor, camera);
            let largest = |start: usize| {
                errors[start..start + 3].iter().copied().fold(0.0, f64::max).hypot(COMMON_ERROR)
            };
            let footprints = self.displacement(camera, &now[camera], &claimed[camera]);
            // Beside all others as they are now, and beside the rig as it is claimed.
            let mut but_one = now.clone();
            but_one[camera] = claimed[camera];
            let [alone, in_all] = [&but_one[..], claimed]
                .map(|then| PoseJudgment::new(self, weighing, then, |pair| pair.contains(&camera)));
            let is_known = weakest.sqrt() * inflated < WEAK.max(0.3 * footprints);
            let is_wanted = alone.may_pay() && in_all.pays_for_one() && footprints > LEAST_MOVE;
            let change = claimed[camera].inverse() * now[camera];
            let is_plausible = is_of_a_rig(&change, self.scale.inverse_depth);
            PoseCorrection {
                kept: is_wanted && is_known && is_plausible,
                is_weak: is_wanted && !is_known,
                is_implausible: is_wanted && is_known && !is_plausible,
                footprints,
                standard_errors: [
                    largest(0) / self.scale.focal,
                    largest(3) / (self.scale.focal * self.scale.inverse_depth),
                ],
                judgment: in_all.all,
                distances: in_all.distances,
            }
        });
        Some(judged.collect())
    }
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
            distances: Judgment::default(),
        }
    }
}

/// The poses that were found but are farther off than those of rigs, a sentence each.
pub(super) fn refusals(capture: &Capture, poses: &[PoseCorrection]) -> Vec<String> {
    let refused = capture.cameras.iter().zip(poses).filter(|(_, pose)| pose.is_implausible);
    let sentence = |(camera, pose): (&Camera, &PoseCorrection)| {
        format!(
            "{}: pose left as it is: it would be {:.0} footprints off, more than rigs are; check how poses and depth are read",
            camera.name, pose.footprints
        )
    };
    refused.map(sentence).collect()
}
