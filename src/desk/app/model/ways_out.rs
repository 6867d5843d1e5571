//! Ways out of the window, and what is chosen for each.

use std::path::PathBuf;

use crate::app::model::purpose::{FigureOf, FigureOptions, Purpose};
use overlook_engine::render::film::FilmComparison;
use overlook_engine::splats::{SplatFormat, SplatSky};

/// A way out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum ShareWay {
    #[default]
    Page,
    Splats,
    Film,
    Pictures,
    Figure,
    Points,
    Cameras,
    Store,
}

impl ShareWay {
    /// Every way in the order of the dialog: its name, and what it is for.
    pub(crate) const ALL: [(Self, &'static str, &'static str); 8] = [
        (
            Self::Page,
            "Interactive page",
            "One HTML file that plays the scene from any viewpoint, in any browser and offline: to mail, to publish, or to put beside \
             a paper.",
        ),
        (
            Self::Splats,
            "Splats",
            "Gaussian splats for other viewers and engines: every kept sample is one, as wide as its pixel. Nothing is trained.",
        ),
        (Self::Film, "Video", "A video along the camera path, which everybody can play."),
        (
            Self::Pictures,
            "Pictures",
            "This view as it is shown, or every picture of the camera path: PNG, or EXR with linear color and depth.",
        ),
        (
            Self::Figure,
            "Figure",
            "A picture for print, with what its colors mean, a scale bar and a caption: PDF, SVG or PNG.",
        ),
        (
            Self::Points,
            "Points",
            "A point cloud with normals, colors and radii as PLY, for programs that measure and mesh.",
        ),
        (
            Self::Cameras,
            "Cameras",
            "Pose and lens of every camera as a transforms.json, for other programs and for viewpoints of overlook render --views.",
        ),
        (
            Self::Store,
            "Store",
            "All kept samples in one file that Overlook opens at once, on any machine and without the recording.",
        ),
    ];

    /// Its name and what it is for.
    pub(crate) fn name_and_use(self) -> (&'static str, &'static str) {
        let known = Self::ALL.iter().find(|(way, ..)| *way == self);
        known.map_or(("", ""), |(_, name, used)| (name, used))
    }
}

/// What pictures are of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum SharedPictures {
    #[default]
    View,
    CameraPath,
}

impl SharedPictures {
    /// Every choice: its name and what it is.
    pub(crate) const ALL: [(Self, &'static str, &'static str); 2] = [
        (Self::View, "This view", "The picture of the live view."),
        (Self::CameraPath, "Camera path", "A folder of numbered pictures along the camera path."),
    ];
}

/// What is chosen in the dialog.
#[derive(Clone, Debug, PartialEq)]
#[expect(clippy::struct_excessive_bools, reason = "switches of the dialog, each by its name")]
pub(crate) struct ShareOptions {
    pub way: ShareWay,
    /// Title of the page; empty for the name of the scene.
    pub title: String,
    /// Text of the page's author.
    pub text: String,
    /// Most megabytes of a page, where it is bounded.
    pub page_is_bounded: bool,
    pub page_megabytes: f64,
    pub format: SplatFormat,
    pub sky: SplatSky,
    /// Most thousands of splats, where they are bounded.
    pub splats_are_bounded: bool,
    pub kilosplats: u64,
    pub pictures: SharedPictures,
    /// Columns and rows of a picture of this view; `None` for those that are shown.
    pub picture_size: Option<[u32; 2]>,
    /// How a video or pictures along the camera path show both sides of the comparison; `None` for the samples alone.
    pub compares: Option<FilmComparison>,
    /// Whether pictures are EXR with linear color and depth.
    pub linear: bool,
    /// Whether points are those of every frame, in a folder.
    pub points_of_all_frames: bool,
    pub figure_of: FigureOf,
    pub figure: FigureOptions,
}

impl Default for ShareOptions {
    fn default() -> Self {
        Self {
            way: ShareWay::default(),
            title: String::new(),
            text: String::new(),
            page_is_bounded: false,
            page_megabytes: 10.0,
            format: SplatFormat::Ply,
            sky: SplatSky::Out,
            splats_are_bounded: false,
            kilosplats: 500,
            pictures: SharedPictures::default(),
            picture_size: None,
            compares: None,
            linear: false,
            points_of_all_frames: false,
            figure_of: FigureOf::default(),
            figure: FigureOptions::default(),
        }
    }
}

impl ShareOptions {
    /// What a path is chosen for.
    pub(crate) fn purpose(&self) -> Purpose {
        match (self.way, self.pictures) {
            (ShareWay::Page, _) => Purpose::ExportPage,
            (ShareWay::Splats, _) => Purpose::ExportSplats(self.format),
            (ShareWay::Film, _) => Purpose::ExportFilm,
            (ShareWay::Pictures, SharedPictures::View) => Purpose::SavePicture,
            (ShareWay::Pictures, SharedPictures::CameraPath) if self.linear && self.compares.is_none() => {
                Purpose::ExportExr
            }
            (ShareWay::Pictures, SharedPictures::CameraPath) => Purpose::ExportPictures,
            (ShareWay::Figure, _) => Purpose::ExportFigure,
            (ShareWay::Points, _) if self.points_of_all_frames => Purpose::ExportPointsOfFrames,
            (ShareWay::Points, _) => Purpose::ExportPoints,
            (ShareWay::Cameras, _) => Purpose::SaveCameras,
            (ShareWay::Store, _) => Purpose::SaveStore,
        }
    }

    /// Most bytes of a page.
    pub(crate) fn page_at_most(&self) -> Option<u64> {
        self.page_is_bounded.then_some((self.page_megabytes * 1e6) as u64)
    }

    /// Most splats.
    pub(crate) fn splats_at_most(&self) -> Option<u64> {
        self.splats_are_bounded.then_some(self.kilosplats * 1000)
    }
}

/// What can be done in the dialog.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum ShareCommand {
    /// Open it, at a way or where it was.
    Open(Option<ShareWay>),
    Close,
    Change(Box<ShareOptions>),
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
