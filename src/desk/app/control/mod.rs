//! Carries out commands and takes in answers: the only place where the state changes.

pub(crate) mod keyboard;
pub(crate) mod update;

use std::path::PathBuf;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{Receiver, sync_channel};
use std::time::{Duration, Instant};

use crate::address::ViewAddress;
pub(crate) use crate::app::control::keyboard::gave_up_number;
use crate::app::dock::Dock;
use crate::app::model::command::{FileCommand, Opening, WindowCommand};
use crate::app::model::purpose::TypedPath;
use crate::app::model::window::{DockView, NoticeKind, Workspace};
use crate::app::model::{Busy, Command, Message, State, WorkKind};
use crate::app::pace::LeastPeriod;
use crate::app::rooms::files::remembered::Memory;
use crate::app::rooms::timeline::TimeCommand;
use crate::app::theme;
use crate::app::work::{Outbox, Unread, Workers};
use overlook_engine::capture::Camera;
use overlook_engine::demo::DemoSpec;
use overlook_engine::error::Result;
use overlook_engine::job::Progress;
use overlook_engine::preprocess::diagnostics::Report;
use overlook_engine::render::gpu::SharedDevice;
use overlook_engine::settings::Settings;

/// Answers that may wait for the window at once: more than there are workers, so that none of them waits.
const MESSAGES: usize = 32;

/// How often progress is updated while long work is under way.
const WATCH: Duration = Duration::from_millis(100);

/// How long a message of success stays.
const DONE_STAYS: Duration = Duration::from_secs(8);

/// How far the pointer may move in a click, points: what moves farther drags, and is answered at once.
const CLICK: f32 = 4.0;

/// Work on edits that takes less is not told of.
const PASSING: Duration = Duration::from_millis(200);

/// A frame may come earlier by this share of its time: better than to draw the window for it alone.
const EARLY: f32 = 0.2;

/// What the window shows first.
#[derive(Clone, Debug, PartialEq)]
pub enum Start {
    /// A built-in scene.
    Demo(DemoSpec),
    /// The room that comes with the program: it moves at once, in the workspace for looking around.
    Welcome,
    /// A capture (a folder, or a file that it is known by) or a store.
    Path(PathBuf),
}

/// The window's contents.
pub struct OverlookApp {
    pub(crate) state: State,
    pub(crate) workers: Workers,
    pub(crate) dock: Dock,
    pub(crate) inbox: Receiver<Message>,
    /// What is in it, or about to be.
    pub(crate) unread: Unread,
    pub(crate) commands: Vec<Command>,
    /// Whether the system has dialogs for files: a window off screen has none, nor a desktop whose dialog closed at once.
    pub(crate) has_dialogs: bool,
    /// When the system's dialog was requested.
    pub(crate) asked_at: Option<Instant>,
    /// The path that was taken from the field last.
    pub(crate) last_typed: Option<TypedPath>,
    pub(crate) ctx: egui::Context,
    /// The renderer of the window, if that is wgpu.
    pub(crate) window: Option<eframe::egui_wgpu::RenderState>,
    /// When each kind of work that is watched began, by its words.
    pub(crate) stages: std::collections::HashMap<String, Instant>,
    /// The view to go to once a path is open.
    pub(crate) address_to_open: Option<(PathBuf, ViewAddress)>,
    /// Read by what draws the window.
    pub(crate) least_period: LeastPeriod,
}

