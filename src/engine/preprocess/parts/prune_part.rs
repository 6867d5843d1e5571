//! Pruning of one run of frames.
//!
//! ```text
//! 1, image; … ; 0; counts and residuals (JSON)
//! ```

use std::io::Write;

use super::join_spans::{read_short, read_span};
use super::measured::{Measured, MeasuredCapture};
use super::runs::run_of_part;
use crate::alignment::Aligned;
use crate::error::Result;
use crate::job::Job;
use crate::part::Part;
use crate::preprocess::diagnostics::{Residuals, RunCounts};
use crate::preprocess::temporal::{CameraScan, RangeHistogram, SpanStore, TemporalScan};
use crate::preprocess::{PreparedScan, prune_run};
use crate::samples::{ImageBuffer, ReadSeek, RecordReader, RecordWriter, Span, samples_in_memory};
use crate::settings::Settings;

/// The parts of the scan that pruning a part reads: the part of its own run, and the part with the earlier frame that moving samples
/// are compared with.
#[must_use]
pub fn scan_parts_read_by(frames: usize, part: Part) -> Vec<Part> {
    let run = run_of_part(frames, part);
    let before = Residuals::frame_before(frames, run);
    let is_read = |other: &Part| {
        let other_run = run_of_part(frames, *other);
        *other == part || before.is_some_and(|before| other_run.contains(before))
    };
    Part::all(part.of()).filter(is_read).collect()
}

/// Prunes the frames of a part: `spans` is what [`join_spans`](super::join_spans()) wrote, `scans` what
/// [`scan_part`](super::scan_part()) wrote of [`scan_parts_read_by`] the part, each with its name for errors. Writes the images that
/// are kept, and what was counted.
///
/// # Errors
/// As [`preprocess`](crate::preprocess::preprocess()), and `Invalid` if a part is damaged or of another kind.
pub fn prune_part<'a>(
    of: MeasuredCapture<'_>,
    part: Part,
    spans: (String, Box<dyn ReadSeek + 'a>),
    scans: Vec<(String, Box<dyn ReadSeek + 'a>)>,
    writer: &mut dyn Write,
    job: &Job,
) -> Result<()> {
    let MeasuredCapture { measured, settings, .. } = of;
    let aligned = of.edited();
    let run = run_of_part(aligned.capture.frame_count(), part);
    let scan = read_scan(&aligned, measured, settings, run, spans, scans, job)?;
    let scan = PreparedScan::of(scan, aligned, measured.conventions.clone(), &settings.align);
    let images = ImageBuffer::new(samples_in_memory(settings));
    let (images, counts): (ImageBuffer, RunCounts) = prune_run(images, &scan, settings, run, job)?;
    let mut writer = RecordWriter::new(writer, format!("part {part} of pruning"))?;
    for index in 0..images.len() {
        writer.number(1)?;
        writer.record(&*images.get(index)?)?;
    }
    writer.number(0)?;
    writer.json(&counts)
}

/// What a run needs of a scan of all frames.
fn read_scan<'a>(
    aligned: &Aligned,
    measured: &Measured,
    settings: &Settings,
    run: Span,
    spans: (String, Box<dyn ReadSeek + 'a>),
    scans: Vec<(String, Box<dyn ReadSeek + 'a>)>,
    job: &Job,
) -> Result<TemporalScan> {
    let frames = aligned.capture.frame_count();
    let before = Residuals::frame_before(frames, run);
    let is_needed = |span: Span| {
        let overlaps = span.start < run.end && run.start < span.end;
        overlaps || before.is_some_and(|before| span.contains(before)) || span.len() == frames
    };
    let (place, spans) = spans;
    let mut spans = RecordReader::new(spans, place);
    let mut scans: Vec<RecordReader<'a>> =
        scans.into_iter().map(|(place, reader)| RecordReader::new(reader, place)).collect();
    let mut store = SpanStore::new(samples_in_memory(settings));
    job.start("Reading spans", measured.cameras.len());
    let mut cameras = Vec::new();
    for (camera, preview) in measured.cameras.iter().enumerate() {
        job.check()?;
        for scan in &mut scans {
            read_short(scan, is_needed, |span, samples| store.insert(camera, span, samples))?;
        }
        while spans.number()? == 1 {
            let span = read_span(&mut spans)?;
            if is_needed(span) {
                store.insert(camera, span, spans.record()?)?;
            } else {
                spans.skip_record()?;
            }
        }
        let invalid = spans.number()?;
        let shares: RangeHistogram = spans.json()?;
        cameras.push(CameraScan::of_parts(preview, shares, invalid));
        job.advance(1);
    }
    let lenses = aligned.capture.cameras.iter().map(|camera| camera.intrinsics).collect();
    Ok(TemporalScan::of_parts(frames, lenses, cameras, store, settings))
}
