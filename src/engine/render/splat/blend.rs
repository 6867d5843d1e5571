//! The blend stage: the colors of all samples of the nearest surface, weighted and summed in every pixel.
//!
//! `block` weighs bilinearly over the 2×2 pixels around a sample (the paper, §3.3, "a coarse blending within a 4-pixel
//! region"). `surfel` weighs by the sample's oriented footprint; by its sampling rate, which falls with distance and with the
//! angle of incidence; by the angle between its camera's line of sight and the vantage's; and less beside another surface.
//!
//! Source: for screen-space filters joined with projected footprints, Zwicker et al., *Surface Splatting*, SIGGRAPH 2001,
//! equation 11. What differs: the kernel is `(1 − q/q₀)²` instead of a Gaussian, so that it ends, and only samples within a
//! tolerance of the nearest surface take part.

use std::ops::Range;

use glam::Vec3;
use rayon::prelude::*;

use super::input::{StageInput, split_at_bands};
use super::zkey::inverse_depth_of;
use crate::error::Result;
use crate::render::geometry::{
    FootprintReach, Footprints, MAX_STRETCH, ProjectedPixels, Projector, RowBand, footprints,
};
use crate::render::input::{DenseTile, FrameTile, beside_edges, slopes};
use crate::samples::TILE;
use crate::settings::Kernel;
use crate::simd::{self, VectorLoop};

/// One pixel's sum of weighted colors, and of weights.
pub(crate) type BlendSum = [f32; 4];

/// Weights that sum to less give no color: the fixed-point sums of the GPU would be too inexact. Only samples that lie far apart in
/// the picture and outermost parts of kernels sum to so little.
pub(crate) const LEAST_WEIGHT: f32 = 1.0 / 65536.0;

/// Variance of the reconstruction filter, squared source pixels, and of the screen filter, squared target pixels.
const SOURCE_VARIANCE: f32 = 0.15;
const SCREEN_VARIANCE: f32 = 0.1;

/// The squared distance, in standard deviations, at which a footprint's weight has fallen to 0.
const KERNEL_END: f32 = 6.0;

/// Footprints reach no farther, in target pixels.
const MAX_REACH: f32 = 64.0;

/// How far a sample's weight reaches: the filter, and twice the widest footprint.
pub(crate) const BLEND_REACH: FootprintReach =
    FootprintReach { pixels: 1.5, source_pixels: 2.0 * MAX_STRETCH };

/// Adds up the colors in `bands` of the samples that are on the nearest surface, by the z-buffer `keys`.
pub(crate) fn blend(
    input: &StageInput<'_>,
    bands: &[RowBand],
    keys: &[u64],
    sums: &mut [BlendSum],
) -> Result<()> {
    let parts: Vec<BandBlend<'_>> = split_at_bands(bands, input.width, sums)
        .into_iter()
        .map(|(band, sums)| {
            let keys = &keys[band.rows.start * input.width..band.rows.end * input.width];
            BandBlend { input, band, keys, sums }
        })
        .collect();
    parts.into_par_iter().try_for_each(simd::run)
}

struct BandBlend<'a> {
    input: &'a StageInput<'a>,
    band: &'a RowBand,
    keys: &'a [u64],
    sums: &'a mut [BlendSum],
}

impl VectorLoop for BandBlend<'_> {
    type Output = Result<()>;

    #[inline(always)]
    fn run(self) -> Result<()> {
        let Self { input, band, keys, sums } = self;
        let (width, surface_ratio) = (input.width, input.surface_ratio);
        let mut dense = DenseTile::new();
        let mut sums = BandSums { width, rows: band.rows.clone(), keys, surface_ratio, sums };
        for &number in &band.tiles {
            input.job.check()?;
            let tile = input.frame.tile(number as usize);
            let camera = tile.camera as usize;
            let projector = &input.projectors[camera];
            dense.unpack(tile);
            let (x, y) = tile.origin;
            let mut nth = 0;
            for row in (0..TILE).filter(|row| tile.rows[*row] != 0) {
                let w = dense.row(row);
                let ray = projector.ray(x as f32, (y as usize + row) as f32);
                let projected = projector.row(ray, w);
                let samples = RowSamples { mask: tile.rows[row], first: nth, tile, w };
                if input.kernel == Kernel::Surfel {
                    let slopes = slopes(&dense, row, input.per_footprint[camera]);
                    let mut trust = cosines(&input.rays_in_world, projector, ray, &projected);
                    let beside = beside_edges(&dense, row, input.per_footprint[camera]);
                    for i in 0..TILE {
                        trust[i] *= if beside[i] { BESIDE_EDGE } else { 1.0 };
                    }
                    let found = footprints(projector, &projected, w, &slopes);
                    sums.add_footprints(projector, &projected, &found, &trust, &samples);
                } else {
                    sums.add_blocks(&projected, &samples);
                }
                nth += tile.rows[row].count_ones() as usize;
            }
        }
        Ok(())
    }
}

/// The samples in a row of a tile.
struct RowSamples<'a> {
    mask: u16,
    first: usize,
    tile: &'a FrameTile<'a>,
    w: &'a [f32; TILE],
}

impl RowSamples<'_> {
    /// Column, inverse depth and color of every sample.
    #[inline(always)]
    fn for_each(&self, mut visit: impl FnMut(usize, f32, [f32; 3])) {
        let (mut left, mut nth) = (self.mask, self.first);
        while left != 0 {
            let column = left.trailing_zeros() as usize;
            visit(column, self.w[column], self.tile.color(nth));
            left &= left - 1;
            nth += 1;
        }
    }
}

