//! The chunk `VERD`: what became of every pixel that had a sample, by camera and span. FORMAT.md lists its bytes.
//!
//! ```text
//! for each camera and span: which blocks hold a sample; of each its tiles, bytes and checksum; checksum; then their codes
//! tables of the two channels; for each camera and span where its bytes are                          checksum, length
//! ```
//!
//! All places count from the start of the payload, so that whoever does not know the chunk may copy it.

use std::io::{Seek, Write};
use std::ops::Range;

use rayon::prelude::*;

use crate::capture::Camera;
use crate::error::{Error, Result};
use crate::job::Job;
use crate::plural::counted;
use crate::samples::{Span, SpanVerdicts, VerdictBuffer};
use crate::store::codec::{
    BLOCK, BlockVerdicts, PlaneModel, VALUE_CONTEXTS, VALUE_TOKENS, VERDICT_CHANNELS, ValueCounter,
    ValueCounts, ValueReader, ValueWriter, traverse_verdicts,
};
use crate::store::container::{
    ByteReader, CHECKSUM, FormWriter, IffError, VERDICTS, agree, checksum, push_varint,
};

/// Spans that are coded at a time: enough for every thread, few enough to be held in memory.
const BATCH: usize = 64;
/// Bytes of a span in the table.
const ENTRY_BYTES: usize = 4 + 4 + 4 + 8 + 4;
/// A chunk of more bytes is not begun: none may have 4 GiB.
const MOST_BYTES: f64 = 4.0e9;

/// Where the verdicts of a camera and span are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct VerdictEntry {
    pub(crate) camera: u32,
    pub(crate) span: Span,
    /// Bytes from the start of the payload.
    offset: u64,
    length: u32,
}

impl VerdictEntry {
    /// The bytes of the payload that it takes.
    pub(crate) fn range(&self) -> Range<u64> {
        self.offset..self.offset + u64::from(self.length)
    }
}

/// What the chunk holds beside the verdicts.
#[derive(Debug)]
pub(crate) struct VerdictTable {
    tables: Vec<PlaneModel>,
    /// In the order of images.
    pub(crate) entries: Vec<VerdictEntry>,
}

/// The rows and columns of a camera's blocks.
fn block_grid((width, height): (usize, usize)) -> (usize, usize) {
    (width.div_ceil(BLOCK), height.div_ceil(BLOCK))
}

/// Columns and rows of the picture from a block on.
fn rest_at((across, _): (usize, usize), (width, height): (usize, usize), place: usize) -> (usize, usize) {
    (width - place % across * BLOCK, height - place / across * BLOCK)
}

/// Visits the blocks of a camera and span that hold a sample, in their order.
fn each_block(
    verdicts: &SpanVerdicts,
    size: (usize, usize),
    mut visit: impl FnMut(usize, &mut BlockVerdicts) -> std::result::Result<(), String>,
) -> std::result::Result<(), String> {
    let (width, height) = size;
    let grid = block_grid(size);
    let mut of_block: Vec<Vec<u32>> = vec![Vec::new(); grid.0 * grid.1];
    for (index, &pixel) in verdicts.pixels.iter().enumerate() {
        let (x, y) = (pixel as usize % width, pixel as usize / width);
        if y >= height {
            return Err("a verdict lies outside the picture".to_owned());
        }
        of_block[y / BLOCK * grid.0 + x / BLOCK].push(index as u32);
    }
    let mut block = BlockVerdicts::new();
    for (place, indices) in of_block.iter().enumerate().filter(|(_, indices)| !indices.is_empty()) {
        block.clear();
        for &index in indices {
            let index = index as usize;
            let pixel = verdicts.pixels[index] as usize;
            block.set(
                pixel % width % BLOCK,
                pixel / width % BLOCK,
                (verdicts.rules[index], verdicts.witnesses[index]),
            );
        }
        visit(place, &mut block)?;
    }
    Ok(())
}

