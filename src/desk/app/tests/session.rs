//! A session is saved and opened again, by itself or by another window.

use super::*;
use crate::app::model::SceneSource;
use crate::app::model::command::{
    FileCommand, KeptViewCommand, Opening, PathCommand, SourceCommand, ViewCommand, WindowCommand,
};
use crate::app::model::look::{Background, Display};
use crate::app::model::picture::{ColorBy, HoleDisplay, Overlay};
use crate::app::model::window::Workspace;
use crate::app::rooms::compare::state::{CompareMode, CompareVantage};
use crate::app::rooms::path::SavedPathKey;
use crate::app::rooms::timeline::TimeCommand;
use crate::app::tests::edits::{delete, open};
use overlook_engine::capture::transforms::Easing;
use overlook_engine::edits::Region;

/// Everything that a session holds, of a window.
fn held(app: &OverlookApp) -> impl PartialEq + std::fmt::Debug + use<> {
    let state = &app.state;
    // Files have the poses of keys as matrices, whose last bits are rounded.
    let rounded = |number: f64| (number * 1e9).round() as i64;
    let pose = |key: &SavedPathKey| key.orbit.world_from_camera.to_cols_array().map(rounded);
    let keys: Vec<_> = state.doc.path.keys.iter().map(|key| (pose(key), key.frame)).collect();
    (
        (state.settings.clone(), state.doc.edits.list.clone(), state.doc.path.pictures_per_leg, keys),
        (state.live.orbit.clone(), state.live.up, state.timeline.frame, state.look.workspace),
        (state.doc.path.easing, state.doc.path.looks_at, app.dock.to_json()),
        (
            (state.source.overlay, state.source.camera, state.live.color_by, state.live.holes, state.display),
            (state.live.cameras.clone(), state.timeline.markers.clone(), state.timeline.range),
            (state.inspector.compare.choice, state.inspector.compare.mode),
        ),
        state.doc.kept_views.iter().map(|kept| (kept.name.clone(), kept.view.clone())).collect::<Vec<_>>(),
        state.doc.scene.as_ref().map(|scene| scene.origin.clone()),
    )
}

/// A capture with a setting and an edit of its own.
fn open_pruned_otherwise_and_cut(app: &mut OverlookApp) {
    open(app, &small_capture(), true);
    let mut settings = app.state.settings.clone();
    settings.pruning.depth_tolerance = 2.0;
    app.change_settings(settings);
    settle(app);
    delete(app, Region::ConfirmedByFewerThan(1));
}

