//! `overlook tune`: no more model than the scene needs.

use std::path::PathBuf;

use clap::Args;

use super::truth::TruthArgs;
use super::{Failure, SettingsArgs, output, results, targets};
use crate::error::Error;
use crate::evaluate::tune::{self, Budget, Plan};
use crate::settings::Settings;

/// Arguments of `overlook tune`.
#[derive(Debug, Args)]
pub(super) struct TuneArgs {
    /// The capture: a folder or its transforms.json.
    capture: PathBuf,
    #[command(flatten)]
    truth: TruthArgs,
    /// The settings that were found, as TOML for --settings.
    #[arg(long, value_name = "S.toml")]
    out: PathBuf,
    /// Take the most accurate setting whose store has at most so many bytes, instead of the simplest good enough.
    #[arg(long, value_name = "BYTES", conflicts_with = "max_ms")]
    max_bytes: Option<u64>,
    /// Take the most accurate setting that paints a view within so many milliseconds on this machine.
    #[arg(long, value_name = "MS")]
    max_ms: Option<f64>,
    /// Keep all cameras.
    #[arg(long)]
    all_cameras: bool,
    /// Folder to keep what was measured in, so that a run that was cut short goes on from there.
    #[arg(long, value_name = "DIR")]
    journal: Option<PathBuf>,
    #[command(flatten)]
    settings: SettingsArgs,
    /// Print one JSON document.
    #[arg(long)]
    json: bool,
}

impl TuneArgs {
    pub(super) fn run(self) -> Result<(), Failure> {
        let settings = self.settings.over(Settings::default())?;
        targets::file(&self.out, "tuned.toml")?;
        targets::apart_from_stores(&self.out)?;
        let opened = super::open_capture(&self.capture, &settings.capture)?;
        targets::apart_from_capture(&self.capture, self.truth.views.as_deref(), &self.out)?;
        let (capture, truth) = self.truth.open(&self.capture, &opened)?;
        let journal = match &self.journal {
            Some(folder) => {
                let fingerprint = self.truth.fingerprint(&self.capture, &opened, &truth)?;
                Some(results::Journal::open(folder, "tune", &fingerprint)?)
            }
            None => None,
        };
        let budget = self.max_bytes.map(Budget::Bytes).or(self.max_ms.map(Budget::Milliseconds));
        let done = journal.as_ref().map(results::Journal::points).unwrap_or_default();
        let plan = Plan { settings, budget, drop_cameras: !self.all_cameras, done };
        let tuned =
            results::recorded(journal.as_ref(), |job, keep| tune::run(&capture, &plan, &truth, job, keep))?;
        let head = format!("# {}\n\n", tuned.words.join("\n# "));
        std::fs::write(&self.out, head + &tuned.settings.to_toml())
            .map_err(|error| Error::io(&self.out, error))?;
        if self.json {
            return output::print_json(&tuned);
        }
        let cameras = tuned.cameras.join(", ");
        output::print(&format!(
            "{}\nCameras: {cameras}\nWrote {}",
            tuned.words.join("\n"),
            self.out.display()
        ))
    }
}
