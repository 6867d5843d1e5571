//! Votes: how cameras see surface points of the vantage, sixteen at a time. What is made of them: [`super::silhouette`].

use super::reproject::{agrees, bilinear, carried};
use super::view_weights::SourceViews;
use crate::render::input::{LANES, LaneValues, TileCaches};

/// Samples beside agreeing ones that say nothing count this much, half for the surface and half against it.
const SILENCE: f32 = 0.5;

/// Surface points that are put to the vote.
#[derive(Debug, Default)]
pub(crate) struct VotedPoints {
    /// Columns of their pixels.
    pub(crate) x: Vec<f32>,
    /// Rows of their pixels.
    pub(crate) y: Vec<f32>,
    /// Inverse depths.
    pub(crate) w: Vec<f32>,
}

/// Votes on a surface point.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Votes {
    /// What speaks for it.
    pub(crate) agree: f32,
    /// Everything that is said.
    pub(crate) all: f32,
    /// What the camera that counts most could say.
    pub(crate) most: f32,
}

impl VotedPoints {
    pub(crate) fn clear(&mut self) {
        [&mut self.x, &mut self.y, &mut self.w].into_iter().for_each(Vec::clear);
    }

    pub(crate) fn push(&mut self, x: f32, y: f32, w: f32) {
        self.x.push(x);
        self.y.push(y);
        self.w.push(w);
    }
}

/// Some numbers from `first` on, 0 where there are no more.
#[inline(always)]
fn lanes(numbers: &[f32], first: usize) -> LaneValues {
    let mut lanes = [0.0; LANES];
    let count = LANES.min(numbers.len() - first);
    lanes[..count].copy_from_slice(&numbers[first..first + count]);
    lanes
}

impl SourceViews<'_> {
    /// The votes of `cameras` on some points.
    #[inline(always)]
    pub(crate) fn vote(
        &self,
        points: &VotedPoints,
        cameras: &[u16],
        windows: &mut TileCaches,
        votes: &mut Vec<Votes>,
    ) {
        votes.clear();
        let count = points.x.len();
        for first in (0..count).step_by(LANES) {
            let (x, y, w) = (lanes(&points.x, first), lanes(&points.y, first), lanes(&points.w, first));
            let asked = u32::MAX >> (32 - LANES.min(count - first));
            let mut heard = [[0.0; LANES]; 3];
            for &camera in cameras {
                self.hear(camera, [&x, &y, &w], asked, windows, &mut heard);
            }
            let [agree, all, most] = heard;
            let votes_on = |i: usize| Votes { agree: agree[i], all: all[i], most: most[i] };
            votes.extend((0..LANES.min(count - first)).map(votes_on));
        }
    }

    /// Adds the votes of one camera: shares of the 2×2 samples around a point that show the surface there, and that show
    /// something behind it. What is hidden by something nearer, or was pruned, says nothing.
    ///
    /// A sample does not count as agreeing where the surface that the camera saw lies elsewhere in the vantage, by half a
    /// pixel and more: there it is another part of the surface, which only happens to be as far away.
    #[inline(always)]
    fn hear(
        &self,
        camera: u16,
        [x, y, w]: [&LaneValues; 3],
        asked: u32,
        windows: &mut TileCaches,
        [agree, all, most]: &mut [LaneValues; 3],
    ) {
        let view = &self.views[camera as usize];
        let places = self.places(view, x, y, w);
        let asked = asked & places.inside;
        if asked == 0 {
            return;
        }
        let quads = windows.quads::<false>(&self.lookup, view.camera, &places.corners(), asked);
        let weights = self.weights(view, &places.reciprocal, [x, y, w]);
        for i in 0..LANES {
            let expected = places.expected[i];
            let limit = expected * view.tolerance;
            let shares = bilinear(places.along[i], places.down[i]);
            let (mut agreeing, mut through, mut silent, mut depth) = (0.0, 0.0, 0.0, 0.0);
            for corner in 0..4 {
                let (found, share) = (quads.depth[corner][i], shares[corner]);
                let agrees = agrees(found, expected, limit);
                let is_behind = !agrees & (found >= 0.0) & (found < expected);
                agreeing += if agrees { share } else { 0.0 };
                depth += if agrees { share * found } else { 0.0 };
                through += if is_behind { share } else { 0.0 };
                silent += if agrees | is_behind { 0.0 } else { share };
            }
            let (column, row) = (places.left[i] + places.along[i], places.above[i] + places.down[i]);
            let seen = carried(&view.target_from_source, column, row, depth / agreeing);
            let off = (seen[0] / seen[2] - x[i] - 0.5).abs().max((seen[1] / seen[2] - y[i] - 0.5).abs());
            let doubt = if agreeing > 0.0 { agreeing * off.min(1.0) } else { 0.0 };
            let silent = if agreeing - doubt > 0.0 { SILENCE * silent } else { 0.0 };
            let (agreeing, through) = (agreeing - doubt, through + doubt);
            let is_asked = asked >> i & 1 == 1;
            agree[i] += if is_asked { weights[i] * (agreeing + 0.5 * silent) } else { 0.0 };
            all[i] += if is_asked { weights[i] * (agreeing + through + silent) } else { 0.0 };
            most[i] = most[i].max(if is_asked { weights[i] } else { 0.0 });
        }
    }
}
