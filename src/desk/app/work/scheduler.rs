//! Requests missing parts of the state after every change; nothing is requested twice.

use std::sync::Arc;
use std::time::{Duration, Instant};

use super::requests::PruneRequest;
use super::workers::Workers;
use crate::app::model::{OpenScene, SceneSource, State, method_of};
use crate::app::rooms::frame::model::DockView;
use crate::app::rooms::live::work::schedule::LiveSchedule;
use crate::app::rooms::readings::work::ReadingRequest;
use overlook_engine::settings::Settings;

/// How long a slider must rest before the whole capture is pruned again.
const DEBOUNCE: Duration = Duration::from_millis(400);

/// After this long at one frame it is prepared for interactive thresholds.
const REST: Duration = Duration::from_millis(200);

#[derive(Clone, PartialEq)]
pub(crate) struct InspectKey {
    scene: u64,
    pub frame: usize,
    method: Settings,
    /// Whether there is a scan, and whether it serves the settings or is shown until one does.
    scan_serves: Option<bool>,
}

/// What is pruned as the state is: the open capture, or its frame that is shown.
fn prune_request(state: &State, scene: &Arc<OpenScene>) -> PruneRequest {
    PruneRequest {
        scene: scene.clone(),
        scan: state.doc.scan.clone(),
        settings: state.settings.clone(),
        frame: state.timeline.frame,
    }
}

/// The last request to each worker; `None` requests again.
#[derive(Default)]
pub(crate) struct Scheduler {
    pub inspect: Option<InspectKey>,
    prepare: Option<InspectKey>,
    /// When an inspection was last requested.
    inspect_at: Option<Instant>,
    pub live: LiveSchedule,
    pub whole: Option<(u64, Settings)>,
    /// The scene whose reading was checked last, and the one whose two readings were shown.
    checked: Option<u64>,
    shown_readings: Option<u64>,
    /// When a setting was last changed.
    pub changed_at: Option<Instant>,
}

impl Scheduler {
    /// Whether everything that the state needs came back, except for whole-capture work that was stopped.
    pub(crate) fn is_up_to_date(&self, state: &State, workers: &Workers) -> bool {
        let whole =
            !state.has_capture() || state.doc.stopped || (state.doc.whole.is_some() && !state.is_stale());
        let source = !state.has_capture()
            || state.doc.source_shown.as_ref().map(|shown| &shown.key)
                == workers.source.asked().map(|asked| &asked.key);
        let live = self.live.is_up_to_date(state);
        let edits = !state.doc.edits.are_in_use()
            || state.samples_to_edit().is_none()
            || state.doc.edits.trouble.is_some()
            || state.doc.edits.edited.as_ref().map(|(key, _)| key) == workers.edits.asked();
        whole && source && live && edits && (self.is_inspected(state) || !state.has_capture())
    }

    /// Whether the last inspection that was requested came back.
    fn is_inspected(&self, state: &State) -> bool {
        state.doc.inspected.as_ref().is_some_and(|inspected| {
            self.inspect.as_ref().is_some_and(|key| {
                key.frame == inspected.inspection.frame && key.method == method_of(&inspected.settings)
            })
        })
    }

    /// Requests everything that is missing from the workers. Gives the time after which to call again, if any.
    pub(crate) fn request_missing(
        &mut self,
        state: &State,
        visible: &[DockView],
        workers: &mut Workers,
    ) -> Option<Duration> {
        self.request_inspection(state, workers);
        let preparation = self.request_preparation(state, workers);
        for slot in workers.slots() {
            slot.ask(state, visible);
        }
        let rest = self.live.request(state, workers, self.changed_at);
        self.request_readings(state, workers);
        self.request_whole(state, workers).into_iter().chain(rest).chain(preparation).min()
    }

    fn request_inspection(&mut self, state: &State, workers: &Workers) {
        let Some(scene) = state.doc.scene.as_ref().filter(|_| state.has_capture()) else { return };
        if state.skips_verdicts() {
            return;
        }
        let key = InspectKey {
            scene: scene.id,
            frame: state.timeline.frame,
            method: method_of(&state.settings),
            scan_serves: state.doc.scan.as_ref().map(|scan| scan.serves(&state.settings)),
        };
        if self.inspect.as_ref() != Some(&key) {
            workers.inspect.submit(prune_request(state, scene));
            self.inspect = Some(key);
            self.inspect_at = Some(Instant::now());
        }
    }

    /// Prepares the shown frame for interactive thresholds, once everything rests. Returns the time to wait for that, if any.
    fn request_preparation(&mut self, state: &State, workers: &Workers) -> Option<Duration> {
        let scene = state.doc.scene.as_ref().filter(|_| state.has_capture())?;
        let with_scan = state.doc.inspected.as_ref().is_some_and(|inspected| inspected.with_scan);
        if state.timeline.playing || !with_scan || self.prepare == self.inspect || !self.is_inspected(state) {
            return None;
        }
        let rested = self.inspect_at.map_or(REST, |at| at.elapsed());
        if rested < REST {
            return Some(REST.saturating_sub(rested));
        }
        workers.prepare.submit(prune_request(state, scene));
        self.prepare.clone_from(&self.inspect);
        None
    }

    fn request_whole(&mut self, state: &State, workers: &Workers) -> Option<Duration> {
        let scene = state.doc.scene.as_ref().filter(|_| state.has_capture())?;
        let key = (scene.id, method_of(&state.settings));
        if state.is_whole_ready() {
            if self.whole.as_ref().is_some_and(|asked| *asked != key) {
                // What runs works with settings that were taken back.
                workers.whole.cancel();
                self.whole = Some(key);
            }
            return None;
        }
        // The first look at the first frame goes before everything else.
        if state.doc.stopped || state.doc.inspected.is_none() || self.whole.as_ref() == Some(&key) {
            return None;
        }
        let rested = self.changed_at.map_or(DEBOUNCE, |at| at.elapsed());
        if rested < DEBOUNCE {
            // The running work is out of date; should its settings return, it is requested again.
            workers.whole.cancel();
            self.whole = None;
            return Some(DEBOUNCE.saturating_sub(rested));
        }
        workers.whole.submit(prune_request(state, scene));
        self.whole = Some(key);
        None
    }

    /// Once the first frame is shown: whether the capture's files are read as they are meant. A built-in scene is.
    fn request_readings(&mut self, state: &State, workers: &Workers) {
        let Some(scene) = state.doc.scene.as_ref().filter(|_| state.doc.inspected.is_some()) else { return };
        let is_read = state.has_capture() && matches!(scene.origin, SceneSource::Path(_));
        if !is_read {
            return;
        }
        let readings = &state.doc.readings;
        if !scene.is_reread && self.checked != Some(scene.id) {
            workers.readings.submit(ReadingRequest::Check(scene.clone()));
            self.checked = Some(scene.id);
        }
        if let Some(finding) =
            readings.finding.as_ref().filter(|_| readings.is_open && readings.shown.is_none())
            && self.shown_readings != Some(scene.id)
        {
            workers.readings.submit(ReadingRequest::Show(scene.clone(), finding.clone()));
            self.shown_readings = Some(scene.id);
        }
    }
}
