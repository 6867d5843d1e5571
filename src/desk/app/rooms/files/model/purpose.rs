//! The purposes of paths that a person chooses.

use std::path::PathBuf;

use crate::app::model::work_kind::WorkKind;
use crate::app::rooms::charts::model::study::Study;
use crate::app::rooms::report::model::table::Table;
use overlook_engine::splats::SplatFormat;

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
