//! Takes in the answers of the workers.

use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use egui::TextureOptions;

use crate::app::control::overlook_app::OverlookApp;
use crate::app::model;
use crate::app::model::{
    Accuracy, Message, OpenScene, SceneSource, ShownPicture, SourceLook, State, Texture, Whole, WorkKind,
    method_of,
};
use crate::app::rooms::colors::model::Display;
use crate::app::rooms::edits::model::SceneEdits;
use crate::app::rooms::files::control::remembered::remember_recent;
use crate::app::rooms::frame::model::{DockView, NoticeKind, NoticeLink};
use crate::app::rooms::live::model::{
    CarriedLook, LiveKey, LivePicture, OrbitCamera, PixelSource, Ruler, ShownCameras, ShownCarried, Unit,
};
use crate::app::rooms::pixel::model::{Probed, Spot};
use crate::app::rooms::readings::model::ReadingCheck;
use crate::app::rooms::settings::model::SettingPairs;
use crate::app::rooms::share::model::{SharePreview, ShownPreview};
use overlook_engine::capture::Camera;
use overlook_engine::error::Error;
use overlook_engine::plural::{counted, either};
use overlook_engine::preprocess::diagnostics::Suspect;
use overlook_engine::preprocess::{PreparedScan, Preprocessed};
use overlook_engine::settings::Settings;

impl OverlookApp {
    /// Takes in a live picture. If the view has moved on, what is shown stays until this picture is carried to where the view is: it
    /// would jump back.
    fn live_painted(&mut self, key: LiveKey, picture: Arc<LivePicture>) {
        let state = &mut self.state;
        state.report_damage(&picture.damage);
        self.scheduler.live.painted(&key, &picture, state);
        if state.timeline.playing {
            state.timeline.shown.add(key.vantage.frame, Instant::now());
        }
        let is_behind = !state.looks_from(&key.vantage.camera);
        let carried = state.live_carried.take().filter(|_| is_behind && picture.rendered().is_some());
        if carried.is_some() && self.scheduler.live.is_late(&key) {
            state.live_carried = carried;
            return;
        }
        let texture = match (carried.is_some(), state.live_shown.take()) {
            (true, Some(shown)) => Some(shown.texture),
            (_, shown) => self.texture_of(&picture, shown.map(|shown| shown.texture)),
        };
        self.state.live_carried = carried;
        self.state.live_shown = texture.map(|texture| ShownPicture { key, picture, texture });
    }

    /// Takes in the live picture as `camera` sees it, unless that was painted in the meantime.
    fn live_carried(&mut self, camera: &Camera, carried: Option<CarriedLook>) {
        let state = &mut self.state;
        let is_painted =
            state.live_shown.as_ref().is_none_or(|shown| state.looks_from(&shown.key.vantage.camera));
        let Some(CarriedLook { image, inverse_depth }) = carried.filter(|_| !is_painted) else { return };
        let replaced = state.live_carried.take().map(|carried| carried.texture);
        let texture = Texture::send(&self.ctx, "carried", options_of(image.size, state), &image, replaced);
        state.live_carried = Some(ShownCarried { camera: camera.clone(), inverse_depth, texture });
    }

    /// The texture that shows a picture of the live view; `None` if it is on the GPU and the window does not draw with one.
    fn texture_of(&self, picture: &LivePicture, replaced: Option<Texture>) -> Option<Texture> {
        match &picture.pixels {
            PixelSource::InMemory { image, .. } => {
                let options = options_of(image.size, &self.state);
                Some(Texture::send(&self.ctx, "live", options, image, replaced))
            }
            PixelSource::OnAdapter(painted) => {
                let options =
                    options_of([painted.width(), painted.height()].map(|side| side as usize), &self.state);
                Some(Texture::painted(self.window.as_ref()?, options, painted, replaced))
            }
        }
    }

