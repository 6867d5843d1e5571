//! What is shared and stopped, and addresses to the last bit.

use crate::app::control::{OverlookApp, Start};
use crate::app::model::Command;
use crate::app::model::command::{ChartCommand, FileCommand, Opening, ViewCommand};
use crate::app::model::picture::ColorBy;
use crate::app::model::purpose::{Purpose, ShareCommand};
use crate::app::rooms::charts::state::{Found, Study};
use crate::app::rooms::share::state::{ShareOutcome, SharePreviewKey};
use crate::app::rooms::timeline::TimeCommand;
use crate::app::tests::{add_path, copied, ready, save_store, settle, wait};
use crate::app::work::worker::Wanted;
use crate::ways_out;
use crate::ways_out::{Options, Way};
use overlook_engine::demo::DemoSpec;
use overlook_engine::settings::Settings;
use overlook_lab::sweep::{Point, Series};
use overlook_lab::trial::{Trial, TrialResult};

#[test]
fn a_chart_is_written_in_the_format_of_its_name_and_copied() {
    let folder = tempfile::tempdir().unwrap();
    let mut app = ready(2, 2);
    let save = Purpose::SaveChart(Study::Sweep);
    app.apply(Command::File(FileCommand::AskPath(save)));
    assert!(app.state.typed_path.is_none(), "no path is asked for in vain");
    assert!(app.notices().iter().any(|notice| notice.contains("There is no sweep chart yet")));
    let trial = Trial::new("default, gather", Settings::default());
    let mut point = Point::new(&trial, Series::Reference, &TrialResult::default());
    (point.psnr_filled_db, point.bytes) = (30.0, 1000);
    app.state.doc.charts.add(Found::Sweep(point), (1, 1));
    for (ending, begins) in [("pdf", &b"%PDF"[..]), ("svg", b"<svg"), ("png", b"\x89PNG")] {
        let path = folder.path().join(format!("sweep.{ending}"));
        app.take_path(save, path.clone());
        settle(&mut app);
        assert!(std::fs::read(&path).unwrap().starts_with(begins), "{ending}");
    }
    app.apply(Command::File(FileCommand::AskPath(save)));
    assert_eq!(app.state.typed_path.as_ref().unwrap().text, "sweep.pdf");
    app.apply(Command::Chart(ChartCommand::Copy(Study::Sweep)));
    settle(&mut app);
    let notices = app.notices();
    assert!(
        notices.iter().any(|notice| notice.contains("The sweep chart is on the clipboard")),
        "{notices:?}"
    );
}

#[test]
fn what_is_stopped_leaves_nothing_behind() {
    let folder = tempfile::tempdir().unwrap();
    let mut app = ready(3, 4);
    for (purpose, name) in [
        (Purpose::Share(&ways_out::page::PAGE), "scene.html"),
        (Purpose::Share(&ways_out::splats::GLB), "scene.glb"),
        (Purpose::Share(&ways_out::splats::SPZ), "scene.spz"),
        (Purpose::Share(&ways_out::points::POINTS_OF_FRAMES), "points"),
        (Purpose::Share(&ways_out::store::STORE), "scene.ovl"),
    ] {
        app.apply(Command::Share(ShareCommand::Open(None)));
        app.take_path(purpose, folder.path().join(name));
        app.watch_work();
        app.apply(Command::Share(ShareCommand::Stop));
        wait(&mut app, "a word about it", |app| app.state.share.outcome.is_some());
        let outcome = app.state.share.outcome.take().unwrap();
        assert!(
            matches!(&outcome, ShareOutcome::Failed(why) if why.contains("Nothing was written")),
            "{outcome:?}"
        );
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "{name}");
    }
}

#[test]
fn what_a_budget_leaves_is_seen_before_it_is_made_and_less_is_farther_from_all() {
    let spec = DemoSpec::new("orrery").cameras(3).frames(1).size((128, 96));
    let mut app = OverlookApp::new(&egui::Context::default(), None, None, Start::Demo(spec)).unwrap();
    app.state.live.size = [128, 96];
    settle(&mut app);
    app.apply(Command::Share(ShareCommand::Open(Some(Way::Splats))));
    settle(&mut app);
    wait(&mut app, "sizes", |app| app.state.share.facts.is_some());
    assert!(app.state.share.preview.is_none(), "nothing is made coarser");
    let all = app.state.share.facts.unwrap().placed_here;
    let mut decibels_of = |kilosplats: u64| {
        let options = Options { splats_are_bounded: true, kilosplats, ..app.state.share.options.clone() };
        app.apply(Command::Share(ShareCommand::Change(Box::new(options))));
        let is_of_it = |app: &OverlookApp| {
            let shown = app.state.share.preview.as_ref().map(|shown| &shown.key);
            shown.is_some() && shown == SharePreviewKey::wanted(&app.state).as_ref()
        };
        wait(&mut app, "the preview of this budget", is_of_it);
        let shown = app.state.share.preview.as_ref().unwrap();
        shown.picture.as_ref().map(|(_, decibels)| decibels.unwrap())
    };
    let [more, less] = [all / 1300, all / 4000].map(|kilosplats| decibels_of(kilosplats).unwrap());
    assert!(more > less && less > 10.0, "{more} {less} of {all}");
    assert_eq!(decibels_of(0), None, "nothing is left");
}