impl VerdictTable {
    /// Writes the chunk; nothing where it would take more than about `most_bytes`, or be too large for one.
    ///
    /// # Errors
    /// `Io`; `Invalid` where a verdict is none of a camera's pixel; `Cancelled`.
    pub(crate) fn write<W: Write + Seek>(
        form: &mut FormWriter<W>,
        verdicts: &VerdictBuffer,
        cameras: &[Camera],
        most_bytes: f64,
        job: &Job,
        iff: impl Fn(IffError) -> Error,
    ) -> Result<()> {
        let counted = (0..verdicts.len()).into_par_iter().try_fold(
            || ValueCounts::new(VERDICT_CHANNELS),
            |mut counts, index| {
                job.check()?;
                let of_span = verdicts.get(index)?;
                let size = size_of_camera(cameras, &of_span)?;
                let count = |place, block: &mut BlockVerdicts| {
                    let rest = rest_at(block_grid(size), size, place);
                    traverse_verdicts(&mut ValueCounter(&mut counts), block, rest, cameras.len())
                };
                each_block(&of_span, size, count).map_err(invalid)?;
                Ok(counts)
            },
        );
        let none = || ValueCounts::new(VERDICT_CHANNELS);
        let counted = counted.try_reduce(none, |a, b| Ok::<_, Error>(a.plus(&b)))?;
        let tables = counted.0.iter().map(|counts| PlaneModel::fit(counts));
        let tables = tables.collect::<std::result::Result<Vec<_>, _>>().map_err(invalid)?;
        let bits: f64 = tables.iter().zip(&counted.0).map(|(table, counts)| table.bits(counts)).sum();
        let bytes = bits / 8.0 + (verdicts.len() * ENTRY_BYTES) as f64;
        if bytes > most_bytes.min(MOST_BYTES) {
            return Ok(());
        }
        let mut table = Self { tables, entries: Vec::new() };
        let chunk = form.begin(VERDICTS).map_err(&iff)?;
        let mut offset = 0;
        for start in (0..verdicts.len()).step_by(BATCH) {
            let encode = |index| {
                job.check()?;
                let of_span = verdicts.get(index)?;
                let code = table.encode_span(&of_span, size_of_camera(cameras, &of_span)?, cameras.len());
                Ok((of_span.camera, of_span.span, code.map_err(invalid)?))
            };
            let batch = (start..verdicts.len().min(start + BATCH)).into_par_iter().map(encode);
            for (camera, span, code) in batch.collect::<Result<Vec<_>>>()? {
                form.append(&code).map_err(&iff)?;
                let length = code.len() as u32;
                table.entries.push(VerdictEntry { camera, span, offset, length });
                offset += u64::from(length);
            }
        }
        form.append(&table.encode()).map_err(&iff)?;
        form.end(chunk).map_err(&iff)
    }

    /// The bytes of a camera and span.
    fn encode_span(
        &self,
        verdicts: &SpanVerdicts,
        size: (usize, usize),
        cameras: usize,
    ) -> std::result::Result<Vec<u8>, String> {
        let grid = block_grid(size);
        let mut head = vec![0; (grid.0 * grid.1).div_ceil(8)];
        let mut codes = Vec::new();
        let mut entries = Vec::new();
        each_block(verdicts, size, |place, block| {
            head[place / 8] |= 0x80 >> (place % 8);
            let mut writer = ValueWriter::new(&self.tables);
            traverse_verdicts(&mut writer, block, rest_at(grid, size, place), cameras)?;
            let code = writer.finish();
            entries.extend(block.tiles.to_be_bytes());
            push_varint(&mut entries, code.len() as u64);
            entries.extend(crc32fast::hash(&code).to_be_bytes());
            codes.extend(code);
            Ok(())
        })?;
        head.extend(entries);
        let sum = checksum(VERDICTS, &head);
        head.extend(sum.to_be_bytes());
        head.extend(codes);
        Ok(head)
    }

    /// What follows the verdicts.
    fn encode(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        self.tables.iter().for_each(|table| table.encode(&mut bytes));
        bytes.extend((self.entries.len() as u32).to_be_bytes());
        for VerdictEntry { camera, span, offset, length } in &self.entries {
            for number in [*camera, span.start, span.end] {
                bytes.extend(number.to_be_bytes());
            }
            bytes.extend(offset.to_be_bytes());
            bytes.extend(length.to_be_bytes());
        }
        let sum = checksum(VERDICTS, &bytes);
        bytes.extend(sum.to_be_bytes());
        bytes.extend((bytes.len() as u32).to_be_bytes());
        bytes
    }

