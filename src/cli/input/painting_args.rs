//! Settings of rendering that have options of their own.

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};

use crate::settings::{Backend, Fill, Kernel, RenderSettings};

/// The choices that are made most often when painting; they win over the settings.
#[derive(Debug, Args)]
pub(crate) struct PaintingArgs {
    /// How a sample is painted [default: as the settings say].
    #[arg(long, value_parser = choice::<Kernel>(Kernel::NAMES))]
    kernel: Option<Kernel>,
    /// How pixels without any sample are filled [default: as the settings say].
    #[arg(long, value_parser = choice::<Fill>(Fill::NAMES))]
    fill: Option<Fill>,
    /// What paints [default: as the settings say].
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
