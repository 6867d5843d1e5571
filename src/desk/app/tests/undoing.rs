//! What is taken back by Ctrl+Z, and in which order.

use super::*;
use crate::app::model::command::{PathCommand, ViewCommand};
use crate::app::rooms::timeline::TimeCommand;

#[test]
fn keys_of_the_camera_path_are_taken_back_in_the_order_of_all_changes() {
    let mut app = ready(2, 4);
    let keys = |app: &OverlookApp| app.state.doc.path.keys.iter().map(|key| key.frame).collect::<Vec<_>>();
    for frame in [0, 3] {
        app.apply(Command::Time(TimeCommand::Frame(frame)));
        app.apply(Command::Path(PathCommand::AddKey));
    }
    // A key that is dragged passes many frames, and is taken back at once.
    for frame in [2, 1] {
        change_path(&mut app, Some(1), |path| path.move_key(1, frame));
    }
    set_method(&mut app, PruningMethod::Off);
    app.apply(Command::Undo);
    assert_eq!(keys(&app), [0, 1], "the setting was changed last");
    change_path(&mut app, None, |path| path.remove_key(0));
    app.apply(Command::Undo);
    assert_eq!(keys(&app), [0, 1]);
    app.apply(Command::Undo);
    assert_eq!(keys(&app), [0, 3]);
    app.apply(Command::Undo);
    app.apply(Command::Undo);
    assert!(keys(&app).is_empty());
    for _ in 0..3 {
        app.apply(Command::Redo);
    }
    assert_eq!(keys(&app), [0, 1]);
    change_path(&mut app, None, CameraPath::clear);
    app.apply(Command::Undo);
    assert_eq!(keys(&app), [0, 1]);
}

#[test]
fn changes_are_listed_by_name_in_the_order_in_which_undo_takes_them_back() {
    let mut app = ready(2, 4);
    assert!(!app.state.can_undo(true) && app.state.undo_list(true).is_empty());
    set_method(&mut app, PruningMethod::Off);
    for frame in [0, 3] {
        app.apply(Command::Time(TimeCommand::Frame(frame)));
        app.apply(Command::Path(PathCommand::AddKey));
    }
    change_path(&mut app, Some(1), |path| path.move_key(1, 2));
    let expected = ["Change key 2", "Add key 2", "Add key 1", "Pruning method: Highest sampling rate » Off"];
    assert_eq!(app.state.undo_list(true), expected);
    for taken_back in 1..=expected.len() {
        app.apply(Command::Undo);
        assert_eq!(app.state.undo_list(true), expected[taken_back..]);
    }
    assert!(!app.state.can_undo(true) && app.state.can_undo(false));
    assert_eq!(app.state.undo_list(false).len(), expected.len());
}

#[test]
fn a_turn_replaces_the_keys_of_the_path_and_they_come_back() {
    let mut app = ready(2, 4);
    for angle in [0.1, 0.2] {
        app.apply(Command::View(ViewCommand::Orbit(glam::DVec2::new(angle, 0.0))));
        app.apply(Command::Path(PathCommand::AddKey));
    }
    let before = app.state.doc.path.shape();
    app.apply(Command::Path(PathCommand::TurnAround));
    let path = &app.state.doc.path;
    assert_eq!((path.keys.len(), path.is_closed), (12, true));
    assert!(app.notices().iter().any(|told| told.contains("2 keys before")), "{:?}", app.notices());
    app.apply(Command::Undo);
    assert_eq!(app.state.doc.path.shape(), before);
    change_path(&mut app, None, |path| path.is_closed = true);
    app.apply(Command::Undo);
    assert_eq!(app.state.doc.path.shape(), before);
}

#[test]
fn a_view_that_was_left_by_a_jump_is_gone_back_to_and_left_again() {
    let mut app = ready(3, 1);
    let view = |app: &OverlookApp| app.state.live.orbit.clone().unwrap();
    let go = |app: &mut OverlookApp, command| app.apply(Command::View(command));
    app.apply(Command::View(ViewCommand::Orbit(glam::DVec2::new(0.3, 0.1))));
    let turned = view(&app);
    app.apply(Command::View(ViewCommand::JumpTo(1)));
    app.apply(Command::View(ViewCommand::Dolly(0.5, None)));
    let near = view(&app);
    app.apply(Command::View(ViewCommand::Home));
    let home = view(&app);
    app.apply(Command::View(ViewCommand::Home));
    go(&mut app, ViewCommand::Back);
    assert_eq!(view(&app), near, "a jump to where the view is leaves nothing");
    go(&mut app, ViewCommand::Back);
    assert_eq!(view(&app), turned);
    go(&mut app, ViewCommand::Back);
    assert_eq!(view(&app), turned, "there is nothing before");
    go(&mut app, ViewCommand::Forward);
    go(&mut app, ViewCommand::Forward);
    assert_eq!(view(&app), home);
}
