//! A sample image as the payload of its chunk, and back.
//!
//! ```text
//! head    which blocks hold samples; of each its tiles, samples, depth bounds, bytes and checksum       checksum
//! blocks  the code of each, one after another
//! ```
//!
//! A block can be read with the head alone (and the reference's block at the same place), and a damaged one is left out.

use rayon::prelude::*;

use super::blocks::{BlockCoding, ImageBlock, assemble, blocks_of, depth_bounds, find, summary};
use super::value_blocks::ImageValues;
use crate::capture::Camera;
use crate::plural::counted;
use crate::samples::{SampleImage, TILE, TileMask};
use crate::store::codec::{BLOCK, Counts};
use crate::store::container::{ByteReader, IMAGE, agree, checksum};

const HAS_NORMALS: u8 = 1;
const IS_PLAIN: u8 = 2;

/// Bytes of a block's entry in the head.
const ENTRY_BYTES: usize = 16;

/// Blocks that are worth handing to another thread.
const BLOCKS_PER_TASK: usize = 4;

/// One block, as the head of its image has it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlockEntry {
    /// Column and row of the block, in blocks of 64 pixels.
    pub place: (u16, u16),
    /// Bit `4 y + x`: whether the tile in column `x`, row `y` of the block holds a sample.
    pub tiles: u16,
    /// Samples in the block.
    pub samples: u32,
    /// Inverse depths of the block are between these.
    pub inverse_depth: (f32, f32),
    /// Bytes from the start of the payload to the block's code.
    pub(crate) start: usize,
    /// Bytes of the code.
    pub(crate) length: usize,
    checksum: [u8; 4],
}

/// What the payload of an image holds before its samples.
#[derive(Clone, Debug, PartialEq)]
pub struct ImageHead {
    /// Blocks that hold a sample, row by row.
    pub blocks: Vec<BlockEntry>,
    pub(crate) normals: bool,
    pub(crate) plain: bool,
    pub(crate) depth_shift: u32,
    /// Bytes of the head, checksum included.
    pub(crate) bytes: usize,
}

/// A block that could not be read.
#[derive(Clone, Debug)]
pub(crate) struct Damage {
    /// Column and row of the block.
    pub(crate) place: (u16, u16),
    /// Why not.
    pub(crate) what: String,
}

fn block_grid(camera: &Camera) -> (usize, usize) {
    let (width, height) = camera.intrinsics.size();
    (width.div_ceil(BLOCK), height.div_ceil(BLOCK))
}

/// Checks the promises of [`SampleImage`], so that what is written can be read and what was read can be trusted.
pub(crate) fn check(image: &SampleImage, cameras: &[Camera], frames: usize) -> Result<(), String> {
    let camera = cameras.get(image.camera as usize).ok_or_else(|| format!("no camera {}", image.camera))?;
    if image.span.start >= image.span.end || image.span.end as usize > frames {
        return Err(format!("no frames {} to {}", image.span.start, image.span.end));
    }
    let (width, height) = camera.intrinsics.size();
    let mut first = 0;
    let mut last_place = None;
    for tile in &image.tiles {
        let place = Some((tile.tile_y, tile.tile_x));
        let (left, top) = (tile.tile_x as usize * TILE, tile.tile_y as usize * TILE);
        if place <= last_place || left >= width || top >= height {
            return Err("a tile is out of order or outside the picture".to_owned());
        }
        let beyond_right = |row: &u16| (width - left) < TILE && row >> (width - left) != 0;
        let beyond_bottom = tile.rows.iter().skip(height - top).any(|row| *row != 0);
        if tile.rows.iter().any(beyond_right) || beyond_bottom {
            return Err("a sample is outside the picture".to_owned());
        }
        if tile.first as usize != first || tile.count() == 0 {
            return Err("a tile is empty or its samples are out of order".to_owned());
        }
        first += tile.count();
        last_place = place;
    }
    let normals = image.normal.as_ref().map_or(first, Vec::len);
    if image.values.channels() > 0 && image.values.len() != first {
        return Err("the scalar values are not one a channel and sample".to_owned());
    }
    if [image.color.len(), normals] != [first; 2] || !image.depth.fits(&image.tiles) {
        return Err("the planes do not have one value per sample".to_owned());
    }
    let is_among = |mask: &TileMask| {
        let tile = image.tiles.get(mask.tile as usize);
        mask.rows != [0; TILE]
            && tile
                .is_some_and(|tile| mask.rows.iter().zip(&tile.rows).all(|(mask, there)| mask & !there == 0))
    };
    if !image.doubtful.is_sorted_by_key(|mask| mask.tile) || !image.doubtful.iter().all(is_among) {
        return Err("a mask of doubtful samples does not fit its tile".to_owned());
    }
    if image.inverse_depths().iter().any(|w| !w.is_finite() || w.is_sign_negative()) {
        return Err("an inverse depth is negative or not finite".to_owned());
    }
    if image.color.iter().flatten().any(|value| !value.is_finite()) {
        return Err("a color is not finite".to_owned());
    }
    Ok(())
}

