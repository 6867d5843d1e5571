//! Carries out commands. Here and where answers are taken in is the only place where the state changes.

use std::path::Path;

use crate::address;
use crate::app::control::overlook_app::OverlookApp;
use crate::app::model;
use crate::app::model::{Command, StoppableWork};
use crate::app::rooms::files::control::path_names::lasting;
use crate::app::rooms::files::model::{Destination, Purpose};
use crate::app::rooms::live::model::{HoleDisplay, OrbitCamera, ViewCommand, ViewHistory};
use crate::app::rooms::source::model::PictureZoom;
use crate::app::rooms::timeline::model::ShownRate;
use crate::app::work::OpenRequest;
use overlook_engine::demo::DemoSpec;
use overlook_engine::settings::{Fill, RenderSettings};

impl OverlookApp {
    /// Carries out one command.
    pub(crate) fn apply(&mut self, command: Command) {
        self.state.timeline.plays_once_open &= only_looks(&command);
        let left = ViewHistory::is_jump(&command).then(|| self.state.live.orbit.clone()).flatten();
        let rest = self
            .apply_to_typed_path(command)
            .and_then(|command| self.apply_to_edits(command))
            .and_then(|command| self.apply_to_settings(command))
            .and_then(|command| self.apply_to_timeline(command))
            .and_then(|command| self.apply_to_inspector(command))
            .and_then(|command| self.apply_to_path(command))
            .and_then(|command| self.apply_to_readings(command))
            .and_then(|command| self.apply_to_share(command))
            .and_then(|command| self.apply_to_window(command))
            .and_then(|command| self.apply_to_view(command))
            .and_then(|command| self.apply_to_views(command));
        match rest {
            Some(
                command @ (Command::OpenDemo(_)
                | Command::OpenRoom
                | Command::OpenPath(_)
                | Command::OpenReading(_)),
            ) => {
                self.ask_to_open(command);
            }
            Some(Command::ForgetRecent) => {
                self.state.recent.clear();
                self.state.recent_pictures.clear();
            }
            Some(Command::Recompute) => {
                self.state.stopped = false;
                self.state.failed_frame = None;
                (self.scheduler.inspect, self.scheduler.source) = (None, None);
                (self.scheduler.whole, self.scheduler.measure) = (None, None);
                self.scheduler.changed_at = None;
            }
            Some(Command::Cancel) => self.cancel(),
            Some(Command::Escape) => self.escape(),
            Some(Command::InterfaceSize(step)) => match step {
                0 => self.ctx.set_zoom_factor(1.0),
                step if step > 0 => egui::gui_zoom::zoom_in(&self.ctx),
                _ => egui::gui_zoom::zoom_out(&self.ctx),
            },
            Some(Command::Display(display)) => self.state.display = display,
            Some(Command::LiveArea(area)) => self.state.live.area = area,
            Some(Command::Dark(dark)) => self.state.dark = dark,
            Some(Command::Holes(holes)) => self.show_holes(holes),
            Some(Command::Dismiss(id)) => self.state.notices.retain(|notice| notice.id != id),
            _ => {}
        }
        if let Some(left) = left.filter(|left| self.state.live.orbit.as_ref() != Some(left)) {
            self.state.inspector.views.left(left);
        }
        // Whichever camera or key the view was taken to, what is up stays.
        let up = self.state.up_in_world();
        if let Some(orbit) = &mut self.state.live.orbit {
            orbit.set_up(up);
        }
    }

    fn apply_to_timeline(&mut self, command: Command) -> Option<Command> {
        let frames = self.state.frame_count();
        let timeline = &mut self.state.timeline;
        match command {
            Command::Frame(frame) => timeline.frame = frame.min(frames.saturating_sub(1)),
            Command::Step(by) if frames > 0 => {
                timeline.frame = (timeline.frame as i64 + by).rem_euclid(frames as i64) as usize;
            }
            Command::TogglePlay => {
                timeline.playing = frames > 1 && !timeline.playing;
                timeline.elapsed_secs = 0.0;
                timeline.shown = ShownRate::default();
            }
            Command::LoopRange(range) => timeline.range = range,
            Command::ToggleMarker if frames > 0 => timeline.toggle_marker(),
            Command::ToMarker(forward) => timeline.frame = timeline.marker(forward).unwrap_or(timeline.frame),
            Command::PingPong(on) => (timeline.ping_pong, timeline.backward) = (on, false),
            Command::FramesPerSecond(rate) => timeline.frames_per_second = rate.clamp(1.0, 120.0),
            other => return Some(other),
        }
        None
    }

