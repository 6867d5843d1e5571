//! What a figure for print shows, and how large it is.

use std::fmt::{self, Display};
use std::str::FromStr;

use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};

use crate::text::significant;
use overlook_lab::chart::{FIGURE_COLUMNS, INCH_MM};

/// The picture of a figure.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum FigureOf {
    /// The live view.
    #[default]
    Live,
    /// The source picture with its overlay.
    Source,
    /// The pictures of Compare.
    Compared,
    /// What the last change of settings did in the live view.
    Change,
}

impl FigureOf {
    /// Every choice: its name and what it is.
    pub(crate) const ALL: [(Self, &'static str, &'static str); 4] = [
        (Self::Live, "Live view", "The live view as it is colored, rendered anew at the size of the figure."),
        (Self::Source, "Source picture", "The recorded picture with the overlay that is chosen."),
        (
            Self::Compared,
            "Comparison",
            "What Compare shows, zoomed as there: wiped, side by side, one of both, or their difference with its scale.",
        ),
        (
            Self::Change,
            "Last change",
            "The live view, with the samples of this frame that the last change of settings dropped, and those that it brought back.",
        ),
    ];
}

/// What is chosen of a figure beside its picture.
#[derive(Clone, Debug, PartialEq, Args)]
pub(crate) struct FigureOptions {
    /// Width with its unit, as in 120mm, 12cm, 4.7in or 1400px.
    #[arg(long, value_name = "WIDTH", default_value_t = FigureWidth::default())]
    pub width: FigureWidth,
    /// Pixels of an inch of paper.
    #[arg(long = "dpi", value_name = "DPI", default_value_t = 300, value_parser = clap::value_parser!(u32).range(i64::from(*DOTS_PER_INCH.start())..=i64::from(*DOTS_PER_INCH.end())))]
    pub dots_per_inch: u32,
    /// Size of the type, typographic points.
    #[arg(long = "type-size", value_name = "POINTS", default_value_t = 8.0, value_parser = length)]
    pub type_points: f64,
    /// A text below the picture.
    #[arg(long, value_name = "TEXT", default_value = "")]
    pub caption: String,
    /// Dark type on white paper, or light type on dark paper.
    #[arg(long = "theme", value_name = "THEME", default_value = "light", action = clap::ArgAction::Set, value_parser = one_of([("light", false), ("dark", true)]))]
    pub is_dark: bool,
    /// The unit of the scene's lengths.
    #[arg(long, default_value = "m", value_parser = one_of(UNITS))]
    pub unit: Unit,
    /// Leave out what colors mean, the scalar bar too.
    #[arg(long = "no-legend", action = clap::ArgAction::SetFalse)]
    pub has_legend: bool,
    /// Leave out the scale bar.
    #[arg(long = "no-scale-bar", action = clap::ArgAction::SetFalse)]
    pub has_scale_bar: bool,
}

/// Pixels of an inch of paper.
pub(crate) const DOTS_PER_INCH: std::ops::RangeInclusive<u32> = 30..=2400;

impl Default for FigureOptions {
    fn default() -> Self {
        Self {
            width: FigureWidth::default(),
            dots_per_inch: 300,
            type_points: 8.0,
            caption: String::new(),
            is_dark: false,
            has_legend: true,
            has_scale_bar: true,
            unit: Unit::default(),
        }
    }
}

impl FigureOptions {
    /// Columns, pixels.
    pub(crate) fn columns(&self) -> u32 {
        self.width.columns(self.dots_per_inch)
    }

    /// Width on paper, millimeters.
    pub(crate) fn width_mm(&self) -> f64 {
        f64::from(self.columns()) / f64::from(self.dots_per_inch) * INCH_MM
    }
}

/// A finite number above 0.
pub(crate) fn length(text: &str) -> Result<f64, String> {
    let number = text.parse::<f64>().ok().filter(|number| number.is_finite() && *number > 0.0);
    number.ok_or_else(|| "must be a number above 0".to_owned())
}