/// Counts the tokens of an image.
pub(crate) fn count(
    image: &SampleImage,
    reference: Option<&SampleImage>,
    coding: &BlockCoding,
    counts: &mut Counts,
) {
    let before = reference.map(|reference| (reference, blocks_of(reference)));
    for tiles in &blocks_of(image) {
        let before = before.as_ref().and_then(|(image, blocks)| find(image, blocks, tiles.place));
        coding.count(ImageBlock { image, tiles }, before, counts);
    }
}

/// The payload of an image's chunk, and how many of its bytes are its head. The image must have passed [`check`].
pub(crate) fn encode(
    image: &SampleImage,
    reference: Option<&SampleImage>,
    camera: &Camera,
    coding: &BlockCoding,
) -> (Vec<u8>, usize) {
    let blocks = blocks_of(image);
    let before = reference.map(|reference| (reference, blocks_of(reference)));
    let codes: Vec<Vec<u8>> = blocks
        .iter()
        .map(|tiles| {
            let before = before.as_ref().and_then(|(image, blocks)| find(image, blocks, tiles.place));
            coding.encode(ImageBlock { image, tiles }, before)
        })
        .collect();

    let (across, down) = block_grid(camera);
    let mut occupancy = vec![0_u8; (across * down).div_ceil(8)];
    for block in &blocks {
        let place = block.place.1 as usize * across + block.place.0 as usize;
        occupancy[place / 8] |= 0x80 >> (place % 8);
    }
    let flags =
        if image.normal.is_some() { HAS_NORMALS } else { 0 } | if coding.plain { IS_PLAIN } else { 0 };
    let mut payload = vec![flags, coding.depth_shift as u8];
    payload.extend(occupancy);
    for (block, code) in blocks.iter().zip(&codes) {
        let (samples, farthest, nearest) = summary(image, block);
        payload.extend(block.tiles.to_be_bytes());
        payload.extend((samples as u16 - 1).to_be_bytes());
        // Halves of the bits, rounded outwards.
        payload.extend(((farthest >> 16) as u16).to_be_bytes());
        payload.extend((nearest.div_ceil(1 << 16) as u16).to_be_bytes());
        payload.extend((code.len() as u32).to_be_bytes());
        payload.extend(crc32fast::hash(code).to_be_bytes());
    }
    payload.extend(checksum(IMAGE, &payload).to_be_bytes());
    let head = payload.len();
    payload.extend(codes.iter().flatten());
    (payload, head)
}

