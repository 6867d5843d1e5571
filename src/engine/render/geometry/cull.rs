//! Culling: which tiles of samples can touch which rows of the vantage.
//!
//! A tile and the bounds of its depths make a box, `(column, row, inverse depth)`, whose projection is between those of its
//! eight corners if all of them are in front of the vantage. The picture is cut into bands of rows, each with a list of the
//! tiles that may touch it, in the order of the samples. One thread paints each band: threads share no cache line, no buffer is
//! merged, and sums run in the order of the samples for any number of threads.

use std::ops::Range;

use rayon::prelude::*;

use super::project::Projector;
use crate::capture::Camera;
use crate::render::input::{FrameSamples, FrameTile};
use crate::samples::TILE;
use crate::simd::{self, LANES, VectorLoop};

/// Pixels `[left, right) × [top, bottom)` of the target that a tile may touch, clipped to the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct TileBounds {
    pub(crate) left: u32,
    pub(crate) right: u32,
    pub(crate) top: u32,
    pub(crate) bottom: u32,
}

impl TileBounds {
    /// Whether it contains no pixel.
    pub(crate) fn is_empty(self) -> bool {
        self.left >= self.right || self.top >= self.bottom
    }
}

/// Rows of the picture and the tiles that may touch them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct RowBand {
    pub(crate) rows: Range<usize>,
    /// Numbers of tiles in [`FrameSamples`], ascending.
    pub(crate) tiles: Vec<u32>,
}

/// How far from the projected pixel of a sample its footprint reaches.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FootprintReach {
    /// In target pixels.
    pub(crate) pixels: f32,
    /// Added to it, in projected source pixels.
    pub(crate) source_pixels: f32,
}

/// The pixels of the target that each tile may touch; empty if none.
pub(crate) fn bounds(
    frame: &FrameSamples<'_>,
    tiles: Range<usize>,
    projectors: &[Projector],
    target: &Camera,
    reach: FootprintReach,
) -> Vec<TileBounds> {
    let tiles = frame.tiles(tiles);
    let mut bounds = vec![TileBounds::default(); tiles.len()];
    let parts = bounds.par_chunks_mut(64 * LANES).zip(tiles.par_chunks(64 * LANES));
    parts.for_each(|(bounds, tiles)| simd::run(BoundTiles { tiles, projectors, target, reach, bounds }));
    bounds
}

struct BoundTiles<'a> {
    tiles: &'a [FrameTile<'a>],
    projectors: &'a [Projector],
    target: &'a Camera,
    reach: FootprintReach,
    bounds: &'a mut [TileBounds],
}

impl VectorLoop for BoundTiles<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for (tiles, bounds) in self.tiles.chunks(LANES).zip(self.bounds.chunks_mut(LANES)) {
            let boxes = TileBoxes::of(tiles, self.projectors);
            boxes.bounds(self.target, self.reach, bounds);
            for (tile, bounds) in tiles.iter().zip(bounds) {
                let projector = &self.projectors[tile.camera as usize];
                if projector.has_orthographic() {
                    *bounds = bounds_of_orthographic(tile, projector, self.target, self.reach);
                }
            }
        }
    }
}

/// The bounds of a tile where one of the cameras is orthographic: what is no straight box then has the same corners.
#[cold]
#[inline(never)]
fn bounds_of_orthographic(
    tile: &FrameTile<'_>,
    projector: &Projector,
    target: &Camera,
    reach: FootprintReach,
) -> TileBounds {
    let (far, near) = tile.depths.bounds();
    let [left, top] = [tile.origin.0, tile.origin.1].map(|first| first as f32 - 0.5);
    let (mut min, mut max) = ([f32::INFINITY; 2], [f32::NEG_INFINITY; 2]);
    let (mut behind, mut largest, mut is_sound) = (0, 0.0_f32, true);
    for corner in 0..8_usize {
        let [x, y, share] = [0, 1, 2].map(|edge| (corner >> edge & 1) as f32);
        let w = far + (near - far) * share;
        let point = projector.point_of_any(left + x * TILE as f32, top + y * TILE as f32, w);
        let position = projector.position(point, w);
        behind += usize::from(point.z <= 0.0);
        is_sound &= point.z > 0.0 && position.iter().all(|position| position.abs() < f32::MAX);
        largest = largest.max(projector.magnification(w, point.z.recip()));
        for axis in 0..2 {
            (min[axis], max[axis]) = (min[axis].min(position[axis]), max[axis].max(position[axis]));
        }
    }
    if behind == 8 {
        return TileBounds::default();
    }
    let size = [target.intrinsics.width as f32, target.intrinsics.height as f32];
    let grow = reach.pixels + reach.source_pixels * largest;
    let [[left, right], [top, bottom]] = [0, 1].map(|axis| {
        let ends = if is_sound { [min[axis] - grow, max[axis] + grow + 2.0] } else { [0.0, size[axis]] };
        ends.map(|end| end.clamp(0.0, size[axis]) as u32)
    });
    TileBounds { left, right, top, bottom }
}

/// Boxes of `(column, row, inverse depth)` in the target before the division, one per lane.
struct TileBoxes {
    /// The first corner.
    corner: [[f32; LANES]; 3],
    /// The edges along columns, rows and inverse depths.
    edges: [[[f32; LANES]; 3]; 3],
    focal_ratio: [f32; LANES],
}