impl OverlookApp {
    /// A window that opens `start`. `storage` restores the memory of an earlier run. The GPU renders on the device of `window`,
    /// so that pictures in motion need not be copied.
    ///
    /// # Errors
    /// `Io` where the operating system gives no threads.
    pub fn new(
        ctx: &egui::Context,
        storage: Option<&dyn eframe::Storage>,
        window: Option<&eframe::egui_wgpu::RenderState>,
        start: Start,
    ) -> Result<Self> {
        theme::install(ctx);
        ctx.options_mut(|options| options.input_options.max_click_dist = CLICK);
        let (sender, inbox) = sync_channel(MESSAGES);
        let shared = window.map(|window| SharedDevice {
            adapter: window.adapter.clone(),
            device: window.device.clone(),
            queue: window.queue.clone(),
        });
        let outbox = Outbox::new(sender, ctx.clone());
        let workers = Workers::start(&outbox, shared)?;
        let mut state = State::default();
        state.live.shares_device = window.is_some();
        state.inspector.graphics = window.map(|window| {
            let adapter = window.adapter.get_info();
            format!("{} ({})", adapter.name, adapter.backend)
        });
        let dock = Memory::load(storage).restore(&mut state, ctx);
        state.look.workspace = dock.workspace();
        if storage.is_none() {
            // Nothing can be remembered, so that it would be a first run every time.
            (state.inspector.introduced, state.inspector.room_explained) = (true, true);
        }
        let mut app = Self {
            state,
            workers,
            dock,
            inbox,
            unread: outbox.unread,
            commands: Vec::new(),
            has_dialogs: false,
            asked_at: None,
            last_typed: None,
            ctx: ctx.clone(),
            window: window.cloned(),
            stages: std::collections::HashMap::new(),
            address_to_open: None,
            least_period: LeastPeriod::default(),
        };
        match start {
            Start::Demo(spec) => app.open_demo(spec),
            Start::Welcome => {
                app.apply(Command::Window(WindowCommand::Workspace(Workspace::Explore)));
                app.state.timeline.plays_once_open = true;
                app.open(Opening::Room);
            }
            Start::Path(path) => app.open_path(&path),
        }
        Ok(app)
    }

    /// The work between two pictures of the window: every change of the state.
    pub(crate) fn between_pictures(&mut self, ctx: &egui::Context) {
        while let Ok(message) = self.inbox.try_recv() {
            self.unread.read_one();
            self.receive(message);
        }
        self.carry_out_commands();
        self.take_dropped_files();
        self.advance_time();
        self.advance_path();
        self.fade_changes();
        self.watch_closing();
        self.request_missing();
        self.watch_work();
        let theme = if self.state.dark { egui::Theme::Dark } else { egui::Theme::Light };
        if ctx.theme() != theme {
            ctx.set_theme(theme);
        }
        theme::show_tooltips(ctx, !self.state.is_asking());
    }

    /// The work after a picture of the window. What only moves the view is answered at once, and the window is drawn again when there is
    /// something to show.
    pub(crate) fn after_picture(&mut self) {
        if self.commands.is_empty() {
            return;
        }
        if self.state.doc.live_shown.is_none() || !self.commands.iter().all(Command::moves_view) {
            self.ctx.request_repaint();
            return;
        }
        self.carry_out_commands();
        self.request_missing();
    }

    fn carry_out_commands(&mut self) {
        self.state.live.is_held = self.ctx.input(|input| input.pointer.any_down());
        for command in std::mem::take(&mut self.commands) {
            self.apply(command);
        }
    }

    /// Requests what is missing, and to be called again where that depends on time.
    fn request_missing(&mut self) {
        self.state.look.in_sight = self.visible_views();
        self.state.follow_view();
        if let Some(wait) = self.workers.request_missing(&self.state) {
            self.ctx.request_repaint_after(wait);
        }
    }

    /// Leaves what the next run brings back.
    pub(crate) fn remember(&mut self, storage: &mut dyn eframe::Storage) {
        self.state.remember_picture(&self.ctx);
        Memory::of(&self.state, &self.dock).save(storage);
    }

    pub(crate) fn visible_views(&self) -> Vec<DockView> {
        self.state.look.maximized.map_or_else(|| self.dock.visible(), |view| vec![view])
    }

