//! The store: a tiled, run-length-encoded, chunked IFF file. FORMAT.md describes it byte by byte.
//!
//! ```text
//! SampleSet + Report ─ tiles ─▶ planes of bytes ─ codec (rle) ─▶ chunks ─ iff ─▶ file
//! ```
//!
//! Source: the paper, §3.2: tiles, of which empty ones are skipped, "simple run-length encoding", a "customized IFF
//! format". What differs: checksums, a version, an index for random access, and byte planes of differences before the
//! run-length encoding, which finds few runs in half floats as they are. The file holds exactly what the set holds.

mod bytes;
pub mod codec;
mod header;
pub mod iff;
mod reader;
pub mod rle;
mod tiles;
mod writer;

use std::path::Path;

use crate::error::Result;
use crate::job::Job;
use crate::preprocess::{Report, SampleSet};

pub use header::{ImageEntry, VERSION};
pub use reader::{Store, StoreInfo};
pub use writer::write;

/// Reads a whole store.
///
/// # Errors
/// `Io`, `Invalid` (naming file, chunk and byte offset), `Unsupported` (a newer version), `Cancelled`.
pub fn read(path: &Path, job: &Job) -> Result<(SampleSet, Report)> {
    Store::open(path)?.read_all(job)
}