    /// Reads the table of a chunk: `bytes` gives some of its payload, which has `length` bytes.
    ///
    /// # Errors
    /// What is wrong with it.
    pub(crate) fn read(
        length: u64,
        cameras: usize,
        frames: usize,
        bytes: impl Fn(Range<u64>) -> Result<Vec<u8>>,
    ) -> std::result::Result<Self, String> {
        let part = |range| bytes(range).map_err(|error| error.to_string());
        let end = length.checked_sub(4).ok_or("it is too short")?;
        let table_length = u64::from(ByteReader::new(&part(end..length)?).u32()?);
        let start = end.checked_sub(table_length).ok_or("its table is longer than the chunk")?;
        let mut payload = part(start..end)?;
        let stated = payload.len().checked_sub(CHECKSUM as usize).ok_or("its table is too short")?;
        let stated = payload.split_off(stated);
        if !agree(&stated, checksum(VERDICTS, &payload)) {
            return Err("its table is damaged".to_owned());
        }
        let mut reader = ByteReader::new(&payload);
        let tables =
            (0..VERDICT_CHANNELS).map(|_| PlaneModel::decode(&mut reader, VALUE_CONTEXTS, VALUE_TOKENS));
        let tables = tables.collect::<std::result::Result<Vec<_>, _>>()?;
        let entries = (0..reader.count(ENTRY_BYTES)?).map(|_| {
            let camera = reader.u32()?;
            let span = Span { start: reader.u32()?, end: reader.u32()? };
            let entry = VerdictEntry { camera, span, offset: reader.u64()?, length: reader.u32()? };
            let is_there = entry.offset.checked_add(u64::from(entry.length)).is_some_and(|end| end <= start);
            let is_of_store = camera < cameras as u32 && span.start < span.end && span.end as usize <= frames;
            if is_there && is_of_store {
                Ok(entry)
            } else {
                Err("its table names what is not there".to_owned())
            }
        });
        let entries = entries.collect::<std::result::Result<_, String>>()?;
        reader.finish()?;
        Ok(Self { tables, entries })
    }

    /// Decodes those blocks of a camera and span that are `wanted`, by column and row, and visits each with the column and row of its
    /// first pixel.
    ///
    /// # Errors
    /// What is damaged.
    pub(crate) fn decode_span(
        &self,
        bytes: &[u8],
        size: (usize, usize),
        cameras: usize,
        wanted: impl Fn((usize, usize)) -> bool,
        mut visit: impl FnMut((usize, usize), &BlockVerdicts),
    ) -> std::result::Result<(), String> {
        let grid = block_grid(size);
        let mut reader = ByteReader::new(bytes);
        let bits = reader.take((grid.0 * grid.1).div_ceil(8))?;
        let mut entries = Vec::new();
        for place in (0..grid.0 * grid.1).filter(|place| bits[place / 8] & 0x80 >> (place % 8) != 0) {
            entries.push((place, reader.u16()?, reader.varint()? as usize, reader.u32()?.to_be_bytes()));
        }
        let head = &bytes[..bytes.len() - reader.rest.len()];
        let stated = reader.u32()?.to_be_bytes();
        if !agree(&stated, checksum(VERDICTS, head)) {
            return Err("the head of some verdicts is damaged".to_owned());
        }
        let mut block = BlockVerdicts::new();
        for (place, tiles, length, stated) in entries {
            let code = reader.take(length)?;
            let at = (place % grid.0, place / grid.0);
            if !wanted(at) {
                continue;
            }
            if !agree(&stated, crc32fast::hash(code)) {
                return Err(format!("the verdicts on the 64×64 pixels of block {place} are damaged"));
            }
            block.clear();
            block.tiles = tiles;
            let mut reader =
                ValueReader::new(&self.tables, code).ok_or("the code of verdicts is cut short")?;
            traverse_verdicts(&mut reader, &mut block, rest_at(grid, size, place), cameras)?;
            if !reader.is_whole() {
                return Err("the code of verdicts does not end where it should".to_owned());
            }
            visit((at.0 * BLOCK, at.1 * BLOCK), &block);
        }
        Ok(())
    }
}

fn invalid(what: impl std::fmt::Display) -> Error {
    Error::invalid("verdicts", format!("cannot be written: {what}"))
}

/// Columns and rows of the camera that verdicts are of.
fn size_of_camera(cameras: &[Camera], verdicts: &SpanVerdicts) -> Result<(usize, usize)> {
    let camera = cameras.get(verdicts.camera as usize);
    let camera = camera.ok_or_else(|| {
        invalid(format!("camera {}; there are {}", verdicts.camera, counted(cameras.len(), "camera")))
    })?;
    Ok(camera.intrinsics.size())
}
