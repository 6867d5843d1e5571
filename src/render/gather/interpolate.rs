//! The gather stage's arithmetic: a camera is asked for the colors of all points of a block that want it, sixteen at a time
//! in vectors. Every point hears its cameras in the same order as if it asked alone, so that its color does not depend on its
//! neighbors.

use super::reproject::{ReprojectedPoints, agrees, bilinear, carried};
use super::surface_points::{MOST, SurfacePoints};
use super::view_weights::{BESIDE_EDGE, EXACT, MAX_SUBPIXELS, SUBPIXEL_WIDTH, SourceView, SourceViews};
use crate::color::widened;
use crate::render::input::{LANES, LaneValues, Quads, TileCaches};
use crate::simd::{joined, mask};

/// A camera that shows less of the surface than this share knows nothing of it.
const LEAST_KNOWN: f32 = 1e-3;

/// Points that one camera is asked for together.
struct PointGroup {
    x: LaneValues,
    y: LaneValues,
    w: LaneValues,
    /// One bit for each that there is.
    which: u32,
}

/// What cameras say of the points.
#[derive(Clone, Copy)]
struct ViewColors {
    /// Weighted by `weight`.
    color: [LaneValues; 3],
    weight: LaneValues,
    /// Share of the pixel that is known.
    known: LaneValues,
}

impl ViewColors {
    const NONE: Self = Self { color: [[0.0; LANES]; 3], weight: [0.0; LANES], known: [0.0; LANES] };

    #[inline(always)]
    fn add(&mut self, other: &Self, factor: f32) {
        for i in 0..LANES {
            self.color[0][i] += other.color[0][i] * factor;
            self.color[1][i] += other.color[1][i] * factor;
            self.color[2][i] += other.color[2][i] * factor;
            self.weight[i] += other.weight[i] * factor;
            self.known[i] += other.known[i] * factor;
        }
    }
}

/// Red, green and blue of each corner of quads.
#[inline(always)]
fn colors(quads: &Quads) -> [[LaneValues; 3]; 4] {
    let mut colors = [[[0.0; LANES]; 3]; 4];
    for (bits, colors) in quads.color.iter().zip(&mut colors) {
        for i in 0..LANES {
            colors[0][i] = widened(bits[i] as i16);
            colors[1][i] = widened((bits[i] >> 16) as i16);
            colors[2][i] = widened((bits[i] >> 32) as i16);
        }
    }
    colors
}

