//! `overlook evaluate`: accuracy, speed and size of one setting.

use std::collections::BTreeSet;
use std::fmt::Write;
use std::path::PathBuf;

use clap::Args;
use serde::Serialize;

use super::render::PaintingArgs;
use crate::capture::{Capture, TruthView, transforms};
use crate::cli::input::HoldOutArgs;
use crate::cli::{CommandError, SettingsArgs, output};
use crate::evaluate::metrics::Scores;
use crate::evaluate::{Evaluation, MeanScore, MethodComparison, MethodScore, compare, truth};
use crate::settings::Settings;

/// Arguments of `overlook evaluate`.
#[derive(Debug, Args)]
pub(crate) struct EvaluateArgs {
    /// The capture: a folder or its transforms.json.
    capture: PathBuf,
    /// Vantages whose truth is known [default: the capture's novel/transforms.json].
    #[arg(long, value_name = "TRANSFORMS", conflicts_with = "hold_out")]
    views: Option<PathBuf>,
    #[command(flatten)]
    held_out: HoldOutArgs,
    #[command(flatten)]
    painting: PaintingArgs,
    #[command(flatten)]
    settings: SettingsArgs,
    /// Print one JSON document.
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct EvaluateOutput<'a> {
    #[serde(flatten)]
    as_set: &'a MethodScore,
    no_pruning: &'a MethodScore,
    first_camera: &'a MethodScore,
    hold_out: &'a [String],
    settings: &'a Settings,
}

impl EvaluateArgs {
    pub(crate) fn run(self) -> Result<(), CommandError> {
        let mut settings = self.settings.over(Settings::default())?;
        self.painting.apply(&mut settings.render);
        let capture = crate::cli::open_capture(&self.capture, &settings.capture)?;
        let (capture, views) = self.truth(capture)?;
        let comparison = output::watched(|job| compare(&capture, &views, &settings, job))?;
        let MethodComparison { as_set, no_pruning, first_camera } = &comparison;
        let notices = [as_set, no_pruning, first_camera].map(|compared| compared.evaluation.notice.clone());
        output::warn(&notices.into_iter().flatten().collect::<BTreeSet<_>>().into_iter().collect::<Vec<_>>());
        if self.json {
            return output::print_json(&EvaluateOutput {
                as_set,
                no_pruning,
                first_camera,
                hold_out: &self.held_out.names(),
                settings: &settings,
            });
        }
        output::print(&format!(
            "{}\n{}\n\n{}",
            view_table(&as_set.evaluation),
            painter_line(&as_set.evaluation),
            comparison_table(&comparison)
        ))
    }

    /// The capture to preprocess, and the views to score it at.
    fn truth(&self, capture: Capture) -> Result<(Capture, Vec<TruthView>), CommandError> {
        let held_out = self.held_out.names();
        if !held_out.is_empty() {
            return Ok(truth::split(&capture, &held_out)?);
        }
        let views = self.views.clone().or_else(|| transforms::truth_beside(&self.capture)).ok_or_else(|| {
            CommandError::Usage(format!(
                "{} comes without truth views; name some with --views, or hold out a camera with --hold-out {}",
                self.capture.display(),
                capture.cameras.first().map_or("CAMERA", |camera| &camera.name)
            ))
        })?;
        let views = transforms::open_views_of(&views, capture.frames_are_ranked())?;
        Ok((capture, views))
    }
}

/// Columns of accuracy, their names and the decimals they are worth. `PSNR dB` counts pixels that got a sample, `all dB`
/// all pixels; `edge` is the error near silhouettes, 8-bit steps.
const ACCURACY: [(&str, usize); 7] =
    [("PSNR dB", 2), ("all dB", 2), ("SSIM", 4), ("MS-SSIM", 4), ("FLIP", 4), ("edge", 2), ("cover", 3)];

fn accuracy_head() -> String {
    ACCURACY.iter().fold(String::new(), |mut text, (name, _)| {
        let _ = write!(text, " {name:>8}");
        text
    })
}

fn accuracy_columns(values: [Option<f64>; ACCURACY.len()]) -> String {
    let columns = values.iter().zip(ACCURACY);
    columns.fold(String::new(), |mut text, (value, (_, decimals))| {
        let _ = write!(text, " {}", output::number(*value, decimals, 8));
        text
    })
}

fn of_view(scores: &Scores) -> [Option<f64>; ACCURACY.len()] {
    let s = scores;
    let [psnr_db, all_db, ssim, ms_ssim, flip, coverage] =
        [s.psnr_db, s.psnr_all_db, s.ssim, s.ms_ssim, s.flip, s.coverage].map(Some);
    [psnr_db, all_db, ssim, ms_ssim, flip, s.silhouette_steps, coverage]
}

fn of_mean(mean: &MeanScore) -> [Option<f64>; ACCURACY.len()] {
    let m = mean;
    [m.psnr_db, m.psnr_all_db, m.ssim, m.ms_ssim, m.flip, m.silhouette_steps, m.coverage]
}

/// One line per view, then the mean.
pub(crate) fn view_table(evaluation: &Evaluation) -> String {
    let mut text = format!("{:<28}{} {:>10} {:>12}", "view", accuracy_head(), "ms", "samples");
    let mut line = |name: &str, values, milliseconds, samples| {
        let samples = output::count(samples);
        let _ = write!(text, "\n{name:<28}{} {milliseconds:>10.1} {samples:>12}", accuracy_columns(values));
    };
    for view in &evaluation.views {
        let values = view.scores.as_ref().map_or([None; ACCURACY.len()], of_view);
        line(&view.file_path, values, view.milliseconds, view.samples);
    }
    let mean = &evaluation.mean;
    line("mean", of_mean(mean), mean.milliseconds, mean.samples as u64);
    if let Some(steps) = mean.flicker_steps {
        let _ = write!(text, "\nFlicker at still vantages: {steps:.2} 8-bit steps");
    }
    text
}

/// What painted, where any view was.
pub(crate) fn painter_line(evaluation: &Evaluation) -> String {
    let painters: BTreeSet<String> = evaluation.views.iter().map(|view| view.painter.to_string()).collect();
    format!("Painted by {}", painters.into_iter().collect::<Vec<_>>().join(" and "))
}

/// One line per way to prune.
fn comparison_table(comparison: &MethodComparison) -> String {
    let mut text = format!(
        "{:<16}{} {:>10} {:>14} {:>12} {:>12}",
        "pruning",
        accuracy_head(),
        "ms",
        "samples kept",
        "in memory",
        "in the store"
    );
    for compared in [&comparison.as_set, &comparison.no_pruning, &comparison.first_camera] {
        let mean = &compared.evaluation.mean;
        let _ = write!(
            text,
            "\n{:<16}{} {:>10.1} {:>14} {:>12} {:>12}",
            compared.method.name(),
            accuracy_columns(of_mean(mean)),
            mean.milliseconds,
            output::count(compared.samples_kept),
            output::bytes(compared.bytes_memory),
            output::bytes(compared.bytes_store)
        );
    }
    text
}
