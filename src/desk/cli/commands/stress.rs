//! `overlook stress`: accuracy against the size of a disturbance, with and without defenses.

use std::fmt::Write;
use std::path::PathBuf;

use clap::Args;
use clap::builder::PossibleValuesParser;

use crate::cli::input::{self, BudgetArgs, SettingsArgs, TruthArgs};
use crate::cli::output::{self, CommandError, SavedPicture, StressDocument};
use overlook_engine::capture::Capture;
use overlook_engine::settings::Settings;
use overlook_lab::chart;
use overlook_lab::stress::{self, BreakingPoint, Disturbance, StressPlan, StressPoint};
use overlook_lab::trial::Measured;
use overlook_lab::truth::Truth;

#[derive(Debug, Args)]
pub(crate) struct StressArgs {
    /// The capture: a folder, or the file in it that names its pictures.
    capture: PathBuf,
    #[command(flatten)]
    truth: TruthArgs,
    /// Folder for stress.csv, stress.json, stress.png and .svg, pictures at the breaking points, and report.html with all of it. An interrupted
    /// run resumes from the results there.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Apply this disturbance alone; may be given several times.
    #[arg(long, value_name = "NAME", value_parser = PossibleValuesParser::new(Disturbance::ALL.map(Disturbance::name)))]
    only: Vec<String>,
    #[command(flatten)]
    budget: BudgetArgs,
    #[command(flatten)]
    settings: SettingsArgs,
    /// Print one JSON document.
    #[arg(long)]
    json: bool,
}

impl StressArgs {
    pub(crate) fn run(self) -> Result<(), CommandError> {
        let settings = self.settings.over(Settings::default())?;
        output::check_folder(&self.out)?;
        let capture = input::open_capture(&self.capture, &settings.capture)?;
        let truth: Truth = self.truth.truth(&self.capture, &capture)?;
        let mut plan = StressPlan {
            frames: self.truth.frames,
            budget: self.budget.budget,
            ..StressPlan::standard(&settings).with_rivals(&settings)
        };
        if !self.only.is_empty() {
            plan.disturbances.retain(|disturbance| self.only.iter().any(|name| name == disturbance.name()));
        }
        let fingerprint = self.truth.fingerprint(&self.capture, &capture, &truth)?;
        let journal = output::Journal::open(&self.out, "stress", &fingerprint)?;
        plan.done = journal.points();
        let Measured { points, left } = output::recorded(Some(&journal), |job, keep| {
            stress::run(&capture, &plan, &truth, job, |point, _| keep(point))
        })?;
        let failures = stress::failures(&points);
        let breaking = self.breaking(&capture, &truth, &plan, &points)?;
        let chart = chart::stress(&capture.name, &points);
        let document = StressDocument {
            capture: capture.name.clone(),
            truth: self.truth.words(&capture, &truth),
            command: output::command(),
            version: output::version(),
            points,
            failures,
            breaking,
        };
        output::write_results(&self.out, "stress", &document, &document.points, "stress.png", &chart)?;
        output::write_page(std::slice::from_ref(&self.out), &self.out.join(output::PAGE))?;
        BudgetArgs::warn_of(left);
        if self.json {
            output::print_json(&document)
        } else {
            output::print(&table(&document.points, &document.failures))
        }
    }

    /// Writes a picture at the breaking point of each disturbance.
    fn breaking(
        &self,
        capture: &Capture,
        truth: &Truth,
        plan: &StressPlan,
        points: &[StressPoint],
    ) -> Result<Vec<SavedPicture>, CommandError> {
        let views = output::watched(|job| stress::breaking_views(capture, plan, truth, points, job))?;
        let mut saved = Vec::new();
        for view in &views {
            let file = format!("breaking/{}.png", view.disturbance.replace(' ', "-"));
            let caption = format!(
                "{} at {} {}: {:.2} dB lost over all viewpoints; {} has {:.2} dB",
                view.disturbance,
                view.dial,
                view.unit,
                view.loss_db,
                view.shown.file_path,
                view.shown.psnr_filled_db
            );
            saved.push(output::save_picture(&self.out, &file, caption, &view.shown)?);
        }
        Ok(saved)
    }
}

/// Per disturbance: the dial at which each method loses 1 dB, and the smallest lead of ours over each other method.
fn table(points: &[StressPoint], failures: &[BreakingPoint]) -> String {
    let methods = stress::distinct(failures.iter().map(|failure| failure.method.as_str()));
    let mut text = format!("{:<44}", "1 dB is lost at");
    for method in &methods {
        let _ = write!(text, " {method:>18}");
    }
    for method in methods.iter().skip(1) {
        let _ = write!(text, " {:>26}", format!("least over {method}"));
    }
    for first in failures.iter().filter(|failure| Some(&failure.method.as_str()) == methods.first()) {
        let name = format!("{}, {}", first.disturbance, first.unit);
        let _ = write!(text, "\n{name:<44}");
        for method in &methods {
            let failure = failures
                .iter()
                .find(|other| other.disturbance == first.disturbance && other.method == *method);
            let dial = failure.map_or_else(String::new, |failure| {
                failure.dial.map_or_else(
                    || format!("never ({:.2} dB)", failure.worst_loss_db),
                    |dial| format!("{dial:.2}"),
                )
            });
            let _ = write!(text, " {dial:>18}");
        }
        for method in methods.iter().skip(1) {
            let lead = least_lead_db(points, &first.disturbance, [&first.method, method]);
            let _ = write!(text, " {:>26}", format!("{lead:+.2} dB"));
        }
    }
    text
}

/// The smallest lead of one method over another along the dial of a disturbance, dB; negative if it is behind.
fn least_lead_db(points: &[StressPoint], disturbance: &str, [ahead, behind]: [&str; 2]) -> f64 {
    let of = |method: &str| {
        let matching =
            points.iter().filter(|point| point.disturbance == disturbance && point.method == method);
        matching.map(|point| point.point.psnr_filled_db).collect::<Vec<f64>>()
    };
    of(ahead).iter().zip(of(behind)).map(|(ahead, behind)| ahead - behind).fold(f64::INFINITY, f64::min)
}
