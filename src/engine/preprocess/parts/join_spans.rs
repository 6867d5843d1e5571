//! The spans that are longer than a run, from what is known of each run at its end.
//!
//! ```text
//! for each camera:  1, span and samples; … ; 0
//!                   pixels without depth; how far ranges reach (JSON)
//! ```

use std::io::Write;

use super::measured::MeasuredCapture;
use super::scan_part::write_span;
use crate::error::Result;
use crate::job::Job;
use crate::preprocess::temporal::{OpenSums, SpanSamples, SpanSums, Split, StaticTest};
use crate::samples::{ReadSeek, RecordReader, RecordWriter, Span};

/// Joins what [`scan_part`](super::scan_part()) wrote of all runs, in order, and writes the samples of all spans that no run holds
/// as a whole or that were open at its end.
///
/// # Errors
/// `Io`; `Invalid` if a part is damaged or of another kind; `Cancelled`.
pub fn join_spans<'a>(
    of: MeasuredCapture<'_>,
    parts: Vec<(String, Box<dyn ReadSeek + 'a>)>,
    writer: &mut dyn Write,
    job: &Job,
) -> Result<()> {
    let MeasuredCapture { measured, settings, .. } = of;
    let capture = of.aligned().capture;
    let frames = capture.frame_count();
    let mut parts: Vec<RecordReader<'a>> =
        parts.into_iter().map(|(place, reader)| RecordReader::new(reader, place)).collect();
    let mut writer = RecordWriter::new(writer, "the spans of all parts")?;
    job.start("Joining spans", capture.cameras.len());
    for (camera, preview) in capture.cameras.iter().zip(&measured.cameras) {
        let test = StaticTest::new(&settings.spans, &preview.noise, preview.depth_step_relative, frames)
            .with_lens(&camera.intrinsics)
            .with_values(capture.value_channels());
        let mut split = Split::new(camera.intrinsics.pixel_count(), frames, test);
        let mut invalid = 0;
        for part in &mut parts {
            skip_short(part)?;
            for _ in 0..part.number()? {
                job.check()?;
                let (span, sums) = read_open(part)?;
                for (span, samples) in split.add_sums(span, sums) {
                    writer.number(1)?;
                    write_span(&mut writer, span)?;
                    writer.record(&samples)?;
                }
            }
            invalid += part.number()?;
        }
        writer.number(0)?;
        writer.number(invalid)?;
        writer.json(&split.shares())?;
        job.advance(1);
    }
    Ok(())
}

fn skip_short(part: &mut RecordReader<'_>) -> Result<()> {
    for _ in 0..part.number()? {
        read_span(part)?;
        part.skip_record()?;
    }
    Ok(())
}

fn read_open(part: &mut RecordReader<'_>) -> Result<(Span, OpenSums)> {
    let span = read_span(part)?;
    let chunks = (0..part.number()?).map(|_| part.record::<SpanSums>()).collect::<Result<_>>()?;
    Ok((span, chunks))
}

pub(super) fn read_span(part: &mut RecordReader<'_>) -> Result<Span> {
    Ok(Span { start: part.number()? as u32, end: part.number()? as u32 })
}

/// Passes the short spans of a run that are needed to `take`.
pub(super) fn read_short(
    part: &mut RecordReader<'_>,
    is_needed: impl Fn(Span) -> bool,
    mut take: impl FnMut(Span, SpanSamples) -> Result<()>,
) -> Result<()> {
    for _ in 0..part.number()? {
        let span = read_span(part)?;
        if is_needed(span) {
            take(span, part.record()?)?;
        } else {
            part.skip_record()?;
        }
    }
    for _ in 0..part.number()? {
        read_span(part)?;
        for _ in 0..part.number()? {
            part.skip_record()?;
        }
    }
    part.number().map(|_| ())
}
