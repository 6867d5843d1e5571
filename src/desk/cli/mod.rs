//! The command line: one file per subcommand over the same library calls as the window.
//!
//! Results go to stdout, as text or with `--json` as one document; progress and errors go to stderr. The exit code is 0 on
//! success, 1 on bad input (with one line on what, where, and what to do) and 2 on bad usage.

mod commands;
mod freed_memory;
mod input;
mod output;

use std::ffi::OsString;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::error::ErrorKind;
use clap::{CommandFactory, Parser, Subcommand};

use crate::address;
use output::CommandError;
use overlook_engine::error::Error;

const EXAMPLES: &str = "\
Examples:
  overlook                                                  explore a room that comes with the program
  overlook open 'scene.ovl#view=…&frame=…'                  at a view whose address was copied from a window or a page
  overlook demo orrery --out scene                          write a capture to try things on
  overlook place coarse --cameras 6 --out placed.json       where cameras show the most, by a capture of few pixels
  overlook preprocess scene --out scene.ovl                 drop what is redundant
  overlook render scene.ovl --views scene/novel/transforms.json --out pictures
  overlook edit scene.ovl --edits edits.toml --out cleaned.ovl      without what was deleted by hand
  overlook evaluate scene                                   accuracy against no pruning and first camera wins
  overlook align scene --out aligned.json                   poses without what the rig got wrong
  overlook sweep scene --out sweep                          accuracy against time and bytes, for many settings
  overlook stress scene --out stress                        where methods fail
  overlook report sweep stress                              one page on both, with charts, tables and pictures
  overlook tune scene --out tuned.toml                      the simplest settings that are as good as the best
  overlook export points scene.ovl --out points            binary PLY, one file a frame
  overlook export splats scene.ovl --format glb --out scene.glb     Gaussian splats that other viewers open, moving
  overlook export figure scene --overlay kept-by --out figure.pdf   a picture for print, with legend and scale bar
  overlook verify scene.ovl                                 whether all of a store can be read

Exit codes: 0 success, 1 bad input (one line on stderr with the error, its place and the remedy), 2 bad usage, 130 stopped by Ctrl-C.";

/// A path or a command: clap would draw both in one line.
const USAGE: &str = "overlook [OPTIONS] [PATH]\n       overlook [OPTIONS] <COMMAND>";

/// See, prune and explore animated scenes recorded as color and depth by several static cameras.
///
/// Without a command, a window opens on PATH, or on the room that comes with the program.
#[derive(Debug, Parser)]
#[command(version, after_help = EXAMPLES, override_usage = USAGE)]
struct Cli {
    #[command(subcommand)]
    command: Option<CliCommand>,

    /// What the window opens: a capture (a folder, or the file in it that names its pictures) or a store.
    path: Option<PathBuf>,

    /// Threads to work with [default: one per core].
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
}

