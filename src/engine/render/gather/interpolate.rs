//! The gather stage's arithmetic: one camera after another is read for all points of a block that want it, sixteen at a time in
//! vectors. Every point adds up its cameras in the same order as if it were alone, so that its color does not depend on its
//! neighbors.

use std::ops::Range;

use super::near_cameras::bit_of;
use super::surface_points::{MOST, SurfacePoints};
use super::view_weights::{SourceView, SourceViews, TargetPoints};
use super::visibility_votes::{ReprojectedPoints, agrees, bilinear};
use crate::render::input::{LaneValues, Quads, TexelColor, TileCaches};
use crate::simd::{LANES, joined, mask};

/// A camera that covers a smaller share of the pixel gives no color.
const LEAST_COVERAGE: f32 = 1e-3;

/// The weight of a camera if some of its 2×2 samples are on another surface: the color of that surface may be blended into the others.
const BESIDE_EDGE: f32 = 0.3;

/// Depths that differ by less than this part of the tolerance are taken as equal.
const EXACT: f32 = 0.005;

/// A sub-pixel is at most this many samples wide. A recorded pixel, itself a box one sample wide, and the tent that interpolates
/// it have together the variance of a box 1.7 wide (1/12 + 1/6 = 1.7²/12), so that no picture is blurred by one look-up up to
/// there, nor sharper than by two of them until 2.2; up to 2.5 the difference cannot be measured.
const SUBPIXEL_WIDTH: f32 = 2.5;

/// Most sub-pixels along each side of a pixel.
const MAX_SUBPIXELS: f32 = 4.0;

/// The colors that cameras give to sixteen points.
#[derive(Clone, Copy)]
struct ViewColors {
    /// Weighted by `weight`.
    color: [TexelColor; LANES],
    weight: LaneValues,
    /// Share of the pixel that samples cover.
    coverage: LaneValues,
}

impl ViewColors {
    const NONE: Self = Self { color: [[0.0; 4]; LANES], weight: [0.0; LANES], coverage: [0.0; LANES] };

    #[inline(always)]
    fn add(&mut self, other: &Self, factor: f32) {
        for i in 0..LANES {
            for channel in 0..4 {
                self.color[i][channel] += other.color[i][channel] * factor;
            }
            self.weight[i] += other.weight[i] * factor;
            self.coverage[i] += other.coverage[i] * factor;
        }
    }
}

/// A block whose surface points are listed.
#[derive(Clone, Debug)]
pub(super) struct ListedBlock {
    /// Its points.
    pub(super) points: Range<usize>,
    /// Its cameras, sorted by weight, in the list of those of all blocks.
    pub(super) cameras: Range<usize>,
}

/// The cameras that the points of some blocks are looked up in.
#[derive(Debug, Default)]
pub(super) struct BlockCameras {
    pub(super) blocks: Vec<ListedBlock>,
    /// The cameras of one block after the other.
    pub(super) cameras: Vec<u16>,
    /// Each of them once.
    distinct: Vec<u16>,
}

impl BlockCameras {
    /// Without blocks.
    pub(super) fn clear(&mut self) {
        self.blocks.clear();
        self.cameras.clear();
    }

    /// The cameras of a block.
    #[inline(always)]
    fn of(&self, block: usize) -> &[u16] {
        &self.cameras[self.blocks[block].cameras.clone()]
    }

    /// The camera of a rank in a block's list, unless a block before has the same there.
    #[inline(always)]
    fn first_at(&self, rank: usize, block: usize) -> Option<u16> {
        let camera = *self.of(block).get(rank)?;
        for before in 0..block {
            if self.of(before).get(rank) == Some(&camera) {
                return None;
            }
        }
        Some(camera)
    }
}

