//! Compressed parts of a PDF, and what it refuses.

use overlook_engine::error::{Error, Result};

/// Effort of compression, as zlib counts it.
const EFFORT: i32 = 6;

pub(super) fn refusal(what: &str) -> Error {
    Error::unsupported("chart as PDF", format!("cannot hold {what}"))
}

/// Bytes as zlib holds them, which the filter `FlateDecode` reads.
///
/// # Errors
/// `Unsupported` where they are too many.
pub(super) fn deflated(bytes: &[u8]) -> Result<Vec<u8>> {
    let level = libdeflater::CompressionLvl::new(EFFORT).map_err(|_| refusal("compressed data"))?;
    let mut compressor = libdeflater::Compressor::new(level);
    let mut compressed = vec![0; compressor.zlib_compress_bound(bytes.len())];
    let length = compressor.zlib_compress(bytes, &mut compressed).map_err(|_| refusal("that much data"))?;
    compressed.truncate(length);
    Ok(compressed)
}
