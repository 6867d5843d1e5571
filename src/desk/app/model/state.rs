//! What the window knows. Panels borrow it and only read.

use std::collections::{BTreeSet, VecDeque};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use egui::TextureHandle;
use glam::DVec3;

use crate::app::model::command::Opening;
use crate::app::model::look::{Display, FrameGuide, FrameValues};
use crate::app::model::notice::Notice;
use crate::app::model::picture::{
    ColorBy, HoleDisplay, LiveKey, LivePicture, Overlay, PixelSource, ShownCarried, SourceKey, SourcePicture,
};
use crate::app::model::purpose::TypedPath;
use crate::app::model::scene::{Accuracy, CameraMemory, Content, Inspected, OpenScene, Whole, method_of};
use crate::app::model::texture::{Texture, smaller};
use crate::app::model::undo::History;
use crate::app::model::window::{CommandPalette, DockView, HelpPage, LogLine, NoticeKind, WindowLook};
use crate::app::model::work_kind::WorkKind;
use crate::app::rooms::change::state::SettingsChange;
use crate::app::rooms::charts::state::Charts;
use crate::app::rooms::compare::state::{CompareLook, PictureFolder, ShownComparison};
use crate::app::rooms::edits::state::SceneEdits;
use crate::app::rooms::files::state::RecentPicture;
use crate::app::rooms::live::state::{FIRST_SIZE, KeptView, LiveLook, ViewHistory, ViewMotion, ViewPictures};
use crate::app::rooms::path::CameraPath;
use crate::app::rooms::pixel::state::InspectedPixel;
use crate::app::rooms::readings::state::ReadingCheck;
use crate::app::rooms::settings::ThresholdHistogram;
use crate::app::rooms::share::state::ShareDialog;
use crate::app::rooms::source::SourceLook;
use crate::app::rooms::timeline::Timeline;
use crate::pruned_store::PrunedBefore;
use overlook_engine::capture::Camera;
use overlook_engine::job::Progress;
use overlook_engine::plural;
use overlook_engine::preprocess::diagnostics::Report;
use overlook_engine::preprocess::inspect::FrameInspection;
use overlook_engine::preprocess::{PreparedScan, Preprocessed};
use overlook_engine::samples::SampleSet;
use overlook_engine::settings::{Fill, Settings};

/// Columns or rows that exported pictures can have.
pub(crate) const SIDES: std::ops::RangeInclusive<u32> = 2..=16_384;

/// Work that takes long enough to be watched.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Busy {
    pub work: WorkKind,
    pub progress: Progress,
    /// Whether cancelling it leaves something to be rerun.
    pub cancellable: bool,
    /// How long the rest takes at the pace so far; `None` while too little is done to estimate it.
    pub secs_left: Option<f32>,
}

/// What the window knows.
pub(crate) struct State {
    pub doc: Document,
    /// What is being opened, in words.
    pub opening: Option<String>,
    /// The settings on the sliders.
    pub settings: Settings,
    pub timeline: Timeline,
    pub source: SourceLook,
    pub live: LiveLook,
    pub notices: Vec<Notice>,
    pub inspector: Inspector,
    pub typed_path: Option<TypedPath>,
    pub share: ShareDialog,
    /// What is to be opened once the question about what is lost is answered.
    pub open_after_question: Option<Opening>,
    pub dark: bool,
    pub look: WindowLook,
    pub display: Display,
    /// What was open lately, the latest first.
    pub recent: Vec<PathBuf>,
    /// What the live view showed of some of them.
    pub recent_pictures: Vec<RecentPicture>,
    /// Which way was chosen to be up in what was open, in world space; `None` where it was asked and left as it is.
    pub chosen_ups: Vec<(PathBuf, Option<DVec3>)>,
    /// Long work under way; the line at the bottom names the first, which is what can be cancelled.
    pub busy: Vec<Busy>,
}

impl State {
    /// Frames of what is open.
    pub(crate) fn frame_count(&self) -> usize {
        self.doc.scene.as_ref().map_or(0, |scene| scene.frame_count())
    }

    /// Whether there is time to move in.
    pub(crate) fn has_time(&self) -> bool {
        self.doc.scene.is_none() || self.frame_count() > 1
    }

    /// Whether there is something for a view to show: nothing passes in a single frame.
    pub(crate) fn has_use_of(&self, view: DockView) -> bool {
        view != DockView::Time || self.has_time()
    }

