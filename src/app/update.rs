//! Carries out commands and takes in answers: the only place where the state changes.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use egui::{TextureFilter, TextureOptions};

use super::OverlookApp;
use super::command::Command;
use super::lanes::{FileRequest, OpenRequest};
use super::memory::remember_recent;
use super::message::{Message, Purpose};
use super::scene::{Content, Origin, Scene};
use super::state::{NoticeKind, Shown, TypedPath, Whole, method_of};
use super::text;
use super::views::rig::Rig;
use crate::capture::demo::DemoSpec;
use crate::error::Error;
use crate::settings::Settings;

/// A dialog that is answered faster than this was not seen by a person: there is none on this system.
const NO_DIALOG: Duration = Duration::from_millis(200);

/// Pixels of the recording are looked at one by one; those of the live view are only as fine as there are samples.
const SOURCE: (&str, TextureFilter) = ("source", TextureFilter::Nearest);
const LIVE: (&str, TextureFilter) = ("live", TextureFilter::Linear);

impl OverlookApp {
    /// Carries out one command.
    pub(super) fn apply(&mut self, command: Command) {
        match command {
            Command::OpenDemo(scene) => {
                self.open_demo(DemoSpec { scene, cameras: None, frames: None, size: None, noise: None });
            }
            Command::OpenPath(path) => self.open_path(path),
            Command::AskPath(purpose) => {
                self.asked_at = Some(Instant::now());
                self.lanes.dialog.submit(purpose);
            }
            Command::TypePath(purpose) => self.type_path(purpose, None),
            Command::TypedPath(text) => {
                if let Some(typed) = &mut self.state.typed_path {
                    typed.text = text;
                }
            }
            Command::TakeTypedPath => {
                if let Some(typed) = self.state.typed_path.take() {
                    self.take_path(typed.purpose, PathBuf::from(typed.text.trim()));
                }
            }
            Command::CloseTypedPath => self.state.typed_path = None,
            Command::ForgetRecent => self.state.recent.clear(),
            Command::Set { path, value } => self.set(path, value),
            Command::Reset(path) => {
                if let Some(value) = Settings::default().get(path) {
                    self.set(path, value);
                }
            }
            Command::ResetAll => self.change_settings(Settings::default()),
            Command::Rerun => {
                self.state.stopped = false;
                self.plan.forget_whole();
                self.plan.changed_at = None;
            }
            Command::Cancel => self.cancel(),
            Command::Escape => self.escape(),
            Command::Frame(_) | Command::Step(_) | Command::TogglePlay | Command::FramesPerSecond(_) => {
                self.apply_to_timeline(&command);
            }
            Command::Sidebar(sidebar) => self.state.sidebar = sidebar,
            Command::Dark(dark) => self.state.dark = dark,
            Command::Dismiss(id) => self.state.notices.retain(|notice| notice.id != id),
            looks => self.apply_to_views(looks),
        }
    }

    fn apply_to_timeline(&mut self, command: &Command) {
        let frames = self.state.frame_count();
        let timeline = &mut self.state.timeline;
        match *command {
            Command::Frame(frame) => timeline.frame = frame.min(frames.saturating_sub(1)),
            Command::Step(by) if frames > 0 => {
                timeline.frame = (timeline.frame as i64 + by).rem_euclid(frames as i64) as usize;
            }
            Command::TogglePlay => {
                timeline.playing = frames > 1 && !timeline.playing;
                timeline.elapsed_secs = 0.0;
            }
            Command::FramesPerSecond(rate) => timeline.frames_per_second = rate.clamp(1.0, 120.0),
            _ => {}
        }
    }

    fn apply_to_views(&mut self, command: Command) {
        let state = &mut self.state;
        match command {
            Command::SourceCamera(camera) => {
                if state.scene.as_ref().is_some_and(|scene| camera < scene.cameras.len()) {
                    state.source.camera = camera;
                    state.source.against = state.source.against.filter(|&against| against != camera);
                }
            }
            Command::Overlay(overlay) => state.source.overlay = overlay,
            Command::Against(against) => state.source.against = against,
            Command::SourceZoom { zoom, center } => {
                state.source.zoom = zoom.clamp(1.0, 64.0);
                state.source.center = center.clamp(egui::Vec2::ZERO, egui::Vec2::splat(1.0));
            }
            Command::JumpTo(index) => {
                if let Some(scene) = &state.scene
                    && let Some(camera) = scene.cameras.get(index)
                {
                    state.live.rig = Some(Rig::at_camera(scene, camera));
                }
            }
            Command::Home => {
                state.live.rig = state.scene.as_ref().and_then(|scene| Rig::home(scene));
                state.source.zoom = 1.0;
                state.source.center = egui::Vec2::splat(0.5);
            }
            Command::ColorBy(color_by) => state.live.color_by = color_by,
            Command::ShowCameras(show) => state.live.show_cameras = show,
            Command::LiveSize(size) => state.live.size = size,
            motion => {
                let Some(rig) = &mut state.live.rig else { return };
                match motion {
                    Command::Orbit(angles) => rig.orbit(angles),
                    Command::Pan(share) => rig.pan(share),
                    Command::Dolly(factor) => rig.dolly(factor),
                    Command::Fly(steps) => rig.fly(steps),
                    _ => {}
                }
            }
        }
    }

