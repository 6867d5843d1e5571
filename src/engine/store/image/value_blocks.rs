//! The scalar values of an image as the payload of their chunk, and back. FORMAT.md lists its bytes.
//!
//! ```text
//! for each block of the image: bytes of its code, checksum         then the codes, one after another
//! ```

use super::blocks::{BlockTiles, ImageBlock, blocks_of, columns, find};
use crate::capture::Values;
use crate::samples::{SampleImage, TILE, TILE_SAMPLES};
use crate::store::codec::{
    BLOCK, ChannelCoding, PlaneModel, ValueCounter, ValueCounts, ValuePixels, ValueReader, ValueWriter, cell,
    traverse_values,
};
use crate::store::container::{ByteReader, agree, push_varint};

/// How the values of all images are coded.
#[derive(Clone, Debug)]
pub(crate) struct ValueCoding {
    pub(crate) channels: Vec<ChannelCoding>,
    pub(crate) tables: Vec<PlaneModel>,
    /// Whether numbers come as they are.
    pub(crate) plain: bool,
}

/// Where the samples of a block are, in the order of their image: index, cell, row and column of each.
fn places(block: ImageBlock<'_>) -> impl Iterator<Item = (usize, usize, usize, usize)> + '_ {
    block.tiles.each().flat_map(move |(inside, index)| {
        let tile = &block.image.tiles[index];
        let (left, top) = BlockTiles::corner(inside);
        let mut sample = tile.first as usize;
        (0..TILE).flat_map(move |row| {
            let first = sample;
            sample += tile.rows[row].count_ones() as usize;
            columns(tile.rows[row]).enumerate().map(move |(nth, column)| {
                let (x, y) = (left + column, top + row);
                (first + nth, cell(x, y), y, x)
            })
        })
    })
}

/// The samples of a block, with the numbers of their values where the image has some.
fn pixels_of(block: ImageBlock<'_>, channels: &[ChannelCoding]) -> ValuePixels {
    let mut pixels = ValuePixels::new(channels.len());
    let mut depths = [0.0; TILE_SAMPLES];
    let mut next = block.tiles.each().map(|(_, index)| index);
    let mut tile_end = 0;
    let mut tile_first = 0;
    for (sample, at, y, x) in places(block) {
        if sample >= tile_end {
            let Some(index) = next.next() else { break };
            let tile = &block.image.tiles[index];
            (tile_first, tile_end) = (tile.first as usize, tile.first as usize + tile.count());
            block.image.depth.tile(index, tile.first, tile.count()).unpack(&mut depths);
        }
        pixels.rows[y] |= 1 << x;
        pixels.inverse_depths[at] = depths[sample - tile_first];
        if block.image.values.channels() == channels.len() {
            for (codes, (value, channel)) in
                pixels.codes.iter_mut().zip(block.image.values.of(sample).iter().zip(channels))
            {
                codes[at] = channel.scale.code(*value);
            }
        }
    }
    pixels
}

/// Counts the tokens of an image's values.
pub(crate) fn count_values(
    image: &SampleImage,
    reference: Option<&SampleImage>,
    channels: &[ChannelCoding],
    counts: &mut ValueCounts,
) {
    let before = reference.map(|reference| (reference, blocks_of(reference)));
    for tiles in &blocks_of(image) {
        let before = before.as_ref().and_then(|(image, blocks)| find(image, blocks, tiles.place));
        let before = before.map(|block| pixels_of(block, channels));
        let mut pixels = pixels_of(ImageBlock { image, tiles }, channels);
        traverse_values(&mut ValueCounter(counts), channels, &mut pixels, before.as_ref());
    }
}

/// The payload of an image's values.
pub(crate) fn encode_values(
    image: &SampleImage,
    reference: Option<&SampleImage>,
    coding: &ValueCoding,
) -> Vec<u8> {
    let before = reference.map(|reference| (reference, blocks_of(reference)));
    let (mut payload, mut codes) = (Vec::new(), Vec::new());
    for tiles in &blocks_of(image) {
        let before = before.as_ref().and_then(|(image, blocks)| find(image, blocks, tiles.place));
        let code = coding.encode(ImageBlock { image, tiles }, before);
        push_varint(&mut payload, code.len() as u64);
        payload.extend(crc32fast::hash(&code).to_be_bytes());
        codes.extend(code);
    }
    payload.extend(codes);
    payload
}

impl ValueCoding {
    fn encode(&self, block: ImageBlock<'_>, before: Option<ImageBlock<'_>>) -> Vec<u8> {
        let mut pixels = pixels_of(block, &self.channels);
        if self.plain {
            let numbers = |codes: &Vec<i32>| -> Vec<u8> {
                held(&pixels).flat_map(|at| codes[at].to_be_bytes()).collect()
            };
            return pixels.codes.iter().flat_map(numbers).collect();
        }
        let before = before.map(|block| pixels_of(block, &self.channels));
        let mut writer = ValueWriter::new(&self.tables);
        traverse_values(&mut writer, &self.channels, &mut pixels, before.as_ref());
        writer.finish()
    }

    /// The values of the samples of a block, which are an image by themselves, predicted from the same block of the reference.
    ///
    /// # Errors
    /// Where the code is damaged.
    pub(crate) fn decode(
        &self,
        samples: &SampleImage,
        code: &[u8],
        before: Option<ImageBlock<'_>>,
    ) -> Result<Values, String> {
        let blocks = blocks_of(samples);
        let tiles = blocks.first().ok_or("there are no samples")?;
        let block = ImageBlock { image: samples, tiles };
        let mut pixels = pixels_of(block, &self.channels);
        if self.plain {
            let mut reader = ByteReader::new(code);
            let at: Vec<usize> = held(&pixels).collect();
            for codes in &mut pixels.codes {
                at.iter().try_for_each(|at| reader.u32().map(|code| codes[*at] = code as i32))?;
            }
            reader.finish()?;
        } else {
            let before = before.map(|block| pixels_of(block, &self.channels));
            let mut reader =
                ValueReader::new(&self.tables, code).ok_or("the code of its values is cut short")?;
            traverse_values(&mut reader, &self.channels, &mut pixels, before.as_ref());
            if !reader.is_whole() {
                return Err("the code of its values does not end where it should".to_owned());
            }
        }
        let mut planes: Vec<Vec<f32>> = self.channels.iter().map(|_| vec![0.0; samples.len()]).collect();
        for (sample, at, ..) in places(block) {
            for ((plane, codes), channel) in planes.iter_mut().zip(&pixels.codes).zip(&self.channels) {
                plane[sample] = channel.scale.value(codes[at]);
            }
        }
        Ok(Values::from_planes(&planes))
    }
}

/// The cells that hold a sample, row by row.
fn held(pixels: &ValuePixels) -> impl Iterator<Item = usize> + '_ {
    pixels
        .rows
        .iter()
        .enumerate()
        .flat_map(|(y, row)| (0..BLOCK).filter(move |x| row >> x & 1 == 1).map(move |x| cell(x, y)))
}

