//! Edits in the window: what is selected and deleted is shown, taken back and saved, with the bytes that lists give elsewhere.

use std::path::Path;
use std::time::Duration;

use crate::app::model::command::{Combine, EditCommand, ViewCommand};
use crate::app::model::picture::LiveKey;
use crate::app::model::purpose::{Purpose, ShareCommand};
use crate::app::model::{Command, Same, count};
use crate::app::rooms::report::ui::figures;
use crate::app::tests::{OverlookApp, ready, save_store, set, settle, small_capture, wait};
use crate::app::work::worker::Wanted;
use crate::pruned_store;
use crate::ways_out::Way;
use overlook_engine::capture;
use overlook_engine::edited_store::write_edited_store;
use overlook_engine::edits::{Action, EditList, Region, Stroke, Viewpoint};
use overlook_engine::job::Job;
use overlook_engine::preprocess::diagnostics::Report;
use overlook_engine::render::Picture;
use overlook_engine::store::file::Store;

pub(crate) fn open(app: &mut OverlookApp, path: &Path, is_capture: bool) {
    let before = app.state.doc.scene.as_ref().map(|scene| scene.id);
    app.state.doc.edits.saved = app.state.doc.edits.list.clone();
    app.open_path(path);
    wait(app, "the scene", |app| {
        app.state.doc.scene.as_ref().is_some_and(|scene| Some(scene.id) != before)
            && app.state.has_capture() == is_capture
    });
    settle(app);
}

fn edit(app: &mut OverlookApp, command: EditCommand) {
    app.apply(Command::Edit(command));
    settle(app);
}

pub(crate) fn delete(app: &mut OverlookApp, region: Region) {
    edit(app, EditCommand::Select(region));
    assert!(app.state.edited().unwrap().selected > 0);
    edit(app, EditCommand::Act(Action::Delete));
}

fn picture(app: &OverlookApp) -> Picture {
    Picture::clone(app.state.doc.live_shown.as_ref().unwrap().picture.rendered().unwrap())
}

fn shows_same(a: &Picture, b: &Picture) -> bool {
    a.color == b.color && a.inverse_depth == b.inverse_depth
}

fn is_alike(a: &Path, b: &Path) -> bool {
    std::fs::read(a).unwrap() == std::fs::read(b).unwrap()
}

/// Saves the edits of the small capture and its store: the list gives the same bytes without a window.
fn saved_alike(app: &mut OverlookApp, [list, store, beside]: [&Path; 3]) -> Report {
    app.take_path(Purpose::SaveEdits, list.to_path_buf());
    save_store(app, store);
    let edits = EditList::load(list).unwrap();
    assert_eq!(edits, app.state.doc.edits.list);
    let settings = &app.state.settings;
    let capture = capture::open(&small_capture(), &settings.capture).unwrap();
    let (report, _) =
        pruned_store::prune_into_store(&capture, None, settings, &edits, beside, &Job::new()).unwrap();
    assert!(is_alike(store, beside));
    report
}

fn middle(app: &OverlookApp, radius: f64) -> Region {
    let center = app.state.doc.scene.as_ref().unwrap().pivot_in_world.to_array();
    Region::Sphere { center, radius: radius * app.state.live.orbit.as_ref().unwrap().pivot_distance }
}

#[test]
fn a_capture_is_cleaned_by_hand_and_its_list_gives_the_same_bytes_elsewhere_and_when_it_is_opened_again() {
    let folder = tempfile::tempdir().unwrap();
    let [list, store, again, beside] =
        ["edits.toml", "clean.ovl", "again.ovl", "beside.ovl"].map(|name| folder.path().join(name));
    let mut app = ready(2, 1);
    open(&mut app, &small_capture(), true);
    let before = picture(&app);
    let region = middle(&app, 0.3);
    edit(&mut app, EditCommand::Select(region.clone()));
    assert!(!shows_same(&picture(&app), &before), "the selection is in a color of its own");
    edit(&mut app, EditCommand::SelectNothing);
    assert!(shows_same(&picture(&app), &before));
    delete(&mut app, region);
    let deleted = app.state.edited().unwrap().deleted;
    assert!(deleted > 0 && !shows_same(&picture(&app), &before));
    app.apply(Command::Undo);
    settle(&mut app);
    assert!(shows_same(&picture(&app), &before) && app.state.edited_samples().is_none());
    app.apply(Command::Redo);
    settle(&mut app);
    assert_eq!(app.state.edited().unwrap().deleted, deleted);
    delete(&mut app, Region::ConfirmedByFewerThan(1));
    edit(&mut app, EditCommand::LeaveOut(vec![1]));
    assert!(app.state.unsaved_work().is_some_and(|work| work.contains("3 edits")));
    let edited = app.state.edited().unwrap();
    assert_eq!(edited.counts.iter().sum::<i64>(), edited.deleted as i64);
    assert!(edited.counts.len() == 3 && edited.counts[2] > 0, "{:?}", edited.counts);
    let figure = &figures(&app.state)[0];
    assert_eq!(figure.value, count(edited.before - edited.deleted));
    assert!(figure.note.ends_with(", with 3 edits"), "{}", figure.note);
    let left = edited.samples.sample_count();
    app.apply(Command::Share(ShareCommand::Open(Some(Way::Page))));
    wait(&mut app, "sizes of what edits left", |app| {
        app.state.share.facts.is_some_and(|facts| facts.samples == left)
    });
    assert!(app.state.share_size(Way::Page).reason.ends_with(", with 3 edits"));
    app.apply(Command::Share(ShareCommand::Close));
    let report = saved_alike(&mut app, [&list, &store, &beside]);
    assert_eq!(app.state.unsaved_work(), None);
    assert_eq!(report.cut[0].cameras, [app.state.doc.scene.as_ref().unwrap().cameras[1].name.clone()]);
    assert_eq!(report.pixel_account().sum(), report.pixel_account().pixels);

    open(&mut app, &small_capture(), true);
    assert!(app.state.doc.edits.list.edits.is_empty());
    app.take_path(Purpose::LoadEdits, list);
    wait(&mut app, "the list", |app| app.state.doc.edits.list.edits.len() == 3);
    settle(&mut app);
    save_store(&mut app, &again);
    assert!(is_alike(&again, &store));
    open(&mut app, &store, false);
    let cleaned = picture(&app);
    open(&mut app, &again, false);
    assert!(shows_same(&picture(&app), &cleaned));
}

