//! Moves no more cameras than samples that judge ask for.
//!
//! Purpose: where one camera is wrong, all poses that are solved for drift a little along what surfaces hardly tell, most of all nearer
//! to or farther from what the rig looks at. Source: none; forward selection by size. What differs: where most cameras move, none is taken
//! for right, as all others would turn with it.

use glam::DAffine3;

use super::judge::PoseJudgment;
use super::poses::STAGES;
use super::solver::{Problem, SolverStage, Weighing};
use crate::error::Result;
use crate::job::Job;

/// Cameras are let go that moved by at least this share of the farthest, one share after the other.
const SHARES: [f64; 3] = [0.5, 0.25, 0.12];
/// Cameras that are let go start close to where they belong.
const FINEST: SolverStage = STAGES[STAGES.len() - 1];

impl Problem {
    /// Puts those cameras back that need not move, and lets the others find their places between them. `weighing` is that of all poses as
    /// they are now; that of the remaining moves is returned.
    ///
    /// # Errors
    /// `Cancelled`.
    pub(super) fn move_fewest(
        &mut self,
        weighing: &Weighing,
        claimed: &[DAffine3],
        job: &Job,
    ) -> Result<Weighing> {
        let (found, may_move, moved) = (self.poses(), self.is_free.clone(), self.moved.clone());
        let offs: Vec<f64> = (0..found.len())
            .map(|camera| self.displacement(camera, &found[camera], &claimed[camera]))
            .collect();
        let most = offs.iter().copied().fold(0.0, f64::max);
        for share in SHARES {
            let goes = |camera: usize| may_move[camera] && offs[camera] >= share * most;
            let going = (0..found.len()).filter(|camera| goes(*camera)).count();
            if 2 * going > may_move.iter().filter(|may_move| **may_move).count() {
                break;
            }
            self.put_back(claimed, |camera| !goes(camera));
            self.is_free = (0..found.len()).map(goes).collect();
            self.iterate(&FINEST, job)?;
            let beside_all = PoseJudgment::new(self, weighing, &found, |_| true);
            if !beside_all.reversed().may_pay() {
                return Ok(self.finest_weighing());
            }
            for (view, pose) in self.views.iter_mut().zip(&found) {
                view.camera.world_from_camera = *pose;
            }
            (self.is_free, self.moved) = (may_move.clone(), moved.clone());
        }
        Ok(self.finest_weighing())
    }
}
