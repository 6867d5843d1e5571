//! Paths that are chosen or typed, and what is asked before something is lost.

use std::path::Path;
use std::time::{Duration, Instant};

use crate::app::control::OverlookApp;
use crate::app::model::command::{ChartCommand, FileCommand, PathCommand, PixelCommand, ViewCommand};
use crate::app::model::look::{Background, Display};
use crate::app::model::picture::ColorBy;
use crate::app::model::purpose::{Purpose, Table};
use crate::app::model::window::DockView;
use crate::app::model::{Command, Message};
use crate::app::rooms::charts::state::Study;
use crate::app::rooms::path::SavedPathKey;
use crate::app::rooms::pixel::state::Spot;
use crate::app::tests::{add_path, change_path, ready, save_store, set_method, settle, start, step, wait};
use crate::ways_out;
use overlook_engine::settings::{PruningMethod, Settings};

fn type_path(app: &mut OverlookApp, purpose: Purpose, path: &Path) {
    app.apply(Command::File(FileCommand::AskPath(purpose)));
    app.apply(Command::File(FileCommand::TypedPath(path.display().to_string())));
    app.apply(Command::File(FileCommand::TakeTypedPath));
}

fn asks_to_replace(app: &OverlookApp) -> bool {
    app.state.typed_path.as_ref().is_some_and(|typed| typed.replaces)
}

/// Takes a path from the system's dialog.
fn choose_path(app: &mut OverlookApp, purpose: Purpose, path: &Path) {
    app.receive(Message::PathChosen { purpose, path: Some(path.to_path_buf()) });
}

#[test]
fn a_dialog_that_gives_no_path_is_never_silent() {
    let mut app = ready(2, 2);
    let mut answer = |after: u64| {
        app.has_dialogs = true;
        app.asked_at = Instant::now().checked_sub(Duration::from_millis(after));
        app.receive(Message::PathChosen { purpose: Purpose::Share(&ways_out::store::STORE), path: None });
        (app.state.typed_path.take().map(|typed| typed.text), app.notices(), app.has_dialogs)
    };
    for soon in [0, 900] {
        let typed = (Some("orrery.ovl".to_owned()), Vec::new(), false);
        assert_eq!(answer(soon), typed, "the next is typed at once");
    }
    let (typed, notices, has_dialogs) = answer(60_000);
    assert_eq!((typed, has_dialogs), (None, true));
    assert!(notices[0].starts_with("No path was chosen"));
}

#[test]
fn a_file_that_stands_at_a_typed_path_is_replaced_only_after_a_question() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("settings.toml");
    std::fs::write(&path, "old").unwrap();
    let mut app = ready(2, 2);
    type_path(&mut app, Purpose::SaveSettings, &path);
    wait(&mut app, "the question", asks_to_replace);
    app.apply(Command::File(FileCommand::TypedPath("other.toml".into())));
    assert!(!asks_to_replace(&app), "it was about another path");
    app.apply(Command::File(FileCommand::TypedPath(path.display().to_string())));
    app.apply(Command::File(FileCommand::TakeTypedPath));
    wait(&mut app, "the question", asks_to_replace);
    assert_eq!(std::fs::read_to_string(&path).unwrap(), "old");
    app.apply(Command::File(FileCommand::TakeTypedPath));
    settle(&mut app);
    assert!(app.state.typed_path.is_none());
    assert_eq!(std::fs::read_to_string(&path).unwrap(), app.state.settings.to_toml());
}

#[test]
fn pictures_are_put_beside_other_files_only_after_a_question() {
    let folder = tempfile::tempdir().unwrap();
    let [used, empty, new] = ["used", "empty", "new"].map(|name| folder.path().join(name));
    std::fs::create_dir(&used).unwrap();
    std::fs::create_dir(&empty).unwrap();
    std::fs::write(used.join("0001.png"), "old").unwrap();
    let pictures = Purpose::Share(&ways_out::pictures::PICTURES);
    let mut app = ready(2, 2);
    add_path(&mut app, 1);
    type_path(&mut app, pictures, &used);
    wait(&mut app, "the question", asks_to_replace);
    app.apply(Command::File(FileCommand::CloseTypedPath));
    choose_path(&mut app, pictures, &used);
    wait(&mut app, "the question after the dialog", asks_to_replace);
    app.apply(Command::Escape);
    assert_eq!(std::fs::read_to_string(used.join("0001.png")).unwrap(), "old");
    for folder in [empty, new] {
        type_path(&mut app, pictures, &folder);
        wait(&mut app, "the pictures", |_| folder.join("0002.png").is_file());
    }
}

#[test]
fn a_typed_path_that_cannot_be_written_comes_back_to_be_mended() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("missing/small.ovl");
    let store = Purpose::Share(&ways_out::store::STORE);
    let mut app = ready(2, 2);
    type_path(&mut app, store, &path);
    wait(&mut app, "the error", |app| !app.state.notices.is_empty());
    let typed = app.state.typed_path.take().unwrap();
    assert_eq!((typed.purpose, typed.text), (store, path.display().to_string()));
    let reason = typed.reason.unwrap();
    assert!(reason.contains("check the path") && !reason.contains(".overlook-"), "{reason}");
}

