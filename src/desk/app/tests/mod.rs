//! What the window does between commands and answers, without a picture of it.

mod changes;
mod edits;
mod first_minute;
mod motion;
mod paths;
mod session;
mod sharing;
mod stopping;
mod studying;
mod telling;
mod undoing;
mod values;

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use crate::app::control::{OverlookApp, Start};
use crate::app::model::command::{
    ChartCommand, CompareCommand, FileCommand, PathCommand, PixelCommand, SettingsCommand, ViewCommand,
};
use crate::app::model::purpose::Purpose;
use crate::app::model::window::{DockView, NoticeKind};
use crate::app::model::{Command, Message, WorkKind};
use crate::app::rooms::charts::state::Study;
use crate::app::rooms::compare::state::CompareSide;
use crate::app::rooms::path::CameraPath;
use crate::app::rooms::pixel::state::Spot;
use crate::app::rooms::share::state::Exported;
use crate::app::rooms::timeline::TimeCommand;
use crate::ways_out;
use overlook_engine::demo::DemoSpec;
use overlook_engine::error::Error;
use overlook_engine::render::NO_IMAGE;
use overlook_engine::settings::PruningMethod;
use overlook_engine::store::file::Store;

/// Far longer than anything here takes.
const PATIENCE: Duration = Duration::from_mins(3);

fn orrery(cameras: usize, frames: usize) -> DemoSpec {
    DemoSpec::new("orrery").cameras(cameras).frames(frames).size((48, 36))
}

/// The window's logic on a small scene.
fn start(cameras: usize, frames: usize) -> OverlookApp {
    let ctx = egui::Context::default();
    let mut app = OverlookApp::new(&ctx, None, None, Start::Demo(orrery(cameras, frames))).unwrap();
    app.state.live.size = [48, 36];
    app
}

/// The same, once all work is done.
fn ready(cameras: usize, frames: usize) -> OverlookApp {
    let mut app = start(cameras, frames);
    settle(&mut app);
    app
}

/// Changes the camera path as its panel does.
fn change_path(app: &mut OverlookApp, key: Option<usize>, change: impl FnOnce(&mut CameraPath)) {
    let command = PathCommand::change(&app.state.doc.path, key, change);
    app.apply(Command::Path(command));
}

fn small_capture() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/small_capture")
}

/// Gives the camera path two keys with so many pictures between them.
fn add_path(app: &mut OverlookApp, pictures: usize) {
    change_path(app, None, |path| path.pictures_per_leg = pictures);
    for _ in 0..2 {
        app.apply(Command::Path(PathCommand::AddKey));
    }
    app.state.notices.clear();
}

/// Writes the store of what is open.
fn save_store(app: &mut OverlookApp, path: &Path) {
    app.take_path(Purpose::Share(&ways_out::store::STORE), path.to_path_buf());
    settle(app);
}

/// The text that was copied last.
fn copied(app: &OverlookApp) -> Option<String> {
    let commands = app.ctx.output(|output| output.commands.clone());
    commands.into_iter().rev().find_map(|command| match command {
        egui::OutputCommand::CopyText(text) => Some(text),
        _ => None,
    })
}

/// Copies the small capture that comes along.
fn copy_capture(to: &Path) {
    fn copy_folder(from: &Path, to: &Path) {
        std::fs::create_dir_all(to).unwrap();
        for entry in std::fs::read_dir(from).unwrap().map(|entry| entry.unwrap().path()) {
            let target = to.join(entry.file_name().unwrap());
            if entry.is_dir() {
                copy_folder(&entry, &target);
            } else {
                std::fs::copy(&entry, &target).unwrap();
            }
        }
    }
    copy_folder(&small_capture(), to);
}

/// What happens between two pictures of the window.
fn step(app: &mut OverlookApp) {
    let ctx = app.ctx.clone();
    eframe::App::logic(app, &ctx, &mut eframe::Frame::_new_kittest());
}

impl OverlookApp {
    fn is_idle(&self) -> bool {
        self.observed().is_idle
    }

    fn notices(&self) -> Vec<String> {
        self.observed().notices
    }

    /// Whether a message on screen begins like this.
    fn tells(&self, beginning: &str) -> bool {
        self.notices().iter().any(|notice| notice.starts_with(beginning))
    }
}