/// Reads a head; `length` is that of the whole payload.
pub(crate) fn decode_head(head: &[u8], length: usize, camera: &Camera) -> Result<ImageHead, String> {
    let Some((checked, stated)) = head.split_last_chunk::<4>() else {
        return Err("it is cut short".to_owned());
    };
    if !agree(stated, checksum(IMAGE, checked)) {
        return Err("its head is damaged".to_owned());
    }
    let mut reader = ByteReader::new(checked);
    let (flags, depth_shift) = (reader.u8()?, u32::from(reader.u8()?));
    if flags & !(HAS_NORMALS | IS_PLAIN) != 0 || depth_shift > 23 {
        return Err(format!("unknown flags {flags}, {depth_shift}; a newer Overlook may read it"));
    }
    let (across, down) = block_grid(camera);
    let occupancy = reader.take((across * down).div_ceil(8))?;
    let places = (0..occupancy.len() * 8).filter(|place| occupancy[place / 8] & (0x80 >> (place % 8)) != 0);
    let mut start = head.len();
    let mut blocks = Vec::with_capacity(reader.rest.len() / ENTRY_BYTES);
    for place in places {
        if place >= across * down {
            return Err("a block is outside the picture".to_owned());
        }
        let (tiles, samples) = (reader.u16()?, u32::from(reader.u16()?) + 1);
        let bounds = [reader.u16()?, reader.u16()?].map(|half| f32::from_bits(u32::from(half) << 16));
        let (code_length, checksum) = (reader.u32()? as usize, reader.u32()?.to_be_bytes());
        blocks.push(BlockEntry {
            place: ((place % across) as u16, (place / across) as u16),
            tiles,
            samples,
            inverse_depth: (bounds[0], bounds[1]),
            start,
            length: code_length,
            checksum,
        });
        start = start.saturating_add(code_length);
    }
    reader.finish()?;
    if start != length {
        return Err(format!("its blocks take {}, not {length}", counted(start, "byte")));
    }
    Ok(ImageHead {
        blocks,
        normals: flags & HAS_NORMALS != 0,
        plain: flags & IS_PLAIN != 0,
        depth_shift,
        bytes: head.len(),
    })
}

/// The image that another is predicted from.
pub(crate) struct ReferenceImage<'a> {
    pub(crate) image: &'a SampleImage,
    /// Its blocks that could not be read.
    pub(crate) damage: &'a [Damage],
}

/// Reads some blocks of an image and adds them to what was read before. `code` gives the code of a block; `values` say how scalar values
/// are coded, and their codes.
///
/// Blocks that are damaged, or whose reference is, are left out and reported.
pub(crate) fn decode<'a>(
    image: &SampleImage,
    head: &ImageHead,
    reference: Option<ReferenceImage>,
    coding: &BlockCoding,
    values: Option<&ImageValues<'_>>,
    code: impl Fn(&BlockEntry) -> Result<&'a [u8], String> + Sync,
    blocks: &[&BlockEntry],
) -> (SampleImage, Vec<Damage>) {
    let before = reference.map(|ReferenceImage { image, damage }| (image, blocks_of(image), damage));
    let read = |block: &BlockEntry| -> Result<SampleImage, String> {
        let before = match &before {
            Some((_, _, damage)) if damage.iter().any(|damaged| damaged.place == block.place) => {
                return Err("the block it is predicted from is damaged".to_owned());
            }
            Some((image, blocks, _)) => find(image, blocks, block.place),
            None => None,
        };
        let code = code(block)?;
        if !agree(&block.checksum, crc32fast::hash(code)) {
            return Err("its bytes are damaged".to_owned());
        }
        let mut samples = coding.decode(image, block.place, block.tiles, code, before)?;
        let (farthest, nearest) = depth_bounds(&samples);
        let (least, most) = (block.inverse_depth.0.to_bits(), block.inverse_depth.1.to_bits());
        if samples.color.len() != block.samples as usize || farthest < least || nearest > most {
            return Err("its contents differ from its image's head".to_owned());
        }
        if let Some(ImageValues { coding, codes }) = values {
            let nth = head.blocks.iter().position(|other| other.place == block.place).unwrap_or(usize::MAX);
            samples.values =
                coding.decode(&samples, codes.as_ref().map_err(String::clone)?.of_block(nth)?, before)?;
        }
        Ok(samples)
    };
    let read: Vec<_> =
        blocks.par_iter().with_min_len(BLOCKS_PER_TASK).map(|block| (block.place, read(block))).collect();
    let mut damage = Vec::new();
    let mut samples = Vec::with_capacity(read.len());
    for (place, block) in read {
        match block {
            Ok(block) => samples.push(block),
            Err(what) => damage.push(Damage { place, what }),
        }
    }
    (assemble(image, head.normals, &samples), damage)
}
