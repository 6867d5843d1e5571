//! The samples of one frame, as the renderers see them: its images one after another, their tiles numbered through.
//!
//! A sample is named by its *slot*: the number of its tile at this frame and its place in the tile. A slot says at once
//! which camera recorded the sample and where, and fits into half a z-buffer key:
//!
//! ```text
//! slot = [ number of the tile: 24 bits | row in the tile: 4 bits | column in the tile: 4 bits ]
//! ```

use std::ops::Range;

use crate::error::{Error, Result};
use crate::preprocess::{SampleImage, SampleSet, SampleTile, TILE};

/// Tiles that slots can tell apart.
const MAX_TILES: usize = 1 << 24;

/// One tile of the frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct TileRef {
    /// Position in [`FrameSamples::images`].
    pub(super) image: u32,
    /// Index in [`SampleImage::tiles`].
    pub(super) tile: u32,
}

/// The images at a frame, those that outlast it first, so that their slots are the same at every frame they share.
#[derive(Clone, Debug)]
pub(super) struct FrameSamples<'a> {
    pub(super) set: &'a SampleSet,
    /// Indices in [`SampleSet::images`].
    pub(super) images: Vec<usize>,
    /// Every tile, image by image.
    pub(super) tiles: Vec<TileRef>,
    /// How many of `images` outlast the frame.
    pub(super) lasting_images: usize,
    /// How many of `tiles` belong to them.
    pub(super) lasting_tiles: usize,
}

impl<'a> FrameSamples<'a> {
    /// The samples at `frame`.
    ///
    /// # Errors
    /// `Unsupported` where there are more tiles than slots can number.
    pub(super) fn at(set: &'a SampleSet, frame: usize) -> Result<Self> {
        let at_frame = |lasting: bool| {
            let images = set.images.iter().enumerate();
            images
                .filter(move |(_, image)| image.span.contains(frame) && (image.span.len() > 1) == lasting)
                .map(|(index, _)| index)
        };
        let mut images: Vec<usize> = at_frame(true).collect();
        let lasting_images = images.len();
        images.extend(at_frame(false));
        let mut tiles = Vec::new();
        let mut lasting_tiles = 0;
        for (position, &image) in images.iter().enumerate() {
            let count = set.images[image].tiles.len() as u32;
            tiles.extend((0..count).map(|tile| TileRef { image: position as u32, tile }));
            if position < lasting_images {
                lasting_tiles = tiles.len();
            }
        }
        if tiles.len() > MAX_TILES {
            return Err(Error::unsupported(
                format!("'{}', frame {frame}", set.name),
                format!("{} tiles of samples at one frame; {MAX_TILES} can be rendered", tiles.len()),
            ));
        }
        Ok(Self { set, images, tiles, lasting_images, lasting_tiles })
    }

    /// Numbers of the tiles that outlast the frame.
    pub(super) fn lasting(&self) -> Range<usize> {
        0..self.lasting_tiles
    }

    /// Numbers of the tiles of this frame alone.
    pub(super) fn passing(&self) -> Range<usize> {
        self.lasting_tiles..self.tiles.len()
    }

    /// The image a tile belongs to, and the tile.
    #[inline]
    pub(super) fn tile(&self, number: usize) -> (&'a SampleImage, &'a SampleTile) {
        let place = self.tiles[number];
        let image: &SampleImage = &self.set.images[self.images[place.image as usize]];
        (image, &image.tiles[place.tile as usize])
    }

    /// Index in [`SampleSet::images`] of the image of a slot.
    pub(super) fn image_of(&self, slot: u32) -> u32 {
        self.images[self.tiles[(slot >> 8) as usize].image as usize] as u32
    }

    /// The color of the sample at a slot, linear.
    pub(super) fn color_of(&self, slot: u32) -> [f32; 3] {
        let (image, tile) = self.tile((slot >> 8) as usize);
        let nth = tile.rank(slot as usize % TILE, slot as usize / TILE % TILE);
        image.color[tile.first as usize + nth].map(half::f16::to_f32)
    }

    /// The cameras that some keys' samples come from, ascending.
    pub(super) fn cameras_of(&self, keys: &[u64], cameras: &mut Vec<u16>) {
        cameras.clear();
        let mut last_tile = u32::MAX;
        for key in keys.iter().filter(|key| **key != 0) {
            let tile = !(*key as u32) >> 8;
            if tile != last_tile {
                last_tile = tile;
                let camera = self.tile(tile as usize).0.camera as u16;
                if let Err(place) = cameras.binary_search(&camera) {
                    cameras.insert(place, camera);
                }
            }
        }
    }

    /// Samples in some tiles.
    pub(super) fn sample_count(&self, tiles: Range<usize>) -> u64 {
        self.tiles[tiles]
            .chunk_by(|a, b| a.image == b.image)
            .map(|tiles| self.set.images[self.images[tiles[0].image as usize]].len() as u64)
            .sum()
    }
}
