//! `overlook preprocess`: from a capture to a store.

mod stages;

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use rayon::prelude::*;
use serde::Serialize;

use crate::cli::input::{self, HoldOutArgs, SettingsArgs};
use crate::cli::output::{self, CommandError};
use crate::pruned_store;
use overlook_engine::capture::{self, Capture};
use overlook_engine::edits::{self, EditList};
use overlook_engine::error::{Error, Result};
use overlook_engine::job::Job;
use overlook_engine::part::{MOST_PARTS, Part};
use overlook_engine::plural::counted;
use overlook_engine::preprocess::diagnostics::{CameraReport, PixelAccount, Report};
use overlook_engine::settings::{CaptureSettings, Settings, SpanLevels};
use overlook_lab::truth::{self, ViewCorrections};
use stages::{PreprocessStage, Stages};

/// Which part of the work to do, or to put parts together.
#[derive(Debug, Args)]
struct PartArgs {
    /// Do one part of the work, as in `--part 2/6`: the second of six. Several machines can each do one. The part becomes one file
    /// beside the results, complete or not there at all.
    #[arg(long, value_name = "K/N", conflicts_with = "join")]
    part: Option<Part>,
    /// Put N parts together that --part made: the results are those of one piece of work. A part whose input has changed since is
    /// refused.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(MOST_PARTS)))]
    join: Option<u32>,
}

#[derive(Debug, Args)]
pub(crate) struct PreprocessArgs {
    /// The capture: a folder, or the file in it that names its pictures.
    capture: PathBuf,
    /// The store to write.
    #[arg(long, value_name = "F.ovl")]
    out: PathBuf,
    #[command(flatten)]
    settings: SettingsArgs,
    #[command(flatten)]
    held_out: HoldOutArgs,
    /// Use only the cameras that this file names, one a line, as `overlook tune --fewest-views` writes it.
    #[arg(long, value_name = "FILE")]
    only: Option<PathBuf>,
    /// Obey this edit list (TOML, as the window saves it): cameras that are left out take no part, and what is deleted in a region counts
    /// as pixels without depth before pruning, so that no other pixel brings it back.
    #[arg(long, value_name = "FILE")]
    edits: Option<PathBuf>,
    /// Do one stage of the work, cut by runs of frames for several machines. In this order: `measure`; each `--part` of `scan`, then
    /// its `--join`; each `--part` of `prune`, then its `--join`, which writes the store. Files between stages are beside the store, under
    /// its name.
    #[arg(long, value_enum)]
    stage: Option<PreprocessStage>,
    #[command(flatten)]
    parts: PartArgs,
    /// Also measure how long decoding every frame takes on its own.
    #[arg(long)]
    measure_decode: bool,
    /// Print one JSON document.
    #[arg(long)]
    json: bool,
}

/// The settings for frames that are read once.
fn one_frame(settings: &Settings) -> CaptureSettings {
    CaptureSettings { memory: 16, ..settings.capture.clone() }
}

/// The tree of spans reads every frame once, the paper's two lengths twice.
fn frame_cache(settings: &Settings) -> CaptureSettings {
    if settings.spans.levels == SpanLevels::Tree { one_frame(settings) } else { settings.capture.clone() }
}

/// A part of the work.
enum Work {
    Whole,
    Measure,
    Part(PreprocessStage, Part),
    Join(PreprocessStage, u32),
}

#[derive(Serialize)]
struct PreprocessOutput {
    samples_in: u64,
    samples_kept: u64,
    /// All input pixels as 8-bit color and 32-bit depth.
    bytes_raw: u64,
    bytes_memory: u64,
    bytes_store: u64,
    /// From the open capture to the whole store, without what --measure-decode adds.
    seconds_total: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    seconds_decode_only: Option<f64>,
    peak_rss_bytes: Option<u64>,
    pruned: BTreeMap<String, u64>,
    /// What became of every pixel, in numbers that add up to `samples_in`.
    pixels: PixelAccount,
    threads: usize,
    report: Report,
}