#[test]
fn a_store_that_the_window_saves_says_why_and_is_that_of_the_command_line_before_and_after_edits() {
    let folder = tempfile::tempdir().unwrap();
    let [list, store, beside] =
        ["edits.toml", "store.ovl", "beside.ovl"].map(|name| folder.path().join(name));
    let mut app = ready(2, 1);
    open(&mut app, &small_capture(), true);
    set(&mut app, "store.verdicts", 4.0);
    settle(&mut app);
    for region in [None, Some(Region::ConfirmedByFewerThan(1)), Some(middle(&app, 0.3))] {
        if let Some(region) = region {
            delete(&mut app, region);
        }
        saved_alike(&mut app, [&list, &store, &beside]);
        assert!(Store::open(&store).unwrap().has_verdicts());
    }
}

#[test]
fn a_store_is_cleaned_and_shows_the_same_once_it_is_opened_again() {
    let folder = tempfile::tempdir().unwrap();
    let [all, clean, beside] = ["all.ovl", "clean.ovl", "beside.ovl"].map(|name| folder.path().join(name));
    let mut app = ready(3, 2);
    save_store(&mut app, &all);
    open(&mut app, &all, false);
    let region = middle(&app, 0.2);
    delete(&mut app, region);
    let edited = picture(&app);
    save_store(&mut app, &clean);
    let edits = app.state.doc.edits.list.clone();
    let store = Store::open(&all).unwrap();
    let (_, deleted) = write_edited_store(&beside, &store, &edits, None, &Job::new()).unwrap();
    assert!(deleted > 0 && is_alike(&clean, &beside));
    open(&mut app, &clean, false);
    assert!(shows_same(&picture(&app), &edited));
    // A store does not hold who confirms its samples.
    edit(&mut app, EditCommand::Select(Region::Contradicted));
    assert!(app.state.doc.edits.trouble.as_ref().is_some_and(|trouble| trouble.contains("store")));
}

#[test]
fn an_edit_of_a_color_asks_for_the_colors_of_samples_and_not_for_that_of_the_selection() {
    let mut app = ready(2, 1);
    let samples = app.state.samples_to_edit().unwrap().clone();
    let image = samples.images.iter().max_by_key(|image| image.len()).unwrap();
    let linear = image.color[image.len() / 2].map(f64::from);
    let color = Region::Color { linear, tolerance: 20.0 };
    edit(&mut app, EditCommand::Select(color.clone()));
    let selected = app.state.edited().unwrap().selected;
    assert!(selected > 0 && selected < samples.sample_count(), "{selected}");
    edit(&mut app, EditCommand::Act(Action::Delete));
    // All that is left is selected, and so has the color of selections.
    edit(&mut app, EditCommand::Select(Region::All(Vec::new())));
    let edited = app.state.edited().unwrap();
    assert_eq!((edited.deleted, edited.selected), (selected, samples.sample_count() - selected));
    assert_eq!(edited.shown.sample_count(), edited.samples.sample_count());
    edit(&mut app, EditCommand::Select(color));
    assert_eq!(app.state.edited().unwrap().selected, 0, "none of it is left");
}

#[test]
fn the_selection_is_framed_and_an_empty_one_says_so() {
    let mut app = ready(2, 1);
    let home = app.state.live.orbit.clone();
    let nowhere = Region::Sphere { center: [1e6; 3], radius: 1.0 };
    edit(&mut app, EditCommand::Select(nowhere));
    app.apply(Command::View(ViewCommand::FramePoint));
    assert_eq!(app.state.live.orbit, home);
    assert!(app.notices()[0].starts_with("Nothing to frame"), "{:?}", app.notices());
    let (point, radius) = (surface_point(&app), 0.2 * home.as_ref().unwrap().pivot_distance);
    edit(&mut app, EditCommand::Select(Region::Sphere { center: point, radius }));
    let place = app.state.edited_now().unwrap().place.unwrap();
    assert!((place.mean - glam::DVec3::from(point)).length() <= radius && place.spread <= radius);
    app.apply(Command::View(ViewCommand::FramePoint));
    let orbit = app.state.live.orbit.clone().unwrap();
    let (middle, depth) = orbit.camera(64, 48).project(place.mean).unwrap();
    assert!((middle - glam::DVec2::new(32.0, 24.0)).length() < 1e-6, "{middle}");
    assert!(depth > place.spread && Some(orbit) != home);
}

