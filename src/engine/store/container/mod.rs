//! Chunked files of bytes.

mod iff;
mod source;

use crate::plural::counted;
pub(crate) use iff::{
    CHECKSUM, CHUNK_HEADER, ChunkHeader, ChunkId, FORM_HEADER, FormReader, FormWriter, IffError, agree,
    checksum,
};
pub use source::ReadAt;

/// Functions that take the next whole number, by its type.
macro_rules! take_numbers {
    ($($number:ident),+) => {
        $(pub(crate) fn $number(&mut self) -> Result<$number, String> {
            self.array().map($number::from_be_bytes)
        })+
    };
}

/// What is left of a payload.
pub(crate) struct ByteReader<'a> {
    pub(crate) rest: &'a [u8],
}

impl<'a> ByteReader<'a> {
    pub(crate) fn new(bytes: &'a [u8]) -> Self {
        Self { rest: bytes }
    }

    pub(crate) fn take(&mut self, count: usize) -> Result<&'a [u8], String> {
        let (taken, rest) = self.rest.split_at_checked(count).ok_or("the chunk is too short")?;
        self.rest = rest;
        Ok(taken)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], String> {
        let (taken, rest) = self.rest.split_first_chunk().ok_or("the chunk is too short")?;
        self.rest = rest;
        Ok(*taken)
    }

    take_numbers!(u8, u16, u32, u64, i64);

    /// Seven bits a byte, lowest first; the highest bit is set in all bytes but the last.
    pub(crate) fn varint(&mut self) -> Result<u64, String> {
        let mut value = 0;
        for shift in (0..63).step_by(7) {
            let byte = self.u8()?;
            value |= u64::from(byte & 0x7F) << shift;
            if byte & 0x80 == 0 {
                return Ok(value);
            }
        }
        Err("a number is too long".to_owned())
    }

    pub(crate) fn f64(&mut self) -> Result<f64, String> {
        let value = self.array().map(f64::from_be_bytes)?;
        if value.is_finite() { Ok(value) } else { Err("a number is not finite".to_owned()) }
    }

    pub(crate) fn text(&mut self) -> Result<String, String> {
        let length = self.u32()? as usize;
        let bytes = self.take(length)?;
        String::from_utf8(bytes.to_vec()).map_err(|_| "a name is not UTF-8".to_owned())
    }

    /// A count of things that take at least `bytes_each`: never more than the rest can hold.
    pub(crate) fn count(&mut self, bytes_each: usize) -> Result<usize, String> {
        let count = self.u32()? as usize;
        if count > self.rest.len() / bytes_each {
            return Err(format!("the chunk has no room for {}", counted(count, "entry")));
        }
        Ok(count)
    }

    pub(crate) fn finish(&self) -> Result<(), String> {
        if self.rest.is_empty() {
            Ok(())
        } else {
            Err(format!("{} too many in the chunk", counted(self.rest.len(), "byte")))
        }
    }
}

/// See [`ByteReader::varint`].
pub(crate) fn push_varint(target: &mut Vec<u8>, mut value: u64) {
    while value >= 0x80 {
        target.push(value as u8 | 0x80);
        value >>= 7;
    }
    target.push(value as u8);
}

pub(crate) fn push_text(target: &mut Vec<u8>, text: &str) {
    target.extend_from_slice(&(text.len() as u32).to_be_bytes());
    target.extend_from_slice(text.as_bytes());
}

/// `FORM` type of a store.
pub(crate) const STORE: ChunkId = *b"OVLK";
/// Version, cameras, frames.
pub(crate) const HEAD: ChunkId = *b"HEAD";
/// How the set was made, TOML.
pub(crate) const SETTINGS: ChunkId = *b"SETT";
/// What was dropped and why, JSON.
pub(crate) const REPORT: ChunkId = *b"REPT";
pub(crate) const LONG_REPORT: ChunkId = *b"RPTZ";
/// The position of each image.
pub(crate) const INDEX: ChunkId = *b"INDX";
/// One sample image.
pub(crate) const IMAGE: ChunkId = *b"IMAG";
/// Which samples are doubtful.
pub(crate) const DOUBTFUL: ChunkId = *b"DOUB";
/// Channels of scalar values, and where those of each image are.
pub(crate) const VALUES: ChunkId = *b"VALU";
/// The scalar values of one image.
pub(crate) const IMAGE_VALUES: ChunkId = *b"VALI";
/// What became of every pixel, and which camera stands for it.
pub(crate) const VERDICTS: ChunkId = *b"VERD";
/// Frequencies of tokens.
pub(crate) const MODEL: ChunkId = *b"MODL";
/// The halves that colors are made of.
pub(crate) const PALETTE: ChunkId = *b"PALT";
/// What the store was made from, JSON.
pub(crate) const PROVENANCE: ChunkId = *b"PROV";
