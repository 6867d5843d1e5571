//! Looking samples up by camera and pixel: the way back from a surface point to the pixels that saw it.
//!
//! Each camera's picture is a grid of cells, one per tile; a cell leads to the tiles of the images that hold samples there,
//! one after another: no two images of a camera hold a sample of the same pixel at one frame. Building the table takes a few
//! instructions per tile and copies no sample.

use std::ops::Range;

use half::f16;

use super::dense_tile::MISSING;
use super::frame_samples::FrameSamples;
use crate::capture::Camera;
use crate::preprocess::TILE;

/// Marks the end of a list of tiles.
const NONE: u32 = u32::MAX;

/// A tile, with everything that its samples are read from.
struct Entry<'a> {
    rows: [u16; TILE],
    /// Samples in the rows above each row.
    before: [u8; TILE],
    color: &'a [[f16; 3]],
    low: &'a [u16],
    high: &'a [u8],
    farthest: u32,
    wide: bool,
    /// The next tile of the same cell.
    next: u32,
}

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
    cells: Vec<u32>,
    entries: Vec<Entry<'a>>,
}

/// The samples of 2×2 pixels: left above, right above, left below, right below.
pub(super) struct Quad {
    /// Inverse depths in the camera; [`MISSING`] where there is no sample.
    pub(super) depth: [f32; 4],
    entry: [u32; 4],
    nth: [u32; 4],
}

impl<'a> Entry<'a> {
    fn new(frame: &FrameSamples<'a>, number: usize, next: u32) -> Self {
        let (image, tile) = frame.tile(number);
        let place = image.depth.tiles()[frame.tiles[number].tile as usize];
        let mut before = [0; TILE];
        let mut count = 0;
        for (before, row) in before.iter_mut().zip(&tile.rows) {
            *before = count as u8;
            count += row.count_ones();
        }
        let samples = tile.first as usize..tile.first as usize + count as usize;
        let bytes = samples.len() << usize::from(place.is_wide());
        Self {
            rows: tile.rows,
            before,
            color: &image.color[samples.clone()],
            low: &image.depth.low()[samples],
            high: &image.depth.high()[place.first_high as usize..place.first_high as usize + bytes],
            farthest: place.farthest,
            wide: place.is_wide(),
            next,
        }
    }

    #[inline(always)]
    fn holds(&self, column: usize, row: usize) -> bool {
        self.rows[row] >> column & 1 == 1
    }

    #[inline(always)]
    fn rank(&self, column: usize, row: usize) -> usize {
        self.before[row] as usize + (self.rows[row] & ((1 << column) - 1)).count_ones() as usize
    }

    #[inline(always)]
    fn depth(&self, nth: usize) -> f32 {
        let high = if self.wide {
            u32::from(self.high[2 * nth]) | u32::from(self.high[2 * nth + 1]) << 8
        } else {
            u32::from(self.high[nth])
        };
        f32::from_bits(self.farthest + (u32::from(self.low[nth]) | high << 16))
    }
}

impl<'a> Lookup<'a> {
    /// Over some tiles of the frame.
    pub(super) fn new(frame: &FrameSamples<'a>, tiles: Range<usize>) -> Self {
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
        let mut entries = Vec::with_capacity(tiles.len());
        // Backwards, so that the tiles of the longest spans, which hold the most, come first in their lists.
        for number in tiles.rev() {
            let (image, tile) = frame.tile(number);
            let camera = &cameras[image.camera as usize];
            let cell = camera.first + tile.tile_y as usize * camera.across + tile.tile_x as usize;
            entries.push(Entry::new(frame, number, cells[cell]));
            cells[cell] = entries.len() as u32 - 1;
        }
        Self { cameras, cells, entries }
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
        let mut quad = Quad { depth: [MISSING; 4], entry: [NONE; 4], nth: [0; 4] };
        let inside = x >= 0 && y >= 0 && x + 1 < cells.width && y + 1 < cells.height;
        let (column, row) = ((x & 15) as usize, (y & 15) as usize);
        if inside && column < TILE - 1 && row < TILE - 1 {
            let cell = cells.first + (y >> 4) as usize * cells.across + (x >> 4) as usize;
            let mut at = self.cells[cell];
            while at != NONE {
                let entry = &self.entries[at as usize];
                let (above, below) = (entry.rows[row] >> column & 3, entry.rows[row + 1] >> column & 3);
                let (first_above, first_below) = (entry.rank(column, row), entry.rank(column, row + 1));
                let places = [
                    (above & 1, first_above),
                    (above >> 1, first_above + (above & 1) as usize),
                    (below & 1, first_below),
                    (below >> 1, first_below + (below & 1) as usize),
                ];
                for (corner, (held, nth)) in places.into_iter().enumerate() {
                    if held == 1 {
                        quad.set(corner, at, entry, nth);
                    }
                }
                if above & below == 3 {
                    break;
                }
                at = entry.next;
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
                let entry = &self.entries[at as usize];
                if entry.holds(column, row) {
                    quad.set(corner as usize, at, entry, entry.rank(column, row));
                    break;
                }
                at = entry.next;
            }
        }
        quad
    }

    /// The color of one sample of a quad, linear.
    #[inline(always)]
    pub(super) fn color(&self, quad: &Quad, corner: usize) -> [f32; 3] {
        let entry = &self.entries[quad.entry[corner] as usize];
        entry.color[quad.nth[corner] as usize].map(f32_from_f16)
    }
}

impl Quad {
    #[inline(always)]
    fn set(&mut self, corner: usize, at: u32, entry: &Entry<'_>, nth: usize) {
        self.depth[corner] = entry.depth(nth);
        self.entry[corner] = at;
        self.nth[corner] = nth as u32;
    }
}

/// A half float widened by integer arithmetic alone, so that it is inlined and vectorized; colors are finite.
#[inline(always)]
pub(super) fn f32_from_f16(value: f16) -> f32 {
    let bits = u32::from(value.to_bits());
    // The exponent and mantissa in their place, times 2^112: the difference of the two exponent biases.
    let magnitude = f32::from_bits((bits & 0x7fff) << 13) * f32::from_bits(0x7780_0000);
    if bits & 0x8000 == 0 { magnitude } else { -magnitude }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn widening_a_half_float_is_exact() {
        for bits in 0..=u16::MAX {
            let half = f16::from_bits(bits);
            if half.is_finite() {
                assert_eq!(f32_from_f16(half), half.to_f32(), "{bits:#06x}");
            }
        }
    }
}