#[derive(Debug, Subcommand)]
enum CliCommand {
    /// Open a window on a capture or a store, at the view of an address: 'scene.ovl#view=…&frame=…', as windows and pages copy it.
    Open {
        /// The capture, the store, or the address.
        #[arg(value_name = "ADDRESS")]
        place: PathBuf,
    },
    /// Write a built-in scene as a capture: EXR, transforms.json, and true pictures of new viewpoints in DIR/novel.
    Demo(commands::demo::DemoArgs),
    /// Tell from a first capture of few pixels where cameras show the most, before the expensive pictures are made.
    Place(commands::place::PlaceArgs),
    /// Print what a capture or a store holds.
    Info(commands::info::InfoArgs),
    /// Drop what is redundant in a capture and write the rest as a store.
    Preprocess(commands::preprocess::PreprocessArgs),
    /// Apply an edit list to a store: delete regions, bad cameras or samples that few cameras confirm, and write what is left.
    Edit(commands::edit::EditArgs),
    /// Render a store from any viewpoints, and score the pictures where the truth is known.
    Render(commands::render::RenderArgs),
    /// Measure errors of the rig, and write corrected poses for other programs.
    Align(commands::align::AlignArgs),
    /// Score settings: accuracy, speed and size, against no pruning and against first camera wins.
    Evaluate(commands::evaluate::EvaluateArgs),
    /// Try many settings and all baselines: accuracy against time and bytes, with the Pareto front.
    Sweep(commands::sweep::SweepArgs),
    /// Disturb a capture more and more: where does each method fail, with and without its defenses?
    Stress(commands::stress::StressArgs),
    /// Find the simplest settings, and the fewest cameras, that are as accurate as the best.
    Tune(commands::tune::TuneArgs),
    /// Put the results of sweeps and stress tests on one page: charts, tables and pictures, for any number of captures.
    Report(commands::report::ReportArgs),
    /// Write the samples of a store in forms that other programs read: points, pictures, a video.
    Export(commands::export::ExportArgs),
    /// Read everything in a store and report damage.
    Verify(commands::verify::VerifyArgs),
    /// Print every setting with its meaning, unit, range and value, as TOML.
    Settings(commands::settings::SettingsCommandArgs),
}

/// Opens the window on a capture or store, or on the room that comes with the program.
pub type OpenWindow = fn(Option<PathBuf>) -> Result<(), Error>;

/// Runs the program with the arguments it was started with. The window is handed in: commands need none.
#[must_use]
pub fn run(open_window: OpenWindow) -> ExitCode {
    let cli = match Cli::read(std::env::args_os()) {
        Ok(cli) => cli,
        Err(error) => {
            // A closed stdout or stderr has no reader.
            let _ = error.print();
            return ExitCode::from(if error.use_stderr() { 2 } else { 0 });
        }
    };
    // A window draws pictures of the same size again and again.
    if cli.command.is_some() {
        freed_memory::give_back_large_blocks();
    }
    match cli.run(open_window) {
        Ok(()) => ExitCode::SUCCESS,
        Err(CommandError::Usage(what)) => {
            output::print_error(&what);
            ExitCode::from(2)
        }
        Err(CommandError::Work(error)) => {
            output::print_error(&error.to_string().replace('\n', " "));
            if matches!(error, Error::Cancelled) {
                ExitCode::from(output::STOPPED)
            } else {
                ExitCode::FAILURE
            }
        }
    }
}

/// The command line for clap: manual pages and shell completions are made from it.
#[must_use]
pub fn command() -> clap::Command {
    Cli::command()
}

impl Cli {
    /// As `Parser::try_parse`, but PATH before a command is refused here: clap's own check would miss commands after --threads.
    fn read(arguments: impl IntoIterator<Item = OsString>) -> Result<Self, clap::Error> {
        let cli = Self::try_parse_from(arguments)?;
        match &cli {
            Self { command: Some(_), path: Some(path), .. } => {
                let what =
                    format!("'{}' is before a command; write paths after the command's name", path.display());
                Err(Self::command().error(ErrorKind::ArgumentConflict, what))
            }
            _ => Ok(cli),
        }
    }

    fn run(self, open_window: OpenWindow) -> Result<(), CommandError> {
        use_threads(self.threads)?;
        match self.command {
            Some(CliCommand::Open { place }) => explore(Some(place), open_window),
            Some(CliCommand::Demo(args)) => args.run(),
            Some(CliCommand::Place(args)) => args.run(),
            Some(CliCommand::Info(args)) => args.run(),
            Some(CliCommand::Edit(args)) => args.run(),
            Some(CliCommand::Preprocess(args)) => args.run(),
            Some(CliCommand::Render(args)) => args.run(),
            Some(CliCommand::Align(args)) => args.run(),
            Some(CliCommand::Evaluate(args)) => args.run(),
            Some(CliCommand::Sweep(args)) => args.run(),
            Some(CliCommand::Stress(args)) => args.run(),
            Some(CliCommand::Tune(args)) => args.run(),
            Some(CliCommand::Report(args)) => args.run(),
            Some(CliCommand::Export(args)) => args.run(),
            Some(CliCommand::Verify(args)) => args.run(),
            Some(CliCommand::Settings(args)) => args.run(),
            None => explore(self.path, open_window),
        }
    }
}

