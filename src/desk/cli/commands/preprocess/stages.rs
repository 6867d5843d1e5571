//! Stages of preprocessing, each cut by runs of frames.
//!
//! ```text
//! F.ovl.measured ─▶ F.ovl.scan.part-K-of-N ─▶ F.ovl.spans-of-N ─▶ F.ovl.prune.part-K-of-N ─▶ F.ovl
//! ```
//!
//! A part of the scan begins with length and CRC-32 of the files that its frames are read from, and the pixels that edits removed. Each file names the files
//! that it was made from: a changed picture is found by the part that read it.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use clap::ValueEnum;

use crate::cli::input;
use crate::cli::output::{Inputs, OpenPart, PartFiles};
use overlook_engine::capture::Capture;
use overlook_engine::edits::EditList;
use overlook_engine::error::Result;
use overlook_engine::job::Job;
use overlook_engine::part::Part;
use overlook_engine::preprocess::BufferedResult;
use overlook_engine::preprocess::parts::{
    Measured, MeasuredCapture, join_pruned, join_spans, prune_part, run_of_part, scan_part,
    scan_parts_read_by,
};
use overlook_engine::samples::{ReadSeek, RecordReader, RecordWriter};
use overlook_engine::settings::{CaptureSettings, Settings};
use overlook_engine::store::file::InputFiles;
use overlook_engine::whole_file;

/// A stage of preprocessing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum PreprocessStage {
    /// Errors of the rig, and noise: measured once, for all parts.
    Measure,
    /// The pass over the frames of each run; joined, the spans that are longer than a run.
    Scan,
    /// What is redundant between cameras, in each run; joined, the store.
    Prune,
}

/// The stages on the way to one store.
pub(super) struct Stages<'a> {
    pub(super) path: &'a Path,
    pub(super) capture: &'a Capture,
    pub(super) out: &'a Path,
    pub(super) settings: &'a Settings,
    pub(super) edits: &'a EditList,
    /// The capture without the cameras that edits leave out.
    pub(super) left: &'a Capture,
}

/// A part that is read, and its name for errors.
type NamedPart = (String, Box<dyn ReadSeek>);

fn named(part: OpenPart) -> NamedPart {
    (part.path.display().to_string(), Box::new(part.reader))
}

/// What a part of the scan begins with: length and CRC-32 of the files that it was read from, and for each camera the pixels that edits
/// removed.
type ScanHead = (Vec<(u64, u32)>, Vec<u64>);

/// What was measured once, for all parts.
struct Measurement {
    measured: Measured,
    /// Differs from that of any other such file.
    identity: String,
    /// The capture with the errors of the rig corrected.
    corrected: Capture,
}

