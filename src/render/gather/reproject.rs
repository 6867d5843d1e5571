//! Where surface points of the vantage lie in a camera, sixteen at a time.

use super::view_weights::{SourceView, SourceViews};
use crate::render::geometry::Projector;
use crate::render::input::{LANES, LaneValues};
use crate::simd::{joined, whole};

/// Sixteen points in one camera.
pub(crate) struct ReprojectedPoints {
    /// Which of them the camera looks at: one bit each.
    pub(crate) inside: u32,
    /// Column of the samples to the left, −1 beside the picture.
    pub(crate) left: LaneValues,
    /// Row of the samples above.
    pub(crate) above: LaneValues,
    /// How far the point lies from the left samples toward the right ones.
    pub(crate) along: LaneValues,
    /// The same downward.
    pub(crate) down: LaneValues,
    /// Inverse depth there, if it is the surface that the camera sees.
    pub(crate) expected: LaneValues,
    /// Distance from the vantage over that from the camera.
    pub(crate) reciprocal: LaneValues,
}

impl ReprojectedPoints {
    /// `left` and `above` as numbers; anything for points that the camera does not look at.
    #[inline(always)]
    pub(crate) fn corners(&self) -> [[i32; LANES]; 2] {
        let mut corners = [[0; LANES]; 2];
        for i in 0..LANES {
            corners[0][i] = whole(self.left[i] + 1.0) as i32 - 1;
            corners[1][i] = whole(self.above[i] + 1.0) as i32 - 1;
        }
        corners
    }
}

impl SourceViews<'_> {
    /// Where points lie in a camera.
    #[inline(always)]
    pub(crate) fn places(
        &self,
        view: &SourceView,
        x: &LaneValues,
        y: &LaneValues,
        w: &LaneValues,
    ) -> ReprojectedPoints {
        let zero = [0.0; LANES];
        let (mut left, mut above, mut along, mut down) = (zero, zero, zero, zero);
        let (mut expected, mut reciprocals, mut inside) = (zero, zero, [0_u32; LANES]);
        let (width, height) = self.lookup.size(view.camera);
        let (width, height) = (width as f32, height as f32);
        for i in 0..LANES {
            let point = carried(&view.source_from_target, x[i], y[i], w[i]);
            let reciprocal = 1.0 / point[2];
            let (u, v) = (point[0] * reciprocal - 0.5, point[1] * reciprocal - 0.5);
            // Rounded down: inside, both are larger than −1.
            left[i] = (u + 1.0).floor() - 1.0;
            above[i] = (v + 1.0).floor() - 1.0;
            along[i] = u - left[i];
            down[i] = v - above[i];
            expected[i] = w[i] * reciprocal;
            reciprocals[i] = reciprocal;
            let is_inside = (point[2] > 0.0) & (u > -1.0) & (v > -1.0) & (u < width) & (v < height);
            inside[i] = u32::from(is_inside) << i;
        }
        let inside = joined(&inside);
        ReprojectedPoints { inside, left, above, along, down, expected, reciprocal: reciprocals }
    }

    /// How much a camera counts for each of sixteen points.
    #[inline(always)]
    pub(crate) fn weights(
        &self,
        view: &SourceView,
        reciprocal: &LaneValues,
        [x, y, w]: [&LaneValues; 3],
    ) -> LaneValues {
        let mut weights = [0.0; LANES];
        for i in 0..LANES {
            weights[i] = self.weight(view, reciprocal[i], (x[i], y[i]), w[i]);
        }
        weights
    }
}

/// Whether a sample at inverse depth `depth` shows the surface that is expected.
#[inline(always)]
pub(crate) fn agrees(depth: f32, expected: f32, limit: f32) -> bool {
    ((depth - expected).abs() <= limit) & (depth >= 0.0)
}

/// `M·ray + o·w` of a pixel.
#[inline(always)]
pub(crate) fn carried(projector: &Projector, x: f32, y: f32, w: f32) -> [f32; 3] {
    let point = projector.ray(x, y) + projector.origin * w;
    [point.x, point.y, point.z]
}

/// Shares of left above, right above, left below, right below.
#[inline(always)]
pub(crate) fn bilinear(along: f32, down: f32) -> [f32; 4] {
    let (back, up) = (1.0 - along, 1.0 - down);
    [back * up, along * up, back * down, along * down]
}