    fn apply_to_views(&mut self, command: Command) -> Option<Command> {
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
            Command::SourceZoom(part) => state.source.part = part,
            Command::JumpTo(index) => {
                if let Some(scene) = &state.scene
                    && let Some(camera) = scene.cameras.get(index)
                {
                    state.live.orbit = Some(OrbitCamera::at_camera(scene, camera));
                }
            }
            Command::Home => {
                let up = state.up_in_world();
                state.live.orbit = state.scene.as_ref().and_then(|scene| OrbitCamera::home(scene, up));
                state.source.part = PictureZoom::default();
            }
            Command::ColorBy(color_by) => state.live.color_by = color_by,
            Command::ShowCameras(show) => state.live.show_cameras = show,
            Command::LiveSize(size) => state.live.size = size,
            motion => {
                let Some(orbit) = &mut state.live.orbit else { return Some(motion) };
                match motion {
                    Command::Orbit(angles) => orbit.orbit(angles),
                    Command::Pan(share) => orbit.pan(share),
                    Command::Dolly(factor) => orbit.dolly(factor),
                    Command::DollyTo { factor, point_in_world } => orbit.dolly_to(factor, point_in_world),
                    Command::Fly(steps) => orbit.fly(steps),
                    other => return Some(other),
                }
            }
        }
        None
    }

    /// Shows holes filled or hatched; to be shown filled, they must be filled by the settings too.
    fn show_holes(&mut self, holes: HoleDisplay) {
        self.state.live.holes = holes;
        let mut settings = self.state.settings.clone();
        if holes == HoleDisplay::Filled && settings.render.fill == Fill::None {
            settings.render.fill = RenderSettings::default().fill;
            self.change_settings(settings);
        }
    }

    /// Opens something, after a question where a camera path or measured points are lost by it.
    fn ask_to_open(&mut self, command: Command) {
        match command {
            _ if self.state.unsaved_work().is_none() => self.open(command),
            // First whether there is anything: nobody should give up work for a path that does not exist.
            Command::OpenPath(path) => {
                let path = lasting(path);
                self.workers.check.submit(Destination { purpose: Purpose::OpenFile, path });
            }
            command => self.state.open_after_question = Some(command),
        }
    }

    pub(crate) fn open(&mut self, command: Command) {
        match command {
            Command::OpenDemo(scene) => {
                self.open_demo(DemoSpec::new(scene));
            }
            Command::OpenRoom => self.open_room(),
            Command::OpenPath(path) => self.open_path(&path),
            Command::OpenReading(otherwise) => self.open_reading(otherwise),
            _ => {}
        }
    }

    /// Closes, or opens something else, without another question.
    pub(crate) fn go_on_anyway(&mut self) {
        let opens = self.state.open_after_question.take();
        if self.state.inspector.closing.asks {
            self.state.inspector.closing.anyway = true;
            self.ctx.send_viewport_cmd(egui::ViewportCommand::Close);
            return;
        }
        if let Some(command) = opens {
            self.open(command);
        }
    }

    /// Opens a built-in scene.
    pub(crate) fn open_demo(&mut self, spec: DemoSpec) {
        self.state.opening = Some(model::words(&spec.scene));
        self.workers.open.submit(OpenRequest::Demo { spec, settings: self.state.settings.capture.clone() });
    }

    /// Opens the room that comes with the program.
    pub(crate) fn open_room(&mut self) {
        self.state.opening = Some("room".to_owned());
        self.workers.open.submit(OpenRequest::Room);
    }

    /// Opens a capture or a store, at the view that an address names.
    pub(crate) fn open_path(&mut self, path: &Path) {
        let (path, view) = address::of_path(path);
        let path = lasting(path);
        self.address_to_open = view.map(|view| (path.clone(), view));
        self.open_with_keys(path, Vec::new());
    }

    /// Stops the work that the line at the bottom names, and nothing beside it.
    fn cancel(&mut self) {
        let Some(work) = self.state.busy.first().map(|busy| busy.work) else { return };
        let workers = &self.workers;
        match work {
            StoppableWork::Open => workers.open.cancel(),
            StoppableWork::Whole => {
                workers.whole.cancel();
                if !self.state.is_whole_ready() {
                    self.state.stopped = true;
                    self.scheduler.whole = None;
                }
            }
            StoppableWork::File => workers.file.cancel(),
            StoppableWork::Export => workers.export.cancel(),
            StoppableWork::Study => workers.study.cancel(),
            StoppableWork::Compare => {
                workers.compare.cancel();
                let text = "It was stopped; choose what to compare again.";
                self.state.inspector.compare_error = Some(text.to_owned());
            }
            StoppableWork::Measure => workers.measure.cancel(),
        }
        self.refresh_busy();
    }

    fn escape(&mut self) {
        let inspector = &mut self.state.inspector;
        let was_open = inspector.palette.take().is_some()
            | inspector.naming.take().is_some()
            | inspector.help.take().is_some()
            | inspector.closing.asks
            | inspector.readings.is_open
            | inspector.charts.question.take().is_some()
            | self.state.open_after_question.take().is_some();
        inspector.closing.asks = false;
        inspector.readings.is_open = false;
        if was_open
            || self.state.typed_path.take().is_some()
            || std::mem::take(&mut self.state.share.is_open)
            || self.state.notices.pop().is_some()
        {
            return;
        }
        self.state.edits.draft = None;
        if self.state.edits.tool.take().is_some() || self.state.edits.selection.take().is_some() {
            return;
        }
        if self.state.live.ruler.active {
            return self.apply(Command::View(ViewCommand::Measure(false)));
        }
        if self.state.inspector.path.playing.take().is_some() || self.state.look.maximized.take().is_some() {
            return;
        }
        let is_cancellable = self.state.busy.iter().any(|busy| busy.cancellable);
        if self.state.inspector.probe.pinned && !is_cancellable {
            self.apply(Command::Pin(false));
        } else {
            self.cancel();
        }
    }
}

/// Whether a command only looks around, so that a scene that was about to move still may.
fn only_looks(command: &Command) -> bool {
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
            | Command::Holes(_)
            | Command::ShowCameras(_)
            | Command::Workspace(_)
            | Command::View(_)
            | Command::Display(_)
            | Command::LiveArea(_)
            | Command::LoopRange(_)
            | Command::PingPong(_)
            | Command::ToggleMarker
            | Command::Maximize(_)
            | Command::ShowArea(..)
            | Command::ShowTotals(_)
            | Command::FullScreen
            | Command::OpenView(_)
            | Command::ResetLayout
            | Command::Introduced
            | Command::RoomExplained
            | Command::Dark(_)
    )
}
