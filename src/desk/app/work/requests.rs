//! The requests that workers take.

use std::path::PathBuf;
use std::sync::Arc;

use glam::DVec3;

use crate::app::model::OpenScene;
use crate::app::model::command::ExportTarget;
use crate::app::model::look::Display;
use crate::app::model::picture::{LiveKey, SourceKey};
use crate::app::model::purpose::FigureOptions;
use crate::app::rooms::charts::state::{Study, StudyChoice};
use crate::app::rooms::compare::state::ComparisonFigure;
use crate::app::rooms::path::CameraPath;
use crate::app::rooms::share::{ComparedFilm, FilmLook};
use overlook_engine::capture::Camera;
use overlook_engine::demo::DemoSpec;
use overlook_engine::edits::EditList;
use overlook_engine::page::PageOptions;
use overlook_engine::preprocess::diagnostics::Report;
use overlook_engine::render::film::FilmSource;
use overlook_engine::render::{Picture, Vantage};
use overlook_engine::samples::SampleSet;
use overlook_engine::settings::{CaptureSettings, RenderSettings, Settings};
use overlook_engine::splats::SplatOptions;
use overlook_engine::store::playback::Playback;
use overlook_lab::chart::Chart;
use overlook_lab::stress::StressPoint;
use overlook_lab::sweep::Point;

/// What to open.
#[derive(Clone, Debug)]
pub(crate) enum OpenRequest {
    /// A built-in scene.
    Demo { spec: DemoSpec, settings: CaptureSettings },
    /// The room that comes with the program.
    Room,
    /// A file or folder; `keys` of a manifest, with their values as JSON, count whatever its files say.
    Path { path: PathBuf, settings: CaptureSettings, keys: Vec<(String, String)> },
}

/// A file to read or write.
pub(crate) enum FileRequest {
    /// Write what was pruned of a scene as a store.
    SaveStore {
        path: PathBuf,
        scene: Arc<OpenScene>,
        samples: Arc<SampleSet>,
        report: Arc<Report>,
    },
    /// The open store again, under another name.
    SaveAgain {
        path: PathBuf,
        playback: Arc<Playback>,
        /// What is cut out of it.
        edits: EditList,
    },
    /// Prune a scene again with edits, and write the store.
    SaveEdited {
        path: PathBuf,
        scene: Arc<OpenScene>,
        settings: Settings,
        edits: EditList,
    },
    SaveEdits {
        path: PathBuf,
        list: EditList,
    },
    LoadEdits {
        path: PathBuf,
        scene: u64,
    },
    SaveSettings {
        path: PathBuf,
        settings: Settings,
    },
    /// Write the picture of the live view, as PNG as it is shown or as EXR as it was rendered, by the path's ending.
    SavePicture {
        path: PathBuf,
        picture: Arc<egui::ColorImage>,
        rendered: Arc<Picture>,
        display: Display,
    },
    LoadSettings {
        path: PathBuf,
    },
    /// Text as it is.
    SaveText {
        path: PathBuf,
        text: String,
    },
    /// Write a chart in the format that the path's ending names.
    SaveChart {
        path: PathBuf,
        chart: Chart,
    },
    /// A chart for the clipboard.
    CopyChart {
        study: Study,
        chart: Chart,
    },
    /// Write the pictures of a camera path, of this size, as a manifest.
    SavePath {
        path: PathBuf,
        scene: Arc<OpenScene>,
        camera_path: CameraPath,
        size: [u32; 2],
        up_in_world: DVec3,
    },
    /// Write poses and lenses of cameras as a manifest.
    SaveCameras {
        path: PathBuf,
        cameras: Vec<Camera>,
        frame_number: i64,
        up_in_world: DVec3,
    },
    LoadPath {
        path: PathBuf,
        scene: u64,
    },
    /// Read which pictures of another program are those of a scene's viewpoints.
    OpenPictures {
        path: PathBuf,
        scene: Arc<OpenScene>,
    },
}

