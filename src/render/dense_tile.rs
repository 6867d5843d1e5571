//! A tile of samples laid out as the 16×16 pixels that it is, and the slope of its surface.

use super::frame_samples::FrameTile;
use crate::preprocess::{TILE, TILE_SAMPLES};

/// Marks a pixel without a sample.
pub(super) const MISSING: f32 = -1.0;

/// A surface is taken to go on from one pixel to the next where their inverse depths differ by no more than this many
/// pixel footprints along the ray: some 83 degrees of slant.
const EDGE_FOOTPRINTS: f32 = 8.0;

/// Inverse depths of a tile's pixels, row-major.
pub(super) struct DenseTile {
    pub(super) inverse_depth: [[f32; TILE]; TILE],
    packed: [f32; TILE_SAMPLES],
}

impl DenseTile {
    pub(super) fn new() -> Self {
        Self { inverse_depth: [[MISSING; TILE]; TILE], packed: [0.0; TILE_SAMPLES] }
    }

    /// Lays out a tile.
    #[inline(always)]
    pub(super) fn unpack(&mut self, tile: &FrameTile<'_>) {
        tile.depths.unpack(&mut self.packed);
        if tile.color.len() == TILE_SAMPLES {
            self.inverse_depth.as_flattened_mut().copy_from_slice(&self.packed);
            return;
        }
        let mut next = 0;
        for (row, &mask) in self.inverse_depth.iter_mut().zip(&tile.rows) {
            *row = [MISSING; TILE];
            let mut left = mask;
            while left != 0 {
                row[left.trailing_zeros() as usize] = self.packed[next & (TILE_SAMPLES - 1)];
                left &= left - 1;
                next += 1;
            }
        }
    }
}

/// Growth of the inverse depth from one column to the next and from one row to the next, at the pixels of a row: in each
/// direction the smaller of the differences to both neighbors that lie on the same surface, 0 where neither does.
#[inline(always)]
pub(super) fn slopes(tile: &DenseTile, row: usize, per_footprint: f32) -> [[f32; TILE]; 2] {
    let here = &tile.inverse_depth[row];
    let (above, below) = (&tile.inverse_depth[row.max(1) - 1], &tile.inverse_depth[(row + 1).min(TILE - 1)]);
    // Beyond the tile nothing is within the limit.
    let has_above = row > 0;
    let has_below = row + 1 < TILE;
    let (mut left, mut right) = ([MISSING; TILE], [MISSING; TILE]);
    left[1..].copy_from_slice(&here[..TILE - 1]);
    right[..TILE - 1].copy_from_slice(&here[1..]);
    let mut slopes = [[0.0; TILE]; 2];
    for column in 0..TILE {
        let w = here[column];
        let limit = EDGE_FOOTPRINTS * per_footprint * w;
        slopes[0][column] = gentler(w, left[column], right[column], [limit; 2]);
        slopes[1][column] = gentler(
            w,
            above[column],
            below[column],
            [if has_above { limit } else { -1.0 }, if has_below { limit } else { -1.0 }],
        );
    }
    slopes
}

/// The smaller of `w − before` and `after − w` of those within their limits.
#[inline(always)]
fn gentler(w: f32, before: f32, after: f32, limits: [f32; 2]) -> f32 {
    let (back, on) = (w - before, after - w);
    // Missing pixels are −1, farther from any inverse depth than every limit, save for absurdly near samples.
    let back_steepness = if back.abs() <= limits[0] && before >= 0.0 { back.abs() } else { f32::INFINITY };
    let on_steepness = if on.abs() <= limits[1] && after >= 0.0 { on.abs() } else { f32::INFINITY };
    let slope = if back_steepness <= on_steepness { back } else { on };
    if back_steepness.min(on_steepness) < f32::INFINITY { slope } else { 0.0 }
}
