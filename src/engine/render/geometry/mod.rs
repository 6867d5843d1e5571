//! Where samples are in the picture, and how large they are there.
//!
//! Oriented footprints: the patch of surface that a sample represents, as the vantage sees it.
//!
//! A plane has an inverse depth that is linear in the pixels of *any* pinhole camera. From the slope of the inverse depths
//! around a sample follow, without a normal and exactly for planes: the Jacobian of target pixels by source pixels, hence the
//! parallelogram that the source pixel covers in the target, and the slope of the target's own inverse depth over it.
//!
//! Source: for splats as oriented, projected reconstruction filters, Zwicker et al., *Surface Splatting*, SIGGRAPH 2001.
//! What differs: tangents come from neighboring depths instead of stored normals, and each pixel gets the depth of the
//! sample's plane there, not that of its center.

mod cull;
mod project;

use glam::Vec3;

use crate::samples::TILE;
pub(crate) use cull::{FootprintReach, RowBand, TileBounds, bands, bounds};
pub(crate) use project::{ProjectedPixels, Projector, growth_along, rays_in_world};

/// A footprint stretches at most to this many times its size seen face on: steeper slopes are too inexact.
pub(crate) const MAX_STRETCH: f32 = 1.5;

/// Neighboring footprints overlap by this factor, so that no crack opens between them.
pub(crate) const OVERLAP: f32 = 1.05;

/// How far a footprint reaches from its sample, in source pixels.
pub(crate) const CORE_REACH: f32 = 0.5 * OVERLAP;

/// Samples at least this many pixels wide count as magnified; gaps beside narrower ones are no wider than a pixel.
pub(crate) const MAGNIFIED: f32 = 2.5;

/// How far the fringe of a magnified sample reaches, in source pixels: over its neighbors, which may have been pruned.
pub(crate) const FRINGE: f32 = 1.0;

/// The footprints of a row of sixteen samples.
#[derive(Default)]
pub(crate) struct Footprints {
    /// The target's inverse depth at the sample.
    pub(crate) inverse_depth: [f32; TILE],
    /// Its growth from one target column to the next.
    pub(crate) slope_x: [f32; TILE],
    /// Its growth from one target row to the next.
    pub(crate) slope_y: [f32; TILE],
    /// How far the inverse depth may deviate from that at the sample within the footprint.
    pub(crate) deviation: [f32; TILE],
    /// Jacobian of target pixels by source pixels: `[∂u/∂column, ∂u/∂row, ∂v/∂column, ∂v/∂row]`.
    pub(crate) jacobian: [[f32; TILE]; 4],
    /// Its inverse: source pixels by target pixels; zeros where the surface is seen edge on.
    pub(crate) inverse: [[f32; TILE]; 4],
    /// Half the extent in target columns.
    pub(crate) half_width: [f32; TILE],
    /// Half the extent in target rows.
    pub(crate) half_height: [f32; TILE],
    /// The largest half extent, also of the fringe.
    pub(crate) largest: [f32; TILE],
}

/// The footprints of a row of samples with inverse depths `w` whose slopes are `slopes`.
#[inline(always)]
pub(crate) fn footprints(
    projector: &Projector,
    row: &ProjectedPixels,
    w: &[f32; TILE],
    slopes: &[[f32; TILE]; 2],
) -> Footprints {
    if projector.source_is_orthographic {
        return footprints_of_orthographic(projector, row, w, slopes);
    }
    let mut found = Footprints::default();
    let (across, down, origin) = (projector.per_column, projector.per_row, projector.origin);
    for i in 0..TILE {
        let (u, v, reciprocal) = (row.u[i], row.v[i], row.reciprocal[i]);
        let (wx, wy) = (slopes[0][i], slopes[1][i]);
        let target_w = w[i] * reciprocal;
        let z_across = across.z + origin.z * wx;
        let z_down = down.z + origin.z * wy;
        let a = (across.x + origin.x * wx - u * z_across) * reciprocal;
        let b = (down.x + origin.x * wy - u * z_down) * reciprocal;
        let c = (across.y + origin.y * wx - v * z_across) * reciprocal;
        let d = (down.y + origin.y * wy - v * z_down) * reciprocal;
        let w_across = (wx - target_w * z_across) * reciprocal;
        let w_down = (wy - target_w * z_down) * reciprocal;
        let determinant = a * d - b * c;
        // Edge on, the plane gives no depth in the target.
        let inverse = if determinant.abs() > 1e-6 { 1.0 / determinant } else { 0.0 };
        let largest = MAX_STRETCH * projector.focal_ratio * reciprocal;
        found.inverse_depth[i] = target_w;
        found.slope_x[i] = (w_across * d - w_down * c) * inverse;
        found.slope_y[i] = (w_down * a - w_across * b) * inverse;
        found.deviation[i] = CORE_REACH * (w_across.abs() + w_down.abs());
        found.jacobian[0][i] = a;
        found.jacobian[1][i] = b;
        found.jacobian[2][i] = c;
        found.jacobian[3][i] = d;
        found.inverse[0][i] = d * inverse;
        found.inverse[1][i] = -b * inverse;
        found.inverse[2][i] = -c * inverse;
        found.inverse[3][i] = a * inverse;
        found.largest[i] = largest;
        found.half_width[i] = (CORE_REACH * (a.abs() + b.abs())).min(largest);
        found.half_height[i] = (CORE_REACH * (c.abs() + d.abs())).min(largest);
    }
    found
}

