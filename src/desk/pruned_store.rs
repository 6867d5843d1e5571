//! Stores of pruned captures, as the command line and the window write them: the same bytes.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use rayon::prelude::*;

use overlook_engine::capture::Capture;
use overlook_engine::edits::EditList;
use overlook_engine::error::{Error, Result};
use overlook_engine::job::Job;
use overlook_engine::preprocess::diagnostics::Report;
use overlook_engine::preprocess::{
    BufferedResult, PreparedScan, Preprocessed, preprocess_again, preprocess_edited,
};
use overlook_engine::settings::Settings;
use overlook_engine::store::file::{self, Extras, InputFiles, Provenance};

/// A capture that was scanned and pruned without edits.
pub(crate) struct PrunedBefore {
    pub scan: Arc<PreparedScan>,
    pub result: Preprocessed,
}

/// Prunes a capture with edits and writes the store; gives its report and its bytes. What was done `before` with these settings is not done
/// again.
///
/// # Errors
/// As [`preprocess_edited`] and [`file::write`].
pub(crate) fn prune_into_store(
    capture: &Capture,
    before: Option<&PrunedBefore>,
    settings: &Settings,
    edits: &EditList,
    out: &Path,
    job: &Job,
) -> Result<(Report, u64)> {
    let result = match before {
        Some(PrunedBefore { scan, result }) => preprocess_again(capture, scan, result, settings, edits, job)?,
        None => preprocess_edited(capture, settings, edits, job)?,
    };
    let inputs = input_files(capture, job)?;
    write(capture, result, inputs, out, job)
}

/// Writes a store, and gives its report and its bytes.
///
/// # Errors
/// As [`file::write`].
pub(crate) fn write(
    capture: &Capture,
    result: BufferedResult,
    inputs: Option<InputFiles>,
    out: &Path,
    job: &Job,
) -> Result<(Report, u64)> {
    let BufferedResult { outline, images, verdicts, report } = result;
    let frames_are_ranked = capture.frames_are_ranked();
    let provenance = Provenance { inputs, frames_are_ranked, ..Provenance::default() };
    let extras = Extras { report: report.to_json()?, provenance, verdicts, ..Extras::default() };
    let bytes = file::write_spooled(out, &outline, &images, &extras, job)?;
    Ok((report, bytes))
}

/// Length and checksum of all files of a capture; `None` if it does not come from files.
fn input_files(capture: &Capture, job: &Job) -> Result<Option<InputFiles>> {
    let files = capture.files();
    let sums = sums_of(&files, job)?;
    Ok(summed_up(files.into_iter().zip(sums)))
}

/// Length and CRC-32 of each file.
pub(crate) fn sums_of(files: &[PathBuf], job: &Job) -> Result<Vec<(u64, u32)>> {
    job.start("Summing the input up", files.len());
    let read = files.par_iter().map(|path| {
        job.check()?;
        let sums = sum_of(path).map_err(|error| Error::io(path, error))?;
        job.advance(1);
        Ok(sums)
    });
    read.collect()
}

/// All files of a capture in one sum; `None` without files.
pub(crate) fn summed_up(files: impl Iterator<Item = (PathBuf, (u64, u32))>) -> Option<InputFiles> {
    let files: BTreeMap<PathBuf, (u64, u32)> = files.collect();
    // Names are relative to the folder common to all files, so that a capture may move as a whole.
    let root = files.keys().skip(1).fold(files.keys().next().and_then(|path| path.parent()), |root, path| {
        root.and_then(|root| root.ancestors().find(|root| path.starts_with(root)))
    });
    let root = root.unwrap_or(Path::new(""));
    let named = files.iter().map(|(path, (bytes, crc))| {
        (path.strip_prefix(root).unwrap_or(path).display().to_string(), *bytes, *crc)
    });
    let mut named: Vec<(String, u64, u32)> = named.collect();
    named.sort();
    let lines: Vec<String> =
        named.iter().map(|(name, bytes, crc)| format!("{crc:08x} {bytes} {name}\n")).collect();
    let list = lines.concat();
    (!named.is_empty()).then(|| InputFiles {
        files: named.len() as u64,
        bytes: named.iter().map(|(_, bytes, _)| bytes).sum(),
        crc32: crc32fast::hash(list.as_bytes()),
    })
}

/// Length and CRC-32 of a file, read piece by piece through one small buffer.
fn sum_of(path: &Path) -> std::io::Result<(u64, u32)> {
    let mut file = BufReader::with_capacity(1 << 18, File::open(path)?);
    let (mut bytes, mut crc32) = (0, crc32fast::Hasher::new());
    loop {
        let piece = file.fill_buf()?;
        if piece.is_empty() {
            return Ok((bytes, crc32.finalize()));
        }
        crc32.update(piece);
        let length = piece.len();
        bytes += length as u64;
        file.consume(length);
    }
}
