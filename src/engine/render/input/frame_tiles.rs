//! The samples of one frame: its images one after another, with their tiles numbered consecutively.
//!
//! A sample is identified by its *slot*: the number of its tile at this frame and its pixel in the tile. A slot gives the camera
//! and pixel of the sample and takes half of a z-buffer key:
//!
//! ```text
//! slot = [ number of the tile: 24 bits | row in the tile: 4 bits | column in the tile: 4 bits ]
//! ```

use std::ops::Range;

use half::f16;

use crate::color::widened;
use crate::error::{Error, Result};
use crate::samples::{SampleImage, SampleSet, TILE, TILE_SAMPLES, TileDepths};
use crate::simd::{self, VectorLoop};

/// Most tiles that slots can number.
const MAX_TILES: usize = 1 << 24;

/// Where a color is stored.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct ColorIndex {
    /// Index in [`FrameSamples::images`].
    pub(crate) image: u32,
    /// Index of the sample in the image.
    pub(crate) nth: u32,
}

/// Marks tiles with a sample in every pixel, where samples need not be counted.
const FULL: u32 = 1 << 31;

/// The images at a frame, those of all frames first, so that their slots are the same at every frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct FrameImages {
    /// Indices in [`SampleSet::images`].
    indices: Vec<usize>,
    /// How many of them hold at all frames: the background.
    background: usize,
}

impl FrameImages {
    pub(crate) fn at(set: &SampleSet, frame: usize) -> Self {
        // Keeping images of only some frames painted would not pay: they change too often.
        let is_background =
            |image: &SampleImage| image.span.len() > 1 && image.span.len() == set.frame_count();
        let at_frame = |background: bool| {
            let images = set.images.iter().enumerate();
            images
                .filter(move |(_, image)| image.span.contains(frame) && is_background(image) == background)
                .map(|(index, _)| index)
        };
        let mut indices: Vec<usize> = at_frame(true).collect();
        let background = indices.len();
        indices.extend(at_frame(false));
        Self { indices, background }
    }

    /// Indices of all images, those that hold at all frames first.
    pub(crate) fn all(&self) -> &[usize] {
        &self.indices
    }

    /// Indices of the images that hold at all frames.
    pub(crate) fn background(&self) -> &[usize] {
        &self.indices[..self.background]
    }
}

/// The camera and the color index of every tile by its number. For tiles of the background it is kept from frame to frame.
#[derive(Clone, Debug, Default)]
pub(crate) struct TileIndex {
    /// Where the colors of each tile begin, with [`FULL`] added to the image. Eight bytes a tile, to fit in a cache.
    color_indices: Vec<ColorIndex>,
    /// The camera of each tile. Two bytes a tile, to fit in the smallest cache.
    cameras: Vec<u16>,
}

/// The samples at a frame, their tiles numbered image by image.
#[derive(Clone, Debug)]
pub(crate) struct FrameSamples<'a> {
    pub(crate) set: &'a SampleSet,
    /// Indices in [`SampleSet::images`].
    pub(crate) images: Vec<usize>,
    /// The tiles to be painted: all, or those of the foreground if the background is painted already.
    tiles: Vec<FrameTile<'a>>,
    /// The number of the first of `tiles`.
    first_number: usize,
    /// How many of `images` hold at all frames.
    pub(crate) background_images: usize,
    /// How many tiles these have.
    pub(crate) background_tile_count: usize,
    /// The number of the first tile of each image.
    first_of_image: Vec<usize>,
    index: TileIndex,
    /// Colors of each image.
    colors: Vec<&'a [[f16; 3]]>,
}

/// Adds the tiles of an image, the `nth` of the frame, to a list and an index.
struct IndexTiles<'a, 'b> {
    nth: u32,
    image: &'a SampleImage,
    tiles: &'b mut Vec<FrameTile<'a>>,
    index: &'b mut TileIndex,
}

impl VectorLoop for IndexTiles<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { nth, image, tiles, index } = self;
        for (at, tile) in image.tiles.iter().enumerate() {
            let numbered = FrameTile::new(image, at);
            let full = if numbered.color.len() == TILE_SAMPLES { FULL } else { 0 };
            index.color_indices.push(ColorIndex { image: nth | full, nth: tile.first });
            index.cameras.push(numbered.camera);
            tiles.push(numbered);
        }
    }
}

impl<'a> FrameSamples<'a> {
    /// Whether redundant samples were pruned.
    pub(crate) fn is_pruned(&self) -> bool {
        self.set.is_pruned()
    }

