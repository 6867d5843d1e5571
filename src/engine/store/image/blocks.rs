//! Conversion between the samples of an image and the blocks of numbers that are coded.

use super::color_ranks::ColorRanks;
use crate::samples::{DepthPlane, OctNormal, SampleImage, SampleTile, TILE, TILE_SAMPLES};
use crate::simd;
use crate::store::codec::{
    BLOCK, BlockPixels, BlockShape, BlockTraversal, Coder, Counts, FrequencyTables, ModelReader, ModelWriter,
    PlainReader, PlainWriter, TokenCounter, cell,
};

/// Tiles across a block, and down.
pub(crate) const TILES: usize = BLOCK / TILE;

/// The largest bits of a finite inverse depth.
pub(super) const LARGEST_DEPTH: u32 = 0x7F7F_FFFF;

/// What all blocks of an image share.
#[derive(Clone, Copy)]
pub(crate) struct BlockCoding<'a> {
    pub(crate) model: &'a FrequencyTables,
    pub(crate) palette: &'a ColorRanks,
    pub(crate) depth_shift: u32,
    pub(crate) normals: bool,
    pub(crate) plain: bool,
    /// Columns and rows of the camera's pictures.
    pub(crate) size: (usize, usize),
}

/// The tiles of one block of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct BlockTiles {
    /// Column and row of the block; blocks are ordered row by row.
    pub(crate) place: (u16, u16),
    /// Bit `4 y + x`: whether the block has the tile in column `x`, row `y`.
    pub(crate) tiles: u16,
    /// Index of each tile in its image.
    index: [u32; TILES * TILES],
}

impl BlockTiles {
    /// The tiles that there are: where each is inside the block, and its index in the image.
    pub(super) fn each(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        let there = self.index.iter().enumerate().filter(|(_, index)| **index != u32::MAX);
        there.map(|(inside, index)| (inside, *index as usize))
    }

    /// Column and row in the block of a tile's first pixel.
    pub(super) fn corner(inside: usize) -> (usize, usize) {
        (inside % TILES * TILE, inside / TILES * TILE)
    }
}

/// One block of an image, with its samples.
#[derive(Clone, Copy)]
pub(crate) struct ImageBlock<'a> {
    pub(crate) image: &'a SampleImage,
    pub(crate) tiles: &'a BlockTiles,
}

/// Working memory of one thread.
#[derive(Default)]
pub(crate) struct CodingScratch {
    traversal: BlockTraversal,
    pixels: BlockPixels,
    reference: BlockPixels,
}

impl CodingScratch {
    /// Runs `work` with this thread's scratch memory. `work` must not wait for other threads' work.
    pub(crate) fn with<R>(work: impl FnOnce(&mut Self) -> R) -> R {
        thread_local! {
            static SCRATCH: std::cell::RefCell<CodingScratch> = std::cell::RefCell::default();
        }
        SCRATCH.with_borrow_mut(work)
    }
}

/// The blocks of an image that hold a sample, row by row.
pub(crate) fn blocks_of(image: &SampleImage) -> Vec<BlockTiles> {
    let place = |tile: &SampleTile| (tile.tile_y / TILES as u16, tile.tile_x / TILES as u16);
    let mut order: Vec<u32> = (0..image.tiles.len() as u32).collect();
    order.sort_by_key(|index| place(&image.tiles[*index as usize]));
    let mut blocks: Vec<BlockTiles> = Vec::new();
    for index in order {
        let tile = &image.tiles[index as usize];
        let (y, x) = place(tile);
        if blocks.last().is_none_or(|block| block.place != (x, y)) {
            blocks.push(BlockTiles { place: (x, y), tiles: 0, index: [u32::MAX; TILES * TILES] });
        }
        let inside = tile.tile_y as usize % TILES * TILES + tile.tile_x as usize % TILES;
        if let Some(block) = blocks.last_mut() {
            block.tiles |= 1 << inside;
            block.index[inside] = index;
        }
    }
    blocks
}

/// The block at `place`, among those of an image.
pub(crate) fn find<'a>(
    image: &'a SampleImage,
    blocks: &'a [BlockTiles],
    place: (u16, u16),
) -> Option<ImageBlock<'a>> {
    let order = |block: &BlockTiles| (block.place.1, block.place.0);
    let index = blocks.binary_search_by_key(&(place.1, place.0), order).ok()?;
    Some(ImageBlock { image, tiles: &blocks[index] })
}

/// Samples in a block, and the bits of its smallest and largest inverse depth.
pub(crate) fn summary(image: &SampleImage, block: &BlockTiles) -> (usize, u32, u32) {
    block.index.iter().filter(|index| **index != u32::MAX).fold(
        (0, u32::MAX, 0),
        |(count, low, high), &index| {
            let depths = image.depth.tiles()[index as usize];
            let samples = image.tiles[index as usize].count();
            (count + samples, low.min(depths.farthest), high.max(depths.nearest))
        },
    )
}

