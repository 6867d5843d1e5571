//! A cache of unpacked tiles for each camera.
//!
//! Neighboring points of the vantage are looked up in the same few tiles of a camera again and again. A tile is unpacked when it
//! is first read; sixteen points at a time then read their 2×2 samples from plain arrays.
//!
//! A cache holds 4×4 tiles: pixel `(x, y)` of a camera is stored at `(x mod 64, y mod 64)`, so that a tile replaces those that
//! lie a whole number of 64 pixels away.

use half::f16;

use super::dense_tile::MISSING;
use super::frame_tiles::{FrameTile, linear};
use super::tile_grid::Lookup;
use crate::samples::{TILE, TILE_SAMPLES};
use crate::simd::{LANES, joined};

/// One number for each point of those that are looked up together.
pub(crate) type LaneValues = [f32; LANES];

/// The color of a sample as it is interpolated: red, green and blue, linear, and a zero, for one vector.
pub(crate) type TexelColor = [f32; 4];

/// Tiles along each side of a cache.
const TILES: usize = 4;
const SIDE: usize = TILES * TILE;
const AREA: usize = SIDE * SIDE;

/// Marks a slot of a cache without a tile; larger than the cell of any camera.
const NO_CELL: u32 = u32::MAX;

/// The 2×2 samples around each point: left above, right above, left below, right below.
pub(crate) struct Quads {
    /// Inverse depths in the camera; [`MISSING`] where there is no sample.
    pub(crate) depth: [LaneValues; 4],
    /// Red, green and blue, linear, and a zero.
    pub(crate) color: [[TexelColor; LANES]; 4],
}

/// The cache of one camera.
#[derive(Debug)]
struct TileCache {
    depth: [f32; AREA],
    color: [TexelColor; AREA],
    /// The tile in each slot: `row + 1 << 16 | column + 1`.
    cells: [u32; TILES * TILES],
    /// The same for tiles whose colors are unpacked too.
    colored: [u32; TILES * TILES],
    /// Which slots hold no sample: many cameras kept none where others see better.
    vacant: [bool; TILES * TILES],
}

/// A cache for each camera that was read.
#[derive(Debug)]
pub(crate) struct TileCaches {
    cameras: Vec<Option<Box<TileCache>>>,
    packed: [f32; TILE_SAMPLES],
}

impl TileCaches {
    /// Empty caches for this many cameras.
    pub(crate) fn new(cameras: usize) -> Self {
        Self { cameras: std::iter::repeat_with(|| None).take(cameras).collect(), packed: [0.0; TILE_SAMPLES] }
    }

    /// The number of cameras that there may be caches of.
    pub(crate) fn camera_count(&self) -> usize {
        self.cameras.len()
    }

    /// Empties the caches.
    pub(crate) fn forget(&mut self) {
        for cache in self.cameras.iter_mut().flatten() {
            cache.cells.fill(NO_CELL);
            cache.colored.fill(NO_CELL);
        }
    }

    /// Prefetches the tile around a pixel of a camera, if it is not unpacked yet.
    #[inline(always)]
    pub(crate) fn prefetch(&self, lookup: &Lookup<'_>, camera: usize, (x, y): (i32, i32)) {
        let (column, row) = (x >> 4, y >> 4);
        let is_there = self.cameras[camera]
            .as_ref()
            .is_some_and(|cache| cache.cells[slot(column, row)] == cell(column, row));
        if !is_there {
            let mut at = lookup.first_at(camera, column, row);
            while let Some(number) = at {
                lookup.tile(number, &mut None).prefetch();
                at = lookup.next(number);
            }
        }
    }

