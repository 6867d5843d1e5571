//! The samples of a tile, sixteen at a time.
//!
//! ```text
//!     row 0   ■■■■■■■■■■■■■■■■     one group as it is
//!     row 1   ■■····■···■■····  ┐
//!     row 2   ·····■■■■■······  ├  packed: one group
//!     row 3   ·■■■············  ┘
//! ```
//!
//! Purpose: pruning leaves a third to four fifths of the samples in the rows that hold any, and vectors cost the same whether they are full or
//! not.

use super::zkey::{TRUSTED, key, nearness};
use crate::render::geometry::{CORE_REACH, FRINGE, ProjectedPixels, Projector};
use crate::render::input::{DenseTile, FrameTile, MISSING, RelativeWidth, slopes};
use crate::samples::{TILE, TILE_SAMPLES};

/// A tile whose samples are to be painted.
pub(super) struct PackedTile {
    dense: DenseTile,
    /// Growth of inverse depths by column and by row, at each pixel.
    slopes: [[[f32; TILE]; TILE]; 2],
    /// Of the first pixel of each row: `x`, `y` and `z`.
    rays: [[f32; TILE]; 3],
    /// Rows with a sample in every pixel.
    full: [u8; TILE],
    full_count: usize,
    /// Positions in the tile of the samples of other rows.
    packed: [u8; TILE_SAMPLES],
    packed_count: usize,
}

/// Sixteen samples of a tile, or fewer at its end.
pub(super) struct TileSamples<'a> {
    pub(super) projector: &'a Projector,
    /// Where the tile holds samples: a mask of columns per row.
    rows: &'a [u16; TILE],
    /// Positions in the tile: 16 times the row, and the column.
    pub(super) at: [u32; TILE],
    /// Inverse depths; [`MISSING`] beyond the last sample.
    pub(super) w: [f32; TILE],
    /// Growth of the inverse depth by column and by row.
    pub(super) slopes: [[f32; TILE]; 2],
    pub(super) projected: ProjectedPixels,
    /// [`TRUSTED`] per sample, 0 where it is doubtful.
    pub(super) trust: [u32; TILE],
}

impl PackedTile {
    pub(super) fn new() -> Self {
        Self {
            dense: DenseTile::new(),
            slopes: [[[0.0; TILE]; TILE]; 2],
            rays: [[0.0; TILE]; 3],
            full: [0; TILE],
            full_count: 0,
            packed: [0; TILE_SAMPLES],
            packed_count: 0,
        }
    }

    /// Lays out a tile that `projector` carries into the target. Slopes stay those of an earlier tile without the size of its footprints.
    #[inline(always)]
    pub(super) fn set(
        &mut self,
        tile: &FrameTile<'_>,
        projector: &Projector,
        per_footprint: Option<RelativeWidth>,
    ) {
        self.dense.unpack(tile);
        (self.full_count, self.packed_count) = (0, 0);
        for (row, &mask) in tile.rows.iter().enumerate() {
            if mask == 0 {
                continue;
            }
            let ray = projector.ray(tile.origin.0 as f32, (tile.origin.1 as usize + row) as f32);
            (self.rays[0][row], self.rays[1][row], self.rays[2][row]) = (ray.x, ray.y, ray.z);
            if let Some(per_footprint) = per_footprint {
                [self.slopes[0][row], self.slopes[1][row]] = slopes(&self.dense, row, per_footprint);
            }
            if mask == u16::MAX {
                self.full[self.full_count % TILE] = row as u8;
                self.full_count += 1;
                continue;
            }
            let mut left = mask;
            while left != 0 {
                self.packed[self.packed_count % TILE_SAMPLES] =
                    (row * TILE) as u8 + left.trailing_zeros() as u8;
                self.packed_count += 1;
                left &= left - 1;
            }
        }
    }

    /// How many groups of samples there are: sixteen at most.
    pub(super) fn group_count(&self) -> usize {
        self.full_count + self.packed_count.div_ceil(TILE)
    }

