//! Writes pictures of the live view, and the pictures or the film of a camera path.

mod figure_meaning;
pub(crate) mod pictures;

use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::sync::mpsc::{RecvTimeoutError, sync_channel};
use std::time::Duration;

use egui::ColorImage;
use half::f16;

use crate::app::colormap::recorded;
use crate::app::model::look::Display;
use crate::app::model::picture::{LiveKey, LivePicture, PixelSource};
use crate::app::model::{Content, Message, OpenScene, Same, State};
use crate::app::rooms::files::work::save_picture;
use crate::app::rooms::live::work::image as live_image;
use crate::app::rooms::path::NO_KEYS;
use crate::app::rooms::share::PathExport;
use crate::app::rooms::share::state::{ShareKey, SharePreviewKey};
use crate::app::work::develop::developed;
use crate::app::work::shown_samples::CameraFilter;
use crate::app::work::worker::Wanted;
use crate::ways_out::page::{EMPTY_PAGE, PAGE_BY_STORE};
use crate::ways_out::{Facts, PictureFacts, Way, temporary_folder};
use overlook_engine::color::srgb_from_linear;
use overlook_engine::error::{Error, Result};
use overlook_engine::job::Job;
use overlook_engine::page::coarsened;
use overlook_engine::plural::counted;
use overlook_engine::render::film::{self, FilmEncoder, FilmPicture, FilmSource};
use overlook_engine::render::output::{write_exr, write_png};
use overlook_engine::render::{CpuRenderer, Picture, Renderer, Vantage};
use overlook_engine::samples::SampleSet;
use overlook_engine::store::file::{Extras, write_with};
use overlook_engine::store::playback::Playback;
use overlook_engine::whole_file;
use overlook_lab::chart::Caption;
use overlook_lab::metrics::psnr_db;

/// Writes what the live view shows, in the size of the key's viewpoint. Gives what was written, and why the renderer of the settings
/// was not used.
pub(crate) fn write_view(path: &Path, key: &LiveKey, job: &Job) -> Result<(String, Option<String>)> {
    job.start("Rendering the picture", 0);
    let painted = live_image::paint(&mut Renderer::new(), &mut CameraFilter::default(), key, job)?;
    let PixelSource::InMemory { image, rendered } = &painted.pixels else {
        return Err(Error::unsupported("picture", "it stays on the GPU; set render.backend to cpu"));
    };
    save_picture(path, image, rendered, &key.display)?;
    let [width, height] = painted.size;
    Ok((format!("a picture of {width}×{height}"), painted.notice))
}

/// Pictures a second of those in a folder, where that matters.
const PICTURES_A_SECOND: f64 = 24.0;

