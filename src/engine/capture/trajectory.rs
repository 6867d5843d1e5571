//! Where a moving camera was at any time: stamps are paired, and poses lie between the recorded ones.

use glam::{DAffine3, DMat3, DQuat};

/// Poses by time.
#[derive(Clone, Debug, Default)]
pub(crate) struct Trajectory {
    times: Vec<f64>,
    poses: Vec<DAffine3>,
}

impl Trajectory {
    /// Sorts poses by time, in seconds; of several at one time the first counts.
    pub(crate) fn new(mut stamped: Vec<(f64, DAffine3)>) -> Self {
        stamped.sort_by(|a, b| a.0.total_cmp(&b.0));
        stamped.dedup_by(|later, first| later.0 == first.0);
        let (times, poses) = stamped.into_iter().unzip();
        Self { times, poses }
    }

    /// The pose at `time`: between the two around it, by the shortest rotation and along a straight line, where both are within
    /// `limit` seconds; else the nearest within `limit`.
    pub(crate) fn at(&self, time: f64, limit: f64) -> Option<DAffine3> {
        let after = self.times.partition_point(|other| *other < time);
        if after > 0 && after < self.times.len() {
            let (start, end) = (self.times[after - 1], self.times[after]);
            if time - start <= limit && end - time <= limit {
                let share = (time - start) / (end - start);
                return Some(between(&self.poses[after - 1], &self.poses[after], share));
            }
        }
        nearest(&self.times, time, limit).map(|index| self.poses[index])
    }
}

/// The rigid pose at `share` of the way from `a` to `b`.
fn between(a: &DAffine3, b: &DAffine3, share: f64) -> DAffine3 {
    let rotation = DQuat::from_mat3(&a.matrix3).slerp(DQuat::from_mat3(&b.matrix3), share);
    let translation = a.translation.lerp(b.translation, share);
    DAffine3::from_mat3_translation(DMat3::from_quat(rotation.normalize()), translation)
}

/// The index of the time nearest to `time`, where it is within `limit` seconds; of two equally near ones the earlier. `times` are
/// finite and ascending.
pub(crate) fn nearest(times: &[f64], time: f64, limit: f64) -> Option<usize> {
    let after = times.partition_point(|other| *other < time);
    let around = [after.checked_sub(1), (after < times.len()).then_some(after)];
    let apart = |index: &usize| (times[*index] - time).abs();
    around
        .into_iter()
        .flatten()
        .min_by(|a, b| apart(a).total_cmp(&apart(b)))
        .filter(|index| apart(index) <= limit)
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    #[test]
    fn a_pose_between_two_is_halfway_in_place_and_turn() {
        let pose = |angle: f64, x: f64| {
            DAffine3::from_mat3_translation(DMat3::from_rotation_z(angle), DVec3::new(x, 0.0, 0.0))
        };
        let trajectory = Trajectory::new(vec![(2.0, pose(0.4, 3.0)), (1.0, pose(0.0, 1.0))]);
        assert!(trajectory.at(1.5, 0.6).unwrap().abs_diff_eq(pose(0.2, 2.0), 1e-12));
        assert!(trajectory.at(2.05, 0.1).unwrap().abs_diff_eq(pose(0.4, 3.0), 1e-12));
        assert_eq!(trajectory.at(1.5, 0.1), None, "a gap is not bridged");
        assert_eq!(Trajectory::default().at(1.0, 1.0), None);
    }

    #[test]
    fn the_nearest_stamp_counts_within_its_limit() {
        let times = [1.0, 2.0, 2.5];
        assert_eq!(nearest(&times, 2.2, 0.5), Some(1));
        assert_eq!(nearest(&times, 1.5, 0.5), Some(0), "the earlier of two");
        assert_eq!(nearest(&times, 9.0, 0.5), None);
        assert_eq!(nearest(&times, 0.9, 0.11), Some(0));
        assert_eq!(nearest(&[], 0.9, 9.0), None);
    }
}
