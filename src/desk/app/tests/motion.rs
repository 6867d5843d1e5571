//! What the live view shows while it moves, and once it rests.

use glam::DVec2;

use crate::app::control::OverlookApp;
use crate::app::model::Same;
use crate::app::model::command::{PixelCommand, ViewCommand};
use crate::app::model::picture::{CarriedLook, CarryKey, LiveKey, PixelSource};
use crate::app::model::{Command, Message};
use crate::app::rooms::pixel::state::Spot;
use crate::app::tests::{ready, settle};
use overlook_engine::capture::Camera;

const SIZE: [u32; 2] = [48, 36];

fn turn(app: &mut OverlookApp) -> Camera {
    app.apply(Command::View(ViewCommand::Orbit(DVec2::new(0.1, 0.02))));
    app.state.live_camera(SIZE).unwrap()
}

/// The answer that the picture is carried to a camera: any picture will do.
fn carried(app: &OverlookApp, to: &Camera) -> Message {
    let shown = app.state.doc.live_shown.as_ref().unwrap();
    let PixelSource::InMemory { image, rendered } = &shown.picture.pixels else { panic!("on a card") };
    let carried = CarriedLook { image: image.clone(), inverse_depth: rendered.inverse_depth.clone() };
    let (picture, from) = (shown.picture.clone(), shown.key.vantage.camera.clone());
    let key = CarryKey { scene: shown.key.scene, picture: Same(picture), from, to: to.clone() };
    Message::LiveCarried { key, carried: Some(carried) }
}

/// The answer that a picture like the one shown is painted.
fn painted(app: &OverlookApp, change: impl FnOnce(&mut LiveKey)) -> Message {
    let shown = app.state.doc.live_shown.as_ref().unwrap();
    let mut key = shown.key.clone();
    change(&mut key);
    Message::LivePainted { key, picture: shown.picture.clone() }
}

#[test]
fn what_is_drawn_over_a_picture_lies_where_that_picture_shows_it_until_it_is_carried() {
    let mut app = ready(2, 2);
    let before = app.state.seen_camera(SIZE).unwrap();
    let positions = |app: &OverlookApp| app.observed().cameras_on_screen.clone();
    let drawn = positions(&app);
    let here = turn(&mut app);
    assert_ne!(here.world_from_camera, before.world_from_camera);
    assert_eq!(app.state.seen_camera(SIZE).as_ref(), Some(&before), "the picture is that of before");
    assert_eq!(positions(&app), drawn);
    let message = carried(&app, &here);
    app.receive(message);
    let seen = app.state.live_seen().unwrap();
    assert_eq!(seen.camera, &here);
    assert_ne!(seen.texture, app.state.doc.live_shown.as_ref().unwrap().texture.id());
}

#[test]
fn the_pixel_under_the_pointer_keeps_its_place_in_the_scene_when_the_picture_changes_its_size() {
    let mut app = ready(2, 1);
    let size = |app: &OverlookApp| app.state.doc.live_shown.as_ref().unwrap().picture.size;
    let point = |app: &OverlookApp| app.state.doc.probe.shown.as_ref().unwrap().point_in_world.unwrap();
    let spot = Spot::Live { x: 24, y: 18, size: size(&app) };
    assert_eq!(size(&app), [48, 36]);
    app.apply(Command::Pixel(PixelCommand::Probe(Some(spot))));
    settle(&mut app);
    let before = point(&app);
    app.apply(Command::View(ViewCommand::Size([96, 72])));
    settle(&mut app);
    assert_eq!(size(&app), [96, 72]);
    let apart = (point(&app) - before).length();
    let distance = app.state.live.orbit.as_ref().unwrap().pivot_distance;
    assert!(apart < 0.05 * distance, "{apart} at {distance}");
}

#[test]
fn a_picture_that_the_view_has_left_does_not_take_it_back() {
    let mut app = ready(2, 2);
    let before = app.state.seen_camera(SIZE).unwrap();
    let here = turn(&mut app);
    let message = carried(&app, &here);
    app.receive(message);
    let late = painted(&app, |_| {});
    app.receive(late);
    assert_eq!(app.state.live_seen().unwrap().camera, &here);
    assert_eq!(
        app.state.doc.live_shown.as_ref().unwrap().key.vantage.camera,
        before,
        "it is carried from now on"
    );
    let current = painted(&app, |key| key.vantage.camera = here.clone());
    app.receive(current);
    assert!(app.state.doc.live_carried.is_none());
    // What was carried in the meantime is of no use any more.
    let message = carried(&app, &here);
    app.receive(message);
    assert!(app.state.doc.live_carried.is_none());
}

#[test]
fn at_rest_the_picture_is_exact_and_of_full_size_and_nothing_is_carried() {
    let mut app = ready(2, 2);
    for _ in 0..3 {
        let here = turn(&mut app);
        settle(&mut app);
        let shown = app.state.doc.live_shown.as_ref().unwrap();
        assert_eq!((&shown.key.vantage.camera, shown.key.quality.is_none()), (&here, true));
        assert_eq!(shown.key.settings, app.state.settings.render);
        assert_eq!(shown.picture.size, SIZE.map(|side| side as usize));
        assert!(app.state.doc.live_carried.is_none());
    }
}
