//! The inspector: what the window knows beyond its two pictures, and the lanes that find it out.

use std::collections::{BTreeSet, VecDeque};
use std::sync::Arc;
use std::time::Instant;

use egui::TextureHandle;

use super::camera_path::{CameraPath, ExportRequest};
use super::charts::Charts;
use super::compare_options::{CompareLook, CompareVantage};
use super::document::{NoticeKind, State};
use super::frame_timer::Meter;
use super::message::Message;
use super::presets::OwnPreset;
use super::undo::{History, SettingsSlot};
use crate::app::dock::DockView;
use crate::app::panels::CommandPalette;
use crate::app::work::{
    CameraMemory, CompareKey, Comparer, Lane, Outbox, ProbeKey, Probed, ShownComparison, Spot, StudyRequest,
    Supersede, ThresholdHistogram, or_stopped, pool,
};
use crate::error::{Error, Result};
use crate::preprocess::PreparedScan;
use crate::preprocess::inspect::FrameInspection;
use crate::samples::SampleSet;
use crate::settings::Settings;

/// Entries the log keeps.
const LOG: usize = 500;

/// The pixel that is looked at.
#[derive(Default)]
pub(crate) struct InspectedPixel {
    /// Where somebody points.
    pub spot: Option<Spot>,
    /// Whether it stays when the pointer goes.
    pub pinned: bool,
    /// What there is to say.
    pub shown: Option<Arc<Probed>>,
}

/// What stands between the person and closing the window.
#[derive(Clone, Copy, Default)]
pub(crate) struct Closing {
    /// Whether the question before closing is asked.
    pub asks: bool,
    /// Whether the window closes whatever is lost by it.
    pub anyway: bool,
    /// Whether a file, pictures or a film are being written.
    pub writing: bool,
}

/// A line of the log.
pub(crate) struct LogLine {
    /// When.
    pub at: Instant,
    /// How loud.
    pub kind: NoticeKind,
    /// What.
    pub text: String,
}

/// What the inspector knows.
#[derive(Default)]
pub(crate) struct Inspector {
    /// The pixel that is looked at.
    pub probe: InspectedPixel,
    /// Every camera small, in the capture's order; empty before the first.
    pub thumbs: Vec<TextureHandle>,
    /// What takes the memory, largest first; `None` before it was asked for.
    pub memory: Option<Vec<CameraMemory>>,
    /// The quantities that thresholds cut; empty before the first.
    pub histograms: Vec<ThresholdHistogram>,
    /// Settings as they were.
    pub history: History,
    /// Settings of one's own to start from.
    pub presets: Vec<OwnPreset>,
    /// What a new preset is named so far, while it is named.
    pub naming: Option<String>,
    /// How the comparison looks.
    pub compare: CompareLook,
    /// The comparison that is shown.
    pub compared: Option<ShownComparison>,
    /// Why there is none.
    pub compare_trouble: Option<String>,
    /// What was measured.
    pub charts: Charts,
    /// The camera path.
    pub path: CameraPath,
    /// The command palette, while it is open.
    pub palette: Option<CommandPalette>,
    /// Whether the sheet of keys is open.
    pub cheat_sheet: bool,
    /// Whether the introduction of the first run was read.
    pub introduced: bool,
    /// The settings of the store that was saved last of the open capture, at first those that it was opened with.
    pub saved: Option<Settings>,
    /// What stands between the person and closing the window.
    pub closing: Closing,
    /// What happened, the latest last.
    pub log: VecDeque<LogLine>,
    /// What could not be read of the open store, as far as it was told.
    pub told_damage: BTreeSet<String>,
    /// What the window's own work takes.
    pub meter: Meter,
}

impl Inspector {
    /// Forgets what belongs to a scene.
    pub(crate) fn close_scene(&mut self) {
        self.probe = InspectedPixel::default();
        self.thumbs.clear();
        self.memory = None;
        self.histograms.clear();
        self.compare.place = CompareVantage::Live;
        self.compared = None;
        self.path = CameraPath::default();
        self.charts = Charts::default();
        self.saved = None;
        self.compare_trouble = None;
        self.told_damage.clear();
    }

    /// What stands in no file and ends with the scene, in words; `None` where there is nothing.
    pub(crate) fn losses(&self) -> Option<String> {
        let counted = |count: usize, of: &str| match count {
            0 => None,
            1 => Some(format!("1 {of}")),
            _ => Some(format!("{count} {of}s")),
        };
        let charts = &self.charts;
        let parts = [
            counted(self.path.keys.len(), "key").map(|keys| format!("the camera path ({keys})")),
            counted(charts.sweep.len(), "point").map(|points| format!("the sweep ({points})")),
            counted(charts.stress.len(), "point").map(|points| format!("the stress test ({points})")),
            charts.studying.then(|| "what is being measured".to_owned()),
        ];
        let parts: Vec<String> = parts.into_iter().flatten().collect();
        (!parts.is_empty()).then(|| parts.join(", "))
    }