    /// Takes in one answer, unless it is about a scene that is no longer open.
    pub(crate) fn receive(&mut self, message: Message) {
        let current = self.state.scene.as_ref().map(|scene| scene.id);
        if message.scene().is_some_and(|scene| Some(scene) != current) {
            return;
        }
        let Self { state, ctx, .. } = self;
        match message {
            Message::Opened(scene) => self.opened(&scene),
            Message::Scanned { scan, .. } => self.scanned(scan),
            Message::Pruned { settings, result, .. } => self.pruned(settings, &result),
            Message::Inspected { inspected, .. } => {
                state.inspected = Some(inspected);
                state.failed_frame = None;
            }
            Message::SourcePainted { key, picture } => {
                let replaced = state.source_shown.take().map(|shown| shown.texture);
                // The source view shows single pixels sharply; the live view is interpolated.
                let texture = Texture::send(ctx, "source", Texture::PIXELS, &picture.image, replaced);
                state.source_shown = Some(ShownPicture { key, picture, texture });
            }
            Message::LivePainted { key, picture } => self.live_painted(key, picture),
            Message::LiveCarried { carried, key } => self.live_carried(&key.to, carried),
            Message::Measured { settings, accuracy, .. } => self.measured(&settings, accuracy),
            Message::Probed { spot, probed, is_hole, .. } => self.probed(spot, probed, is_hole),
            Message::Thumbnails { pictures, .. } => {
                let textures =
                    pictures.into_iter().map(|it| ctx.load_texture("thumbnail", it, TextureOptions::LINEAR));
                state.inspector.thumbs = textures.collect();
            }
            Message::Histograms { histograms, .. } => state.inspector.histograms = histograms,
            Message::Compared { key, outcome } => self.compared(&key, outcome),
            Message::MemoryMapped { cameras, .. } => state.inspector.memory = Some(cameras),
            Message::Saved { path, bytes, holds } => self.saved(&path, bytes, holds),
            Message::Swept { point, known, .. } => state.inspector.charts.add(*point, known),
            Message::Stressed { point, known, .. } => state.inspector.charts.add_stressed(*point, known),
            Message::Studied { left, .. } => self.studied(left),
            Message::FigureDrawn { image, width_mm } => self.figure_drawn(image, width_mm),
            Message::Exported { path, exported } => self.exported(&path, &exported),
            Message::PathSaved { path, saved } => self.path_saved(&path, saved),
            Message::PathLoaded { path, views, .. } => self.path_loaded(&path, &views),
            Message::PicturesOpened { folder, .. } => self.pictures_opened(folder),
            Message::Edited { key, edited } => self.edited(*key, edited),
            Message::EditsSaved { path, list } => self.edits_saved(&path, list),
            Message::EditsLoaded { path, list, .. } => self.edits_loaded(&path, list),
            Message::SettingsLoaded { path, settings } => self.settings_loaded(&path, settings),
            Message::PathChosen { purpose, path } => self.path_chosen(purpose, path),
            Message::DestinationChecked { destination, taken } => {
                self.destination_checked(&destination, taken);
            }
            Message::ReadingsChecked { finding, .. } => self.readings_checked(finding),
            Message::ReadingsShown { images, .. } => self.readings_shown(images),
            Message::Stopped { title, text } => self.stopped_writing(title, text),
            Message::SizesMeasured { facts, .. } => state.share.facts = Some(facts),
            Message::SharePreviewed { key, preview } => {
                let replaced = state.share.preview.take().and_then(|shown| shown.picture);
                let picture = preview.map(|SharePreview { image, decibels }| {
                    let replaced = replaced.map(|(texture, _)| texture);
                    (Texture::send(ctx, "preview", TextureOptions::LINEAR, &image, replaced), decibels)
                });
                state.share.preview = Some(ShownPreview { key, picture });
            }
            Message::Failed { work, error } => self.failed(work, &error),
            // Nobody sees it, or the system shows it.
            Message::Prepared | Message::FolderShown => {}
        }
    }

    fn scanned(&mut self, scan: Arc<PreparedScan>) {
        let settings = &self.state.settings;
        // Its settings were taken back, and the scan for the settings on the sliders is here already.
        let late =
            !scan.serves(settings) && self.state.scan.as_ref().is_some_and(|scan| scan.serves(settings));
        if !late {
            self.state.scan = Some(scan);
        }
    }