    /// Whether a view can be seen.
    pub(crate) fn shows(&self, view: DockView) -> bool {
        self.look.in_sight.contains(&view)
    }

    /// What the source view can show of what is open.
    pub(crate) fn overlays(&self) -> impl Iterator<Item = (Overlay, &'static str, &'static str)> {
        let (has_time, has_capture) = (self.has_time(), self.has_capture());
        Overlay::ALL.into_iter().filter(move |(overlay, ..)| match overlay {
            Overlay::Split => has_time,
            Overlay::Color | Overlay::WhoWon | Overlay::Tiles | Overlay::Depth => true,
            _ => has_capture,
        })
    }

    /// What the live view can show of what is open.
    pub(crate) fn live_colors(&self) -> impl Iterator<Item = (ColorBy, &'static str, &'static str)> {
        let (has_time, has_values) = (self.has_time(), !self.value_channels().is_empty());
        ColorBy::ALL.into_iter().filter(move |(color_by, ..)| match color_by {
            ColorBy::Span => has_time,
            ColorBy::Value => has_values,
            _ => true,
        })
    }

    /// Frames or samples of what is open.
    pub(crate) fn content(&self) -> Option<&Content> {
        self.doc.scene.as_ref().map(|scene| &scene.content)
    }

    /// Whether a capture (not a store) is open.
    pub(crate) fn has_capture(&self) -> bool {
        self.doc.scene.as_ref().is_some_and(|scene| scene.capture().is_some())
    }

    /// Whether there are pictures of cameras: those of a capture, or what a store that says why shows from where they stood.
    pub(crate) fn has_source(&self) -> bool {
        let says_why =
            |scene: &Arc<OpenScene>| scene.playback().is_some_and(|playback| playback.store().has_verdicts());
        self.has_capture() || self.doc.scene.as_ref().is_some_and(says_why)
    }

    /// Whether the whole-capture numbers were made with other settings than those on the sliders.
    pub(crate) fn is_stale(&self) -> bool {
        self.doc.whole.as_ref().is_some_and(|whole| method_of(&whole.settings) != method_of(&self.settings))
    }

    /// The whole capture as it was pruned before edits, if by the settings on the sliders.
    pub(crate) fn pruned_before(&self) -> Option<PrunedBefore> {
        let Whole { samples, report, verdicts, .. } = self.doc.whole.as_ref().filter(|_| !self.is_stale())?;
        let scan = self.doc.scan.clone().filter(|scan| scan.serves(&self.settings))?;
        let (samples, verdicts, report) = (samples.clone(), verdicts.clone(), (**report).clone());
        Some(PrunedBefore { scan, result: Preprocessed { samples, verdicts, report } })
    }

    /// The whole capture's samples, if they were made with the settings on the sliders.
    pub(crate) fn current_whole(&self) -> Option<&Arc<SampleSet>> {
        self.doc.whole.as_ref().filter(|_| !self.is_stale()).map(|whole| &whole.samples)
    }