impl PreprocessArgs {
    pub(crate) fn run(self) -> Result<(), CommandError> {
        let settings = self.settings.over(Settings::default())?;
        output::check_file(&self.out, "scene.ovl")?;
        self.settings.refuse_inputs(&self.out)?;
        let edits = self.edits()?;
        let capture = self.open(&frame_cache(&settings))?;
        output::refuse_capture_files(&self.capture, None, &self.out)?;
        output::warn(&capture.warnings);
        let seconds_decode_only =
            if self.measure_decode { Some(self.decode_seconds(&settings)?) } else { None };
        let started = Instant::now();
        let left = edits::with_cameras_left(&capture, &edits)?;
        let (path, out, settings, left) = (&self.capture, &self.out, &settings, &left);
        let stages = Stages { path, capture: &capture, out, settings, edits: &edits, left };
        let (report, bytes_store) = match self.work()? {
            Work::Whole => output::watched(|job| {
                pruned_store::prune_into_store(&capture, None, settings, &edits, &self.out, job)
            })?,
            Work::Measure => {
                return self.left(&output::watched(|job| stages.measure(job))?, "--stage scan --part 1/N");
            }
            Work::Part(stage, part) => {
                let file = output::watched(|job| {
                    if stage == PreprocessStage::Prune {
                        stages.prune(part, job)
                    } else {
                        stages.scan(part, job)
                    }
                })?;
                return output::print_parts(part, &[file], self.json);
            }
            Work::Join(PreprocessStage::Prune, of) => output::watched(|job| {
                let (result, inputs) = stages.join_pruned(of, job)?;
                pruned_store::write(&capture, result, inputs, &self.out, job)
            })?,
            Work::Join(_, of) => {
                let next = format!("--stage prune --part 1/{of}");
                return self.left(&output::watched(|job| stages.join_spans(of, job))?, &next);
            }
        };
        output::warn(&report.warnings());
        let result = PreprocessOutput {
            samples_in: report.samples_in,
            samples_kept: report.samples_kept,
            bytes_raw: report.bytes_raw,
            bytes_memory: report.bytes_memory,
            bytes_store,
            seconds_total: started.elapsed().as_secs_f64(),
            seconds_decode_only,
            peak_rss_bytes: output::peak_rss_bytes(),
            pruned: report.pruned.clone(),
            pixels: report.pixel_account(),
            threads: rayon::current_num_threads(),
            report,
        };
        if self.json { output::print_json(&result) } else { output::print(&self.text(&result)) }
    }

    /// The part of the work that the options choose.
    fn work(&self) -> Result<Work, CommandError> {
        let usage = |what: &str| Err(CommandError::Usage(what.to_owned()));
        match (self.stage, self.parts.part, self.parts.join) {
            (None, None, None) => Ok(Work::Whole),
            (None, ..) => usage("--part and --join are of one stage; name it with --stage"),
            (Some(PreprocessStage::Measure), None, None) => Ok(Work::Measure),
            (Some(PreprocessStage::Measure), ..) => {
                usage("--stage measure is not cut into parts; leave --part and --join out")
            }
            (Some(stage), Some(part), _) => Ok(Work::Part(stage, part)),
            (Some(stage), None, Some(of)) => Ok(Work::Join(stage, of)),
            (Some(_), None, None) => {
                usage("name the part of the stage, as in --part 2/6, or put all parts together with --join 6")
            }
        }
    }

    /// Reports the file of a stage, and the next step.
    fn left(&self, file: &Path, next: &str) -> Result<(), CommandError> {
        if self.json {
            return output::print_json(&serde_json::json!({ "files": [file] }));
        }
        output::print(&format!("Wrote {}\nNext: the same command with {next}", file.display()))
    }

    /// The list of edits, empty where none is named.
    fn edits(&self) -> Result<EditList> {
        let Some(file) = &self.edits else { return Ok(EditList::default()) };
        output::refuse_input(file, &self.out)?;
        EditList::load(file)
    }

    fn open(&self, settings: &CaptureSettings) -> Result<Capture> {
        let mut capture = capture::open(&self.capture, settings)?;
        if let Some(file) = &self.only {
            capture = input::only_cameras(&capture, file)?;
        }
        let held_out = self.held_out.names();
        if held_out.is_empty() { Ok(capture) } else { Ok(truth::split(&capture, &held_out)?.0) }
    }