fn explore(path: Option<PathBuf>, open_window: OpenWindow) -> Result<(), CommandError> {
    if let Some(path) = &path
        && !address::of_path(path).0.exists()
    {
        return Err(CommandError::Work(Error::invalid(
            path.display(),
            "is neither a command nor a capture or store; see overlook --help",
        )));
    }
    Ok(open_window(path)?)
}

fn use_threads(threads: Option<u16>) -> Result<(), CommandError> {
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads.map_or(0, usize::from))
        .thread_name(|index| format!("worker {index}"))
        .build_global()
        .map_err(|error| CommandError::Work(Error::unsupported("--threads", error.to_string())))
}

#[cfg(test)]
mod tests {
    use super::*;
    use overlook_engine::settings::Settings;

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn threads_may_stand_before_and_after_a_command_and_a_path() {
        let read =
            |arguments: &str| Cli::read(format!("overlook {arguments}").split(' ').map(OsString::from));
        for arguments in [
            "--threads 2 settings",
            "settings --threads 2",
            "--threads=2 settings --set pruning.overlap=false",
        ] {
            let cli = read(arguments).unwrap();
            assert!(
                matches!(cli.command, Some(CliCommand::Settings(_))) && cli.path.is_none(),
                "{arguments}"
            );
            assert_eq!(cli.threads, Some(2), "{arguments}");
        }
        for arguments in
            ["--threads 2 preprocess scene --out x.ovl", "preprocess scene --threads 2 --out x.ovl"]
        {
            let cli = read(arguments).unwrap();
            assert!(matches!(cli.command, Some(CliCommand::Preprocess(_))), "{arguments}");
            assert_eq!(cli.threads, Some(2), "{arguments}");
        }
        for arguments in ["--threads 2 scene", "scene --threads 2"] {
            let cli = read(arguments).unwrap();
            assert!(cli.command.is_none() && cli.path == Some("scene".into()), "{arguments}");
            assert_eq!(cli.threads, Some(2), "{arguments}");
        }
        assert_eq!(read("settings").unwrap().threads, None);
        for arguments in ["scene settings", "scene --threads 2 settings", "--threads 2 scene info scene"] {
            let refused = read(arguments).unwrap_err();
            assert_eq!(
                (refused.kind(), refused.exit_code()),
                (ErrorKind::ArgumentConflict, 2),
                "{arguments}"
            );
            assert!(refused.to_string().contains("'scene' is before a command"), "{refused}");
        }
    }

    /// The long help of a command and of those below it, each after its name.
    fn helps(command: &mut clap::Command, name: &str) -> Vec<(String, String)> {
        let mut found = vec![(name.to_owned(), command.render_long_help().to_string())];
        for below in command.get_subcommands_mut() {
            let name = format!("{name} {}", below.get_name());
            found.extend(helps(below, &name));
        }
        found
    }

    #[test]
    fn help_that_many_commands_share_shows_no_setting_that_one_of_them_refuses() {
        let helps = helps(&mut Cli::command(), "overlook");
        let mut examples = 0;
        for (name, help) in &helps {
            let shown = help.split("--set ").skip(1).filter_map(|after| after.split([' ', ';', '\n']).next());
            for example in shown.filter(|example| !example.starts_with('<')) {
                examples += 1;
                let names_a_setting = Settings::default().set_text(example).is_ok();
                assert!(!names_a_setting, "{name} --help shows --set {example}, which other commands refuse");
            }
        }
        assert!(examples >= 8, "{examples} examples in the help of {} commands", helps.len());
    }
}
