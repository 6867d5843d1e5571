//! The work itself: one lane per kind, all of it calls into the engine.

use std::path::PathBuf;
use std::sync::Arc;

use super::live_image::{self, LiveKey};
use super::source_image::{self, SourceKey};
use super::thread_priority;
use super::worker::{Lane, Outbox, Supersede};
use crate::app::control::{Destination, write_picture};
use crate::app::model::{Inspected, InspectorLanes, Message, OpenScene, Origin, Purpose, median_depth};
use crate::capture::{Capture, TruthView, transforms};
use crate::demo::{Demo, DemoSpec};
use crate::error::{Error, Result};
use crate::job::Job;
use crate::preprocess::diagnostics::Report;
use crate::preprocess::{self, PreparedScan};
use crate::render::Renderer;
use crate::render::gpu::SharedDevice;
use crate::samples::SampleSet;
use crate::settings::{CaptureSettings, Settings};
use crate::store::file::{Extras, Provenance};
use crate::store::playback::Playback;
use crate::{store, whole_file};

/// What to open.
#[derive(Clone, Debug)]
pub(crate) enum OpenRequest {
    /// A built-in scene.
    Demo { spec: DemoSpec, settings: CaptureSettings },
    /// A file or folder.
    Path { path: PathBuf, settings: CaptureSettings },
}

/// Prune the whole capture.
pub(crate) struct WholeRequest {
    /// The scene, a capture.
    pub scene: Arc<OpenScene>,
    /// The pass over all frames, where it is done.
    pub scan: Option<Arc<PreparedScan>>,
    /// With which settings.
    pub settings: Settings,
}

/// Prune one frame, with reasons; or make it ready for that to be repeated.
pub(crate) struct InspectRequest {
    /// The scene, a capture.
    pub scene: Arc<OpenScene>,
    /// The pass over all frames, where it is done.
    pub scan: Option<Arc<PreparedScan>>,
    /// With which settings.
    pub settings: Settings,
    /// Which frame.
    pub frame: usize,
}

/// Compare with the truth.
pub(crate) struct MeasureRequest {
    /// The scene, a capture.
    pub scene: Arc<OpenScene>,
    /// What was kept.
    pub samples: Arc<SampleSet>,
    /// With which settings.
    pub settings: Settings,
}

/// Read or write a file.
pub(crate) enum FileRequest {
    /// Write what was pruned of a scene as a store.
    SaveStore { path: PathBuf, scene: Arc<OpenScene>, samples: Arc<SampleSet>, report: Arc<Report> },
    /// The open store again, under another name.
    SaveAgain { path: PathBuf, playback: Arc<Playback> },
    /// Write settings.
    SaveSettings { path: PathBuf, settings: Settings },
    /// Write a picture.
    SavePicture { path: PathBuf, picture: Arc<egui::ColorImage> },
    /// Read settings.
    LoadSettings { path: PathBuf },
}

impl FileRequest {
    /// What there is to say once it was stopped: title and text.
    fn stopped(&self) -> (&'static str, String) {
        match self {
            Self::SaveStore { path, .. }
            | Self::SaveAgain { path, .. }
            | Self::SaveSettings { path, .. }
            | Self::SavePicture { path, .. } => {
                ("Saving stopped", format!("Nothing was written to {}.", path.display()))
            }
            Self::LoadSettings { path } => {
                ("Loading stopped", format!("Nothing was read from {}.", path.display()))
            }
        }
    }
}

