//! The purposes of paths that a person chooses, and the tables and figures that are written to some of them.

use std::path::{Path, PathBuf};

use crate::app::model::work_kind::WorkKind;
use crate::app::rooms::charts::state::Study;
use crate::app::rooms::files::state::SESSION_ENDING;
use crate::ways_out::figure::FIGURE;
pub(crate) use crate::ways_out::figure::FigureOf;
use crate::ways_out::{Action, FileKind, Options, Way};

/// What a chosen path is for; [`Purpose::asked`] has the words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Purpose {
    OpenFile,
    OpenFolder,
    /// Write what the dialog of all ways out makes.
    Share(&'static FileKind),
    SaveSettings,
    LoadSettings,
    /// Write a table, in the form that the ending of its file says.
    SaveTable(Table),
    /// Write the chart of a study, in the format that the ending of its file says.
    SaveChart(Study),
    SavePath,
    LoadPath,
    OpenPictures,
    SaveEdits,
    LoadEdits,
    SaveSession,
}

/// What is said of a path that is asked for.
pub(crate) struct AskedPath {
    pub action: Action,
    /// The title of the dialog.
    pub title: &'static str,
    /// As those of a [`FileKind`].
    pub endings: &'static [&'static str],
    pub stem: &'static str,
}

/// The endings of what can be opened.
const OPENED: [&str; 6] = ["ovl", SESSION_ENDING, "json", "txt", "bin", "log"];

impl Purpose {
    /// What is said of its path.
    pub(crate) fn asked(self) -> AskedPath {
        use Action::{Load, Open, Save};
        let (action, title, endings, stem): (_, _, &[&str], _) = match self {
            Self::OpenFile => (Open, "Open a store, or the file of a capture", &OPENED, ""),
            Self::OpenFolder => (Open, "Open a capture folder", &[], ""),
            Self::Share(kind) => (kind.action, kind.title, kind.endings, kind.stem),
            Self::SaveSettings => (Save, "Save the settings", &["toml"], "settings"),
            Self::LoadSettings => (Load, "Load settings", &["toml"], ""),
            Self::SaveTable(_) => {
                let title = "Save a table as CSV, Markdown (.md) or LaTeX (.tex)";
                (Save, title, &["csv", "md", "tex"], "")
            }
            Self::SaveChart(_) => (Save, "Save a chart as PDF, SVG or PNG", FIGURE.endings, ""),
            Self::SavePath => (Save, "Save the camera path", &["json"], "transforms"),
            Self::LoadPath => (Load, "Open a camera path", &["json"], ""),
            Self::OpenPictures => (Load, "Open pictures of another program", &[], ""),
            Self::SaveEdits => (Save, "Save the edits", &["toml"], "edits"),
            Self::LoadEdits => (Load, "Open edits", &["toml"], ""),
            Self::SaveSession => (Save, "Save the session", &[SESSION_ENDING], "session"),
        };
        AskedPath { action, title, endings, stem }
    }

    /// Whether something is written to the path.
    pub(crate) fn writes(self) -> bool {
        matches!(self.asked().action, Action::Save | Action::Export)
    }

    /// The work that reads or writes there.
    pub(crate) fn work(self) -> WorkKind {
        match self.asked().action {
            Action::Open => WorkKind::Open,
            Action::Export => WorkKind::Export,
            Action::Load | Action::Save => WorkKind::File,
        }
    }
}

/// What can be done in the dialog.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum ShareCommand {
    /// Open it, at a way or where it was.
    Open(Option<Way>),
    Close,
    Change(Box<Options>),
    /// Copy a figure of a view. `None` is the view under the pointer or filling the window, if that is the source view or the comparison,
    /// else the live view.
    CopyFigure(Option<FigureOf>),
    /// Copy the picture of a view as it is shown, with nothing around it.
    CopyPicture(FigureOf),
    /// Stop what is being written.
    Stop,
    /// Open the folder of a file in the system's file manager.
    ShowInFolder(PathBuf),
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