fn wait(app: &mut OverlookApp, what: &str, mut condition: impl FnMut(&OverlookApp) -> bool) {
    let started = Instant::now();
    while !condition(app) {
        assert!(started.elapsed() < PATIENCE, "waited too long for {what}; messages: {:?}", app.notices());
        step(app);
        std::thread::sleep(Duration::from_millis(2));
    }
}

fn settle(app: &mut OverlookApp) {
    step(app);
    wait(app, "all work to be done", OverlookApp::is_idle);
}

fn set(app: &mut OverlookApp, path: &'static str, value: impl Into<toml::Value>) {
    app.apply(Command::Settings(SettingsCommand::Set { path, value: value.into() }));
}

fn set_method(app: &mut OverlookApp, method: PruningMethod) {
    set(app, "pruning.method", method.to_string());
}

#[test]
fn a_threshold_changed_and_taken_back_at_once_leaves_the_capture_to_be_pruned() {
    let mut app = start(4, 60);
    wait(&mut app, "the capture to be pruned", |app| !app.workers.whole.worker.is_idle());
    set_method(&mut app, PruningMethod::Off);
    step(&mut app);
    set_method(&mut app, PruningMethod::HighestRate);
    settle(&mut app);
    assert!(app.state.doc.whole.is_some() && !app.state.is_stale());
}

#[test]
fn a_store_records_how_it_was_painted_when_it_was_saved() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("small.ovl");
    let mut app = ready(2, 2);
    set(&mut app, "render.kernel", "surfel");
    save_store(&mut app, &path);
    let settings = Store::open(&path).unwrap().info().settings.clone();
    assert_eq!(settings.render, app.state.settings.render);
}

#[test]
fn accuracy_is_that_of_the_kernel_on_screen_also_after_a_change_in_motion_and_after_measuring_was_stopped() {
    let mut app = start(2, 4);
    let measured = |app: &mut OverlookApp| {
        wait(app, "the accuracy", |app| app.state.doc.accuracy.is_some());
        app.state.doc.accuracy
    };
    let gathered = measured(&mut app);
    app.apply(Command::Time(TimeCommand::TogglePlay));
    set(&mut app, "render.kernel", "point");
    step(&mut app);
    assert!(app.state.doc.accuracy.is_none());
    // Back again, still in motion: what was asked for before is asked for again.
    set(&mut app, "render.kernel", "gather");
    step(&mut app);
    app.apply(Command::Time(TimeCommand::TogglePlay));
    // Measuring gives the same numbers each time.
    assert_eq!(measured(&mut app), gathered);
    settle(&mut app);
    set(&mut app, "render.kernel", "point");
    step(&mut app);
    app.apply(Command::Cancel);
    wait(&mut app, "the measuring to stop", |app| app.workers.measure.worker.is_idle());
    assert_ne!(app.state.doc.accuracy, gathered, "shown with another kernel");
    set(&mut app, "render.kernel", "gather");
    assert_eq!(measured(&mut app), gathered);
}

#[test]
fn a_sweep_that_runs_is_not_begun_anew_and_ends_with_its_capture_while_what_gave_way_says_nothing_of_that() {
    let mut app = ready(2, 2);
    app.apply(Command::Chart(ChartCommand::Study(Study::Sweep)));
    wait(&mut app, "the first point", |app| !app.state.doc.charts.sweep.is_empty());
    app.apply(Command::Chart(ChartCommand::Study(Study::Sweep)));
    step(&mut app);
    assert!(app.state.doc.charts.studying && app.notices()[0].starts_with("Already measuring"));
    app.open_demo(orrery(2, 3));
    for work in [WorkKind::Open, WorkKind::Study] {
        app.receive(Message::Failed { work, error: Error::Cancelled });
    }
    assert!(app.state.opening.is_some() && app.state.doc.charts.studying);
    wait(&mut app, "the other capture", |app| app.state.frame_count() == 3);
    wait(&mut app, "the sweep to stop", |app| app.workers.study.is_idle());
    step(&mut app);
    assert!(!app.state.doc.charts.studying && app.state.doc.charts.sweep.is_empty());
}