/// The weight of samples beside another surface, whose colors may be blended with it. Measured: a half gains most.
const BESIDE_EDGE: f32 = 0.5;

/// The least weight of a line of sight.
const LEAST_COSINE: f32 = 0.01;

/// Cosines between the camera's and the vantage's lines of sight to the samples of a row; `ray` is that of its first pixel.
#[inline(always)]
fn cosines(
    rays_in_world: &[Vec3; 3],
    projector: &Projector,
    ray: Vec3,
    projected: &ProjectedPixels,
) -> [f32; TILE] {
    let [corner, across, down] = *rays_in_world;
    let mut cosines = [0.0; TILE];
    for i in 0..TILE {
        let image = if projector.source_is_orthographic {
            projector.origin
        } else {
            ray + projector.per_column * i as f32
        };
        let from_camera = across * image.x + down * image.y + corner * image.z;
        let from_vantage = across * projected.u[i] + down * projected.v[i] + corner;
        let lengths = (from_camera.length_squared() * from_vantage.length_squared()).sqrt();
        cosines[i] = (from_camera.dot(from_vantage) / lengths).max(LEAST_COSINE);
    }
    cosines
}

/// The sums of a band, and the keys by which samples take part.
struct BandSums<'a> {
    width: usize,
    rows: Range<usize>,
    keys: &'a [u64],
    surface_ratio: f32,
    sums: &'a mut [BlendSum],
}

impl BandSums<'_> {
    #[inline(always)]
    fn add(&mut self, x: usize, y: usize, depth: f32, weight: f32, color: [f32; 3]) {
        let pixel = (y - self.rows.start) * self.width + x;
        let nearest = inverse_depth_of(self.keys[pixel]);
        // Neither what is behind the surface, nor a nearer sample whose kernel only touches the edge of the pixel.
        if depth >= nearest * self.surface_ratio && depth * self.surface_ratio <= nearest {
            let sum = &mut self.sums[pixel];
            let parts = [color[0] * weight, color[1] * weight, color[2] * weight, weight];
            (0..4).for_each(|channel| sum[channel] += parts[channel]);
        }
    }

    #[inline(always)]
    fn add_blocks(&mut self, projected: &ProjectedPixels, samples: &RowSamples<'_>) {
        let (width, top, bottom) = (self.width as f32, self.rows.start as f32, self.rows.end as f32);
        samples.for_each(|i, w, color| {
            let (u, v, reciprocal) = (projected.u[i] - 0.5, projected.v[i] - 0.5, projected.reciprocal[i]);
            let (left, above) = (u.floor(), v.floor());
            let inside = left >= -1.0 && left < width && above >= top - 1.0 && above < bottom;
            if !inside || reciprocal <= 0.0 {
                return;
            }
            let (along, down) = (u - left, v - above);
            for (dy, share_y) in [(0.0, 1.0 - down), (1.0, down)] {
                for (dx, share_x) in [(0.0, 1.0 - along), (1.0, along)] {
                    let (x, y) = (left + dx, above + dy);
                    if x >= 0.0 && x < width && y >= top && y < bottom {
                        self.add(x as usize, y as usize, w * reciprocal, share_x * share_y, color);
                    }
                }
            }
        });
    }

    #[inline(always)]
    fn add_footprints(
        &mut self,
        projector: &Projector,
        projected: &ProjectedPixels,
        found: &Footprints,
        trust: &[f32; TILE],
        samples: &RowSamples<'_>,
    ) {
        let (width, top, bottom) = (self.width as f32, self.rows.start as f32, self.rows.end as f32);
        samples.for_each(|i, w, color| {
            if projected.reciprocal[i] <= 0.0 {
                return;
            }
            let [a, b, c, d] = [0, 1, 2, 3].map(|entry| found.jacobian[entry][i]);
            let xx = SOURCE_VARIANCE * (a * a + b * b) + SCREEN_VARIANCE;
            let yy = SOURCE_VARIANCE * (c * c + d * d) + SCREEN_VARIANCE;
            let xy = SOURCE_VARIANCE * (a * c + b * d);
            let area = (a * d - b * c).abs().max(0.05);
            let determinant = xx * yy - xy * xy;
            let (half_width, half_height) = ((KERNEL_END * xx).sqrt(), (KERNEL_END * yy).sqrt());
            // Not beyond the bounds that tiles are culled by: the picture must not depend on how it is cut into bands.
            let limit = (BLEND_REACH.pixels
                + BLEND_REACH.source_pixels
                    * projector.focal_ratio
                    * projector.distance_ratio(w, projected.reciprocal[i]))
            .min(MAX_REACH);
            let (half_width, half_height) = (half_width.min(limit), half_height.min(limit));
            let (u, v) = (projected.u[i], projected.v[i]);
            let left = (u - half_width - 0.5).ceil().max(0.0);
            let right = (u + half_width - 0.5).floor().min(width - 1.0);
            let above = (v - half_height - 0.5).ceil().max(top);
            let below = (v + half_height - 0.5).floor().min(bottom - 1.0);
            if !(left <= right && above <= below) {
                return;
            }
            for y in above as usize..=below as usize {
                for x in left as usize..=right as usize {
                    let (dx, dy) = (x as f32 + 0.5 - u, y as f32 + 0.5 - v);
                    let q = (yy * dx * dx - 2.0 * xy * dx * dy + xx * dy * dy) / determinant;
                    let share = (1.0 - q / KERNEL_END).max(0.0);
                    let depth = found.inverse_depth[i] + found.slope_x[i] * dx + found.slope_y[i] * dy;
                    self.add(x, y, depth, share * share * trust[i] / area, color);
                }
            }
        });
    }
}
