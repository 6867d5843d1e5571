//! Preprocessing cut by runs of frames, for several machines; what is joined is bit for bit what one piece gives.
//!
//! ```text
//! capture ─ Measured (once: what the rig got wrong, noise) ─▶ scan_part (of each run of frames) ─▶ join_spans (spans longer than a run)
//!                                                                     └───────┬────────────────────────┘
//!                                                         prune_part (of each run) ─▶ join_pruned ─▶ samples and report
//! ```
//!
//! Only the tree of spans is cut: a run is made of whole spans of the tree, so that what is known of it at its end (range and sum of
//! every pixel over each of them) is all that longer spans need. Sums are exact and counts are whole numbers, so that nothing depends
//! on where runs begin. A span that reaches over several runs is decided in each of them, and counted in the one that it begins in.
//!
//! The pass over the frames of one run.
//!
//! ```text
//! for each camera:  number of short spans; span and samples of each
//!                   number of open spans; span, number of chunks of pixels, and range and sum of each chunk
//!                   pixels without depth
//! ```
//!
//! The spans that are longer than a run, from what is known of each run at its end.
//!
//! ```text
//! for each camera:  1, span and samples; … ; 0
//!                   pixels without depth; how far ranges reach (JSON)
//! ```
//!
//! Pruning of one run of frames.
//!
//! ```text
//! 1, image; … ; 0; 1, verdicts of a camera and span; … ; 0; counts and residuals (JSON)
//! ```

use std::collections::BTreeSet;
use std::io::Write;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::diagnostics::{Residuals, RunCounts};
use super::temporal::{
    self, CameraPreview, CameraScan, OpenSums, RangeHistogram, SIDE_BY_SIDE, ScannedRun, SpanSamples,
    SpanStore, SpanSums, Split, StaticTest, TemporalScan, scan_run,
};
use super::{
    BufferedResult, KeptSamples, PreparedScan, aligned_settings, better_conventions, cut_by_hand, prune_run,
    sample_set,
};
use crate::alignment::{self, Aligned, Alignment, CaptureCorrection};
use crate::capture::conventions::Finding;
use crate::capture::{Camera, Capture, with_changed_frames};
use crate::edits::{self, EditList};
use crate::error::{Error, Result};
use crate::job::Job;
use crate::part::Part;
use crate::samples::{
    ReadSeek, RecordReader, RecordWriter, SampleImage, Span, SpanVerdicts, VerdictBuffer, samples_in_memory,
};
use crate::settings::{Settings, SpanLevels};

/// Units of frames for each part, about: runs then differ by a quarter at most.
const UNITS: usize = 4;

/// The frames of a part of a capture of `frames` frames: whole spans of the tree, which begin at a multiple of their length. Empty
/// where there are more parts than frames.
#[must_use]
pub fn run_of_part(frames: usize, part: Part) -> Span {
    let unit = 1 << (frames / (UNITS * part.of() as usize)).max(1).ilog2();
    let units = part.range(frames.div_ceil(unit));
    let frame = |unit_index: usize| (unit_index * unit).min(frames) as u32;
    Span { start: frame(units.start), end: frame(units.end) }
}

/// What the rig got wrong, and the noise of each camera: as JSON it keeps every bit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Measured {
    correction: CaptureCorrection,
    alignment: Option<Alignment>,
    /// How poses and depth would fit far better between cameras than as the capture says, where they would.
    #[serde(default)]
    conventions: Option<Finding>,
    cameras: Vec<CameraPreview>,
    /// Cameras and frames that were read.
    frames_read: BTreeSet<(usize, usize)>,
}

/// A capture with what was measured of it, and the settings that all parts are made with.
#[derive(Clone, Copy, Debug)]
pub struct MeasuredCapture<'a> {
    /// The capture as it was recorded, without the cameras that edits leave out ([`edits::with_cameras_left`]).
    pub capture: &'a Capture,
    /// What was measured of this capture.
    pub measured: &'a Measured,
    /// The settings that it was measured with.
    pub settings: &'a Settings,
    /// The edits that it was measured with.
    pub edits: &'a EditList,
}

impl MeasuredCapture<'_> {
    /// The capture without what the rig got wrong.
    #[must_use]
    pub fn aligned(&self) -> Aligned {
        Aligned {
            capture: self.measured.correction.applied(self.capture),
            alignment: self.measured.alignment.clone(),
            correction: self.measured.correction.clone(),
        }
    }

    /// The same without the pixels that edits remove.
    fn edited(&self) -> Aligned {
        let aligned = self.aligned();
        let capture = edits::without_removed_pixels(
            &aligned.capture,
            self.edits,
            self.settings.capture.edited_cache_bytes(),
        );
        Aligned { capture, ..aligned }
    }

    /// For each camera the pixels with depth that edits remove from the frames of a part.
    ///
    /// # Errors
    /// Whatever the capture gives (naming file and frame), and `Cancelled`.
    pub fn removed_pixels(&self, part: Part, job: &Job) -> Result<Vec<u64>> {
        let run = run_of_part(self.capture.frame_count(), part);
        let frames = run.start as usize..run.end as usize;
        edits::count_removed_pixels(&self.aligned().capture, self.edits, frames, job)
    }
}

