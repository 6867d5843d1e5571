//! The window's contents: takes in answers, carries out commands, requests what is missing, and draws.

use std::path::PathBuf;
use std::sync::mpsc::{Receiver, sync_channel};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use super::control::{self, Memory};
use super::dock::Dock;
use super::model::{
    Busy, Command, DockView, Message, NoticeKind, State, StoppableWork, Stopwatch, Texture, TypedPath,
};
use super::work::{Outbox, Scheduler, Workers};
use super::{theme, window};
use overlook_engine::demo::DemoSpec;
use overlook_engine::error::Result;
use overlook_engine::preprocess::diagnostics::Report;
use overlook_engine::render::gpu::SharedDevice;
use overlook_engine::settings::Settings;

/// Answers that may wait for the window at once: more than there are workers, so that none of them waits.
const MESSAGES: usize = 32;

/// How often progress is updated while long work is under way.
const WATCH: Duration = Duration::from_millis(100);

/// How long a message of success stays.
const DONE_STAYS: Duration = Duration::from_secs(8);

/// What the window shows first.
#[derive(Clone, Debug, PartialEq)]
pub enum Start {
    /// A built-in scene.
    Demo(DemoSpec),
    /// A built-in scene that starts to move once all about it is known, unless the person at the window takes over before.
    Welcome(DemoSpec),
    /// A capture (a folder, or a file that it is known by) or a store.
    Path(PathBuf),
}

/// The window's contents.
pub struct OverlookApp {
    pub(super) state: State,
    pub(super) workers: Workers,
    pub(super) scheduler: Scheduler,
    pub(super) dock: Dock,
    pub(super) inbox: Receiver<Message>,
    pub(super) commands: Vec<Command>,
    /// When the system's dialog was requested.
    pub(super) asked_at: Option<Instant>,
    /// The path that was taken from the field last.
    pub(super) last_typed: Option<TypedPath>,
    pub(super) ctx: egui::Context,
    /// What draws the window, where that is wgpu.
    pub(super) window: Option<eframe::egui_wgpu::RenderState>,
    /// Where a picture of the window is to be written, once it is taken.
    pub(super) shot_wanted: Option<PathBuf>,
    /// The picture of the window that was taken last.
    pub(super) shot: Arc<Mutex<Option<Arc<egui::ColorImage>>>>,
    /// When each kind of work that is watched began, by its words.
    pub(super) stages: std::collections::HashMap<String, Instant>,
}