    fn advance_time(&mut self) {
        let all_frames = self.state.frame_count();
        let timeline = &mut self.state.timeline;
        let period = 1.0 / timeline.frames_per_second;
        let least_period = if timeline.playing { period * (1.0 - EARLY / 2.0) * 1e6 } else { 0.0 };
        self.least_period.store(least_period as u32, Ordering::Relaxed);
        if !timeline.playing {
            return;
        }
        timeline.elapsed_secs += self.ctx.input(|input| input.unstable_dt).min(0.5);
        let frames = (timeline.elapsed_secs / period + EARLY).floor() as i64;
        timeline.elapsed_secs -= frames as f32 * period;
        let wait = (period - timeline.elapsed_secs).max(0.0);
        let before = timeline.frame;
        if frames > 0 {
            timeline.advance(frames as usize, all_frames);
        }
        let frame = std::mem::replace(&mut timeline.frame, before);
        if frame != before {
            self.apply(Command::Time(TimeCommand::Frame(frame)));
        }
        self.ctx.request_repaint_after(Duration::from_secs_f32(wait));
    }

    /// Moves along the camera path, at the frame rate of the timeline.
    fn advance_path(&mut self) {
        let path = &mut self.state.doc.path;
        let Some(picture) = path.playing else { return };
        let Some(key) = path.at(picture) else { return };
        let next = picture
            + self.ctx.input(|input| input.unstable_dt).min(0.5) * self.state.timeline.frames_per_second;
        let pictures = path.pictures() as f32;
        path.playing = if path.is_closed {
            Some(next % pictures.max(1.0))
        } else {
            (picture < pictures - 1.0).then_some(next)
        };
        self.go_to_key(key);
        self.ctx.request_repaint();
    }

    /// Asks before the window closes with something unsaved, half written or half measured.
    fn watch_closing(&mut self) {
        let is_unsaved = self.state.is_unsaved() || self.state.unsaved_work().is_some();
        let closing = &mut self.state.inspector.closing;
        closing.writing = !self.workers.file.is_idle() || !self.workers.export.is_idle();
        let closes = !closing.anyway && self.ctx.input(|input| input.viewport().close_requested());
        if closes && (is_unsaved || closing.writing) {
            self.ctx.send_viewport_cmd(egui::ViewportCommand::CancelClose);
            closing.asks = true;
        }
    }

    fn take_dropped_files(&mut self) {
        let dropped = |input: &egui::InputState| Some(input.raw.dropped_files.first()?.path().to_path_buf());
        if let Some(path) = self.ctx.input(dropped) {
            self.apply(Command::File(FileCommand::Open(Opening::Path(path))));
        }
    }

    pub(crate) fn watch_work(&mut self) {
        let watched = self.workers.watched();
        let is_under_way = |stage: &str| watched.iter().flat_map(|(_, of)| of).any(|of| of.stage == stage);
        self.stages.retain(|stage, _| is_under_way(stage));
        if watched.iter().any(|(_, progress)| progress.is_some()) {
            self.ctx.request_repaint_after(WATCH);
        }
        let busy = watched.into_iter().filter_map(|(work, progress)| {
            // Comparing takes long only if the capture is read again.
            let progress = progress.filter(|progress| work != WorkKind::Compare || progress.total > 0)?;
            let began = *self.stages.entry(progress.stage.clone()).or_insert_with(Instant::now);
            // These take long only now and then: a frame that is read first, evidence that is asked of all cameras.
            let is_passing = match work {
                WorkKind::InspectFrame => self.state.doc.inspected.is_some(),
                WorkKind::EditSamples => began.elapsed() < PASSING,
                _ => false,
            };
            if is_passing {
                return None;
            }
            let secs_left = secs_left(work, &progress, began.elapsed());
            Some(Busy { work, progress, cancellable: work != WorkKind::MeasureAccuracy, secs_left })
        });
        self.state.busy = busy.collect();
        let notices = &mut self.state.notices;
        if !notices.is_empty() {
            notices.retain(|notice| notice.kind != NoticeKind::Done || notice.since.elapsed() < DONE_STAYS);
            self.ctx.request_repaint_after(Duration::from_secs(1));
        }
    }
}

/// How long the rest takes at the pace so far; `None` while too little is done to estimate it.
pub(crate) fn secs_left(work: WorkKind, progress: &Progress, elapsed: Duration) -> Option<f32> {
    let share = progress.fraction();
    // A study is a row of stages; the progress is that of one of them.
    (work != WorkKind::Study && share > 0.02 && elapsed > Duration::from_millis(500))
        .then(|| elapsed.as_secs_f32() * (1.0 - share) / share)
}

