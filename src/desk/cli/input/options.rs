//! Options that several commands share.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};

use crate::cli::output::{self, CommandError};
use overlook_engine::capture::Capture;
use overlook_engine::error::Error;
use overlook_engine::settings::{Backend, Fill, Kernel, RenderSettings, Settings};
use overlook_engine::whole_file;

/// Settings: the defaults, then a file, then single values.
#[derive(Debug, Args)]
pub(crate) struct SettingsArgs {
    /// Settings to start from (TOML; `overlook settings` prints them all).
    #[arg(long, value_name = "FILE")]
    settings: Option<PathBuf>,
    /// Change one setting, as in --set section.name=value; may be given several times.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
}

impl SettingsArgs {
    /// These settings over `base`.
    pub(crate) fn over(&self, base: Settings) -> Result<Settings, CommandError> {
        let mut settings = match &self.settings {
            Some(path) => Settings::load(path)?,
            None => base,
        };
        for assignment in &self.set {
            settings.set_text(assignment).map_err(|error| CommandError::Usage(error.to_string()))?;
        }
        Ok(settings)
    }

    /// Refuses to write over the file that they are read from.
    pub(crate) fn refuse_inputs(&self, out: &Path) -> Result<(), Error> {
        self.settings.as_ref().map_or(Ok(()), |settings| output::refuse_input(settings, out))
    }

    /// Refuses --set outside of the one section that a command uses: it would have no effect. A settings file may hold more,
    /// since it serves other commands too.
    pub(crate) fn only(&self, section: &str) -> Result<(), CommandError> {
        for assignment in &self.set {
            Settings::default()
                .set_text(assignment)
                .map_err(|error| CommandError::Usage(error.to_string()))?;
            if assignment.split('.').next().map(str::trim) != Some(section) {
                return Err(CommandError::Usage(format!(
                    "--set {assignment}: of a store that is there, this command uses settings of '{section}' alone; the others are \
                     those it was preprocessed with"
                )));
            }
        }
        Ok(())
    }
}

/// The choices that are made most often when painting; they win over the settings.
#[derive(Debug, Args)]
pub(crate) struct PaintingArgs {
    /// How samples are rendered [default: as in the settings].
    #[arg(long, value_parser = choice::<Kernel>(Kernel::NAMES))]
    kernel: Option<Kernel>,
    /// How pixels without any sample are filled [default: as in the settings].
    #[arg(long, value_parser = choice::<Fill>(Fill::NAMES))]
    fill: Option<Fill>,
    /// The renderer [default: as in the settings].
    #[arg(long, value_parser = choice::<Backend>(Backend::NAMES))]
    backend: Option<Backend>,
}

impl PaintingArgs {
    pub(crate) fn apply(&self, settings: &mut RenderSettings) {
        settings.kernel = self.kernel.unwrap_or(settings.kernel);
        settings.fill = self.fill.unwrap_or(settings.fill);
        settings.backend = self.backend.unwrap_or(settings.backend);
    }
}

/// A parser that takes the names of a setting's choices and lists them in the help.
pub(crate) fn choice<T>(names: &'static [(&'static str, &'static str)]) -> impl TypedValueParser<Value = T>
where
    T: std::str::FromStr<Err = String> + Clone + Send + Sync + 'static,
{
    PossibleValuesParser::new(names.iter().map(|(name, help)| PossibleValue::new(*name).help(help.trim())))
        .try_map(|name| name.parse::<T>())
}

/// A whole number above 0, with k for a thousand or M for a million behind it.
pub(crate) fn amount(text: &str) -> Result<u64, String> {
    let (number, unit) = match text.strip_suffix(['k', 'K']) {
        Some(number) => (number, 1e3),
        None => text.strip_suffix('M').map_or((text, 1.0), |number| (number, 1e6)),
    };
    match number.parse::<f64>() {
        Ok(number) if number * unit >= 1.0 && number * unit < 1e15 => Ok((number * unit) as u64),
        _ => Err("must be a number, as in 3000000, 500k or 3M".to_owned()),
    }
}

/// Which cameras are left out.
#[derive(Debug, Args)]
pub(crate) struct HoldOutArgs {
    /// Leave this camera out, so that pictures can be scored against its frames; may be given several times.
    #[arg(long, value_name = "CAMERA")]
    hold_out: Vec<String>,
}

impl HoldOutArgs {
    /// Their names in the order given, each once.
    pub(crate) fn names(&self) -> Vec<String> {
        let mut names = self.hold_out.clone();
        let mut seen = HashSet::new();
        names.retain(|name| seen.insert(name.clone()));
        names
    }
}

/// The cameras that a file names, one a line; empty lines count for nothing.
pub(crate) fn only_cameras(capture: &Capture, file: &Path) -> Result<Capture, Error> {
    let text = whole_file::short_text(file)?;
    let names: Vec<&str> = text.lines().map(str::trim).filter(|name| !name.is_empty()).collect();
    if names.is_empty() {
        return Err(Error::invalid(file.display(), "names no camera; write one a line"));
    }
    let known: HashSet<&str> = capture.cameras.iter().map(|camera| camera.name.as_str()).collect();
    if let Some(unknown) = names.iter().find(|name| !known.contains(*name)) {
        let what = format!("'{}' has no camera '{unknown}'", capture.name);
        return Err(Error::invalid(file.display(), what));
    }
    let names: HashSet<&str> = names.into_iter().collect();
    Ok(capture.with_cameras(|_, camera| names.contains(camera.name.as_str())))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn single_values_win_over_the_file_and_the_file_over_what_was_there() {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(&file, "[pruning]\ndepth_tolerance = 2.0\nnormal_tolerance = 10.0\n").unwrap();
        let mut base = Settings::default();
        base.set_text("pruning.normal_tolerance=50").unwrap();
        let mut args = SettingsArgs {
            settings: Some(file.path().to_path_buf()),
            set: vec!["pruning.depth_tolerance=3".to_owned()],
        };
        let settings = args.over(base.clone()).unwrap();
        assert_eq!((settings.pruning.depth_tolerance, settings.pruning.normal_tolerance), (3.0, 10.0));
        args.settings = None;
        assert_eq!(args.over(base).unwrap().pruning.normal_tolerance, 50.0);
        args.set.push("pruning.nonsense=1".to_owned());
        assert!(matches!(args.over(Settings::default()), Err(CommandError::Usage(_))));
    }

    #[test]
    fn values_that_a_command_does_not_use_are_refused() {
        let set = |assignment: &str| SettingsArgs { settings: None, set: vec![assignment.to_owned()] };
        assert!(set("render.kernel=block").only("render").is_ok());
        assert!(set(" store.precision = bits8").only("store").is_ok());
        for (assignment, section) in [
            ("pruning.rate=paper", "render"),
            ("store.precision=bits8", "render"),
            ("render.kernel=block", "store"),
        ] {
            let Err(CommandError::Usage(said)) = set(assignment).only(section) else {
                panic!("{assignment} passed")
            };
            assert!(said.contains(assignment) && said.contains(section), "{said}");
        }
        let Err(CommandError::Usage(said)) = set("render.nonsense=1").only("store") else {
            panic!("nonsense passed")
        };
        assert!(said.contains("no such setting"), "{said}");
    }

    #[test]
    fn amounts_are_given_plain_in_thousands_and_in_millions() {
        assert_eq!(["3000", "500k", "1.5M"].map(amount), [3000, 500_000, 1_500_000].map(Ok));
        assert!(["", "k", "-1", "0", "0.5", "1G", "nan"].iter().all(|text| amount(text).is_err()));
    }
}