impl SourceViews<'_> {
    /// Finds what the samples of `cameras`, of which the best come first, say of the colors of surface points; in a pruned set
    /// a point's own camera is asked before all others. Each camera is asked at once for all points that want it.
    #[inline(always)]
    pub(crate) fn find(&self, points: &mut SurfacePoints, cameras: &[u16], windows: &mut TileCaches) {
        let count = points.count();
        points.color.iter_mut().for_each(|channel| channel[..count].fill(0.0));
        points.weight[..count].fill(0.0);
        points.known[..count].fill(0.0);
        let (pruned, many) = (self.pruned, self.many);
        // One loop for both, so that the code, which is all inlined, is there once.
        let own_first = if pruned { cameras } else { &[] };
        for (nth, &camera) in own_first.iter().chain(cameras).enumerate() {
            let is_asked = if nth < own_first.len() {
                points.list_own(camera)
            } else {
                points.list_open(many, pruned.then_some(camera))
            };
            if is_asked {
                self.ask(camera, points, windows);
            } else if !pruned {
                break;
            }
        }
    }

    /// Adds what one camera says of the points that want it.
    #[inline(always)]
    fn ask(&self, camera: u16, points: &mut SurfacePoints, windows: &mut TileCaches) {
        let view = &self.views[camera as usize];
        let SurfacePoints { x, y, w, color, weight, known, wanting, .. } = points;
        for group in wanting.chunks(LANES) {
            // What is missing at the end is a point that is there already, and not asked for.
            let mut at = [group[0] as usize % MOST; LANES];
            for (at, nth) in at.iter_mut().zip(group) {
                *at = *nth as usize % MOST;
            }
            let which = u32::MAX >> (32 - group.len());
            let (x, y, w) = (listed(x, &at), listed(y, &at), listed(w, &at));
            let answers = self.answers(view, &PointGroup { x, y, w, which }, windows);
            for (sum, part) in color.iter_mut().zip(&answers.color) {
                add_listed(sum, &at, group.len(), part);
            }
            add_listed(weight, &at, group.len(), &answers.weight);
            add_listed(known, &at, group.len(), &answers.known);
        }
    }

    /// What one camera says of sixteen points.
    #[inline(always)]
    fn answers(&self, view: &SourceView, points: &PointGroup, windows: &mut TileCaches) -> ViewColors {
        let mut found = ViewColors::NONE;
        let mut places = self.places(view, &points.x, &points.y, &points.w);
        let mut left = points.which & places.inside;
        let mut counts = [1.0; LANES];
        for i in 0..LANES {
            let rate = view.source_from_target.focal_ratio * places.reciprocal[i];
            // The picture is coarser than the camera's: the mean over sub-pixels, or fine detail would alias.
            let count = (rate / SUBPIXEL_WIDTH).ceil().min(MAX_SUBPIXELS);
            counts[i] = if rate <= SUBPIXEL_WIDTH { 1.0 } else { count };
        }
        // One loop for whole pixels and sub-pixels, so that the code, which is all inlined, is there once.
        while left != 0 {
            let count = counts[left.trailing_zeros() as usize % LANES];
            let alike = left & mask(|i| counts[i] == count);
            left &= !alike;
            let mut sum = ViewColors::NONE;
            let per_subpixel = 1.0 / count;
            let (mut x, mut y, mut sub) = (points.x, points.y, (0.0, 0.0));
            while sub.1 < count {
                if count > 1.0 {
                    let (across, down) = ((sub.0 + 0.5) * per_subpixel, (sub.1 + 0.5) * per_subpixel);
                    for i in 0..LANES {
                        x[i] = points.x[i] + across - 0.5;
                        y[i] = points.y[i] + down - 0.5;
                    }
                    places = self.places(view, &x, &y, &points.w);
                }
                let asked = alike & places.inside;
                let part = self.interpolated(view, &places, (&x, &y, &points.w), asked, windows);
                sum.add(&part, 1.0);
                sub = if sub.0 + 1.0 < count { (sub.0 + 1.0, sub.1) } else { (0.0, sub.1 + 1.0) };
            }
            found.add(&sum, per_subpixel * per_subpixel);
            // Places of sub-pixels serve no other points.
            if left != 0 {
                places = self.places(view, &points.x, &points.y, &points.w);
            }
        }
        found
    }

    /// What a camera's samples say of the points of a mask; nothing of the others.
    #[inline(always)]
    fn interpolated(
        &self,
        view: &SourceView,
        places: &ReprojectedPoints,
        (x, y, w): (&LaneValues, &LaneValues, &LaneValues),
        asked: u32,
        windows: &mut TileCaches,
    ) -> ViewColors {
        let quads = windows.quads::<true>(&self.lookup, view.camera, &places.corners(), asked);
        let (mut known, mut depth, mut moved) = ([0.0; LANES], [0.0; LANES], [0; LANES]);
        for i in 0..LANES {
            let limit = places.expected[i] * view.tolerance;
            let shares = bilinear(places.along[i], places.down[i]);
            // Samples that show the surface there count fully, others not at all; all four do nearly everywhere.
            let (a, b) = (quads.depth[0][i], quads.depth[1][i]);
            let (c, d) = (quads.depth[2][i], quads.depth[3][i]);
            let shown_a = if agrees(a, places.expected[i], limit) { shares[0] } else { 0.0 };
            let shown_b = if agrees(b, places.expected[i], limit) { shares[1] } else { 0.0 };
            let shown_c = if agrees(c, places.expected[i], limit) { shares[2] } else { 0.0 };
            let shown_d = if agrees(d, places.expected[i], limit) { shares[3] } else { 0.0 };
            known[i] = (shown_a + shown_b) + (shown_c + shown_d);
            depth[i] = ((shown_a * a + shown_b * b) + (shown_c * c + shown_d * d)) / known[i];
            // Where the camera agrees with the z-buffer to a small part of the tolerance, correcting moves nothing.
            let is_exact = (depth[i] - places.expected[i]).abs() <= EXACT * limit;
            moved[i] = u32::from(!is_exact) << i;
        }
        if asked & mask(|i| known[i] >= LEAST_KNOWN) == 0 {
            return ViewColors::NONE;
        }
        let (mut along, mut down) = (places.along, places.down);
        let moved = joined(&moved);
        if moved & asked != 0 {
            for i in 0..LANES {
                let (correct_along, correct_down) = corrected(view, places, i, (x[i], y[i]), depth[i]);
                let moves = moved >> i & 1 == 1;
                along[i] = if moves { correct_along } else { along[i] };
                down[i] = if moves { correct_down } else { down[i] };
            }
        }
        let weights = self.weights(view, &places.reciprocal, [x, y, w]);
        let colors = colors(&quads);
        let mut answers = ViewColors::NONE;
        for i in 0..LANES {
            let expected = places.expected[i];
            let limit = expected * view.tolerance;
            let (a, b) = (quads.depth[0][i], quads.depth[1][i]);
            let (c, d) = (quads.depth[2][i], quads.depth[3][i]);
            let (agrees_a, agrees_b) = (agrees(a, expected, limit), agrees(b, expected, limit));
            let (agrees_c, agrees_d) = (agrees(c, expected, limit), agrees(d, expected, limit));
            let shares = bilinear(along[i], down[i]);
            let part_a = if agrees_a { shares[0] } else { 0.0 };
            let part_b = if agrees_b { shares[1] } else { 0.0 };
            let part_c = if agrees_c { shares[2] } else { 0.0 };
            let part_d = if agrees_d { shares[3] } else { 0.0 };
            let share = part_a + part_b + part_c + part_d;
            let beside = (!agrees_a & (a >= 0.0))
                | (!agrees_b & (b >= 0.0))
                | (!agrees_c & (c >= 0.0))
                | (!agrees_d & (d >= 0.0));
            let weight = weights[i] * if beside { BESIDE_EDGE } else { 1.0 };
            let counts = (asked >> i & 1 == 1) & (known[i] >= LEAST_KNOWN);
            let red = colors[0][0][i] * part_a
                + colors[1][0][i] * part_b
                + colors[2][0][i] * part_c
                + colors[3][0][i] * part_d;
            let green = colors[0][1][i] * part_a
                + colors[1][1][i] * part_b
                + colors[2][1][i] * part_c
                + colors[3][1][i] * part_d;
            let blue = colors[0][2][i] * part_a
                + colors[1][2][i] * part_b
                + colors[2][2][i] * part_c
                + colors[3][2][i] * part_d;
            answers.color[0][i] = if counts { red * weight } else { 0.0 };
            answers.color[1][i] = if counts { green * weight } else { 0.0 };
            answers.color[2][i] = if counts { blue * weight } else { 0.0 };
            answers.weight[i] = if counts { share * weight } else { 0.0 };
            answers.known[i] = if counts { share } else { 0.0 };
        }
        answers
    }
}

