//! Writes what is shared: a page, splats, points, and the pictures or the film of a camera path.

use std::path::Path;
use std::sync::Arc;

use crate::app::model::{Message, bytes, count_of, significant};
use crate::app::rooms::colors::work::developed;
use crate::app::rooms::files::work::files::save_picture;
use crate::app::rooms::live::model::{LiveKey, PixelSource};
use crate::app::rooms::live::work::image as live_image;
use crate::app::rooms::live::work::shown_samples::CameraFilter;
use crate::app::rooms::path::model::{Exported, NO_KEYS};
use crate::app::rooms::share::model::FigureOptions;
use crate::app::rooms::share::work::{compared_film, figures, looked_film};
use crate::app::work::requests::{Export, ExportRequest, FigureExport, PathExport};
use crate::points;
use overlook_engine::error::{Error, Result};
use overlook_engine::job::Job;
use overlook_engine::page::{self, PageOptions};
use overlook_engine::plural::counted;
use overlook_engine::render::film::{self, FilmEncoder, FilmSource};
use overlook_engine::render::output::{write_exr, write_png};
use overlook_engine::render::{Picture, Renderer};
use overlook_engine::samples::SampleSet;
use overlook_engine::splats::{self, SplatOptions};
use overlook_engine::store::file::{Extras, Store, write_with};
use overlook_engine::whole_file;
use overlook_lab::chart::Figure;

/// Writes what was asked for. Files take their names once they are whole; of a folder of pictures those that were rendered stay.
/// Comparisons read whole captures on `threads`.
pub(crate) fn export(
    request: &ExportRequest,
    threads: &Arc<rayon::ThreadPool>,
    job: &Job,
) -> Result<Message> {
    let ExportRequest { path, source, what } = request;
    let mut notice = None;
    let said = match what {
        Export::Path(export) => {
            let (said, used) = write_path(path, source, export, threads, job)?;
            notice = used;
            said
        }
        Export::Page(options) => write_page(path, source, options, job)?,
        Export::Splats { options, frame } => write_splats(path, source, options, *frame, job)?,
        Export::Figure(figure) => write_figure(path, figure, job)?,
        Export::View(key) => {
            let (said, used) = write_view(path, key, job)?;
            notice = used;
            said
        }
        Export::CopyFigure(figure) => {
            let (figure, options) = drawn(figure, job)?;
            return Ok(Message::FigureDrawn {
                image: figures::image(&figure)?,
                width_mm: Some(options.width_mm()),
            });
        }
        Export::CopyPicture(figure) => {
            let (figure, _) = drawn(figure, job)?;
            return Ok(Message::FigureDrawn { image: figures::picture(&figure), width_mm: None });
        }
        Export::Points { frame: Some(frame) } => {
            let points = write_points(path, &*at(source, *frame, job)?, *frame)?;
            count_of(points, "point")
        }
        Export::Points { frame: None } => write_all_points(path, source, job)?,
    };
    let damage = match source {
        FilmSource::Memory(_) => Vec::new(),
        FilmSource::Disk(playback) => playback.store().damage(),
    };
    Ok(Message::Exported { path: path.clone(), exported: Exported { said, notice, damage } })
}

/// The samples of a frame, perhaps with those of others.
fn at(source: &FilmSource, frame: usize, job: &Job) -> Result<Arc<SampleSet>> {
    match source {
        FilmSource::Memory(samples) => Ok(samples.clone()),
        FilmSource::Disk(playback) => playback.at(frame, job),
    }
}

/// Writes the page. That of samples in memory is the page of their store, byte for byte.
fn write_page(path: &Path, source: &FilmSource, options: &PageOptions, job: &Job) -> Result<String> {
    let written = match source {
        FilmSource::Disk(playback) => page::write(path, playback.store(), options, job)?,
        FilmSource::Memory(samples) => {
            let folder = temporary_folder()?;
            let store = folder.path().join("scene.ovl");
            job.start("Rounding samples", 0);
            write_with(&store, samples, &Extras::default(), job)?;
            page::write(path, &Store::open(&store)?, options, job)?
        }
    };
    let of = if written.samples < written.samples_of_store {
        format!(" in place of {}", count_of(written.samples_of_store, "sample"))
    } else {
        String::new()
    };
    Ok(format!("a page of {} with {}{of}", bytes(written.bytes), count_of(written.samples, "sample")))
}

/// A figure of a view, and its options.
fn drawn<'a>(figure: &'a FigureExport, job: &Job) -> Result<(Figure, &'a FigureOptions)> {
    job.start("Drawing the figure", 0);
    Ok(match figure {
        FigureExport::Live { key, options } => (figures::of_live_view(key, options, job)?, options),
        FigureExport::Source { scene, key, options } => {
            (figures::of_source_picture(scene.source()?, key, options)?, options)
        }
        FigureExport::Compared { compared, options } => (figures::of_comparison(compared, options), options),
    })
}

fn write_figure(path: &Path, figure: &FigureExport, job: &Job) -> Result<String> {
    let (figure, options) = drawn(figure, job)?;
    let written = figures::write(path, &figure)?;
    Ok(format!("a figure of {} mm, {}", significant(options.width_mm()), bytes(written)))
}