#[test]
fn pictures_along_the_path_show_what_the_live_view_shows() {
    let folder = tempfile::tempdir().unwrap();
    let mut app = ready(2, 2);
    add_path(&mut app, 1);
    assert_eq!(app.state.film_look(), None);
    let written = |app: &mut OverlookApp, name: &str| {
        let pictures = folder.path().join(name);
        app.state.notices.clear();
        app.take_path(Purpose::Share(&ways_out::pictures::PICTURES), pictures.clone());
        wait(app, "the pictures", |app| app.tells("Exported"));
        image::open(pictures.join("0002.png")).unwrap().into_rgb8()
    };
    let plain = written(&mut app, "plain");
    app.apply(Command::View(ViewCommand::look(&app.state.live, |live| live.color_by = ColorBy::Camera)));
    app.apply(Command::View(ViewCommand::look(&app.state.live, |live| live.cameras.switch(1, false))));
    settle(&mut app);
    assert_eq!(app.state.film_look().unwrap(), "colored by camera, without 1 hidden camera");
    let colored = written(&mut app, "colored");
    assert_ne!(plain, colored);
    // The view has the size of exported pictures.
    let shown = app.state.shown_picture().unwrap();
    let rgb = shown.pixels.iter().map(|pixel| [pixel.r(), pixel.g(), pixel.b()]);
    assert!(colored.pixels().map(|pixel| pixel.0).eq(rgb), "it is what the live view shows");
}

#[test]
fn cameras_are_written_as_other_programs_read_them() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("cameras.json");
    let mut app = ready(3, 2);
    app.take_path(Purpose::Share(&ways_out::cameras::CAMERAS), file.clone());
    wait(&mut app, "the file", |_| file.is_file());
    let views = overlook_engine::capture::transforms::open_views(&file).unwrap();
    let cameras = &app.state.doc.scene.as_ref().unwrap().cameras;
    assert_eq!(views.len(), 3);
    for (view, camera) in views.iter().zip(cameras) {
        assert_eq!(view.camera.intrinsics, camera.intrinsics);
        let apart = view.camera.position_in_world() - camera.position_in_world();
        assert!(apart.length() < 1e-9);
    }
}

#[test]
fn what_cannot_be_written_is_said_in_the_dialog_and_can_be_mended() {
    let folder = tempfile::tempdir().unwrap();
    let mut app = ready(2, 2);
    app.apply(Command::Share(ShareCommand::Open(None)));
    app.state.notices.clear();
    app.take_path(Purpose::Share(&ways_out::page::PAGE), folder.path().join("missing/scene.html"));
    wait(&mut app, "the error", |app| app.state.share.outcome.is_some());
    let outcome = app.state.share.outcome.clone().unwrap();
    assert!(
        matches!(&outcome, ShareOutcome::Failed(why) if why.starts_with("Could not export: ") && !why.contains('\n'))
    );
    assert!(app.notices().is_empty(), "it is not said twice");
}

#[test]
fn an_address_gives_back_the_viewpoint_and_the_frame_to_the_last_bit() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("small.ovl");
    let mut app = ready(2, 4);
    save_store(&mut app, &path);
    for (nth, angles) in [[0.3, 0.1], [-2.1, -0.4], [1e-7, 0.0]].into_iter().enumerate() {
        app.apply(Command::View(ViewCommand::Orbit(angles.into())));
        let orbit = app.state.live.orbit.as_mut().unwrap();
        orbit.set_angle_of_view(0.5 + nth as f64 / 7.0);
        app.apply(Command::Time(TimeCommand::Frame(nth + 1)));
        let before = app.state.live.orbit.clone().unwrap();
        app.apply(Command::View(ViewCommand::CopyAddress));
        let address = copied(&app).unwrap();
        let (_, view) = address.split_once('#').unwrap();
        let shown = app.state.live.orbit.clone().unwrap();
        let moved = shown.world_from_camera.translation - before.world_from_camera.translation;
        assert!(moved.length() < 1e-9, "copying moves nothing that anybody sees");
        app.apply(Command::View(ViewCommand::Home));
        app.apply(Command::Time(TimeCommand::Frame(0)));
        app.apply(Command::View(ViewCommand::GoToAddress(address.clone())));
        assert_eq!((app.state.live.orbit.as_ref(), app.state.timeline.frame), (Some(&shown), nth + 1));
        // The same view of the store, which is another scene.
        let there = format!("{}#{view}", path.display());
        app.apply(Command::File(FileCommand::Open(Opening::Path(there.into()))));
        wait(&mut app, "the store", |app| app.state.doc.scene.is_some() && app.state.opening.is_none());
        settle(&mut app);
        assert_eq!((app.state.live.orbit.as_ref(), app.state.timeline.frame), (Some(&shown), nth + 1));
    }
}