impl FileRequest {
    /// Title and text of the message once it was stopped.
    pub(crate) fn stopped(&self) -> (&'static str, String) {
        match self {
            Self::SaveStore { path, .. }
            | Self::SaveAgain { path, .. }
            | Self::SaveEdited { path, .. }
            | Self::SaveEdits { path, .. }
            | Self::SaveSettings { path, .. }
            | Self::SaveText { path, .. }
            | Self::SaveChart { path, .. }
            | Self::SavePicture { path, .. }
            | Self::SaveCameras { path, .. }
            | Self::SavePath { path, .. } => {
                ("Saving stopped", format!("Nothing was written to {}.", path.display()))
            }
            Self::CopyChart { .. } => ("Copying stopped", "Nothing was copied.".to_owned()),
            Self::LoadSettings { path }
            | Self::LoadPath { path, .. }
            | Self::LoadEdits { path, .. }
            | Self::OpenPictures { path, .. } => {
                ("Loading stopped", format!("Nothing was read from {}.", path.display()))
            }
        }
    }
}

/// What to measure.
pub(crate) struct StudyRequest {
    /// What is open, a capture.
    pub scene: Arc<OpenScene>,
    pub study: Study,
    /// The settings to start from.
    pub settings: Settings,
    /// What is measured, and for how long.
    pub choice: StudyChoice,
    /// What is known of the sweep already.
    pub known: Vec<Point>,
    /// What is known of the stress test already.
    pub known_stress: Vec<StressPoint>,
}

/// What is written of all samples, and where.
pub(crate) struct ExportRequest {
    pub path: PathBuf,
    pub source: FilmSource,
    pub what: Export,
}

/// What becomes of samples.
pub(crate) enum Export {
    /// Pictures along a camera path: a film, or `0001.png`, `0002.png`, … in a folder.
    Path(Box<PathExport>),
    /// A page that plays the scene.
    Page(PageOptions),
    /// Splats of a frame, or of all time where the format holds it.
    Splats { options: SplatOptions, frame: usize },
    /// What the live view shows, in the size of the key's viewpoint.
    View(Box<LiveKey>),
    /// A figure of a view.
    Figure(Box<FigureExport>),
    /// The same, for the clipboard; its path counts for nothing.
    CopyFigure(Box<FigureExport>),
    /// Its picture alone, for the clipboard.
    CopyPicture(Box<FigureExport>),
    /// Points of a frame, or a folder with those of each.
    Points { frame: Option<usize> },
}

/// A figure, and the view that it shows.
pub(crate) enum FigureExport {
    /// The live view; the key has the figure's size.
    Live {
        key: Box<LiveKey>,
        options: FigureOptions,
    },
    Source {
        scene: Arc<OpenScene>,
        key: SourceKey,
        options: FigureOptions,
    },
    /// A comparison as its view shows it.
    Compared {
        compared: Box<ComparisonFigure>,
        options: FigureOptions,
    },
}

/// The pictures of a camera path.
pub(crate) struct PathExport {
    /// The place of each.
    pub vantages: Vec<Vantage>,
    /// The comparison that they show; `None` where they show the samples.
    pub compared: Option<ComparedFilm>,
    /// How they look, where not plain.
    pub look: Option<FilmLook>,
    pub settings: RenderSettings,
    pub display: Display,
    /// Columns and rows of the pictures.
    pub size: [u32; 2],
    pub target: ExportTarget,
}

impl ExportRequest {
    /// What is left of it once it was stopped, in words.
    pub(crate) fn stopped(&self) -> String {
        let written = match &self.what {
            Export::CopyFigure(_) | Export::CopyPicture(_) => return "Nothing was copied.".to_owned(),
            Export::Path(path) if path.target.film_rate.is_none() => {
                "Only the pictures rendered until then were"
            }
            _ => "Nothing was",
        };
        format!("{written} written to {}.", self.path.display())
    }
}