impl Stages<'_> {
    fn folder(&self) -> &Path {
        whole_file::folder_of(self.out)
    }

    fn name(&self, suffix: &str) -> String {
        format!("{}.{suffix}", self.out.file_name().unwrap_or_default().to_string_lossy())
    }

    /// The inputs of all stages. The memory setting is left out: it changes no result.
    fn inputs(&self) -> Result<Inputs> {
        let capture = CaptureSettings { memory: 0, ..self.settings.capture.clone() };
        let settings = Settings { capture, ..self.settings.clone() };
        Ok(Inputs::default()
            .with("list of cameras and frames", &input::capture_state(self.path, self.capture)?)
            .with("settings", &format!("{settings:?}"))
            .with("edits", &self.edits.to_toml()))
    }

    fn measured_file(&self) -> Result<PartFiles> {
        Ok(PartFiles::single(self.folder(), &self.name("measured"), self.inputs()?, "--stage measure"))
    }

    /// Measures what all parts need.
    pub(super) fn measure(&self, job: &Job) -> Result<PathBuf> {
        let (file, part) = (self.measured_file()?, Part::WHOLE);
        if self.measured().is_err() {
            let measured = Measured::of(self.left, self.settings, self.edits, job)?;
            let state = input::pictures_state(&measured.files_read(self.left))?;
            file.write(part, |writer| {
                let mut writer = RecordWriter::new(writer, file.path(part).display().to_string())?;
                writer.json(&state)?;
                writer.json(&measured)
            })?;
        }
        Ok(file.path(part))
    }

    /// Reads what was measured.
    fn measured(&self) -> Result<Measurement> {
        let (file, part) = (self.measured_file()?, Part::WHOLE);
        let opened = file.open(part)?;
        let identity = opened.tail.clone();
        let (place, reader) = named(opened);
        let mut reader = RecordReader::new(reader, place);
        let (state, measured): (String, Measured) = (reader.json()?, reader.json()?);
        if input::pictures_state(&measured.files_read(self.left))? != state {
            return Err(
                file.refused(part, "was made from another state of the pictures that it was measured on")
            );
        }
        let corrected = self.of(&measured).aligned().capture;
        Ok(Measurement { measured, identity, corrected })
    }

    /// The files of a part's frames, each once: those recorded as these frames, and those read for them where a camera's frames are moved
    /// in time. All parts together name every file of the capture.
    fn files_of(&self, measurement: &Measurement, part: Part) -> Vec<PathBuf> {
        let run = run_of_part(self.capture.frame_count(), part);
        let frames = run.start as usize..run.end as usize;
        let mut files = BTreeSet::new();
        for capture in [self.capture, &measurement.corrected] {
            for camera in 0..capture.cameras.len() {
                files.extend(frames.clone().flat_map(|frame| capture.files_of(camera, frame)));
            }
        }
        files.into_iter().collect()
    }

    fn scan_files(&self, measurement: &Measurement, part: Part) -> Result<PartFiles> {
        let pictures = self.files_of(measurement, part);
        let inputs = self
            .inputs()?
            .with("file of what was measured", &measurement.identity)
            .with("pictures of its frames", &input::pictures_state(&pictures)?);
        Ok(PartFiles::new(self.folder(), &self.name("scan"), inputs, "--stage scan"))
    }

    /// Passes over the frames of a part.
    pub(super) fn scan(&self, part: Part, job: &Job) -> Result<PathBuf> {
        let measurement = self.measured()?;
        let files = self.scan_files(&measurement, part)?;
        if !files.is_complete(part) {
            let of = self.of(&measurement.measured);
            let sums = input::sums_of(&self.files_of(&measurement, part), job)?;
            let removed = of.removed_pixels(part, job)?;
            files.write(part, |writer| {
                RecordWriter::new(writer, files.path(part).display().to_string())?.json(&(sums, removed))?;
                scan_part(of, part, writer, job)
            })?;
        }
        Ok(files.path(part))
    }

    /// The identity of each part of the scan.
    fn scans(&self, measurement: &Measurement, of: u32) -> Result<Vec<String>> {
        Part::all(of).map(|part| self.scan_files(measurement, part)?.identity(part)).collect()
    }

    /// A part of the scan, and what it begins with.
    fn open_scan(&self, measurement: &Measurement, part: Part) -> Result<(NamedPart, ScanHead)> {
        let mut opened = self.scan_files(measurement, part)?.open(part)?;
        let head =
            RecordReader::new(Box::new(&mut opened.reader), opened.path.display().to_string()).json()?;
        Ok((named(opened), head))
    }

    fn spans_file(&self, scans: &[String], of: u32) -> Result<PartFiles> {
        let inputs = self.inputs()?.with("parts of the scan", &scans.concat());
        let options = format!("--stage scan --join {of}");
        Ok(PartFiles::single(self.folder(), &self.name(&format!("spans-of-{of}")), inputs, &options))
    }

    /// Joins the spans that are longer than a run.
    pub(super) fn join_spans(&self, of: u32, job: &Job) -> Result<PathBuf> {
        let measurement = self.measured()?;
        let (file, part) = (self.spans_file(&self.scans(&measurement, of)?, of)?, Part::WHOLE);
        if !file.is_complete(part) {
            let opened = Part::all(of).map(|part| Ok(self.open_scan(&measurement, part)?.0));
            let parts = opened.collect::<Result<Vec<_>>>()?;
            file.write(part, |writer| join_spans(self.of(&measurement.measured), parts, writer, job))?;
        }
        Ok(file.path(part))
    }

    fn prune_files(&self, scans: &[String], spans: &str, part: Part) -> Result<PartFiles> {
        let read = scan_parts_read_by(self.capture.frame_count(), part);
        let read: String = read.iter().map(|part| scans[part.number() as usize - 1].as_str()).collect();
        let inputs =
            self.inputs()?.with("parts of the scan that it reads", &read).with("file of joined spans", spans);
        Ok(PartFiles::new(self.folder(), &self.name("prune"), inputs, "--stage prune"))
    }

    /// Prunes the frames of a part.
    pub(super) fn prune(&self, part: Part, job: &Job) -> Result<PathBuf> {
        let measurement = self.measured()?;
        let scans = self.scans(&measurement, part.of())?;
        let spans = self.spans_file(&scans, part.of())?.open(Part::WHOLE)?;
        let files = self.prune_files(&scans, &spans.tail, part)?;
        if !files.is_complete(part) {
            let read = scan_parts_read_by(self.capture.frame_count(), part).into_iter();
            let read =
                read.map(|part| Ok(self.open_scan(&measurement, part)?.0)).collect::<Result<Vec<_>>>()?;
            let from = self.of(&measurement.measured);
            files.write(part, |writer| prune_part(from, part, named(spans), read, writer, job))?;
        }
        Ok(files.path(part))
    }

    /// Joins the kept samples of all parts; also gives the files of the capture.
    pub(super) fn join_pruned(&self, of: u32, job: &Job) -> Result<(BufferedResult, Option<InputFiles>)> {
        let measurement = self.measured()?;
        let scans = self.scans(&measurement, of)?;
        let spans = self.spans_file(&scans, of)?.identity(Part::WHOLE)?;
        let (mut sums, mut removed) = (Vec::new(), vec![0; self.left.cameras.len()]);
        for part in Part::all(of) {
            let files = self.files_of(&measurement, part).into_iter();
            let (sums_of_part, removed_of_part) = self.open_scan(&measurement, part)?.1;
            sums.extend(files.zip(sums_of_part));
            removed.iter_mut().zip(removed_of_part).for_each(|(all, of_part)| *all += of_part);
        }
        let opened = Part::all(of).map(|part| Ok(named(self.prune_files(&scans, &spans, part)?.open(part)?)));
        let parts = opened.collect::<Result<Vec<_>>>()?;
        let from = self.of(&measurement.measured);
        let result = join_pruned(from, &self.capture.cameras, &removed, parts, job)?;
        Ok((result, input::summed_up(sums.into_iter())))
    }

    fn of<'b>(&'b self, measured: &'b Measured) -> MeasuredCapture<'b> {
        MeasuredCapture { capture: self.left, measured, settings: self.settings, edits: self.edits }
    }
}
