//! `overlook sweep`: accuracy against time and bytes, for many settings and all baselines.

use std::path::PathBuf;

use clap::Args;
use serde::Serialize;

use crate::capture::Capture;
use crate::cli::input::{self, PaintingArgs, SettingsArgs, TruthArgs};
use crate::cli::output::{self, CommandError};
use crate::evaluate::chart;
use crate::evaluate::sweep::{self, Point, SweepPlan};
use crate::settings::Settings;

#[derive(Debug, Args)]
pub(crate) struct SweepArgs {
    /// The capture: a folder, or the file in it that names its pictures.
    capture: PathBuf,
    #[command(flatten)]
    truth: TruthArgs,
    /// Folder for sweep.csv, sweep.json and pareto.png. A sweep that was cut short goes on from what it left there.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Try these values of a setting, and all combinations where given several times, instead of the usual variations: as
    /// in `--vary pruning.depth_tolerance=0.5,1,2`.
    #[arg(long, value_name = "KEY=VALUE,VALUE…")]
    vary: Vec<String>,
    /// Try the settings of this file, under its name; may be given several times.
    #[arg(long, value_name = "FILE", conflicts_with = "vary")]
    with: Vec<PathBuf>,
    #[command(flatten)]
    painting: PaintingArgs,
    #[command(flatten)]
    settings: SettingsArgs,
    /// Print one JSON document.
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct SweepOutput<'a> {
    capture: &'a str,
    truth: String,
    points: &'a [Point],
}

impl SweepArgs {
    pub(crate) fn run(self) -> Result<(), CommandError> {
        let mut settings = self.settings.over(Settings::default())?;
        self.painting.apply(&mut settings.render);
        output::check_folder(&self.out)?;
        let opened = input::open_capture(&self.capture, &settings.capture)?;
        let (capture, truth) = self.truth.open(&self.capture, &opened)?;
        let mut plan = self.plan(&settings, &capture)?;
        let fingerprint = self.truth.fingerprint(&self.capture, &opened, &truth)?;
        let journal = output::Journal::open(&self.out, "sweep", &fingerprint)?;
        plan.done = journal.points();
        let points = output::recorded(Some(&journal), |job, keep| {
            sweep::run(&capture, &plan, &truth, job, |point, _| keep(point))
        })?;
        let document = SweepOutput {
            capture: &capture.name,
            truth: self.truth.words(&capture, &truth),
            points: &points,
        };
        let chart = chart::pareto(&capture.name, &points);
        output::write_results(&self.out, "sweep", &document, &points, ("pareto.png", &chart))?;
        if self.json { output::print_json(&document) } else { output::print(&output::sweep_table(&points)) }
    }

    /// The settings files under their names, or under their paths if two share a name. A file that equals another row gets none
    /// of its own, with a warning.
    fn named(&self, reference: &Settings) -> Result<Vec<(String, Settings)>, CommandError> {
        let label = |path: &PathBuf| {
            let of_that_name = self.with.iter().filter(|other| other.file_stem() == path.file_stem()).count();
            let name = path.file_stem().filter(|_| of_that_name == 1).unwrap_or(path.as_os_str());
            Ok((name.to_string_lossy().into_owned(), Settings::load(path)?))
        };
        let named = self.with.iter().map(label).collect::<Result<Vec<_>, CommandError>>()?;
        for (index, (name, settings)) in named.iter().enumerate() {
            let earlier =
                named[..index].iter().find(|(_, other)| other == settings).map(|(name, _)| name.as_str());
            if let Some(same) = earlier.or((settings == reference).then_some("default")) {
                output::warn(&[format!("'{name}' says the same as '{same}', and has no row of its own")]);
            }
        }
        Ok(named)
    }

    fn plan(&self, settings: &Settings, capture: &Capture) -> Result<SweepPlan, CommandError> {
        if !self.with.is_empty() {
            return Ok(SweepPlan::list(settings, self.named(settings)?, capture));
        }
        if self.vary.is_empty() {
            return Ok(SweepPlan::standard(settings, capture));
        }
        let axis = |text: &String| {
            let (path, values) = text.split_once('=').ok_or_else(|| {
                CommandError::Usage(format!(
                    "--vary {text}: write it as key=value,value, as in render.kernel=block,gather"
                ))
            })?;
            Ok((path.trim().to_owned(), values.split(',').map(|value| value.trim().to_owned()).collect()))
        };
        let axes = self.vary.iter().map(axis).collect::<Result<Vec<_>, CommandError>>()?;
        SweepPlan::grid(settings, &axes, capture).map_err(|error| CommandError::Usage(error.to_string()))
    }
}
