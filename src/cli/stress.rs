//! `overlook stress`: accuracy against the size of a disturbance, with and without defenses.

use std::fmt::Write;
use std::path::PathBuf;

use clap::Args;
use clap::builder::PossibleValuesParser;
use serde::Serialize;

use super::truth::TruthArgs;
use super::{Failure, SettingsArgs, output, progress, results};
use crate::capture::transforms;
use crate::evaluate::stress::{self, Disturbance, Failure as PointOfFailure, Plan, StressPoint};
use crate::evaluate::truth::Truth;
use crate::settings::Settings;

/// Arguments of `overlook stress`.
#[derive(Debug, Args)]
pub(super) struct StressArgs {
    /// The capture: a folder or its transforms.json.
    capture: PathBuf,
    #[command(flatten)]
    truth: TruthArgs,
    /// Folder for stress.csv, stress.json and stress.png. A run that was cut short goes on from what it left there.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Apply this disturbance alone; may be given several times.
    #[arg(long, value_name = "NAME", value_parser = PossibleValuesParser::new(Disturbance::ALL.map(Disturbance::name)))]
    only: Vec<String>,
    #[command(flatten)]
    settings: SettingsArgs,
    /// Print one JSON document.
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct StressOutput<'a> {
    capture: &'a str,
    truth: String,
    points: &'a [StressPoint],
    failures: &'a [PointOfFailure],
}

impl StressArgs {
    pub(super) fn run(self) -> Result<(), Failure> {
        let settings = self.settings.over(Settings::default())?;
        let capture = transforms::open(&self.capture, &settings.capture)?;
        output::warn(&capture.warnings);
        let truth: Truth = self.truth.truth(&self.capture, &capture)?;
        let mut plan = Plan { frames: self.truth.frames, ..Plan::standard(&settings) };
        if !self.only.is_empty() {
            plan.disturbances.retain(|disturbance| self.only.iter().any(|name| name == disturbance.name()));
        }
        let journal = results::Journal::open(&self.out, "stress", &self.truth.fingerprint(&capture))?;
        plan.done = journal.points();
        let mut trouble = None;
        let points = progress::watched(|job| {
            stress::run(&capture, &plan, &truth, job, |point, _| {
                if let Err(error) = journal.add(point) {
                    trouble = Some(error);
                    job.cancel();
                }
            })
        });
        if let Some(error) = trouble {
            return Err(error.into());
        }
        let points = points?;
        let failures = stress::failures(&points);
        let document = StressOutput {
            capture: &capture.name,
            truth: self.truth.words(&capture),
            points: &points,
            failures: &failures,
        };
        results::write_json(&self.out.join("stress.json"), &document)?;
        results::write_csv(&self.out.join("stress.csv"), &points)?;
        if self.json { output::print_json(&document) } else { output::print(&table(&points, &failures)) }
    }
}

/// Per disturbance and method: accuracy and share kept along the dial, and where 1 dB is lost.
fn table(points: &[StressPoint], failures: &[PointOfFailure]) -> String {
    let mut text = String::new();
    for failure in failures {
        let along = points
            .iter()
            .filter(|point| point.disturbance == failure.disturbance && point.method == failure.method);
        let along: Vec<String> = along
            .map(|point| {
                format!(
                    "{}: {:.2} dB {:.0} %",
                    point.dial,
                    point.point.psnr_filled_db,
                    100.0 * point.kept_share
                )
            })
            .collect();
        let _ = writeln!(
            text,
            "{:<26} {:<18} loses 1 dB at {:<28} {}",
            failure.disturbance,
            failure.method,
            failure.dial.map_or_else(
                || format!("none ({:.2} dB at most)", failure.worst_loss_db),
                |dial| format!("{dial:.3} {}", failure.unit)
            ),
            along.join(", ")
        );
    }
    text.truncate(text.trim_end().len());
    text
}