    /// Opens a built-in scene.
    pub(super) fn open_demo(&mut self, spec: DemoSpec) {
        self.state.opening = Some(text::words(&spec.scene));
        self.lanes.open.submit(OpenRequest::Demo { spec, settings: self.state.settings.capture.clone() });
    }

    /// Opens a capture or a store.
    pub(super) fn open_path(&mut self, path: PathBuf) {
        self.state.opening = Some(path.display().to_string());
        self.lanes.open.submit(OpenRequest::Path { path, settings: self.state.settings.capture.clone() });
    }

    fn type_path(&mut self, purpose: Purpose, reason: Option<&'static str>) {
        let text = match purpose {
            Purpose::SaveStore => format!("{}.ovl", self.state.scene.as_ref().map_or("capture", |s| &s.name)),
            Purpose::SaveSettings => "settings.toml".to_owned(),
            _ => String::new(),
        };
        self.state.typed_path = Some(TypedPath { purpose, text, reason });
    }

    fn take_path(&mut self, purpose: Purpose, path: PathBuf) {
        if path.as_os_str().is_empty() {
            return;
        }
        match purpose {
            Purpose::OpenFile | Purpose::OpenFolder => self.open_path(path),
            Purpose::SaveStore => self.save_store(path),
            Purpose::SaveSettings => {
                let settings = self.state.shown_settings();
                self.lanes.file.submit(FileRequest::SaveSettings { path, settings });
            }
            Purpose::LoadSettings => self.lanes.file.submit(FileRequest::LoadSettings { path }),
        }
    }

    fn save_store(&mut self, path: PathBuf) {
        let stale = self.state.is_stale();
        let content = self.state.scene.as_ref().map(|scene| &scene.content);
        let (samples, report) = match (content, &self.state.whole) {
            (Some(Content::Store { playback, .. }), _) => {
                let playback = playback.clone();
                self.lanes.file.submit(FileRequest::SaveAgain { path, playback });
                return;
            }
            (_, Some(whole)) if !stale => (whole.samples.clone(), whole.report.clone()),
            _ => {
                let text = "The whole capture is not pruned with these settings yet; rerun it, then save.";
                self.state.notify(NoticeKind::Warning, "Nothing to save yet", text);
                return;
            }
        };
        self.lanes.file.submit(FileRequest::SaveStore { path, samples, report });
    }

    fn set(&mut self, path: &'static str, value: toml::Value) {
        let mut settings = self.state.settings.clone();
        match settings.set(path, value) {
            Ok(()) => self.change_settings(settings),
            Err(error) => self.state.notify(NoticeKind::Error, "Setting not changed", error.to_string()),
        }
    }

    fn change_settings(&mut self, settings: Settings) {
        if method_of(&settings) != method_of(&self.state.settings) {
            self.plan.changed_at = Some(Instant::now());
            self.state.stopped = false;
        }
        self.state.settings = settings;
    }

    fn cancel(&mut self) {
        if !self.lanes.whole.is_idle() {
            self.state.stopped = true;
            self.plan.forget_whole();
        }
        self.lanes.whole.cancel();
        self.lanes.open.cancel();
        self.lanes.file.cancel();
        self.lanes.measure.cancel();
    }

    fn escape(&mut self) {
        if self.state.typed_path.take().is_none() && self.state.notices.pop().is_none() {
            self.cancel();
        }
    }