    fn pruned(&mut self, settings: Settings, result: &Preprocessed) {
        let state = &mut self.state;
        // As above.
        if state.is_whole_ready() && method_of(&settings) != method_of(&state.settings) {
            return;
        }
        let report = &result.report;
        for (suspect, warning) in report.suspects() {
            // A notice of its own reports that another reading fits better.
            let is_told = suspect == Suspect::Depth && report.conventions.is_some();
            if is_told && state.why_no_readings().is_none() {
                continue;
            }
            let title = format!("Check the capture: {}", suspect.name().to_lowercase());
            state.warn_with_link(title, model::sentence(&warning), NoticeLink::View(DockView::Matrix));
        }
        let line = format!(
            "Pruned the capture: {} of {} kept in {} s",
            model::count(report.samples_kept),
            model::count_of(report.samples_in, "sample"),
            model::significant(report.seconds)
        );
        state.inspector.log(NoticeKind::Done, line);
        state.accuracy = None;
        let (samples, report) = (result.samples.clone(), Arc::new(report.clone()));
        state.whole = Some(Whole { samples, report, settings });
    }

    fn measured(&mut self, settings: &Settings, accuracy: Option<Accuracy>) {
        if *settings != self.state.settings {
            return;
        }
        self.state.accuracy = accuracy;
    }

    fn settings_loaded(&mut self, path: &Path, settings: Settings) {
        self.change_settings(settings);
        let text = if self.state.has_thresholds() {
            path.display().to_string()
        } else {
            "Rendering settings were applied; the others apply to captures opened from now on.".to_owned()
        };
        self.state.notify(NoticeKind::Done, "Settings loaded", text);
    }

    fn probed(&mut self, spot: Spot, probed: Option<Arc<Probed>>, is_hole: bool) {
        let probe = &mut self.state.inspector.probe;
        // An answer about a spot that the pointer has left is better than none while the next is on its way.
        if probe.spot.is_none() {
            return;
        }
        let is_kept = probe.pinned && probe.spot == Some(spot) && matches!(spot, Spot::Live { .. });
        match &probed {
            Some(probed) if is_kept => {
                probe.spot = Some(Spot::Source { camera: probed.camera, x: probed.x, y: probed.y });
            }
            // A hole cannot be pinned: a sample that appears there later is another pixel.
            None if is_kept && is_hole => (probe.pinned, probe.spot) = (false, None),
            _ => {}
        }
        probe.shown = probed;
    }

    fn opened(&mut self, scene: &Arc<OpenScene>) {
        self.state.remember_picture();
        self.forget_closed_scene(scene);
        self.state.scene = Some(scene.clone());
        self.show_source_where_there_is_one();
        self.notify_of_opened(scene);
        // Work for the closed scene stops, except for files that are being written.
        self.workers.whole.cancel();
        self.workers.measure.cancel();
        self.workers.study.cancel();
        self.workers.compare.cancel();
        self.workers.readings.cancel();
        self.scheduler = crate::app::work::Scheduler::default();
        if let Some(session) = &scene.session {
            self.take_session(session, scene);
        }
        self.go_to_opened_address(scene);
        let plays_once_open = std::mem::take(&mut self.state.timeline.plays_once_open);
        self.state.timeline.playing |= plays_once_open && scene.frame_count() > 1;
    }