#[test]
fn no_path_is_asked_for_where_there_is_no_camera_path_to_export() {
    let mut app = ready(2, 2);
    app.apply(Command::Path(PathCommand::AddKey));
    for purpose in [Purpose::Share(&ways_out::pictures::PICTURES), Purpose::Share(&ways_out::film::VIDEO)] {
        app.apply(Command::File(FileCommand::AskPath(purpose)));
        assert!(app.state.typed_path.is_none());
        let told = app.state.notices.pop().unwrap();
        assert!(told.text.contains("two keys at least") && told.text.contains("Camera path view"));
    }
}

#[test]
fn exported_pictures_are_as_large_as_the_largest_camera_or_as_was_chosen_of_sizes_in_its_shape() {
    let folder = tempfile::tempdir().unwrap();
    let mut app = start(2, 2);
    app.state.live.size = [31, 23];
    settle(&mut app);
    assert_eq!(app.state.offered_sizes(), [[48, 36], [1280, 960], [1920, 1440], [3840, 2880]]);
    add_path(&mut app, 1);
    for (chosen, expected) in [(None, (48, 36)), (Some([65, 30]), (64, 30))] {
        if let Some(size) = chosen {
            change_path(&mut app, None, |path| path.size = Some(size));
        }
        let pictures = folder.path().join(format!("{expected:?}"));
        app.take_path(Purpose::Share(&ways_out::pictures::PICTURES), pictures.clone());
        wait(&mut app, "the pictures", |app| app.tells("Exported"));
        app.state.notices.clear();
        assert_eq!(image::image_dimensions(pictures.join("0001.png")).unwrap(), expected);
    }
}

#[test]
fn a_key_of_a_camera_path_that_nobody_sees_is_told() {
    let mut app = ready(2, 2);
    app.apply(Command::Path(PathCommand::AddKey));
    assert!(app.notices()[0].starts_with("Key 1 added") && app.notices()[0].contains("Camera path"));
    app.state.notices.clear();
    app.dock.open(DockView::Path);
    app.apply(Command::Path(PathCommand::AddKey));
    assert!(app.notices().is_empty());
}

#[test]
fn keys_of_the_path_have_the_pictures_of_their_views() {
    let mut app = ready(2, 2);
    let pictured = |app: &OverlookApp| -> Vec<bool> {
        let view = |key: &SavedPathKey| app.state.address_of(&key.orbit, key.frame).unwrap();
        let (doc, keys) = (&app.state.doc, &app.state.doc.path.keys);
        keys.iter().map(|key| doc.view_pictures.of(&view(key)).is_some()).collect()
    };
    app.apply(Command::Path(PathCommand::AddKey));
    assert_eq!(pictured(&app), [true], "it is shown already");
    app.apply(Command::View(ViewCommand::Orbit(glam::DVec2::new(0.3, 0.1))));
    app.apply(Command::Path(PathCommand::AddKey));
    assert_eq!(pictured(&app), [true, false]);
    settle(&mut app);
    assert_eq!(pictured(&app), [true, true]);
}

#[test]
fn the_pixel_that_is_looked_at_is_framed_and_without_one_nothing_moves() {
    let mut app = ready(2, 2);
    app.apply(Command::View(ViewCommand::Orbit(glam::DVec2::new(0.3, 0.1))));
    let before = app.state.live.orbit.clone();
    app.apply(Command::View(ViewCommand::FramePoint));
    assert_eq!(app.state.live.orbit, before);
    assert!(app.notices()[0].starts_with("Point at a pixel first"));
    app.apply(Command::Pixel(PixelCommand::Probe(Some(Spot::Source { camera: 0, x: 20, y: 22 }))));
    wait(&mut app, "the pixel", |app| app.state.doc.probe.shown.is_some());
    assert!(!app.state.doc.probe.pinned);
    app.apply(Command::View(ViewCommand::FramePoint));
    assert_ne!(app.state.live.orbit, before);
}

#[test]
fn escape_stops_work_before_it_lets_go_of_a_pixel() {
    let mut app = ready(2, 2);
    app.apply(Command::Pixel(PixelCommand::Probe(Some(Spot::Source { camera: 0, x: 24, y: 18 }))));
    app.apply(Command::Pixel(PixelCommand::Pin(true)));
    app.apply(Command::Chart(ChartCommand::Study(Study::Sweep)));
    step(&mut app);
    app.apply(Command::Escape);
    assert!(app.state.doc.probe.pinned);
    wait(&mut app, "the sweep to stop", |app| !app.state.doc.charts.studying);
    step(&mut app);
    wait(&mut app, "the pixel", |app| app.state.doc.probe.shown.is_some());
    // Messages close before anything else.
    app.state.notices.clear();
    app.apply(Command::Escape);
    assert!(!app.state.doc.probe.pinned);
    settle(&mut app);
    assert!(app.state.doc.probe.shown.is_none(), "nothing more is said of it");
}

