//! Opens captures and stores; reads and writes files, and asks where.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use egui::ColorImage;
use image::{ImageFormat, RgbaImage};

use crate::address;
use crate::app::model::look::Display;
use crate::app::model::purpose::{AskedPath, Purpose};
use crate::app::model::{Content, Message, OpenScene, SceneSource, median_depth};
use crate::app::rooms::compare::state::PictureFolder;
use crate::app::rooms::files::state::Session;
use crate::app::work::requests::OpenRequest;
use crate::ways_out::figure::FIGURE;
use overlook_engine::capture::transforms::{self, open_pictures, picture_name};
use overlook_engine::capture::{Capture, Source, TruthView};
use overlook_engine::demo::Demo;
use overlook_engine::error::{Error, Result};
use overlook_engine::job::Job;
use overlook_engine::render::Picture;
use overlook_engine::render::output::write_exr;
use overlook_engine::settings::CaptureSettings;
use overlook_engine::store::file::Store;
use overlook_engine::store::playback::Playback;
use overlook_engine::{store, whole_file};
use overlook_lab::chart::Chart;

/// The store that the window opens by itself: `assets/room/make.sh` made it.
static ROOM: &[u8] = include_bytes!("../../../../../assets/room/room.ovl");

/// Opens a built-in scene, a capture or a store.
pub(crate) fn open(request: OpenRequest, job: &Job) -> Result<Message> {
    let mut session = None;
    let opened = match request {
        OpenRequest::Demo { spec, settings } => {
            job.start(format!("Opening {}", spec.scene), 0);
            let demo = Demo::new(&spec)?;
            let capture = demo.capture(&settings);
            let truth = demo.truth_views();
            open_capture(SceneSource::Demo(spec.scene), capture, truth, job)
        }
        OpenRequest::Room => {
            let store = Store::over(Path::new("the built-in room"), Box::new(ROOM.to_vec()))?;
            let playback = Playback::new(store, store::playback::DEFAULT_CACHE_BYTES);
            OpenScene::of_store(SceneSource::Room, playback, job)
        }
        OpenRequest::Path { path, settings, keys } => {
            job.start(format!("Opening {}", path.display()), 0);
            if Session::is_session(&path) {
                let known = session.insert(Session::from_text(&whole_file::short_text(&path)?, &path)?);
                open_path(known.opens.clone(), &known.settings.capture, &[], job)
            } else {
                open_path(path, &settings, &keys, job)
            }
        }
    }?;
    // Who cancelled meanwhile, or opened something else, does not want it any more.
    job.check()?;
    Ok(Message::Opened { scene: Arc::new(opened), session: session.map(Box::new) })
}

fn open_path(
    path: PathBuf,
    settings: &CaptureSettings,
    keys: &[(String, String)],
    job: &Job,
) -> Result<OpenScene> {
    if Store::is_store(&path)? {
        let playback = Playback::new(Store::open(&path)?, store::playback::DEFAULT_CACHE_BYTES);
        return OpenScene::of_store(SceneSource::Path(path), playback, job);
    }
    let source = Source::find(&path)?;
    let manifest = source.manifest().map(PathBuf::from);
    let is_reread = !keys.is_empty();
    let source = if is_reread { source.read_as(keys)? } else { source };
    let up_is_estimated = source.description().up_is_estimated;
    let mut capture = source.open(settings)?;
    job.check()?;
    let mut truth = Vec::new();
    if is_reread {
        let keys: Vec<String> = keys.iter().map(|(key, value)| format!("\"{key}\": {value}")).collect();
        capture = capture.with_warning(format!(
            "it is open under another reading than that of its files; to keep this, write {} in the manifest",
            keys.join(", ")
        ));
    } else if let Some(views) = transforms::truth_beside(&path) {
        // Views beside a capture that is read otherwise are placed as the capture was: they would show something else.
        truth = transforms::open_views_of(&views, capture.frames_are_ranked())?;
    }
    let scene = open_capture(SceneSource::Path(path), capture, truth, job)?;
    Ok(OpenScene { up_is_estimated, manifest, is_reread, ..scene })
}

fn open_capture(
    origin: SceneSource,
    capture: Capture,
    truth: Vec<TruthView>,
    job: &Job,
) -> Result<OpenScene> {
    job.check()?;
    if capture.cameras.is_empty() || capture.frame_count() == 0 {
        return Err(Error::invalid(&capture.name, "there is no camera or no frame in it"));
    }
    let depth = median_depth(capture.frame(0, 0)?.inverse_depth.as_slice());
    Ok(OpenScene::of_capture(origin, capture, truth, depth))
}

