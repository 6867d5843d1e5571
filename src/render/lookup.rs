//! Looking samples up by camera and pixel: the way back from a surface point to the pixels that saw it.
//!
//! Each camera's picture is a grid of cells, one per tile; a cell leads to the tiles of the images that hold samples there,
//! one after another: no two images of a camera hold a sample of the same pixel at one frame. Building the table takes a few
//! instructions per tile and copies no sample.

use std::ops::Range;

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
    down: usize,
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

impl<'a> Lookup<'a> {
    /// Over some tiles of the frame.
    pub(super) fn new(frame: &'a FrameSamples<'a>, tiles: Range<usize>) -> Self {
        let mut first = 0;
        let cells_of = |camera: &Camera| {
            let (width, height) = camera.intrinsics.size();
            let (across, down) = (width.div_ceil(TILE), height.div_ceil(TILE));
            let cells = Cells { width: width as i32, height: height as i32, across, down, first };
            first += across * down;
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

    /// The tiles of a camera that hold samples in a column and row of its grid of tiles, which may lie outside of it.
    #[inline(always)]
    pub(super) fn tiles_at(
        &self,
        camera: usize,
        column: i32,
        row: i32,
    ) -> impl Iterator<Item = &'a FrameTile<'a>> {
        let cells = &self.cameras[camera];
        let inside =
            column >= 0 && row >= 0 && (column as usize) < cells.across && (row as usize) < cells.down;
        let mut at = NONE;
        if inside {
            at = self.cells[cells.first + row as usize * cells.across + column as usize];
        }
        std::iter::from_fn(move || {
            let tile = self.tiles.get(at as usize)?;
            at = self.next[at as usize];
            Some(tile)
        })
    }
}
