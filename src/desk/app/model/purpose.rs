//! The purposes of paths that a person chooses, and the tables and figures that are written to some of them.

use std::fmt::{self, Display};
use std::path::{Path, PathBuf};
use std::str::FromStr;

use crate::app::model::look::Unit;
use crate::app::model::work_kind::WorkKind;
use crate::app::rooms::charts::state::Study;
use overlook_engine::splats::SplatFormat;
use overlook_lab::chart::{FIGURE_COLUMNS, INCH_MM};

/// What a chosen path is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Purpose {
    /// Open a store or a manifest.
    OpenFile,
    /// Open the folder of a capture.
    OpenFolder,
    SaveStore,
    /// Write the settings as TOML.
    SaveSettings,
    /// Read settings from TOML.
    LoadSettings,
    /// Write the picture of the live view.
    SavePicture,
    /// Write a table, in the form that the ending of its file says.
    SaveTable(Table),
    /// Write the chart of a study, in the format that the ending of its file says.
    SaveChart(Study),
    /// Write the pictures of the camera path into a folder.
    ExportPictures,
    /// Write the pictures of the camera path into a folder, as EXR with depth.
    ExportExr,
    /// Write a film of the camera path.
    ExportFilm,
    /// Write a page that plays the scene.
    ExportPage,
    /// Write splats in a format.
    ExportSplats(SplatFormat),
    /// Write a figure of a view.
    ExportFigure,
    /// Write the points of the frame that is shown.
    ExportPoints,
    /// Write the points of every frame into a folder.
    ExportPointsOfFrames,
    /// Write the poses and lenses of all cameras as a manifest.
    SaveCameras,
    /// Write the camera path as a manifest.
    SavePath,
    /// Read a camera path from a manifest.
    LoadPath,
    /// Read pictures that another program made.
    OpenPictures,
    /// Write the edit list as TOML.
    SaveEdits,
    /// Read an edit list from TOML.
    LoadEdits,
    /// Write what is open and all that was set about it.
    SaveSession,
}

impl Purpose {
    /// Whether something is written to the path.
    pub(crate) fn writes(self) -> bool {
        !matches!(
            self,
            Self::OpenFile
                | Self::OpenFolder
                | Self::LoadSettings
                | Self::LoadPath
                | Self::OpenPictures
                | Self::LoadEdits
        )
    }

    /// Whether the dialog of all ways out asks for it.
    pub(crate) fn is_shared(self) -> bool {
        self.work() == WorkKind::Export
            || matches!(self, Self::SaveStore | Self::SavePicture | Self::SaveCameras)
    }

    /// The work that reads or writes there.
    pub(crate) fn work(self) -> WorkKind {
        match self {
            Self::OpenFile | Self::OpenFolder => WorkKind::Open,
            Self::ExportPictures
            | Self::ExportExr
            | Self::ExportFilm
            | Self::ExportPage
            | Self::ExportSplats(_)
            | Self::ExportFigure
            | Self::ExportPoints
            | Self::ExportPointsOfFrames => WorkKind::Export,
            _ => WorkKind::File,
        }
    }

    /// The title of the dialog that asks for the path.
    pub(crate) fn title(self) -> &'static str {
        match self {
            Self::OpenFile => "Open a store, or a file that a capture is known by",
            Self::OpenFolder => "Open a capture folder",
            Self::SaveStore => "Share the store",
            Self::SaveSettings => "Save the settings",
            Self::LoadSettings => "Load settings",
            Self::SavePicture => "Share the picture of the live view",
            Self::SaveTable(_) => "Save a table as CSV, Markdown (.md) or LaTeX (.tex)",
            Self::SaveChart(_) => "Save a chart as PDF, SVG or PNG",
            Self::ExportPictures => "Share pictures in a folder",
            Self::ExportExr => "Share EXR pictures in a folder",
            Self::SaveCameras => "Share the cameras",
            Self::SavePath => "Save the camera path",
            Self::LoadPath => "Open a camera path",
            Self::OpenPictures => "Open pictures of another program",
            Self::SaveEdits => "Save the edits",
            Self::LoadEdits => "Open edits",
            Self::SaveSession => "Save the session",
            Self::ExportFilm => "Share a video",
            Self::ExportPage => "Share an interactive page",
            Self::ExportSplats(_) => "Share splats",
            Self::ExportFigure => "Share a figure",
            Self::ExportPoints => "Share points",
            Self::ExportPointsOfFrames => "Share points in a folder",
        }
    }

    /// Whether the path is that of a folder, which receives numbered files.
    pub(crate) fn fills_folder(self) -> bool {
        matches!(self, Self::ExportPictures | Self::ExportExr | Self::ExportPointsOfFrames)
    }

    /// What opens the field for typing the path: an entry of the command palette, or a button, whose name ends with dots.
    pub(crate) fn typed_entry(self) -> &'static str {
        match self {
            Self::OpenFile | Self::OpenFolder => "Open path",
            Self::SaveSettings => "Save settings to path",
            Self::LoadSettings => "Load settings from path",
            Self::SaveTable(_) => "Save table…",
            Self::SaveChart(_) => "Save chart…",
            Self::SavePath => "Save camera path to path",
            Self::LoadPath => "Open camera path from path",
            Self::OpenPictures => "Open pictures from path",
            Self::SaveEdits => "Save edits to path",
            Self::LoadEdits => "Open edits from path",
            Self::SaveSession => "Save session to path",
            Self::SaveStore
            | Self::SavePicture
            | Self::SaveCameras
            | Self::ExportPictures
            | Self::ExportExr
            | Self::ExportFilm
            | Self::ExportPage
            | Self::ExportSplats(_)
            | Self::ExportFigure
            | Self::ExportPoints
            | Self::ExportPointsOfFrames => "To path…",
        }
    }
}