/// Writes what the live view shows, in the size of the key's viewpoint. Gives what was written, and why the renderer of the settings
/// was not used.
fn write_view(path: &Path, key: &LiveKey, job: &Job) -> Result<(String, Option<String>)> {
    job.start("Rendering the picture", 0);
    let painted = live_image::paint(&mut Renderer::new(), &mut CameraFilter::default(), key, job)?;
    let PixelSource::InMemory { image, rendered } = &painted.pixels else {
        return Err(Error::unsupported("picture", "it stays on the GPU; set render.backend to cpu"));
    };
    save_picture(path, image, rendered, &key.display)?;
    let [width, height] = painted.size;
    Ok((format!("a picture of {width}×{height}"), painted.notice))
}

/// A folder that goes when it is dropped.
///
/// # Errors
/// `Io`.
pub(crate) fn temporary_folder() -> Result<tempfile::TempDir> {
    tempfile::tempdir().map_err(|error| Error::io(std::env::temp_dir(), error))
}

fn write_splats(
    path: &Path,
    source: &FilmSource,
    options: &SplatOptions,
    frame: usize,
    job: &Job,
) -> Result<String> {
    let written = match source {
        _ if !options.format.holds_time() => {
            splats::write(path, &*at(source, frame, job)?, Some(frame), options, job)?
        }
        FilmSource::Memory(samples) => splats::write(path, samples, None, options, job)?,
        FilmSource::Disk(playback) => {
            splats::write(path, &playback.store().read_all(job)?, None, options, job)?
        }
    };
    let mut said = count_of(written.splats, "splat");
    if written.of_sky == 0 && written.at_infinity > 0 {
        said = format!("{said}, without {} of the sky", count_of(written.at_infinity, "sample"));
    }
    if let Some([x, y, z]) = written.offset {
        said = format!("{said}, less the offset ({x}, {y}, {z})");
    }
    Ok(said)
}

fn write_points(path: &Path, set: &SampleSet, frame: usize) -> Result<u64> {
    let images = set.images.iter().filter(|image| image.span.contains(frame));
    points::write(path, set, images.map(|image| &**image))
}

/// Writes a file for each frame, all of them or none.
fn write_all_points(path: &Path, source: &FilmSource, job: &Job) -> Result<String> {
    let frames = source.frame_count();
    job.start("Writing frames", frames);
    let points = whole_file::write_folder(path, |folder| {
        let mut points = 0;
        for frame in 0..frames {
            job.check()?;
            let set = at(source, frame, job)?;
            let number = set.frame_numbers.get(frame).copied().unwrap_or(frame as i64);
            points += write_points(&folder.join(format!("{number:04}.ply")), &set, frame)?;
            job.advance(1);
        }
        Ok(points)
    })?;
    Ok(format!("{}, {}", count_of(points, "point"), counted(frames, "file")))
}

/// Pictures a second of those in a folder, where that matters.
const PICTURES_A_SECOND: f64 = 24.0;

/// Renders all pictures of a camera path and writes them. Gives what was written, and why the renderer of the settings was not used.
fn write_path(
    path: &Path,
    source: &FilmSource,
    export: &PathExport,
    threads: &Arc<rayon::ThreadPool>,
    job: &Job,
) -> Result<(String, Option<String>)> {
    let PathExport { vantages, compared, .. } = export;
    let Some(first) = vantages.first() else { return Err(Error::invalid("camera path", NO_KEYS)) };
    let mut renderer = Renderer::new();
    let rate = export.target.film_rate.unwrap_or(PICTURES_A_SECOND);
    let (linear, look) = (export.target.linear, export.look.as_ref().filter(|_| compared.is_none()));
    let mut paint = |take: &mut dyn FnMut(usize, &Picture) -> Result<()>| match (compared, look) {
        (Some(compared), _) => compared_film::paint(compared, source, vantages, rate, threads, job, take),
        (None, Some(look)) => looked_film::paint(look, source, vantages, linear, &mut renderer, job, take),
        (None, None) => film::paint(source, vantages, None, &mut renderer, &export.settings, job, take),
    };
    // The sides of a comparison are as they are displayed, and so is what the live view shows.
    let is_plain = compared.is_none() && look.is_none();
    let developed = |picture: &Picture| is_plain.then(|| developed(&export.display, picture)).flatten();
    if export.target.film_rate.is_some() {
        let size = match compared {
            Some(compared) => compared_film::size(compared, first)?,
            None => export.size.map(|side| side as usize),
        };
        let mut encoder = FilmEncoder::start(path, size, rate)?;
        paint(&mut |_, picture| encoder.add(developed(picture).as_ref().unwrap_or(picture)))?;
        encoder.finish(job)?;
    } else {
        std::fs::create_dir_all(path).map_err(|error| Error::io(path, error))?;
        paint(&mut |nth, picture| {
            if linear {
                return write_exr(&path.join(format!("{:04}.exr", nth + 1)), picture);
            }
            let file = path.join(format!("{:04}.png", nth + 1));
            write_png(&file, developed(picture).as_ref().unwrap_or(picture))
        })?;
    }
    Ok((counted(vantages.len(), "picture"), renderer.notice().map(str::to_owned)))
}