    /// Adds a line to the log.
    pub(crate) fn log(&mut self, kind: NoticeKind, text: String) {
        if self.log.len() == LOG {
            self.log.pop_front();
        }
        self.log.push_back(LogLine { at: Instant::now(), kind, text });
    }
}

/// The inspector's lanes.
pub(crate) struct InspectorLanes {
    probe: Lane<ProbeKey>,
    thumbs: Lane<(u64, Arc<FrameInspection>)>,
    memory: Lane<(u64, Arc<SampleSet>)>,
    histograms: Lane<HistogramRequest>,
    /// Two pictures of one place.
    pub compare: Lane<Box<CompareKey>>,
    /// The pictures of the camera path.
    pub export: Lane<ExportRequest>,
    /// Sweeps and stress tests.
    pub study: Lane<StudyRequest>,
}

/// What histograms are made from.
struct HistogramRequest {
    scene: u64,
    inspection: Arc<FrameInspection>,
    scan: Option<Arc<PreparedScan>>,
    settings: Settings,
}

impl InspectorLanes {
    /// Starts them.
    ///
    /// # Errors
    /// `Io` where the operating system gives no thread.
    pub(crate) fn start(outbox: &Outbox) -> Result<Self> {
        let studying = outbox.clone();
        // Threads of their own: the pictures on screen must not wait for minutes of measuring.
        let threads = pool("study", rayon::current_num_threads(), true)?;
        let mut comparer = Comparer::new(threads.clone());
        Ok(Self {
            probe: Lane::start("Pixel argument", Supersede::Never, outbox.clone(), |key: ProbeKey, _| {
                let probed = crate::app::work::probe(&key).map(Arc::new);
                let is_hole = probed.is_none() && key.has_picture();
                Ok(Message::Probed { scene: key.scene.id, spot: key.spot, probed, is_hole })
            })?,
            memory: Lane::start(
                "Memory by camera",
                Supersede::Never,
                outbox.clone(),
                |(scene, samples): (u64, Arc<SampleSet>), _| {
                    let cameras = crate::app::work::by_camera(&samples);
                    Ok(Message::MemoryMapped { scene, cameras })
                },
            )?,
            histograms: Lane::start(
                "Histograms",
                Supersede::Never,
                outbox.clone(),
                |request: HistogramRequest, _| {
                    let HistogramRequest { scene, inspection, scan, settings } = request;
                    let histograms = crate::app::work::histograms(&inspection, scan.as_ref(), &settings);
                    Ok(Message::Histograms { scene, histograms })
                },
            )?,
            compare: Lane::start(
                "Compare",
                Supersede::Alternate,
                outbox.clone(),
                move |key: Box<CompareKey>, job| {
                    let outcome = match comparer.compare(&key, job) {
                        Ok(comparison) => Ok(comparison),
                        Err(Error::Cancelled) => return Err(Error::Cancelled),
                        Err(Error::Invalid { what, .. }) => Err(what),
                        Err(error) => Err(error.to_string()),
                    };
                    Ok(Message::Compared { key, outcome })
                },
            )?,
            study: Lane::start(
                "Study",
                Supersede::Always,
                outbox.clone(),
                move |request: StudyRequest, job| {
                    threads.install(|| crate::app::work::study(request, &studying, job))
                },
            )?,
            export: Lane::start(
                "Export",
                Supersede::Queue,
                outbox.clone(),
                |request: ExportRequest, job| {
                    or_stopped(job, "Export stopped", request.target.stopped(), || {
                        let exported = super::camera_path::export(&request, job)?;
                        Ok(Message::Exported { path: request.target.path().to_path_buf(), exported })
                    })
                },
            )?,
            thumbs: Lane::start(
                "Thumbnails",
                Supersede::Never,
                outbox.clone(),
                |(scene, inspection): (u64, Arc<FrameInspection>), _| {
                    let pictures = crate::app::work::paint(&inspection);
                    Ok(Message::Thumbnails { scene, pictures })
                },
            )?,
        })
    }

    /// Whether nothing runs or waits.
    pub(crate) fn are_idle(&self) -> bool {
        self.probe.is_idle()
            && self.thumbs.is_idle()
            && self.memory.is_idle()
            && self.histograms.is_idle()
            && self.compare.is_idle()
            && self.export.is_idle()
            && self.study.is_idle()
    }
}