    /// The samples of a camera at columns `x`, `x + 1` and rows `y`, `y + 1` for the points of a mask, whose corners `(x, y)` are −1
    /// or more; those of other points are undefined. Colors only if `COLORS`. `None` where the camera kept none of them.
    #[inline(always)]
    pub(crate) fn quads<const COLORS: bool>(
        &mut self,
        lookup: &Lookup<'_>,
        camera: usize,
        corners: &[[i32; LANES]; 2],
        which: u32,
    ) -> Option<Quads> {
        let Self { cameras, packed } = self;
        let cache = cameras[camera].get_or_insert_with(TileCache::new);
        let (near, corner, touched) = within(corners, which);
        let mut is_vacant = true;
        for row in touched[2]..=touched[3] {
            for column in touched[0]..=touched[1] {
                let (column, row) = (corner.0 + column, corner.1 + row);
                cache.unpack::<COLORS>(lookup, camera, (column, row), packed);
                is_vacant &= cache.vacant[slot(column, row)];
            }
        }
        if is_vacant && which & !near == 0 {
            return None;
        }
        let mut quads = cache.read::<COLORS>(corners);
        // Points too far from the first for the cache to hold both are looked up one by one: unpacking tiles for them would replace
        // those of their neighbors.
        let [x, y] = corners;
        let mut left = which & !near;
        while left != 0 {
            let i = left.trailing_zeros() as usize % LANES;
            left &= left - 1;
            for corner in 0..4 {
                let pixel = (x[i] + (corner as i32 & 1), y[i] + (corner as i32 >> 1));
                let (depth, color) = cache.sample::<COLORS>(lookup, camera, pixel);
                quads.depth[corner][i] = depth;
                quads.color[corner][i] = color;
            }
        }
        Some(quads)
    }
}

/// A stored color as a texel.
#[inline(always)]
fn texel(color: [f16; 3]) -> TexelColor {
    let [red, green, blue] = linear(color);
    [red, green, blue, 0.0]
}

/// Where a pixel of a camera is stored in its cache.
#[inline(always)]
fn pixel_at(x: i32, y: i32) -> usize {
    let (column, row) = (x as u32 % SIDE as u32, y as u32 % SIDE as u32);
    (row * SIDE as u32 + column) as usize % AREA
}

/// The slot of a cache for a tile of a camera.
#[inline(always)]
fn slot(column: i32, row: i32) -> usize {
    let (column, row) = (column & (TILES as i32 - 1), row & (TILES as i32 - 1));
    (row as usize * TILES + column as usize) % (TILES * TILES)
}

/// The column and row of a tile in one number.
#[inline(always)]
fn cell(column: i32, row: i32) -> u32 {
    ((row + 1) as u32) << 16 | (column + 1) as u32
}

/// The points of a mask whose 2×2 samples fit into the cache together with those of the first; the first column and row of these
/// 4×4 tiles; and from there, the first and last columns and rows of tiles that the points touch.
#[inline(always)]
fn within([x, y]: &[[i32; LANES]; 2], which: u32) -> (u32, (i32, i32), [i32; 4]) {
    let first = which.trailing_zeros() as usize % LANES;
    let corner = ((x[first] >> 4) - 1, (y[first] >> 4) - 1);
    let (mut near, mut touched) = ([0_u32; LANES], [[1; LANES]; 4]);
    for i in 0..LANES {
        let (left, right) = ((x[i] >> 4) - corner.0, ((x[i] + 1) >> 4) - corner.0);
        let (above, below) = ((y[i] >> 4) - corner.1, ((y[i] + 1) >> 4) - corner.1);
        let inside = (left >= 0) & (right < TILES as i32) & (above >= 0) & (below < TILES as i32);
        let is_near = inside & (which >> i & 1 == 1);
        near[i] = u32::from(is_near) << i;
        touched[0][i] = if is_near { left } else { 1 };
        touched[1][i] = if is_near { right } else { 1 };
        touched[2][i] = if is_near { above } else { 1 };
        touched[3][i] = if is_near { below } else { 1 };
    }
    let near = joined(&near);
    let mut ends = [1; 4];
    for i in 0..LANES {
        ends[0] = ends[0].min(touched[0][i]);
        ends[1] = ends[1].max(touched[1][i]);
        ends[2] = ends[2].min(touched[2][i]);
        ends[3] = ends[3].max(touched[3][i]);
    }
    (near, corner, ends)
}