impl BlockCoding<'_> {
    fn shape(&self, place: (u16, u16), tiles: u16) -> BlockShape {
        let (left, top) = (place.0 as usize * BLOCK, place.1 as usize * BLOCK);
        BlockShape {
            width: self.size.0.saturating_sub(left).min(BLOCK),
            height: self.size.1.saturating_sub(top).min(BLOCK),
            tiles,
            depth_shift: self.depth_shift,
            colors: self.palette.len(),
            normals: self.normals,
        }
    }

    /// Puts the samples of a block where a traversal finds them.
    fn spread(&self, ImageBlock { image, tiles }: ImageBlock<'_>, pixels: &mut BlockPixels) {
        pixels.clear();
        let mut depths = [0.0; TILE_SAMPLES];
        for (inside, &index) in tiles.index.iter().enumerate().filter(|(_, index)| **index != u32::MAX) {
            let tile = &image.tiles[index as usize];
            let count = tile.count();
            image.depth.tile(index as usize, tile.first, count).unpack(&mut depths);
            let mut nth = 0;
            for (row, &mask) in tile.rows.iter().enumerate() {
                let (left, y) = (inside % TILES * TILE, inside / TILES * TILE + row);
                pixels.rows[y] |= u64::from(mask) << left;
                for column in columns(mask) {
                    let at = cell(left + column, y);
                    let sample = tile.first as usize + nth;
                    let [red, green, blue] = image.color[sample].map(|half| self.palette.rank(half));
                    let depth = (depths[nth].to_bits() >> self.depth_shift) as i32;
                    let normal = image.normal.as_ref().map_or([0; 2], |normals| normals[sample].0);
                    let numbers = [depth, green, red, blue, i32::from(normal[0]), i32::from(normal[1])];
                    let used = if self.normals { 6 } else { 4 };
                    for (values, number) in pixels.values.iter_mut().zip(numbers).take(used) {
                        values[at] = number;
                    }
                    nth += 1;
                }
            }
        }
    }

    /// Counts the tokens of a block.
    pub(crate) fn count(
        &self,
        block: ImageBlock<'_>,
        reference: Option<ImageBlock<'_>>,
        counts: &mut Counts,
    ) {
        CodingScratch::with(|scratch| self.traverse(&mut TokenCounter(counts), scratch, block, reference));
    }

    /// The code of a block.
    pub(crate) fn encode(&self, block: ImageBlock<'_>, reference: Option<ImageBlock<'_>>) -> Vec<u8> {
        CodingScratch::with(|scratch| {
            if self.plain {
                let mut writer = PlainWriter::default();
                self.traverse(&mut writer, scratch, block, reference);
                writer.finish()
            } else {
                let mut writer = ModelWriter::new(self.model);
                self.traverse(&mut writer, scratch, block, reference);
                writer.finish()
            }
        })
    }

    fn traverse<C: Coder>(
        &self,
        coder: &mut C,
        scratch: &mut CodingScratch,
        block: ImageBlock<'_>,
        reference: Option<ImageBlock<'_>>,
    ) {
        self.spread(block, &mut scratch.pixels);
        let reference = reference.map(|block| {
            self.spread(block, &mut scratch.reference);
            &scratch.reference
        });
        let shape = self.shape(block.tiles.place, block.tiles.tiles);
        scratch.traversal.traverse(coder, &shape, &mut scratch.pixels, reference);
    }

    /// Decodes the samples of a block of an image, alone; only the camera and span of `image` are read.
    pub(crate) fn decode(
        &self,
        image: &SampleImage,
        place: (u16, u16),
        tiles: u16,
        code: &[u8],
        reference: Option<ImageBlock<'_>>,
    ) -> Result<SampleImage, String> {
        CodingScratch::with(|scratch| {
            scratch.pixels.clear();
            let reference = reference.map(|block| {
                self.spread(block, &mut scratch.reference);
                &scratch.reference
            });
            let shape = self.shape(place, tiles);
            let (traversal, pixels) = (&mut scratch.traversal, &mut scratch.pixels);
            let whole = if self.plain {
                let mut reader = PlainReader::new(code);
                traversal.traverse(&mut reader, &shape, pixels, reference);
                reader.is_whole()
            } else {
                let reader = ModelReader::new(self.model, code).ok_or("its code is cut short")?;
                simd::run(Decoding { reader, traversal, shape: &shape, pixels, reference })
            };
            if !whole {
                return Err("its code does not end where it should".to_owned());
            }
            self.gather(image, place, tiles, pixels)
        })
    }

    /// Takes the samples of a block from where a traversal left them.
    fn gather(
        &self,
        image: &SampleImage,
        place: (u16, u16),
        tiles: u16,
        pixels: &BlockPixels,
    ) -> Result<SampleImage, String> {
        let count = pixels.rows.iter().map(|row| row.count_ones() as usize).sum();
        let mut samples = with_capacity(image, tiles.count_ones() as usize, count, self.normals);
        let mut depths = [0.0; TILE_SAMPLES];
        for inside in (0..TILES * TILES).filter(|inside| tiles >> inside & 1 == 1) {
            let (left, top) = (inside % TILES * TILE, inside / TILES * TILE);
            let rows = std::array::from_fn(|row| (pixels.rows[top + row] >> left) as u16);
            let tile = SampleTile {
                tile_x: place.0 * TILES as u16 + (inside % TILES) as u16,
                tile_y: place.1 * TILES as u16 + (inside / TILES) as u16,
                first: samples.color.len() as u32,
                rows,
            };
            if tile.rows == [0; TILE] {
                return Err("a tile is empty".to_owned());
            }
            let mut nth = 0;
            let mut largest = 0;
            for (row, &mask) in rows.iter().enumerate() {
                let start = cell(left, top + row);
                for column in columns(mask) {
                    let at = start + column;
                    let color = [2, 1, 3].map(|number: usize| self.palette.color(pixels.values[number][at]));
                    let [Some(red), Some(green), Some(blue)] = color else {
                        return Err("a color is not in the palette".to_owned());
                    };
                    samples.color.push([red, green, blue]);
                    let bits = u64::from(pixels.values[0][at] as u32) << self.depth_shift;
                    largest = bits.max(largest);
                    depths[nth] = f32::from_bits(bits as u32);
                    nth += 1;
                    if let Some(normals) = &mut samples.normal {
                        let normal = [4, 5].map(|number: usize| i8::try_from(pixels.values[number][at]));
                        let [Ok(x), Ok(y)] = normal else {
                            return Err("a normal is out of range".to_owned());
                        };
                        normals.push(OctNormal([x, y]));
                    }
                }
            }
            if largest > u64::from(LARGEST_DEPTH) {
                return Err("an inverse depth is negative or not finite".to_owned());
            }
            samples.depth.push_tile(&depths[..nth]);
            samples.tiles.push(tile);
        }
        Ok(samples)
    }
}

