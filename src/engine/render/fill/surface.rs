//! Which surface a hole pixel is filled from: the farthest one that it sees across its own hole.

use super::rays::HoleNeighbors;
use crate::capture::Camera;
use crate::render::input::focal;
use crate::render::vantage::Picture;
use crate::settings::RenderSettings;
use crate::simd::joined;

/// Directions in which the hole is up to this many times as wide as where it is narrowest count: in a corner of a near object
/// the narrowest runs from near to near, and only a longer one reaches the background.
const MAX_WIDTH_RATIO: f32 = 4.0;

/// A surface counts as no farther than a limit from this share of its inverse depth on: the surface around a hole slopes.
const LIMIT_SLACK: f32 = 0.95;

/// Tells surfaces apart by their inverse depths.
#[derive(Clone, Copy, Debug)]
pub(super) struct SurfaceTolerance {
    footprints: f32,
    focal_px: f32,
}

impl SurfaceTolerance {
    pub(super) fn new(target: &Camera, settings: &RenderSettings) -> Self {
        Self { footprints: settings.depth_tolerance, focal_px: focal(target) }
    }

    /// The factor by which inverse depths of one surface may differ over `distance_px`: what the renderer blends within a pixel,
    /// and one footprint more per pixel, as on a surface at 45° to the line of sight.
    pub(super) fn factor(self, distance_px: f32) -> f32 {
        1.0 + (self.footprints + distance_px) / self.focal_px
    }
}

/// The surface that a hole pixel is filled from.
pub(super) struct HoleSurface {
    /// Smallest and largest inverse depth of it that the pixel sees.
    pub(super) range: [f32; 2],
    /// Distance to the remotest pixel that it sees of it.
    pub(super) reach_px: f32,
    /// The directions in which the pixel sees it: one bit each.
    directions: u32,
}

/// A mean color and inverse depth with their weight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct WeightedMean {
    /// Linear Rec.709.
    pub(super) color: [f32; 3],
    /// Reciprocal of planar z.
    pub(super) inverse_depth: f32,
    /// In a pyramid the share of the block that the surface covers, 0 to 1; 0 where nothing is painted.
    pub(super) weight: f32,
}

impl WeightedMean {
    /// No weight.
    pub(super) const EMPTY: Self = Self { color: [0.0; 3], inverse_depth: 0.0, weight: 0.0 };

    /// Adds a color; the cell is a sum until it is normalized.
    pub(super) fn add(&mut self, weight: f32, color: [f32; 3], inverse_depth: f32) {
        (0..3).for_each(|channel| self.color[channel] += weight * color[channel]);
        self.inverse_depth += weight * inverse_depth;
        self.weight += weight;
    }

    /// The mean of what was added.
    pub(super) fn normalized(self) -> Self {
        let scale = self.weight.recip();
        let color = self.color.map(|channel| channel * scale);
        Self { color, inverse_depth: self.inverse_depth * scale, weight: self.weight }
    }
}

/// The surface in the direction that is `covering` the pixel, if one is; else the farthest surface across the hole where it is narrow that
/// is no farther than inverse depth `limit`, if there is one, else the nearest; `None` if the pixel sees nothing painted. `depths` are the
/// inverse depths of the picture.
#[inline]
pub(super) fn surface_behind(
    depths: &[f32],
    seen: &HoleNeighbors,
    limit: f32,
    covering: Option<usize>,
    tolerance: SurfaceTolerance,
) -> Option<HoleSurface> {
    let HoleNeighbors { pixel, distance_px } = seen;
    let mut inverse_depth = [0.0; 8];
    for direction in 0..8 {
        inverse_depth[direction] = depths[pixel[direction]];
    }
    let mut width_px = [0.0; 8];
    let mut narrowest_px = f32::INFINITY;
    for direction in 0..4 {
        let (a, b) = (distance_px[direction], distance_px[direction + 4]);
        narrowest_px = narrowest_px.min(a + b);
        // Where one of two opposite rays leaves the picture, the hole is taken to be as wide on that side as on the other.
        let width = if a + b < f32::INFINITY { a + b } else { 2.0 * a.min(b) };
        (width_px[direction], width_px[direction + 4]) = (width, width);
    }
    // The farthest surface among the directions that count, and the nearest pixel among equally far ones.
    let (farthest, widest) = (limit * LIMIT_SLACK, MAX_WIDTH_RATIO * narrowest_px);
    let (mut counted, mut far) = ([f32::INFINITY; 8], f32::INFINITY);
    for direction in 0..8 {
        let counts = (distance_px[direction] < f32::INFINITY)
            & (inverse_depth[direction] >= farthest)
            & (width_px[direction] <= widest);
        counted[direction] = if counts { inverse_depth[direction] } else { f32::INFINITY };
    }
    for counted in counted {
        far = far.min(counted);
    }
    let mut far_px = f32::INFINITY;
    for direction in 0..8 {
        far_px = far_px.min(if counted[direction] == far { distance_px[direction] } else { f32::INFINITY });
    }
    if let Some(direction) = covering {
        (far, far_px) = (inverse_depth[direction], distance_px[direction]);
    }
    if far == f32::INFINITY {
        (far, far_px) = nearest_of(&inverse_depth, distance_px)?;
    }
    let (mut is_same, mut range, mut reach_px) = ([0_u32; 8], [far; 2], 0.0_f32);
    for direction in 0..8 {
        let (near, near_px) = (inverse_depth[direction], distance_px[direction]);
        let same =
            (near_px < f32::INFINITY) & (near.max(far) <= near.min(far) * tolerance.factor(near_px + far_px));
        is_same[direction] = u32::from(same) << direction;
        range[0] = range[0].min(if same { near } else { far });
        range[1] = range[1].max(if same { near } else { far });
        reach_px = reach_px.max(if same { near_px } else { 0.0 });
    }
    Some(HoleSurface { range, reach_px, directions: joined(&is_same) })
}

impl HoleSurface {
    /// The mean of what the pixel sees of it in a picture, nearby pixels counting more; `seen` as for [`surface_behind`].
    #[cold]
    pub(super) fn mean(&self, picture: &Picture, seen: &HoleNeighbors) -> WeightedMean {
        let mut mean = WeightedMean::EMPTY;
        for direction in (0..8).filter(|direction| self.directions >> direction & 1 == 1) {
            let (pixel, near_px) = (seen.pixel[direction], seen.distance_px[direction]);
            let (color, near) = (picture.color.as_slice()[pixel], picture.inverse_depth.as_slice()[pixel]);
            mean.add(1.0 / (near_px * near_px), color, near);
        }
        mean.normalized()
    }
}

/// Inverse depth and distance of the nearest surface that a hole pixel sees.
fn nearest_of(inverse_depth: &[f32; 8], distance_px: &[f32; 8]) -> Option<(f32, f32)> {
    let seen = inverse_depth.iter().zip(distance_px).filter(|(_, distance)| distance.is_finite());
    seen.map(|(w, distance)| (*w, *distance)).max_by(|a, b| a.0.total_cmp(&b.0).then(b.1.total_cmp(&a.1)))
}
