//! The inverse depths of a sample image in three bytes each, bit for bit.
//!
//! The depths of one tile are close together, and positive floats order like integers: what is kept is the distance from
//! the tile's smallest depth, counted in representable floats. Three bytes hold 2²⁴ of them, two octaves of depth; tiles that
//! span more (a silhouette before the sky, whose inverse depth is 0) keep a fourth byte.
//!
//! ```text
//! low    one u16 per sample
//! high   one u8 per sample of a narrow tile; two (low byte first) per sample of a wide tile
//! tiles  farthest: bits of the tile's smallest inverse depth      distance = low | high << 16
//!        nearest:  bits of its largest                            bits     = farthest + distance
//!        first_high: where its bytes of `high` begin; the tile is wide where nearest − farthest ≥ 2²⁴
//! ```

use super::tile::{SampleTile, TILE};

/// Samples a tile has at most.
pub const TILE_SAMPLES: usize = TILE * TILE;

/// Distances from this on need a fourth byte.
const WIDE: u32 = 1 << 24;

/// Depths of one tile: where they lie, and between which bounds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct DepthTile {
    /// Bits of the smallest inverse depth.
    pub farthest: u32,
    /// Bits of the largest inverse depth.
    pub nearest: u32,
    /// Index of the tile's first byte in the high plane.
    pub first_high: u32,
}

impl DepthTile {
    /// Whether samples of this tile have two high bytes.
    #[inline(always)]
    pub(crate) fn is_wide(self) -> bool {
        self.nearest - self.farthest >= WIDE
    }
}

/// The inverse depths of one tile's samples, where they lie.
#[derive(Clone, Copy, Debug)]
pub struct TileDepths<'a> {
    place: DepthTile,
    low: &'a [u16],
    high: &'a [u8],
}

impl TileDepths<'_> {
    /// Smallest and largest inverse depth.
    pub(crate) fn bounds(&self) -> (f32, f32) {
        (f32::from_bits(self.place.farthest), f32::from_bits(self.place.nearest))
    }

    /// The planes that it is read from, see the module's page: low halves and high bytes.
    #[inline(always)]
    pub(crate) fn planes(&self) -> (&[u16], &[u8]) {
        (self.low, self.high)
    }

    /// The inverse depth of a sample, from 0.
    #[inline(always)]
    #[must_use]
    pub fn get(&self, nth: usize) -> f32 {
        let high = if self.place.is_wide() {
            u32::from(self.high[2 * nth]) | u32::from(self.high[2 * nth + 1]) << 8
        } else {
            u32::from(self.high[nth])
        };
        f32::from_bits(self.place.farthest + (u32::from(self.low[nth]) | high << 16))
    }

    /// The inverse depths of all samples, in their order, into the front of `depths`; the rest of it is left as it is.
    #[inline(always)]
    pub(crate) fn unpack(&self, depths: &mut [f32; TILE_SAMPLES]) {
        let farthest = self.place.farthest;
        if self.place.is_wide() {
            let (high, _) = self.high.as_chunks::<2>();
            for ((depth, &low), high) in depths.iter_mut().zip(self.low).zip(high) {
                let high = u32::from(u16::from_le_bytes(*high));
                *depth = f32::from_bits(farthest + (u32::from(low) | high << 16));
            }
        } else {
            for ((depth, &low), &high) in depths.iter_mut().zip(self.low).zip(self.high) {
                *depth = f32::from_bits(farthest + (u32::from(low) | u32::from(high) << 16));
            }
        }
    }
}

/// Inverse depths of a [`super::sample_set::SampleImage`]; see the module's page.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct DepthPlane {
    tiles: Vec<DepthTile>,
    low: Vec<u16>,
    high: Vec<u8>,
}

impl DepthPlane {
    /// Packs one inverse depth per sample, in the order of the samples of `tiles`. Every bit pattern survives; what is
    /// left over because the numbers do not match the tiles is cut off.
    #[must_use]
    pub fn pack(tiles: &[SampleTile], inverse_depth: &[f32]) -> Self {
        let mut plane = Self::default();
        plane.low.reserve_exact(inverse_depth.len());
        let mut rest = inverse_depth;
        for tile in tiles {
            let (depths, after) = rest.split_at(tile.count().min(rest.len()));
            rest = after;
            plane.push_tile(depths);
        }
        plane.high.shrink_to_fit();
        plane
    }

    /// Appends the depths of a tile's samples, in their order.
    pub(crate) fn push_tile(&mut self, depths: &[f32]) {
        let bits = || depths.iter().map(|depth| depth.to_bits());
        let farthest = bits().min().unwrap_or(0);
        let tile =
            DepthTile { farthest, nearest: bits().max().unwrap_or(0), first_high: self.high.len() as u32 };
        self.low.extend(bits().map(|bits| (bits - farthest) as u16));
        if tile.is_wide() {
            self.high.extend(bits().flat_map(|bits| (((bits - farthest) >> 16) as u16).to_le_bytes()));
        } else {
            self.high.extend(bits().map(|bits| ((bits - farthest) >> 16) as u8));
        }
        self.tiles.push(tile);
    }

    /// Appends a tile as another plane has it.
    pub(crate) fn push_packed(&mut self, tile: &TileDepths<'_>) {
        self.tiles.push(DepthTile { first_high: self.high.len() as u32, ..tile.place });
        self.low.extend_from_slice(tile.low);
        self.high.extend_from_slice(tile.high);
    }

