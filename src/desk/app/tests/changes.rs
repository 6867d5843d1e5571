//! What the window tells of a change of settings.

use super::*;
use crate::app::rooms::files::paths::no_figure;
use crate::ways_out::figure::{FIGURE, FigureOf};

fn set_depth_tolerance(app: &mut OverlookApp, footprints: f64) {
    set(app, "pruning.depth_tolerance", footprints);
    assert_eq!(f64::from(app.state.settings.pruning.depth_tolerance), f64::from(footprints as f32));
}

/// Whether samples of the last change are seen coming or going.
fn glows(app: &OverlookApp, came: bool) -> bool {
    app.state.doc.change.glows.iter().any(|glow| glow.came == came)
}

#[test]
fn samples_are_seen_coming_and_going_as_a_threshold_turns_and_then_no_more() {
    let mut app = ready(3, 2);
    set_depth_tolerance(&mut app, 0.05);
    wait(&mut app, "samples that come", |app| glows(app, true));
    set_depth_tolerance(&mut app, 4.0);
    wait(&mut app, "samples that go", |app| glows(app, false));
    settle(&mut app);
    wait(&mut app, "the end of it", |app| app.state.doc.change.glows.is_empty());
    app.state.live.shows_changes = false;
    set_depth_tolerance(&mut app, 1.0);
    settle(&mut app);
    assert!(app.state.doc.change.glows.is_empty(), "it is switched off");
}

#[test]
fn a_figure_keeps_what_the_last_change_dropped_and_brought_back() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("change.svg");
    let mut app = ready(3, 2);
    assert!(no_figure(&app.state, FigureOf::Change).is_some_and(|why| why.contains("turn a threshold")));
    set_depth_tolerance(&mut app, 0.05);
    settle(&mut app);
    assert_eq!(no_figure(&app.state, FigureOf::Change), None);
    app.state.share.options.figure_of = FigureOf::Change;
    app.take_path(Purpose::Share(&FIGURE), path.clone());
    settle(&mut app);
    let figure = std::fs::read_to_string(&path).unwrap();
    let told =
        |name: &str| figure.split(name).nth(1).and_then(|rest| rest.split('<').next()).unwrap().to_owned();
    let [dropped, back] = ["dropped, ", "brought back, "].map(told);
    assert!(back.ends_with("samples") && !back.starts_with("0 "), "{dropped} dropped, {back} brought back");
}

#[test]
fn figures_before_a_change_stay_beside_those_after_it_until_the_next() {
    let mut app = ready(3, 2);
    let kept = |app: &OverlookApp| app.state.report().unwrap().samples_kept;
    let first = kept(&app);
    assert!(app.state.differences().is_empty());
    set_depth_tolerance(&mut app, 0.5);
    set_depth_tolerance(&mut app, 0.05);
    settle(&mut app);
    let second = kept(&app);
    assert!(second > first, "{second} of {first}");
    let before = |app: &OverlookApp| app.state.doc.change.before.as_ref().unwrap().samples;
    assert_eq!(before(&app), Some(first), "one change, however often the threshold was turned");
    let told = app.state.differences();
    for name in ["This frame", "Samples kept", "Memory"] {
        assert!(told.iter().any(|it| it.name == name), "{name}: {told:?}");
    }
    assert!(told.iter().all(|it| it.now.is_some()), "{told:?}");
    app.apply(Command::Undo);
    settle(&mut app);
    assert_eq!(before(&app), Some(second), "taking it back is the next change");
    set_depth_tolerance(&mut app, 0.05);
    set_depth_tolerance(&mut app, 1.0);
    assert!(app.state.doc.change.before.is_none(), "turned back before anything was pruned");
}
