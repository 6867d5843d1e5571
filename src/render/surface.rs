//! The surface stage: which sample is nearest in each pixel.
//!
//! Kernels differ in the pixels that a sample touches: `point` the one it falls into; `block` the 2×2 around it (the paper,
//! §3.3); `surfel` and `gather` those whose centers lie in its oriented footprint, each at the depth of its plane there.

use std::ops::Range;

use rayon::prelude::*;

use super::cull::Band;
use super::dense_tile::{DenseTile, slopes};
use super::footprint::{Footprints, OVERLAP, footprints};
use super::frame_samples::FrameSamples;
use super::keys::{CORE, key, nearness};
use super::project::{ProjectedRow, Projector};
use crate::error::Result;
use crate::job::Job;
use crate::preprocess::TILE;
use crate::settings::Kernel;
use crate::simd::{self, Work};

/// A sample belongs to the core of a pixel that gets at least this share of it by bilinear weights, and else to its
/// fringe. The fringe fills pixels that are no sample's core; elsewhere it stays away, so that silhouettes do not grow.
const CORE_SHARE: f32 = 0.06;

/// What the stages of one picture share.
pub(super) struct Stage<'a> {
    pub(super) frame: &'a FrameSamples<'a>,
    /// Carries each camera into the target.
    pub(super) projectors: &'a [Projector],
    /// Reciprocal focal length of each camera: the size of its footprints at unit distance.
    pub(super) per_footprint: &'a [f32],
    /// Columns of the target.
    pub(super) width: usize,
    pub(super) kernel: Kernel,
    pub(super) job: &'a Job,
}

/// Cuts a buffer of `width` columns into the rows of each band; bands ascend.
pub(super) fn split_at_bands<'a, 'b, T>(
    bands: &'a [Band],
    width: usize,
    buffer: &'b mut [T],
) -> Vec<(&'a Band, &'b mut [T])> {
    let (mut rest, mut row) = (buffer, 0);
    let mut parts = Vec::with_capacity(bands.len());
    for band in bands {
        let (_, from) = rest.split_at_mut((band.rows.start - row) * width);
        let (part, after) = from.split_at_mut(band.rows.len() * width);
        parts.push((band, part));
        (rest, row) = (after, band.rows.end);
    }
    parts
}

/// Raises the keys of the pixels of `bands` to those of their samples.
///
/// # Errors
/// `Cancelled`.
pub(super) fn surface(stage: &Stage<'_>, bands: &[Band], keys: &mut [u64]) -> Result<()> {
    split_at_bands(bands, stage.width, keys)
        .into_par_iter()
        .try_for_each(|(band, keys)| simd::run(BandSurface { stage, band, keys }))
}

/// One band of the picture.
struct BandSurface<'a> {
    stage: &'a Stage<'a>,
    band: &'a Band,
    keys: &'a mut [u64],
}

impl Work for BandSurface<'_> {
    type Output = Result<()>;

    #[inline(always)]
    fn run(self) -> Result<()> {
        let Self { stage, band, keys } = self;
        let mut dense = DenseTile::new();
        let rows = band.rows.clone();
        for &number in &band.tiles {
            stage.job.check()?;
            let tile = &stage.frame.tiles[number as usize];
            let camera = tile.camera as usize;
            let projector = &stage.projectors[camera];
            dense.unpack(tile);
            let (x, y) = tile.origin;
            for row in (0..TILE).filter(|row| tile.rows[*row] != 0) {
                let w = &dense.inverse_depth[row];
                let projected = projector.row(projector.ray(x as f32, (y as usize + row) as f32), w);
                let slots = number << 8 | (row as u32) << 4;
                let window = Window { width: stage.width, rows: rows.clone(), keys: &mut *keys };
                match stage.kernel {
                    Kernel::Point => window.points(&projected, w, slots),
                    Kernel::Block => window.blocks(&projected, w, slots),
                    Kernel::Surfel | Kernel::Gather => {
                        let slopes = slopes(&dense, row, stage.per_footprint[camera]);
                        window.footprints(projector, &projected, (w, &slopes), slots);
                    }
                }
            }
        }
        Ok(())
    }
}

/// The rows of the picture that are being painted.
struct Window<'a> {
    width: usize,
    rows: Range<usize>,
    keys: &'a mut [u64],
}