#[test]
fn of_two_captures_opened_at_once_the_latter_appears() {
    let mut app = start(2, 2);
    app.open_demo(orrery(2, 3));
    app.open_demo(orrery(2, 5));
    wait(&mut app, "a capture", |app| app.state.doc.scene.is_some() && app.state.opening.is_none());
    assert_eq!(app.state.frame_count(), 5);
    app.open_demo(orrery(2, 3));
    app.watch_work();
    app.apply(Command::Cancel);
    wait(&mut app, "the end of opening", |app| app.state.opening.is_none());
    assert_eq!(app.state.frame_count(), 5);
}

#[test]
fn thresholds_changed_while_a_store_is_written_are_still_unsaved() {
    let mut app = ready(2, 2);
    let before = app.state.settings.clone();
    set_method(&mut app, PruningMethod::Off);
    let scene = app.state.doc.scene.as_ref().unwrap().id;
    let saved = |holds| Message::Saved { path: "capture.ovl".into(), bytes: Some(1), holds: Some(holds) };
    app.receive(saved((scene, before)));
    assert!(app.state.is_unsaved());
    let now = app.state.settings.clone();
    app.receive(saved((scene + 1, now.clone())));
    assert!(app.state.is_unsaved(), "another capture was saved");
    app.receive(saved((scene, now)));
    assert!(!app.state.is_unsaved());
}

#[test]
fn thresholds_that_were_taken_back_need_not_be_saved() {
    let mut app = ready(2, 2);
    set_method(&mut app, PruningMethod::Off);
    assert!(app.state.is_unsaved());
    app.apply(Command::Undo);
    assert!(!app.state.is_unsaved());
    app.apply(Command::Settings(SettingsCommand::Switch));
    set_method(&mut app, PruningMethod::FirstCamera);
    assert!(app.state.is_unsaved());
    app.apply(Command::Settings(SettingsCommand::Switch));
    assert!(!app.state.is_unsaved());
}

#[test]
fn nothing_is_saved_or_exported_of_a_capture_pruned_with_other_thresholds() {
    let folder = tempfile::tempdir().unwrap();
    let mut app = ready(2, 2);
    add_path(&mut app, 1);
    set_method(&mut app, PruningMethod::Off);
    for purpose in [
        Purpose::Share(&ways_out::store::STORE),
        Purpose::Share(&ways_out::pictures::PICTURES),
        Purpose::Share(&ways_out::film::VIDEO),
    ] {
        app.apply(Command::File(FileCommand::AskPath(purpose)));
        assert!(app.state.typed_path.is_none(), "no path is asked for in vain");
        app.take_path(purpose, folder.path().join("out"));
        let told = app.state.notices.pop().unwrap();
        assert!(told.text.contains("not pruned with these settings yet"), "{}", told.text);
    }
    assert!(app.workers.file.is_idle() && app.workers.export.is_idle());
    settle(&mut app);
    app.apply(Command::File(FileCommand::AskPath(Purpose::Share(&ways_out::store::STORE))));
    assert!(app.state.typed_path.is_some());
}

/// Opens a store of which nothing that is seen at its last frame alone can be read.
fn open_damaged(folder: &Path) -> OverlookApp {
    let path = folder.join("damaged.ovl");
    let mut app = ready(2, FRAMES);
    save_store(&mut app, &path);
    let mut bytes = std::fs::read(&path).unwrap();
    let store = Store::open(&path).unwrap();
    let last = store.info().images.iter().filter(|image| image.span.start as usize == FRAMES - 1);
    for image in last {
        let payload = image.offset as usize + 8;
        bytes[payload..payload + image.length as usize].fill(0xEE);
    }
    std::fs::write(&path, bytes).unwrap();
    app.open_path(&path);
    wait(&mut app, "the store", |app| app.state.doc.scene.is_some() && !app.state.has_capture());
    settle(&mut app);
    app
}

const FRAMES: usize = 8;