impl OverlookApp {
    /// A window that opens `start`. `storage` brings back what an earlier run remembered; on the device of `window` the GPU
    /// paints, so that pictures in motion need not be copied.
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
        let (sender, inbox) = sync_channel(MESSAGES);
        let shared = window.map(|window| SharedDevice {
            adapter: window.adapter.clone(),
            device: window.device.clone(),
            queue: window.queue.clone(),
        });
        let workers = Workers::start(&Outbox::new(sender, ctx.clone()), shared)?;
        let mut state = State::default();
        state.live.shares_device = window.is_some();
        state.inspector.graphics = window.map(|window| {
            let adapter = window.adapter.get_info();
            format!("{} ({})", adapter.name, adapter.backend)
        });
        let dock = Memory::load(storage).restore(&mut state);
        state.look.workspace = dock.workspace();
        if storage.is_none() {
            // Nothing can be remembered, so that it would be a first run every time.
            state.inspector.introduced = true;
        }
        let mut app = Self {
            state,
            workers,
            scheduler: Scheduler::default(),
            dock,
            inbox,
            commands: Vec::new(),
            asked_at: None,
            last_typed: None,
            ctx: ctx.clone(),
            window: window.cloned(),
            shot_wanted: None,
            shot: Arc::default(),
            stages: std::collections::HashMap::new(),
        };
        app.state.timeline.plays_once_ready = matches!(start, Start::Welcome(_));
        match start {
            Start::Demo(spec) | Start::Welcome(spec) => app.open_demo(spec),
            Start::Path(path) => app.open_path(path),
        }
        Ok(app)
    }

    /// Whether all requested work is done and shown.
    #[must_use]
    pub fn is_idle(&self) -> bool {
        self.workers.are_idle() && self.state.opening.is_none() && self.scheduler.is_up_to_date(&self.state)
    }

    /// Index of the frame shown.
    #[must_use]
    pub fn frame(&self) -> usize {
        self.state.timeline.frame
    }

    /// Name of what is open, or `None`.
    #[must_use]
    pub fn scene_name(&self) -> Option<&str> {
        self.state.scene.as_ref().map(|scene| scene.name.as_str())
    }

    /// The account of the open capture or store, and whether it was made with the settings on the sliders.
    #[must_use]
    pub fn report(&self) -> Option<(&Report, bool)> {
        self.state.report().map(|report| (report, !self.state.is_stale()))
    }

    /// The settings on the sliders.
    #[must_use]
    pub fn settings(&self) -> &Settings {
        &self.state.settings
    }

    /// Pixel size of the live picture on screen and the share of it that samples reached; `None` before the first.
    #[must_use]
    pub fn live_coverage(&self) -> Option<([usize; 2], f64)> {
        let shown = self.state.live_shown.as_ref()?;
        let [width, height] = shown.picture.size;
        Some(([width, height], 1.0 - shown.picture.stats.holes as f64 / (width * height).max(1) as f64))
    }

    /// Whether the live picture is shown without its pixels ever having left the device that draws the window.
    #[must_use]
    pub fn live_is_on_device(&self) -> bool {
        self.state.live_shown.as_ref().is_some_and(|shown| matches!(shown.texture, Texture::Painted(_)))
    }

    /// What egui knows the live picture by; `None` while there is none.
    #[must_use]
    pub fn live_texture(&self) -> Option<egui::TextureId> {
        self.state.live_shown.as_ref().map(|shown| shown.texture.id())
    }

    /// Position of the live view in world space; `None` while nothing is open.
    #[must_use]
    pub fn live_position(&self) -> Option<[f64; 3]> {
        self.state.live.orbit.as_ref().map(|orbit| orbit.world_from_camera.translation.to_array())
    }

    /// Index of the camera whose picture the source view shows.
    #[must_use]
    pub fn source_camera(&self) -> usize {
        self.state.source.camera
    }

    /// Camera, column and row of the selected pixel; `None` while there is none.
    #[must_use]
    pub fn probed_pixel(&self) -> Option<(usize, usize, usize)> {
        self.state.inspector.probe.shown.as_ref().map(|probed| (probed.camera, probed.x, probed.y))
    }

    /// Text of every message on screen.
    #[must_use]
    pub fn notices(&self) -> Vec<String> {
        self.state.notices.iter().map(|notice| format!("{}: {}", notice.title, notice.text)).collect()
    }

    /// The view that fills the window, by the name on its tab; `None` where none does.
    #[must_use]
    pub fn maximized_view(&self) -> Option<&'static str> {
        self.state.look.maximized.map(|view| view.name_and_help().0)
    }

    /// Names of the views that can be seen.
    #[must_use]
    pub fn views_in_sight(&self) -> Vec<&'static str> {
        self.visible_views().into_iter().map(|view| view.name_and_help().0).collect()
    }

    /// The cameras that the live view shows, each with the place of its middle as shares of the view.
    #[must_use]
    pub fn cameras_on_screen(&self) -> Vec<(usize, egui::Vec2)> {
        let size = self.state.live.size;
        let (Some(scene), Some(vantage)) = (&self.state.scene, self.state.live_camera(size)) else {
            return Vec::new();
        };
        let [width, height] = size;
        let cameras = scene.cameras.iter().enumerate();
        let places = cameras.filter_map(|(index, camera)| {
            let (pixel, _) = vantage.project(camera.position_in_world())?;
            let share = egui::vec2(pixel.x as f32 / width as f32, pixel.y as f32 / height as f32);
            (share.min_elem() > 0.0 && share.max_elem() < 1.0).then_some((index, share))
        });
        places.collect()
    }

    /// Position of a camera in world space; the origin where there is none.
    #[must_use]
    pub fn camera_position(&self, camera: usize) -> [f64; 3] {
        let cameras = self.state.scene.as_ref().map_or(&[][..], |scene| &scene.cameras);
        cameras.get(camera).map_or([0.0; 3], |camera| camera.position_in_world().to_array())
    }

    /// The distance between the two points that were picked, in units of the scene; `None` before both were.
    #[must_use]
    pub fn measured_distance(&self) -> Option<f64> {
        self.state.live.ruler.distance()
    }

    pub(super) fn visible_views(&self) -> Vec<DockView> {
        self.state.look.maximized.map_or_else(|| self.dock.visible(), |view| vec![view])
    }

    fn advance_time(&mut self) {
        if !self.state.timeline.playing {
            return;
        }
        let timeline = &mut self.state.timeline;
        let period = 1.0 / timeline.frames_per_second;
        timeline.elapsed_secs += self.ctx.input(|input| input.unstable_dt).min(0.5);
        let frames = (timeline.elapsed_secs / period) as i64;
        timeline.elapsed_secs -= frames as f32 * period;
        let wait = (period - timeline.elapsed_secs).max(0.0);
        let before = timeline.frame;
        if frames > 0 {
            timeline
                .advance(frames as usize, self.state.scene.as_ref().map_or(1, |scene| scene.frame_count()));
        }
        let frame = std::mem::replace(&mut self.state.timeline.frame, before);
        if frame != before {
            self.apply(Command::Frame(frame));
        }
        self.ctx.request_repaint_after(Duration::from_secs_f32(wait));
    }

    /// Moves along the camera path, at the frame rate of the timeline.
    fn advance_path(&mut self) {
        let path = &mut self.state.inspector.path;
        let Some(picture) = path.playing else { return };
        let Some(key) = path.at(picture) else { return };
        let next = picture
            + self.ctx.input(|input| input.unstable_dt).min(0.5) * self.state.timeline.frames_per_second;
        path.playing = (picture < path.pictures() as f32 - 1.0).then_some(next);
        self.go_to_key(key);
        self.ctx.request_repaint();
    }

    /// Asks before the window closes with something unsaved, half written or half measured.
    fn watch_closing(&mut self) {
        let is_unsaved = self.state.is_unsaved();
        let inspector = &mut self.state.inspector;
        let closing = &mut inspector.closing;
        closing.writing = !self.workers.file.is_idle() || !self.workers.export.is_idle();
        if closing.anyway || !self.ctx.input(|input| input.viewport().close_requested()) {
            return;
        }
        if is_unsaved || inspector.closing.writing || inspector.unsaved_work().is_some() {
            self.ctx.send_viewport_cmd(egui::ViewportCommand::CancelClose);
            inspector.closing.asks = true;
        }
    }

    fn take_dropped_files(&mut self) {
        let dropped =
            self.ctx.input(|input| input.raw.dropped_files.first().map(|file| file.path().to_path_buf()));
        if let Some(path) = dropped {
            self.apply(Command::OpenPath(path));
        }
    }

    pub(super) fn watch_work(&mut self) {
        let workers = &self.workers;
        let watched = [
            (StoppableWork::Open, workers.open.progress(), true),
            (StoppableWork::Whole, workers.whole.progress(), true),
            (StoppableWork::File, workers.file.progress(), true),
            (StoppableWork::Export, workers.export.progress(), true),
            (StoppableWork::Study, workers.study.progress(), true),
            // Only where it reads the capture again, which takes long.
            (StoppableWork::Compare, workers.compare.progress().filter(|progress| progress.total > 0), true),
            (StoppableWork::Measure, workers.measure.progress(), false),
        ];
        self.state.busy = watched
            .into_iter()
            .filter_map(|(work, progress, cancellable)| {
                let progress = progress?;
                let began = *self.stages.entry(progress.stage.clone()).or_insert_with(Instant::now);
                let secs_left = secs_left(work, &progress, began.elapsed());
                Some(Busy { work, progress, cancellable, secs_left })
            })
            .collect();
        let busy = &self.state.busy;
        self.stages.retain(|stage, _| busy.iter().any(|busy| busy.progress.stage == *stage));
        if !self.state.busy.is_empty() {
            self.ctx.request_repaint_after(WATCH);
        }
        let before = self.state.notices.len();
        self.state
            .notices
            .retain(|notice| notice.kind != NoticeKind::Done || notice.since.elapsed() < DONE_STAYS);
        if before > 0 {
            self.ctx.request_repaint_after(Duration::from_secs(1));
        }
    }
}

