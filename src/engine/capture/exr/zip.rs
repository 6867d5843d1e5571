//! Undoes OpenEXR's ZIP compression. Nearly every renderer writes it, and undoing it is most of the time of reading a frame.
//!
//! Source: OpenEXR, `ImfZip.cpp`. A block of rows is deflated. Inflating gives differences of successive bytes, each 128 too large.
//! They add up to bytes; the first half belongs at even positions and the second at odd ones, so that the high bytes of half floats
//! are together. What differs from the `exr` crate, which reads every other compression and everything around blocks: `libdeflate`
//! inflates, as in OpenEXR itself, and bytes are added up and put in place 64 at a time.

use exr::block::chunk::Chunk;
use exr::block::{BlockIndex, UncompressedBlock};
use exr::compression::Compression;
use exr::error::{Error, Result};
use exr::meta::MetaData;
use exr::meta::header::Header;
use libdeflater::Decompressor;

use super::decoder_guard::packed_bytes;
use crate::simd::{self, VectorLoop};

/// Makes pixels of the blocks of one file.
pub(super) struct Inflater {
    decompressor: Decompressor,
    /// What was inflated last.
    bytes: Vec<u8>,
}

impl Inflater {
    pub(super) fn new() -> Self {
        Self { decompressor: Decompressor::new(), bytes: Vec::new() }
    }

    /// The pixels of a block.
    ///
    /// # Errors
    /// `Invalid` for a damaged block, `NotSupported` for a compression that nothing here reads.
    pub(super) fn pixels(&mut self, chunk: Chunk, meta: &MetaData) -> Result<UncompressedBlock> {
        match self.unzip(&chunk, meta)? {
            Some(block) => Ok(block),
            None => UncompressedBlock::decompress_chunk(chunk, meta, false),
        }
    }

    /// The pixels of a block that ZIP packed; `None` for a block that is stored as it is, or packed otherwise.
    fn unzip(&mut self, chunk: &Chunk, meta: &MetaData) -> Result<Option<UncompressedBlock>> {
        let header = meta.headers.get(chunk.layer_index).filter(|header| is_zipped(header));
        let Some((header, zipped)) = header.zip(packed_bytes(&chunk.compressed_block)) else {
            return Ok(None);
        };
        let place = header.get_block_data_indices(&chunk.compressed_block)?;
        let pixels = header.get_absolute_block_pixel_coordinates(place)?;
        pixels.validate(Some(header.layer_size))?;
        let length = pixels.size.area() * header.channels.bytes_per_pixel;
        if zipped.len() == length {
            return Ok(None);
        }
        self.bytes.resize(length, 0);
        let inflated = self.decompressor.zlib_decompress(zipped, &mut self.bytes);
        if inflated.map_err(|error| Error::Invalid(format!("ZIP block: {error}").into()))? != length {
            return Err(Error::Invalid("ZIP block of another length than its pixels".into()));
        }
        simd::run(AddUp(&mut self.bytes));
        let mut data = vec![0; length];
        simd::run(Interleave { bytes: &self.bytes, to: &mut data });
        let index = BlockIndex {
            layer: chunk.layer_index,
            level: place.level_index,
            pixel_position: pixels.position.to_usize("block position")?,
            pixel_size: pixels.size,
        };
        Ok(Some(UncompressedBlock { index, data }))
    }
}

/// Whether ZIP packed the blocks, in an order of bytes that is read here.
fn is_zipped(header: &Header) -> bool {
    let is_zip = matches!(header.compression, Compression::ZIP1 | Compression::ZIP16);
    is_zip && !header.deep && cfg!(target_endian = "little")
}

/// Bytes that are added up together, in words.
const WORDS: usize = 8;
/// The lowest bytes of the four pairs of a word.
const EVEN: u64 = 0x00ff_00ff_00ff_00ff;

/// Replaces differences by what they add up to.
struct AddUp<'a>(&'a mut [u8]);

impl VectorLoop for AddUp<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        // Adding 128 and taking it away is the same in a byte; the first one has nothing before it.
        let mut before = 0x80_u8;
        let (blocks, rest) = self.0.as_chunks_mut::<{ 8 * WORDS }>();
        for block in blocks {
            let mut words: [u64; WORDS] = bytemuck::cast(*block);
            for word in &mut words {
                *word = sums_within(*word ^ 0x8080_8080_8080_8080);
            }
            let mut befores = [0; WORDS];
            for (word, add) in words.iter().zip(&mut befores) {
                *add = u64::from(before) * 0x0101_0101_0101_0101;
                before = before.wrapping_add((word >> 56) as u8);
            }
            let (words, befores): ([u8; 8 * WORDS], [u8; 8 * WORDS]) =
                (bytemuck::cast(words), bytemuck::cast(befores));
            for i in 0..8 * WORDS {
                block[i] = words[i].wrapping_add(befores[i]);
            }
        }
        for byte in rest {
            before = before.wrapping_add(*byte ^ 0x80);
            *byte = before;
        }
    }
}