/// Every kind of work the window hands out.
pub(crate) struct Workers {
    /// Opening.
    pub open: Lane<OpenRequest>,
    /// The whole capture: scan, then prune.
    pub whole: Lane<WholeRequest>,
    /// One frame.
    pub inspect: Lane<InspectRequest>,
    /// The same frame, before a threshold is turned.
    pub prepare: Lane<InspectRequest>,
    /// The left picture.
    pub source: Lane<(Arc<OpenScene>, SourceKey)>,
    /// The right picture.
    pub live: Lane<LiveKey>,
    /// Accuracy.
    pub measure: Lane<MeasureRequest>,
    /// Files.
    pub file: Lane<FileRequest>,
    /// The system's dialogs, and the name that they suggest.
    pub dialog: Lane<(Purpose, String)>,
    /// What stands where something is to be written.
    pub look: Lane<Destination>,
    /// What the inspector asks.
    pub inspector: InspectorLanes,
}

impl Workers {
    /// Starts all lanes; on the `shared` device of a window the GPU paints the live view.
    ///
    /// # Errors
    /// `Io` where the operating system gives no thread.
    pub(crate) fn start(outbox: &Outbox, shared: Option<SharedDevice>) -> Result<Self> {
        let background = pool("prune", rayon::current_num_threads(), true)?;
        // A frame that this lane decodes may be awaited by every thread of the shared pool; its own thread finishes it.
        let decoder = pool("decode", 1, false)?;
        let (measuring, preparing) = (background.clone(), background.clone());
        let progress = outbox.clone();
        let mut renderer = Renderer::sharing(shared);
        Ok(Self {
            open: Lane::start("Open", Supersede::Always, outbox.clone(), open)?,
            whole: Lane::start("Prune", Supersede::Always, outbox.clone(), move |request, job| {
                background.install(|| prune_whole(request, &progress, job))
            })?,
            inspect: Lane::start("Inspect frame", Supersede::Alternate, outbox.clone(), inspect)?,
            // A frame made ready for settings just left still serves most of what comes after.
            prepare: Lane::start("Prepare frame", Supersede::Never, outbox.clone(), move |request, job| {
                preparing.install(|| prepare(&request, job))
            })?,
            source: Lane::start("Source picture", Supersede::Never, outbox.clone(), move |request, _| {
                paint_source(request, &decoder)
            })?,
            live: Lane::start("Live view", Supersede::Never, outbox.clone(), move |key: LiveKey, job| {
                let picture = live_image::paint(&mut renderer, &key, job)?;
                Ok(Message::LivePainted { key, picture: Arc::new(picture) })
            })?,
            measure: Lane::start(
                "Measure accuracy",
                Supersede::Always,
                outbox.clone(),
                move |request, job| measuring.install(|| measure(&request, job)),
            )?,
            file: Lane::start("File", Supersede::Queue, outbox.clone(), |request: FileRequest, job| {
                let (title, text) = request.stopped();
                or_stopped(job, title, text, || file(request, job))
            })?,
            dialog: Lane::start("Dialog", Supersede::Never, outbox.clone(), |(purpose, name), _| {
                Ok(Message::PathChosen { purpose, path: ask(purpose, name) })
            })?,
            look: Lane::start("Look", Supersede::Never, outbox.clone(), |destination: Destination, _| {
                Ok(destination.look())
            })?,
            inspector: InspectorLanes::start(outbox)?,
        })
    }

    /// Whether nothing runs or waits.
    pub(crate) fn are_idle(&self) -> bool {
        self.open.is_idle()
            && self.whole.is_idle()
            && self.inspect.is_idle()
            && self.prepare.is_idle()
            && self.source.is_idle()
            && self.live.is_idle()
            && self.measure.is_idle()
            && self.file.is_idle()
            && self.look.is_idle()
            && self.inspector.are_idle()
    }
}

/// Does work whose end is waited for: where it is stopped, says so.
pub(crate) fn or_stopped(
    job: &Job,
    title: &'static str,
    text: String,
    work: impl FnOnce() -> Result<Message>,
) -> Result<Message> {
    match job.check().and_then(|()| work()) {
        Err(_) if job.is_cancelled() => Ok(Message::Stopped { title, text }),
        outcome => outcome,
    }
}

