//! What the window says of its work and of what is measured.

use std::sync::Arc;
use std::time::Duration;

use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;

use crate::app::control::{OverlookApp, secs_left};
use crate::app::dock::Dock;
use crate::app::model::command::{FileCommand, Opening, SettingsCommand, ViewCommand};
use crate::app::model::notice::Notice;
use crate::app::model::window::DockView;
use crate::app::model::{Busy, Command, Message, OpenScene, State, WorkKind};
use crate::app::rooms::charts::state::Study;
use crate::app::rooms::files;
use crate::app::rooms::pixel::pending_verdict;
use crate::app::start::{view_ui, window_ui};
use crate::app::tests::{ready, small_capture, start, wait};
use crate::app::work::requests::OpenRequest;
use crate::app::{model, theme};
use overlook_engine::job::{Job, Progress};
use overlook_engine::settings::{CaptureSettings, Kernel, Settings};

/// Whether a piece of the window says something.
fn says(text: &str, mut contents: impl FnMut(&mut egui::Ui)) -> bool {
    let mut is_themed = false;
    let mut harness = Harness::builder().with_size([1280.0, 800.0]).build_ui(|ui| {
        // From the next frame on.
        if std::mem::replace(&mut is_themed, true) {
            contents(ui);
        } else {
            theme::install(ui.ctx());
        }
    });
    harness.run_steps(2);
    harness.query_all_by_label_contains(text).next().is_some()
}

pub(super) fn view_says(state: &State, view: DockView, text: &str) -> bool {
    says(text, |ui| view_ui(ui, view, state, &mut Vec::new()))
}

fn scoring() -> Progress {
    Progress {
        context: "3 of 60, 2 min left".to_owned(),
        stage: "Scoring views".to_owned(),
        done: 14,
        total: 15,
    }
}

#[test]
fn a_capture_whose_up_was_taken_from_the_cameras_asks_once_and_takes_again_what_was_chosen() {
    let mut app = start(2, 1);
    let open = |app: &mut OverlookApp| {
        let (path, settings) = (small_capture(), CaptureSettings::default());
        let request = OpenRequest::Path { path, settings, keys: Vec::new() };
        let Ok(Message::Opened { scene, .. }) = files::work::open(request, &Job::new()) else {
            panic!("the small capture opens")
        };
        let scene = Arc::into_inner(scene).expect("nobody else has it");
        assert!(!scene.up_is_estimated, "its manifest says it");
        app.opened(&Arc::new(OpenScene { up_is_estimated: true, ..scene }), None);
    };
    let is_question = |notice: &Notice| notice.title == "Does it lie on its side?";
    let asks = |app: &OverlookApp| app.state.notices.iter().any(is_question);
    open(&mut app);
    assert!(asks(&app));
    app.apply(Command::View(ViewCommand::FindUp));
    assert!(app.visible_views().contains(&DockView::View));
    open(&mut app);
    assert!(!asks(&app), "it was asked before");
    let recorded = app.state.up_in_world();
    let up = if recorded == glam::DVec3::X { glam::DVec3::Y } else { glam::DVec3::X };
    app.apply(Command::View(ViewCommand::Up(Some(up))));
    open(&mut app);
    assert_eq!(app.state.up_in_world(), up);
    assert_eq!(app.state.live.orbit.as_ref().unwrap().up_in_world, up);
    app.apply(Command::View(ViewCommand::Up(None)));
    open(&mut app);
    assert_eq!(app.state.up_in_world(), recorded);
}

#[test]
fn the_line_at_the_bottom_names_what_is_measured_and_how_long_all_of_it_takes() {
    let left = |work| secs_left(work, &scoring(), Duration::from_secs(10));
    assert!(left(WorkKind::Prune).is_some() && left(WorkKind::Study).is_none(), "not that of one stage");
    for (study, name) in [(Study::Sweep, "Sweep"), (Study::Stress, "Stress test")] {
        let mut state = State::default();
        state.doc.charts.begin(study, &Settings::default());
        let (work, progress) = (WorkKind::Study, scoring());
        state.busy = vec![Busy { work, progress, cancellable: true, secs_left: None }];
        let (line, mut dock) = (format!("{name}: 3 of 60, 2 min left"), Dock::new());
        assert!(says(&line, |ui| window_ui(ui, &state, &mut dock, &mut Vec::new())));
    }
}

