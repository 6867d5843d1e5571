//! What a window shows that nobody gave anything to open.

use super::*;
use crate::app::model::command::ViewCommand;
use crate::app::model::window::Workspace;
use crate::app::model::{Content, SceneSource};
use crate::app::rooms::timeline::TimeCommand;

#[test]
fn the_room_that_comes_with_the_program_opens_at_once_in_explore_moves_and_says_what_it_is_in_figures() {
    let mut app = OverlookApp::new(&egui::Context::default(), None, None, Start::Welcome).unwrap();
    app.state.live.size = [200, 150];
    wait(&mut app, "the room", |app| app.state.doc.scene.is_some());
    let scene = app.state.doc.scene.clone().unwrap();
    assert_eq!((scene.origin.clone(), app.state.look.workspace), (SceneSource::Room, Workspace::Explore));
    assert!(app.state.timeline.playing && scene.frame_count() > 1);
    assert!(scene.cameras.len() == 9 && app.state.report().is_some_and(|report| report.samples_kept > 0));
    let before = app.state.timeline.frame;
    wait(&mut app, "time to pass", |app| app.state.timeline.frame != before);
    wait(&mut app, "a picture", |app| app.state.doc.live_shown.is_some());
    let shown = app.state.doc.live_shown.as_ref().unwrap();
    assert!(shown.key.quality.is_some(), "while it plays no picture takes the time of one at rest");
    let stats = shown.picture.stats;
    assert!(stats.holes * 10 < 200 * 150, "{} of the first view's pixels are invented", stats.holes);
    let bytes = match app.state.content() {
        Some(Content::Store { bytes, .. }) => *bytes,
        _ => panic!("it is a store"),
    };
    assert!(bytes <= 4_000_000, "{bytes}");
    // Who takes over before is not set in motion.
    let mut other = OverlookApp::new(&egui::Context::default(), None, None, Start::Welcome).unwrap();
    other.apply(Command::Time(TimeCommand::Step(1)));
    wait(&mut other, "the room", |app| app.state.doc.scene.is_some());
    assert!(!other.state.timeline.playing);
    // What has no path is named by none.
    app.apply(Command::View(ViewCommand::CopyAddress));
    assert!(app.state.recent.is_empty());
}