    /// Note for numbers of the whole capture that were made with other settings; `None` for current numbers.
    pub(crate) fn stale_note(&self) -> Option<&'static str> {
        self.is_stale().then_some(if self.doc.stopped {
            "Made with other settings; Recompute (below) brings it up to date."
        } else {
            "Made with other settings; being brought up to date."
        })
    }

    /// Whether there are thresholds to be turned: a store keeps those that it was made with.
    pub(crate) fn has_thresholds(&self) -> bool {
        self.doc.scene.is_none() || self.has_capture()
    }

    /// Whether playback needs no verdicts: the live view shows the whole capture's samples, and the source view the bare picture.
    pub(crate) fn skips_verdicts(&self) -> bool {
        let needed = self.source.overlay.needs_verdicts() || self.live.color_by == ColorBy::Agreement;
        self.timeline.playing && self.current_whole().is_some() && !needed
    }

    /// How the live view shows holes: where the settings do not fill them, there is nothing but hatching.
    pub(crate) fn holes_shown(&self) -> HoleDisplay {
        if self.settings.render.fill == Fill::None { HoleDisplay::Hatched } else { self.live.holes }
    }

    /// The account of the open capture or store.
    pub(crate) fn report(&self) -> Option<&Report> {
        match self.content() {
            Some(Content::Store { report, .. }) => Some(report),
            _ => self.doc.whole.as_ref().map(|whole| whole.report.as_ref()),
        }
    }

    /// Whether the true picture of some viewpoint is known.
    pub(crate) fn has_truth(&self) -> bool {
        matches!(self.content(), Some(Content::Capture { truth, .. }) if !truth.is_empty())
    }

    /// Whether thresholds differ from those of the last saved store; before one is saved, from those at opening.
    pub(crate) fn is_unsaved(&self) -> bool {
        let saved = self.doc.saved.as_ref().filter(|_| self.has_capture());
        saved.is_some_and(|saved| method_of(saved) != method_of(&self.settings))
    }

    /// The settings that the panel shows: a store's own where one is open, with the painting that is on now.
    pub(crate) fn shown_settings(&self) -> Settings {
        match self.content() {
            Some(Content::Store { samples, .. }) => {
                Settings { render: self.settings.render.clone(), ..samples.settings.clone() }
            }
            _ => self.settings.clone(),
        }
    }

    /// The verdicts at the frame shown, under any settings.
    pub(crate) fn inspection_here(&self) -> Option<&Arc<FrameInspection>> {
        let inspected = self.doc.inspected.as_ref()?;
        (inspected.inspection.frame == self.timeline.frame).then_some(&inspected.inspection)
    }

    /// Whether there are no verdicts at the frame shown, nor will be, as they could not be worked out.
    pub(crate) fn is_frame_failed(&self) -> bool {
        self.doc.failed_frame == Some(self.timeline.frame) && self.inspection_here().is_none()
    }

    /// Up in world space, unit length: as chosen, or as in the capture.
    pub(crate) fn up_in_world(&self) -> DVec3 {
        let recorded = self.doc.scene.as_ref().map_or(DVec3::Z, |scene| scene.up_in_world);
        self.live.up.unwrap_or(recorded)
    }

    /// The best account of the frame shown: the whole capture's samples, or while those are stale this frame's.
    pub(crate) fn samples_here(&self) -> Option<&Arc<SampleSet>> {
        if let Some(Content::Store { samples, .. }) = self.content() {
            return Some(samples);
        }
        let own = || self.inspection_here().map(|inspection| &inspection.samples);
        self.current_whole().or_else(own).or(self.doc.whole.as_ref().map(|whole| &whole.samples))
    }

    /// The picture of the live view as it is shown; `None` while it stays on the graphics card.
    pub(crate) fn shown_picture(&self) -> Option<&Arc<egui::ColorImage>> {
        match &self.doc.live_shown.as_ref()?.picture.pixels {
            PixelSource::InMemory { image, .. } => Some(image),
            PixelSource::OnAdapter(_) => None,
        }
    }

    /// Keeps a small picture of what is open, and those of other files that were open lately.
    pub(crate) fn remember_picture(&mut self, ctx: &egui::Context) {
        let Some((path, picture)) = self.opened_path().zip(self.shown_picture()) else { return };
        let picture = RecentPicture::new(ctx, path.clone(), smaller(picture));
        let recent = &self.recent;
        self.recent_pictures.retain(|known| known.path != picture.path && recent.contains(&known.path));
        self.recent_pictures.push(picture);
    }

    /// Whether the samples of all frames are there, made with the settings on the sliders or played from a store.
    pub(crate) fn is_whole_ready(&self) -> bool {
        self.doc.scene.is_some() && (!self.has_capture() || self.current_whole().is_some())
    }

    /// The samples of the whole capture or store, perhaps by older settings.
    pub(crate) fn whole_samples(&self) -> Option<&Arc<SampleSet>> {
        match self.content() {
            Some(Content::Store { samples, .. }) => Some(samples),
            _ => self.doc.whole.as_ref().map(|whole| &whole.samples),
        }
    }

    /// Columns and rows of exported pictures: as chosen, else those of the largest camera; even, as films want them.
    pub(crate) fn export_size(&self) -> [u32; 2] {
        even(self.doc.path.size.unwrap_or_else(|| self.largest_size()))
    }

    /// Columns and rows of the largest camera's pictures.
    fn largest_size(&self) -> [u32; 2] {
        let cameras = self.doc.scene.iter().flat_map(|scene| &scene.cameras);
        let sizes = cameras.map(|camera| [camera.intrinsics.width, camera.intrinsics.height]);
        sizes.max_by_key(|[width, height]| u64::from(*width) * u64::from(*height)).unwrap_or(FIRST_SIZE)
    }

    /// Sizes that are offered for exported pictures: that of the largest camera, and usual widths in its shape.
    pub(crate) fn offered_sizes(&self) -> [[u32; 2]; 4] {
        let [width, height] = self.largest_size();
        let wide = |columns: u32| {
            let rows = f64::from(columns) * f64::from(height) / f64::from(width.max(1));
            even([columns, rows.round() as u32])
        };
        [even([width, height]), wide(1280), wide(1920), wide(3840)]
    }

    /// Columns and rows of the live view's picture in a figure.
    pub(crate) fn figure_size(&self) -> [u32; 2] {
        let columns = self.share.options.figure.columns();
        let [width, height] = self.live.size.map(f64::from);
        [columns, (f64::from(columns) * height / width.max(1.0)).round().max(1.0) as u32]
    }

    /// Columns and rows of the picture whose frame the live view shows; of the camera's where none is.
    pub(crate) fn framed_size(&self) -> Option<[u32; 2]> {
        match self.live.guides.frame {
            FrameGuide::Off | FrameGuide::Camera => {
                self.live.orbit.as_ref().map(|orbit| [orbit.lens.width, orbit.lens.height])
            }
            FrameGuide::Export => Some(self.export_size()),
        }
    }

    /// The camera of a live view of `width × height` pixels: all of the frame that is shown lies within.
    pub(crate) fn live_camera(&self, [width, height]: [u32; 2]) -> Option<Camera> {
        let orbit = self.live.orbit.as_ref()?.framed(self.framed_size()?);
        Some(orbit.camera(width, height))
    }

    /// Work that is in no file and ends with the scene, in words; `None` without any.
    pub(crate) fn unsaved_work(&self) -> Option<String> {
        let counted = |count: usize, of: &str| (count > 0).then(|| plural::counted(count, of));
        let Document { path, charts, edits, .. } = &self.doc;
        let parts = [
            counted(if path.is_saved() { 0 } else { path.keys.len() }, "key")
                .map(|keys| format!("the camera path ({keys})")),
            counted(charts.sweep.len(), "point").map(|points| format!("the sweep ({points})")),
            counted(charts.stress.len(), "point").map(|points| format!("the stress test ({points})")),
            charts.studying.then(|| "what is being measured".to_owned()),
            counted(if edits.list == edits.saved { 0 } else { edits.list.edits.len() }, "edit")
                .map(|edits| format!("the edits ({edits})")),
        ];
        let parts: Vec<String> = parts.into_iter().flatten().collect();
        (!parts.is_empty()).then(|| parts.join(", "))
    }

    /// Whether a dialog is open over the window.
    pub(crate) fn is_asking(&self) -> bool {
        let inspector = &self.inspector;
        self.typed_path.is_some()
            || self.share.is_open
            || self.open_after_question.is_some()
            || inspector.palette.is_some()
            || inspector.closing.asks
            || self.doc.readings.is_open
            || self.doc.charts.question.is_some()
            || inspector.help.is_some_and(|page| !matches!(page, HelpPage::Guide(_)))
    }
}