#[test]
fn a_chart_whose_first_point_is_on_its_way_does_not_say_that_there_is_none() {
    for (study, view, none) in [
        (Study::Sweep, DockView::Tradeoff, "No sweep yet"),
        (Study::Stress, DockView::Stability, "No stress test yet"),
    ] {
        let mut state = State::default();
        assert!(view_says(&state, view, none));
        state.doc.charts.begin(study, &Settings::default());
        assert!(view_says(&state, view, "Measuring the first setting") && !view_says(&state, view, none));
    }
}

#[test]
fn settings_put_on_from_a_chart_are_named_as_in_the_panel() {
    let mut app = start(2, 2);
    let mut settings = Settings::default();
    settings.render.kernel = Kernel::Point;
    app.apply(Command::Settings(SettingsCommand::Take(Box::new(settings.clone()))));
    let notices = app.notices();
    let told = "Settings applied: Kernel: Gather (interpolate cameras) » Point (Ctrl+Z undoes)";
    assert_eq!(notices, [told]);
    assert!(view_says(&app.state, DockView::Thresholds, "1 setting differs from its default"));
    app.apply(Command::Settings(SettingsCommand::Take(Box::new(settings))));
    assert!(app.notices()[1].starts_with("Already applied"), "{:?}", app.notices());
    app.apply(Command::Undo);
    assert!(view_says(&app.state, DockView::Thresholds, "Every setting has its default"));
}

#[test]
fn histograms_of_another_frame_than_the_one_shown_say_so() {
    let mut app = start(2, 2);
    let are_of = |app: &OverlookApp, frame| {
        app.state.doc.histograms.first().is_some_and(|histogram| histogram.frame == Some(frame))
    };
    wait(&mut app, "the histograms", |app| are_of(app, 0));
    assert!(!view_says(&app.state, DockView::Thresholds, "at frame"));
    app.state.timeline.frame = 1;
    assert!(view_says(&app.state, DockView::Thresholds, "at frame 1"));
    wait(&mut app, "the histograms", |app| are_of(app, 1));
    assert!(!view_says(&app.state, DockView::Thresholds, "at frame"));
}

#[test]
fn of_a_pixel_that_is_kept_in_motion_nobody_is_asked_to_click_it() {
    let mut state = State::default();
    state.timeline.playing = true;
    assert!(pending_verdict(&state, false).contains("click"));
    assert_eq!(pending_verdict(&state, true), "Playing: pause to read its verdict.");
}

#[test]
fn samples_of_shorter_spans_are_not_said_to_be_of_one_frame() {
    let app = ready(2, 4);
    let counted = app.state.report().unwrap().foreground_per_frame[0];
    let words = format!("{} time-varying samples", model::count(counted));
    let mut dock = Dock::new();
    assert!(says(&words, |ui| window_ui(ui, &app.state, &mut dock, &mut Vec::new())));
    assert!(view_says(&app.state, DockView::Report, "Repeated over time"));
}

#[test]
fn a_folder_without_a_capture_is_told_in_one_line_with_what_opens() {
    let folder = tempfile::tempdir().unwrap();
    let mut app = ready(2, 1);
    app.apply(Command::File(FileCommand::Open(Opening::Path(folder.path().to_path_buf()))));
    wait(&mut app, "a word about it", |app| app.state.notices.iter().any(|of| of.link.is_some()));
    let leads = |of: &&Notice| of.link.as_ref().is_some_and(|(name, _)| *name == "What opens?");
    let notice = app.state.notices.iter().find(leads).unwrap();
    assert!(notice.text.starts_with("No capture in ") && notice.text.lines().count() == 1, "{}", notice.text);
}
