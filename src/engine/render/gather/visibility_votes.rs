//! Votes of the cameras on whether surface points of the vantage are visible, sixteen at a time. [`super::silhouette`] decides
//! by them.

use super::reproject::{ReprojectedPoints, agrees, bilinear};
use super::view_weights::{SourceViews, TargetPoints};
use crate::render::input::{LaneValues, TileCaches};
use crate::simd::LANES;

/// The weight of samples that show nothing, beside agreeing ones: half of it counts for the surface and half against it.
const UNKNOWN_WEIGHT: f32 = 0.5;

/// Surface points that cameras vote on.
#[derive(Debug, Default)]
pub(super) struct VotedPoints {
    /// Columns of their pixels.
    x: Vec<f32>,
    /// Rows of their pixels.
    y: Vec<f32>,
    /// Inverse depths.
    w: Vec<f32>,
}

/// Votes on a surface point.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct VisibilityVotes {
    /// Sum of the votes for it.
    pub(super) agree: f32,
    /// Sum of all votes.
    pub(super) total: f32,
    /// The largest weight of a camera.
    pub(super) max_weight: f32,
}

impl VotedPoints {
    pub(super) fn clear(&mut self) {
        [&mut self.x, &mut self.y, &mut self.w].into_iter().for_each(Vec::clear);
    }

    pub(super) fn push(&mut self, x: f32, y: f32, w: f32) {
        self.x.push(x);
        self.y.push(y);
        self.w.push(w);
    }
}

/// Sixteen values from `first` on, 0 beyond the end.
#[inline(always)]
fn lanes(numbers: &[f32], first: usize) -> LaneValues {
    let mut lanes = [0.0; LANES];
    let count = LANES.min(numbers.len() - first);
    lanes[..count].copy_from_slice(&numbers[first..first + count]);
    lanes
}

/// The votes of `cameras` on some points.
#[inline(always)]
pub(super) fn vote(
    views: &SourceViews<'_>,
    points: &VotedPoints,
    cameras: &[u16],
    caches: &mut TileCaches,
    votes: &mut Vec<VisibilityVotes>,
) {
    votes.clear();
    let count = points.x.len();
    for first in (0..count).step_by(LANES) {
        let (x, y, w) = (lanes(&points.x, first), lanes(&points.y, first), lanes(&points.w, first));
        let which = u32::MAX >> (32 - LANES.min(count - first));
        let mut sums = [[0.0; LANES]; 3];
        for &camera in cameras {
            let points = TargetPoints { x, y, w };
            if views.views[camera as usize].is_orthographic() {
                add_votes_of_orthographic(views, camera, &points, which, caches, &mut sums);
            } else {
                add_votes::<false>(views, camera, &points, which, caches, &mut sums);
            }
        }
        let [agree, total, max_weight] = sums;
        let votes_on =
            |i: usize| VisibilityVotes { agree: agree[i], total: total[i], max_weight: max_weight[i] };
        votes.extend((0..LANES.min(count - first)).map(votes_on));
    }
}

/// [`add_votes`] of an orthographic camera. Apart, so that those in perspective stay as fast as they are.
#[cold]
#[inline(never)]
fn add_votes_of_orthographic(
    views: &SourceViews<'_>,
    camera: u16,
    points: &TargetPoints,
    which: u32,
    caches: &mut TileCaches,
    sums: &mut [LaneValues; 3],
) {
    add_votes::<true>(views, camera, points, which, caches, sums);
}

/// Adds the votes of one camera: shares of the 2×2 samples around a point that show the surface there, and that show
/// something behind it. Samples of something nearer, and missing samples, count for neither.
///
/// An agreeing sample counts less the farther the surface that it shows lies from the pixel in the vantage, and nothing from one
/// pixel on: it is then another part of the surface that happens to be as far away.
#[inline(always)]
fn add_votes<const PARALLEL: bool>(
    views: &SourceViews<'_>,
    camera: u16,
    points: &TargetPoints,
    which: u32,
    caches: &mut TileCaches,
    [agree, total, max_weight]: &mut [LaneValues; 3],
) {
    let view = &views.views[camera as usize];
    let at = ReprojectedPoints::new(&views.lookup, view, points);
    let which = which & at.inside;
    if which == 0 {
        return;
    }
    let quads = caches.quads::<false>(&views.lookup, view.camera, &at.corners(), which);
    let weights = views.weights(view, &at.distance_ratio, points);
    for i in 0..LANES {
        let expected = at.expected[i];
        let limit = expected * view.tolerance.at(expected);
        let shares = bilinear(at.along[i], at.down[i]);
        let (mut agreeing, mut behind, mut unknown, mut depth) = (0.0, 0.0, 0.0, 0.0);
        for corner in 0..4 {
            let (found, share) = (quads.depth[corner][i], shares[corner]);
            let agrees = agrees(found, expected, limit);
            let is_behind = !agrees & (found >= 0.0) & (found < expected);
            agreeing += if agrees { share } else { 0.0 };
            depth += if agrees { share * found } else { 0.0 };
            behind += if is_behind { share } else { 0.0 };
            unknown += if agrees | is_behind { 0.0 } else { share };
        }
        let (column, row) = (at.left[i] + at.along[i], at.above[i] + at.down[i]);
        let seen = if PARALLEL {
            view.target_from_source.point_of_any(column, row, depth / agreeing)
        } else {
            view.target_from_source.point(column, row, depth / agreeing)
        };
        let (dx, dy) = (seen.x / seen.z - points.x[i] - 0.5, seen.y / seen.z - points.y[i] - 0.5);
        let displaced = if agreeing > 0.0 { agreeing * dx.abs().max(dy.abs()).min(1.0) } else { 0.0 };
        let unknown = if agreeing - displaced > 0.0 { UNKNOWN_WEIGHT * unknown } else { 0.0 };
        let (agreeing, behind) = (agreeing - displaced, behind + displaced);
        let is_asked = which >> i & 1 == 1;
        agree[i] += if is_asked { weights[i] * (agreeing + 0.5 * unknown) } else { 0.0 };
        total[i] += if is_asked { weights[i] * (agreeing + behind + unknown) } else { 0.0 };
        max_weight[i] = max_weight[i].max(if is_asked { weights[i] } else { 0.0 });
    }
}
