//! A tile of samples as 16×16 pixels, and the slope of its surface.

use super::frame_tiles::FrameTile;
use super::relative_width::RelativeWidth;
use crate::samples::{TILE, TILE_SAMPLES};

/// Marks a pixel without a sample.
pub(crate) const MISSING: f32 = -1.0;

/// Neighboring pixels show the same surface if their inverse depths differ by at most this many pixel footprints along the ray:
/// some 83 degrees of slant.
const EDGE_FOOTPRINTS: f32 = 8.0;

/// Inverse depths of a tile's pixels, row-major, between two rows of missing ones.
pub(crate) struct DenseTile {
    rows: [[f32; TILE]; TILE + 2],
    packed: [f32; TILE_SAMPLES],
}

impl DenseTile {
    pub(crate) fn new() -> Self {
        Self { rows: [[MISSING; TILE]; TILE + 2], packed: [0.0; TILE_SAMPLES] }
    }

    /// The inverse depths of a row.
    #[inline(always)]
    pub(crate) fn row(&self, row: usize) -> &[f32; TILE] {
        &self.rows[row + 1]
    }

    /// The inverse depths of all pixels, row-major.
    #[inline(always)]
    pub(crate) fn pixels(&self) -> &[f32; TILE_SAMPLES] {
        self.rows.as_flattened()[TILE..].first_chunk().unwrap_or(&[MISSING; TILE_SAMPLES])
    }

    /// The inverse depths of all rows.
    #[inline(always)]
    pub(crate) fn rows(&self) -> &[[f32; TILE]] {
        &self.rows[1..=TILE]
    }

    /// Lays out a tile.
    #[inline(always)]
    pub(crate) fn unpack(&mut self, tile: &FrameTile<'_>) {
        let Some(pixels) = self.rows.as_flattened_mut()[TILE..].first_chunk_mut::<TILE_SAMPLES>() else {
            return;
        };
        if tile.color.len() == TILE_SAMPLES {
            tile.depths.unpack(pixels);
            return;
        }
        tile.depths.unpack(&mut self.packed);
        pixels.fill(MISSING);
        let mut next = 0;
        for (row, &mask) in pixels.as_chunks_mut::<TILE>().0.iter_mut().zip(&tile.rows) {
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
/// direction the smaller of the differences to both neighbors that are on the same surface, 0 where neither is.
#[inline(always)]
pub(crate) fn slopes(tile: &DenseTile, row: usize, per_footprint: RelativeWidth) -> [[f32; TILE]; 2] {
    let [above, here, below] = [&tile.rows[row], &tile.rows[row + 1], &tile.rows[row + 2]];
    let first = (row + 1) * TILE;
    let beside = &tile.rows.as_flattened()[first - 1..][..TILE + 2];
    let mut slopes = [[0.0; TILE]; 2];
    for column in 0..TILE {
        let w = here[column];
        let limit = EDGE_FOOTPRINTS * per_footprint.at(w) * w;
        // Beyond the tile nothing is known.
        let left = if column == 0 { MISSING } else { beside[column] };
        let right = if column == TILE - 1 { MISSING } else { beside[column + 2] };
        slopes[0][column] = gentler(w, left, right, limit);
        slopes[1][column] = gentler(w, above[column], below[column], limit);
    }
    slopes
}

/// For the pixels of a row, whether a neighbor in the tile shows another surface: such samples may be blended with it.
#[inline(always)]
pub(crate) fn beside_edges(tile: &DenseTile, row: usize, per_footprint: RelativeWidth) -> [bool; TILE] {
    let [above, here, below] = [&tile.rows[row], &tile.rows[row + 1], &tile.rows[row + 2]];
    let first = (row + 1) * TILE;
    let beside = &tile.rows.as_flattened()[first - 1..][..TILE + 2];
    let mut found = [false; TILE];
    for column in 0..TILE {
        let w = here[column];
        let limit = EDGE_FOOTPRINTS * per_footprint.at(w) * w;
        let left = if column == 0 { MISSING } else { beside[column] };
        let right = if column == TILE - 1 { MISSING } else { beside[column + 2] };
        let is_other = |neighbor: f32| (neighbor >= 0.0) & ((w - neighbor).abs() > limit);
        found[column] = is_other(left) | is_other(right) | is_other(above[column]) | is_other(below[column]);
    }
    found
}

/// The smaller of `w − before` and `after − w` of those within the limit.
#[inline(always)]
fn gentler(w: f32, before: f32, after: f32, limit: f32) -> f32 {
    let (back, on) = (w - before, after - w);
    let near_back = (back.abs() <= limit) & (before >= 0.0);
    let near_on = (on.abs() <= limit) & (after >= 0.0);
    let back_steepness = if near_back { back.abs() } else { f32::INFINITY };
    let on_steepness = if near_on { on.abs() } else { f32::INFINITY };
    let slope = if back_steepness <= on_steepness { back } else { on };
    if near_back | near_on { slope } else { 0.0 }
}