/// Reading one block's code, the store's hottest loop.
struct Decoding<'a> {
    reader: ModelReader<'a>,
    traversal: &'a mut BlockTraversal,
    shape: &'a BlockShape,
    pixels: &'a mut BlockPixels,
    reference: Option<&'a BlockPixels>,
}

impl simd::VectorLoop for Decoding<'_> {
    /// Whether the code was whole.
    type Output = bool;

    #[inline(always)]
    fn run(mut self) -> bool {
        self.traversal.traverse(&mut self.reader, self.shape, self.pixels, self.reference);
        self.reader.is_whole()
    }
}

/// Columns of the set bits of a mask.
pub(super) fn columns(mut mask: u16) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        (mask != 0).then(|| {
            let column = mask.trailing_zeros() as usize;
            mask &= mask - 1;
            column
        })
    })
}

/// An image of the camera and span of another, with room for samples.
fn with_capacity(like: &SampleImage, tiles: usize, samples: usize, normals: bool) -> SampleImage {
    SampleImage {
        camera: like.camera,
        span: like.span,
        tiles: Vec::with_capacity(tiles),
        color: Vec::with_capacity(samples),
        depth: DepthPlane::with_capacity(tiles, samples),
        normal: normals.then(|| Vec::with_capacity(samples)),
        doubtful: Vec::new(),
        values: crate::capture::Values::default(),
    }
}

/// Bits of the smallest and the largest inverse depth of some samples.
pub(crate) fn depth_bounds(samples: &SampleImage) -> (u32, u32) {
    samples.depth.tiles().iter().fold((u32::MAX, 0), |(farthest, nearest), tile| {
        (farthest.min(tile.farthest), nearest.max(tile.nearest))
    })
}

/// Puts blocks together, tiles in their order, with those that an image of the same camera and span has already. Which samples are
/// doubtful is elsewhere in the file, see [`super::doubtful`].
pub(crate) fn assemble(image: &SampleImage, normals: bool, blocks: &[SampleImage]) -> SampleImage {
    let parts = std::iter::once(image).chain(blocks);
    let count = parts.clone().map(SampleImage::len).sum();
    let mut order: Vec<(&SampleTile, usize, &SampleImage)> = parts
        .flat_map(|part| part.tiles.iter().enumerate().map(move |(index, tile)| (tile, index, part)))
        .collect();
    order.sort_unstable_by_key(|(tile, ..)| (tile.tile_y, tile.tile_x));
    let mut all = with_capacity(image, order.len(), count, normals);
    for (tile, index, part) in order {
        let samples = tile.first as usize..tile.first as usize + tile.count();
        all.tiles.push(SampleTile { first: all.color.len() as u32, ..*tile });
        all.color.extend_from_slice(&part.color[samples.clone()]);
        all.depth.push_packed(&part.depth.tile(index, tile.first, samples.len()));
        if let (Some(all), Some(normal)) = (&mut all.normal, &part.normal) {
            all.extend_from_slice(&normal[samples.clone()]);
        }
        all.values.extend_part(part.values.channels(), part.values.part(samples));
    }
    all
}
