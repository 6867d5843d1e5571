//! Chunked files of bytes.

mod bytes;
mod iff;
mod source;

pub(crate) use bytes::{
    ByteReader, HEAD, IMAGE, INDEX, MODEL, PALETTE, PROVENANCE, REPORT, SETTINGS, STORE, push_text,
    push_varint,
};
pub(crate) use iff::{CHECKSUM, agree};
pub use iff::{CHUNK_HEADER, ChunkHeader, ChunkId, FORM_HEADER, FormReader, FormWriter, IffError};
pub use source::ReadAt;
