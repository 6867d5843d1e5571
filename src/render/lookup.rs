//! Looking samples up by camera and pixel: the way back from a surface point to the pixels that saw it.
//!
//! Each camera's picture is a grid of cells, one per tile; a cell leads to the tiles of the images that hold samples there,
//! one after another: no two images of a camera hold a sample of the same pixel at one frame. Building the table takes a few
//! instructions per tile and copies no sample.

use std::ops::Range;

use super::dense_tile::MISSING;
use super::frame_samples::{FrameSamples, FrameTile};
use crate::capture::Camera;
use crate::preprocess::TILE;

/// Marks the end of a list of tiles.
const NONE: u32 = u32::MAX;

/// Where a camera's cells begin, and its size.
#[derive(Clone, Copy)]
struct Cells {
    width: i32,
    height: i32,
    across: usize,
    first: usize,
}

/// Finds samples of a frame by camera and pixel.
pub(super) struct Lookup<'a> {
    cameras: Vec<Cells>,
    /// The first tile of each cell.
    cells: Vec<u32>,
    /// The next tile of the same cell, for each tile.
    next: Vec<u32>,
    tiles: &'a [FrameTile<'a>],
}

/// The samples of 2×2 pixels: left above, right above, left below, right below.
pub(super) struct Quad {
    /// Inverse depths in the camera; [`MISSING`] where there is no sample.
    pub(super) depth: [f32; 4],
    tile: [u32; 4],
    nth: [u32; 4],
}

impl<'a> Lookup<'a> {
    /// Over some tiles of the frame.
    pub(super) fn new(frame: &'a FrameSamples<'a>, tiles: Range<usize>) -> Self {
        let mut first = 0;
        let cells_of = |camera: &Camera| {
            let (width, height) = camera.intrinsics.size();
            let cells =
                Cells { width: width as i32, height: height as i32, across: width.div_ceil(TILE), first };
            first += cells.across * height.div_ceil(TILE);
            cells
        };
        let cameras: Vec<Cells> = frame.set.cameras.iter().map(cells_of).collect();
        let mut cells = vec![NONE; first];
        let mut next = vec![NONE; tiles.end];
        // Backwards, so that the tiles of the longest spans, which hold the most, come first in their lists.
        for number in tiles.rev() {
            let tile = &frame.tiles[number];
            let camera = &cameras[tile.camera as usize];
            let (column, row) = (tile.origin.0 as usize / TILE, tile.origin.1 as usize / TILE);
            let cell = &mut cells[camera.first + row * camera.across + column];
            next[number] = std::mem::replace(cell, number as u32);
        }
        Self { cameras, cells, next, tiles: &frame.tiles }
    }

    /// Columns and rows of a camera.
    #[inline(always)]
    pub(super) fn size(&self, camera: usize) -> (i32, i32) {
        (self.cameras[camera].width, self.cameras[camera].height)
    }

    /// The samples of a camera at columns `x`, `x + 1` and rows `y`, `y + 1`, which may lie outside its picture.
    #[inline(always)]
    pub(super) fn quad(&self, camera: usize, x: i32, y: i32) -> Quad {
        let cells = &self.cameras[camera];
        let mut quad = Quad { depth: [MISSING; 4], tile: [NONE; 4], nth: [0; 4] };
        let inside = x >= 0 && y >= 0 && x + 1 < cells.width && y + 1 < cells.height;
        let (column, row) = ((x & 15) as usize, (y & 15) as usize);
        if inside && column < TILE - 1 && row < TILE - 1 {
            let cell = cells.first + (y >> 4) as usize * cells.across + (x >> 4) as usize;
            let mut at = self.cells[cell];
            while at != NONE {
                let tile = &self.tiles[at as usize];
                let (above, below) = (tile.rows[row] >> column & 3, tile.rows[row + 1] >> column & 3);
                let (first_above, first_below) = (tile.rank(column, row), tile.rank(column, row + 1));
                let places = [
                    (above & 1, first_above),
                    (above >> 1, first_above + (above & 1) as usize),
                    (below & 1, first_below),
                    (below >> 1, first_below + (below & 1) as usize),
                ];
                for (corner, (held, nth)) in places.into_iter().enumerate() {
                    if held == 1 {
                        quad.set(corner, at, tile, nth);
                    }
                }
                if above & below == 3 {
                    break;
                }
                at = self.next[at as usize];
            }
            return quad;
        }
        for corner in 0..4 {
            let (x, y) = (x + (corner & 1), y + (corner >> 1));
            if x < 0 || y < 0 || x >= cells.width || y >= cells.height {
                continue;
            }
            let (column, row) = ((x & 15) as usize, (y & 15) as usize);
            let mut at = self.cells[cells.first + (y >> 4) as usize * cells.across + (x >> 4) as usize];
            while at != NONE {
                let tile = &self.tiles[at as usize];
                if tile.holds(column, row) {
                    quad.set(corner as usize, at, tile, tile.rank(column, row));
                    break;
                }
                at = self.next[at as usize];
            }
        }
        quad
    }

    /// Inverse depths and colors, three half floats each, of the samples at the pixels that [`Lookup::quad`] looks at.
    #[inline(always)]
    pub(super) fn samples(&self, camera: usize, x: i32, y: i32) -> ([f32; 4], [u64; 4]) {
        let cells = &self.cameras[camera];
        let inside = x >= 0 && y >= 0 && x + 1 < cells.width && y + 1 < cells.height;
        let (column, row) = ((x & 15) as usize, (y & 15) as usize);
        if inside && column < TILE - 1 && row < TILE - 1 {
            let cell = cells.first + (y >> 4) as usize * cells.across + (x >> 4) as usize;
            if let Some(tile) = self.tiles.get(self.cells[cell] as usize)
                && let Some(found) = tile.quad(column, row)
            {
                return found;
            }
        }
        let quad = self.quad(camera, x, y);
        let color = [0, 1, 2, 3].map(|corner: usize| {
            let tile = self.tiles.get(quad.tile[corner] as usize);
            tile.map_or(0, |tile| tile.color_bits(quad.nth[corner] as usize))
        });
        (quad.depth, color)
    }
}

impl Quad {
    #[inline(always)]
    fn set(&mut self, corner: usize, at: u32, tile: &FrameTile<'_>, nth: usize) {
        self.depth[corner] = tile.depths.get(nth);
        self.tile[corner] = at;
        self.nth[corner] = nth as u32;
    }
}