    /// A group of the tile that was laid out.
    #[inline(always)]
    pub(super) fn group<'a>(
        &self,
        nth: usize,
        tile: &'a FrameTile<'_>,
        projector: &'a Projector,
    ) -> TileSamples<'a> {
        let (mut at, mut w) = ([0; TILE], [0.0; TILE]);
        let (mut slopes, mut rays, mut columns) = ([[0.0; TILE]; 2], [[0.0; TILE]; 3], [0.0; TILE]);
        if nth < self.full_count {
            let row = self.full[nth % TILE] as usize % TILE;
            for i in 0..TILE {
                (at[i], columns[i]) = ((row * TILE + i) as u32, i as f32);
            }
            w = *self.dense.row(row);
            slopes = [self.slopes[0][row], self.slopes[1][row]];
            rays = [[self.rays[0][row]; TILE], [self.rays[1][row]; TILE], [self.rays[2][row]; TILE]];
        } else {
            let first = (nth - self.full_count) * TILE % TILE_SAMPLES;
            let wanted = (self.packed_count - first).min(TILE);
            let depths = self.dense.pixels();
            for i in 0..TILE {
                at[i] = u32::from(self.packed[(first + i) % TILE_SAMPLES]);
            }
            for i in 0..TILE {
                let (place, row) = (at[i] as usize % TILE_SAMPLES, at[i] as usize / TILE % TILE);
                w[i] = if i < wanted { depths[place] } else { MISSING };
                slopes[0][i] = self.slopes[0].as_flattened()[place];
                slopes[1][i] = self.slopes[1].as_flattened()[place];
                rays[0][i] = self.rays[0][row];
                rays[1][i] = self.rays[1][row];
                rays[2][i] = self.rays[2][row];
                columns[i] = (at[i] % TILE as u32) as f32;
            }
        }
        let mut trust = [TRUSTED; TILE];
        if let Some(doubtful) = tile.doubtful {
            for i in 0..TILE {
                let columns = doubtful[at[i] as usize / TILE % TILE];
                trust[i] = if columns >> (at[i] % TILE as u32) & 1 == 1 { 0 } else { TRUSTED };
            }
        }
        let projected = projector.pixels(&rays, &columns, &w);
        TileSamples { projector, rows: &tile.rows, at, w, slopes, projected, trust }
    }
}

impl TileSamples<'_> {
    /// The key of sample `i` at its own depth; 0 if it is not in the band or not visible. `slots` is the slot of the tile's first pixel.
    #[inline(always)]
    pub(super) fn key(&self, i: usize, tier: u32, slots: u32, inside: bool) -> u64 {
        let (w, reciprocal) = (self.w[i], self.projected.reciprocal[i]);
        let seen = inside & (reciprocal > 0.0) & (w >= 0.0);
        let full = key(nearness(w * reciprocal, tier | self.trust[i]), slots | self.at[i]);
        if seen { full } else { 0 }
    }

    /// How far the footprint of sample `i` reaches with its fringe, in source pixels: to the left, right, up and down. Toward samples
    /// of the same tile, which have footprints of their own, there is no fringe.
    #[inline(always)]
    pub(super) fn reach(&self, i: usize) -> [f32; 4] {
        let (nth, i) = (self.at[i] as usize / TILE, self.at[i] as usize % TILE);
        let row = |nth: usize| u32::from(*self.rows.get(nth).unwrap_or(&0)) << 1;
        let (above, here, below) = (row(nth.wrapping_sub(1)), row(nth), row(nth + 1));
        [here >> i, here >> (i + 2), above >> (i + 1), below >> (i + 1)]
            .map(|closed| if closed & 1 == 1 { CORE_REACH } else { FRINGE })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::demo::DemoSpec;
    use crate::render::input::FrameSamples;
    use crate::render::tests::scene;

    #[test]
    fn every_sample_of_a_tile_is_in_one_group_and_is_carried_as_in_its_row() {
        let (samples, target) = scene(DemoSpec::new("orrery").cameras(3).size((120, 90)), 1);
        let frame = FrameSamples::at(&samples, 1).unwrap();
        let (mut packed, mut partial) = (PackedTile::new(), 0);
        for tile in frame.tiles(0..frame.tile_count()) {
            let source = &samples.cameras[tile.camera as usize];
            let projector = Projector::new(source, &target.camera);
            let per_footprint = RelativeWidth::of(1.0, source);
            packed.set(tile, &projector, Some(per_footprint));
            let mut dense = DenseTile::new();
            dense.unpack(tile);
            let mut found = [0_u16; TILE];
            for nth in 0..packed.group_count() {
                let group = packed.group(nth, tile, &projector);
                for i in (0..TILE).filter(|i| group.w[*i] >= 0.0) {
                    let (row, column) = (group.at[i] as usize / TILE, group.at[i] as usize % TILE);
                    assert_eq!(found[row] >> column & 1, 0, "once");
                    found[row] |= 1 << column;
                    let y = (tile.origin.1 as usize + row) as f32;
                    let alone = projector.row(projector.ray(tile.origin.0 as f32, y), dense.row(row));
                    let slopes = slopes(&dense, row, per_footprint);
                    assert_eq!(group.w[i], dense.row(row)[column]);
                    assert_eq!(group.projected.u[i].to_bits(), alone.u[column].to_bits());
                    assert_eq!(group.projected.v[i].to_bits(), alone.v[column].to_bits());
                    assert_eq!(group.projected.reciprocal[i].to_bits(), alone.reciprocal[column].to_bits());
                    assert_eq!([group.slopes[0][i], group.slopes[1][i]], slopes.map(|along| along[column]));
                }
            }
            assert_eq!(found, tile.rows);
            partial += usize::from(packed.packed_count > 0);
        }
        assert!(partial > 20, "{partial}");
    }
}