/// Adds up the colors of the surface points of some blocks over the samples of their cameras, the best for its block first; in a pruned set a
/// point's own camera, which kept its sample, comes before all others. Each camera is read at once for all points that want it.
#[inline(always)]
pub(super) fn find_colors(
    views: &SourceViews<'_>,
    points: &mut SurfacePoints,
    listed: &mut BlockCameras,
    caches: &mut TileCaches,
) {
    points.reset_colors();
    listed.distinct.clear();
    if views.pruned {
        listed.distinct.extend_from_slice(&listed.cameras);
        listed.distinct.sort_unstable();
        listed.distinct.dedup();
    }
    let (blocks, own) = (listed.blocks.len(), listed.distinct.len());
    let most = listed.blocks.iter().map(|block| block.cameras.len()).max().unwrap_or(0);
    let mut is_any_uncovered = true;
    // One loop for both, because all code in it is inlined.
    for step in 0..own + most * blocks {
        points.selected.clear();
        let camera = if step < own {
            let camera = listed.distinct[step];
            for block in &listed.blocks {
                points.select_own(block.points.clone(), camera);
            }
            camera
        } else {
            let (rank, first) = ((step - own) / blocks, (step - own) % blocks);
            if first == 0 && !std::mem::take(&mut is_any_uncovered) && !views.pruned {
                break;
            }
            let Some(camera) = listed.first_at(rank, first) else { continue };
            for block in first..blocks {
                if listed.of(block).get(rank) == Some(&camera) {
                    let (range, except) =
                        (listed.blocks[block].points.clone(), views.pruned.then_some(camera));
                    points.select_uncovered(range, bit_of(rank), views.full_coverage, except);
                }
            }
            is_any_uncovered |= !points.selected.is_empty();
            camera
        };
        if !points.selected.is_empty() {
            add_camera(views, camera, points, caches);
        }
    }
}

/// Adds the colors that one camera gives to the selected points.
#[inline(always)]
fn add_camera(views: &SourceViews<'_>, camera: u16, points: &mut SurfacePoints, caches: &mut TileCaches) {
    let view = &views.views[camera as usize];
    let SurfacePoints { x, y, w, slope, color, weight, coverage, selected, .. } = points;
    for group in selected.chunks(LANES) {
        // The last group is filled up with its first point, which the mask leaves out.
        let mut at = [group[0] as usize % MOST; LANES];
        for (at, nth) in at.iter_mut().zip(group) {
            *at = *nth as usize % MOST;
        }
        let which = u32::MAX >> (32 - group.len());
        let group_points = TargetPoints { x: listed(x, &at), y: listed(y, &at), w: listed(w, &at) };
        let slopes = [listed(&slope[0], &at), listed(&slope[1], &at)];
        let found = colors_in(views, view, (&group_points, &slopes), which, caches);
        for (at, part) in at.iter().zip(&found.color).take(group.len()) {
            for channel in 0..4 {
                color[at % MOST][channel] += part[channel];
            }
        }
        add_listed(weight, &at, group.len(), &found.weight);
        add_listed(coverage, &at, group.len(), &found.coverage);
    }
}

/// The colors that one camera gives to the points of a mask: the mean over the sub-pixels of each.
#[inline(always)]
fn colors_in(
    views: &SourceViews<'_>,
    view: &SourceView,
    (points, slopes): (&TargetPoints, &[LaneValues; 2]),
    which: u32,
    caches: &mut TileCaches,
) -> ViewColors {
    let mut found = ViewColors::NONE;
    let mut reprojected = ReprojectedPoints::new(&views.lookup, view, points);
    let mut left = which & reprojected.inside;
    let mut counts = [1.0; LANES];
    for i in 0..LANES {
        let rate = views.rate(view, reprojected.distance_ratio[i]);
        // Where the picture is coarser than the camera's, one look-up would alias fine detail.
        let count = (rate / SUBPIXEL_WIDTH).ceil().min(MAX_SUBPIXELS);
        counts[i] = if rate <= SUBPIXEL_WIDTH { 1.0 } else { count };
    }
    // One loop for whole pixels and sub-pixels, because all code in it is inlined.
    while left != 0 {
        let count = counts[left.trailing_zeros() as usize % LANES];
        let alike = left & mask(|i| counts[i] == count);
        left &= !alike;
        let mut sum = ViewColors::NONE;
        let per_subpixel = 1.0 / count;
        let (mut moved, mut sub) = (*points, (0.0, 0.0));
        while sub.1 < count {
            if count > 1.0 {
                let (across, down) = ((sub.0 + 0.5) * per_subpixel, (sub.1 + 0.5) * per_subpixel);
                for i in 0..LANES {
                    moved.x[i] = points.x[i] + (across - 0.5) * views.subpixels;
                    moved.y[i] = points.y[i] + (down - 0.5) * views.subpixels;
                }
                reprojected = ReprojectedPoints::new(&views.lookup, view, &moved);
            }
            let which = alike & reprojected.inside;
            sum.add(&interpolated(views, view, (&moved, slopes), &mut reprojected, which, caches), 1.0);
            sub = if sub.0 + 1.0 < count { (sub.0 + 1.0, sub.1) } else { (0.0, sub.1 + 1.0) };
        }
        found.add(&sum, per_subpixel * per_subpixel);
        // The last positions are those of sub-pixels of the points before.
        if left != 0 {
            reprojected = ReprojectedPoints::new(&views.lookup, view, points);
        }
    }
    found
}

