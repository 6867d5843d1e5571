//! The store: tiles of samples, predicted and entropy-coded, in a chunked IFF file. FORMAT.md describes it byte by byte.
//!
//! ```text
//! SampleSet + Report ─ precision ─▶ images ─ blocks ─▶ numbers ─ coding ─▶ bytes ─ iff ─▶ file
//! ```
//!
//! Source: the paper, §3.2: tiles, of which empty ones are skipped, "simple run-length encoding", a "customized IFF
//! format". What differs: prediction and entropy coding in place of runs, of which half floats have few; checksums, a version,
//! an index for random access. The file holds exactly what the set holds, unless a precision is asked for.

mod blocks;
mod bytes;
pub mod coding;
mod header;
pub mod iff;
mod images;
mod palette;
mod precision;
mod provenance;
mod reader;
mod source;
mod writer;

use std::path::Path;

use crate::error::{Error, Result};
use crate::job::Job;
use crate::preprocess::{Report, SampleSet};

pub use header::{ImageEntry, MAX_REFERENCES, VERSION};
pub use images::{BlockEntry, ImageHead};
pub use provenance::{InputFiles, Provenance, Rivals};
pub use reader::{Store, StoreInfo};
pub use source::ReadAt;
pub use writer::{Extras, write, write_to, write_with};

/// Reads a whole store, in which nothing may be damaged: [`Store::read_all`] makes do with what is whole.
///
/// # Errors
/// `Io`, `Invalid` (naming file, chunk and byte offset), `Unsupported` (a newer version), `Cancelled`.
pub fn read(path: &Path, job: &Job) -> Result<(SampleSet, Report)> {
    let store = Store::open(path)?;
    let read = store.read_all(job)?;
    match store.damage().first() {
        None => Ok(read),
        Some(damage) => Err(Error::invalid(path.display(), damage)),
    }
}