/// How the values of an image are coded, and their codes, or why there are none.
pub(crate) struct ImageValues<'a> {
    pub(crate) coding: &'a ValueCoding,
    pub(crate) codes: Result<ValueCodes<'a>, String>,
}

/// The codes of the values of an image's blocks.
#[derive(Clone, Debug)]
pub(crate) struct ValueCodes<'a> {
    codes: Vec<(&'a [u8], [u8; 4])>,
}

impl<'a> ValueCodes<'a> {
    /// From the payload of an image with so many blocks.
    ///
    /// # Errors
    /// Where the payload does not hold one code a block.
    pub(crate) fn of(payload: &'a [u8], blocks: usize) -> Result<Self, String> {
        let mut reader = ByteReader::new(payload);
        let mut heads = Vec::new();
        for _ in 0..blocks {
            heads.push((reader.varint()? as usize, reader.u32()?.to_be_bytes()));
        }
        let mut take = |(length, checksum)| Ok::<_, String>((reader.take(length)?, checksum));
        let codes = heads.into_iter().map(&mut take).collect::<Result<_, _>>()?;
        reader.finish()?;
        Ok(Self { codes })
    }

    /// The code of a block, by its place in the head of the image.
    ///
    /// # Errors
    /// Where its checksum differs.
    pub(crate) fn of_block(&self, nth: usize) -> Result<&'a [u8], String> {
        let (code, stated) = self.codes.get(nth).ok_or("there are no values of it")?;
        if agree(stated, crc32fast::hash(code)) { Ok(code) } else { Err("its values are damaged".to_owned()) }
    }
}
