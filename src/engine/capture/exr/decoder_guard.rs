//! Keeps a damaged file from taking the program down with the decoder.

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Once;

use exr::block::chunk::{Chunk, CompressedBlock};
use exr::compression::Compression;
use exr::meta::MetaData;

use crate::error::{Error, Result, one_line};

/// Sizes at the start of a DWA chunk: a version, nine sizes, and the kind of entropy coding, 8 bytes each.
const DWA_SIZES: std::ops::Range<usize> = 1..10;
/// Room for padding to blocks of 8×8 in chunks that are smaller than that.
const DWA_SLACK_BYTES: u64 = 1 << 16;

/// Checks the sizes that a compressed chunk claims for itself. The decoder allocates as much as a DWA chunk claims, and a
/// failed allocation ends the process. Other compressions derive their sizes from the header.
///
/// # Errors
/// The decoder's `Invalid`, for sizes that the pixels of one chunk cannot have.
pub(crate) fn check_chunk(chunk: &Chunk, meta: &MetaData) -> exr::error::Result<()> {
    let Some(header) = meta.headers.get(chunk.layer_index) else {
        return Err(exr::error::Error::Invalid("a block of a part that is not there".into()));
    };
    let Some(bytes) = packed_bytes(&chunk.compressed_block) else { return Ok(()) };
    if !matches!(header.compression, Compression::DWAA(_) | Compression::DWAB(_)) {
        return Ok(());
    }
    let block_size = header.max_block_pixel_size();
    let pixels = block_size.0.min(header.layer_size.0) as u64 * block_size.1.min(header.layer_size.1) as u64;
    // Coefficients are 2 bytes for samples of 2 or 4, padded to whole blocks, and run lengths at most double.
    let limit = 4 * pixels * header.channels.bytes_per_pixel as u64 + DWA_SLACK_BYTES;
    let (words, _) = bytes.as_chunks::<8>();
    let sizes = words.get(DWA_SIZES).unwrap_or_default();
    if sizes.iter().all(|word| u64::from_le_bytes(*word) <= limit) {
        Ok(())
    } else {
        Err(exr::error::Error::Invalid("a DWA block claims more bytes than its pixels have".into()))
    }
}

/// The bytes that a compressed block holds; of a deep one none.
pub(crate) fn packed_bytes(block: &CompressedBlock) -> Option<&[u8]> {
    match block {
        CompressedBlock::ScanLine(block) => Some(&block.compressed_pixels_le),
        CompressedBlock::Tile(block) => Some(&block.compressed_pixels_le),
        _ => None,
    }
}

/// Runs the decoder and turns its errors, and its panics, into ours.
///
/// The decoder checks its input in places by assertions and by indexing; on a damaged file those may fail, and a
/// damaged file must never take the program down.
pub(crate) fn guarded<T>(place: &str, decode: impl FnOnce() -> exr::error::Result<T>) -> Result<T> {
    silence_expected_panics();
    let outer = EXPECTED.replace(true);
    let outcome = catch_unwind(AssertUnwindSafe(decode));
    EXPECTED.set(outer);
    match outcome {
        Ok(Ok(value)) => Ok(value),
        Ok(Err(exr::error::Error::NotSupported(what))) => {
            let what = one_line(&what);
            let advice = if what.contains("deep") {
                "flattened"
            } else if what.contains("subsampling") {
                "as RGB, every channel of every pixel"
            } else {
                "with ZIP compression"
            };
            Err(Error::unsupported(place, format!("{what}; save it again {advice}")))
        }
        Ok(Err(error)) => Err(damaged(place, &error.to_string())),
        Err(_) => Err(damaged(place, "the decoder gave up")),
    }
}

thread_local! {
    /// Whether a panic of this thread is caught and becomes an error.
    static EXPECTED: Cell<bool> = const { Cell::new(false) };
}

/// Keeps panics that become errors from being printed as well; all others are printed as before.
fn silence_expected_panics() {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let print = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |panic| {
            if !EXPECTED.get() {
                print(panic);
            }
        }));
    });
}

fn damaged(place: &str, what: &str) -> Error {
    Error::invalid(
        place,
        format!(
            "damaged, or not an OpenEXR picture ({}); save it again with ZIP compression",
            one_line(what)
        ),
    )
}
