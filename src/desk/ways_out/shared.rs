//! What all ways out share: what is said of each, what is chosen of them, and what sizes follow from.

use std::path::Path;
use std::sync::Arc;

use super::figure_options::{FigureOf, FigureOptions};
use crate::text::bytes;
use overlook_engine::error::{Error, Result};
use overlook_engine::job::Job;
use overlook_engine::page::PagePath;
use overlook_engine::render::film::{FilmComparison, FilmSource};
use overlook_engine::samples::SampleSet;
use overlook_engine::splats::{SplatFormat, SplatSky};
use overlook_engine::whole_file;

/// A way out, by its place in the table.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Way {
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

/// Writes samples to a path; gives what was written, and how many files.
pub(crate) type Write = fn(&Path, &FilmSource, &Shared, &Job) -> Result<(String, usize)>;

/// What is said of a way out.
pub(crate) struct WayOut {
    /// Its name in the dialog and the palette.
    pub name: &'static str,
    /// What it is for, in the dialog.
    pub used: &'static str,
    /// What the button says that makes it.
    pub button: &'static str,
    /// Its command below `overlook export`, and the help of that; empty where there is none.
    pub command: &'static str,
    pub about: &'static str,
    /// What is written by the options of the dialog.
    pub kind: fn(&Options) -> &'static FileKind,
    /// How large that will be.
    pub size: fn(&Scope, &Options) -> Size,
    /// What writes it, and the kinds that it writes; `None` where the window writes it of its own state.
    pub write: Option<(&'static [FileKind], Write)>,
}

/// A kind of file, or a folder of numbered files.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct FileKind {
    /// The title of the dialog that asks for its path.
    pub title: &'static str,
    /// The endings that it may have, the usual one first; none of a folder.
    pub endings: &'static [&'static str],
    /// Its likely name without ending; empty for the name of the scene.
    pub stem: &'static str,
    pub action: Action,
    pub needs: Needs,
}

impl FileKind {
    /// A file that is made of all samples.
    pub(crate) const fn of_samples(
        title: &'static str,
        endings: &'static [&'static str],
        stem: &'static str,
    ) -> Self {
        Self { title, endings, stem, action: Action::Export, needs: Needs::Samples }
    }
}

/// What is done with a path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Action {
    Open,
    Load,
    Save,
    Export,
}

impl Action {
    /// Its word.
    pub(crate) fn word(self) -> &'static str {
        ["Open", "Load", "Save", "Export"][self as usize]
    }
}

/// What has to be there before something is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Needs {
    Nothing,
    Scene,
    /// Those of the whole capture.
    Samples,
    /// Samples, and a camera path or a comparison.
    Film,
    /// A picture of the view that the figure shows.
    Figure,
}

/// What is chosen in the dialog.
#[derive(Clone, Debug, PartialEq)]
#[expect(clippy::struct_excessive_bools, reason = "switches of the dialog, each by its name")]
pub(crate) struct Options {
    pub way: Way,
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
    /// Whether pictures are those of the camera path in place of this view.
    pub along_path: bool,
    /// Columns and rows of a picture of this view; `None` for those that are shown.
    pub picture_size: Option<[u32; 2]>,
    /// How a video or pictures along the camera path show both sides of the comparison; `None` for the samples alone.
    pub compares: Option<FilmComparison>,
    /// Text below every picture of a video; empty for none.
    pub film_caption: String,
    /// Whether pictures are EXR with linear color and depth.
    pub linear: bool,
    /// Whether points are those of every frame, in a folder.
    pub points_of_all_frames: bool,
    pub figure_of: FigureOf,
    pub figure: FigureOptions,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            way: Way::default(),
            title: String::new(),
            text: String::new(),
            page_is_bounded: false,
            page_megabytes: 10.0,
            format: SplatFormat::Ply,
            sky: SplatSky::Dome,
            splats_are_bounded: false,
            kilosplats: 500,
            along_path: false,
            picture_size: None,
            compares: None,
            film_caption: String::new(),
            linear: false,
            points_of_all_frames: false,
            figure_of: FigureOf::default(),
            figure: FigureOptions::default(),
        }
    }
}

impl Options {
    /// Most bytes of a page.
    pub(crate) fn page_at_most(&self) -> Option<u64> {
        self.page_is_bounded.then_some((self.page_megabytes * 1e6) as u64)
    }