/// Writes a picture as it is shown, with alpha 0 where `is_empty`, or as it was rendered, by the ending of its path.
pub(crate) fn save_picture(
    path: &Path,
    picture: &ColorImage,
    rendered: &Picture,
    display: &Display,
) -> Result<()> {
    if path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("exr")) {
        return write_exr(path, rendered);
    }
    let [width, height] = picture.size;
    let pixels = picture.pixels.iter().enumerate();
    let bytes = pixels.flat_map(|(index, pixel)| {
        let is_left_out = display.leaves_out(rendered, (index % width, index / width));
        if is_left_out { [0; 4] } else { [pixel.r(), pixel.g(), pixel.b(), u8::MAX] }
    });
    let png = RgbaImage::from_raw(width as u32, height as u32, bytes.collect());
    let png = png.filter(|_| width * height > 0);
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

/// Whether a path exists, so that writing would replace what is there.
pub(crate) fn check(purpose: Purpose, path: PathBuf) -> Message {
    let taken = if !purpose.writes() {
        address::of_path(&path).0.exists()
    } else if purpose.asked().endings.is_empty() {
        std::fs::read_dir(&path).is_ok_and(|mut entries| entries.next().is_some())
    } else {
        path.is_file()
    };
    Message::PathChecked { purpose, path, taken }
}

/// The path that is chosen in the system's dialog; `None` if the dialog is closed.
pub(crate) fn ask(purpose: Purpose, name: String) -> Option<PathBuf> {
    let AskedPath { title, endings, .. } = purpose.asked();
    let dialog = rfd::FileDialog::new().set_file_name(name).set_title(title);
    if endings.is_empty() {
        return dialog.pick_folder();
    }
    if purpose == Purpose::OpenFile {
        let dialog = dialog.add_filter("Stores, captures and sessions", endings);
        return dialog.add_filter("All files", &["*"]).pick_file();
    }
    let dialog = dialog.add_filter(endings.join(", ").to_uppercase(), endings);
    if purpose.writes() { dialog.save_file() } else { dialog.pick_file() }
}

static NEXT_ID: AtomicU64 = AtomicU64::new(1);

/// The pictures in a folder of viewpoints with true pictures, and of cameras that may be held out.
///
/// # Errors
/// `Invalid` where a store is open, or the folder has a picture of neither; those of reading its `transforms.json`.
pub(crate) fn open_rendered(folder: &Path, scene: &OpenScene) -> Result<PictureFolder> {
    let Content::Capture { capture, truth } = &scene.content else {
        return Err(Error::invalid(
            folder.display(),
            "a store has no viewpoints with true pictures to compare with; open the capture it was made from",
        ));
    };
    if !folder.is_dir() {
        return Err(Error::io(folder, std::io::ErrorKind::NotFound.into()));
    }
    let with_truth: Vec<TruthView> = truth.iter().filter(|view| view.truth.is_some()).cloned().collect();
    let of_camera = |camera| {
        let view =
            move |number: &i64| TruthView::new(picture_name(camera, *number), camera.clone(), *number, None);
        capture.frame_numbers.iter().map(view)
    };
    let of_cameras: Vec<TruthView> = capture.cameras.iter().flat_map(of_camera).collect();
    let find = |views: &[TruthView]| open_pictures(folder, views, capture.frames_are_ranked());
    let of_views = (!with_truth.is_empty()).then(|| find(&with_truth));
    let (of_views, of_cameras) = match (of_views, find(&of_cameras)) {
        (Some(Err(error)), Err(_)) | (None, Err(error)) => return Err(error),
        (of_views, of_cameras) => (of_views.and_then(Result::ok), of_cameras.ok()),
    };
    let [of_views, of_cameras] = [of_views, of_cameras].map(|pictures| pictures.map(Arc::new));
    let id = NEXT_ID.fetch_add(1, Ordering::Relaxed);
    Ok(PictureFolder { id, of_views, of_cameras, frame_count: capture.frame_count() })
}

/// A chart as an image.
pub(crate) fn chart_image(chart: &Chart) -> Result<ColorImage> {
    let pixels = image::load_from_memory(&chart.png()?)
        .map_err(|error| Error::invalid("figure", error.to_string()))?;
    Ok(color_image(&pixels.into_rgba8()))
}

pub(crate) fn color_image(pixels: &RgbaImage) -> ColorImage {
    let size = [pixels.width(), pixels.height()].map(|side| side as usize);
    ColorImage::from_rgba_unmultiplied(size, pixels)
}

/// A chart in the format that the ending of its path names; `Invalid` for another ending.
pub(crate) fn chart_bytes(path: &Path, chart: &Chart) -> Result<Vec<u8>> {
    let is = |known: &str| path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case(known));
    match FIGURE.endings.iter().position(|known| is(known)) {
        Some(0) => chart.pdf(),
        Some(1) => Ok(chart.svg().into_bytes()),
        Some(_) => chart.png(),
        None => {
            Err(Error::invalid(path.display(), "a figure is PDF, SVG or PNG; name it .pdf, .svg or .png"))
        }
    }
}