/// The colors that a camera's samples give to the points of a mask; nothing for the others. Moves `at` to where the camera saw
/// the surface.
#[inline(always)]
fn interpolated(
    views: &SourceViews<'_>,
    view: &SourceView,
    (points, slopes): (&TargetPoints, &[LaneValues; 2]),
    at: &mut ReprojectedPoints,
    which: u32,
    caches: &mut TileCaches,
) -> ViewColors {
    let Some(quads) = caches.quads::<true>(&views.lookup, view.camera, &at.corners(), which) else {
        return ViewColors::NONE;
    };
    let (mut coverage, mut depth, mut moved) = ([0.0; LANES], [0.0; LANES], [0; LANES]);
    for i in 0..LANES {
        let limit = at.expected[i] * view.tolerance.at(at.expected[i]);
        let shares = bilinear(at.along[i], at.down[i]);
        // Samples that show the surface there count fully, others not at all; all four do nearly everywhere.
        let (a, b) = (quads.depth[0][i], quads.depth[1][i]);
        let (c, d) = (quads.depth[2][i], quads.depth[3][i]);
        let shown_a = if agrees(a, at.expected[i], limit) { shares[0] } else { 0.0 };
        let shown_b = if agrees(b, at.expected[i], limit) { shares[1] } else { 0.0 };
        let shown_c = if agrees(c, at.expected[i], limit) { shares[2] } else { 0.0 };
        let shown_d = if agrees(d, at.expected[i], limit) { shares[3] } else { 0.0 };
        coverage[i] = (shown_a + shown_b) + (shown_c + shown_d);
        depth[i] = ((shown_a * a + shown_b * b) + (shown_c * c + shown_d * d)) / coverage[i];
        // Where the camera agrees with the z-buffer to a small part of the tolerance, correcting moves nothing.
        let is_exact = (depth[i] - at.expected[i]).abs() <= EXACT * limit;
        moved[i] = u32::from(!is_exact) << i;
    }
    let which = which & mask(|i| coverage[i] >= LEAST_COVERAGE);
    if which == 0 {
        return ViewColors::NONE;
    }
    let moved = joined(&moved);
    if moved & which != 0 && view.is_orthographic() {
        for i in (0..LANES).filter(|i| moved >> i & 1 == 1) {
            (at.along[i], at.down[i]) =
                corrected_in_orthographic(view, at, i, (points.x[i], points.y[i]), depth[i]);
        }
    } else if moved & which != 0 {
        for i in 0..LANES {
            let (along, down) = corrected(view, at, i, (points.x[i], points.y[i]), depth[i]);
            let moves = moved >> i & 1 == 1;
            at.along[i] = if moves { along } else { at.along[i] };
            at.down[i] = if moves { down } else { at.down[i] };
        }
    }
    let weights = views.weights_on_surface(view, &at.distance_ratio, points, slopes);
    weighted_colors(view, &quads, at, &weights, which)
}

