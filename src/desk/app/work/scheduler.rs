//! Requests missing parts of the state after every change; nothing is requested twice.

use std::sync::Arc;
use std::time::{Duration, Instant};

use crate::app::model::{OpenScene, SceneSource, State, method_of};
use crate::app::rooms::compare::model::CompareKey;
use crate::app::rooms::edits::model::EditKey;
use crate::app::rooms::frame::model::DockView;
use crate::app::rooms::live::work::schedule::LiveSchedule;
use crate::app::rooms::pixel::model::{ProbeKey, Spot};
use crate::app::rooms::readings::work::ReadingRequest;
use crate::app::rooms::share::model::{ShareKey, SharePreviewKey};
use crate::app::rooms::source::model::SourceKey;
use crate::app::work::requests::{HistogramRequest, MeasureRequest, PruneRequest};
use crate::app::work::worker::Worker;
use crate::app::work::workers::Workers;
use overlook_engine::preprocess::inspect::FrameInspection;
use overlook_engine::samples::SampleSet;
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

/// Submits a request that differs from the last one.
fn submit_new<K: Clone + PartialEq + Send + 'static>(worker: &Worker<K>, last: &mut Option<K>, key: K) {
    if last.as_ref() != Some(&key) {
        worker.submit(key.clone());
        *last = Some(key);
    }
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
    pub source: Option<SourceKey>,
    pub live: LiveSchedule,
    pub whole: Option<(u64, Settings)>,
    pub measure: Option<(Arc<SampleSet>, Settings)>,
    pub probe: Option<ProbeKey>,
    thumbs: Option<Arc<FrameInspection>>,
    memory: Option<Arc<SampleSet>>,
    histograms: Option<(Arc<FrameInspection>, bool)>,
    compare: Option<Box<CompareKey>>,
    /// The scene whose reading was checked last, and the one whose two readings were shown.
    checked: Option<u64>,
    shown_readings: Option<u64>,
    sizes: Option<ShareKey>,
    preview: Option<SharePreviewKey>,
    edits: Option<EditKey>,
    /// When a setting was last changed.
    pub changed_at: Option<Instant>,
}