    /// The samples of the images at `frame`. With an index of the background's tiles, these are not listed for painting again.
    ///
    /// # Errors
    /// `Unsupported` where there are more tiles than slots can number.
    pub(crate) fn of(
        set: &'a SampleSet,
        frame: usize,
        images: FrameImages,
        background: Option<TileIndex>,
    ) -> Result<Self> {
        let FrameImages { indices: images, background: background_images } = images;
        let mut count = 0;
        let mut first_of_image = Vec::with_capacity(images.len() + 1);
        for &image in &images {
            first_of_image.push(count);
            count += set.images[image].tiles.len();
        }
        first_of_image.push(count);
        if count > MAX_TILES {
            return Err(Error::unsupported(
                format!("'{}', frame {frame}", set.name),
                format!("{count} tiles of samples at one frame; {MAX_TILES} can be rendered"),
            ));
        }
        let background_tile_count = first_of_image[background_images];
        let (first_image, first_number) =
            if background.is_some() { (background_images, background_tile_count) } else { (0, 0) };
        let mut index = background.unwrap_or_default();
        index.color_indices.reserve(count - first_number);
        index.cameras.reserve(count - first_number);
        let mut tiles = Vec::with_capacity(count - first_number);
        for (nth, &image) in images.iter().enumerate().skip(first_image) {
            let image = &set.images[image];
            simd::run(IndexTiles { nth: nth as u32, image, tiles: &mut tiles, index: &mut index });
        }
        let colors = images.iter().map(|&image| set.images[image].color.as_slice()).collect();
        Ok(Self {
            set,
            images,
            tiles,
            first_number,
            background_images,
            background_tile_count,
            first_of_image,
            index,
            colors,
        })
    }

    /// The samples at `frame`, with all tiles to be painted.
    pub(crate) fn at(set: &'a SampleSet, frame: usize) -> Result<Self> {
        Self::of(set, frame, FrameImages::at(set, frame), None)
    }

    /// The index of the background's tiles, for the next frame.
    pub(crate) fn into_background_index(self) -> TileIndex {
        let Self { mut index, background_tile_count, .. } = self;
        index.color_indices.truncate(background_tile_count);
        index.cameras.truncate(background_tile_count);
        index
    }

    /// The number of tiles.
    pub(crate) fn tile_count(&self) -> usize {
        self.index.cameras.len()
    }

    /// Tiles to be painted.
    pub(crate) fn tiles(&self, numbers: Range<usize>) -> &[FrameTile<'a>] {
        &self.tiles[numbers.start - self.first_number..numbers.end - self.first_number]
    }

    /// A tile to be painted.
    #[inline(always)]
    pub(crate) fn tile(&self, number: usize) -> &FrameTile<'a> {
        &self.tiles[number - self.first_number]
    }

    /// A tile, if it is to be painted.
    #[inline(always)]
    pub(crate) fn tile_to_paint(&self, number: usize) -> Option<&FrameTile<'a>> {
        self.tiles.get(number.wrapping_sub(self.first_number))
    }

    /// A tile of the background that is painted already.
    #[inline(always)]
    pub(crate) fn painted_tile(&self, number: usize) -> FrameTile<'a> {
        let nth = self.nth_image(number);
        FrameTile::new(&self.set.images[self.images[nth]], number - self.first_of_image[nth])
    }

    /// Numbers of the tiles that hold at all frames.
    pub(crate) fn background_tiles(&self) -> Range<usize> {
        0..self.background_tile_count
    }

    /// Numbers of the tiles of shorter spans.
    pub(crate) fn foreground_tiles(&self) -> Range<usize> {
        self.background_tile_count..self.tile_count()
    }

    /// Index in [`SampleSet::images`] of the image of a slot.
    #[inline(always)]
    pub(crate) fn image_of(&self, slot: u32) -> u32 {
        self.images[self.nth_image((slot >> 8) as usize)] as u32
    }

    /// Index of the camera of a slot.
    #[inline(always)]
    pub(crate) fn camera_of(&self, slot: u32) -> u16 {
        self.index.cameras[(slot >> 8) as usize]
    }

    /// The image of a tile, as an index in `images`.
    #[inline(always)]
    fn nth_image(&self, number: usize) -> usize {
        (self.index.color_indices[number].image & !FULL) as usize
    }

    /// The color of the sample at a slot, linear.
    #[inline(always)]
    pub(crate) fn color_of(&self, slot: u32) -> [f32; 3] {
        let index = self.color_index(slot);
        linear(self.colors(index.image)[index.nth as usize])
    }

    /// Where the color of the sample at a slot is stored.
    #[inline(always)]
    pub(crate) fn color_index(&self, slot: u32) -> ColorIndex {
        let number = (slot >> 8) as usize;
        let first = self.index.color_indices[number];
        let nth = if first.image & FULL != 0 {
            slot as usize % TILE_SAMPLES
        } else if let Some(tile) = self.tile_to_paint(number) {
            tile.rank(slot as usize % TILE, slot as usize / TILE % TILE)
        } else {
            self.rank_in_painted_tile(slot)
        };
        ColorIndex { image: first.image & !FULL, nth: first.nth + nth as u32 }
    }

    /// Samples before a slot in its tile, if the tile is painted already.
    #[cold]
    #[inline(never)]
    fn rank_in_painted_tile(&self, slot: u32) -> usize {
        self.painted_tile((slot >> 8) as usize).rank(slot as usize % TILE, slot as usize / TILE % TILE)
    }

    /// The colors of an image, as an index in `images`.
    #[inline(always)]
    pub(crate) fn colors(&self, image: u32) -> &'a [[f16; 3]] {
        self.colors[image as usize]
    }

    /// The number of samples in tiles to be painted.
    pub(crate) fn sample_count(&self, tiles: Range<usize>) -> u64 {
        self.tiles(tiles).iter().map(|tile| tile.color.len() as u64).sum()
    }
}