    /// Puts back to its start what belonged to the scene before `scene`.
    fn forget_closed_scene(&mut self, scene: &Arc<OpenScene>) {
        let state = &mut self.state;
        if let SceneSource::Path(path) = &scene.origin {
            remember_recent(&mut state.recent, path);
        }
        if self.workers.open.is_idle() {
            state.opening = None;
        }
        state.scan = None;
        state.whole = None;
        state.stopped = false;
        state.failed_frame = None;
        state.inspected = None;
        state.accuracy = None;
        if !scene.is_reread {
            state.inspector.readings = ReadingCheck::default();
        }
        state.inspector.close_scene();
        state.share.close_scene();
        state.edits = SceneEdits::default();
        state.source_shown = None;
        (state.live_shown, state.live_carried) = (None, None);
        state.timeline.frame = 0;
        state.timeline.playing = false;
        state.timeline.range = None;
        state.timeline.markers.clear();
        state.live.cameras = ShownCameras::default();
        state.live.ruler = Ruler::default();
        state.live.unit = Unit::default();
        state.live.up = None;
        state.display = Display::default();
        state.source = SourceLook { overlay: state.source.overlay, ..SourceLook::default() };
        state.live.orbit = OrbitCamera::home(scene, scene.up_in_world);
        state.inspector.saved = scene.capture().map(|_| state.settings.clone());
        state.notices.retain(|notice| notice.kind != NoticeKind::Error && notice.scene.is_none());
    }

    /// Reports warnings about a scene that was opened, and settings that differ from the defaults.
    fn notify_of_opened(&mut self, scene: &OpenScene) {
        let state = &mut self.state;
        for warning in scene.capture().iter().flat_map(|capture| &capture.warnings) {
            state.warn_of_scene("While opening", warning.clone());
        }
        if let Some(playback) = scene.playback() {
            for warning in &playback.store().info().warnings {
                state.warn_of_scene("While opening", warning.clone());
            }
            state.report_damage(&playback.store().damage());
        }
        let changed = SettingPairs::new(&state.settings, &Settings::default()).differing().count();
        if changed > 0 && scene.capture().is_some() {
            let text = format!(
                "{} {} from the defaults, as set before; Reset all in the Settings view takes the defaults.",
                counted(changed, "setting"),
                either(changed, "differs", "differ")
            );
            state.notify_with_link("Settings were kept", text, DockView::Thresholds);
        }
        state.inspector.log(NoticeKind::Done, format!("Opened {}", scene.name));
    }

    /// Updates whether something is being opened or measured: superseded work sends no message of its end.
    pub(crate) fn refresh_busy(&mut self) {
        if self.workers.open.is_idle() {
            self.state.opening = None;
        }
        self.state.inspector.charts.studying = !self.workers.study.is_idle();
    }

    fn saved(&mut self, path: &Path, bytes: Option<u64>, holds: Option<(u64, Settings)>) {
        // Thresholds may have been changed while it was written, and another capture opened.
        let scene = self.state.scene.as_ref().map(|scene| scene.id);
        if let Some((_, settings)) = holds.filter(|(of, _)| Some(*of) == scene) {
            self.state.inspector.saved = Some(settings);
        }
        if bytes.is_some() {
            remember_recent(&mut self.state.recent, path);
        }
        let place = path.display();
        let (said, text) = match bytes.map(model::bytes) {
            Some(size) => (format!("a store of {size}"), format!("{place} ({size})")),
            None => ("saved".to_owned(), place.to_string()),
        };
        self.written("Saved", path, &said, text);
    }

    fn failed(&mut self, work: WorkKind, error: &Error) {
        if matches!(work, WorkKind::Open | WorkKind::Study) {
            self.refresh_busy();
        }
        if matches!(error, Error::Cancelled) {
            if work == WorkKind::Study {
                self.notify_stopped_study();
            }
            return;
        }
        match work {
            WorkKind::Prune if self.workers.whole.is_idle() => self.state.stopped = true,
            WorkKind::InspectFrame if self.workers.inspect.is_idle() => {
                self.state.failed_frame = self.scheduler.inspect.as_ref().map(|key| key.frame);
                // Nothing goes on from here by itself.
                self.state.stopped |= self.state.inspected.is_none();
            }
            _ => {}
        }
        if !self.failed_in_dialog(work, error) {
            self.state.notify_of_failure(work.failure(), error);
        }
        self.type_again(work, error);
    }
}

/// How a live picture is magnified: not at all where it has the pixels of its view, which costs a processor that draws the least.
fn options_of(size: [usize; 2], state: &State) -> TextureOptions {
    let fits = size.map(|side| side as u32) == state.live.size;
    if fits { TextureOptions::NEAREST } else { TextureOptions::LINEAR }
}