impl Scheduler {
    /// Whether everything that the state needs came back, except for whole-capture work that was stopped.
    pub(crate) fn is_up_to_date(&self, state: &State) -> bool {
        let whole =
            !state.has_capture() || state.doc.stopped || (state.doc.whole.is_some() && !state.is_stale());
        let source = !state.has_capture()
            || state.doc.source_shown.as_ref().map(|shown| &shown.key) == self.source.as_ref();
        let live = self.live.is_up_to_date(state);
        let edits = !state.doc.edits.are_in_use()
            || state.samples_to_edit().is_none()
            || state.doc.edits.trouble.is_some()
            || state.doc.edits.edited.as_ref().map(|(key, _)| key) == self.edits.as_ref();
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
        workers: &Workers,
    ) -> Option<Duration> {
        self.request_inspection(state, workers);
        let preparation = self.request_preparation(state, workers);
        self.request_edits(state, workers);
        self.request_source(state, workers);
        let rest = self.live.request(state, workers, self.changed_at);
        self.request_accuracy(state, workers);
        self.request_probe(state, workers);
        self.request_thumbs(state, visible, workers);
        self.request_memory(state, visible, workers);
        self.request_histograms(state, visible, workers);
        self.request_comparison(state, visible, workers);
        self.request_readings(state, workers);
        self.request_sizes(state, workers);
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

    /// Applies edits to the samples, and shows what is selected of them.
    fn request_edits(&mut self, state: &State, workers: &Workers) {
        let samples = state.samples_to_edit().filter(|_| state.doc.edits.are_in_use());
        let (Some(scene), Some(samples)) = (&state.doc.scene, samples) else { return };
        let key = EditKey {
            scene: scene.clone(),
            samples: samples.clone(),
            scan: state.doc.scan.clone(),
            list: state.doc.edits.list.clone(),
            selection: state.doc.edits.shown_selection(),
        };
        submit_new(&workers.edits, &mut self.edits, key);
    }

    fn request_source(&mut self, state: &State, workers: &Workers) {
        let Some(scene) = state.doc.scene.as_ref().filter(|_| state.has_capture()) else { return };
        // Verdicts of a frame just passed are better than a flash of another kind: in motion they may never catch up.
        let inspection = state
            .doc
            .inspected
            .as_ref()
            .filter(|_| state.source.overlay.needs_verdicts())
            .map(|inspected| inspected.inspection.clone());
        let key = SourceKey {
            scene: scene.id,
            camera: state.source.camera,
            frame: inspection.as_ref().map_or(state.timeline.frame, |inspection| inspection.frame),
            overlay: state.source.overlay,
            against: state.source.against,
            isolated: state.doc.isolated.filter(|_| state.source.overlay.names_cameras()),
            display: state.display,
            dark: state.dark,
            inspection,
        };
        if self.source.as_ref() != Some(&key) {
            workers.source.submit((scene.clone(), key.clone()));
            self.source = Some(key);
        }
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

    fn request_accuracy(&mut self, state: &State, workers: &Workers) {
        let (Some(scene), Some(whole)) = (&state.doc.scene, &state.doc.whole) else { return };
        if state.is_stale() || state.timeline.playing {
            return;
        }
        let asked = self.measure.as_ref().is_some_and(|(samples, settings)| {
            Arc::ptr_eq(samples, &whole.samples) && *settings == state.settings
        });
        if !asked {
            workers.measure.submit(MeasureRequest {
                scene: scene.clone(),
                samples: whole.samples.clone(),
                scan: state.doc.scan.clone(),
                settings: state.settings.clone(),
            });
            self.measure = Some((whole.samples.clone(), state.settings.clone()));
        }
    }

    /// Compares at the vantage, and with the samples, of the last live picture.
    fn request_comparison(&mut self, state: &State, visible: &[DockView], workers: &Workers) {
        if visible.contains(&DockView::Compare)
            && let Some(key) = state.compare_key()
        {
            submit_new(&workers.compare, &mut self.compare, Box::new(key));
        }
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

    /// Measures what sizes follow from, while the dialog that shows them is open.
    fn request_sizes(&mut self, state: &State, workers: &Workers) {
        let samples = state.samples_here().filter(|_| state.share.is_open);
        let (Some(scene), Some(samples)) = (&state.doc.scene, samples) else { return };
        // Until the whole capture is pruned only pictures have a size.
        let samples = state.whole_samples().unwrap_or(samples);
        let shown = state.doc.live_shown.as_ref().filter(|shown| shown.key.quality.is_none());
        let key = ShareKey {
            scene: scene.clone(),
            samples: samples.clone(),
            frame: state.timeline.frame,
            picture: shown.map(|shown| shown.picture.clone()),
        };
        submit_new(&workers.sizes, &mut self.sizes, key);
        if let Some(key) = state.share_preview_key() {
            submit_new(&workers.preview, &mut self.preview, key);
        }
    }

    fn request_histograms(&mut self, state: &State, visible: &[DockView], workers: &Workers) {
        let wanted = visible.contains(&DockView::Thresholds) && !state.timeline.playing;
        let Some(inspected) = state.doc.inspected.as_ref().filter(|_| wanted) else { return };
        let asked = self.histograms.as_ref().is_some_and(|(inspection, with_scan)| {
            Arc::ptr_eq(inspection, &inspected.inspection) && *with_scan == state.doc.scan.is_some()
        });
        if let (false, Some(scene)) = (asked, &state.doc.scene) {
            workers.histograms.submit(HistogramRequest {
                scene: scene.id,
                inspection: inspected.inspection.clone(),
                scan: state.doc.scan.clone(),
                settings: inspected.settings.clone(),
            });
            self.histograms = Some((inspected.inspection.clone(), state.doc.scan.is_some()));
        }
    }

    fn request_memory(&mut self, state: &State, visible: &[DockView], workers: &Workers) {
        // A store plays from disk: its sample set is an outline.
        let wanted = visible.contains(&DockView::Memory) && state.has_capture();
        let samples = state.whole_samples().filter(|_| wanted);
        let (Some(scene), Some(samples)) = (&state.doc.scene, samples) else { return };
        if !self.memory.as_ref().is_some_and(|asked| Arc::ptr_eq(asked, samples)) {
            workers.memory.submit((scene.id, samples.clone()));
            self.memory = Some(samples.clone());
        }
    }

    fn request_probe(&mut self, state: &State, workers: &Workers) {
        let moves = state.doc.live_shown.as_ref().is_some_and(|shown| shown.key.quality.is_some());
        if moves && matches!(state.doc.probe.spot, Some(Spot::Live { .. })) {
            // The mark stays at its place in the scene; the picture at rest is asked again.
            return;
        }
        let key = state.doc.scene.as_ref().zip(state.doc.probe.spot).map(|(scene, spot)| ProbeKey {
            scene: scene.clone(),
            spot,
            inspection: state.inspection_here().cloned(),
            whole: state.current_whole().cloned(),
            live: matches!(spot, Spot::Live { .. })
                .then(|| {
                    state.doc.live_shown.as_ref().map(|shown| (shown.key.clone(), shown.picture.clone()))
                })
                .flatten(),
        });
        match key {
            Some(key) => submit_new(&workers.probe, &mut self.probe, key),
            None => self.probe = None,
        }
    }

    fn request_thumbs(&mut self, state: &State, visible: &[DockView], workers: &Workers) {
        let guides =
            state.live.show_cameras && state.live.guides.pictures && visible.contains(&DockView::Live);
        // In motion they would be made anew for every frame, for nobody to look at.
        let wanted = visible.contains(&DockView::Cameras) || (guides && !state.timeline.playing);
        let Some(inspection) = state.inspection_here().filter(|_| wanted) else { return };
        let asked = self.thumbs.as_ref().is_some_and(|asked| Arc::ptr_eq(asked, inspection));
        if let (false, Some(scene)) = (asked, &state.doc.scene) {
            workers.thumbs.submit((scene.id, inspection.clone()));
            self.thumbs = Some(inspection.clone());
        }
    }
}