/// A tile of the frame, with everything that its samples are read from.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FrameTile<'a> {
    /// One mask per pixel row, as in [`SampleTile`](crate::samples::SampleTile).
    pub(crate) rows: [u16; TILE],
    /// Samples in the rows above each row.
    before: [u8; TILE],
    /// One color per sample.
    pub(crate) color: &'a [[f16; 3]],
    /// One inverse depth per sample.
    pub(crate) depths: TileDepths<'a>,
    /// Column and row of the tile's first pixel in the camera.
    pub(crate) origin: (u32, u32),
    /// Index of the camera.
    pub(crate) camera: u16,
    /// Where it holds doubtful samples, as [`FrameTile::rows`]; `None` where it holds none.
    pub(crate) doubtful: Option<&'a [u16; TILE]>,
}

impl<'a> FrameTile<'a> {
    /// The tile of an image with an index.
    #[inline(always)]
    pub(crate) fn new(image: &'a SampleImage, index: usize) -> Self {
        let tile = &image.tiles[index];
        let before = samples_above(&tile.rows);
        let count = usize::from(before[TILE - 1]) + tile.rows[TILE - 1].count_ones() as usize;
        let samples = tile.first as usize..tile.first as usize + count;
        Self {
            rows: tile.rows,
            before,
            depths: image.depth.tile(index, tile.first, samples.len()),
            color: &image.color[samples],
            origin: (u32::from(tile.tile_x) * TILE as u32, u32::from(tile.tile_y) * TILE as u32),
            camera: image.camera as u16,
            doubtful: image.doubtful_rows(index),
        }
    }

    /// Samples before a pixel of the tile.
    #[inline(always)]
    pub(crate) fn rank(&self, column: usize, row: usize) -> usize {
        self.before[row] as usize + (self.rows[row] & ((1 << column) - 1)).count_ones() as usize
    }

    /// The color of a sample, linear.
    #[inline(always)]
    pub(crate) fn color(&self, nth: usize) -> [f32; 3] {
        linear(self.color[nth])
    }

    /// Prefetches the depths.
    #[inline(always)]
    pub(crate) fn prefetch_depths(&self) {
        let (low, high) = self.depths.planes();
        (0..low.len()).step_by(32).for_each(|at| simd::prefetch(low, at));
        (0..high.len()).step_by(64).for_each(|at| simd::prefetch(high, at));
    }

    /// Prefetches depths and colors.
    #[inline(always)]
    pub(crate) fn prefetch(&self) {
        self.prefetch_depths();
        // Ten colors to a cache line.
        (0..self.color.len()).step_by(10).for_each(|at| simd::prefetch(self.color, at));
    }

    /// The three half floats of a color, red lowest.
    #[inline(always)]
    pub(crate) fn bits_of(color: [f16; 3]) -> u64 {
        let [red, green, blue] = color.map(|half| u64::from(half.to_bits()));
        red | green << 16 | blue << 32
    }
}

/// A color as it is stored, widened.
#[inline(always)]
pub(crate) fn linear(color: [f16; 3]) -> [f32; 3] {
    color.map(|half| widened(half.to_bits().cast_signed()))
}

/// The number of samples in the rows above each row of a tile.
#[inline(always)]
pub(crate) fn samples_above(rows: &[u16; TILE]) -> [u8; TILE] {
    let mut count = 0;
    rows.map(|row| {
        let above = count as u8;
        count += row.count_ones();
        above
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_above_a_row_are_counted() {
        let mut rows = [0; TILE];
        (rows[0], rows[2], rows[15]) = (0b101, 0xffff, 1);
        let above = samples_above(&rows);
        assert_eq!([0, 1, 2, 3, 15].map(|row| above[row]), [0, 2, 2, 18, 18]);
    }
}
