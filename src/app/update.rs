//! Carries out commands. Here and where answers are taken in is the only place where the state changes.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use super::OverlookApp;
use super::command::Command;
use super::dock::Dock;
use super::inspector::path::Target;
use super::lanes::{FileRequest, OpenRequest};
use super::message::Purpose;
use super::scene::Content;
use super::state::{NoticeKind, TypedPath, Work, method_of};
use super::text;
use super::views::rig::Rig;
use crate::capture::demo::DemoSpec;
use crate::settings::Settings;

impl OverlookApp {
    /// Carries out one command.
    pub(super) fn apply(&mut self, command: Command) {
        self.state.timeline.will_play &= leaves_time_alone(&command);
        match command {
            Command::OpenDemo(scene) => {
                self.open_demo(DemoSpec { scene, cameras: None, frames: None, size: None, noise: None });
            }
            Command::OpenPath(path) => self.open_path(path),
            // Before a path is chosen for nothing.
            Command::AskPath(purpose) | Command::TypePath(purpose) if self.refuses(purpose) => {}
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
            Command::ResetAll => self.change_settings("all", Settings::default()),
            Command::Preset(_)
            | Command::OwnPreset(_)
            | Command::NamePreset(_)
            | Command::SavePreset(_)
            | Command::RemovePreset(_) => self.apply_to_presets(command),
            Command::Undo | Command::Redo | Command::SwitchSettings => self.apply_to_history(&command),
            Command::Rerun => {
                self.state.stopped = false;
                self.state.failed_frame = None;
                self.plan.forget_frame();
                self.plan.forget_whole();
                self.plan.forget_accuracy();
                self.plan.changed_at = None;
            }
            Command::Cancel => self.cancel(),
            Command::Escape => self.escape(),
            Command::Frame(_) | Command::Step(_) | Command::TogglePlay | Command::FramesPerSecond(_) => {
                self.apply_to_timeline(&command);
            }
            Command::OpenView(view) => self.dock.open(view),
            Command::ResetLayout => self.dock = Dock::new(),
            Command::Dark(dark) => self.state.dark = dark,
            Command::Dismiss(id) => self.state.notices.retain(|notice| notice.id != id),
            other => {
                if let Some(looks) = self.apply_to_inspector(other) {
                    self.apply_to_views(looks);
                }
            }
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
                    Command::DollyTo { factor, point_in_world } => rig.dolly_to(factor, point_in_world),
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
        let path = lasting(path);
        self.state.opening = Some(path.display().to_string());
        self.lanes.open.submit(OpenRequest::Path { path, settings: self.state.settings.capture.clone() });
    }

    pub(super) fn type_path(&mut self, purpose: Purpose, reason: Option<&'static str>) {
        let text = match purpose {
            Purpose::SaveStore => format!("{}.ovl", self.state.scene.as_ref().map_or("capture", |s| &s.name)),
            Purpose::SaveSettings => "settings.toml".to_owned(),
            Purpose::SavePicture => "picture.png".to_owned(),
            Purpose::ExportPictures => "pictures".to_owned(),
            Purpose::ExportFilm => "film.mp4".to_owned(),
            _ => String::new(),
        };
        self.state.typed_path = Some(TypedPath { purpose, text, reason });
    }

    pub(super) fn take_path(&mut self, purpose: Purpose, path: PathBuf) {
        if path.as_os_str().is_empty() {
            return;
        }
        let path = lasting(path);
        match purpose {
            Purpose::OpenFile | Purpose::OpenFolder => self.open_path(path),
            Purpose::SaveStore => self.save_store(path),
            Purpose::SaveSettings => {
                let settings = self.state.shown_settings();
                self.lanes.file.submit(FileRequest::SaveSettings { path, settings });
            }
            Purpose::LoadSettings => self.lanes.file.submit(FileRequest::LoadSettings { path }),
            Purpose::SavePicture => {
                let rendered = self.state.live_shown.as_ref().and_then(|shown| shown.picture.rendered());
                match rendered.cloned() {
                    Some(picture) => self.lanes.file.submit(FileRequest::SavePicture { path, picture }),
                    None => self.tell_of_motion(),
                }
            }
            Purpose::ExportPictures => self.export_path(Target::Pictures(path)),
            Purpose::ExportFilm => {
                let rate = f64::from(self.state.timeline.frames_per_second);
                self.export_path(Target::Film(path, rate));
            }
        }
    }

    fn save_store(&mut self, path: PathBuf) {
        if self.refuses(Purpose::SaveStore) {
            return;
        }
        let Some(scene) = &self.state.scene else { return };
        if let Content::Store { playback, .. } = &scene.content {
            self.lanes.file.submit(FileRequest::SaveAgain { path, playback: playback.clone() });
        } else if let Some(whole) = &self.state.whole {
            // How it is painted may have changed since; whoever opens it paints it as it was seen here.
            let mut samples = (*whole.samples).clone();
            samples.settings.render = self.state.settings.render.clone();
            let (scene, samples, report) = (scene.clone(), Arc::new(samples), whole.report.clone());
            self.lanes.file.submit(FileRequest::SaveStore { path, scene, samples, report });
        }
    }

    /// Whether there is nothing yet that a file of this purpose could hold; says so.
    pub(super) fn refuses(&mut self, purpose: Purpose) -> bool {
        let title = match purpose {
            Purpose::SaveStore => "Nothing to save yet",
            Purpose::ExportPictures | Purpose::ExportFilm => "Nothing to export yet",
            _ => return false,
        };
        let ready = self.state.is_whole_ready();
        if !ready {
            let text = if self.state.scene.is_none() {
                "Open a capture or a store first."
            } else if self.state.stopped {
                "The whole capture is not pruned with these settings; rerun it (below), then try again."
            } else {
                "The whole capture is not pruned with these settings yet; try again once the line at the bottom is done."
            };
            self.state.notify(NoticeKind::Warning, title, text);
        }
        !ready
    }

    fn set(&mut self, path: &'static str, value: toml::Value) {
        let mut settings = self.state.settings.clone();
        match settings.set(path, value) {
            Ok(()) => self.change_settings(path, settings),
            Err(error) => self.state.notify(NoticeKind::Error, "Setting not changed", error.to_string()),
        }
    }

    /// Changes settings; `what` tells one change from the next.
    pub(super) fn change_settings(&mut self, what: &'static str, settings: Settings) {
        if settings != self.state.settings {
            self.state.inspector.history.record(&self.state.settings, what, Instant::now());
            self.put_settings(settings);
        }
    }

    pub(super) fn put_settings(&mut self, settings: Settings) {
        if method_of(&settings) != method_of(&self.state.settings) {
            self.state.inspector.unsaved = self.state.has_capture();
            self.plan.changed_at = Some(Instant::now());
            self.state.stopped = false;
            self.state.failed_frame = None;
        }
        if settings.render != self.state.settings.render {
            // It was that of pictures painted otherwise.
            self.state.accuracy = None;
        }
        if self.state.accuracy.is_none() {
            self.plan.forget_accuracy();
        }
        self.state.settings = settings;
    }

    /// Stops the work that the line at the bottom names, and nothing beside it.
    fn cancel(&mut self) {
        let Some(work) = self.state.busy.first().map(|busy| busy.work) else { return };
        let lanes = &self.lanes;
        match work {
            Work::Open => lanes.open.cancel(),
            Work::Whole => {
                lanes.whole.cancel();
                if !self.state.is_whole_ready() {
                    self.state.stopped = true;
                    self.plan.forget_whole();
                }
            }
            Work::File => lanes.file.cancel(),
            Work::Export => lanes.inspector.export.cancel(),
            Work::Study => lanes.inspector.study.cancel(),
            Work::Compare => {
                lanes.inspector.compare.cancel();
                let text = "It was stopped; choose what to compare again.";
                self.state.inspector.compare_trouble = Some(text.to_owned());
            }
            Work::Measure => lanes.measure.cancel(),
        }
        self.take_stock();
    }

    fn escape(&mut self) {
        let inspector = &mut self.state.inspector;
        let was_open = inspector.palette.take().is_some()
            | inspector.naming.take().is_some()
            | inspector.cheat_sheet
            | inspector.closing.asks;
        (inspector.cheat_sheet, inspector.closing.asks) = (false, false);
        if was_open || self.state.typed_path.take().is_some() || self.state.notices.pop().is_some() {
            return;
        }
        if self.state.inspector.path.playing.take().is_some() {
            return;
        }
        if self.state.inspector.probe.pinned {
            self.apply(Command::Pin(false));
        } else {
            self.cancel();
        }
    }
}

/// A path that means the same from whatever folder the window is started next time.
fn lasting(path: PathBuf) -> PathBuf {
    std::path::absolute(&path).unwrap_or(path)
}

/// Whether a command only looks around, so that a scene that was about to move still may.
fn leaves_time_alone(command: &Command) -> bool {
    matches!(
        command,
        Command::Probe(_)
            | Command::LiveSize(_)
            | Command::Orbit(_)
            | Command::Pan(_)
            | Command::Dolly(_)
            | Command::DollyTo { .. }
            | Command::Fly(_)
            | Command::JumpTo(_)
            | Command::Home
            | Command::ColorBy(_)
            | Command::ShowCameras(_)
            | Command::Callout(_)
            | Command::Dark(_)
    )
}