#[test]
fn damage_that_is_met_while_a_store_plays_is_told_once_and_only_as_long_as_the_store_is_open() {
    let folder = tempfile::tempdir().unwrap();
    let mut app = open_damaged(folder.path());
    let tells = |app: &OverlookApp| app.tells("The store is damaged");
    assert!(!tells(&app), "what is shown first is whole");
    app.state.notices.clear();
    app.apply(Command::Time(TimeCommand::Frame(FRAMES - 1)));
    wait(&mut app, "the warning", tells);
    let warning = app.state.notices.clone();
    settle(&mut app);
    app.state.notices.clear();
    for frame in [0, FRAMES - 1] {
        app.apply(Command::Time(TimeCommand::Frame(frame)));
        settle(&mut app);
    }
    assert!(!tells(&app));
    // One about files stays.
    app.state.notices = warning;
    let exported = Exported { said: "2 pictures".into(), notice: None, damage: vec!["frame 8".into()] };
    app.receive(Message::Exported { path: "pictures".into(), exported });
    app.open_demo(orrery(2, 2));
    wait(&mut app, "the capture", |app| app.state.has_capture());
    let warnings = app.state.notices.iter().filter(|notice| notice.kind == NoticeKind::Warning);
    let titles: Vec<&str> = warnings.map(|notice| notice.title.as_str()).collect();
    assert_eq!(titles, ["Exported from a damaged store"]);
}

#[test]
fn a_hole_that_is_clicked_is_not_kept() {
    let mut app = ready(2, 2);
    app.apply(Command::View(ViewCommand::Dolly(4.0, None)));
    app.apply(Command::View(ViewCommand::Orbit(glam::DVec2::new(2.0, 0.0))));
    settle(&mut app);
    let picture = app.state.doc.live_shown.as_ref().unwrap().picture.rendered().unwrap().clone();
    let width = picture.image.width();
    let hole = picture.image.as_slice().iter().position(|image| *image == NO_IMAGE).expect("a hole");
    let size = picture.image.size().into();
    let spot = Spot::Live { x: hole % width, y: hole / width, size };
    // With and without having been pointed at before.
    for before in [false, true] {
        app.apply(Command::Pixel(PixelCommand::Probe(Some(spot))));
        if before {
            settle(&mut app);
            step(&mut app);
        }
        app.apply(Command::Pixel(PixelCommand::Pin(true)));
        settle(&mut app);
        // What the worker sent last is taken in.
        step(&mut app);
        let probe = &app.state.doc.probe;
        assert!(!probe.pinned && probe.spot.is_none() && probe.shown.is_none(), "before: {before}");
    }
    app.apply(Command::View(ViewCommand::Home));
    settle(&mut app);
    assert!(app.state.doc.probe.shown.is_none());
}

#[test]
fn pictures_are_named_after_what_they_show_until_those_that_were_chosen_are_there() {
    let mut app = start(2, 2);
    app.dock.open(DockView::Compare);
    wait(&mut app, "the comparison", |app| app.state.doc.compared.is_some());
    let sides = |app: &OverlookApp| app.state.doc.compared.as_ref().map(|compared| compared.choice.sides);
    let before = app.state.inspector.compare.clone();
    let mut look = before.clone();
    look.choice.sides = [CompareSide::Point, CompareSide::Kept];
    app.state.doc.compare_error = Some("of those before".into());
    app.apply(Command::Compare(CompareCommand::Look(Box::new(look.clone()))));
    assert_eq!((sides(&app), &app.state.doc.compare_error), (Some(before.choice.sides), &None));
    wait(&mut app, "the other comparison", |app| sides(app) == Some(look.choice.sides));
}

#[test]
fn pictures_exported_from_a_damaged_store_come_with_a_warning() {
    let folder = tempfile::tempdir().unwrap();
    let mut app = open_damaged(folder.path());
    let pictures = folder.path().join("pictures");
    change_path(&mut app, None, |path| path.pictures_per_leg = 1);
    for frame in [0, FRAMES - 1] {
        app.apply(Command::Time(TimeCommand::Frame(frame)));
        app.apply(Command::Path(PathCommand::AddKey));
    }
    app.take_path(Purpose::Share(&ways_out::pictures::PICTURES), pictures.clone());
    wait(&mut app, "the warning", |app| app.tells("Exported from a damaged store"));
    assert_eq!(std::fs::read_dir(&pictures).unwrap().count(), 2);
}

#[test]
fn an_export_that_the_gpu_was_asked_for_and_did_not_paint_says_so() {
    let mut app = ready(2, 2);
    let notice = Some("the CPU renders: no adapter".into());
    let exported = Exported { said: "2 pictures".into(), notice, damage: Vec::new() };
    app.receive(Message::Exported { path: "film.mp4".into(), exported });
    let told = "Exported without the GPU: Of film.mp4: the CPU renders: no adapter";
    assert_eq!(app.notices(), ["Exported: 2 pictures in film.mp4", told]);
}
