//! Every kind of work that the window hands out, each on a worker of its own.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use super::worker::Supersede::{Alternate, Always, Never, Queue};
use crate::app::model::picture::{CarryKey, LiveKey};
use crate::app::model::purpose::Purpose;
use crate::app::model::{Message, State, WorkKind as Kind};
use crate::app::rooms::change::state::ChangeRequest;
use crate::app::rooms::change::work as change;
use crate::app::rooms::charts;
use crate::app::rooms::charts::work::{MeasureRequest, measure};
use crate::app::rooms::colors::work::{ValuesRequest, values};
use crate::app::rooms::compare::state::CompareKey;
use crate::app::rooms::compare::work::Comparer;
use crate::app::rooms::edits::state::EditKey;
use crate::app::rooms::edits::work::SampleEditor;
use crate::app::rooms::files::work as files;
use crate::app::rooms::live::work::image as live_image;
use crate::app::rooms::pixel::state::ProbeKey;
use crate::app::rooms::pixel::work as facts;
use crate::app::rooms::pixel::work::{MemoryRequest, ThumbnailRequest};
use crate::app::rooms::readings::work as readings;
use crate::app::rooms::readings::work::ReadingRequest;
use crate::app::rooms::report::work as pruning;
use crate::app::rooms::report::work::{InspectRequest, PrepareRequest, WholeRequest};
use crate::app::rooms::settings::work as histograms;
use crate::app::rooms::settings::work::HistogramRequest;
use crate::app::rooms::share::state::{ShareKey, SharePreviewKey};
use crate::app::rooms::share::work::{self, StoreMeter};
use crate::app::rooms::source::work::{SourceRequest, paint_source};
use crate::app::work::requests::{FileWork, OpenRequest, StudyRequest};
use crate::app::work::shown_samples::CameraFilter;
use crate::app::work::worker::{AnySlot, Outbox, Slot, Worker};
use overlook_engine::error::{Error, Result};
use overlook_engine::job::{Job, Progress};
use overlook_engine::render::gpu::SharedDevice;
use overlook_engine::render::{PictureCarrier, Renderer};

/// The workers.
pub(crate) struct Workers {
    pub open: Worker<OpenRequest>,
    /// The whole capture: scan, then prune.
    pub whole: Slot<WholeRequest>,
    pub inspect: Slot<InspectRequest>,
    /// Candidate lists of that frame, before a threshold is turned.
    pub prepare: Slot<PrepareRequest>,
    pub source: Slot<SourceRequest>,
    pub live: Slot<LiveKey>,
    /// The last live picture, as the view shows it now.
    pub carry: Slot<CarryKey>,
    pub measure: Slot<MeasureRequest>,
    pub file: Worker<FileWork>,
    /// The system's dialogs, and the name that they suggest.
    pub dialog: Worker<(Purpose, String)>,
    /// Whether a destination exists already.
    pub check: Worker<(Purpose, PathBuf)>,
    pub probe: Slot<ProbeKey>,
    pub thumbs: Slot<ThumbnailRequest>,
    pub memory: Slot<MemoryRequest>,
    pub histograms: Slot<HistogramRequest>,
    pub values: Slot<ValuesRequest>,
    /// The samples that a change of settings drops or brings back.
    pub change: Slot<ChangeRequest>,
    pub compare: Slot<Box<CompareKey>>,
    pub export: Worker<FileWork>,
    /// The threads on which filmed comparisons read whole captures.
    pub filming: Arc<rayon::ThreadPool>,
    /// What the sizes of what is shared follow from.
    pub sizes: Slot<ShareKey>,
    /// What is shared within a budget, as a picture.
    pub preview: Slot<SharePreviewKey>,
    pub show_in_folder: Worker<PathBuf>,
    pub study: Worker<StudyRequest>,
    /// What edits leave of the samples.
    pub edits: Slot<EditKey>,
    /// How the capture is read, and how it would fit better.
    pub readings: Slot<ReadingRequest>,
}

/// The threads that workers share: for background work, decoding, studies, painting and carrying.
fn pools() -> Result<[Arc<rayon::ThreadPool>; 5]> {
    let threads = rayon::current_num_threads();
    Ok([
        pool("prune", threads, WORK)?,
        // A frame that this worker decodes may be awaited by every thread of the shared pool; its own thread finishes it.
        pool("decode", 1, WINDOW)?,
        pool("study", threads, WORK)?,
        // Neither decoding nor inspecting holds up a picture, and a picture does not hold up the window.
        pool("render", threads, PICTURES)?,
        // What follows the hand goes before everything else.
        pool("carry", threads.min(CARRIERS), WINDOW)?,
    ])
}