impl TileCache {
    #[expect(
        clippy::large_stack_arrays,
        reason = "80 KiB on their way to the heap, once per camera and thread"
    )]
    fn new() -> Box<Self> {
        Box::new(Self {
            depth: [MISSING; AREA],
            color: [[0.0; 4]; AREA],
            cells: [NO_CELL; TILES * TILES],
            colored: [NO_CELL; TILES * TILES],
            vacant: [true; TILES * TILES],
        })
    }

    /// Unpacks a tile of the camera into its slot, if it is not there yet; tiles beside the picture are empty. Colors only if
    /// `COLORS`: votes need none.
    #[inline(always)]
    fn unpack<const COLORS: bool>(
        &mut self,
        lookup: &Lookup<'_>,
        camera: usize,
        (column, row): (i32, i32),
        packed: &mut [f32; TILE_SAMPLES],
    ) {
        let (slot, cell) = (slot(column, row), cell(column, row));
        let corner = (slot / TILES * SIDE + slot % TILES) * TILE;
        let mut at = None;
        let mut is_new = false;
        if self.cells[slot] != cell {
            (self.cells[slot], is_new) = (cell, true);
            at = lookup.first_at(camera, column, row);
            let is_full = match at {
                Some(number) => lookup.tile(number, &mut None).color.len() == TILE_SAMPLES,
                None => false,
            };
            if !is_full && !self.vacant[slot] {
                self.empty(corner);
            }
            self.vacant[slot] = at.is_none();
        }
        if COLORS && self.colored[slot] != cell {
            self.colored[slot] = cell;
            at = lookup.first_at(camera, column, row);
        }
        while let Some(number) = at {
            let mut made = None;
            let tile = lookup.tile(number, &mut made);
            if is_new {
                tile.depths.unpack(packed);
                self.unpack_tile::<true, COLORS>(tile, corner, packed);
            } else {
                self.unpack_tile::<false, true>(tile, corner, packed);
            }
            at = lookup.next(number);
        }
    }

    /// The sample of a camera at a pixel, from the cache if its tile is unpacked, else from the packed samples.
    #[inline(always)]
    fn sample<const COLORS: bool>(
        &self,
        lookup: &Lookup<'_>,
        camera: usize,
        (x, y): (i32, i32),
    ) -> (f32, TexelColor) {
        let (slot, cell) = (slot(x >> 4, y >> 4), cell(x >> 4, y >> 4));
        if self.cells[slot] == cell && (!COLORS || self.colored[slot] == cell) {
            let at = pixel_at(x, y);
            return (self.depth[at], self.color[at]);
        }
        let (column, row) = ((x & 15) as usize, (y & 15) as usize);
        let mut at = lookup.first_at(camera, x >> 4, y >> 4);
        while let Some(number) = at {
            let mut made = None;
            let tile = lookup.tile(number, &mut made);
            if tile.rows[row] >> column & 1 == 1 {
                let nth = tile.rank(column, row);
                let color = if COLORS { texel(tile.color[nth]) } else { [0.0; 4] };
                return (tile.depths.get(nth), color);
            }
            at = lookup.next(number);
        }
        (MISSING, [0.0; 4])
    }

    /// Empties the slot of a tile.
    #[inline(always)]
    fn empty(&mut self, corner: usize) {
        for row in 0..TILE {
            self.depth[corner + row * SIDE..][..TILE].fill(MISSING);
        }
    }

    /// Writes the depths of a tile, which are in `packed`, if `DEPTHS`, and its colors if `COLORS`.
    #[inline(always)]
    fn unpack_tile<const DEPTHS: bool, const COLORS: bool>(
        &mut self,
        tile: &FrameTile<'_>,
        corner: usize,
        packed: &[f32; TILE_SAMPLES],
    ) {
        let (mut depths, mut colors) = (packed.as_slice(), tile.color);
        for (row, &mask) in tile.rows.iter().enumerate() {
            let at = corner + row * SIDE;
            let count = mask.count_ones() as usize;
            let (row_depths, rest_of_depths) = depths.split_at(count);
            let (row_colors, rest_of_colors) = colors.split_at(count);
            (depths, colors) = (rest_of_depths, rest_of_colors);
            let (to_depths, to_colors) = (&mut self.depth[at..][..TILE], &mut self.color[at..][..TILE]);
            if mask == u16::MAX {
                if DEPTHS {
                    to_depths.copy_from_slice(row_depths);
                }
                if COLORS {
                    for (to, color) in to_colors.iter_mut().zip(row_colors) {
                        *to = texel(*color);
                    }
                }
                continue;
            }
            let mut left = mask;
            for (depth, color) in row_depths.iter().zip(row_colors) {
                let column = left.trailing_zeros() as usize % TILE;
                left &= left.wrapping_sub(1);
                if DEPTHS {
                    to_depths[column] = *depth;
                }
                if COLORS {
                    to_colors[column] = texel(*color);
                }
            }
        }
    }

    /// Reads the 2×2 samples of all points; those of points that are not in the cache are undefined.
    #[inline(always)]
    fn read<const COLORS: bool>(&self, corners: &[[i32; LANES]; 2]) -> Quads {
        // One corner after the other, not in a loop, which would be compiled to reading and scattering the four corners of each
        // point.
        let (depth_a, color_a) = self.read_corner::<COLORS>(corners, (0, 0));
        let (depth_b, color_b) = self.read_corner::<COLORS>(corners, (1, 0));
        let (depth_c, color_c) = self.read_corner::<COLORS>(corners, (0, 1));
        let (depth_d, color_d) = self.read_corner::<COLORS>(corners, (1, 1));
        Quads { depth: [depth_a, depth_b, depth_c, depth_d], color: [color_a, color_b, color_c, color_d] }
    }

    /// Reads the samples `right` and `below` of the corners of all points.
    #[inline(always)]
    fn read_corner<const COLORS: bool>(
        &self,
        [x, y]: &[[i32; LANES]; 2],
        (right, below): (i32, i32),
    ) -> (LaneValues, [TexelColor; LANES]) {
        let (mut at, mut depth, mut color) = ([0_u32; LANES], [0.0; LANES], [[0.0; 4]; LANES]);
        for i in 0..LANES {
            at[i] = pixel_at(x[i] + right, y[i] + below) as u32;
        }
        for i in 0..LANES {
            depth[i] = self.depth[at[i] as usize % AREA];
        }
        if COLORS {
            for i in 0..LANES {
                color[i] = self.color[at[i] as usize % AREA];
            }
        }
        (depth, color)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::demo::DemoSpec;
    use crate::render::input::frame_tiles::FrameSamples;
    use crate::render::input::tile_grid::CellTable;
    use crate::render::tests::scene;

    #[test]
    fn points_far_apart_read_what_each_of_them_reads_alone() {
        let (samples, _) = scene(DemoSpec::new("orrery").cameras(2).size((160, 120)), 1);
        let frame = FrameSamples::at(&samples, 1).unwrap();
        let table = CellTable::empty(&samples.cameras).with(&frame, 0..frame.tile_count());
        let lookup = Lookup { table, frame: &frame };
        let corners: [[i32; LANES]; 2] = [(53, 161), (37, 121)]
            .map(|(step, count)| std::array::from_fn(|i| (i as i32 * step) % count - 1));
        let together = TileCaches::new(2).quads::<true>(&lookup, 0, &corners, 0xffff).unwrap();
        let mut found = 0;
        for i in 0..LANES {
            let alone = TileCaches::new(2).quads::<true>(&lookup, 0, &corners, 1 << i);
            let Some(alone) = alone else { continue };
            for corner in 0..4 {
                let depth = alone.depth[corner][i];
                assert_eq!(together.depth[corner][i], depth, "point {i}, corner {corner}");
                if depth >= 0.0 {
                    found += 1;
                    assert_eq!(
                        together.color[corner][i], alone.color[corner][i],
                        "point {i}, corner {corner}"
                    );
                }
            }
        }
        assert!(found > 16, "{found}");
    }
}