/// Renders all pictures of a camera path and writes them. Gives what was written, and why the renderer of the settings was not used.
pub(crate) fn write_path(
    path: &Path,
    source: &FilmSource,
    export: &PathExport,
    threads: &Arc<rayon::ThreadPool>,
    job: &Job,
) -> Result<(String, Option<String>)> {
    let PathExport { vantages, compared, .. } = export;
    let Some(first) = vantages.first() else { return Err(Error::invalid("camera path", NO_KEYS)) };
    let mut renderer = Renderer::new();
    let rate = export.film_rate.unwrap_or(PICTURES_A_SECOND);
    let (linear, look) = (export.linear, export.look.as_ref().filter(|_| compared.is_none()));
    let mut paint = |take: &mut dyn FnMut(usize, &Picture) -> Result<()>| match (compared, look) {
        (Some(compared), _) => pictures::paint(compared, source, vantages, rate, threads, job, take),
        (None, Some(look)) => {
            pictures::paint_looked(look, source, vantages, linear, &mut renderer, job, take)
        }
        (None, None) => {
            let take = |nth: usize, shown: &FilmPicture| take(nth, &shown.picture);
            film::paint(source, vantages, None, &mut renderer, &export.settings, job, take)
        }
    };
    // The sides of a comparison are as they are displayed, and so is what the live view shows.
    let is_plain = compared.is_none() && look.is_none();
    let developed = |picture: &Picture| is_plain.then(|| developed(&export.display, picture)).flatten();
    if export.film_rate.is_some() {
        let [columns, rows] = match compared {
            Some(compared) => pictures::size(compared, first)?,
            None => export.size.map(|side| side as usize),
        };
        let caption = Caption::new(&export.caption, columns)?;
        let mut encoder = FilmEncoder::start(path, [columns, rows + caption.rows()], rate)?;
        paint(&mut |_, picture| {
            let developed = developed(picture);
            encoder.add(&caption.below(developed.as_ref().unwrap_or(picture)))
        })?;
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

/// Samples that are written to measure how large a store is: those of as many cameras as it takes to have so many.
const MEASURED_SAMPLES: u64 = 1_000_000;

impl Wanted for ShareKey {
    /// What sizes follow from, while the dialog that shows them is open.
    fn wanted(state: &State) -> Option<Self> {
        let samples = state.samples_here().filter(|_| state.share.is_open)?;
        let shown = state.doc.live_shown.as_ref().filter(|shown| shown.key.quality.is_none());
        Some(Self {
            scene: state.doc.scene.clone()?,
            // Until the whole capture is pruned only pictures have a size.
            samples: Same(state.edited_samples().or(state.whole_samples()).unwrap_or(samples).clone()),
            frame: state.timeline.frame,
            picture: shown.map(|shown| Same(shown.picture.clone())),
        })
    }
}

/// What was measured of samples that are in memory.
#[derive(Default)]
pub(crate) struct StoreMeter {
    known: Option<(Arc<SampleSet>, f64)>,
}

impl StoreMeter {
    /// Counts and measures.
    pub(crate) fn facts(&mut self, key: &ShareKey, job: &Job) -> Result<Message> {
        let here = samples_of_frame(&key.scene, &key.samples, key.frame, job)?;
        let (samples, store_bytes) = match stored(&key.scene, &key.samples) {
            Some((playback, bytes)) => (playback.store().info().sample_count(), bytes as f64),
            None => (here.sample_count(), self.store_bytes(&here, job)?),
        };
        let of_frame = || here.images_at(key.frame);
        let placed_here: u64 = of_frame().map(|image| image.placed_count()).sum();
        let all_here: u64 = of_frame().map(|image| image.len() as u64).sum();
        let picture = key.picture.as_deref().map(|picture| picture_facts(picture)).transpose()?.flatten();
        let facts =
            Facts { samples, placed_here, at_infinity_here: all_here - placed_here, store_bytes, picture };
        Ok(Message::SizesMeasured { scene: key.scene.id, facts })
    }

    /// Bytes of the store of a set.
    fn store_bytes(&mut self, samples: &Arc<SampleSet>, job: &Job) -> Result<f64> {
        if let Some((_, bytes)) = self.known.as_ref().filter(|(known, _)| Arc::ptr_eq(known, samples)) {
            return Ok(*bytes);
        }
        let some = of_first_cameras(samples);
        let folder = temporary_folder()?;
        let written = write_with(&folder.path().join("part.ovl"), &some, &Extras::default(), job)?;
        let bytes = written as f64 * samples.sample_count() as f64 / some.sample_count().max(1) as f64;
        self.known = Some((samples.clone(), bytes));
        Ok(bytes)
    }
}

/// The store that is open, and its bytes, where samples are its outline; `None` of a capture, and where they are what edits left.
fn stored<'a>(scene: &'a OpenScene, of: &Arc<SampleSet>) -> Option<(&'a Arc<Playback>, u64)> {
    match &scene.content {
        Content::Store { playback, samples, bytes, .. } if Arc::ptr_eq(samples, of) => {
            Some((playback, *bytes))
        }
        _ => None,
    }
}

/// A set that has the samples of a frame in memory; `samples` are the outline of a store, or in memory already.
fn samples_of_frame(
    scene: &OpenScene,
    samples: &Arc<SampleSet>,
    frame: usize,
    job: &Job,
) -> Result<Arc<SampleSet>> {
    stored(scene, samples).map_or_else(|| Ok(samples.clone()), |(playback, _)| playback.at(frame, job))
}

/// The samples of as many of the first cameras as have [`MEASURED_SAMPLES`]: images of one camera are predicted from each other.
fn of_first_cameras(samples: &SampleSet) -> SampleSet {
    let mut some = samples.clone();
    let mut wanted = 0;
    let mut count = 0;
    while count < MEASURED_SAMPLES && wanted < samples.cameras.len() as u32 {
        let of_next = samples.images.iter().filter(|image| image.camera == wanted);
        count += of_next.map(|image| image.len() as u64).sum::<u64>();
        wanted += 1;
    }
    some.images.retain(|image| image.camera < wanted);
    some
}

/// What a picture takes in both formats; `None` while its pixels are out of reach.
fn picture_facts(picture: &LivePicture) -> Result<Option<PictureFacts>> {
    let PixelSource::InMemory { image, rendered } = &picture.pixels else { return Ok(None) };
    let folder = temporary_folder()?;
    let written = |name: &str| -> Result<f64> {
        let path = folder.path().join(name);
        save_picture(&path, image, rendered, &Display::default())?;
        let length = std::fs::metadata(&path).map_err(|error| Error::io(&path, error))?.len();
        Ok(length as f64)
    };
    let pixels = (image.width() * image.height()) as f64;
    Ok(Some(PictureFacts { pixels, png_bytes: written("picture.png")?, exr_bytes: written("picture.exr")? }))
}

/// How long a program that opens folders is waited for: one that still runs has opened it.
const OPENED_BY: Duration = Duration::from_secs(4);

/// Opens the folder of a file in the system's file manager.
///
/// # Errors
/// `Unsupported` where there is none, with the folder.
pub(crate) fn show_in_folder(path: &Path) -> Result<Message> {
    let folder = whole_file::folder_of(path);
    let program = if cfg!(target_os = "macos") {
        "open"
    } else if cfg!(windows) {
        "explorer"
    } else {
        "xdg-open"
    };
    let none =
        || Error::unsupported(folder.display(), "this system has no file manager to open the folder with");
    let mut command = Command::new(program);
    command.arg(folder).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    let mut opener = command.spawn().map_err(|_| none())?;
    // Where the file manager itself was started it runs until it is closed; its end is taken note of.
    let (sender, ended) = sync_channel(1);
    let waiter = std::thread::Builder::new().name("file manager".to_owned());
    waiter.spawn(move || sender.send(opener.wait())).map_err(|error| Error::io(folder, error))?;
    match ended.recv_timeout(OPENED_BY) {
        // Windows' explorer gives no meaning to its exit status.
        Ok(Ok(status)) if status.success() || cfg!(windows) => Ok(Message::FolderShown),
        Err(RecvTimeoutError::Timeout) => Ok(Message::FolderShown),
        _ => Err(none()),
    }
}

/// Columns of a preview, pixels.
const PREVIEW_COLUMNS: u32 = 320;

impl Wanted for SharePreviewKey {
    /// The preview that the dialog shows of the chosen way, where a budget makes it coarser.
    fn wanted(state: &State) -> Option<Self> {
        let (facts, options) = (state.share.facts.as_ref()?, &state.share.options);
        let share = match options.way {
            Way::Page => {
                let most = options.page_at_most()? as f64 - EMPTY_PAGE;
                most / (facts.store_bytes * PAGE_BY_STORE).max(1.0)
            }
            Way::Splats => {
                let most = options.splats_at_most()? as f64;
                let all = if options.format.holds_time() { facts.samples } else { facts.placed_here };
                most / all.max(1) as f64
            }
            _ => return None,
        };
        let [width, height] = state.live.size;
        let rows = (PREVIEW_COLUMNS * height / width.max(1)).max(1);
        let camera = state.live_camera([PREVIEW_COLUMNS, rows])?;
        let ready = state.is_whole_ready() && state.share.is_open && share < 1.0;
        let samples = state.edited_samples().or(state.whole_samples()).filter(|_| ready)?;
        Some(Self {
            scene: state.doc.scene.clone()?,
            samples: Same(samples.clone()),
            vantage: Vantage { camera, frame: state.timeline.frame },
            settings: state.settings.render.clone(),
            share: share.max(0.0),
        })
    }
}

/// Paints the view of all samples and of those within the budget.
pub(crate) fn preview(key: SharePreviewKey, job: &Job) -> Result<Message> {
    let here = samples_of_frame(&key.scene, &key.samples, key.vantage.frame, job)?;
    let images = here.images_at(key.vantage.frame).cloned().collect();
    let all = SampleSet { images, ..(*here).clone() };
    let most = (key.share * all.sample_count() as f64) as u64;
    let Some(some) = coarsened(&all, most, job)? else {
        return Ok(Message::SharePreviewed { preview: None, key });
    };
    let settings = &key.settings;
    let painted = |set: SampleSet, vantage: &Vantage| -> Result<Arc<Picture>> {
        Ok(CpuRenderer::new().render(&Arc::new(set), vantage, settings, job)?.0)
    };
    let [whole, within] = [painted(all, &key.vantage)?, painted(some, &key.vantage)?];
    let shown = |picture: &Picture| {
        picture.color.as_slice().iter().map(|color| color.map(srgb_from_linear)).collect::<Vec<_>>()
    };
    let decibels = psnr_db(&shown(&whole), &shown(&within), 0..whole.color.as_slice().len());
    let (width, height) = within.color.size();
    let pixels = within.color.as_slice().iter().map(|color| recorded(color.map(f16::from_f32))).collect();
    let image = Arc::new(ColorImage::new([width, height], pixels));
    Ok(Message::SharePreviewed { preview: Some((image, decibels)), key })
}
