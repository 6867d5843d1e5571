//! How scalar values are shown and written, by the command line.

use std::str::FromStr;

use clap::Args;

use super::options::choice;
use overlook_engine::capture::ValueChannel;
use overlook_engine::error::{Error, Result};
use overlook_engine::render::ValueColors;
use overlook_engine::settings::{Colormap, ValueScale};

/// How scalar values are shown.
#[derive(Clone, Debug, Default, Args)]
pub(crate) struct ValueArgs {
    /// Color the PNG by the value of this name, in each pixel that of the nearest surface; what has none is gray (128, 128, 128). The EXR
    /// keeps the picture, and has all values as layers value.NAME.
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
    /// Also write each value as an array beside the picture: NAME.npy behind the picture's name, float32, NaN where it is missing.
    #[arg(long)]
    pub(crate) values: bool,
}

/// Two ends of a range.
#[derive(Clone, Copy, Debug)]
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

    /// The colors of a channel, given the values in view, ascending.
    ///
    /// # Errors
    /// `Invalid` where the range cannot be colored, and where there is nothing in view that it could be a share of.
    pub(crate) fn colors(&self, channel: &ValueChannel, in_view: &[f32], place: &str) -> Result<ValueColors> {
        let invalid = |what: String| Error::invalid(format!("{place}: value '{}'", channel.name), what);
        let at = |share: f32| {
            let last = in_view.len().checked_sub(1);
            let last =
                last.ok_or_else(|| invalid("none is in view that --range could be a share of".to_owned()))?;
            Ok::<_, Error>(in_view[(share * last as f32).round() as usize])
        };
        let range = match self.range {
            None => channel.range,
            Some(ValueRange::Numbers(range)) => range,
            Some(ValueRange::Shares([low, high])) => [at(low)?, at(high)?],
        };
        let (map, scale) =
            (self.colormap.unwrap_or(Colormap::Viridis), self.value_scale.unwrap_or(ValueScale::Linear));
        let colors = ValueColors::new(map, scale, range).map_err(invalid)?;
        match self.isolate {
            None => Ok(colors),
            Some(ValueRange::Numbers(isolated)) => Ok(colors.isolating(isolated)),
            Some(ValueRange::Shares([low, high])) => Ok(colors.isolating([at(low)?, at(high)?])),
        }
    }
}