/// Threads of their own: in the pool that the views share, a picture would wait behind minutes of pruning. Where they make
/// way, the window and its pictures also come before them.
pub(crate) fn pool(name: &'static str, threads: usize, makes_way: bool) -> Result<Arc<rayon::ThreadPool>> {
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .thread_name(move |index| format!("{name} {index}"))
        .start_handler(move |_| {
            if makes_way {
                thread_priority::make_way();
            }
        })
        .build()
        .map(Arc::new)
        .map_err(|error| Error::invalid("thread pool", error.to_string()))
}

fn open(request: OpenRequest, job: &Job) -> Result<Message> {
    let opened = match request {
        OpenRequest::Demo { spec, settings } => {
            job.start(format!("Opening {}", spec.scene), 0);
            let demo = Demo::new(&spec)?;
            let capture = demo.capture(&settings);
            let truth = demo.truth_views();
            open_capture(Origin::Demo(spec.scene), capture, truth, job)
        }
        OpenRequest::Path { path, settings } => {
            job.start(format!("Opening {}", path.display()), 0);
            open_path(path, &settings, job)
        }
    }?;
    // Who cancelled meanwhile, or opened something else, does not want it any more.
    job.check()?;
    Ok(opened)
}

fn open_path(path: PathBuf, settings: &CaptureSettings, job: &Job) -> Result<Message> {
    if store::file::Store::is_store(&path)? {
        let playback = Playback::new(store::file::Store::open(&path)?, store::playback::DEFAULT_CACHE_BYTES);
        return Ok(Message::Opened(Arc::new(OpenScene::of_store(path, playback, job)?)));
    }
    let named_json = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("json"));
    if path.is_file() && !named_json {
        let what = "is neither a store nor a transforms.json; open one of those, or the folder of a capture";
        return Err(Error::unsupported(path.display(), what));
    }
    let capture = transforms::open(&path, settings)?;
    job.check()?;
    let truth = transforms::truth_beside(&path).map_or_else(
        || Ok(Vec::new()),
        |views| transforms::open_views_of(&views, capture.frames_are_ranked()),
    )?;
    open_capture(Origin::Path(path), capture, truth, job)
}

fn open_capture(origin: Origin, capture: Capture, truth: Vec<TruthView>, job: &Job) -> Result<Message> {
    job.check()?;
    if capture.cameras.is_empty() || capture.frame_count() == 0 {
        return Err(Error::invalid(&capture.name, "there is no camera or no frame in it"));
    }
    let depth = median_depth(capture.frame(0, 0)?.inverse_depth.as_slice());
    Ok(Message::Opened(Arc::new(OpenScene::of_capture(origin, capture, truth, depth))))
}

fn capture_of(scene: &OpenScene) -> Result<&Capture> {
    scene.capture().ok_or_else(|| Error::invalid(&scene.name, "a store holds no source frames"))
}

fn prune_whole(request: WholeRequest, outbox: &Outbox, job: &Job) -> Result<Message> {
    let WholeRequest { scene, scan, settings } = request;
    let capture = capture_of(&scene)?;
    let scan = if let Some(scan) = scan.filter(|scan| scan.serves(&settings.spans)) {
        scan
    } else {
        let scan = preprocess::scan(capture, &settings, job)?;
        outbox.send(Message::Scanned { scene: scene.id, scan: scan.clone() });
        scan
    };
    let result = preprocess::prune(capture, &scan, &settings, job)?;
    Ok(Message::Pruned { scene: scene.id, settings, result: Arc::new(result) })
}

fn inspect(request: InspectRequest, job: &Job) -> Result<Message> {
    let InspectRequest { scene, scan, settings, frame } = request;
    let inspection = preprocess::inspect_frame(capture_of(&scene)?, scan.as_deref(), &settings, frame, job)?;
    let mut kept = vec![0; inspection.cameras.len()];
    for image in &inspection.samples.images {
        kept[image.camera as usize] += image.len() as u64;
    }
    let inspected = Inspected { inspection: Arc::new(inspection), settings, with_scan: scan.is_some(), kept };
    Ok(Message::Inspected { scene: scene.id, inspected })
}