/// Somewhere to write, before anything is written there.
#[derive(Clone, Debug)]
pub(crate) struct Destination {
    pub purpose: Purpose,
    pub path: PathBuf,
}

/// A path that is being typed.
#[derive(Clone, Debug)]
pub(crate) struct TypedPath {
    pub purpose: Purpose,
    pub text: String,
    /// Where a name without a folder leads to.
    pub folder: Option<PathBuf>,
    /// Why the field is shown in place of the system's dialog, if it is.
    pub reason: Option<String>,
    /// Whether the path exists already, and the question is whether to replace it.
    pub replaces: bool,
}

/// A form that tables are written in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TableForm {
    Csv,
    Markdown,
    Latex,
}

impl TableForm {
    /// Every form: its name, and the ending of its files.
    pub(crate) const ALL: [(Self, &'static str, &'static str); 3] =
        [(Self::Csv, "CSV", "csv"), (Self::Markdown, "Markdown", "md"), (Self::Latex, "LaTeX", "tex")];

    /// Its name.
    pub(crate) fn name(self) -> &'static str {
        Self::ALL.iter().find(|(form, ..)| *form == self).map_or("", |(_, name, _)| name)
    }

    /// The form of a file, by its ending; CSV where that says nothing.
    pub(crate) fn of_file(path: &Path) -> Self {
        let has = |ending: &str| path.extension().is_some_and(|own| own.eq_ignore_ascii_case(ending));
        Self::ALL.iter().find(|(.., ending)| has(ending)).map_or(Self::Csv, |(form, ..)| *form)
    }
}

/// A table that can be copied or saved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Table {
    Sweep,
    StressTest,
    /// Which camera's samples replace whose.
    Replacements,
    /// How far cameras are off each other.
    Agreement,
    /// What was corrected of cameras.
    Alignment,
    /// The evidence of every camera about the selected pixel.
    Pixel,
    Cameras,
    /// What was kept of all pixels, and why the rest was dropped.
    Pixels,
    /// What the samples of each camera take in memory.
    Memory,
    /// How many samples each span of frames has.
    Spans,
}

impl Table {
    /// Every table: what it is called in commands, and its file.
    pub(crate) const ALL: [(Self, &'static str, &'static str); 10] = [
        (Self::Sweep, "sweep", "sweep.csv"),
        (Self::StressTest, "stress test", "stress.csv"),
        (Self::Replacements, "matrix of replaced samples", "replacements.csv"),
        (Self::Agreement, "matrix of agreement", "agreement.csv"),
        (Self::Alignment, "table of corrections", "alignment.csv"),
        (Self::Pixel, "pixel table", "pixel.csv"),
        (Self::Cameras, "camera table", "cameras.csv"),
        (Self::Pixels, "table of all pixels", "pixels.csv"),
        (Self::Memory, "memory table", "memory.csv"),
        (Self::Spans, "span table", "spans.csv"),
    ];

    /// What it is called in commands.
    pub(crate) fn name(self) -> &'static str {
        Self::ALL.iter().find(|(of, ..)| *of == self).map_or("", |(_, name, _)| name)
    }

    /// Name of its file.
    pub(crate) fn file(self) -> &'static str {
        Self::ALL.iter().find(|(of, ..)| *of == self).map_or("", |(.., file)| file)
    }
}

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
