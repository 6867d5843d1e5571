//! Chunked files of bytes.

mod bytes;
mod iff;
mod source;

pub(crate) use bytes::{
    ByteReader, DOUBTFUL, HEAD, IMAGE, IMAGE_VALUES, INDEX, LONG_REPORT, MODEL, PALETTE, PROVENANCE, REPORT,
    SETTINGS, STORE, VALUES, push_text, push_varint,
};
pub(crate) use iff::{
    CHECKSUM, CHUNK_HEADER, ChunkHeader, ChunkId, FORM_HEADER, FormReader, FormWriter, IffError, agree,
    checksum,
};
pub use source::ReadAt;
