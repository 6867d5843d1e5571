//! What is taken back by Ctrl+Z, and in which order.

use super::*;

#[test]
fn keys_of_the_camera_path_are_taken_back_in_the_order_of_all_changes() {
    let mut app = ready(2, 4);
    let keys =
        |app: &OverlookApp| app.state.inspector.path.keys.iter().map(|key| key.frame).collect::<Vec<_>>();
    for frame in [0, 3] {
        app.apply(Command::Frame(frame));
        app.apply(Command::AddKey);
    }
    // A key that is dragged passes many frames, and is taken back at once.
    for frame in [2, 1] {
        app.apply(Command::MoveKey { index: 1, frame });
    }
    set_method(&mut app, PruningMethod::Off);
    app.apply(Command::Undo);
    assert_eq!(keys(&app), [0, 1], "the setting was changed last");
    app.apply(Command::RemoveKey(0));
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
    app.apply(Command::ClearPath);
    app.apply(Command::Undo);
    assert_eq!(keys(&app), [0, 1]);
}
