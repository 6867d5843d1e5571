//! `overlook tune`: no more model than the scene needs.

mod views;

use std::path::{Path, PathBuf};

use clap::Args;

use crate::cli::input::{self, SettingsArgs, TruthArgs};
use crate::cli::output::{self, CommandError};
use overlook_engine::settings::Settings;
use overlook_engine::whole_file;
use overlook_lab::tune::{self, TuneBudget, TunePlan};

#[derive(Debug, Args)]
pub(crate) struct TuneArgs {
    /// The capture: a folder, or the file in it that names its pictures.
    capture: PathBuf,
    #[command(flatten)]
    truth: TruthArgs,
    /// The settings that were found, as TOML for --settings.
    #[arg(long, value_name = "S.toml", required_unless_present = "fewest_views")]
    out: Option<PathBuf>,
    /// Choose the fewest views that show everything, by what each adds, instead of settings. The folder gets their names in views.txt
    /// (for `overlook preprocess --only`), the curve of coverage and accuracy against their number in views.json, views.csv and
    /// views.png, and report.html. Without true pictures, accuracy is measured at views that were not chosen.
    #[arg(long, value_name = "DIR", conflicts_with_all = ["out", "max_bytes", "max_ms", "at_most", "all_cameras", "journal"])]
    fewest_views: Option<PathBuf>,
    /// Percentage of the surface seen by all views that the chosen views must show [default: 99].
    #[arg(long = "show", value_name = "PERCENT", value_parser = parse_percent)]
    show_percent: Option<f64>,
    /// Take the most accurate setting whose store of the whole capture has at most this many bytes, instead of the simplest good
    /// enough.
    #[arg(long, value_name = "BYTES", conflicts_with = "max_ms", value_parser = clap::value_parser!(u64).range(1..))]
    max_bytes: Option<u64>,
    /// Take the most accurate setting that renders a view within this many milliseconds on this machine, holes not filled.
    #[arg(long, value_name = "MS", allow_negative_numbers = true, value_parser = parse_milliseconds)]
    max_ms: Option<f64>,
    /// Lose at most this many dB against the most accurate setting, with 95 % confidence.
    #[arg(long, value_name = "DB", default_value_t = tune::AT_MOST_DB, allow_negative_numbers = true, value_parser = parse_decibels, conflicts_with_all = ["max_bytes", "max_ms"])]
    at_most: f64,
    /// Keep all cameras.
    #[arg(long)]
    all_cameras: bool,
    /// Folder for the measurements, from which an interrupted run resumes.
    #[arg(long, value_name = "DIR")]
    journal: Option<PathBuf>,
    #[command(flatten)]
    settings: SettingsArgs,
    /// Print one JSON document.
    #[arg(long)]
    json: bool,
}

impl TuneArgs {
    pub(crate) fn run(self) -> Result<(), CommandError> {
        let settings = self.settings.over(Settings::default())?;
        if let Some(folder) = &self.fewest_views {
            return self.run_views(folder, &settings);
        }
        let Some(out) = &self.out else {
            return Err(CommandError::Usage("give --out or --fewest-views".to_owned()));
        };
        if self.show_percent.is_some() {
            return Err(CommandError::Usage(
                "--show is the goal of --fewest-views; give that option too".to_owned(),
            ));
        }
        output::check_file(out, "tuned.toml")?;
        output::refuse_store(out)?;
        self.settings.refuse_inputs(out)?;
        if let Some(journal) = &self.journal {
            output::check_folder(journal)?;
        }
        let opened = input::open_capture(&self.capture, &settings.capture)?;
        output::refuse_capture_files(&self.capture, self.truth.views.as_deref(), out)?;
        let (capture, truth) = self.truth.open(&self.capture, &opened)?;
        let journal = match &self.journal {
            Some(folder) => {
                let fingerprint = self.truth.fingerprint(&self.capture, &opened, &truth)?;
                Some(output::Journal::open(folder, "tune", &fingerprint)?)
            }
            None => None,
        };
        let budget = self.max_bytes.map(TuneBudget::Bytes).or(self.max_ms.map(TuneBudget::Milliseconds));
        let done = journal.as_ref().map(output::Journal::points).unwrap_or_default();
        let plan = TunePlan {
            budget,
            whole: Some(opened),
            at_most_db: self.at_most,
            drop_cameras: !self.all_cameras,
            done,
            ..TunePlan::of(settings)
        };
        let tuned =
            output::recorded(journal.as_ref(), |job, keep| tune::run(&capture, &plan, &truth, job, keep))?;
        let head = format!("# {}\n\n", tuned.words.join("\n# "));
        let written = whole_file::write_all(out, head + &tuned.settings.to_toml());
        // Results of hours of work are printed even if the file cannot be written.
        if self.json {
            output::print_json(&tuned)?;
        } else {
            output::print(&format!("{}\nCameras: {}", tuned.words.join("\n"), tuned.cameras.join(", ")))?;
        }
        written?;
        if self.json { Ok(()) } else { output::print(&format!("Wrote {}", out.display())) }
    }
}

impl TuneArgs {
    fn run_views(&self, folder: &Path, settings: &Settings) -> Result<(), CommandError> {
        output::check_folder(folder)?;
        let opened = input::open_capture(&self.capture, &settings.capture)?;
        let (capture, truth) = self.truth.open(&self.capture, &opened)?;
        self.choose_views(folder, settings, &capture, &truth)
    }
}

fn parse_decibels(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number: &f64| number.is_finite() && *number >= 0.0);
    number.ok_or_else(|| "write a number of dB, 0 or more, as in 0.1".to_owned())
}

fn parse_percent(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number: &f64| *number > 0.0 && *number <= 100.0);
    number.ok_or_else(|| "write a share in percent, above 0 and up to 100, as in 99.5".to_owned())
}

fn parse_milliseconds(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number: &f64| number.is_finite() && *number > 0.0);
    number.ok_or_else(|| "write a number above 0, as in 16.7".to_owned())
}
