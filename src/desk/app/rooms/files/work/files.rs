//! Reads and writes files: stores, settings and pictures; and asks where.

use std::path::{Path, PathBuf};

use egui::ColorImage;
use image::{ImageFormat, RgbaImage};

use crate::address;
use crate::app::model::Message;
use crate::app::rooms::colors::model::Display;
use crate::app::rooms::files::model::{Destination, Purpose, SESSION_ENDING};
use crate::app::rooms::files::work::other_pictures;
use crate::app::rooms::report::model::TableForm;
use crate::app::rooms::share::work::figures::{FIGURE_ENDINGS, chart_image, write_chart};
use crate::app::work::requests::FileRequest;
use crate::pruned_store;
use overlook_engine::capture::Capture;
use overlook_engine::capture::transforms::{PathFile, open_path, path_to_json, write_cameras};
use overlook_engine::edited_store::write_edited_store;
use overlook_engine::edits::EditList;
use overlook_engine::error::{Error, Result};
use overlook_engine::job::Job;
use overlook_engine::render::Picture;
use overlook_engine::render::output::write_exr;
use overlook_engine::settings::Settings;
use overlook_engine::store::file::{Extras, Provenance};
use overlook_engine::{store, whole_file};

/// The endings of a picture's file: as shown, and as rendered with depth.
const ENDINGS: [&str; 2] = ["png", "exr"];

/// The path with the ending of a picture; `None` if it has another one.
pub(crate) fn with_ending(path: PathBuf) -> Option<PathBuf> {
    match path.extension() {
        None => Some(path.with_extension(ENDINGS[0])),
        Some(ending) => ENDINGS.iter().any(|known| ending.eq_ignore_ascii_case(known)).then_some(path),
    }
}

/// Writes a picture as it is shown, with alpha 0 where `is_empty`, or as it was rendered, by the ending of its path.
pub(crate) fn save_picture(
    path: &Path,
    picture: &ColorImage,
    rendered: &Picture,
    display: &Display,
) -> Result<()> {
    if path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case(ENDINGS[1])) {
        return write_exr(path, rendered);
    }
    let width = rendered.color.width();
    let pixels = picture.pixels.iter().enumerate();
    let bytes = pixels.flat_map(|(index, pixel)| {
        let is_left_out = display.leaves_out(rendered, (index % width, index / width));
        if is_left_out { [0; 4] } else { [pixel.r(), pixel.g(), pixel.b(), u8::MAX] }
    });
    write_rgba(path, picture.size, bytes.collect())
}

/// Writes a PNG. The file takes its name once it is whole.
fn write_rgba(path: &Path, [width, height]: [usize; 2], bytes: Vec<u8>) -> Result<()> {
    let png = RgbaImage::from_raw(width as u32, height as u32, bytes).filter(|_| width * height > 0);
    let png = png.ok_or_else(|| {
        Error::invalid(path.display(), "the picture has no size; show it once, then try again")
    })?;
    whole_file::write(path, |writer| {
        png.write_to(writer, ImageFormat::Png).map_err(|error| match error {
            image::ImageError::IoError(error) => Error::io(path, error),
            error => Error::invalid(path.display(), error.to_string()),
        })
    })
}

/// Reads or writes a file.
pub(crate) fn file(request: FileRequest, job: &Job) -> Result<Message> {
    let (path, bytes, holds) = match request {
        FileRequest::SaveStore { path, scene, samples, report } => {
            job.start(format!("Saving {}", path.display()), 0);
            let frames_are_ranked = scene.capture().is_some_and(Capture::frames_are_ranked);
            let provenance = Provenance { frames_are_ranked, ..Provenance::default() };
            let extras = Extras { report: report.to_json()?, provenance, ..Extras::default() };
            let bytes = store::file::write_with(&path, &samples, &extras, job)?;
            (path, Some(bytes), Some((scene.id, samples.settings.clone())))
        }
        FileRequest::SaveAgain { path, playback, edits } => {
            let store = playback.store();
            let bytes = if edits.is_idle() {
                store::write_again(&path, store, None, job)?
            } else {
                write_edited_store(&path, store, &edits, None, job)?.0
            };
            (path, Some(bytes), None)
        }
        FileRequest::SaveEdited { path, scene, settings, edits } => {
            let (_, bytes) = pruned_store::prune_into_store(scene.source()?, &settings, &edits, &path, job)?;
            (path, Some(bytes), Some((scene.id, settings)))
        }
        FileRequest::SaveEdits { path, list } => {
            whole_file::write_all(&path, list.to_toml())?;
            return Ok(Message::EditsSaved { path, list });
        }
        FileRequest::LoadEdits { path, scene } => {
            let list = EditList::load(&path)?;
            return Ok(Message::EditsLoaded { scene, path, list });
        }
        FileRequest::SaveSettings { path, settings } => {
            whole_file::write_all(&path, settings.to_toml())?;
            (path, None, None)
        }
        FileRequest::SavePicture { path, picture, rendered, display } => {
            save_picture(&path, &picture, &rendered, &display)?;
            (path, None, None)
        }
        FileRequest::SaveText { path, text } => {
            whole_file::write_all(&path, text)?;
            (path, None, None)
        }
        FileRequest::SaveChart { path, chart } => {
            write_chart(&path, &chart)?;
            (path, None, None)
        }
        FileRequest::CopyChart { study, chart } => {
            return Ok(Message::ChartDrawn { study, image: chart_image(&chart)? });
        }
        FileRequest::SaveCameras { path, cameras, frame_number, up_in_world } => {
            write_cameras(&path, &cameras, frame_number, up_in_world)?;
            (path, None, None)
        }
        FileRequest::SavePath { path, scene, camera_path, size, up_in_world } => {
            let views = camera_path.views(size, &scene.frame_numbers);
            whole_file::write_all(&path, path_to_json(up_in_world, &views, camera_path.easing)?)?;
            return Ok(Message::PathSaved { path, saved: camera_path });
        }
        FileRequest::LoadPath { path, scene } => {
            let file = read_path(&path)?;
            return Ok(Message::PathLoaded { scene, path, file });
        }
        FileRequest::OpenPictures { path, scene } => {
            let folder = other_pictures::open(&path, &scene)?;
            return Ok(Message::PicturesOpened { scene: scene.id, folder });
        }
        FileRequest::LoadSettings { path } => {
            let settings = Settings::load(&path)?;
            return Ok(Message::SettingsLoaded { path, settings });
        }
    };
    Ok(Message::Saved { path, bytes, holds })
}