/// The colors at `at` of the samples that show the surface there, for the points of a mask.
#[inline(always)]
fn weighted_colors(
    view: &SourceView,
    quads: &Quads,
    at: &ReprojectedPoints,
    weights: &LaneValues,
    which: u32,
) -> ViewColors {
    let mut found = ViewColors::NONE;
    let (mut parts, mut weight) = ([[0.0; LANES]; 4], [0.0; LANES]);
    for i in 0..LANES {
        let expected = at.expected[i];
        let limit = expected * view.tolerance.at(expected);
        let (a, b) = (quads.depth[0][i], quads.depth[1][i]);
        let (c, d) = (quads.depth[2][i], quads.depth[3][i]);
        let (agrees_a, agrees_b) = (agrees(a, expected, limit), agrees(b, expected, limit));
        let (agrees_c, agrees_d) = (agrees(c, expected, limit), agrees(d, expected, limit));
        let shares = bilinear(at.along[i], at.down[i]);
        parts[0][i] = if agrees_a { shares[0] } else { 0.0 };
        parts[1][i] = if agrees_b { shares[1] } else { 0.0 };
        parts[2][i] = if agrees_c { shares[2] } else { 0.0 };
        parts[3][i] = if agrees_d { shares[3] } else { 0.0 };
        let share = parts[0][i] + parts[1][i] + parts[2][i] + parts[3][i];
        let beside = (!agrees_a & (a >= 0.0))
            | (!agrees_b & (b >= 0.0))
            | (!agrees_c & (c >= 0.0))
            | (!agrees_d & (d >= 0.0));
        weight[i] = weights[i] * if beside { BESIDE_EDGE } else { 1.0 };
        let counts = which >> i & 1 == 1;
        found.weight[i] = if counts { share * weight[i] } else { 0.0 };
        found.coverage[i] = if counts { share } else { 0.0 };
    }
    let mut left = which;
    while left != 0 {
        let i = left.trailing_zeros() as usize % LANES;
        left &= left - 1;
        let [a, b, c, d] = [0, 1, 2, 3].map(|corner: usize| &quads.color[corner][i]);
        for channel in 0..4 {
            let blended = a[channel] * parts[0][i]
                + b[channel] * parts[1][i]
                + c[channel] * parts[2][i]
                + d[channel] * parts[3][i];
            found.color[i][channel] = blended * weight[i];
        }
    }
    found
}

/// Whether ascending positions follow one another.
#[inline(always)]
fn is_run(at: &[usize; LANES]) -> bool {
    at[LANES - 1] == at[0] + LANES - 1
}

/// The values at sixteen positions.
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

/// Adds the first `count` of `parts` to the sums at their positions.
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

/// Where between the 2×2 samples the pixel's line of sight meets the surface at inverse depth `depth`, which the camera itself saw,
/// instead of the one that the z-buffer holds.
#[inline(always)]
fn corrected(
    view: &SourceView,
    at: &ReprojectedPoints,
    i: usize,
    (x, y): (f32, f32),
    depth: f32,
) -> (f32, f32) {
    let (left, above) = (at.left[i], at.above[i]);
    let seen = view.target_from_source.point(left + at.along[i], above + at.down[i], depth);
    let there = &view.source_from_target;
    let point = there.ray(x, y) * seen.z + there.origin * depth;
    let reciprocal = 1.0 / point.z;
    let (u, v) = (point.x * reciprocal - 0.5, point.y * reciprocal - 0.5);
    let sound = (seen.z > 0.0) & (point.z > 0.0);
    let (along, down) = ((u - left).clamp(0.0, 1.0), (v - above).clamp(0.0, 1.0));
    (if sound { along } else { at.along[i] }, if sound { down } else { at.down[i] })
}

/// [`corrected`] in an orthographic camera.
#[cold]
#[inline(never)]
fn corrected_in_orthographic(
    view: &SourceView,
    at: &ReprojectedPoints,
    i: usize,
    (x, y): (f32, f32),
    depth: f32,
) -> (f32, f32) {
    let seen =
        view.target_from_source.point_of_any(at.left[i] + at.along[i], at.above[i] + at.down[i], depth);
    let (w, there) = (depth / seen.z, &view.source_from_target);
    let point = there.point(x, y, w);
    let [u, v] = there.position(point, w).map(|position| position - 0.5);
    let is_sound = (w > 0.0) & (point.z > 0.0);
    let moved = ((u - at.left[i]).clamp(0.0, 1.0), (v - at.above[i]).clamp(0.0, 1.0));
    if is_sound { moved } else { (at.along[i], at.down[i]) }
}