    /// Takes in one answer.
    pub(super) fn receive(&mut self, message: Message, ctx: &egui::Context) {
        let current = self.state.scene.as_ref().map(|scene| scene.id);
        match message {
            Message::Opened(scene) => self.opened(scene),
            Message::Scanned { scene, scan } if Some(scene) == current => self.state.scan = Some(scan),
            Message::Pruned { scene, settings, result } if Some(scene) == current => {
                self.state.accuracy = None;
                self.state.whole = Some(Whole {
                    samples: result.samples.clone(),
                    report: Arc::new(result.report.clone()),
                    settings,
                });
            }
            Message::Inspected { scene, inspected } if Some(scene) == current => {
                self.state.inspected = Some(inspected);
            }
            Message::SourcePainted { key, picture } if Some(key.scene) == current => {
                let texture = texture(ctx, SOURCE, &picture.image, self.state.source_shown.take());
                self.state.source_shown = Some(Shown { key, picture, texture });
            }
            Message::LivePainted { key, picture } if Some(key.scene) == current => {
                let texture = texture(ctx, LIVE, &picture.image, self.state.live_shown.take());
                self.state.live_shown = Some(Shown { key, picture, texture });
            }
            Message::Measured { scene, settings, accuracy }
                if Some(scene) == current && settings == self.state.settings =>
            {
                self.state.accuracy = accuracy;
            }
            Message::Saved { path, bytes } => self.saved(&path, bytes),
            Message::SettingsLoaded { path, settings } => {
                self.change_settings(settings);
                self.state.notify(NoticeKind::Done, "Settings loaded", path.display().to_string());
            }
            Message::PathChosen { purpose, path } => self.path_chosen(purpose, path),
            Message::Failed { what, error } => self.failed(what, &error),
            // An answer about a scene that is no longer open.
            _ => {}
        }
    }

    fn opened(&mut self, scene: Arc<Scene>) {
        let state = &mut self.state;
        if let Origin::Path(path) = &scene.origin {
            remember_recent(&mut state.recent, path);
        }
        state.opening = None;
        state.scan = None;
        state.whole = None;
        state.stopped = false;
        state.inspected = None;
        state.accuracy = None;
        state.source_shown = None;
        state.live_shown = None;
        state.timeline.frame = 0;
        state.timeline.playing = false;
        state.source.camera = 0;
        state.source.against = None;
        state.source.zoom = 1.0;
        state.source.center = egui::Vec2::splat(0.5);
        state.live.rig = Rig::home(&scene);
        state.notices.retain(|notice| notice.kind != NoticeKind::Error);
        if let Some(capture) = scene.capture() {
            for warning in &capture.warnings {
                state.notify(NoticeKind::Warning, "While opening", warning.clone());
            }
        }
        if let Some(playback) = scene.playback() {
            for damage in playback.store().info().warnings.iter().chain(&playback.store().damage()) {
                state.notify(NoticeKind::Warning, "While opening", damage.clone());
            }
        }
        state.scene = Some(scene);
        self.lanes.whole.cancel();
        self.plan = super::plan::Plan::default();
    }

    fn saved(&mut self, path: &Path, bytes: Option<u64>) {
        let place = path.display();
        let text = match bytes {
            Some(bytes) => {
                remember_recent(&mut self.state.recent, path);
                format!("{place} ({})", text::bytes(bytes))
            }
            None => place.to_string(),
        };
        self.state.notify(NoticeKind::Done, "Saved", text);
    }

    fn path_chosen(&mut self, purpose: Purpose, path: Option<PathBuf>) {
        let asked_at = self.asked_at.take();
        match path {
            Some(path) => self.take_path(purpose, path),
            None if asked_at.is_some_and(|at| at.elapsed() < NO_DIALOG) => {
                self.type_path(purpose, Some("This system offers no file dialog; type the path instead."));
            }
            None => {}
        }
    }

    fn failed(&mut self, what: &'static str, error: &Error) {
        if what == "Open" {
            self.state.opening = None;
        }
        if matches!(error, Error::Cancelled) {
            return;
        }
        if what == "Prune" {
            self.state.stopped = true;
        }
        let title = match what {
            "Open" => "Could not open",
            "Prune" => "Could not prune the capture",
            "Inspect frame" => "Could not read this frame",
            "Source picture" => "Could not show this frame",
            "Live view" => "Could not render this view",
            "File" => "Could not save or load",
            other => other,
        };
        self.state.notify(NoticeKind::Error, title, error.to_string());
    }
}

/// Uploads a picture: into the texture of the one it replaces, where there is one.
fn texture<K, P>(
    ctx: &egui::Context,
    (name, magnification): (&str, TextureFilter),
    image: &Arc<egui::ColorImage>,
    replaced: Option<Shown<K, P>>,
) -> egui::TextureHandle {
    let options = TextureOptions { magnification, minification: TextureFilter::Linear, ..Default::default() };
    match replaced {
        Some(Shown { mut texture, .. }) => {
            texture.set(image.clone(), options);
            texture
        }
        None => ctx.load_texture(name, image.clone(), options),
    }
}
