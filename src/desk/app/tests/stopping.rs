//! Work that is stopped, taken back, lined up, or cannot be done.

use std::sync::Arc;

use crate::app::control::{OverlookApp, Start};
use crate::app::model::command::ChartCommand;
use crate::app::model::purpose::Purpose;
use crate::app::model::{Command, WorkKind};
use crate::app::rooms::charts::state::Study;
use crate::app::rooms::report::ui::figures;
use crate::app::tests::{add_path, copy_capture, orrery, ready, set_method, settle, step, wait};
use crate::ways_out;
use overlook_engine::settings::PruningMethod;

#[test]
fn of_files_asked_for_one_after_the_other_each_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let mut app = ready(2, 2);
    let store = folder.path().join("small.ovl");
    app.take_path(Purpose::Share(&ways_out::store::STORE), store.clone());
    let settings: Vec<_> = (0..4).map(|nth| folder.path().join(format!("{nth}.toml"))).collect();
    for path in &settings {
        app.take_path(Purpose::SaveSettings, path.clone());
    }
    wait(&mut app, "the files", |app| app.workers.file.is_idle());
    assert!(settings.iter().chain([&store]).all(|path| path.is_file()));
}

#[test]
fn cancelling_stops_only_what_is_named_and_an_export_that_was_stopped_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let mut app = ready(2, 4);
    app.apply(Command::Chart(ChartCommand::Study(Study::Sweep)));
    add_path(&mut app, 2000);
    app.take_path(Purpose::Share(&ways_out::pictures::PICTURES), folder.path().join("pictures"));
    app.watch_work();
    assert_eq!(app.state.busy[0].work, WorkKind::Export);
    app.apply(Command::Cancel);
    assert!(app.state.doc.charts.studying, "the sweep stands behind it in the line");
    wait(&mut app, "a word about the export", |app| app.tells("Export stopped: Only the pictures"));
    assert!(app.workers.export.is_idle() && !app.workers.study.is_idle());
    app.state.notices.clear();
    app.watch_work();
    app.apply(Command::Escape);
    wait(&mut app, "the sweep to stop", |app| !app.state.doc.charts.studying);
}

#[test]
fn a_change_taken_back_while_the_capture_is_pruned_leaves_what_was_there() {
    let mut app = ready(4, 60);
    let before = app.state.doc.whole.as_ref().unwrap().samples.clone();
    set_method(&mut app, PruningMethod::Off);
    wait(&mut app, "the capture to be pruned", |app| !app.workers.whole.worker.is_idle());
    app.apply(Command::Undo);
    step(&mut app);
    app.apply(Command::Cancel);
    assert!(!app.state.doc.stopped, "what is there was made with these settings");
    wait(&mut app, "the abandoned work to stop", |app| app.workers.whole.worker.is_idle());
    settle(&mut app);
    assert!(Arc::ptr_eq(&before, &app.state.doc.whole.as_ref().unwrap().samples));
    set_method(&mut app, PruningMethod::Off);
    settle(&mut app);
    assert!(!app.state.is_stale() && !Arc::ptr_eq(&before, &app.state.doc.whole.as_ref().unwrap().samples));
}

#[test]
fn numbers_that_are_out_of_date_say_whether_they_will_be_brought_up_to_date() {
    let mut app = ready(2, 2);
    assert_eq!(app.state.stale_note(), None);
    set_method(&mut app, PruningMethod::Off);
    assert!(app.state.stale_note().unwrap().contains("being brought up to date"));
    app.state.doc.stopped = true;
    assert!(app.state.stale_note().unwrap().contains("Recompute"));
}

#[test]
fn until_a_capture_is_pruned_the_figures_are_those_of_the_frame_that_is_shown_and_say_so() {
    let mut app = ready(3, 2);
    let whole = app.state.doc.whole.take();
    let account = app.state.doc.inspected.as_ref().unwrap().account;
    assert!(account.kept > 0 && account.redundant > 0 && account.sum() == account.pixels, "{account:?}");
    let kept: u64 = app.state.doc.inspected.as_ref().unwrap().kept.iter().sum();
    assert_eq!(account.kept, kept);
    let of = |app: &OverlookApp, name: &str| {
        let figure = figures(&app.state).into_iter().find(|figure| figure.name == name).unwrap();
        (figure.value, figure.note)
    };
    for name in ["Samples kept", "Dropped", "Memory"] {
        let (value, note) = of(&app, name);
        assert!(value != "…" && note == "this frame", "{name}: {value} {note}");
    }
    app.state.doc.whole = whole;
    assert_eq!(of(&app, "Samples kept").1, "of 10.4 k", "all frames of all cameras");
    assert_eq!(of(&app, "Dropped").1, "");
}

#[test]
fn a_first_frame_that_cannot_be_read_says_so_and_is_tried_again_on_demand() {
    let folder = tempfile::tempdir().unwrap();
    let capture = folder.path().join("capture");
    copy_capture(&capture);
    // Opening looks at the first camera alone.
    let picture = capture.join("cam1/0000.exr");
    let whole = std::fs::read(&picture).unwrap();
    std::fs::write(&picture, &whole[..whole.len() / 2]).unwrap();
    let mut app = OverlookApp::new(&egui::Context::default(), None, None, Start::Path(capture)).unwrap();
    wait(&mut app, "the failure", |app| app.state.doc.stopped);
    assert!(app.tells("Could not read this frame") && app.state.is_frame_failed());
    std::fs::write(&picture, &whole).unwrap();
    app.apply(Command::Recompute);
    assert!(!app.state.is_frame_failed());
    settle(&mut app);
    assert!(app.state.is_whole_ready() && app.state.doc.live_shown.is_some());
}

#[test]
fn the_live_view_is_painted_for_others_while_it_lies_behind_them() {
    let ctx = egui::Context::default();
    let mut app = OverlookApp::new(&ctx, None, None, Start::Demo(orrery(2, 2))).unwrap();
    settle(&mut app);
    assert!(app.state.doc.live_shown.is_some());
}

#[test]
fn paths_are_remembered_so_that_they_hold_wherever_the_window_is_started() {
    let here = std::env::current_dir().unwrap();
    let mut app = ready(2, 2);
    app.take_path(Purpose::Share(&ways_out::store::STORE), "no such folder/small.ovl".into());
    wait(&mut app, "the error", |app| !app.state.notices.is_empty());
    assert!(app.state.notices[0].text.contains(&here.join("no such folder").display().to_string()));
    app.open_path("missing.ovl".as_ref());
    assert_eq!(app.state.opening, Some(here.join("missing.ovl").display().to_string()));
}