/// A size that films can have.
fn even(size: [u32; 2]) -> [u32; 2] {
    size.map(|side| (side & !1).clamp(*SIDES.start(), *SIDES.end()))
}

impl Default for State {
    fn default() -> Self {
        Self {
            doc: Document::default(),
            opening: None,
            settings: Settings::default(),
            timeline: Timeline { frames_per_second: 24.0, ..Timeline::default() },
            source: SourceLook::default(),
            live: LiveLook::default(),
            notices: Vec::new(),
            inspector: Inspector::default(),
            typed_path: None,
            share: ShareDialog::default(),
            open_after_question: None,
            dark: true,
            look: WindowLook::default(),
            display: Display::default(),
            recent: Vec::new(),
            recent_pictures: Vec::new(),
            chosen_ups: Vec::new(),
            busy: Vec::new(),
        }
    }
}

/// A picture that is shown, and what it was made from.
pub(crate) struct ShownPicture<K, P> {
    pub key: K,
    pub picture: Arc<P>,
    pub texture: Texture,
}

/// What is open, and what is known of it. It ends with the scene: a new scene replaces it whole.
#[derive(Default)]
pub(crate) struct Document {
    pub scene: Option<Arc<OpenScene>>,
    /// The pass over all frames of the open capture.
    pub scan: Option<Arc<PreparedScan>>,
    /// Perhaps by older settings.
    pub whole: Option<Whole>,
    /// Seconds that reading all frames took; `None` before they were read.
    pub read_seconds: Option<f64>,
    /// Where the session was saved last.
    pub session_place: Option<PathBuf>,
    /// Whether the whole-capture work was stopped, by the person or as something could not be read.
    pub stopped: bool,
    /// The frame whose inspection failed last.
    pub failed_frame: Option<usize>,
    /// The frame last pruned with reasons.
    pub inspected: Option<Inspected>,
    /// When a setting was last changed that decides which samples stay; `None` where nothing waits for it to rest.
    pub changed_at: Option<Instant>,
    pub accuracy: Option<Accuracy>,
    /// What the last change of settings did.
    pub change: SettingsChange,
    pub source_shown: Option<ShownPicture<SourceKey, SourcePicture>>,
    pub motion: ViewMotion,
    /// The live picture that was painted last.
    pub live_shown: Option<ShownPicture<LiveKey, LivePicture>>,
    /// That picture carried to where the view is now, until a new one is painted.
    pub live_carried: Option<ShownCarried>,
    pub edits: SceneEdits,
    pub probe: InspectedPixel,
    /// Every camera small, in the capture's order; empty before the first.
    pub thumbs: Vec<TextureHandle>,
    /// What takes the memory, largest first; `None` before it was asked for.
    pub memory: Option<Vec<CameraMemory>>,
    /// The camera whose name in a legend is under the pointer.
    pub isolated: Option<usize>,
    /// The values that the live view showed in colors when it rested last; `None` before the panel of colors asked for them.
    pub values: Option<FrameValues>,
    /// The quantities that thresholds cut; empty before the first.
    pub histograms: Vec<ThresholdHistogram>,
    pub compared: Option<ShownComparison>,
    /// Why there is none.
    pub compare_error: Option<String>,
    /// Pictures of other programs, to be compared with; of the open scene.
    pub pictures: Vec<PictureFolder>,
    pub path: CameraPath,
    pub readings: ReadingCheck,
    pub charts: Charts,
    /// Views that were left by a jump.
    pub views: ViewHistory,
    pub kept_views: Vec<KeptView>,
    pub view_pictures: ViewPictures,
    /// The settings of the store that was saved last of the open capture, at first those that it was opened with.
    pub saved: Option<Settings>,
    /// The reported parts of the open store that could not be read.
    pub reported_damage: BTreeSet<String>,
}

