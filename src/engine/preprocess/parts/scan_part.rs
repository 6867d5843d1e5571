//! The pass over the frames of one run.
//!
//! ```text
//! for each camera:  number of short spans; span and samples of each
//!                   number of open spans; span, number of chunks of pixels, and range and sum of each chunk
//!                   pixels without depth
//! ```

use std::io::Write;

use rayon::prelude::*;

use super::measured::MeasuredCapture;
use super::runs::run_of_part;
use crate::error::{Error, Result};
use crate::job::Job;
use crate::part::Part;
use crate::preprocess::temporal::{SIDE_BY_SIDE, ScannedRun, scan_run};
use crate::samples::{RecordWriter, Span};
use crate::settings::SpanLevels;

/// Scans the frames of a part, and writes what was found.
///
/// # Errors
/// `Unsupported` where the spans are no tree; whatever the capture gives (naming file and frame); `Io`; `Cancelled`.
pub fn scan_part(of: MeasuredCapture<'_>, part: Part, writer: &mut dyn Write, job: &Job) -> Result<()> {
    let MeasuredCapture { measured, settings, .. } = of;
    if settings.spans.levels != SpanLevels::Tree {
        return Err(Error::unsupported(
            "spans.levels",
            "only the tree of spans can be cut into parts; set it to tree, or preprocess in one piece",
        ));
    }
    let capture = of.edited().capture;
    let run = run_of_part(capture.frame_count(), part);
    let mut writer = RecordWriter::new(writer, format!("part {part} of the scan"))?;
    job.start("Reading frames", run.len() * capture.cameras.len());
    let cameras: Vec<usize> = (0..capture.cameras.len()).collect();
    for cameras in cameras.chunks(SIDE_BY_SIDE) {
        let scan =
            |&camera: &usize| scan_run(&capture, camera, run, &measured.cameras[camera], settings, job);
        // One after the other, so that of two errors the first camera's is reported.
        let scanned: Vec<Result<ScannedRun>> = cameras.par_iter().map(scan).collect();
        scanned.into_iter().try_for_each(|scanned| write_camera(&mut writer, &scanned?))?;
    }
    Ok(())
}

fn write_camera(writer: &mut RecordWriter<'_>, scanned: &ScannedRun) -> Result<()> {
    let spans = scanned.short.spans();
    writer.number(spans.len() as u64)?;
    for (camera, span) in spans {
        write_span(writer, span)?;
        writer.record(&*scanned.short.get(camera, span)?.unwrap_or_default())?;
    }
    writer.number(scanned.open.len() as u64)?;
    for (span, chunks) in &scanned.open {
        write_span(writer, *span)?;
        writer.number(chunks.len() as u64)?;
        chunks.iter().try_for_each(|chunk| writer.record(chunk))?;
    }
    writer.number(scanned.invalid)
}

pub(super) fn write_span(writer: &mut RecordWriter<'_>, span: Span) -> Result<()> {
    writer.number(span.start.into())?;
    writer.number(span.end.into())
}
