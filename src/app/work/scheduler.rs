//! Decides what work the state calls for. Called after every change; asks for nothing twice.

use std::sync::Arc;
use std::time::{Duration, Instant};

use super::live_image::{ColorBy, LiveKey};
use super::source_image::SourceKey;
use super::workers::{InspectRequest, MeasureRequest, WholeRequest, Workers};
use crate::app::dock::DockView;
use crate::app::model::{InspectorPlan, State, method_of};
use crate::render::Vantage;
use crate::samples::SampleSet;
use crate::settings::{Backend, Settings};

/// How long a slider must rest before the whole capture is pruned again.
const DEBOUNCE: Duration = Duration::from_millis(400);

/// The live view is still once it has shown one place and frame for so long; then it is painted as fine as it helps, into memory,
/// where its pixels can be asked about. Of a frame that was shown for so long thresholds may be turned.
const REST: Duration = Duration::from_millis(200);

#[derive(Clone, PartialEq)]
struct InspectKey {
    scene: u64,
    frame: usize,
    method: Settings,
    /// Whether there is a scan, and whether it serves the settings or is shown until one does.
    scan_serves: Option<bool>,
}

/// What was asked for last, per lane.
#[derive(Default)]
pub(crate) struct Scheduled {
    inspect: Option<InspectKey>,
    prepare: Option<InspectKey>,
    /// When an inspection was last asked for.
    inspect_at: Option<Instant>,
    source: Option<SourceKey>,
    live: Option<LiveKey>,
    /// Where the live view looks from and when, as it is painted in motion.
    place: Option<Vantage>,
    /// Whether it is painted otherwise once it rests.
    live_will_change: bool,
    whole: Option<(u64, Settings)>,
    measure: Option<(Arc<SampleSet>, Settings)>,
    inspector: InspectorPlan,
    /// When a setting was last changed.
    pub changed_at: Option<Instant>,
    /// When the live view last looked elsewhere, or at another frame.
    moved_at: Option<Instant>,
}

impl Scheduled {
    /// Forgets that the whole capture was asked for, so that it is asked for again.
    pub(crate) fn forget_whole(&mut self) {
        self.whole = None;
    }

    /// Forgets that the frame shown was asked for, so that it is asked for again.
    pub(crate) fn forget_frame(&mut self) {
        self.inspect = None;
        self.source = None;
    }

    /// Forgets that the pixel was asked about, so that it is asked about again.
    pub(crate) fn forget_probe(&mut self) {
        self.inspector.forget_probe();
    }

    /// The frame whose inspection was asked for last.
    pub(crate) fn inspected_frame(&self) -> Option<usize> {
        self.inspect.as_ref().map(|key| key.frame)
    }

    /// Forgets that accuracy was asked for, so that it is asked for again.
    pub(crate) fn forget_accuracy(&mut self) {
        self.measure = None;
    }

    /// Whether everything that the state calls for was asked for and came back, whole-capture work aside where the person
    /// stopped it.
    pub(crate) fn is_settled(&self, state: &State) -> bool {
        let whole = !state.has_capture() || state.stopped || (state.whole.is_some() && !state.is_stale());
        let source = !state.has_capture()
            || state.source_shown.as_ref().map(|shown| &shown.key) == self.source.as_ref();
        let live =
            state.live_shown.as_ref().map(|shown| &shown.key) == self.live.as_ref() && !self.live_will_change;
        whole && source && live && (self.is_inspected(state) || !state.has_capture())
    }

    /// Whether the inspection that was asked for last came back.
    fn is_inspected(&self, state: &State) -> bool {
        state.inspected.as_ref().is_some_and(|inspected| {
            self.inspect.as_ref().is_some_and(|key| {
                key.frame == inspected.inspection.frame && key.method == method_of(&inspected.settings)
            })
        })
    }

    /// Asks the lanes for whatever is missing. Gives how long to wait before it should be called again, if so.
    pub(crate) fn ask(&mut self, state: &State, visible: &[DockView], lanes: &Workers) -> Option<Duration> {
        self.ask_inspection(state, lanes);
        let preparation = self.ask_preparation(state, lanes);
        self.ask_source(state, lanes);
        let rest = self.ask_live(state, lanes);
        self.ask_accuracy(state, lanes);
        self.inspector.ask(state, visible, &lanes.inspector);
        self.ask_whole(state, lanes).into_iter().chain(rest).chain(preparation).min()
    }

    fn ask_inspection(&mut self, state: &State, lanes: &Workers) {
        let Some(scene) = state.scene.as_ref().filter(|_| state.has_capture()) else { return };
        if state.skips_verdicts() {
            return;
        }
        let key = InspectKey {
            scene: scene.id,
            frame: state.timeline.frame,
            method: method_of(&state.settings),
            scan_serves: state.scan.as_ref().map(|scan| scan.serves(&state.settings.spans)),
        };
        if self.inspect.as_ref() != Some(&key) {
            lanes.inspect.submit(InspectRequest {
                scene: scene.clone(),
                scan: state.scan.clone(),
                settings: state.settings.clone(),
                frame: key.frame,
            });
            self.inspect = Some(key);
            self.inspect_at = Some(Instant::now());
        }
    }

