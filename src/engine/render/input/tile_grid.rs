//! Looks samples up by camera and pixel.
//!
//! Each camera's picture is a grid of cells, one per tile; a cell holds a list of the tiles with samples there, one per image.
//! No two images of a camera hold a sample of the same pixel at one frame. Building the table takes a few instructions per tile
//! and copies no sample.

use std::ops::Range;

use super::frame_tiles::{FrameSamples, FrameTile};
use crate::capture::Camera;
use crate::samples::TILE;

/// Marks the end of a list of tiles.
const NONE: u32 = u32::MAX;

/// The size of a camera's picture and where its cells begin.
#[derive(Clone, Copy, Debug)]
struct CameraGrid {
    width: i32,
    height: i32,
    across: usize,
    down: usize,
    first: usize,
}

/// Which tiles of a frame lie in each cell. That of the background is kept from one frame to the next.
#[derive(Clone, Debug)]
pub(crate) struct CellTable {
    cameras: Vec<CameraGrid>,
    /// The first tile of each cell.
    cells: Vec<u32>,
    /// The next tile of the same cell, for each tile.
    next: Vec<u32>,
}

impl CellTable {
    /// A table without tiles.
    pub(crate) fn empty(cameras: &[Camera]) -> Self {
        let mut first = 0;
        let cells_of = |camera: &Camera| {
            let (width, height) = camera.intrinsics.size();
            let (across, down) = (width.div_ceil(TILE), height.div_ceil(TILE));
            let cells = CameraGrid { width: width as i32, height: height as i32, across, down, first };
            first += across * down;
            cells
        };
        let cameras: Vec<CameraGrid> = cameras.iter().map(cells_of).collect();
        Self { cameras, cells: vec![NONE; first], next: Vec::new() }
    }

    /// The table with further tiles, whose numbers follow those that it holds.
    pub(crate) fn with(mut self, frame: &FrameSamples<'_>, tiles: Range<usize>) -> Self {
        self.next.resize(tiles.end, NONE);
        for (number, tile) in tiles.clone().zip(frame.tiles(tiles)) {
            let camera = &self.cameras[tile.camera as usize];
            let (column, row) = (tile.origin.0 as usize / TILE, tile.origin.1 as usize / TILE);
            let cell = &mut self.cells[camera.first + row * camera.across + column];
            self.next[number] = std::mem::replace(cell, number as u32);
        }
        self
    }
}

/// Finds samples of a frame by camera and pixel.
pub(crate) struct Lookup<'a> {
    pub(crate) table: CellTable,
    pub(crate) frame: &'a FrameSamples<'a>,
}

impl<'a> Lookup<'a> {
    /// Columns and rows of a camera.
    #[inline(always)]
    pub(crate) fn size(&self, camera: usize) -> (i32, i32) {
        let CameraGrid { width, height, .. } = self.table.cameras[camera];
        (width, height)
    }

    /// The number of the first tile of a camera with samples in a column and row of its grid, or outside of it.
    #[inline(always)]
    pub(crate) fn first_at(&self, camera: usize, column: i32, row: i32) -> Option<u32> {
        let cells = &self.table.cameras[camera];
        let inside =
            column >= 0 && row >= 0 && (column as usize) < cells.across && (row as usize) < cells.down;
        if !inside {
            return None;
        }
        let first = self.table.cells[cells.first + row as usize * cells.across + column as usize];
        (first != NONE).then_some(first)
    }

    /// The next tile of the same cell.
    #[inline(always)]
    pub(crate) fn next(&self, number: u32) -> Option<u32> {
        let next = self.table.next[number as usize];
        (next != NONE).then_some(next)
    }

    /// A tile by its number; one that is painted already is made anew in `made`.
    #[inline(always)]
    pub(crate) fn tile<'b>(&'b self, number: u32, made: &'b mut Option<FrameTile<'a>>) -> &'b FrameTile<'a> {
        match self.frame.tile_to_paint(number as usize) {
            Some(tile) => tile,
            None => made.insert(self.frame.painted_tile(number as usize)),
        }
    }
}
