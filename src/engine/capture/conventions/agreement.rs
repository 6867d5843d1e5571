//! How well the views agree under a reading.
//!
//! Source: the outlier test of MPEG's TMIV (`DepthQualityAssessor`): a point carried into another view contradicts it only where it
//! is in front of all of 3×3 pixels, since it would have been seen there. What differs: agreeing points count for a reading, and
//! contradicting ones count against it, so that a reading gains nothing by carrying points out of the picture.

use glam::{DAffine3, DVec3};

use super::reading::{PixelRay, Reading};
use super::views::ComparedView;
use crate::capture::depth_claim::DepthMeasure;
use crate::capture::sighting::{Landing, Sighting};
use crate::median::median;

/// What readings are tried on.
pub(super) struct Comparison {
    pub views: Vec<ComparedView>,
    /// Source and target, by their index.
    pub pairs: Vec<(usize, usize)>,
    /// Distance of the near plane, world units.
    pub near_clip: f64,
    /// The convention of the matrices of [`ComparedView::world_from_camera`].
    pub claimed: Reading,
}

/// Counts of points that were carried from view to view.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct AgreementCounts {
    pub agree: usize,
    /// Those in front of all that the other view saw there.
    pub contradict: usize,
    /// All that were carried.
    pub tried: usize,
}

impl AgreementCounts {
    /// Points that agree, less points that contradict, as a share of all.
    pub(super) fn score(&self) -> f64 {
        (self.agree as f64 - self.contradict as f64) / self.tried.max(1) as f64
    }
}

impl Comparison {
    /// World space from our camera space of every view, under a reading of its matrix.
    pub(super) fn poses(&self, reading: &Reading) -> Vec<DAffine3> {
        let matrix = |view: &ComparedView| self.claimed.pose.matrix(&view.world_from_camera);
        self.views.iter().map(|view| reading.pose.world_from_camera(&matrix(view))).collect()
    }

    /// Points that agree, less points that contradict, as a share of those carried; `points` of each pair agree within `tolerance` of a
    /// number.
    pub(super) fn score(&self, reading: &Reading, points: usize, tolerance: f64) -> f64 {
        self.votes(reading, points, tolerance).score()
    }

    /// Counts over `points` points of each pair.
    pub(super) fn votes(&self, reading: &Reading, points: usize, tolerance: f64) -> AgreementCounts {
        self.votes_of(reading, self.pairs.iter().copied(), points, tolerance)
    }

    /// Counts over `points` points of each of some pairs.
    pub(super) fn votes_of(
        &self,
        reading: &Reading,
        pairs: impl Iterator<Item = (usize, usize)>,
        points: usize,
        tolerance: f64,
    ) -> AgreementCounts {
        let poses = self.poses(reading);
        let mut votes = AgreementCounts::default();
        for (from, to) in pairs {
            let (source, target) = (&self.views[from], &self.views[to]);
            let target_from_source = poses[to].inverse() * poses[from];
            let lens = reading.lens.of(&source.intrinsics);
            for point in source.points.iter().take(points) {
                votes.tried += 1;
                let ray = PixelRay::through(&lens, point.pixel);
                let z = reading.planar_z(point.value, ray, &poses[from], self.near_clip);
                let point_in_target = target_from_source.transform_point3(ray.to_unit_z * z);
                if !(z > 0.0 && point_in_target.z > 0.0) {
                    continue;
                }
                match self.vote(reading, target, point_in_target, &poses[to], tolerance) {
                    Sighting::Same => votes.agree += 1,
                    Sighting::Farther => votes.contradict += 1,
                    Sighting::Nearer | Sighting::NoDepth | Sighting::Outside => {}
                }
            }
        }
        votes
    }

    /// What a view sees of a point in front of it: something farther only where all that it sees around there is.
    fn vote(
        &self,
        reading: &Reading,
        target: &ComparedView,
        point: DVec3,
        pose: &DAffine3,
        tolerance: f64,
    ) -> Sighting {
        let lens = reading.lens.of(&target.intrinsics);
        let Some(landing) = Landing::through(&lens, point, target.intrinsics.size()) else {
            return Sighting::Outside;
        };
        let ray = PixelRay::new(point / point.z);
        // Whether it is in front of all depths so far; `None` before the first one.
        let mut is_in_front = None;
        for row in target.around(landing.position) {
            for &value in row.iter().filter(|value| value.is_finite()) {
                let there = reading.planar_z(f64::from(value), ray, pose, self.near_clip);
                // Heights in world space are no distances from the camera: a share of them is allowed, not of the distance.
                let size = match reading.measure {
                    DepthMeasure::WorldZ => {
                        f64::from(value) * reading.unit / pose.transform_vector3(ray.to_unit_z).z
                    }
                    _ => there,
                };
                if (point.z - there).abs() <= tolerance * size.abs() {
                    return Sighting::Same;
                }
                is_in_front = Some(is_in_front.unwrap_or(true) && point.z < there);
            }
        }
        is_in_front.map_or(Sighting::NoDepth, |is| if is { Sighting::Farther } else { Sighting::Nearer })
    }

    /// The median distance between compared cameras, as a share of the depth that they see; 0 if none can be compared.
    pub(super) fn baseline_over_depth(&self, reading: &Reading) -> f64 {
        let poses = self.poses(reading);
        let share = |&(from, to): &(usize, usize)| {
            let source = &self.views[from];
            let value = source.middle_value()?;
            let depth = reading.planar_z(value, PixelRay::AXIS, &poses[from], self.near_clip).abs();
            Some(poses[from].translation.distance(poses[to].translation) / depth)
        };
        let mut shares: Vec<f64> =
            self.pairs.iter().filter_map(share).filter(|share| share.is_finite()).collect();
        median(&mut shares).unwrap_or(0.0)
    }

    /// The depth in the middle of what the views see, under a reading.
    pub(super) fn middle_depth(&self, reading: &Reading) -> f64 {
        let poses = self.poses(reading);
        let depth = |(view, pose): (&ComparedView, &DAffine3)| {
            Some(reading.planar_z(view.middle_value()?, PixelRay::AXIS, pose, self.near_clip).abs())
        };
        let mut depths: Vec<f64> = self.views.iter().zip(&poses).filter_map(depth).collect();
        median(&mut depths).unwrap_or(0.0)
    }

    /// Whether two readings put the cameras the same way beside each other, whichever way the world is turned: no agreement
    /// between views can distinguish them.
    pub(super) fn are_one_arrangement(&self, a: &Reading, b: &Reading) -> bool {
        let (poses_a, poses_b) = (self.poses(a), self.poses(b));
        let scale = poses_a.iter().map(|pose| pose.translation.length()).fold(1e-9, f64::max);
        self.pairs.iter().all(|&(from, to)| {
            let relative = |poses: &[DAffine3]| poses[to].inverse() * poses[from];
            let (a, b) = (relative(&poses_a), relative(&poses_b));
            a.matrix3.abs_diff_eq(b.matrix3, 1e-4) && a.translation.distance(b.translation) <= 1e-4 * scale
        })
    }
}