/// The thumbnails of what was inspected of a scene.
fn thumbnails(request: &ThumbnailRequest) -> Message {
    Message::Thumbnails { scene: request.scene, pictures: facts::thumbnails(&request.inspection) }
}

/// What the samples of a scene take, by camera.
fn memory(request: &MemoryRequest) -> Message {
    Message::MemoryMapped { scene: request.scene, cameras: facts::memory(&request.samples) }
}

impl Workers {
    /// Starts all workers; on the `shared` device of a window the GPU paints the live view.
    pub(crate) fn start(outbox: &Outbox, shared: Option<SharedDevice>) -> Result<Self> {
        let [background, decoder, studying, rendering, carrying] = pools()?;
        let mut carrier = PictureCarrier::default();
        let (measuring, preparing) = (background.clone(), background.clone());
        let (comparing, previewing, filming) = (studying.clone(), studying.clone(), studying.clone());
        let (progress, points) = (outbox.clone(), outbox.clone());
        let mut renderer = Renderer::sharing(shared);
        let mut filter = CameraFilter::default();
        let mut editor = SampleEditor::default();
        let editing = rendering.clone();
        let mut comparer = Comparer::new(studying.clone());
        let mut meter = StoreMeter::default();
        let preview = move |key, job: &Job| previewing.install(|| work::preview(key, job));
        Ok(Self {
            open: Worker::start(Kind::Open, Always, outbox, files::open)?,
            whole: Slot::start(Kind::Prune, Always, outbox, move |request, job| {
                background.install(|| pruning::prune_whole(request, &progress, job))
            })?,
            inspect: Slot::start(Kind::InspectFrame, Alternate, outbox, pruning::inspect)?,
            // A frame made ready for settings just left still serves most of what comes after.
            prepare: Slot::start(Kind::PrepareFrame, Never, outbox, move |request, job| {
                preparing.install(|| pruning::prepare(&request, job))
            })?,
            source: Slot::start(Kind::SourcePicture, Never, outbox, move |request, _| {
                paint_source(request, &decoder)
            })?,
            live: Slot::start(Kind::LiveView, Never, outbox, move |key, job| {
                let paint = || live_image::paint(&mut renderer, &mut filter, &key, job);
                let picture = rendering.install(paint)?;
                Ok(Message::LivePainted { key, picture: Arc::new(picture) })
            })?,
            carry: Slot::start(Kind::CarriedPicture, Never, outbox, move |key, _| {
                Ok(carrying.install(|| live_image::carry(&mut carrier, key)))
            })?,
            measure: Slot::start(Kind::MeasureAccuracy, Always, outbox, move |request, job| {
                let accuracy = measuring.install(|| measure(&request, job))?;
                Ok(Message::Measured { scene: request.scene.id, settings: request.settings, accuracy })
            })?,
            file: Worker::start(Kind::File, Queue, outbox, or_stopped)?,
            dialog: Worker::start(Kind::Dialog, Never, outbox, |(purpose, name), _| {
                Ok(Message::PathChosen { purpose, path: files::ask(purpose, name) })
            })?,
            check: Worker::start(Kind::CheckPath, Never, outbox, |(purpose, path), _| {
                Ok(files::check(purpose, path))
            })?,
            probe: Slot::start(Kind::PixelExplanation, Never, outbox, |key: ProbeKey, _| {
                let probed = facts::probe(&key).map(Arc::new);
                let is_hole = probed.is_none() && key.has_picture();
                Ok(Message::Probed { scene: key.scene.id, spot: key.spot, probed, is_hole })
            })?,
            thumbs: Slot::start(Kind::Thumbnails, Never, outbox, |request, _| Ok(thumbnails(&request)))?,
            memory: Slot::start(Kind::MemoryByCamera, Never, outbox, |request, _| Ok(memory(&request)))?,
            histograms: Slot::start(Kind::Histograms, Never, outbox, |request, _| {
                Ok(histograms::histograms(&request))
            })?,
            change: Slot::start(Kind::Change, Never, outbox, |request, _| Ok(change::paint(request)))?,
            values: Slot::start(Kind::CountValues, Always, outbox, |request, job| values(&request, job))?,
            compare: Slot::start(Kind::Compare, Alternate, outbox, move |key, job| {
                comparer.answer(key, job)
            })?,
            export: Worker::start(Kind::Export, Queue, outbox, or_stopped)?,
            filming,
            sizes: Slot::start(Kind::MeasureSizes, Never, outbox, move |key, job| meter.facts(&key, job))?,
            preview: Slot::start(Kind::PreviewShare, Never, outbox, preview)?,
            show_in_folder: Worker::start(Kind::ShowInFolder, Queue, outbox, |path: PathBuf, _| {
                work::show_in_folder(&path)
            })?,
            readings: Slot::start(Kind::CompareReadings, Queue, outbox, move |request, _| {
                Ok(comparing.install(|| readings::answer(request)))
            })?,
            // Of selections that follow a drag, every second is shown.
            edits: Slot::start(Kind::EditSamples, Alternate, outbox, move |key, job| {
                editing.install(|| editor.answer(key, job))
            })?,
            study: Worker::start(Kind::Study, Always, outbox, move |request, job| {
                studying.install(|| charts::work::study(request, &points, job))
            })?,
        })
    }

