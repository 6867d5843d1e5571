//! Votes of the cameras on whether surface points of the vantage are visible, sixteen at a time. [`super::silhouette`] decides
//! by them.

use super::view_weights::{SourceView, SourceViews, TargetPoints};
use crate::render::input::{LaneValues, Lookup, TileCaches};
use crate::simd::{LANES, joined, whole};

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
    let Some(quads) = quads else {
        for i in 0..LANES {
            max_weight[i] = max_weight[i].max(if which >> i & 1 == 1 { weights[i] } else { 0.0 });
        }
        return;
    };
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

/// Sixteen points in one camera.
pub(super) struct ReprojectedPoints {
    /// Which of them are in the camera's picture: one bit each.
    pub(super) inside: u32,
    /// Column of the samples to the left, −1 beside the picture.
    pub(super) left: LaneValues,
    /// Row of the samples above.
    pub(super) above: LaneValues,
    /// How far the point lies from the left samples toward the right ones, 0 to 1.
    pub(super) along: LaneValues,
    /// The same downward.
    pub(super) down: LaneValues,
    /// Inverse depth of the point in the camera.
    pub(super) expected: LaneValues,
    /// Distance from the vantage over that from the camera, which is 1 for an orthographic one.
    pub(super) distance_ratio: LaneValues,
}

impl ReprojectedPoints {
    /// Where points are in a camera.
    #[inline(always)]
    pub(super) fn new(lookup: &Lookup<'_>, view: &SourceView, points: &TargetPoints) -> Self {
        if view.is_orthographic() {
            return Self::in_orthographic(lookup, view, points);
        }
        Self::in_camera::<false>(lookup, view, points)
    }

    /// The same for an orthographic one. Apart, so that those in perspective stay as fast as they are.
    #[cold]
    #[inline(never)]
    fn in_orthographic(lookup: &Lookup<'_>, view: &SourceView, points: &TargetPoints) -> Self {
        Self::in_camera::<true>(lookup, view, points)
    }

    #[inline(always)]
    fn in_camera<const PARALLEL: bool>(
        lookup: &Lookup<'_>,
        view: &SourceView,
        points: &TargetPoints,
    ) -> Self {
        let zero = [0.0; LANES];
        let (mut left, mut above, mut along, mut down) = (zero, zero, zero, zero);
        let (mut expected, mut distance_ratio, mut inside) = (zero, zero, [0_u32; LANES]);
        let (width, height) = lookup.size(view.camera);
        let (width, height) = (width as f32, height as f32);
        for i in 0..LANES {
            let point = view.source_from_target.point(points.x[i], points.y[i], points.w[i]);
            let reciprocal = 1.0 / point.z;
            let divided = if PARALLEL { 1.0 / points.w[i] } else { reciprocal };
            let (u, v) = (point.x * divided - 0.5, point.y * divided - 0.5);
            // Rounded down: inside, both are larger than −1.
            left[i] = (u + 1.0).floor() - 1.0;
            above[i] = (v + 1.0).floor() - 1.0;
            along[i] = u - left[i];
            down[i] = v - above[i];
            expected[i] = points.w[i] * reciprocal;
            distance_ratio[i] = divided;
            let is_inside = (point.z > 0.0) & (u > -1.0) & (v > -1.0) & (u < width) & (v < height);
            inside[i] = u32::from(is_inside) << i;
        }
        Self { inside: joined(&inside), left, above, along, down, expected, distance_ratio }
    }

    /// `left` and `above` as whole numbers; meaningless for points that are not inside.
    #[inline(always)]
    pub(super) fn corners(&self) -> [[i32; LANES]; 2] {
        let mut corners = [[0; LANES]; 2];
        for i in 0..LANES {
            corners[0][i] = whole(self.left[i] + 1.0) as i32 - 1;
            corners[1][i] = whole(self.above[i] + 1.0) as i32 - 1;
        }
        corners
    }
}

/// Whether a sample at inverse depth `depth` is on the surface at inverse depth `expected`.
#[inline(always)]
pub(super) fn agrees(depth: f32, expected: f32, limit: f32) -> bool {
    ((depth - expected).abs() <= limit) & (depth >= 0.0)
}

/// Shares of left above, right above, left below, right below.
#[inline(always)]
pub(super) fn bilinear(along: f32, down: f32) -> [f32; 4] {
    let (back, up) = (1.0 - along, 1.0 - down);
    [back * up, along * up, back * down, along * down]
}