impl TileBoxes {
    #[inline(always)]
    fn of(tiles: &[FrameTile<'_>], projectors: &[Projector]) -> Self {
        let zero = [[0.0; LANES]; 3];
        let mut boxes = Self { corner: zero, edges: [zero; 3], focal_ratio: [0.0; LANES] };
        for (lane, tile) in tiles.iter().enumerate() {
            let projector = &projectors[tile.camera as usize];
            let (far, near) = tile.depths.bounds();
            let first = projector.ray(tile.origin.0 as f32 - 0.5, tile.origin.1 as f32 - 0.5);
            let vectors = [
                first + projector.origin * far,
                projector.per_column * TILE as f32,
                projector.per_row * TILE as f32,
                projector.origin * (near - far),
            ];
            for axis in 0..3 {
                boxes.corner[axis][lane] = vectors[0][axis];
                (0..3).for_each(|edge| boxes.edges[edge][axis][lane] = vectors[edge + 1][axis]);
            }
            boxes.focal_ratio[lane] = projector.focal_ratio;
        }
        boxes
    }

    #[inline(always)]
    fn bounds(&self, target: &Camera, reach: FootprintReach, bounds: &mut [TileBounds]) {
        let all = |value: f32| [value; LANES];
        let (mut min, mut max) = ([all(f32::INFINITY); 2], [all(f32::NEG_INFINITY); 2]);
        let (mut nearest_z, mut behind) = (all(f32::INFINITY), [0_u32; LANES]);
        for corner in 0..8_usize {
            let share = [0, 1, 2].map(|edge| (corner >> edge & 1) as f32);
            for lane in 0..LANES {
                let point = [0, 1, 2].map(|axis| {
                    let along = |edge: usize| self.edges[edge][axis][lane] * share[edge];
                    self.corner[axis][lane] + along(0) + along(1) + along(2)
                });
                nearest_z[lane] = nearest_z[lane].min(point[2]);
                behind[lane] += u32::from(point[2] <= 0.0);
                let reciprocal = 1.0 / point[2];
                for axis in 0..2 {
                    min[axis][lane] = min[axis][lane].min(point[axis] * reciprocal);
                    max[axis][lane] = max[axis][lane].max(point[axis] * reciprocal);
                }
            }
        }
        let size = [target.intrinsics.width as f32, target.intrinsics.height as f32];
        let (mut low, mut high) = ([all(0.0); 2], [all(0.0); 2]);
        for axis in 0..2 {
            for lane in 0..LANES {
                let grow = reach.pixels + reach.source_pixels * self.focal_ratio[lane] / nearest_z[lane];
                // A box that reaches behind the vantage, or has NaN corners, may touch everything.
                let sound = (behind[lane] == 0)
                    & (min[axis][lane].abs() < f32::MAX)
                    & (max[axis][lane].abs() < f32::MAX);
                let (first, last) = (min[axis][lane] - grow, max[axis][lane] + grow + 2.0);
                let first = if sound { first } else { 0.0 };
                let last = if sound { last } else { size[axis] };
                low[axis][lane] = first.max(0.0).min(size[axis]);
                high[axis][lane] = last.max(0.0).min(size[axis]);
            }
        }
        for (lane, bounds) in bounds.iter_mut().enumerate() {
            if behind[lane] < 8 {
                *bounds = TileBounds {
                    left: low[0][lane] as u32,
                    right: high[0][lane] as u32,
                    top: low[1][lane] as u32,
                    bottom: high[1][lane] as u32,
                };
            }
        }
    }
}

/// What it takes to lay out a tile, in samples painted.
const SAMPLES_A_TILE: usize = 32;

/// Cuts the picture into at most `count` bands that take about as long to paint. `bounds` are those of the tiles from `first_tile` on.
pub(crate) fn bands(
    frame: &FrameSamples<'_>,
    bounds: &[TileBounds],
    first_tile: usize,
    height: usize,
    count: usize,
) -> Vec<RowBand> {
    let mut middles = vec![0_usize; height];
    for (nth, tile) in bounds.iter().enumerate().filter(|(_, tile)| !tile.is_empty()) {
        let samples = frame.tile(first_tile + nth).color.len();
        middles[(tile.top + tile.bottom) as usize / 2] += samples + SAMPLES_A_TILE;
    }
    let total: usize = middles.iter().sum();
    let mut bands: Vec<RowBand> = Vec::new();
    let (mut start, mut found) = (0, 0);
    for (row, middle) in middles.iter().enumerate() {
        found += middle;
        let full = found * count >= total * (bands.len() + 1) && bands.len() + 1 < count;
        if full || row + 1 == height {
            bands.push(RowBand { rows: start..row + 1, tiles: Vec::new() });
            start = row + 1;
        }
    }
    bands.par_iter_mut().for_each(|band| {
        let touches = |tile: &TileBounds| {
            !tile.is_empty() && (tile.top as usize) < band.rows.end && tile.bottom as usize > band.rows.start
        };
        let touching = bounds.iter().enumerate().filter(|(_, tile)| touches(tile));
        band.tiles = touching.map(|(index, _)| (first_tile + index) as u32).collect();
    });
    bands
}
