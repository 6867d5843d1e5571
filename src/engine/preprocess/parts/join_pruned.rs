//! The kept samples of all runs together.

use super::measured::MeasuredCapture;
use crate::capture::Camera;
use crate::error::{Error, Result};
use crate::job::Job;
use crate::preprocess::diagnostics::RunCounts;
use crate::preprocess::{BufferedResult, aligned_settings, cut_by_hand, sample_set};
use crate::samples::{ImageBuffer, ReadSeek, RecordReader, SampleImage, samples_in_memory};

/// Joins what [`prune_part`](super::prune_part()) wrote of all runs, in order, each with its name for errors, and applies edits to it.
/// `cameras` are all, those that edits leave out among them; `removed` is the sum of [`MeasuredCapture::removed_pixels`] over all parts.
///
/// # Errors
/// `Io`; `Invalid` if a part is damaged or of another kind; as [`edits::cut`](crate::edits::cut()); `Cancelled`.
pub fn join_pruned<'a>(
    of: MeasuredCapture<'_>,
    cameras: &[Camera],
    removed: &[u64],
    parts: Vec<(String, Box<dyn ReadSeek + 'a>)>,
    job: &Job,
) -> Result<BufferedResult> {
    let MeasuredCapture { capture, measured, settings, edits } = of;
    let aligned = of.edited();
    let mut images = ImageBuffer::new(samples_in_memory(settings));
    let mut all: Option<RunCounts> = None;
    job.start("Joining parts", parts.len());
    for (place, reader) in parts {
        let mut reader = RecordReader::new(reader, place);
        while reader.number()? == 1 {
            job.check()?;
            images.push(reader.record::<SampleImage>()?)?;
        }
        let counts: RunCounts = reader.json()?;
        match &mut all {
            None => all = Some(counts),
            Some(all) => all.add(&counts),
        }
        job.advance(1);
    }
    let counts = all.ok_or_else(|| Error::invalid(&capture.name, "there is no part to join"))?;
    images.sort();
    let mut report = counts.finish(aligned.capture.cameras.len(), images.facts());
    report.alignment.clone_from(&aligned.alignment);
    report.note_conventions(measured.conventions.as_ref());
    let settings = aligned_settings(settings, aligned.alignment.as_ref());
    let joined =
        BufferedResult { outline: sample_set(&aligned.capture, &settings, Vec::new()), images, report };
    cut_by_hand(joined, &aligned.capture, removed, edits, cameras, job)
}