/// For each byte of a word, lowest first, the sum of it and all before it.
#[inline(always)]
fn sums_within(word: u64) -> u64 {
    // In lanes of 16 bits nothing runs over: at most eight bytes are added.
    let add_up = |mut lanes: u64| {
        lanes += lanes << 16;
        lanes + (lanes << 32)
    };
    let (even, odd) = (add_up(word & EVEN), add_up(word >> 8 & EVEN));
    ((even + (odd << 16)) & EVEN) | ((even + odd) & EVEN) << 8
}

/// Puts the first half of some bytes at even positions and the second at odd ones.
struct Interleave<'a> {
    bytes: &'a [u8],
    to: &'a mut [u8],
}

impl VectorLoop for Interleave<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (even, odd) = self.bytes.split_at(self.bytes.len().div_ceil(2));
        let (pairs, rest) = self.to.as_chunks_mut::<2>();
        for ((pair, even), odd) in pairs.iter_mut().zip(even).zip(odd) {
            *pair = [*even, *odd];
        }
        if let ([last], Some(even)) = (rest, even.last()) {
            *last = *even;
        }
    }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use exr::block::reader::ChunksReader;
    use exr::image::write::WritableImage;
    use exr::image::{AnyChannel, AnyChannels, Blocks, Encoding, FlatSamples, Image};
    use exr::math::Vec2;
    use half::f16;

    use super::*;

    /// A picture of every kind of number. Some of its blocks do not get shorter, and are stored as they are.
    fn picture(compression: Compression, blocks: Blocks) -> Vec<u8> {
        const SIZE: (usize, usize) = (37, 70);
        // Noise in the first half, a ramp in the second.
        let mixed = |i: u32| (i ^ i >> 15).wrapping_mul(0x85eb_ca6b);
        let noise = |i| mixed(mixed(mixed(i)));
        let numbers = |from: u32| {
            (0..(SIZE.0 * SIZE.1) as u32).map(move |i| if i < 1300 { noise(i ^ from << 16) } else { i })
        };
        let channels = [
            ("A", FlatSamples::F16(numbers(3).map(|i| f16::from_bits(i as u16)).collect())),
            ("B", FlatSamples::F32(numbers(5).map(f32::from_bits).collect())),
            ("C", FlatSamples::U32(numbers(7).collect())),
        ];
        let channels = channels.map(|(name, samples)| AnyChannel::new(name, samples));
        let encoding = Encoding { compression, blocks, ..Encoding::UNCOMPRESSED };
        let channels = AnyChannels::sort(channels.into_iter().collect());
        let mut bytes = Cursor::new(Vec::new());
        Image::from_encoded_channels(SIZE, encoding, channels)
            .write()
            .non_parallel()
            .to_buffered(&mut bytes)
            .unwrap();
        bytes.into_inner()
    }

    #[test]
    fn blocks_hold_what_the_exr_crate_reads_from_them() {
        for compression in [Compression::ZIP1, Compression::ZIP16] {
            for blocks in [Blocks::ScanLines, Blocks::Tiles(Vec2(16, 33))] {
                let bytes = picture(compression, blocks);
                let chunks =
                    exr::block::read(Cursor::new(bytes.as_slice()), true).unwrap().all_chunks(true).unwrap();
                let meta = chunks.meta_data().clone();
                let (mut inflater, mut stored, mut inflated) = (Inflater::new(), 0, 0);
                for chunk in chunks.map(std::result::Result::unwrap) {
                    let expected = UncompressedBlock::decompress_chunk(chunk.clone(), &meta, true).unwrap();
                    assert!(is_zipped(&meta.headers[0]));
                    let zipped = packed_bytes(&chunk.compressed_block).unwrap().len();
                    *(if zipped == expected.data.len() { &mut stored } else { &mut inflated }) += 1;
                    let found = inflater.pixels(chunk, &meta).unwrap();
                    assert_eq!((found.index, found.data), (expected.index, expected.data));
                }
                assert!(stored > 0 && inflated > 2, "{stored} stored, {inflated} inflated");
            }
        }
    }

    /// The steps of OpenEXR's `ImfZip.cpp`, one byte after the other.
    fn plainly_undone(bytes: &[u8]) -> Vec<u8> {
        let mut sums = bytes.to_vec();
        for i in 1..sums.len() {
            sums[i] = (i32::from(sums[i - 1]) + i32::from(sums[i]) - 128) as u8;
        }
        let half = sums.len().div_ceil(2);
        (0..sums.len()).map(|i| sums[if i % 2 == 0 { i / 2 } else { half + i / 2 }]).collect()
    }

    #[test]
    fn every_instruction_set_adds_up_and_interleaves_as_openexr_does_whatever_the_length() {
        let mut state = 1_u32;
        let mut noise = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 24) as u8
        };
        for length in (0..200).chain([640, 6400, 102_401]) {
            let bytes: Vec<u8> = (0..length).map(|_| noise()).collect();
            let expected = plainly_undone(&bytes);
            let found = simd::at_every_level(|| {
                let (mut sums, mut data) = (bytes.clone(), vec![0; length]);
                simd::run(AddUp(&mut sums));
                simd::run(Interleave { bytes: &sums, to: &mut data });
                data
            });
            assert!(found.iter().all(|found| *found == expected), "{length} bytes");
        }
    }
}
