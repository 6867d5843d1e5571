//! Results of sweeps, stress tests and choices of views in a folder, and the page that is made of them.

use std::path::{Path, PathBuf};

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use overlook_engine::capture::Frame;
use overlook_engine::error::{Error, Result};
use overlook_engine::render::Picture;
use overlook_engine::whole_file;
use overlook_lab::chart;
use overlook_lab::metrics::ClassMap;
use overlook_lab::report::{self, CaptionedPicture, CaptureResults};
use overlook_lab::stress::{BreakingPoint, StressPoint};
use overlook_lab::sweep::Point;
use overlook_lab::trial::ShownView;
use overlook_lab::tune::ChosenViews;

/// The page's name.
pub(crate) const PAGE: &str = "report.html";

/// What a sweep of one capture gave.
#[derive(Serialize, Deserialize)]
pub(crate) struct SweepDocument {
    pub(crate) capture: String,
    /// In words.
    pub(crate) truth: String,
    /// What was typed.
    pub(crate) command: String,
    /// The program's version.
    pub(crate) version: String,
    pub(crate) points: Vec<Point>,
    /// The worst viewpoints of the default, as pictures in the same folder.
    pub(crate) worst: Vec<SavedPicture>,
}

/// What a stress test of one capture gave.
#[derive(Serialize, Deserialize)]
pub(crate) struct StressDocument {
    pub(crate) capture: String,
    /// In words.
    pub(crate) truth: String,
    /// What was typed.
    pub(crate) command: String,
    /// The program's version.
    pub(crate) version: String,
    pub(crate) points: Vec<StressPoint>,
    pub(crate) failures: Vec<BreakingPoint>,
    /// The first method at the breaking point of each disturbance, as pictures in the same folder.
    pub(crate) breaking: Vec<SavedPicture>,
}

/// The fewest views of one capture that show everything.
#[derive(Serialize, Deserialize)]
pub(crate) struct ViewsDocument {
    pub(crate) capture: String,
    /// In words.
    pub(crate) truth: String,
    /// What was typed.
    pub(crate) command: String,
    /// The program's version.
    pub(crate) version: String,
    #[serde(flatten)]
    pub(crate) chosen: ChosenViews,
}

/// A picture in the folder of its document.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct SavedPicture {
    /// Its name in the folder.
    pub(crate) file: String,
    /// What it shows.
    pub(crate) caption: String,
}

/// The program's version.
pub(crate) fn version() -> String {
    env!("CARGO_PKG_VERSION").to_owned()
}

/// What was typed, with quotes where a shell needs them, but for what is printed.
pub(crate) fn command() -> String {
    let plain =
        |text: &str| text.chars().all(|letter| letter.is_alphanumeric() || "-_=.,/:+@%".contains(letter));
    let quoted = |text: String| {
        if !text.is_empty() && plain(&text) { text } else { format!("'{}'", text.replace('\'', r"'\''")) }
    };
    let measures = |argument: &std::ffi::OsString| argument != "--json";
    let arguments = std::env::args_os()
        .skip(1)
        .filter(measures)
        .map(|argument| quoted(argument.to_string_lossy().into_owned()));
    std::iter::once("overlook".to_owned()).chain(arguments).collect::<Vec<_>>().join(" ")
}

/// Writes what a method shows at a view as [`write_error_map`] does.
pub(crate) fn save_picture(
    folder: &Path,
    file: &str,
    caption: String,
    shown: &ShownView,
) -> Result<SavedPicture> {
    write_error_map(&folder.join(file), &shown.picture, &shown.truth, shown.classes.as_deref())?;
    Ok(SavedPicture { file: file.to_owned(), caption })
}

/// Writes the truth, the picture and its error beside each other.
pub(crate) fn write_error_map(
    path: &Path,
    picture: &Picture,
    truth: &Frame,
    classes: Option<&ClassMap>,
) -> Result<()> {
    let png = chart::error_picture(picture, truth, classes)?;
    if let Some(parent) = path.parent() {
        std::fs::create_dir_all(parent).map_err(|error| Error::io(parent, error))?;
    }
    whole_file::write_all(path, png)
}

/// Writes one page on the results in some folders, or in folders in them, to `out`. Returns how many captures it shows.
pub(crate) fn write_page(folders: &[PathBuf], out: &Path) -> Result<usize> {
    let mut captures = Vec::new();
    for folder in folders {
        let before = captures.len();
        captures.extend(results_in(folder)?);
        if captures.len() == before {
            for inner in subfolders(folder)? {
                captures.extend(results_in(&inner)?);
            }
        }
        if captures.len() == before {
            return Err(Error::invalid(
                folder.display(),
                "holds no sweep.json, stress.json or views.json, nor does a folder in it; write them with 'overlook sweep', 'overlook stress' or 'overlook tune --fewest-views'",
            ));
        }
    }
    whole_file::write_all(out, report::page(&captures))?;
    Ok(captures.len())
}

fn subfolders(folder: &Path) -> Result<Vec<PathBuf>> {
    let io = |error| Error::io(folder, error);
    let entries = std::fs::read_dir(folder).map_err(io)?.collect::<std::io::Result<Vec<_>>>().map_err(io)?;
    let mut folders: Vec<PathBuf> =
        entries.iter().map(std::fs::DirEntry::path).filter(|path| path.is_dir()).collect();
    folders.sort();
    Ok(folders)
}

/// What a folder holds; `None` if neither a sweep nor a stress test nor chosen views.
fn results_in(folder: &Path) -> Result<Option<CaptureResults>> {
    let sweep: Option<SweepDocument> = document(&folder.join("sweep.json"))?;
    let stress: Option<StressDocument> = document(&folder.join("stress.json"))?;
    let views: Option<ViewsDocument> = document(&folder.join("views.json"))?;
    if sweep.is_none() && stress.is_none() && views.is_none() {
        return Ok(None);
    }
    let mut results = CaptureResults::default();
    if let Some(sweep) = sweep {
        results.worst = figures(folder, &sweep.worst)?;
        (results.name, results.truth, results.points) = (sweep.capture, sweep.truth, sweep.points);
        results.commands.push(sweep.command);
        results.versions.push(sweep.version);
    }
    if let Some(stress) = stress {
        results.breaking = figures(folder, &stress.breaking)?;
        (results.stress, results.failures) = (stress.points, stress.failures);
        if results.name.is_empty() {
            (results.name, results.truth) = (stress.capture, stress.truth);
        }
        results.commands.push(stress.command);
        results.versions.push(stress.version);
    }
    if let Some(views) = views {
        results.views = Some(views.chosen);
        if results.name.is_empty() {
            (results.name, results.truth) = (views.capture, views.truth);
        }
        results.commands.push(views.command);
        results.versions.push(views.version);
    }
    Ok(Some(results))
}

fn document<T: DeserializeOwned>(path: &Path) -> Result<Option<T>> {
    if !path.is_file() {
        return Ok(None);
    }
    let text = std::fs::read_to_string(path).map_err(|error| Error::io(path, error))?;
    serde_json::from_str(&text).map(Some).map_err(|error| {
        Error::invalid(path.display(), format!("{error}; it may be of another version: measure it anew"))
    })
}

fn figures(folder: &Path, saved: &[SavedPicture]) -> Result<Vec<CaptionedPicture>> {
    let figure = |saved: &SavedPicture| {
        let path = folder.join(&saved.file);
        let png = std::fs::read(&path).map_err(|error| Error::io(&path, error))?;
        Ok(CaptionedPicture { caption: saved.caption.clone(), png })
    };
    saved.iter().map(figure).collect()
}
