//! Carries surface points of the vantage back into a camera, sixteen at a time.

use super::view_weights::{SourceView, TargetPoints};
use crate::render::input::{LaneValues, Lookup};
use crate::simd::{LANES, joined, whole};

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