/// Bytes of a camera path at most: some 100,000 pictures.
const MOST_OF_A_PATH: u64 = 64 << 20;

fn read_path(path: &Path) -> Result<PathFile> {
    let length = std::fs::metadata(path).map_err(|error| Error::io(path, error))?.len();
    if length > MOST_OF_A_PATH {
        return Err(Error::invalid(path.display(), format!("{length} bytes are too many for a camera path")));
    }
    open_path(path, false)
}

/// Whether a destination exists, so that writing would replace it.
pub(crate) fn check(destination: Destination) -> Message {
    let path = &destination.path;
    let taken = match destination.purpose {
        purpose if purpose.fills_folder() => {
            std::fs::read_dir(path).is_ok_and(|mut entries| entries.next().is_some())
        }
        purpose if !purpose.writes() => address::of_path(path).0.exists(),
        _ => path.is_file(),
    };
    Message::DestinationChecked { destination, taken }
}

/// The path that is chosen in the system's dialog; `None` if the dialog is closed.
pub(crate) fn ask(purpose: Purpose, name: String) -> Option<PathBuf> {
    let dialog = rfd::FileDialog::new().set_file_name(name).set_title(purpose.title());
    match purpose {
        Purpose::OpenFolder
        | Purpose::ExportPictures
        | Purpose::ExportExr
        | Purpose::ExportPointsOfFrames
        | Purpose::OpenPictures => dialog.pick_folder(),
        Purpose::OpenFile => dialog
            .add_filter(
                "Stores, captures and sessions",
                &["ovl", SESSION_ENDING, "json", "txt", "bin", "log"],
            )
            .add_filter("All files", &["*"])
            .pick_file(),
        Purpose::LoadSettings => dialog.add_filter("Settings", &["toml"]).pick_file(),
        Purpose::LoadEdits => dialog.add_filter("Edits", &["toml"]).pick_file(),
        Purpose::SaveSession => dialog.add_filter("Session", &[SESSION_ENDING]).save_file(),
        Purpose::SaveEdits => dialog.add_filter("Edits", &["toml"]).save_file(),
        Purpose::SaveCameras => dialog.add_filter("Cameras", &["json"]).save_file(),
        Purpose::SavePath => dialog.add_filter("Camera path", &["json"]).save_file(),
        Purpose::LoadPath => dialog.add_filter("Camera path", &["json"]).pick_file(),
        Purpose::SaveStore => dialog.add_filter("Store", &["ovl"]).save_file(),
        Purpose::SaveSettings => dialog.add_filter("Settings", &["toml"]).save_file(),
        Purpose::SaveTable(_) => TableForm::ALL
            .iter()
            .fold(dialog, |dialog, (_, name, ending)| dialog.add_filter(*name, &[ending]))
            .save_file(),
        Purpose::SavePicture => dialog.add_filter("PNG, EXR", &ENDINGS).save_file(),
        Purpose::ExportFilm => dialog.add_filter("Video", &["mp4", "m4v"]).save_file(),
        Purpose::ExportPage => dialog.add_filter("HTML", &["html"]).save_file(),
        Purpose::ExportSplats(format) => dialog.add_filter("Splats", &[format.name()]).save_file(),
        Purpose::ExportFigure | Purpose::SaveChart(_) => {
            dialog.add_filter("PDF, SVG, PNG", &FIGURE_ENDINGS).save_file()
        }
        Purpose::ExportPoints => dialog.add_filter("PLY", &["ply"]).save_file(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_without_an_ending_gets_one_and_other_endings_are_not_taken() {
        let ending = |path: &str| with_ending(path.into());
        assert_eq!(ending("/a/view"), Some("/a/view.png".into()));
        assert_eq!(ending("/a/view.PNG"), Some("/a/view.PNG".into()));
        assert_eq!(ending("/a/view.exr"), Some("/a/view.exr".into()));
        assert_eq!((ending("/a/view.jpg"), ending("/a/view.2")), (None, None));
    }
}