/// A parser of one of some names.
pub(crate) fn one_of<T: Copy + Send + Sync + 'static, const N: usize>(
    names: [(&'static str, T); N],
) -> impl TypedValueParser<Value = T> {
    PossibleValuesParser::new(names.map(|(name, _)| name)).try_map(move |given| {
        let known = names.iter().find(|(name, _)| *name == given);
        known.map(|(_, value)| *value).ok_or("not known")
    })
}

/// Units by their names on the command line.
const UNITS: [(&str, Unit); 4] =
    [("m", Unit::Meters), ("cm", Unit::Centimeters), ("mm", Unit::Millimeters), ("none", Unit::None)];

/// The unit of the scene's lengths.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Unit {
    #[default]
    Meters,
    Centimeters,
    Millimeters,
    None,
}

impl Unit {
    /// Every unit: its name, and what it means.
    pub(crate) const ALL: [(Self, &'static str, &'static str); 4] = [
        (Self::Meters, "m", "One unit of the scene is a meter."),
        (Self::Centimeters, "cm", "One unit of the scene is a centimeter."),
        (Self::Millimeters, "mm", "One unit of the scene is a millimeter."),
        (Self::None, "units", "The scene has no unit of length."),
    ];

    /// Its name.
    pub(crate) fn name(self) -> &'static str {
        Self::ALL.iter().find(|(unit, ..)| *unit == self).map_or("", |(_, name, _)| name)
    }

    /// A length with its unit.
    pub(crate) fn length(self, length: f64) -> String {
        format!("{} {}", significant(length), self.name())
    }
}

/// Width of a figure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum FigureWidth {
    Pixels(u32),
    Millimeters(f64),
}

impl Default for FigureWidth {
    fn default() -> Self {
        Self::Millimeters(120.0)
    }
}

impl FigureWidth {
    /// Columns at so many pixels an inch, of those that figures may have.
    pub(crate) fn columns(self, dots_per_inch: u32) -> u32 {
        let [fewest, most] = FIGURE_COLUMNS;
        match self {
            Self::Pixels(columns) => columns.clamp(fewest, most),
            Self::Millimeters(width) => {
                let columns = width / INCH_MM * f64::from(dots_per_inch);
                columns.round().clamp(f64::from(fewest), f64::from(most)) as u32
            }
        }
    }
}

impl Display for FigureWidth {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Pixels(columns) => write!(formatter, "{columns}px"),
            Self::Millimeters(width) => write!(formatter, "{width}mm"),
        }
    }
}

impl FromStr for FigureWidth {
    type Err = String;

    /// As in `120mm`, `12cm`, `4.7in` or `1400px`.
    fn from_str(text: &str) -> Result<Self, String> {
        let units = [("mm", 1.0), ("cm", 10.0), ("in", INCH_MM)];
        let width = units.into_iter().find_map(|(unit, size)| {
            let number: f64 = text.strip_suffix(unit)?.trim().parse().ok()?;
            (number.is_finite() && number > 0.0).then_some(Self::Millimeters(number * size))
        });
        let pixels = || {
            let columns = text.strip_suffix("px")?.trim().parse().ok()?;
            (FIGURE_COLUMNS[0]..=FIGURE_COLUMNS[1]).contains(&columns).then_some(Self::Pixels(columns))
        };
        width.or_else(pixels).ok_or_else(|| {
            format!(
                "must be a width with its unit, as in 120mm, 12cm, 4.7in or 1400px (from {}px to {}px)",
                FIGURE_COLUMNS[0], FIGURE_COLUMNS[1]
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn widths_are_read_with_their_unit_and_become_columns() {
        let columns = |text: &str| text.parse::<FigureWidth>().map(|width| width.columns(300));
        assert_eq!(["120mm", "12 cm", "2in", "1400px"].map(columns), [1417, 1417, 600, 1400].map(Ok));
        for text in ["", "120", "mm", "-3mm", "nanmm", "10px", "99999px", "1.5px"] {
            assert!(text.parse::<FigureWidth>().is_err(), "{text}");
        }
        assert!((FigureOptions::default().width_mm() - 120.0).abs() < 0.1);
        let lengths = (Unit::Meters.length(1.5), Unit::None.length(0.25));
        assert_eq!(lengths, ("1.50 m".into(), "0.25 units".into()));
    }
}
