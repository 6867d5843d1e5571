//! The samples of one frame, as the renderers see them: its images one after another, their tiles numbered through.
//!
//! A sample is named by its *slot*: the number of its tile at this frame and its place in the tile. A slot says at once
//! which camera recorded the sample and where, and fits into half a z-buffer key:
//!
//! ```text
//! slot = [ number of the tile: 24 bits | row in the tile: 4 bits | column in the tile: 4 bits ]
//! ```

use std::ops::Range;

use half::f16;

use crate::color::widened;
use crate::error::{Error, Result};
use crate::samples::{SampleImage, SampleSet, TILE, TILE_SAMPLES, TileDepths};
use crate::settings::PruningMethod;
use crate::simd::{self, VectorLoop};

/// Tiles that slots can tell apart.
const MAX_TILES: usize = 1 << 24;

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
}

impl<'a> FrameTile<'a> {
    #[inline(always)]
    fn new(image: &'a SampleImage, index: usize) -> Self {
        let tile = &image.tiles[index];
        let mut before = [0; TILE];
        let mut count = 0;
        for (before, row) in before.iter_mut().zip(&tile.rows) {
            *before = count as u8;
            count += row.count_ones();
        }
        let samples = tile.first as usize..tile.first as usize + count as usize;
        Self {
            rows: tile.rows,
            before,
            depths: image.depth.tile(index, tile.first, samples.len()),
            color: &image.color[samples],
            origin: (u32::from(tile.tile_x) * TILE as u32, u32::from(tile.tile_y) * TILE as u32),
            camera: image.camera as u16,
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
        self.color[nth].map(|half| widened(half.to_bits().cast_signed()))
    }

    /// Asks for the memory of the tile's depths.
    #[inline(always)]
    pub(crate) fn prefetch_depths(&self) {
        let (low, high) = self.depths.planes();
        (0..low.len()).step_by(32).for_each(|at| simd::prefetch(low, at));
        (0..high.len()).step_by(64).for_each(|at| simd::prefetch(high, at));
    }

    /// Asks for the memory of everything that is read from the tile.
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

/// Where a color lies.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct ColorIndex {
    /// Index in [`FrameSamples::images`].
    pub(crate) image: u32,
    /// Index of the sample in the image.
    pub(crate) nth: u32,
}

/// Marks tiles whose samples need not be counted: each lies at its place in the tile.
const FULL: u32 = 1 << 31;

/// The images at a frame, those of all frames first, so that their slots are the same at every frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct FrameImages {
    /// Indices in [`SampleSet::images`].
    indices: Vec<usize>,
    /// How many of them hold at all frames.
    lasting: usize,
}

impl FrameImages {
    pub(crate) fn at(set: &SampleSet, frame: usize) -> Self {
        // Images of some frames change so often that keeping them painted would not pay.
        let outlasts = |image: &SampleImage| image.span.len() > 1 && image.span.len() == set.frame_count();
        let at_frame = |lasting: bool| {
            let images = set.images.iter().enumerate();
            images
                .filter(move |(_, image)| image.span.contains(frame) && outlasts(image) == lasting)
                .map(|(index, _)| index)
        };
        let mut indices: Vec<usize> = at_frame(true).collect();
        let lasting = indices.len();
        indices.extend(at_frame(false));
        Self { indices, lasting }
    }

    /// Indices of the images that hold at all frames.
    pub(crate) fn lasting(&self) -> &[usize] {
        &self.indices[..self.lasting]
    }
}

/// What is known of every tile by its number. That of lasting tiles is kept from one frame to the next.
#[derive(Clone, Debug, Default)]
pub(crate) struct TileIndex {
    /// The place of the first sample of each tile, with [`FULL`] added to the image: eight bytes, so that all of them fit in
    /// a cache together.
    color_indices: Vec<ColorIndex>,
    /// The camera of each tile: two bytes, so that all of them fit in the smallest cache.
    cameras: Vec<u16>,
}