#[test]
fn a_stress_test_keeps_the_points_of_the_one_before_until_it_has_its_own() {
    let mut app = ready(2, 2);
    app.apply(Command::Chart(ChartCommand::Study(Study::Stress)));
    wait(&mut app, "three points", |app| app.state.doc.charts.stress.len() > 2);
    app.apply(Command::Escape);
    wait(&mut app, "the test to stop", |app| !app.state.doc.charts.studying);
    let before = app.state.doc.charts.stress.len();
    // With the same settings it would go on.
    set_method(&mut app, PruningMethod::FirstCamera);
    settle(&mut app);
    app.apply(Command::Chart(ChartCommand::Study(Study::Stress)));
    assert_eq!(app.state.doc.charts.stress.len(), before);
    wait(&mut app, "the first new point", |app| app.state.doc.charts.stress.len() < before);
}

#[test]
fn settings_loaded_beside_a_store_do_not_claim_to_have_changed_its_thresholds() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("small.ovl");
    let mut app = ready(2, 2);
    set_method(&mut app, PruningMethod::Off);
    settle(&mut app);
    save_store(&mut app, &path);
    let loaded = || Message::SettingsLoaded { path: "kept.toml".into(), settings: Settings::default() };
    app.state.notices.clear();
    app.receive(loaded());
    assert_eq!(app.notices(), ["Settings loaded: kept.toml"]);
    app.open_path(&path);
    wait(&mut app, "the store", |app| !app.state.has_capture());
    app.state.notices.clear();
    app.receive(loaded());
    assert!(app.notices()[0].contains("captures opened from now on"), "{:?}", app.notices());
    assert_eq!(app.state.settings.pruning.method, PruningMethod::HighestRate);
    assert_eq!(app.state.shown_settings().pruning.method, PruningMethod::Off, "those of the store are shown");
}

#[test]
fn a_picture_is_saved_as_it_is_shown_and_under_the_name_of_its_format_alone() {
    let folder = tempfile::tempdir().unwrap();
    let [bare, png, jpg] = ["view", "view.png", "view.jpg"].map(|name| folder.path().join(name));
    let picture = Purpose::Share(&ways_out::pictures::PICTURE);
    let mut app = ready(2, 2);
    app.apply(Command::View(ViewCommand::look(&app.state.live, |live| live.color_by = ColorBy::Camera)));
    settle(&mut app);
    for take in [choose_path, type_path] {
        take(&mut app, picture, &jpg);
        let typed = app.state.typed_path.take().unwrap();
        assert_eq!(typed.reason.unwrap(), "A picture is written as PNG or EXR; name it .png or .exr.");
    }
    choose_path(&mut app, picture, &bare);
    wait(&mut app, "the picture", |_| png.is_file());
    type_path(&mut app, picture, &bare);
    wait(&mut app, "the question", asks_to_replace);
    assert!(!bare.exists() && !jpg.exists());
    let saved = image::open(&png).unwrap().into_rgb8();
    let shown = app.state.shown_picture().unwrap();
    let rgb = shown.pixels.iter().map(|pixel| [pixel.r(), pixel.g(), pixel.b()]);
    assert!(saved.pixels().map(|pixel| pixel.0).eq(rgb));
}

#[test]
fn a_picture_of_this_view_is_saved_in_a_chosen_size_with_alpha() {
    let folder = tempfile::tempdir().unwrap();
    let png = folder.path().join("view.png");
    let mut app = ready(2, 2);
    app.state.share.options.picture_size = Some([96, 72]);
    app.apply(Command::Display(Display { background: Background::Transparent, ..Display::default() }));
    // From afar, so that there is sky around the scene.
    app.apply(Command::View(ViewCommand::Dolly(4.0, None)));
    settle(&mut app);
    choose_path(&mut app, Purpose::Share(&ways_out::pictures::PICTURE), &png);
    wait(&mut app, "the picture", |app| app.notices().iter().any(|told| told.contains("96×72")));
    let saved = image::open(&png).unwrap().into_rgba8();
    assert_eq!(saved.dimensions(), (96, 72));
    let alphas: Vec<u8> = saved.pixels().map(|pixel| pixel.0[3]).collect();
    assert!(alphas.contains(&0) && alphas.contains(&255), "the sky is left out");
    assert_eq!(app.state.shown_picture().unwrap().size, [48, 36], "the window shows what it did");
}

#[test]
fn a_sweep_is_saved_as_csv_once_it_has_a_point() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("points.csv");
    let mut app = ready(2, 2);
    let save = Purpose::SaveTable(Table::Sweep);
    app.apply(Command::File(FileCommand::AskPath(save)));
    assert!(app.state.typed_path.is_none() && app.notices()[0].starts_with("Nothing to save yet"));
    app.apply(Command::Chart(ChartCommand::Study(Study::Sweep)));
    wait(&mut app, "a point", |app| !app.state.doc.charts.sweep.is_empty());
    app.workers.study.cancel();
    type_path(&mut app, save, &file);
    wait(&mut app, "the file", |_| file.is_file());
    let text = std::fs::read_to_string(&file).unwrap();
    assert!(text.starts_with("label,series,kernel,") && text.lines().count() > 1, "{text}");
}