/// Whether ascending places follow one another.
#[inline(always)]
fn is_run(at: &[usize; LANES]) -> bool {
    at[LANES - 1] == at[0] + LANES - 1
}

/// Some numbers out of many.
#[inline(always)]
fn listed(numbers: &[f32; MOST], at: &[usize; LANES]) -> LaneValues {
    if is_run(at)
        && let Some(run) = numbers[at[0] % MOST..].first_chunk::<LANES>()
    {
        return *run;
    }
    let mut lanes = [0.0; LANES];
    for i in 0..LANES {
        lanes[i] = numbers[at[i] % MOST];
    }
    lanes
}

/// Adds the first `count` of some numbers to others out of many.
#[inline(always)]
fn add_listed(sums: &mut [f32; MOST], at: &[usize; LANES], count: usize, parts: &LaneValues) {
    if is_run(at)
        && let Some(run) = sums[at[0] % MOST..].first_chunk_mut::<LANES>()
    {
        for i in 0..LANES {
            run[i] += parts[i];
        }
        return;
    }
    for (at, part) in at.iter().zip(parts).take(count) {
        sums[at % MOST] += part;
    }
}

/// Where between the 2×2 samples the pixel's line of sight meets the surface that the camera itself saw, at inverse depth
/// `depth`, instead of the one that the z-buffer holds.
#[inline(always)]
fn corrected(
    view: &SourceView,
    places: &ReprojectedPoints,
    i: usize,
    (x, y): (f32, f32),
    depth: f32,
) -> (f32, f32) {
    let (left, above) = (places.left[i], places.above[i]);
    let seen = carried(&view.target_from_source, left + places.along[i], above + places.down[i], depth);
    let there = &view.source_from_target;
    let ray = there.ray(x, y);
    let point = ray * seen[2] + there.origin * depth;
    let reciprocal = 1.0 / point.z;
    let (u, v) = (point.x * reciprocal - 0.5, point.y * reciprocal - 0.5);
    let sound = (seen[2] > 0.0) & (point.z > 0.0);
    let (along, down) = ((u - left).clamp(0.0, 1.0), (v - above).clamp(0.0, 1.0));
    (if sound { along } else { places.along[i] }, if sound { down } else { places.down[i] })
}