/// A surface point that the first camera saw.
fn surface_point(app: &OverlookApp) -> [f64; 3] {
    let samples = app.state.samples_to_edit().unwrap();
    let image = samples.images_at(0).max_by_key(|image| image.placed_count()).unwrap();
    let camera = &samples.cameras[image.camera as usize];
    let middle = image.placed_count() as usize / 2;
    image.placed(camera).nth(middle).unwrap().point_in_world.to_array()
}

fn draw(app: &mut OverlookApp, region: Region, combine: Combine) -> u64 {
    edit(app, EditCommand::Draw { region: region.clone(), combine, is_done: false });
    let drafted = app.state.edited().unwrap().selected;
    edit(app, EditCommand::Draw { region, combine, is_done: true });
    let selected = app.state.edited().unwrap().selected;
    assert_eq!(selected, drafted, "what is being drawn is shown as it will be selected");
    selected
}

#[test]
fn what_is_drawn_grown_followed_and_masked_gives_the_same_bytes_by_the_list_as_by_hand() {
    let folder = tempfile::tempdir().unwrap();
    let [list, store, beside] =
        ["edits.toml", "clean.ovl", "beside.ovl"].map(|name| folder.path().join(name));
    let mut app = ready(2, 1);
    open(&mut app, &small_capture(), true);
    let camera = app.state.doc.scene.as_ref().unwrap().cameras[0].clone();
    let [width, height] = [camera.intrinsics.width, camera.intrinsics.height].map(f64::from);
    let frame = app.state.frame_number();
    let points = vec![[0.4 * width, 0.5 * height], [0.6 * width, 0.5 * height]];
    let stroke = Stroke { radius: 0.1 * width, points };
    let strokes = vec![stroke.clone()];
    let painted = Region::Pixels { camera: camera.name.clone(), frame, outline: Vec::new(), strokes };
    let outline = vec![[0.0, 0.5 * height], [width, height], [0.0, height]];
    let viewpoint = Viewpoint::of(&camera);
    let seen = Region::View { viewpoint, frame, outline, strokes: Vec::new(), depth: None };
    let of_stroke = draw(&mut app, painted.clone(), Combine::Replace);
    let of_both = draw(&mut app, seen, Combine::Add);
    assert!(of_stroke > 0 && of_both > of_stroke, "{of_stroke}, {of_both}");
    let without = draw(&mut app, painted, Combine::Subtract);
    assert!(without < of_both && without >= of_both - of_stroke, "{without} of {of_both}");
    let grown = app.state.doc.edits.grown(true);
    edit(&mut app, EditCommand::Reshape(grown));
    let grown = app.state.edited().unwrap().selected;
    assert!(grown > without, "{grown}, {without}");
    edit(&mut app, EditCommand::Act(Action::Delete));
    let surface = Region::same_surface(surface_point(&app), frame.unwrap());
    let of_surface = draw(&mut app, surface, Combine::Replace);
    let grown = app.state.doc.edits.grown(false);
    edit(&mut app, EditCommand::Reshape(grown));
    assert!(app.state.edited().unwrap().selected < of_surface);
    edit(&mut app, EditCommand::Act(Action::Delete));
    let before = app.state.edited().unwrap().deleted;
    let name = app.state.doc.scene.as_ref().unwrap().cameras[1].name.clone();
    edit(&mut app, EditCommand::Mask { camera: name, stroke });
    assert!(app.state.edited().unwrap().deleted > before, "a mask takes effect as it is painted");
    saved_alike(&mut app, [&list, &store, &beside]);
}

#[test]
fn what_is_selected_shows_in_a_coarse_picture_first_however_long_that_takes() {
    let mut app = ready(2, 2);
    let center = surface_point(&app);
    app.apply(Command::Edit(EditCommand::Select(Region::Sphere { center, radius: 1e6 })));
    wait(&mut app, "the selection", |app| app.state.edited_now().is_some());
    let first = app.workers.live.asked().unwrap();
    let shows_marks = first.samples == Same(app.state.edited_now().unwrap().shown.clone());
    assert!(first.quality.is_some() && shows_marks, "it is asked at once");
    std::thread::sleep(Duration::from_millis(150));
    assert!(LiveKey::changes_in(&app.state).is_none(), "the view rests");
    assert!(first.is_of_use(&app.state), "it is not stopped before it is shown");
    settle(&mut app);
    assert!(!first.is_of_use(&app.state));
    let shown = &app.state.doc.live_shown.as_ref().unwrap().key;
    assert!(shown.quality.is_none() && shown.samples == first.samples);
}