#[test]
fn a_session_opens_again_with_settings_edits_path_view_and_layout_and_gives_the_same_store() {
    let folder = tempfile::tempdir().unwrap();
    let [session, store, again] = ["a.overlook", "a.ovl", "again.ovl"].map(|name| folder.path().join(name));
    let mut app = ready(2, 1);
    assert!(app.state.doc.scene.as_ref().is_some_and(|scene| matches!(scene.origin, SceneSource::Demo(_))));
    app.apply(Command::File(FileCommand::AskPath(Purpose::SaveSession)));
    assert!(app.tells("No session to save"), "{:?}", app.notices());
    open_pruned_otherwise_and_cut(&mut app);
    for (frame, angle) in [(0, 0.1), (2, -0.2)] {
        app.apply(Command::Time(TimeCommand::Frame(frame)));
        app.apply(Command::View(ViewCommand::Orbit(glam::DVec2::new(angle, 0.05))));
        app.apply(Command::View(ViewCommand::Kept(KeptViewCommand::Keep)));
        app.apply(Command::Path(PathCommand::AddKey));
    }
    change_path(&mut app, None, |path| {
        path.easing = Easing::InOut;
        path.looks_at = Some(glam::DVec3::new(0.5, 1.0, 0.25));
    });
    app.apply(Command::View(ViewCommand::Up(Some(glam::DVec3::Y))));
    app.apply(Command::Window(WindowCommand::Workspace(Workspace::Compare)));
    app.apply(Command::Source(SourceCommand::Camera(1)));
    app.state.source.overlay = Overlay::WhoWon;
    app.apply(Command::View(ViewCommand::look(&app.state.live, |live| live.color_by = ColorBy::Camera)));
    app.apply(Command::View(ViewCommand::Holes(HoleDisplay::Hatched)));
    app.apply(Command::View(ViewCommand::look(&app.state.live, |live| live.cameras.switch(0, false))));
    let background = Background::Solid([1, 2, 3]);
    app.apply(Command::Display(Display { exposure: 0.7, background, ..Display::default() }));
    app.state.timeline.markers.insert(2);
    app.state.timeline.range = Some([0, 1]);
    app.state.inspector.compare.choice.sides = [CompareSide::Truth, CompareSide::Gather];
    app.state.inspector.compare.choice.from = CompareVantage::HoldOut(1);
    app.state.inspector.compare.mode = CompareMode::Difference;
    // The address of a view rounds it; who saved it and who opens it see the same.
    app.apply(Command::View(ViewCommand::CopyAddress));
    settle(&mut app);
    app.take_path(Purpose::SaveSession, session.clone());
    save_store(&mut app, &store);
    let before = held(&app);
    assert_eq!(app.state.unsaved_work(), None, "what a session holds is saved");

    let text = std::fs::read_to_string(&session).unwrap();
    let poses = text.matches("transform_matrix").count();
    assert_eq!(poses, 2, "the keys of the path are written, not each picture");
    assert!(text.lines().nth(1).unwrap().contains("--set pruning.depth_tolerance=2"), "{text}");
    let mut other = OverlookApp::new(&egui::Context::default(), None, None, Start::Path(session)).unwrap();
    other.state.live.size = [48, 36];
    settle(&mut other);
    assert_eq!(held(&other), before);
    let is_pictured = |app: &OverlookApp| -> Vec<bool> {
        let doc = &app.state.doc;
        doc.kept_views.iter().map(|kept| doc.view_pictures.of(&kept.view).is_some()).collect()
    };
    let kept = &other.state.doc.kept_views;
    assert!(kept.len() == 2 && is_pictured(&other) == [false, false]);
    let left = other.state.live.orbit.clone();
    other.apply(Command::View(ViewCommand::Kept(KeptViewCommand::GoTo(0))));
    settle(&mut other);
    assert!(is_pictured(&other) == [true, false] && other.state.timeline.frame == 0);
    other.apply(Command::View(ViewCommand::Back));
    assert_eq!(other.state.live.orbit, left);
    save_store(&mut other, &again);
    assert!(std::fs::read(store).unwrap() == std::fs::read(again).unwrap(), "another store");
}

#[test]
fn the_command_that_prunes_the_same_is_copied_and_what_has_none_says_so() {
    let mut app = ready(2, 1);
    app.apply(Command::File(FileCommand::CopyCommandLine));
    assert!(copied(&app).is_none() && app.notices()[0].starts_with("No session to save"));
    open_pruned_otherwise_and_cut(&mut app);
    app.state.notices.clear();
    app.apply(Command::File(FileCommand::CopyCommandLine));
    let line = copied(&app).unwrap();
    assert!(line.starts_with("overlook preprocess "), "{line}");
    assert!(line.ends_with("--set pruning.depth_tolerance=2.0 --edits edits.toml"), "{line}");
    assert!(app.notices()[0].contains("Save the edits as edits.toml first"));
}

#[test]
fn a_session_whose_capture_is_gone_or_that_is_damaged_says_so_and_leaves_what_is_open() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.overlook");
    let mut app = ready(2, 1);
    let id = app.state.doc.scene.as_ref().unwrap().id;
    let of_gone = "version = 1\nopens = \"gone\"\nup = [0, 0, 1]\n";
    for (text, words) in [(of_gone, "gone"), ("nonsense", "line 1: ")] {
        std::fs::write(&path, text).unwrap();
        app.apply(Command::File(FileCommand::Open(Opening::Path(path.clone()))));
        settle(&mut app);
        let is_it = |notice: &String| notice.starts_with("Could not open") && notice.contains(words);
        assert!(app.notices().iter().any(is_it), "{:?}", app.notices());
        assert_eq!(app.state.doc.scene.as_ref().unwrap().id, id);
        app.state.notices.clear();
    }
}
