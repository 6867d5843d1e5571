//! How scalar values are shown, by the command line.

use std::str::FromStr;

use clap::Args;
use image::RgbaImage;

use super::options::choice;
use overlook_engine::capture::ValueChannel;
use overlook_engine::error::{Error, Result};
use overlook_engine::render::ValueColors;
use overlook_engine::render::output::ranked_value;
use overlook_engine::settings::{Colormap, ValueScale};
use overlook_lab::chart::ColorBar;

/// How scalar values are shown.
#[derive(Clone, Debug, Default, PartialEq, Args)]
pub(crate) struct ValueArgs {
    /// Color by the scalar value of this name, in each pixel that of the nearest surface; a surface without one is gray (128, 128, 128), the
    /// background light gray (216, 216, 216). An EXR keeps the picture's colors, and has all values as layers value.NAME.
    #[arg(long, value_name = "NAME")]
    color_by: Option<String>,
    /// Between which values colors run: two numbers, as in 0,5, or shares of what is in view, as in 2%,98% [default: the range of the
    /// manifest].
    #[arg(long, value_name = "LOW,HIGH", requires = "color_by", allow_hyphen_values = true)]
    range: Option<ValueRange>,
    /// The colors [default: viridis].
    #[arg(long, requires = "color_by", value_parser = choice::<Colormap>(Colormap::NAMES))]
    colormap: Option<Colormap>,
    /// How the range runs over the colors [default: linear].
    #[arg(long, requires = "color_by", value_parser = choice::<ValueScale>(ValueScale::NAMES))]
    value_scale: Option<ValueScale>,
    /// Show the values between these two numbers alone; all others are gray.
    #[arg(long, value_name = "LOW,HIGH", requires = "color_by", allow_hyphen_values = true)]
    isolate: Option<ValueRange>,
    /// Pictures are transparent where nothing has a value, or none that is shown, instead of gray.
    #[arg(long, requires = "color_by")]
    transparent: bool,
}

/// How scalar values are shown, with what the colors mean.
#[derive(Clone, Debug, Default, Args)]
pub(crate) struct BarredValueArgs {
    #[command(flatten)]
    pub(crate) values: ValueArgs,
    /// Leave out the scalar bar, which says what colors by value mean.
    #[arg(long, requires = "color_by")]
    no_scalar_bar: bool,
}

/// A value that is shown.
#[derive(Clone, Debug)]
pub(crate) struct ShownValue {
    /// The number of its channel.
    pub(crate) channel: usize,
    pub(crate) colors: ValueColors,
    pub(crate) bar: ColorBar,
}

impl BarredValueArgs {
    pub(crate) fn has_bar(&self) -> bool {
        !self.no_scalar_bar
    }

    /// What lies below pictures of so many columns.
    ///
    /// # Errors
    /// Those of drawing it.
    pub(crate) fn strip(&self, shown: &ShownValue, columns: usize) -> Result<Option<RgbaImage>> {
        self.has_bar().then(|| shown.bar.strip(columns)).transpose()
    }
}

/// Two ends of a range.
#[derive(Clone, Copy, Debug, PartialEq)]
enum ValueRange {
    Numbers([f32; 2]),
    /// Shares of what is in view, 0 to 1.
    Shares([f32; 2]),
}

impl FromStr for ValueRange {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let what = || "must be two numbers, the first below the second, as in 0,5 or 2%,98%".to_owned();
        let (low, high) = text.split_once(',').ok_or_else(what)?;
        let shares = low.trim().strip_suffix('%').zip(high.trim().strip_suffix('%'));
        let (low, high) = shares.unwrap_or((low.trim(), high.trim()));
        let number = |text: &str| text.parse::<f32>().ok().filter(|number| number.is_finite());
        let ends = number(low).zip(number(high)).filter(|(low, high)| low < high).ok_or_else(what)?;
        match shares {
            None => Ok(Self::Numbers([ends.0, ends.1])),
            Some(_) if ends.0 >= 0.0 && ends.1 <= 100.0 => Ok(Self::Shares([ends.0 / 100.0, ends.1 / 100.0])),
            Some(_) => Err(what()),
        }
    }
}

impl ValueArgs {
    /// The channel that is shown, by its number; `None` where colors are those of the picture.
    ///
    /// # Errors
    /// `Invalid` where there is no channel of the name.
    pub(crate) fn channel(&self, channels: &[ValueChannel], place: &str) -> Result<Option<usize>> {
        self.color_by.as_ref().map(|name| ValueChannel::named(channels, name, place)).transpose()
    }

    /// Refuses transparency of what cannot have it.
    pub(crate) fn refuse_transparent(&self, of: &str) -> Result<()> {
        let what = format!("{of} has no transparent pixels; leave it out");
        if self.transparent { Err(Error::invalid("--transparent", what)) } else { Ok(()) }
    }

    /// A channel as it is shown, given the values in view, ascending.
    ///
    /// # Errors
    /// As [`Self::colors`].
    pub(crate) fn shown(
        &self,
        channels: &[ValueChannel],
        channel: usize,
        in_view: &[f32],
        place: &str,
    ) -> Result<ShownValue> {
        let colors = self.colors(&channels[channel], in_view, place)?;
        Ok(ShownValue { channel, bar: ColorBar::of_values(&channels[channel], &colors), colors })
    }

    /// The colors of a channel, given the values in view, ascending.
    ///
    /// # Errors
    /// `Invalid` where the range cannot be colored, and where there is nothing in view that it could be a share of.
    pub(crate) fn colors(&self, channel: &ValueChannel, in_view: &[f32], place: &str) -> Result<ValueColors> {
        let invalid = |what: String| Error::invalid(format!("{place}: value '{}'", channel.name), what);
        let at = |share: f32| {
            ranked_value(in_view, share)
                .ok_or_else(|| invalid("none is in view that --range could be a share of".to_owned()))
        };
        let range = match self.range {
            None => channel.range,
            Some(ValueRange::Numbers(range)) => range,
            Some(ValueRange::Shares([low, high])) => [at(low)?, at(high)?],
        };
        let (map, scale) =
            (self.colormap.unwrap_or(Colormap::Viridis), self.value_scale.unwrap_or(ValueScale::Linear));
        let colors = ValueColors::new(map, scale, range).map_err(invalid)?;
        let colors = if self.transparent { colors.leaving_out_missing() } else { colors };
        match self.isolate {
            None => Ok(colors),
            Some(ValueRange::Numbers(isolated)) => Ok(colors.isolating(isolated)),
            Some(ValueRange::Shares([low, high])) => Ok(colors.isolating([at(low)?, at(high)?])),
        }
    }
}