/// The samples at a frame, their tiles numbered image by image.
#[derive(Clone, Debug)]
pub(crate) struct FrameSamples<'a> {
    pub(crate) set: &'a SampleSet,
    /// Indices in [`SampleSet::images`].
    pub(crate) images: Vec<usize>,
    /// Every tile that is to be painted: all, or those after the lasting ones, which are painted already.
    tiles: Vec<FrameTile<'a>>,
    /// The number of the first of `tiles`.
    first_number: usize,
    /// How many of `images` hold at all frames.
    pub(crate) lasting_images: usize,
    /// How many tiles belong to them.
    pub(crate) lasting_tiles: usize,
    /// The number of the first tile of each image.
    first_of_image: Vec<usize>,
    numbers: TileIndex,
    /// Colors of each image.
    colors: Vec<&'a [[f16; 3]]>,
}

/// Adds the tiles of the `nth` image of the frame.
struct IndexTiles<'a, 'b> {
    nth: u32,
    image: &'a SampleImage,
    tiles: &'b mut Vec<FrameTile<'a>>,
    numbers: &'b mut TileIndex,
}

impl VectorLoop for IndexTiles<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { nth, image, tiles, numbers } = self;
        for (index, tile) in image.tiles.iter().enumerate() {
            let numbered = FrameTile::new(image, index);
            let full = if numbered.color.len() == TILE_SAMPLES { FULL } else { 0 };
            numbers.color_indices.push(ColorIndex { image: nth | full, nth: tile.first });
            numbers.cameras.push(numbered.camera);
            tiles.push(numbered);
        }
    }
}

impl<'a> FrameSamples<'a> {
    /// Whether samples that others represent were dropped.
    pub(crate) fn is_pruned(&self) -> bool {
        self.set.settings.pruning.method != PruningMethod::Off
    }

    /// The samples of the images at `frame`. Where the numbers of lasting tiles are known, those tiles are taken to be painted.
    ///
    /// # Errors
    /// `Unsupported` where there are more tiles than slots can number.
    pub(crate) fn of(
        set: &'a SampleSet,
        frame: usize,
        images: FrameImages,
        lasting: Option<TileIndex>,
    ) -> Result<Self> {
        let FrameImages { indices: images, lasting: lasting_images } = images;
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
        let lasting_tiles = first_of_image[lasting_images];
        let (first_image, first_number) =
            if lasting.is_some() { (lasting_images, lasting_tiles) } else { (0, 0) };
        let mut numbers = lasting.unwrap_or_default();
        numbers.color_indices.reserve(count - first_number);
        numbers.cameras.reserve(count - first_number);
        let mut tiles = Vec::with_capacity(count - first_number);
        for (nth, &index) in images.iter().enumerate().skip(first_image) {
            let image = &set.images[index];
            let (tiles, numbers) = (&mut tiles, &mut numbers);
            simd::run(IndexTiles { nth: nth as u32, image, tiles, numbers });
        }
        let colors = images.iter().map(|&image| set.images[image].color.as_slice()).collect();
        Ok(Self {
            set,
            images,
            tiles,
            first_number,
            lasting_images,
            lasting_tiles,
            first_of_image,
            numbers,
            colors,
        })
    }

    /// The samples at `frame`, of which nothing is known yet.
    ///
    /// # Errors
    /// As [`FrameSamples::of`].
    pub(crate) fn at(set: &'a SampleSet, frame: usize) -> Result<Self> {
        Self::of(set, frame, FrameImages::at(set, frame), None)
    }

    /// What is known of the lasting tiles, for the next frame.
    pub(crate) fn into_lasting_numbers(self) -> TileIndex {
        let Self { mut numbers, lasting_tiles, .. } = self;
        numbers.color_indices.truncate(lasting_tiles);
        numbers.cameras.truncate(lasting_tiles);
        numbers
    }

    /// How many tiles there are.
    pub(crate) fn tile_count(&self) -> usize {
        self.numbers.cameras.len()
    }