impl Window<'_> {
    /// Sets each pixel to the larger of its key and the new one. Keys of 0 change nothing.
    #[inline(always)]
    fn raise(&mut self, pixels: &[u32; TILE], uppers: &[u32; TILE], slots: u32) {
        let mut new = [0_u64; TILE];
        for column in 0..TILE {
            let full = key(uppers[column], slots | column as u32);
            new[column] = if uppers[column] == 0 { 0 } else { full };
        }
        for column in 0..TILE {
            let pixel = &mut self.keys[pixels[column] as usize];
            *pixel = (*pixel).max(new[column]);
        }
    }

    /// The pixel at column `x` and row `y` (whole numbers), and whether it lies in the window; if not, some pixel that does.
    #[inline(always)]
    fn pixel(&self, x: f32, y: f32) -> (u32, bool) {
        let (right, top, bottom) =
            ((self.width - 1) as f32, self.rows.start as f32, (self.rows.end - 1) as f32);
        let inside = (x >= 0.0) & (x <= right) & (y >= top) & (y <= bottom);
        // What lies outside, or is no number, goes to the corner.
        let (x, y) = if inside { (x, y - top) } else { (0.0, 0.0) };
        (whole(y) * self.width as u32 + whole(x), inside)
    }

    #[inline(always)]
    fn points(mut self, projected: &ProjectedRow, w: &[f32; TILE], slots: u32) {
        let (mut pixels, mut uppers) = ([0; TILE], [0; TILE]);
        for i in 0..TILE {
            let (pixel, inside) = self.pixel(projected.u[i].floor(), projected.v[i].floor());
            let seen = inside & (projected.reciprocal[i] > 0.0) & (w[i] >= 0.0);
            pixels[i] = pixel;
            uppers[i] = if seen { nearness(w[i] * projected.reciprocal[i], CORE) } else { 0 };
        }
        self.raise(&pixels, &uppers, slots);
    }

    #[inline(always)]
    fn blocks(mut self, projected: &ProjectedRow, w: &[f32; TILE], slots: u32) {
        for corner in 0..4 {
            let (right, below) = ((corner & 1) as f32, (corner >> 1) as f32);
            let (mut pixels, mut uppers) = ([0; TILE], [0; TILE]);
            for i in 0..TILE {
                let (left, top) = ((projected.u[i] - 0.5).floor(), (projected.v[i] - 0.5).floor());
                let (along, down) = (projected.u[i] - 0.5 - left, projected.v[i] - 0.5 - top);
                let share_x = if corner & 1 == 1 { along } else { 1.0 - along };
                let share_y = if corner >> 1 == 1 { down } else { 1.0 - down };
                let tier = if share_x * share_y >= CORE_SHARE { CORE } else { 0 };
                let (pixel, inside) = self.pixel(left + right, top + below);
                let seen = inside & (projected.reciprocal[i] > 0.0) & (w[i] >= 0.0);
                pixels[i] = pixel;
                uppers[i] = if seen { nearness(w[i] * projected.reciprocal[i], tier) } else { 0 };
            }
            self.raise(&pixels, &uppers, slots);
        }
    }

    #[inline(always)]
    fn footprints(
        mut self,
        projector: &Projector,
        projected: &ProjectedRow,
        (w, slopes): (&[f32; TILE], &[[f32; TILE]; 2]),
        slots: u32,
    ) {
        let found = footprints(projector, projected, w, slopes);
        // First and last column and row whose centers the footprint covers: always one, at most two unless it is large.
        let mut edges = [[0.0_f32; TILE]; 4];
        let mut large = 0_u32;
        for i in 0..TILE {
            let (half_width, half_height) = (found.half_width[i].max(0.5), found.half_height[i].max(0.5));
            let seen = projected.reciprocal[i] > 0.0 && w[i] >= 0.0;
            edges[0][i] = (projected.u[i] - half_width - 0.5).ceil();
            edges[1][i] = (projected.u[i] + half_width - 0.5).floor();
            edges[2][i] = (projected.v[i] - half_height - 0.5).ceil();
            edges[3][i] = (projected.v[i] + half_height - 0.5).floor();
            let wide = edges[1][i] > edges[0][i] + 1.0 || edges[3][i] > edges[2][i] + 1.0;
            large |= u32::from(wide && seen) << i;
        }
        for corner in 0..4_usize {
            let (mut pixels, mut uppers) = ([0; TILE], [0; TILE]);
            let (columns, rows) = (&edges[corner & 1], &edges[2 + (corner >> 1)]);
            for i in 0..TILE {
                let (x, y) = (columns[i], rows[i]);
                let (pixel, inside) = self.pixel(x, y);
                let (depth, covered) = depth_at(&found, projected, i, x, y);
                let seen = inside & covered & (projected.reciprocal[i] > 0.0) & (w[i] >= 0.0);
                pixels[i] = pixel;
                uppers[i] = if seen { nearness(depth, CORE) } else { 0 };
            }
            self.raise(&pixels, &uppers, slots);
        }
        while large != 0 {
            let i = large.trailing_zeros() as usize;
            large &= large - 1;
            let clamp = |value: f32, low: usize, high: usize| value.clamp(low as f32, high as f32) as usize;
            let columns = clamp(edges[0][i], 0, self.width)..clamp(edges[1][i] + 1.0, 0, self.width);
            let (top, bottom) = (self.rows.start, self.rows.end);
            for y in clamp(edges[2][i], top, bottom)..clamp(edges[3][i] + 1.0, top, bottom) {
                for x in columns.clone() {
                    let (depth, covered) = depth_at(&found, projected, i, x as f32, y as f32);
                    if !covered {
                        continue;
                    }
                    let pixel = &mut self.keys[(y - top) * self.width + x];
                    *pixel = (*pixel).max(key(nearness(depth, CORE), slots | i as u32));
                }
            }
        }
    }
}

/// A whole number from 0 to 2²³ − 1. (A cast would be turned into sixteen scalar instructions, each with checks.)
#[inline(always)]
fn whole(number: f32) -> u32 {
    (number + 8_388_608.0).to_bits() & 0x7f_ffff
}

/// Inverse depth of a sample's plane at the center of pixel `(x, y)`, never negative.
#[inline(always)]
fn depth_at(found: &Footprints, projected: &ProjectedRow, i: usize, x: f32, y: f32) -> (f32, bool) {
    let (dx, dy) = (x + 0.5 - projected.u[i], y + 0.5 - projected.v[i]);
    let (across, down) = (
        found.inverse[0][i] * dx + found.inverse[1][i] * dy,
        found.inverse[2][i] * dx + found.inverse[3][i] * dy,
    );
    let covered = (across.abs().max(down.abs()) <= 0.5 * OVERLAP) | (dx.abs().max(dy.abs()) <= 0.5);
    // Not `clamp`, whose check for an empty range is a branch.
    let deviation =
        (found.slope_x[i] * dx + found.slope_y[i] * dy).min(found.deviation[i]).max(-found.deviation[i]);
    ((found.inverse_depth[i] + deviation).max(0.0), covered)
}