/// The same for an orthographic source: a pixel's place counts times `w`, so that it is what the slopes move.
#[cold]
#[inline(never)]
fn footprints_of_orthographic(
    projector: &Projector,
    row: &ProjectedPixels,
    w: &[f32; TILE],
    slopes: &[[f32; TILE]; 2],
) -> Footprints {
    let mut found = Footprints::default();
    let (across, down) = (projector.per_column, projector.per_row);
    for i in 0..TILE {
        let (u, v, reciprocal) = (row.u[i], row.v[i], row.reciprocal[i]);
        let target_w = w[i] * reciprocal;
        let point = Vec3::new(u, v, 1.0) / reciprocal;
        let place = if w[i] > 0.0 { (point - projector.origin) / w[i] } else { Vec3::ZERO };
        let moved = |growth: Vec3, slope: f32| growth * w[i] + place * slope;
        let (x, y) = (moved(across, slopes[0][i]), moved(down, slopes[1][i]));
        let [a, b] = [x, y].map(|moved| (moved.x - u * moved.z) * reciprocal);
        let [c, d] = [x, y].map(|moved| (moved.y - v * moved.z) * reciprocal);
        let w_across = (slopes[0][i] - target_w * x.z) * reciprocal;
        let w_down = (slopes[1][i] - target_w * y.z) * reciprocal;
        let determinant = a * d - b * c;
        let inverse = if determinant.abs() > 1e-6 { 1.0 / determinant } else { 0.0 };
        let largest = MAX_STRETCH * projector.magnification(w[i], reciprocal);
        found.inverse_depth[i] = target_w;
        found.slope_x[i] = (w_across * d - w_down * c) * inverse;
        found.slope_y[i] = (w_down * a - w_across * b) * inverse;
        found.deviation[i] = CORE_REACH * (w_across.abs() + w_down.abs());
        for (part, value) in found.jacobian.iter_mut().zip([a, b, c, d]) {
            part[i] = value;
        }
        for (part, value) in found.inverse.iter_mut().zip([d, -b, -c, a]) {
            part[i] = value * inverse;
        }
        found.largest[i] = largest;
        found.half_width[i] = (CORE_REACH * (a.abs() + b.abs())).min(largest);
        found.half_height[i] = (CORE_REACH * (c.abs() + d.abs())).min(largest);
    }
    found
}

/// The plane of a sample at the center of a pixel.
pub(crate) struct PlaneAt {
    /// Never negative.
    pub(crate) inverse_depth: f32,
    /// Distance from the sample, in source columns.
    pub(crate) across: f32,
    /// The same in rows.
    pub(crate) down: f32,
    /// Whether the center is in the footprint without its fringe.
    pub(crate) is_core: bool,
}

impl Footprints {
    /// The plane of sample `i` at the center of pixel `(x, y)`. Its inverse depth differs from the sample's by at most `stretch` times
    /// `deviation`.
    #[inline(always)]
    pub(crate) fn plane_at(
        &self,
        row: &ProjectedPixels,
        i: usize,
        (x, y): (f32, f32),
        stretch: f32,
    ) -> PlaneAt {
        let (dx, dy) = (x + 0.5 - row.u[i], y + 0.5 - row.v[i]);
        let (across, down) = (
            self.inverse[0][i] * dx + self.inverse[1][i] * dy,
            self.inverse[2][i] * dx + self.inverse[3][i] * dy,
        );
        let is_core = (across.abs().max(down.abs()) <= CORE_REACH) | (dx.abs().max(dy.abs()) <= 0.5);
        let most = self.deviation[i] * stretch;
        // Not `clamp`, whose check for an empty range is a branch.
        let deviation = (self.slope_x[i] * dx + self.slope_y[i] * dy).min(most).max(-most);
        PlaneAt { inverse_depth: (self.inverse_depth[i] + deviation).max(0.0), across, down, is_core }
    }
}
