//! Big-endian numbers and texts taken from a chunk without ever reading past its end.

use crate::store::iff::ChunkId;

/// What is left of a payload.
pub(super) struct ByteReader<'a> {
    pub(super) rest: &'a [u8],
}

impl<'a> ByteReader<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self { rest: bytes }
    }

    pub(super) fn take(&mut self, count: usize) -> Result<&'a [u8], String> {
        let (taken, rest) = self.rest.split_at_checked(count).ok_or("the chunk is too short")?;
        self.rest = rest;
        Ok(taken)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], String> {
        let (taken, rest) = self.rest.split_first_chunk().ok_or("the chunk is too short")?;
        self.rest = rest;
        Ok(*taken)
    }

    pub(super) fn u8(&mut self) -> Result<u8, String> {
        self.array().map(u8::from_be_bytes)
    }

    pub(super) fn u16(&mut self) -> Result<u16, String> {
        self.array().map(u16::from_be_bytes)
    }

    pub(super) fn u32(&mut self) -> Result<u32, String> {
        self.array().map(u32::from_be_bytes)
    }

    pub(super) fn i64(&mut self) -> Result<i64, String> {
        self.array().map(i64::from_be_bytes)
    }

    pub(super) fn f64(&mut self) -> Result<f64, String> {
        let value = self.array().map(f64::from_be_bytes)?;
        if value.is_finite() { Ok(value) } else { Err("a number is not finite".to_owned()) }
    }

    pub(super) fn text(&mut self) -> Result<String, String> {
        let length = self.u32()? as usize;
        let bytes = self.take(length)?;
        String::from_utf8(bytes.to_vec()).map_err(|_| "a name is not UTF-8".to_owned())
    }

    /// A count of things that take at least `bytes_each`: never more than the rest can hold.
    pub(super) fn count(&mut self, bytes_each: usize) -> Result<usize, String> {
        let count = self.u32()? as usize;
        if count > self.rest.len() / bytes_each {
            return Err(format!("{count} entries do not fit into the chunk"));
        }
        Ok(count)
    }

    pub(super) fn finish(&self) -> Result<(), String> {
        if self.rest.is_empty() {
            Ok(())
        } else {
            Err(format!("{} bytes too many in the chunk", self.rest.len()))
        }
    }
}

pub(super) fn push_text(target: &mut Vec<u8>, text: &str) {
    target.extend_from_slice(&(text.len() as u32).to_be_bytes());
    target.extend_from_slice(text.as_bytes());
}

/// `FORM` type of a store.
pub(super) const STORE: ChunkId = *b"OVLK";
/// Version, cameras, frames.
pub(super) const HEAD: ChunkId = *b"HEAD";
/// How the set was made, TOML.
pub(super) const SETTINGS: ChunkId = *b"SETT";
/// What was dropped and why, JSON.
pub(super) const REPORT: ChunkId = *b"REPT";
/// Where each image stands.
pub(super) const INDEX: ChunkId = *b"INDX";
/// One sample image.
pub(super) const IMAGE: ChunkId = *b"IMAG";
