//! Which surface a hole pixel is filled from: the farthest one that it sees across its own hole.

use super::rays::HoleNeighbors;
use crate::capture::Camera;
use crate::render::geometry::focal;
use crate::render::vantage::Picture;
use crate::settings::RenderSettings;

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
    /// The mean of what the pixel sees of it, nearby pixels counting more.
    pub(super) mean: WeightedMean,
    /// Distance to the remotest pixel that it sees of it.
    pub(super) reach_px: f32,
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

/// The farthest surface across the hole where it is narrow that is no farther than inverse depth `limit`, if there is one, else the
/// nearest; `None` if the pixel sees nothing painted.
pub(super) fn surface_behind(
    picture: &Picture,
    seen: &HoleNeighbors,
    limit: f32,
    tolerance: SurfaceTolerance,
) -> Option<HoleSurface> {
    let HoleNeighbors { pixel, distance_px } = *seen;
    let inverse_depth = pixel.map(|pixel| picture.inverse_depth.as_slice()[pixel]);
    let pairs = [0, 1, 2, 3].map(|direction| (distance_px[direction], distance_px[direction + 4]));
    let narrowest_px = pairs.iter().map(|(a, b)| a + b).fold(f32::INFINITY, f32::min);
    // Where one of two opposite rays leaves the picture, the hole is taken to be as wide on that side as on the other.
    let width_px = pairs.map(|(a, b)| if (a + b).is_finite() { a + b } else { 2.0 * a.min(b) });
    let mut behind: Option<(f32, f32)> = None;
    for direction in 0..8 {
        let (far, distance_px) = (inverse_depth[direction], distance_px[direction]);
        let counts = distance_px.is_finite()
            && far >= limit * LIMIT_SLACK
            && width_px[direction % 4] <= MAX_WIDTH_RATIO * narrowest_px;
        if counts && behind.is_none_or(|behind| (far, distance_px) < behind) {
            behind = Some((far, distance_px));
        }
    }
    let (far, far_px) = behind.or_else(|| nearest_of(&inverse_depth, &distance_px))?;
    let mut surface = HoleSurface { range: [far; 2], mean: WeightedMean::EMPTY, reach_px: 0.0 };
    for direction in 0..8 {
        let (near, near_px) = (inverse_depth[direction], distance_px[direction]);
        if near_px.is_finite() && near.max(far) <= near.min(far) * tolerance.factor(near_px + far_px) {
            surface.range = [surface.range[0].min(near), surface.range[1].max(near)];
            surface.reach_px = surface.reach_px.max(near_px);
            let color = picture.color.as_slice()[pixel[direction]];
            surface.mean.add(1.0 / (near_px * near_px), color, near);
        }
    }
    surface.mean = surface.mean.normalized();
    Some(surface)
}

/// Inverse depth and distance of the nearest surface that a hole pixel sees.
fn nearest_of(inverse_depth: &[f32; 8], distance_px: &[f32; 8]) -> Option<(f32, f32)> {
    let seen = inverse_depth.iter().zip(distance_px).filter(|(_, distance)| distance.is_finite());
    seen.map(|(w, distance)| (*w, *distance)).max_by(|a, b| a.0.total_cmp(&b.0).then(b.1.total_cmp(&a.1)))
}
