//! `overlook preprocess`: from a capture to a store.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::PathBuf;
use std::time::Instant;

use clap::Args;
use rayon::prelude::*;
use serde::Serialize;

use crate::alignment::Alignment;
use crate::capture::{self, Capture};
use crate::cli::input::{self, HoldOutArgs, SettingsArgs};
use crate::cli::output::{self, CommandError};
use crate::error::{Error, Result};
use crate::evaluate::truth;
use crate::job::Job;
use crate::plural::counted;
use crate::preprocess::diagnostics::{CameraReport, PairResiduals, Report};
use crate::preprocess::{BufferedResult, preprocess_buffered};
use crate::settings::{CaptureSettings, Settings, SpanLevels};
use crate::store::file::{self, Extras, Provenance};

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
    /// Read at most this many views: those that together show the most [default: as the settings say].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096))]
    views: Option<u32>,
    /// Also measure how long decoding every frame takes on its own.
    #[arg(long)]
    measure_decode: bool,
    /// Print one JSON document.
    #[arg(long)]
    json: bool,
}

/// The settings for frames that are read once.
fn one_frame(settings: &Settings) -> CaptureSettings {
    CaptureSettings { cache: 16, ..settings.capture.clone() }
}

/// The tree of spans reads every frame once, the paper's two lengths twice.
fn frame_cache(settings: &Settings) -> CaptureSettings {
    if settings.spans.levels == SpanLevels::Tree { one_frame(settings) } else { settings.capture.clone() }
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
    threads: usize,
    report: Report,
}

impl PreprocessArgs {
    pub(crate) fn run(self) -> Result<(), CommandError> {
        let mut settings = self.settings.over(Settings::default())?;
        settings.capture.views = self.views.unwrap_or(settings.capture.views);
        output::check_file(&self.out, "scene.ovl")?;
        self.settings.refuse_inputs(&self.out)?;
        let capture = self.open(&frame_cache(&settings))?;
        output::refuse_capture_files(&self.capture, None, &self.out)?;
        output::warn(&capture.warnings);
        let seconds_decode_only =
            if self.measure_decode { Some(self.decode_seconds(&settings)?) } else { None };
        let started = Instant::now();
        let (report, bytes_store) = output::watched(|job| {
            let BufferedResult { outline, images, report } = preprocess_buffered(&capture, &settings, job)?;
            let inputs = input::input_files(&capture, job)?;
            let frames_are_ranked = capture.frames_are_ranked();
            let provenance = Provenance { inputs, frames_are_ranked, ..Provenance::default() };
            let extras = Extras { report: report.to_json()?, provenance, ..Extras::default() };
            let bytes = file::write_spooled(&self.out, &outline, &images, &extras, job)?;
            Ok::<_, Error>((report, bytes))
        })?;
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
            threads: rayon::current_num_threads(),
            report,
        };
        if self.json { output::print_json(&result) } else { output::print(&self.text(&result)) }
    }

    fn open(&self, settings: &CaptureSettings) -> Result<Capture> {
        let capture = capture::open(&self.capture, settings)?;
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
        let disputes: u64 = result.report.rate_disputes.iter().flatten().sum();
        let _ = writeln!(
            text,
            "  of the points of {} the paper's rate and the footprint name different cameras as the best-sampled",
            output::count_of(disputes, "sample")
        );
        for (outcome, samples) in result.report.mixed_pixels.iter().filter(|(_, samples)| **samples > 0) {
            let _ = writeln!(text, "  mixed across a silhouette, {outcome}: {}", output::count(*samples));
        }
        for camera in &result.report.cameras {
            let _ = writeln!(text, "  {}", measured(camera));
            if let Some(noise) = camera.noise_between() {
                let _ = writeln!(text, "    {noise}");
            }
        }
        for line in result.report.alignment.iter().flat_map(Alignment::sentences) {
            let _ = writeln!(text, "  corrected {line}");
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
    let pairs = report.residuals.iter().enumerate().flat_map(|(a, row)| {
        let of = move |(b, pair): (usize, &PairResiduals)| Some((pair.lasting?.most_footprints, a, b));
        row.iter().enumerate().filter_map(of)
    });
    pairs.max_by(|a, b| a.0.total_cmp(&b.0))
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