/// The state of a window beyond its labels.
#[derive(Clone, Debug)]
pub struct Observed<'a> {
    /// Whether all requested work is done and shown.
    pub is_idle: bool,
    /// Index of the frame shown.
    pub frame: usize,
    /// Name of what is open, or `None`.
    pub scene_name: Option<&'a str>,
    /// The account of the open capture or store, and whether it was made with the settings on the sliders.
    pub report: Option<(&'a Report, bool)>,
    /// The settings on the sliders.
    pub settings: &'a Settings,
    /// Pixel size of the live picture on screen and the share of it that samples reached; `None` before the first.
    pub live_coverage: Option<([usize; 2], f64)>,
    /// The texture of the live picture: [`egui::TextureId::User`] if its pixels never left the device that draws the window;
    /// `None` before the first.
    pub live_texture: Option<egui::TextureId>,
    /// Position of the live view in world space; `None` while nothing is open.
    pub live_position: Option<[f64; 3]>,
    /// Index of the camera whose picture the source view shows.
    pub source_camera: usize,
    /// Camera, column and row of the selected pixel; `None` while there is none.
    pub probed_pixel: Option<(usize, usize, usize)>,
    /// Title and text of every message on screen.
    pub notices: Vec<String>,
    /// Names of the views that can be seen, by their tabs.
    pub views_in_sight: Vec<&'static str>,
    /// Positions of all cameras in world space.
    pub camera_positions: Vec<[f64; 3]>,
    /// The cameras that the live view shows, each with the place of its middle as shares of the view.
    pub cameras_on_screen: Vec<(usize, egui::Vec2)>,
    /// The distance between the two points that were picked, in units of the scene; `None` before both were.
    pub measured_distance: Option<f64>,
}

impl OverlookApp {
    /// What the window shows now.
    #[must_use]
    pub fn observed(&self) -> Observed<'_> {
        let state = &self.state;
        let scene = state.doc.scene.as_deref();
        let cameras = scene.map_or(&[][..], |scene| &scene.cameras);
        let (size, orbit) = (state.live.size, state.live.orbit.as_ref());
        let vantage = state.seen_camera(size);
        let on_screen = |(index, camera): (usize, &Camera)| {
            let (pixel, _) = vantage.as_ref()?.project(camera.position_in_world())?;
            let share = egui::vec2(pixel.x as f32 / size[0] as f32, pixel.y as f32 / size[1] as f32);
            (share.min_elem() > 0.0 && share.max_elem() < 1.0).then_some((index, share))
        };
        let live = state.doc.live_shown.as_ref();
        let coverage = live.map(|shown| {
            let [width, height] = shown.picture.size;
            ([width, height], 1.0 - shown.picture.stats.holes as f64 / (width * height).max(1) as f64)
        });
        Observed {
            is_idle: self.workers.are_at_rest(state) && self.unread.is_none() && state.opening.is_none(),
            frame: state.timeline.frame,
            scene_name: scene.map(|scene| scene.name.as_str()),
            report: state.report().map(|report| (report, !state.is_stale())),
            settings: &state.settings,
            live_coverage: coverage,
            live_texture: live.map(|shown| shown.texture.id()),
            live_position: orbit.map(|orbit| orbit.world_from_camera.translation.to_array()),
            source_camera: state.source.camera,
            probed_pixel: state.doc.probe.shown.as_ref().map(|probed| (probed.camera, probed.x, probed.y)),
            notices: state.notices.iter().map(|of| format!("{}: {}", of.title, of.text)).collect(),
            views_in_sight: self.visible_views().into_iter().map(|view| view.name_and_help().0).collect(),
            camera_positions: cameras.iter().map(|camera| camera.position_in_world().to_array()).collect(),
            cameras_on_screen: cameras.iter().enumerate().filter_map(on_screen).collect(),
            measured_distance: state.live.ruler.distance(),
        }
    }
}