    /// Planes as [`DepthPlane::tiles`], [`DepthPlane::low`] and [`DepthPlane::high`] gave them.
    pub(crate) fn of_planes(tiles: Vec<DepthTile>, low: Vec<u16>, high: Vec<u8>) -> Self {
        Self { tiles, low, high }
    }

    /// A plane with room for the given numbers of tiles and depths.
    pub(crate) fn with_capacity(tiles: usize, depths: usize) -> Self {
        Self {
            tiles: Vec::with_capacity(tiles),
            low: Vec::with_capacity(depths),
            high: Vec::with_capacity(depths),
        }
    }

    /// Depths in the plane.
    #[must_use]
    pub fn len(&self) -> usize {
        self.low.len()
    }

    /// Whether it is empty.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.low.is_empty()
    }

    /// Where the depths of each tile lie, in the order of the tiles of the image.
    #[must_use]
    pub fn tiles(&self) -> &[DepthTile] {
        &self.tiles
    }

    /// Low halves, one per sample; see the module's page.
    #[must_use]
    pub fn low(&self) -> &[u16] {
        &self.low
    }

    /// High bytes; see the module's page.
    #[must_use]
    pub fn high(&self) -> &[u8] {
        &self.high
    }

    /// The depths of tile `tile`, whose first sample is `first` and which has `count`.
    #[must_use]
    pub fn tile(&self, tile: usize, first: u32, count: usize) -> TileDepths<'_> {
        let place = self.tiles[tile];
        let (first, first_high) = (first as usize, place.first_high as usize);
        TileDepths {
            place,
            low: &self.low[first..first + count],
            high: &self.high[first_high..first_high + (count << usize::from(place.is_wide()))],
        }
    }

    /// Every inverse depth, in the order of the samples of `tiles`.
    pub(crate) fn unpack(&self, tiles: &[SampleTile]) -> Vec<f32> {
        let mut all = Vec::with_capacity(self.len());
        let mut depths = [0.0; TILE_SAMPLES];
        let mut first = 0;
        for (index, tile) in tiles.iter().enumerate().take(self.tiles.len()) {
            let count = tile.count().min(self.len() - first);
            self.tile(index, first as u32, count).unpack(&mut depths);
            all.extend_from_slice(&depths[..count]);
            first += count;
        }
        all
    }

    /// Whether the plane holds one depth for every sample of `tiles`, and nothing else.
    pub(crate) fn fits(&self, tiles: &[SampleTile]) -> bool {
        let mut high = 0;
        let tiles_fit = self.tiles.len() == tiles.len()
            && self.tiles.iter().zip(tiles).all(|(place, tile)| {
                let begins_here = place.first_high as usize == high && place.farthest <= place.nearest;
                high += tile.count() << usize::from(place.is_wide());
                begins_here
            });
        tiles_fit
            && high == self.high.len()
            && self.low.len() == tiles.iter().map(SampleTile::count).sum::<usize>()
    }

    /// Bytes the plane occupies in memory.
    #[must_use]
    pub fn bytes(&self) -> usize {
        size_of_val(self.tiles.as_slice())
            + size_of_val(self.low.as_slice())
            + size_of_val(self.high.as_slice())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn tiles_of(counts: &[usize]) -> Vec<SampleTile> {
        let mut first = 0;
        let tiles = counts.iter().enumerate().map(|(place, &count)| {
            let mut rows = [0_u16; TILE];
            (0..count).for_each(|nth| rows[nth / TILE] |= 1 << (nth % TILE));
            let tile = SampleTile { tile_x: place as u16, tile_y: 0, first, rows };
            first += count as u32;
            tile
        });
        tiles.collect()
    }

    proptest! {
        #[test]
        fn every_bit_of_every_depth_comes_back(
            counts in prop::collection::vec(1_usize..=TILE_SAMPLES, 1..6),
            seed in any::<u64>(),
            spread in 0_u32..32,
        ) {
            let tiles = tiles_of(&counts);
            let mut state = seed | 1;
            let depths: Vec<f32> = (0..counts.iter().sum())
                .map(|_| {
                    state ^= state << 13;
                    state ^= state >> 7;
                    state ^= state << 17;
                    f32::from_bits(0x3c00_0000 ^ ((state >> 32) as u32 >> spread))
                })
                .collect();
            let plane = DepthPlane::pack(&tiles, &depths);
            let bits = |values: &[f32]| values.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
            prop_assert_eq!(bits(&plane.unpack(&tiles)), bits(&depths));
            for (index, tile) in tiles.iter().enumerate() {
                let (far, near) = (plane.tiles()[index].farthest, plane.tiles()[index].nearest);
                let found = plane.tile(index, tile.first, tile.count());
                for nth in 0..tile.count() {
                    let depth = found.get(nth).to_bits();
                    prop_assert_eq!(depth, depths[tile.first as usize + nth].to_bits());
                    prop_assert!((far..=near).contains(&depth));
                }
            }
        }
    }

    #[test]
    fn a_tile_of_one_surface_takes_three_bytes_a_sample_and_one_with_sky_four() {
        let tiles = tiles_of(&[256, 256]);
        let mut depths: Vec<f32> = (0..512).map(|i| 1.0 / (3.0 + 0.001 * i as f32)).collect();
        let records = 2 * size_of::<DepthTile>();
        assert_eq!(DepthPlane::pack(&tiles, &depths).bytes(), 3 * 512 + records);
        depths[300] = 0.0;
        assert_eq!(DepthPlane::pack(&tiles, &depths).bytes(), 3 * 256 + 4 * 256 + records);
    }
}