    /// All work that follows from the state, in the order in which it is asked for.
    pub(crate) fn slots(&self) -> [&dyn AnySlot; 18] {
        [
            &self.inspect,
            &self.prepare,
            &self.source,
            &self.measure,
            &self.probe,
            &self.thumbs,
            &self.memory,
            &self.histograms,
            &self.values,
            &self.compare,
            &self.sizes,
            &self.preview,
            &self.edits,
            &self.change,
            &self.live,
            &self.carry,
            &self.readings,
            &self.whole,
        ]
    }

    /// Asks for everything that the state needs and that was not asked for. Gives the time after which to call again, if any.
    pub(crate) fn request_missing(&self, state: &State) -> Option<Duration> {
        self.slots().into_iter().filter_map(|slot| slot.ask(state)).min()
    }

    /// Whether nothing runs or waits, and nothing is missing. An open dialog waits for the person.
    pub(crate) fn are_at_rest(&self, state: &State) -> bool {
        self.slots().into_iter().all(|slot| slot.is_at_rest(state))
            && self.watched().into_iter().all(|(_, progress)| progress.is_none())
            && self.check.is_idle()
    }

    /// Work that takes long enough to be watched, and its progress while it runs.
    pub(crate) fn watched(&self) -> [(Kind, Option<Progress>); 9] {
        [
            (Kind::Open, self.open.progress()),
            (Kind::Prune, self.whole.worker.progress()),
            (Kind::File, self.file.progress()),
            (Kind::Export, self.export.progress()),
            (Kind::Study, self.study.progress()),
            (Kind::Compare, self.compare.worker.progress()),
            (Kind::EditSamples, self.edits.worker.progress()),
            (Kind::InspectFrame, self.inspect.worker.progress()),
            (Kind::MeasureAccuracy, self.measure.worker.progress()),
        ]
    }
}

/// Does work, and sends a message if it is stopped.
fn or_stopped(FileWork { stopped: (title, text), run }: FileWork, job: &Job) -> Result<Message> {
    match job.check().and_then(|()| run(job)) {
        Err(_) if job.is_cancelled() => Ok(Message::Stopped { title, text }),
        outcome => outcome,
    }
}

/// How much nicer than the program threads are that answer the hand at once.
const WINDOW: i32 = 0;
/// Niceness of threads that paint the live view.
const PICTURES: i32 = 5;
/// Niceness of threads that work for minutes: an eighth of the window's share, half of that of pictures. With less, a window in
/// steady motion would starve the work that it waits for.
const WORK: i32 = 9;

/// Threads that carry pictures: it takes so little that more would only wait for each other.
const CARRIERS: usize = 4;

/// Threads apart from the pool that the views share, so that no picture waits behind minutes of pruning.
pub(crate) fn pool(name: &'static str, threads: usize, niceness: i32) -> Result<Arc<rayon::ThreadPool>> {
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .thread_name(move |index| format!("{name} {index}"))
        .start_handler(move |_| {
            if niceness > WINDOW {
                make_way(niceness);
            }
        })
        .build()
        .map(Arc::new)
        .map_err(|error| Error::invalid("thread pool", error.to_string()))
}

/// Lowers the priority of the calling thread by its niceness below that of the threads that draw. Linux keeps a niceness per thread; other systems favor
/// the window in front anyway. Best effort: if it is refused, the window is only less smooth.
#[cfg_attr(not(target_os = "linux"), expect(unused_variables, reason = "only Linux keeps it per thread"))]
fn make_way(niceness: i32) {
    #[cfg(target_os = "linux")]
    let _ = rustix::process::getpriority_process(None)
        .and_then(|own| rustix::process::setpriority_process(None, own + niceness));
}

#[cfg(test)]
mod tests {
    #[test]
    #[cfg(target_os = "linux")]
    fn a_thread_that_works_makes_way_and_no_other_does() {
        let niceness = || rustix::process::getpriority_process(None).unwrap();
        let own = niceness();
        let worker = std::thread::Builder::new().name("worker".to_owned());
        let theirs = worker.spawn(move || {
            super::make_way(super::WORK);
            niceness()
        });
        assert_eq!((theirs.unwrap().join().unwrap(), niceness()), (own + super::WORK, own));
    }
}