fn prepare(request: &InspectRequest, job: &Job) -> Result<Message> {
    if let (capture, Some(scan)) = (capture_of(&request.scene)?, &request.scan) {
        preprocess::prepare_frame(capture, scan, &request.settings, request.frame, job)?;
    }
    Ok(Message::Prepared)
}

fn paint_source((scene, key): (Arc<OpenScene>, SourceKey), decoder: &rayon::ThreadPool) -> Result<Message> {
    let frame = if let Some(inspection) = &key.inspection {
        inspection.cameras[key.camera].frame.clone()
    } else {
        let capture = capture_of(&scene)?;
        decoder.install(|| capture.frame(key.camera, key.frame))?
    };
    let picture = source_image::paint(&key, &frame);
    Ok(Message::SourcePainted { key, picture: Arc::new(picture) })
}

fn measure(request: &MeasureRequest, job: &Job) -> Result<Message> {
    let accuracy = super::accuracy::measure(request, job)?;
    Ok(Message::Measured { scene: request.scene.id, settings: request.settings.clone(), accuracy })
}

fn file(request: FileRequest, job: &Job) -> Result<Message> {
    match request {
        FileRequest::SaveStore { path, scene, samples, report } => {
            job.start(format!("Saving {}", path.display()), 0);
            let frames_are_ranked = scene.capture().is_some_and(Capture::frames_are_ranked);
            let provenance = Provenance { frames_are_ranked, ..Provenance::default() };
            let extras = Extras { report: report.to_json()?, provenance, ..Extras::default() };
            let bytes = store::file::write_with(&path, &samples, &extras, job)?;
            let holds = Some((scene.id, samples.settings.clone()));
            Ok(Message::Saved { path, bytes: Some(bytes), holds })
        }
        FileRequest::SaveAgain { path, playback } => {
            let bytes = store::write_again(&path, playback.store(), None, job)?;
            Ok(Message::Saved { path, bytes: Some(bytes), holds: None })
        }
        FileRequest::SaveSettings { path, settings } => {
            whole_file::write_all(&path, settings.to_toml())?;
            Ok(Message::Saved { path, bytes: None, holds: None })
        }
        FileRequest::SavePicture { path, picture } => {
            write_picture(&path, &picture)?;
            Ok(Message::Saved { path, bytes: None, holds: None })
        }
        FileRequest::LoadSettings { path } => {
            let settings = Settings::load(&path)?;
            Ok(Message::SettingsLoaded { path, settings })
        }
    }
}

fn ask(purpose: Purpose, name: String) -> Option<PathBuf> {
    let dialog = rfd::FileDialog::new().set_file_name(name);
    match purpose {
        Purpose::OpenFile => dialog
            .set_title("Open a store or a transforms.json")
            .add_filter("Stores and captures", &["ovl", "json"])
            .add_filter("All files", &["*"])
            .pick_file(),
        Purpose::OpenFolder => dialog.set_title("Open a capture folder").pick_folder(),
        Purpose::SaveStore => dialog.set_title("Save the store").add_filter("Store", &["ovl"]).save_file(),
        Purpose::SaveSettings => {
            dialog.set_title("Save the settings").add_filter("Settings", &["toml"]).save_file()
        }
        Purpose::SavePicture => dialog.set_title("Save the picture").add_filter("PNG", &["png"]).save_file(),
        Purpose::ExportPictures => dialog.set_title("Export pictures into a folder").pick_folder(),
        Purpose::ExportFilm => {
            dialog.set_title("Export a film").add_filter("Film", &["mp4", "mkv", "mov"]).save_file()
        }
        Purpose::LoadSettings => {
            dialog.set_title("Load settings").add_filter("Settings", &["toml"]).pick_file()
        }
    }
}