impl Document {
    /// What is known of a scene that was just opened with `settings`.
    pub(crate) fn of(scene: Arc<OpenScene>, settings: &Settings) -> Self {
        let saved = scene.capture().map(|_| settings.clone());
        Self { scene: Some(scene), saved, ..Self::default() }
    }
}

/// Entries the log keeps.
const LOG: usize = 500;

/// What stands between the person and closing the window.
#[derive(Clone, Copy, Default)]
pub(crate) struct Closing {
    /// Whether the question before closing is open.
    pub asks: bool,
    /// Whether the window closes without another question.
    pub anyway: bool,
    /// Whether a file, pictures or a video are being written.
    pub writing: bool,
}

/// What the inspector knows.
#[derive(Default)]
pub(crate) struct Inspector {
    pub history: History,
    pub compare: CompareLook,
    pub palette: Option<CommandPalette>,
    pub help: Option<HelpPage>,
    /// The setting to scroll to, by its path.
    pub find_setting: Option<&'static str>,
    /// The adapter that draws the window; `None` without one.
    pub graphics: Option<String>,
    /// Bytes that the window's device has allocated on it when *About* was opened, where its driver says.
    pub graphics_memory: Option<u64>,
    /// What the program held in memory when it was asked for, by part, bytes.
    pub held_memory: Vec<(&'static str, u64)>,
    /// Whether the introduction of the first run was read.
    pub introduced: bool,
    /// Whether the sentence about the room that comes with the program was read.
    pub room_explained: bool,
    pub closing: Closing,
    pub log: VecDeque<LogLine>,
}

impl Inspector {
    /// Adds a line to the log.
    pub(crate) fn log(&mut self, kind: NoticeKind, text: String) {
        if self.log.len() == LOG {
            self.log.pop_front();
        }
        self.log.push_back(LogLine { at: Instant::now(), kind, text });
    }
}
