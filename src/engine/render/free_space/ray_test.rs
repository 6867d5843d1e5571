//! Which parts of a line of sight no camera has seen free.

use super::seen_depth::{FreeDepths, SeenDepths, UNSEEN};
use crate::capture::Camera;
use crate::capture::overlap::nearest_first;
use crate::render::geometry::Projector;
use crate::render::input::LaneValues;
use crate::render::input::focal;
use crate::samples::halved_camera;
use crate::simd::{LANES, joined, whole};

/// Vectors of inverse depths at which a line of sight is tested.
const GROUPS: usize = 4;

/// Inverse depths at which a line of sight is tested.
const DEPTHS: usize = GROUPS * LANES;

/// Inverse depths at which a short part of one is tested.
const FEW_DEPTHS: usize = 4;

/// What a camera saw counts as behind a point only if it is farther by this many cells' footprints.
const BEHIND_FOOTPRINTS: f32 = 1.0;

/// What cameras know about a line of sight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum LineOfSight {
    /// Cameras have seen all of it free.
    Free,
    /// Some of it was in no camera's picture, and the rest was seen free.
    Unseen,
    /// Some of it is behind what every camera saw there.
    Hidden(HiddenPart),
}

/// What of a line of sight is behind what every camera saw there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct HiddenPart {
    /// Its share of the tested inverse depths, 0 to 1.
    pub(super) share: f32,
    /// The inverse depth at which the longest stretch of it ends.
    pub(super) end: f32,
}

/// Tests lines of sight of the vantage.
pub(crate) struct RayTest<'a> {
    views: Vec<CellView<'a>>,
}

/// A camera whose lines of sight are compared.
struct CellView<'a> {
    free: &'a FreeDepths,
    cells_from_target: Projector,
    /// Inverse depths below this share of a point's are behind it.
    behind_ratio: f32,
    /// Of an orthographic camera: what is farther by more than this is behind, world units.
    behind_by: Option<f32>,
}

/// At most this many cameras are consulted: those far from the vantage seldom see what the nearest do not.
const MOST_CAMERAS: usize = 12;

/// The cameras that are consulted about the lines of sight of `target`. The nearest come first, because they decide most.
pub(crate) fn cameras_to_ask(cameras: &[Camera], target: &Camera) -> Vec<usize> {
    let center = target.position_in_world();
    let distance = |camera: usize| cameras[camera].position_in_world().distance(center);
    let mut order = nearest_first(0..cameras.len(), distance);
    order.truncate(MOST_CAMERAS);
    order
}

/// Inverse depths below this share of a point's are behind it, by the camera of the cells.
pub(crate) fn behind_ratio(cells: &Camera) -> f32 {
    1.0 - BEHIND_FOOTPRINTS / focal(cells)
}

impl<'a> RayTest<'a> {
    /// For lines of sight of `target`. What `cameras_to_ask` saw must be in `seen` already.
    pub(crate) fn new(seen: &'a SeenDepths, cameras: &[Camera], target: &Camera) -> Self {
        let view = |camera: usize| {
            let cells = halved_camera(&cameras[camera]);
            let cells_from_target = Projector::new(target, &cells);
            let behind_ratio = behind_ratio(&cells);
            let behind_by = cells.intrinsics.is_orthographic().then(|| BEHIND_FOOTPRINTS / focal(&cells));
            Some(CellView { free: seen.free_depths(camera)?, cells_from_target, behind_ratio, behind_by })
        };
        Self { views: cameras_to_ask(cameras, target).into_iter().filter_map(view).collect() }
    }

    /// Tests the line of sight of pixel `(x, y)` between the inverse depths `near` and `far`, evenly in inverse depth, which is
    /// evenly in the pixels of every camera.
    #[inline(always)]
    pub(super) fn test(&self, (x, y): (f32, f32), near: f32, far: f32) -> LineOfSight {
        let step = (near - far) / DEPTHS as f32;
        let (mut free, mut blocked) = (0_u64, 0_u64);
        for group in 0..GROUPS {
            let mut w = [0.0; LANES];
            for i in 0..LANES {
                w[i] = near - step * ((group * LANES + i) as f32 + 0.5);
            }
            let (mut group_free, mut group_blocked) = (0_u32, 0_u32);
            for view in &self.views {
                let [is_free, is_blocked] = Self::look(view, (x, y), &w);
                group_free |= is_free;
                group_blocked |= is_blocked;
                if group_free == 0xffff {
                    break;
                }
            }
            free |= u64::from(group_free) << (group * LANES);
            blocked |= u64::from(group_blocked & !group_free) << (group * LANES);
        }
        if blocked != 0 {
            let end = near - step * end_of_longest_run(blocked) as f32;
            return LineOfSight::Hidden(HiddenPart {
                share: blocked.count_ones() as f32 / DEPTHS as f32,
                end,
            });
        }
        if free == u64::MAX >> (64 - DEPTHS) { LineOfSight::Free } else { LineOfSight::Unseen }
    }

    /// Whether any camera saw through the line of sight of pixel `(x, y)` somewhere between the inverse depths `near` and `far`. One number
    /// after the other: vectors as in [`Self::look`] pay only where the instruction set is chosen, which it is not where holes are filled.
    pub(crate) fn sees_through(&self, (x, y): (f32, f32), near: f32, far: f32) -> bool {
        let step = (near - far) / FEW_DEPTHS as f32;
        let depths: [f32; FEW_DEPTHS] = std::array::from_fn(|nth| near - step * (nth as f32 + 0.5));
        self.views.iter().any(|view| {
            if view.behind_by.is_some() {
                return depths.iter().any(|w| Self::look(view, (x, y), &[*w; LANES])[0] != 0);
            }
            let free_depths = view.free;
            let (ray, origin) = (view.cells_from_target.ray(x, y), view.cells_from_target.origin);
            let (right, below) = ((free_depths.across - 1) as f32, (free_depths.down - 1) as f32);
            depths.iter().any(|w| {
                let reciprocal = 1.0 / (ray.z + origin.z * w);
                let u = ((ray.x + origin.x * w) * reciprocal + 1.5).max(0.0).min(right) as usize;
                let v = ((ray.y + origin.y * w) * reciprocal + 1.5).max(0.0).min(below) as usize;
                let limit = w * reciprocal * view.behind_ratio;
                reciprocal > 0.0 && free_depths.farthest[v * free_depths.across + u] < limit
            })
        })
    }

