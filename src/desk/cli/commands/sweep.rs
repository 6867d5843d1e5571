//! `overlook sweep`: accuracy against time and bytes, for many settings and all baselines.

use std::path::{Path, PathBuf};

use clap::Args;

use crate::cli::input::{self, BudgetArgs, PaintingArgs, SettingsArgs, TruthArgs};
use crate::cli::output::{self, CommandError, SweepDocument};
use overlook_engine::capture::Capture;
use overlook_engine::error::Error;
use overlook_engine::settings::Settings;
use overlook_lab::chart;
use overlook_lab::sweep::{self, ExternalPoint, SweepPlan};
use overlook_lab::trial::Measured;

#[derive(Debug, Args)]
pub(crate) struct SweepArgs {
    /// The captures, each a folder or the file in it that names its pictures. Each of several gets a folder of its own in DIR.
    #[arg(required = true, value_name = "CAPTURE")]
    captures: Vec<PathBuf>,
    #[command(flatten)]
    truth: TruthArgs,
    /// Folder for sweep.csv, sweep.json, pareto.png and .svg, the worst viewpoints, and report.html with all of it. An interrupted sweep
    /// resumes from the results there.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Try these values of a setting, and all combinations where given several times, instead of the usual variations: as
    /// in `--vary pruning.depth_tolerance=0.5,1,2`. `--vary render` tries every switch of the renderer by itself, so that the
    /// chart shows what each gives and what time it takes.
    #[arg(long, value_name = "KEY=VALUE,VALUE…|render")]
    vary: Vec<String>,
    /// Try the settings of this file, under its name; may be given several times.
    #[arg(long, value_name = "FILE", conflicts_with = "vary")]
    with: Vec<PathBuf>,
    /// Show the figures of another program on the same capture beside ours; may be given several times.
    #[arg(long, value_name = "NAME=DB,MS,BYTES")]
    rival: Vec<String>,
    #[command(flatten)]
    budget: BudgetArgs,
    #[command(flatten)]
    painting: PaintingArgs,
    #[command(flatten)]
    settings: SettingsArgs,
    /// Print one JSON document.
    #[arg(long)]
    json: bool,
}

/// Viewpoints whose pictures are shown.
const WORST_VIEWS: usize = 2;

impl SweepArgs {
    pub(crate) fn run(self) -> Result<(), CommandError> {
        let mut settings = self.settings.over(Settings::default())?;
        self.painting.apply(&mut settings.render);
        let external = self.rival.iter().map(|text| {
            text.parse::<ExternalPoint>().map_err(|error: Error| CommandError::Usage(error.to_string()))
        });
        let external = external.collect::<Result<Vec<ExternalPoint>, CommandError>>()?;
        output::check_folder(&self.out)?;
        if self.captures.len() > 1 && (self.truth.views.is_some() || !external.is_empty()) {
            return Err(CommandError::Usage(
                "--views and --rival are of one capture; sweep each by itself, and put them on one page with 'overlook report'".to_owned(),
            ));
        }
        let mut opened = Vec::new();
        for path in &self.captures {
            opened.push((path, input::open_capture(path, &settings.capture)?));
        }
        let folders = self.folders(&opened)?;
        let mut documents = Vec::new();
        for ((path, capture), folder) in opened.iter().zip(&folders) {
            documents.push(self.sweep(path.as_path(), capture, folder, &settings, &external)?);
        }
        output::write_page(&folders, &self.out.join(output::PAGE))?;
        match documents.as_slice() {
            [only] if self.json => output::print_json(only),
            [only] => output::print(&output::sweep_table(&only.points)),
            several if self.json => output::print_json(&several),
            several => {
                let table = |document: &SweepDocument| {
                    format!("{}\n{}\n", document.capture, output::sweep_table(&document.points))
                };
                output::print(&several.iter().map(table).collect::<Vec<_>>().join("\n"))
            }
        }
    }

    /// The folder of each capture's results: DIR itself for a single one.
    fn folders(&self, opened: &[(&PathBuf, Capture)]) -> Result<Vec<PathBuf>, CommandError> {
        if opened.len() == 1 {
            return Ok(vec![self.out.clone()]);
        }
        let names: Vec<&str> = opened.iter().map(|(_, capture)| capture.name.as_str()).collect();
        if let Some(twice) = names.iter().enumerate().find(|(index, name)| names[..*index].contains(name)) {
            return Err(CommandError::Usage(format!(
                "two captures are called '{}'; sweep them into different folders, and put them on one page with 'overlook report'",
                twice.1
            )));
        }
        Ok(names.iter().map(|name| self.out.join(name)).collect())
    }

    /// Sweeps one capture, and writes the results.
    fn sweep(
        &self,
        path: &Path,
        opened: &Capture,
        folder: &Path,
        settings: &Settings,
        external: &[ExternalPoint],
    ) -> Result<SweepDocument, CommandError> {
        let (capture, truth) = self.truth.open(path, opened)?;
        let mut plan = self.plan(settings, &capture)?;
        let fingerprint = self.truth.fingerprint(path, opened, &truth)?;
        let journal = output::Journal::open(folder, "sweep", &fingerprint)?;
        (plan.external, plan.budget) = (external.to_vec(), self.budget.budget);
        plan.done = journal.points();
        let Measured { points, left } = output::recorded(Some(&journal), |job, keep| {
            sweep::run(&capture, &plan, &truth, job, |point, _| keep(point))
        })?;
        let shown =
            output::watched(|job| sweep::worst_views(&capture, &plan, &truth, &points, WORST_VIEWS, job))?;
        let mut worst = Vec::new();
        for (index, view) in shown.iter().enumerate() {
            let caption = format!("{}: {:.2} dB", view.file_path, view.psnr_filled_db);
            worst.push(output::save_picture(folder, &format!("worst{}.png", index + 1), caption, view)?);
        }
        let chart = chart::pareto(&capture.name, &points);
        let document = SweepDocument {
            capture: capture.name.clone(),
            truth: self.truth.words(&capture, &truth),
            command: output::command(),
            version: output::version(),
            points,
            worst,
        };
        output::write_results(folder, "sweep", &document, &document.points, "pareto.png", &chart)?;
        BudgetArgs::warn_of(left);
        Ok(document)
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
                output::warn(&[format!(
                    "'{name}' has the same settings as '{same}', and gets no row of its own"
                )]);
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
        if self.vary == ["render"] {
            return Ok(SweepPlan::switches(settings));
        }
        let axis = |text: &String| {
            let (path, values) = text.split_once('=').ok_or_else(|| {
                CommandError::Usage(format!(
                    "--vary {text}: write it as key=value,value, as in render.kernel=block,gather, or give 'render' alone"
                ))
            })?;
            Ok((path.trim().to_owned(), values.split(',').map(|value| value.trim().to_owned()).collect()))
        };
        let axes = self.vary.iter().map(axis).collect::<Result<Vec<_>, CommandError>>()?;
        SweepPlan::grid(settings, &axes, capture).map_err(|error| CommandError::Usage(error.to_string()))
    }
}