impl Measured {
    /// Measures a capture without the cameras that edits leave out: reads a few of its frames.
    ///
    /// # Errors
    /// Whatever the capture gives (naming file and frame), `Invalid` for settings out of range, and `Cancelled`.
    pub fn of(capture: &Capture, settings: &Settings, edits: &EditList, job: &Job) -> Result<Self> {
        settings.validate("settings")?;
        let frames_read = Arc::new(Mutex::new(BTreeSet::new()));
        let noted = noting_frames_read(capture, frames_read.clone());
        let Aligned { capture, alignment, correction } = alignment::align(&noted, &settings.align, job)?;
        let conventions = better_conventions(&noted, &correction)?;
        let capture = edits::without_removed_pixels(&capture, edits, settings.capture.edited_cache_bytes());
        job.start("Measuring noise", capture.cameras.len());
        let preview = |camera| {
            let preview = temporal::preview(&capture, camera, settings, job);
            job.advance(1);
            preview
        };
        let cameras = (0..capture.cameras.len()).into_par_iter().map(preview).collect::<Result<_>>()?;
        let frames_read = frames_read.lock().unwrap_or_else(PoisonError::into_inner).clone();
        Ok(Self { correction, alignment, conventions, cameras, frames_read })
    }

    /// The files that it was measured on.
    #[must_use]
    pub fn files_read(&self, capture: &Capture) -> Vec<PathBuf> {
        let is_there = |(camera, frame): &&(usize, usize)| {
            *camera < capture.cameras.len() && *frame < capture.frame_count()
        };
        let frames = self.frames_read.iter().filter(is_there);
        frames.flat_map(|&(camera, frame)| capture.files_of(camera, frame)).collect()
    }
}

/// Frames that are kept while a capture is measured, bytes.
const CACHE_BYTES: usize = 256 << 20;

/// The same capture, which notes camera and index of each frame that is read.
fn noting_frames_read(capture: &Capture, read: Arc<Mutex<BTreeSet<(usize, usize)>>>) -> Capture {
    with_changed_frames(capture, CACHE_BYTES, move |camera, frame, recorded| {
        read.lock().unwrap_or_else(PoisonError::into_inner).insert((camera, frame));
        recorded.clone()
    })
}

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

fn write_span(writer: &mut RecordWriter<'_>, span: Span) -> Result<()> {
    writer.number(span.start.into())?;
    writer.number(span.end.into())
}

/// Joins what [`scan_part`] wrote of all runs, in order, and writes the samples of all spans that no run holds
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

fn read_span(part: &mut RecordReader<'_>) -> Result<Span> {
    Ok(Span { start: part.number()? as u32, end: part.number()? as u32 })
}

/// Passes the short spans of a run that are needed to `take`.
fn read_short(
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

/// Prunes the frames of a part: `spans` is what [`join_spans`] wrote, `scans` what
/// [`scan_part`] wrote of [`scan_parts_read_by`] the part, each with its name for errors. Writes the images that
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
    let kept = KeptSamples::for_store(settings);
    let (KeptSamples { images, verdicts }, counts) = prune_run(kept, &scan, settings, run, job)?;
    let mut writer = RecordWriter::new(writer, format!("part {part} of pruning"))?;
    for index in 0..images.len() {
        writer.number(1)?;
        writer.record(&*images.get(index)?)?;
    }
    writer.number(0)?;
    for index in 0..verdicts.as_ref().map_or(0, VerdictBuffer::len) {
        writer.number(1)?;
        verdicts.as_ref().map_or(Ok(()), |verdicts| writer.record(&*verdicts.get(index)?))?;
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

/// Joins what [`prune_part`] wrote of all runs, in order, each with its name for errors, and applies edits to it.
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
    let mut kept = KeptSamples::for_store(settings);
    let mut all: Option<RunCounts> = None;
    job.start("Joining parts", parts.len());
    for (place, reader) in parts {
        let mut reader = RecordReader::new(reader, place);
        while reader.number()? == 1 {
            job.check()?;
            kept.images.push(reader.record::<SampleImage>()?)?;
        }
        while reader.number()? == 1 {
            job.check()?;
            let of_span = reader.record::<SpanVerdicts>()?;
            kept.verdicts.as_mut().map_or(Ok(()), |verdicts| verdicts.push(of_span))?;
        }
        let counts: RunCounts = reader.json()?;
        match &mut all {
            None => all = Some(counts),
            Some(all) => all.add(&counts),
        }
        job.advance(1);
    }
    let counts = all.ok_or_else(|| Error::invalid(&capture.name, "there is no part to join"))?;
    kept.sort();
    let KeptSamples { images, verdicts } = kept;
    let mut report = counts.finish(aligned.capture.cameras.len(), images.facts());
    report.alignment.clone_from(&aligned.alignment);
    report.note_conventions(measured.conventions.as_ref());
    let settings = aligned_settings(settings, aligned.alignment.as_ref());
    let outline = sample_set(&aligned.capture, &settings, Vec::new());
    let joined = BufferedResult { outline, images, verdicts: verdicts.map(Arc::new), report };
    cut_by_hand(joined, &aligned.capture, removed, edits, cameras, job)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_hold_each_frame_once_and_begin_where_long_spans_do() {
        for (frames, of) in [(60, 6), (3000, 256), (61, 7), (3, 5), (1, 1)] {
            let runs: Vec<Span> = Part::all(of).map(|part| run_of_part(frames, part)).collect();
            let all: Vec<u32> = runs.iter().flat_map(|run| run.start..run.end).collect();
            assert_eq!(all, (0..frames as u32).collect::<Vec<_>>(), "{frames} in {of}");
            let lengths = || runs.iter().map(|run| run.len());
            let [most, least] = [lengths().max().unwrap(), lengths().min().unwrap()];
            assert!(most <= least + (least / 2).max(1), "{frames} in {of}: {least} to {most}");
        }
        assert_eq!(run_of_part(3000, "1/16".parse().unwrap()), Span { start: 0, end: 160 });
    }
}