/// What was asked for last.
#[derive(Default)]
pub(crate) struct InspectorPlan {
    probe: Option<ProbeKey>,
    thumbs: Option<Arc<FrameInspection>>,
    memory: Option<Arc<SampleSet>>,
    histograms: Option<(Arc<FrameInspection>, bool)>,
    compare: Option<Box<CompareKey>>,
}

impl InspectorPlan {
    /// Asks for what is missing, of what can be seen.
    pub(crate) fn ask(&mut self, state: &State, visible: &[DockView], lanes: &InspectorLanes) {
        self.ask_probe(state, lanes);
        self.ask_thumbs(state, visible, lanes);
        self.ask_memory(state, visible, lanes);
        self.ask_histograms(state, visible, lanes);
        self.ask_comparison(state, visible, lanes);
    }

    /// Forgets that the pixel was asked about, so that it is asked about again.
    pub(crate) fn forget_probe(&mut self) {
        self.probe = None;
    }

    /// Compares once the live view has come to rest: its picture says from where and of what.
    fn ask_comparison(&mut self, state: &State, visible: &[DockView], lanes: &InspectorLanes) {
        let shown = state.live_shown.as_ref().filter(|_| visible.contains(&DockView::Compare));
        let (Some(scene), Some(shown)) = (&state.scene, shown) else { return };
        let (history, look) = (&state.inspector.history, &state.inspector.compare);
        let now = &state.settings;
        let key = Box::new(CompareKey {
            scene: scene.clone(),
            sides: look.sides,
            place: look.place,
            vantage: shown.key.vantage.clone(),
            // Of a store played from disk only the picture knows the samples.
            samples: shown.picture.samples.clone(),
            whole: state.current_whole().is_some_and(|whole| Arc::ptr_eq(whole, &shown.picture.samples)),
            scan: state.scan.clone(),
            settings: [
                now.clone(),
                history.of(SettingsSlot::A, now).clone(),
                history.of(SettingsSlot::B, now).clone(),
            ],
            measure: look.measure,
            range: look.range,
            dark: state.dark,
        });
        if self.compare.as_ref() != Some(&key) {
            lanes.compare.submit(key.clone());
            self.compare = Some(key);
        }
    }

    fn ask_histograms(&mut self, state: &State, visible: &[DockView], lanes: &InspectorLanes) {
        let wanted = visible.contains(&DockView::Thresholds) && !state.timeline.playing;
        let Some(inspected) = state.inspected.as_ref().filter(|_| wanted) else { return };
        let asked = self.histograms.as_ref().is_some_and(|(inspection, with_scan)| {
            Arc::ptr_eq(inspection, &inspected.inspection) && *with_scan == state.scan.is_some()
        });
        if let (false, Some(scene)) = (asked, &state.scene) {
            lanes.histograms.submit(HistogramRequest {
                scene: scene.id,
                inspection: inspected.inspection.clone(),
                scan: state.scan.clone(),
                settings: inspected.settings.clone(),
            });
            self.histograms = Some((inspected.inspection.clone(), state.scan.is_some()));
        }
    }

    fn ask_memory(&mut self, state: &State, visible: &[DockView], lanes: &InspectorLanes) {
        // A store plays from disk: its set only says where samples are.
        let wanted = visible.contains(&DockView::Memory) && state.has_capture();
        let samples = state.whole_samples().filter(|_| wanted);
        let (Some(scene), Some(samples)) = (&state.scene, samples) else { return };
        if !self.memory.as_ref().is_some_and(|asked| Arc::ptr_eq(asked, samples)) {
            lanes.memory.submit((scene.id, samples.clone()));
            self.memory = Some(samples.clone());
        }
    }

    fn ask_probe(&mut self, state: &State, lanes: &InspectorLanes) {
        let key = state.scene.as_ref().zip(state.inspector.probe.spot).map(|(scene, spot)| ProbeKey {
            scene: scene.clone(),
            spot,
            inspection: state.inspection_here().cloned(),
            whole: state.current_whole().cloned(),
            live: matches!(spot, Spot::Live { .. })
                .then(|| state.live_shown.as_ref().map(|shown| (shown.key.clone(), shown.picture.clone())))
                .flatten(),
        });
        if self.probe != key {
            if let Some(key) = &key {
                lanes.probe.submit(key.clone());
            }
            self.probe = key;
        }
    }

    fn ask_thumbs(&mut self, state: &State, visible: &[DockView], lanes: &InspectorLanes) {
        let Some(inspection) = state.inspection_here().filter(|_| visible.contains(&DockView::Cameras))
        else {
            return;
        };
        let asked = self.thumbs.as_ref().is_some_and(|asked| Arc::ptr_eq(asked, inspection));
        if let (false, Some(scene)) = (asked, &state.scene) {
            lanes.thumbs.submit((scene.id, inspection.clone()));
            self.thumbs = Some(inspection.clone());
        }
    }
}