    /// Most splats.
    pub(crate) fn splats_at_most(&self) -> Option<u64> {
        self.splats_are_bounded.then_some(self.kilosplats * 1000)
    }
}

/// What is written of samples, beside them.
pub(crate) struct Shared {
    pub kind: &'static FileKind,
    pub options: Options,
    pub frames: Frames,
    pub frames_per_second: f64,
    /// The camera path as a page follows it.
    pub path: Option<PagePath>,
    /// How a count and its noun are written.
    pub count: fn(u64, &str) -> String,
}

/// Which samples are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Frames {
    /// Those of a frame.
    One(usize),
    /// What stays the same over all frames.
    Still,
    /// Those of every frame, each in a file of its own where a file holds one.
    Every,
}

/// What was measured of the open scene, for sizes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Facts {
    /// Kept samples.
    pub samples: u64,
    /// Those with a place that are shown at the frame, and those at infinity.
    pub placed_here: u64,
    pub at_infinity_here: u64,
    /// Bytes of the store: of an open one as it is, else by writing all samples or those of some cameras.
    pub store_bytes: f64,
    /// Facts of the live view's picture; `None` while none is in memory.
    pub picture: Option<PictureFacts>,
}

/// What the picture of the live view takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PictureFacts {
    pub pixels: f64,
    pub png_bytes: f64,
    pub exr_bytes: f64,
}

impl PictureFacts {
    /// How many times as many pixels a picture of some columns and rows has.
    pub(crate) fn share_of(self, [width, height]: [u32; 2]) -> f64 {
        f64::from(width) * f64::from(height) / self.pixels.max(1.0)
    }
}

/// What sizes follow from.
pub(crate) struct Scope {
    pub facts: Facts,
    pub cameras: usize,
    pub frames: usize,
    /// Whether cameras stand so far from the origin that places need double precision.
    pub is_far: bool,
    pub frames_per_second: f64,
    /// Pictures of a film, with their columns and rows.
    pub film_pictures: usize,
    pub film_size: [u32; 2],
    /// Columns and rows of the picture of a figure.
    pub figure_size: [u32; 2],
}

/// A size, and what it follows from.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Size {
    /// As in `about 2.4 MB`; what is missing where there is none.
    pub text: String,
    /// What it is the product of.
    pub reason: String,
}

impl Size {
    pub(crate) fn about(size: f64, reason: String) -> Self {
        Self { text: format!("about {}", bytes(size.round() as u64)), reason }
    }

    /// The size of each picture, for a path that has no length yet.
    pub(crate) fn each(size: f64, unit: &str, [width, height]: [u32; 2]) -> Self {
        let Self { text, .. } = Self::about(size, String::new());
        Self { text: format!("{text} a {unit}"), reason: format!("of {width}×{height}") }
    }

    /// Why there is none.
    pub(crate) fn missing(text: &str) -> Self {
        Self { text: text.to_owned(), reason: String::new() }
    }
}

/// A folder that goes when it is dropped.
///
/// # Errors
/// `Io`.
pub(crate) fn temporary_folder() -> Result<tempfile::TempDir> {
    tempfile::tempdir().map_err(|error| Error::io(std::env::temp_dir(), error))
}

/// The samples of a frame, perhaps with those of others.
pub(crate) fn at(source: &FilmSource, frame: usize, job: &Job) -> Result<Arc<SampleSet>> {
    match source {
        FilmSource::Memory(samples) => Ok(samples.clone()),
        FilmSource::Disk(playback) => playback.at(frame, job),
    }
}

/// Writes a file for each frame into a folder, as 0001.ply with the number of the frame, all of them or none. `write` gets the name of a
/// file, and the samples of the frame with its index; what it gives is given frame by frame.
pub(crate) fn write_frames<T>(
    folder: &Path,
    ending: &str,
    source: &FilmSource,
    job: &Job,
    mut write: impl FnMut(&Path, &SampleSet, usize) -> Result<T>,
) -> Result<Vec<T>> {
    let frames = source.frame_count();
    job.start("Writing frames", frames);
    whole_file::write_folder(folder, |folder| {
        let files = (0..frames).map(|frame| {
            job.check()?;
            let set = at(source, frame, job)?;
            let number = set.frame_numbers.get(frame).copied().unwrap_or(frame as i64);
            let written = write(&folder.join(format!("{number:04}.{ending}")), &set, frame)?;
            job.advance(1);
            Ok(written)
        });
        files.collect()
    })
}
