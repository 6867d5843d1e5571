//! What a window shows that nobody gave anything to open.

use super::*;
use crate::app::model::command::{PixelCommand, SourceCommand, ViewCommand, WindowCommand};
use crate::app::model::picture::{Legend, Overlay};
use crate::app::model::window::Workspace;
use crate::app::model::{Content, SceneSource};
use crate::app::rooms::pixel::state::{InspectedPixel, Spot};
use crate::app::rooms::source::SourceLook;
use crate::app::rooms::timeline::TimeCommand;

/// A window on the room that comes with the program, at rest unless it `plays`.
fn welcomed(plays: bool) -> OverlookApp {
    let mut app = OverlookApp::new(&egui::Context::default(), None, None, Start::Welcome).unwrap();
    app.state.live.size = [200, 150];
    if !plays {
        app.apply(Command::Time(TimeCommand::Step(1)));
    }
    wait(&mut app, "the room", |app| app.state.doc.scene.is_some());
    app
}

#[test]
fn the_room_that_comes_with_the_program_opens_at_once_in_explore_moves_and_says_what_it_is_in_figures() {
    let mut app = welcomed(true);
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
    let Some(Content::Store { bytes, .. }) = app.state.content() else { panic!("it is a store") };
    assert!(*bytes <= 4_000_000, "{bytes}");
    // Who takes over before is not set in motion.
    assert!(!welcomed(false).state.timeline.playing);
    // What has no path is named by none.
    app.apply(Command::View(ViewCommand::CopyAddress));
    assert!(app.state.recent.is_empty());
}

#[test]
fn a_click_on_the_room_keeps_the_pixel_and_the_point_that_were_pointed_at() {
    let mut app = welcomed(false);
    settle(&mut app);
    for (x, y) in [(100, 75), (60, 110), (140, 100), (30, 40)] {
        let spot = Spot::Live { x, y, size: [200, 150] };
        app.apply(Command::Pixel(PixelCommand::Probe(Some(spot))));
        wait(&mut app, "the pixel", |app| {
            app.state.doc.probe.shown.as_ref().is_some_and(|probed| probed.spot == spot)
        });
        let hovered = app.state.doc.probe.shown.clone().unwrap();
        app.apply(Command::Pixel(PixelCommand::Pin(true)));
        wait(&mut app, "the pinned pixel", |app| {
            matches!(app.state.doc.probe.shown.as_ref().unwrap().spot, Spot::Source { .. })
        });
        let pinned = app.state.doc.probe.shown.clone().unwrap();
        assert_eq!((pinned.camera, pinned.x, pinned.y), (hovered.camera, hovered.x, hovered.y));
        let moved = (pinned.point_in_world.unwrap() - hovered.point_in_world.unwrap()).length();
        assert!(moved < 0.02, "the point moved by {moved} m");
        app.apply(Command::Pixel(PixelCommand::Pin(false)));
    }
}

#[test]
fn a_click_on_the_room_says_why_its_sample_was_kept_and_a_dropped_pixel_names_the_camera_that_replaces_it() {
    let mut app = welcomed(false);
    let (mut kept, mut replaced) = (0, 0);
    for (x, y) in (0..40).map(|nth| (37 * nth % 400, 53 * nth % 300)) {
        app.state.doc.probe = InspectedPixel::default();
        app.apply(Command::Pixel(PixelCommand::Probe(Some(Spot::Source { camera: 4, x, y }))));
        wait(&mut app, "the pixel", |app| app.state.doc.probe.shown.is_some());
        let probed = app.state.doc.probe.shown.clone().unwrap();
        let explanation = probed.explanation.as_ref().expect("the room says why");
        let is_kept = explanation.verdict.is_kept();
        assert!(is_kept || probed.point_in_world.is_none(), "a dropped sample has no depth here");
        kept += usize::from(is_kept);
        replaced += usize::from(!is_kept && explanation.winner.is_some_and(|winner| winner != 4));
    }
    assert!(kept > 0 && replaced > 0, "{kept} kept, {replaced} replaced");
}

#[test]
fn the_room_shows_every_camera_s_picture_with_what_became_of_its_pixels_once_they_are_looked_at() {
    let mut app = welcomed(false);
    settle(&mut app);
    assert!(app.state.doc.inspected.is_none(), "nobody looks at pictures of cameras");
    app.apply(Command::Window(WindowCommand::Workspace(Workspace::Inspect)));
    let look = SourceLook { overlay: Overlay::WhoWon, ..app.state.source };
    app.apply(Command::Source(SourceCommand::Look(look)));
    wait(&mut app, "verdicts", |app| app.state.doc.source_shown.is_some() && app.is_idle());
    let Legend::Winners { kept, lost_to, dropped, invalid } =
        app.state.doc.source_shown.as_ref().unwrap().picture.legend.clone()
    else {
        panic!("the source view does not show by which camera pixels were kept")
    };
    let pixels: u64 = lost_to.iter().sum::<u64>() + kept + dropped + invalid;
    let (width, height) = app.state.doc.scene.as_ref().unwrap().cameras[0].intrinsics.size();
    assert_eq!(pixels, (width * height) as u64);
    assert!(kept > 0 && kept * 4 < pixels && lost_to.iter().filter(|lost| **lost > 0).count() > 3);
    app.apply(Command::Window(WindowCommand::OpenView(DockView::Cameras)));
    wait(&mut app, "a small picture of every camera", |app| app.state.doc.thumbs.len() == 9);
}
