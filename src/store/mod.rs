//! The store: a tiled, run-length-encoded, chunked IFF file.

use std::path::Path;

use crate::error::Result;
use crate::job::Job;
use crate::preprocess::{Report, SampleSet};

/// Writes a store: to a temporary file beside `path`, which is synced and then renamed over it. Gives its size in bytes.
///
/// # Errors
/// `Io`; whatever stood at `path` is untouched then.
pub fn write(path: &Path, samples: &SampleSet, report: &Report, job: &Job) -> Result<u64> {
    let _ = (path, samples, report, job);
    todo!()
}

/// Reads a whole store.
///
/// # Errors
/// `Io`, `Invalid` (naming file, chunk and byte offset), `Unsupported` (a newer version), `Cancelled`.
pub fn read(path: &Path, job: &Job) -> Result<(SampleSet, Report)> {
    let _ = (path, job);
    todo!()
}
