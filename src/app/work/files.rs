//! Reads and writes files: stores, settings, pictures and films; and asks where.

use std::path::{Path, PathBuf};

use egui::ColorImage;
use image::{ImageFormat, RgbImage};

use super::requests::{ExportRequest, FileRequest};
use crate::app::model::{Destination, ExportTarget, Exported, Message, NO_KEYS, Purpose};
use crate::capture::Capture;
use crate::error::{Error, Result};
use crate::job::Job;
use crate::render::film::{self, FilmEncoder, FilmSource};
use crate::render::output::write_png;
use crate::render::{Picture, Renderer};
use crate::settings::Settings;
use crate::store::file::{Extras, Provenance};
use crate::{store, whole_file};

/// The ending of a picture's file.
const ENDING: &str = "png";

/// The path with the ending that a picture has; `None` where it has another one.
pub(crate) fn with_ending(path: PathBuf) -> Option<PathBuf> {
    match path.extension() {
        None => Some(path.with_extension(ENDING)),
        Some(ending) => ending.eq_ignore_ascii_case(ENDING).then_some(path),
    }
}

/// Writes a picture as it is shown. The file takes its name once it is whole.
fn write_picture(path: &Path, picture: &ColorImage) -> Result<()> {
    let [width, height] = picture.size.map(|side| side as u32);
    let bytes = picture.pixels.iter().flat_map(|pixel| [pixel.r(), pixel.g(), pixel.b()]).collect();
    let png = RgbImage::from_raw(width, height, bytes).ok_or_else(|| {
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
        FileRequest::SaveAgain { path, playback } => {
            let bytes = store::write_again(&path, playback.store(), None, job)?;
            (path, Some(bytes), None)
        }
        FileRequest::SaveSettings { path, settings } => {
            whole_file::write_all(&path, settings.to_toml())?;
            (path, None, None)
        }
        FileRequest::SavePicture { path, picture } => {
            write_picture(&path, &picture)?;
            (path, None, None)
        }
        FileRequest::SaveText { path, text } => {
            whole_file::write_all(&path, text)?;
            (path, None, None)
        }
        FileRequest::LoadSettings { path } => {
            let settings = Settings::load(&path)?;
            return Ok(Message::SettingsLoaded { path, settings });
        }
    };
    Ok(Message::Saved { path, bytes, holds })
}

/// Paints and writes all pictures.
pub(crate) fn export(request: &ExportRequest, job: &Job) -> Result<Message> {
    let vantages = request.path.vantages(request.size, request.reel.frame_count());
    if vantages.is_empty() {
        return Err(Error::invalid("camera path", NO_KEYS));
    }
    let mut renderer = Renderer::new();
    let mut paint = |take: &mut dyn FnMut(usize, &Picture) -> Result<()>| {
        film::paint(&request.reel, &vantages, &mut renderer, &request.settings, job, take)
    };
    let ExportTarget { path, film_rate } = &request.target;
    if let Some(rate) = film_rate {
        let mut encoder = FilmEncoder::start(path, request.size.map(|side| side as usize), *rate)?;
        paint(&mut |_, picture| encoder.add(picture))?;
        encoder.finish(job)?;
    } else {
        std::fs::create_dir_all(path).map_err(|error| Error::io(path, error))?;
        paint(&mut |nth, picture| write_png(&path.join(format!("{:04}.png", nth + 1)), picture))?;
    }
    let damage = match &request.reel {
        FilmSource::Memory(_) => Vec::new(),
        FilmSource::Disk(playback) => playback.store().damage(),
    };
    let exported =
        Exported { pictures: vantages.len(), notice: renderer.notice().map(str::to_owned), damage };
    Ok(Message::Exported { path: path.clone(), exported })
}

/// Whether something stands at a destination that would be replaced.
pub(crate) fn check(destination: Destination) -> Message {
    let path = &destination.path;
    let taken = match destination.purpose {
        Purpose::ExportPictures => std::fs::read_dir(path).is_ok_and(|mut entries| entries.next().is_some()),
        _ if !destination.purpose.writes() => path.exists(),
        _ => path.is_file(),
    };
    Message::DestinationChecked { destination, taken }
}

/// The path that is chosen in the system's dialog; `None` where it is closed.
pub(crate) fn ask(purpose: Purpose, name: String) -> Option<PathBuf> {
    let dialog = rfd::FileDialog::new().set_file_name(name).set_title(purpose.title());
    match purpose {
        Purpose::OpenFolder | Purpose::ExportPictures => dialog.pick_folder(),
        Purpose::OpenFile => dialog
            .add_filter("Stores and captures", &["ovl", "json", "txt", "bin", "log"])
            .add_filter("All files", &["*"])
            .pick_file(),
        Purpose::LoadSettings => dialog.add_filter("Settings", &["toml"]).pick_file(),
        Purpose::SaveStore => dialog.add_filter("Store", &["ovl"]).save_file(),
        Purpose::SaveSettings => dialog.add_filter("Settings", &["toml"]).save_file(),
        Purpose::SavePicture => dialog.add_filter("PNG", &["png"]).save_file(),
        Purpose::SaveTable(_) => dialog.add_filter("CSV", &["csv"]).save_file(),
        Purpose::ExportFilm => dialog.add_filter("Video", &["mp4", "mkv", "mov"]).save_file(),
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
        assert_eq!((ending("/a/view.jpg"), ending("/a/view.2")), (None, None));
    }
}
