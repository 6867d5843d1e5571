//! What a figure for print shows, and how large it is.

use std::fmt::{self, Display};
use std::str::FromStr;

use crate::app::rooms::live::model::view_look::Unit;
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
}

impl FigureOf {
    /// Every choice: its name and what it is.
    pub(crate) const ALL: [(Self, &'static str, &'static str); 3] = [
        (Self::Live, "Live view", "The live view as it is colored, rendered anew at the size of the figure."),
        (Self::Source, "Source picture", "The recorded picture with the overlay that is chosen."),
        (
            Self::Compared,
            "Comparison",
            "What Compare shows, zoomed as there: wiped, side by side, one of both, or their difference with its scale.",
        ),
    ];
}

/// What is chosen of a figure beside its picture.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct FigureOptions {
    /// Columns, pixels.
    pub columns: u32,
    /// Pixels of an inch of paper.
    pub dots_per_inch: u32,
    /// Size of the type, typographic points.
    pub type_points: f64,
    pub caption: String,
    /// Light type on dark paper.
    pub is_dark: bool,
    /// Whether what colors mean is written below the picture.
    pub has_legend: bool,
    /// Whether a scale bar lies in the picture.
    pub has_scale_bar: bool,
    /// The unit of the scene.
    pub unit: Unit,
}

/// Pixels of an inch of paper.
pub(crate) const DOTS_PER_INCH: std::ops::RangeInclusive<u32> = 30..=2400;

impl Default for FigureOptions {
    fn default() -> Self {
        let dots_per_inch = 300;
        Self {
            columns: FigureWidth::default().columns(dots_per_inch),
            dots_per_inch,
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
    /// Width on paper, millimeters.
    pub(crate) fn width_mm(&self) -> f64 {
        f64::from(self.columns) / f64::from(self.dots_per_inch) * INCH_MM
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
    }
}