    /// At which of some inverse depths a camera saw the pixel's line of sight free, and at which it saw something in front of it:
    /// one bit each.
    #[inline(always)]
    fn look(view: &CellView<'_>, (x, y): (f32, f32), w: &LaneValues) -> [u32; 2] {
        if let Some(behind_by) = view.behind_by {
            return Self::look_of_orthographic(view, (x, y), w, behind_by);
        }
        let free_depths = view.free;
        let projector = &view.cells_from_target;
        let (ray, origin) = (projector.ray(x, y), projector.origin);
        let (right, below) = ((free_depths.across - 1) as f32, (free_depths.down - 1) as f32);
        let across = free_depths.across as u32;
        let (mut at, mut limit) = ([0_u32; LANES], [0.0; LANES]);
        for i in 0..LANES {
            let reciprocal = 1.0 / (ray.z + origin.z * w[i]);
            // The corner nearest to the point; the outermost ones, where nothing was seen, if it is beside the picture.
            let u = ((ray.x + origin.x * w[i]) * reciprocal + 1.5).max(0.0).min(right);
            let v = ((ray.y + origin.y * w[i]) * reciprocal + 1.5).max(0.0).min(below);
            let corner = whole(v.floor()).wrapping_mul(across).wrapping_add(whole(u.floor()));
            let in_front = reciprocal > 0.0;
            at[i] = if in_front { corner } else { 0 };
            limit[i] = w[i] * reciprocal * view.behind_ratio;
        }
        let (mut free, mut blocked) = ([0_u32; LANES], [0_u32; LANES]);
        let last = free_depths.farthest.len() - 1;
        for i in 0..LANES {
            let farthest = free_depths.farthest[(at[i] as usize).min(last)];
            free[i] = u32::from(farthest < limit[i]) << i;
            blocked[i] = u32::from((farthest >= limit[i]) & (farthest < UNSEEN)) << i;
        }
        [joined(&free), joined(&blocked)]
    }

    /// The same of an orthographic camera. Apart, so that those in perspective stay as fast as they are.
    #[cold]
    #[inline(never)]
    fn look_of_orthographic(
        view: &CellView<'_>,
        (x, y): (f32, f32),
        w: &LaneValues,
        behind_by: f32,
    ) -> [u32; 2] {
        let FreeDepths { across, down, farthest } = view.free;
        let (mut free, mut blocked) = (0, 0);
        for (i, &w) in w.iter().enumerate() {
            let projector = &view.cells_from_target;
            let point = projector.point(x, y, w);
            let [u, v] = projector.position(point, w).map(|position| position + 1.5);
            let is_inside = u >= 0.0 && v >= 0.0 && u < *across as f32 && v < *down as f32;
            if !(is_inside && point.z > 0.0) {
                continue;
            }
            let found = farthest[v as usize * across + u as usize];
            // As depths: the point's, and what is behind it by a footprint.
            let limit = (point.z / w + behind_by).recip();
            free |= u32::from(found < limit) << i;
            blocked |= u32::from(found >= limit && found < UNSEEN) << i;
        }
        [free, blocked]
    }
}

/// The position after the longest run of set bits.
fn end_of_longest_run(bits: u64) -> u32 {
    let (mut left, mut longest, mut end) = (bits, 0, 0);
    while left != 0 {
        let start = left.trailing_zeros();
        let length = (!(left >> start)).trailing_zeros();
        if length > longest {
            (longest, end) = (length, start + length);
        }
        left &= left.wrapping_add(1 << start);
    }
    end
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_longest_of_several_runs_is_found_and_the_first_of_equal_ones() {
        assert_eq!(end_of_longest_run(0), 0);
        assert_eq!(end_of_longest_run(0b1), 1);
        assert_eq!(end_of_longest_run(0b0111_0011), 7);
        assert_eq!(end_of_longest_run(0b0110_0011), 2);
        assert_eq!(end_of_longest_run(u64::MAX), 64);
        assert_eq!(end_of_longest_run(u64::MAX << 1), 64);
        assert_eq!(end_of_longest_run(1 << 63), 64);
        assert_eq!(end_of_longest_run(u64::MAX >> 1), 63);
        assert_eq!(end_of_longest_run(0xffff_0000_0fff_ffff), 28);
    }

    #[test]
    fn the_end_of_the_longest_run_is_that_of_a_plain_search() {
        let plain = |bits: u64| {
            let (mut longest, mut end, mut length) = (0, 0, 0);
            for bit in 0..64 {
                length = if bits >> bit & 1 == 1 { length + 1 } else { 0 };
                if length > longest {
                    (longest, end) = (length, bit + 1);
                }
            }
            end
        };
        let mut bits = 0x9e37_79b9_7f4a_7c15_u64;
        for _ in 0..2000 {
            bits ^= bits << 13;
            bits ^= bits >> 7;
            bits ^= bits << 17;
            for bits in [bits, bits | bits << 1, bits & bits << 3, !(bits & bits >> 5)] {
                assert_eq!(end_of_longest_run(bits), plain(bits), "{bits:b}");
            }
        }
    }
}