impl eframe::App for OverlookApp {
    fn logic(&mut self, ctx: &egui::Context, _frame: &mut eframe::Frame) {
        let watch = Stopwatch::start();
        while let Ok(message) = self.inbox.try_recv() {
            self.receive(message);
        }
        for command in std::mem::take(&mut self.commands) {
            self.apply(command);
        }
        self.take_dropped_files();
        self.take_shot();
        self.advance_time();
        self.advance_path();
        self.watch_closing();
        if let Some(wait) = self.scheduler.request_missing(&self.state, &self.visible_views(), &self.workers)
        {
            ctx.request_repaint_after(wait);
        }
        self.watch_work();
        let theme = if self.state.dark { egui::Theme::Dark } else { egui::Theme::Light };
        if ctx.theme() != theme {
            ctx.set_theme(theme);
        }
        theme::show_tooltips(ctx, !self.state.is_asking());
        self.state.inspector.meter.logic(watch.spent());
    }

    fn ui(&mut self, ui: &mut egui::Ui, _frame: &mut eframe::Frame) {
        let watch = Stopwatch::start();
        control::commands(ui, &self.state, &mut self.commands);
        window::window_ui(ui, &self.state, &mut self.dock, &mut self.commands);
        if !self.commands.is_empty() {
            ui.ctx().request_repaint();
        }
        self.state.inspector.meter.ui(watch.spent());
    }

    fn save(&mut self, storage: &mut dyn eframe::Storage) {
        self.state.remember_picture();
        Memory::of(&self.state, &self.dock).save(storage);
    }
}

/// How long the rest takes at the pace so far; `None` while too little is done to estimate it.
pub(super) fn secs_left(
    work: StoppableWork,
    progress: &overlook_engine::job::Progress,
    elapsed: Duration,
) -> Option<f32> {
    let share = progress.fraction();
    // A study is a row of stages; the progress is that of one of them.
    (work != StoppableWork::Study && share > 0.02 && elapsed > Duration::from_millis(500))
        .then(|| elapsed.as_secs_f32() * (1.0 - share) / share)
}
