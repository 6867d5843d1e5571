//! What is measured on demand beside charts: the ranking of cameras, and tuning.

use super::telling::view_says;
use super::{OverlookApp, ready, set, settle, step, wait};
use crate::app::model::Command;
use crate::app::model::command::{ChartCommand, EditCommand, SettingsCommand, WindowCommand};
use crate::app::model::window::{DockView, Workspace};
use crate::app::rooms::charts::state::{Study, StudyChoice};
use overlook_lab::trial::Fineness;

#[test]
fn cameras_are_ranked_until_an_edit_or_a_setting_changes_and_a_stopped_ranking_goes_on() {
    let mut app = ready(3, 2);
    let rank = Command::Chart(ChartCommand::Study(Study::Ranking));
    app.apply(Command::Window(WindowCommand::Workspace(Workspace::Explore)));
    app.apply(rank.clone());
    assert!(app.visible_views().contains(&DockView::Cameras));
    step(&mut app);
    assert!(view_says(&app.state, DockView::Cameras, "Most needless first"));
    wait(&mut app, "the first camera", |app| !app.state.doc.charts.ranking.is_empty());
    app.apply(Command::Cancel);
    wait(&mut app, "the ranking to stop", |app| !app.state.doc.charts.studying);
    let known = app.state.doc.charts.ranking.len();
    if known < 3 {
        let told = format!("After {known} of 3 cameras; Resume measures the rest.");
        assert!(app.notices().iter().any(|notice| notice.ends_with(&told)), "{:?}", app.notices());
        assert!(app.state.doc.charts.goes_on(Study::Ranking, &app.state.settings));
    }
    app.apply(rank.clone());
    settle(&mut app);
    let names = |app: &OverlookApp| {
        let mut names: Vec<String> =
            app.state.doc.charts.ranking.iter().map(|camera| camera.name.clone()).collect();
        names.sort();
        names
    };
    let cameras: Vec<_> =
        app.state.doc.scene.as_ref().unwrap().cameras.iter().map(|camera| camera.name.clone()).collect();
    assert_eq!(names(&app), cameras);
    let stale = "rank again to see what is needless now";
    let says = |app: &OverlookApp, text: &str| view_says(&app.state, DockView::Cameras, text);
    assert!(!says(&app, stale) && !says(&app, "Left out") && says(&app, "Leave out"));

    app.apply(Command::Edit(EditCommand::LeaveOut(vec![1])));
    assert!(says(&app, stale) && says(&app, "Left out"));
    app.apply(Command::Undo);
    assert!(!says(&app, stale) && !says(&app, "Left out"));
    set(&mut app, "pruning.depth_tolerance", 2.0);
    assert!(says(&app, "Made with other settings"));
    app.apply(Command::Edit(EditCommand::LeaveOut(vec![1])));
    app.apply(rank);
    settle(&mut app);
    assert_eq!(names(&app), [cameras[0].clone(), cameras[2].clone()]);
    assert!(!says(&app, stale) && !says(&app, "Made with"));
    app.apply(Command::Chart(ChartCommand::CloseRanking));
    assert!(!says(&app, "Most needless first"));
}

#[test]
fn tuned_settings_are_put_on_at_a_button_and_taken_back_by_undo() {
    let mut app = ready(3, 2);
    let before = app.state.settings.clone();
    let coarse = StudyChoice { fineness: Fineness::Coarse, budget: None, ..StudyChoice::quick() };
    app.apply(Command::Chart(ChartCommand::Ask(Some(Study::Tuning))));
    let all = app.state.doc.charts.question.as_ref().unwrap();
    let (measurements, settings) = (all.measurements, all.groups[0].1.clone());
    assert!(measurements > 10 && settings.contains(&"pruning.depth_tolerance".to_owned()), "{settings:?}");
    let left_out = settings.into_iter().filter(|path| path != "pruning.depth_tolerance").collect();
    let choice = StudyChoice { left_out, ..coarse };
    app.apply(Command::Chart(ChartCommand::Choose(Study::Tuning, Box::new(choice))));
    assert_eq!(app.state.doc.charts.question.as_ref().unwrap().measurements, 4);
    assert!(view_says(&app.state, DockView::Tuning, "Not tuned yet"));
    app.apply(Command::Chart(ChartCommand::Study(Study::Tuning)));
    assert!(view_says(&app.state, DockView::Tuning, "Trying settings"));
    settle(&mut app);
    let tuned = app.state.doc.charts.tuned.clone().unwrap();
    assert_eq!(app.state.settings, before, "nothing changes by itself");
    assert!(view_says(&app.state, DockView::Tuning, "settings tried, the best has"));
    let changes = tuned.settings != before;
    assert_eq!(view_says(&app.state, DockView::Tuning, "Use these settings"), changes);
    app.apply(Command::Settings(SettingsCommand::Take(Box::new(tuned.settings.clone()))));
    assert_eq!(app.state.settings, tuned.settings);
    assert!(!view_says(&app.state, DockView::Tuning, "Made with"), "it was made for these");
    if changes {
        app.apply(Command::Undo);
    }
    assert_eq!(app.state.settings, before);
    app.apply(Command::Chart(ChartCommand::Study(Study::Tuning)));
    assert!(app.notices().iter().any(|notice| notice.starts_with("Nothing left to measure")));
}