    /// Tiles that are to be painted.
    pub(crate) fn tiles(&self, numbers: Range<usize>) -> &[FrameTile<'a>] {
        &self.tiles[numbers.start - self.first_number..numbers.end - self.first_number]
    }

    /// A tile that is to be painted.
    #[inline(always)]
    pub(crate) fn tile(&self, number: usize) -> &FrameTile<'a> {
        &self.tiles[number - self.first_number]
    }

    /// A tile, unless it is painted already.
    #[inline(always)]
    pub(crate) fn new_tile(&self, number: usize) -> Option<&FrameTile<'a>> {
        self.tiles.get(number.wrapping_sub(self.first_number))
    }

    /// A tile that is painted already.
    #[inline(always)]
    pub(crate) fn painted_tile(&self, number: usize) -> FrameTile<'a> {
        let nth = (self.numbers.color_indices[number].image & !FULL) as usize;
        FrameTile::new(&self.set.images[self.images[nth]], number - self.first_of_image[nth])
    }

    /// Numbers of the tiles that hold at all frames.
    pub(crate) fn lasting(&self) -> Range<usize> {
        0..self.lasting_tiles
    }

    /// Numbers of the tiles of shorter spans.
    pub(crate) fn passing(&self) -> Range<usize> {
        self.lasting_tiles..self.tile_count()
    }

    /// Index in [`SampleSet::images`] of the image of a slot.
    #[inline(always)]
    pub(crate) fn image_of(&self, slot: u32) -> u32 {
        self.images[self.nth_image(slot)] as u32
    }

    /// Index of the camera of a slot.
    #[inline(always)]
    pub(crate) fn camera_of(&self, slot: u32) -> u16 {
        self.numbers.cameras[(slot >> 8) as usize]
    }

    /// The image of a slot, as an index in `images`.
    #[inline(always)]
    fn nth_image(&self, slot: u32) -> usize {
        (self.numbers.color_indices[(slot >> 8) as usize].image & !FULL) as usize
    }

    /// The color of the sample at a slot, linear.
    #[inline(always)]
    pub(crate) fn color_of(&self, slot: u32) -> [f32; 3] {
        let place = self.color_index(slot);
        self.colors(place.image)[place.nth as usize].map(|half| widened(half.to_bits().cast_signed()))
    }

    /// Where the color of the sample at a slot lies.
    #[inline(always)]
    pub(crate) fn color_index(&self, slot: u32) -> ColorIndex {
        let number = (slot >> 8) as usize;
        let first = self.numbers.color_indices[number];
        let nth = if first.image & FULL != 0 {
            slot as usize % TILE_SAMPLES
        } else if let Some(tile) = self.new_tile(number) {
            tile.rank(slot as usize % TILE, slot as usize / TILE % TILE)
        } else {
            self.rank_in_painted_tile(slot)
        };
        ColorIndex { image: first.image & !FULL, nth: first.nth + nth as u32 }
    }

    /// Samples before a slot in its tile, where that is painted already.
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

    /// The cameras that recorded the samples at some slots, ascending.
    #[inline(always)]
    pub(crate) fn cameras_of(&self, slots: impl Iterator<Item = u32>, cameras: &mut Vec<u16>) {
        cameras.clear();
        let shown = slots.map(|slot| self.camera_of(slot));
        if self.set.cameras.len() > 64 {
            cameras.extend(shown);
            cameras.sort_unstable();
            cameras.dedup();
            return;
        }
        let mut seen = shown.fold(0_u64, |seen, camera| seen | 1 << (camera % 64));
        while seen != 0 {
            cameras.push(seen.trailing_zeros() as u16);
            seen &= seen - 1;
        }
    }

    /// Samples in some tiles that are to be painted.
    pub(crate) fn sample_count(&self, tiles: Range<usize>) -> u64 {
        self.tiles(tiles).iter().map(|tile| tile.color.len() as u64).sum()
    }
}
