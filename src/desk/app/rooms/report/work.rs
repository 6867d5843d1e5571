//! Prunes the open capture: all of it, or the frame shown.

use std::sync::Arc;
use std::time::{Duration, Instant};

use crate::app::model::window::DockView;
use crate::app::model::{Inspected, Message, Method, OpenScene, Same, State};
use crate::app::work::worker::{Outbox, Wanted};
use overlook_engine::error::Result;
use overlook_engine::job::Job;
use overlook_engine::preprocess;
use overlook_engine::preprocess::PreparedScan;
use overlook_engine::preprocess::diagnostics::PixelAccount;
use overlook_engine::stored_verdicts::inspect_stored_frame;

/// How long a slider must rest before the whole capture is pruned again.
const DEBOUNCE: Duration = Duration::from_millis(400);

/// How long a frame must rest before it is prepared for interactive thresholds.
const REST: Duration = Duration::from_millis(200);

/// A frame to be pruned, with reasons; of a store, whose reasons are read.
#[derive(Clone, PartialEq)]
pub(crate) struct InspectRequest {
    scene: Arc<OpenScene>,
    /// The pass over all frames, where it is done.
    scan: Option<Same<PreparedScan>>,
    settings: Method,
    pub frame: usize,
}

impl InspectRequest {
    fn of(state: &State) -> Option<Self> {
        Some(Self {
            scene: state.doc.scene.clone()?,
            scan: state.doc.scan.clone().map(Same),
            settings: Method(state.settings.clone()),
            frame: state.timeline.frame,
        })
    }
}

impl Wanted for InspectRequest {
    fn wanted(state: &State) -> Option<Self> {
        let is_seen = || [DockView::Source, DockView::Cameras].into_iter().any(|view| state.shows(view));
        let is_wanted = if state.has_capture() {
            !state.skips_verdicts()
        } else {
            // Every camera's picture is painted for it.
            state.has_source() && is_seen() && !state.timeline.playing
        };
        Self::of(state).filter(|_| is_wanted)
    }
}

/// A frame to be made ready for its thresholds to be turned.
#[derive(Clone, PartialEq)]
pub(crate) struct PrepareRequest(InspectRequest);

impl Wanted for PrepareRequest {
    const IS_SHOWN: bool = false;

    fn wanted(state: &State) -> Option<Self> {
        let inspected = state.doc.inspected.as_ref().filter(|inspected| inspected.with_scan)?;
        let rests = Self::changes_in(state).is_none();
        let request = InspectRequest::of(state).filter(|_| rests && state.has_capture())?;
        let is_inspected = inspected.inspection.frame == request.frame
            && Method(inspected.settings.clone()) == request.settings;
        (is_inspected && !state.timeline.playing).then_some(Self(request))
    }

    fn changes_in(state: &State) -> Option<Duration> {
        left_of(REST, state.doc.inspected.as_ref()?.at)
    }
}

/// The whole capture to be pruned, whichever frame is shown, with the pass over all frames where one is done that serves the settings.
#[derive(Clone)]
pub(crate) struct WholeRequest(InspectRequest);

impl PartialEq for WholeRequest {
    /// The scan does not count: it is made where there is none.
    fn eq(&self, other: &Self) -> bool {
        self.0.scene == other.0.scene && self.0.settings == other.0.settings
    }
}

impl Wanted for WholeRequest {
    fn wanted(state: &State) -> Option<Self> {
        let rests = Self::changes_in(state).is_none();
        // The first look at the first frame goes before everything else.
        let is_due = rests && !state.is_whole_ready() && !state.doc.stopped && state.doc.inspected.is_some();
        let mut request = InspectRequest::of(state).filter(|_| is_due)?;
        request.scan = request.scan.filter(|scan| scan.serves(&request.settings.0));
        Some(Self(request))
    }

    /// What works with settings that were left is stopped.
    fn is_of_use(&self, state: &State) -> bool {
        self.0.settings == Method(state.settings.clone())
    }

    fn changes_in(state: &State) -> Option<Duration> {
        left_of(DEBOUNCE, state.doc.changed_at.filter(|_| state.has_capture())?)
    }
}

/// What is left of a time since a moment; `None` where it is over.
fn left_of(time: Duration, since: Instant) -> Option<Duration> {
    time.checked_sub(since.elapsed()).filter(|left| !left.is_zero())
}

/// Prunes a whole capture, after the pass over its frames.
pub(crate) fn prune_whole(request: WholeRequest, outbox: &Outbox, job: &Job) -> Result<Message> {
    let InspectRequest { scene, scan, settings: Method(settings), .. } = request.0;
    let capture = scene.source()?;
    let mut read_seconds = None;
    let scan = if let Some(Same(scan)) = scan {
        scan
    } else {
        let started = Instant::now();
        let scan = preprocess::scan(capture, &settings, job)?;
        read_seconds = Some(started.elapsed().as_secs_f64());
        outbox.send(Message::Scanned { scene: scene.id, scan: scan.clone() });
        scan
    };
    let result = preprocess::prune_for_store(capture, &scan, &settings, job)?;
    Ok(Message::Pruned { scene: scene.id, settings, result: Arc::new(result), read_seconds })
}

/// Prunes one frame, with reasons, or reads them from a store.
pub(crate) fn inspect(request: InspectRequest, job: &Job) -> Result<Message> {
    let InspectRequest { scene, scan, settings: Method(settings), frame } = request;
    let known = scan.as_deref().map(|scan| &**scan);
    let stored = scene.playback().map(|playback| inspect_stored_frame(playback, frame, job)).transpose()?;
    let inspection = match stored.flatten() {
        Some(inspection) => inspection,
        None => preprocess::inspect_frame(scene.source()?, known, &settings, frame, job)?,
    };
    let mut kept = vec![0; inspection.cameras.len()];
    for image in &inspection.samples.images {
        kept[image.camera as usize] += image.len() as u64;
    }
    let verdicts = inspection.cameras.iter().flat_map(|camera| camera.verdict.as_slice());
    let account = PixelAccount::of_frame(verdicts.map(|verdict| verdict.rule));
    let with_scan = scan.is_some() || inspection.is_of_store();
    let (inspection, at) = (Arc::new(inspection), Instant::now());
    let inspected = Inspected { inspection, settings, with_scan, kept, account, at };
    Ok(Message::Inspected { scene: scene.id, inspected })
}

/// Makes a frame ready for its thresholds to be turned.
pub(crate) fn prepare(PrepareRequest(request): &PrepareRequest, job: &Job) -> Result<Message> {
    if let (capture, Some(scan)) = (request.scene.source()?, &request.scan) {
        preprocess::prepare_frame(capture, scan, &request.settings.0, request.frame, job)?;
    }
    Ok(Message::Prepared)
}
