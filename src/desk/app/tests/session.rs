//! A session is saved and opened again, by itself or by another window.

use super::*;
use crate::app::model::SceneSource;
use crate::app::rooms::files::model::{FileCommand, Opening};
use crate::app::rooms::frame::model::{WindowCommand, Workspace};
use crate::app::rooms::live::model::{KeptViewCommand, ViewCommand};
use crate::app::rooms::path::model::{PathCommand, SavedPathKey};
use crate::app::rooms::timeline::model::TimeCommand;
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
        (
            state.live.orbit.clone(),
            state.live.up,
            state.timeline.frame,
            state.look.workspace,
            app.dock.to_json(),
        ),
        (state.doc.path.easing, state.doc.path.looks_at),
        state.doc.kept_views.iter().map(|kept| (kept.name.clone(), kept.view.clone())).collect::<Vec<_>>(),
        state.doc.scene.as_ref().map(|scene| scene.origin.clone()),
    )
}

#[test]
fn a_session_opens_again_with_settings_edits_path_view_and_layout_and_gives_the_same_store() {
    let folder = tempfile::tempdir().unwrap();
    let [session, store, again] = ["a.overlook", "a.ovl", "again.ovl"].map(|name| folder.path().join(name));
    let mut app = ready(2, 1);
    assert!(app.state.doc.scene.as_ref().is_some_and(|scene| matches!(scene.origin, SceneSource::Demo(_))));
    app.apply(Command::File(FileCommand::TypePath(Purpose::SaveSession)));
    assert!(
        app.notices().iter().any(|notice| notice.starts_with("No session to save")),
        "{:?}",
        app.notices()
    );
    open(&mut app, &edits::small_capture(), true);
    let mut settings = app.state.settings.clone();
    settings.pruning.depth_tolerance = 2.0;
    app.change_settings(settings);
    settle(&mut app);
    delete(&mut app, Region::ConfirmedByFewerThan(1));
    for (frame, angle) in [(0, 0.1), (2, -0.2)] {
        app.apply(Command::Time(TimeCommand::Frame(frame)));
        app.apply(Command::View(ViewCommand::Orbit(glam::DVec2::new(angle, 0.05))));
        app.apply(Command::View(ViewCommand::Kept(KeptViewCommand::Keep)));
        app.apply(Command::Path(PathCommand::AddKey));
    }
    app.apply(Command::Path(PathCommand::Ease(Easing::InOut)));
    app.apply(Command::Path(PathCommand::LookAt(Some(glam::DVec3::new(0.5, 1.0, 0.25)))));
    app.apply(Command::View(ViewCommand::Up(Some(glam::DVec3::Y))));
    app.apply(Command::Window(WindowCommand::Workspace(Workspace::Compare)));
    // The address of a view rounds it; who saved it and who opens it see the same.
    app.apply(Command::View(ViewCommand::CopyAddress));
    settle(&mut app);
    app.take_path(Purpose::SaveSession, session.clone());
    app.take_path(Purpose::SaveStore, store.clone());
    settle(&mut app);
    let before = held(&app);

    let text = std::fs::read_to_string(&session).unwrap();
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
    other.take_path(Purpose::SaveStore, again.clone());
    settle(&mut other);
    assert!(std::fs::read(store).unwrap() == std::fs::read(again).unwrap(), "another store");
}

#[test]
fn a_session_whose_capture_is_gone_or_that_is_damaged_says_so_and_leaves_what_is_open() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.overlook");
    let mut app = ready(2, 1);
    let id = app.state.doc.scene.as_ref().unwrap().id;
    for (text, words) in
        [("version = 1\nopens = \"gone\"\nup = [0, 0, 1]\n", "gone"), ("nonsense", "line 1: ")]
    {
        std::fs::write(&path, text).unwrap();
        app.apply(Command::File(FileCommand::Open(Opening::Path(path.clone()))));
        settle(&mut app);
        let notices = app.notices();
        assert!(
            notices.iter().any(|notice| notice.starts_with("Could not open") && notice.contains(words)),
            "{notices:?}"
        );
        assert_eq!(app.state.doc.scene.as_ref().unwrap().id, id);
        app.state.notices.clear();
    }
}
