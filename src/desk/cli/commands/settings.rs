//! `overlook settings`: every setting, documented.

use std::fmt::Write;

use clap::Args;

use crate::cli::input::SettingsArgs;
use crate::cli::output::{self, CommandError};
use overlook_engine::settings::{Field, Settings, ValueKind};

#[derive(Debug, Args)]
pub(crate) struct SettingsCommandArgs {
    #[command(flatten)]
    settings: SettingsArgs,
}

impl SettingsCommandArgs {
    pub(crate) fn run(self) -> Result<(), CommandError> {
        let settings = self.settings.over(Settings::default())?;
        output::print(&documented_toml(&settings))
    }
}

/// The settings as TOML, each below its help text, unit and range.
fn documented_toml(settings: &Settings) -> String {
    let mut text = String::from(
        "# Settings of Overlook. Save as a file for --settings; what is left out keeps its default.\n",
    );
    let mut section = String::new();
    for line in settings.to_toml().lines() {
        if let Some(name) = line.strip_prefix('[').and_then(|line| line.strip_suffix(']')) {
            name.clone_into(&mut section);
        } else if let Some((name, _)) = line.split_once(" = ") {
            let path = format!("{section}.{name}");
            if let Some(field) = Settings::fields().find(|field| field.path == path) {
                text.push_str(&comment(field));
            }
        }
        text.push_str(line);
        text.push('\n');
    }
    text.truncate(text.trim_end().len());
    text
}

fn comment(field: &Field) -> String {
    let mut text = format!("\n# {}\n", field.help.trim());
    let unit = if field.unit.is_empty() { String::new() } else { format!(" {}", field.unit) };
    let _ = match field.kind {
        ValueKind::Number { min, max, .. } => writeln!(text, "# {min} to {max}{unit}"),
        ValueKind::Integer { min, max } => writeln!(text, "# {min} to {max}{unit}"),
        ValueKind::Switch => writeln!(text, "# true or false"),
        ValueKind::Choice(choices) => {
            choices.iter().try_for_each(|(name, help)| writeln!(text, "#   {name}: {}", help.trim()))
        }
    };
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_printed_can_be_read_and_explains_every_setting() {
        let mut settings = Settings::default();
        settings.set_text("pruning.depth_tolerance=2.5").unwrap();
        let text = documented_toml(&settings);
        assert_eq!(Settings::from_toml(&text, "test").unwrap(), settings);
        for field in Settings::fields() {
            assert!(text.contains(field.help.trim()), "{}", field.path);
        }
    }
}