    /// Once a frame is shown and everything rests, makes it ready for the thresholds to be turned. Gives how long to wait for
    /// that, if so.
    fn ask_preparation(&mut self, state: &State, lanes: &Workers) -> Option<Duration> {
        let scene = state.scene.as_ref().filter(|_| state.has_capture())?;
        let with_scan = state.inspected.as_ref().is_some_and(|inspected| inspected.with_scan);
        if state.timeline.playing || !with_scan || self.prepare == self.inspect || !self.is_inspected(state) {
            return None;
        }
        let rested = self.inspect_at.map_or(REST, |at| at.elapsed());
        if rested < REST {
            return Some(REST.saturating_sub(rested));
        }
        lanes.prepare.submit(InspectRequest {
            scene: scene.clone(),
            scan: state.scan.clone(),
            settings: state.settings.clone(),
            frame: state.timeline.frame,
        });
        self.prepare.clone_from(&self.inspect);
        None
    }

    fn ask_source(&mut self, state: &State, lanes: &Workers) {
        let Some(scene) = state.scene.as_ref().filter(|_| state.has_capture()) else { return };
        // Verdicts of a frame just passed are better than a flash of another kind: in motion they may never catch up.
        let inspection = state
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
            dark: state.dark,
            inspection,
        };
        if self.source.as_ref() != Some(&key) {
            lanes.source.submit((scene.clone(), key.clone()));
            self.source = Some(key);
        }
    }

    fn ask_live(&mut self, state: &State, lanes: &Workers) -> Option<Duration> {
        let (Some(scene), Some(samples), Some(rig)) =
            (state.scene.as_ref(), state.samples_here(), state.live.rig.as_ref())
        else {
            return None;
        };
        let frame = state.timeline.frame;
        let coarse = rig.size_in_motion(state.live.size);
        let place = Vantage { camera: rig.camera(coarse[0], coarse[1]), frame };
        if self.place.as_ref() != Some(&place) {
            self.moved_at = Some(Instant::now());
            self.place = Some(place);
        }
        // While a threshold is dragged the next picture follows at once, too.
        let changes = [self.moved_at, self.changed_at];
        let rested = changes.into_iter().flatten().map(|at| at.elapsed()).min().unwrap_or(REST);
        // Colors that tell of samples beside pixels would mean something else in a finer picture.
        let fine = match state.live.color_by {
            ColorBy::Picture => rig.size_at_rest(state.live.size),
            _ => coarse,
        };
        let [width, height] = if rested < REST { coarse } else { fine };
        let vantage = Vantage { camera: rig.camera(width, height), frame };
        let on_gpu =
            state.live_shown.as_ref().is_some_and(|shown| shown.picture.painter.backend == Backend::Gpu);
        let in_motion = state.live.shares_device && on_gpu && rested < REST;
        let key = LiveKey {
            scene: scene.id,
            samples: samples.clone(),
            playback: scene.playback().cloned(),
            vantage,
            settings: state.settings.render.clone(),
            color_by: state.live.color_by,
            dark: state.dark,
            in_motion,
            per_coarse_pixel: f64::from(width) / f64::from(coarse[0]),
        };
        if self.live.as_ref() != Some(&key) {
            lanes.live.submit(key.clone());
            self.live = Some(key);
        }
        self.live_will_change = rested < REST && (in_motion || coarse != fine);
        self.live_will_change.then(|| REST.saturating_sub(rested))
    }

    fn ask_whole(&mut self, state: &State, lanes: &Workers) -> Option<Duration> {
        let scene = state.scene.as_ref().filter(|_| state.has_capture())?;
        let key = (scene.id, method_of(&state.settings));
        if state.is_whole_ready() {
            if self.whole.as_ref().is_some_and(|asked| *asked != key) {
                // What runs works with settings that were taken back.
                lanes.whole.cancel();
                self.whole = Some(key);
            }
            return None;
        }
        // The first look at the first frame goes before everything else.
        if state.stopped || state.inspected.is_none() || self.whole.as_ref() == Some(&key) {
            return None;
        }
        let rested = self.changed_at.map_or(DEBOUNCE, |at| at.elapsed());
        if rested < DEBOUNCE {
            // What runs now works with settings that no longer hold; should they come back, it is asked for again.
            lanes.whole.cancel();
            self.whole = None;
            return Some(DEBOUNCE.saturating_sub(rested));
        }
        lanes.whole.submit(WholeRequest {
            scene: scene.clone(),
            scan: state.scan.clone(),
            settings: state.settings.clone(),
        });
        self.whole = Some(key);
        None
    }

    fn ask_accuracy(&mut self, state: &State, lanes: &Workers) {
        let (Some(scene), Some(whole)) = (&state.scene, &state.whole) else { return };
        if state.is_stale() || state.timeline.playing {
            return;
        }
        let asked = self.measure.as_ref().is_some_and(|(samples, settings)| {
            Arc::ptr_eq(samples, &whole.samples) && *settings == state.settings
        });
        if !asked {
            lanes.measure.submit(MeasureRequest {
                scene: scene.clone(),
                samples: whole.samples.clone(),
                settings: state.settings.clone(),
            });
            self.measure = Some((whole.samples.clone(), state.settings.clone()));
        }
    }
}