    /// Decodes every frame once, through a capture of its own so that neither cache helps the other.
    fn decode_seconds(&self, settings: &Settings) -> Result<f64> {
        let capture = self.open(&one_frame(settings))?;
        let frames = capture.frame_count();
        output::watched(|job: &Job| {
            let started = Instant::now();
            job.start("Decoding frames", capture.cameras.len() * frames);
            (0..capture.cameras.len() * frames).into_par_iter().try_for_each(|index| {
                job.check()?;
                capture.frame(index / frames, index % frames)?;
                job.advance(1);
                Ok::<_, Error>(())
            })?;
            Ok(started.elapsed().as_secs_f64())
        })
    }

    fn text(&self, result: &PreprocessOutput) -> String {
        let kept = output::count(result.samples_kept);
        let all = output::count_of(result.samples_in, "sample");
        let share = output::percent(result.samples_kept, result.samples_in);
        let mut text = format!("Kept {kept} of {all} ({share})\n");
        for (rule, dropped) in &result.pruned {
            let _ = writeln!(text, "  dropped {:>16}  {rule}", output::count(*dropped));
        }
        if result.report.samples_doubtful > 0 {
            let doubtful = output::count(result.report.samples_doubtful);
            let _ = writeln!(
                text,
                "  doubtful {doubtful:>15}  no other camera confirms them: shown where nothing else is"
            );
        }
        text += &output::without_depth(&result.report).unwrap_or_default();
        text += &output::cut_by_hand(&result.report);
        for (outcome, samples) in result.report.mixed_pixels.iter().filter(|(_, samples)| **samples > 0) {
            let _ = writeln!(text, "  mixed across a silhouette, {outcome}: {}", output::count(*samples));
        }
        for camera in &result.report.cameras {
            let _ = writeln!(text, "  {}", measured(camera));
            if let Some(noise) = camera.noise_between() {
                let _ = writeln!(text, "    {noise}");
            }
        }
        if let Some(alignment) = &result.report.alignment {
            for line in alignment.sentences().into_iter().chain(ViewCorrections::of(alignment).sentence()) {
                let _ = writeln!(text, "  corrected {line}");
            }
            for line in alignment.refusals() {
                let _ = writeln!(text, "  not corrected: {line}");
            }
        }
        if let Some((off, a, b)) = farthest_apart(&result.report) {
            let [a, b] = [a, b].map(|camera| &result.report.cameras[camera].name);
            let _ =
                writeln!(text, "  farthest apart about what never moves: {a} and {b}, {off:.2} footprints");
        }
        let [raw, memory, store] =
            [result.bytes_raw, result.bytes_memory, result.bytes_store].map(output::bytes);
        let _ = writeln!(text, "Raw {raw}, in memory {memory}, in the store {store}");
        let _ = write!(text, "Took {:.1} s on {}", result.seconds_total, counted(result.threads, "thread"));
        if let Some(seconds) = result.seconds_decode_only {
            let _ = write!(text, ", decoding alone {seconds:.1} s");
        }
        if let Some(bytes) = result.peak_rss_bytes {
            let _ = write!(text, ", at most {} of memory", output::bytes(bytes));
        }
        let store = self.out.display();
        let _ =
            write!(text, "\nNext: overlook {store}, or overlook render {store} --views TRANSFORMS --out DIR");
        text
    }
}

/// The two cameras that agree least on what never changes, and the footprints that 85 % of their samples differ by at most;
/// `None` if no two see the same.
fn farthest_apart(report: &Report) -> Option<(f32, usize, usize)> {
    let pairs = report.residuals.iter();
    pairs
        .filter_map(|(a, b, pair)| Some((pair.lasting?.most_footprints, a, b)))
        .max_by(|a, b| a.0.total_cmp(&b.0))
}

/// A line on the noise of a camera, and the shares of its pixels within the tolerances of spans.
fn measured(camera: &CameraReport) -> String {
    let ranges = &camera.ranges;
    let [within, with_noise, depth] =
        [ranges.within_color_tolerance, ranges.within_color_tolerance_and_noise, ranges.within_depth_granted]
            .map(|share| 100.0 * share);
    let CameraReport { name, color_noise_steps, depth_noise_relative, depth_step_relative, .. } = camera;
    format!(
        "{name}: color noise {color_noise_steps:.2} steps, depth noise {depth_noise_relative:.1e}, depth step \
         {depth_step_relative:.1e}; {within:.1} % of the pixels stay within the color tolerance, {with_noise:.1} % with noise, \
         {depth:.1} % within a depth range of {:.1e}",
        ranges.depth_granted_relative
    )
}
