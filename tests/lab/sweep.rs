//! Sweeps: baselines keep as many samples as they may, a sweep that was cut short goes on, the front is the front.

use std::time::Duration;

use overlook_engine::job::Job;
use overlook_engine::settings::{Kernel, PruningMethod, Settings};
use overlook_lab::sweep::{self, Point, Series, SweepPlan};
use overlook_lab::trial::{Fineness, Trial, Workbench};
use overlook_lab::truth::Recorded;

use crate::scenes::{orrery, still};

fn axes() -> Vec<(String, Vec<String>)> {
    vec![
        ("pruning.depth_tolerance".to_owned(), vec!["0.5".to_owned(), "2".to_owned()]),
        ("render.kernel".to_owned(), vec!["gather".to_owned(), "block".to_owned()]),
    ]
}

/// Everything but what a clock says.
fn without_times(points: &[Point]) -> Vec<Point> {
    let timeless = |point: &Point| Point {
        milliseconds: 0.0,
        load_of_others: None,
        seconds_preprocess: 0.0,
        ..point.clone()
    };
    points.iter().map(timeless).collect()
}

#[test]
fn a_sweep_measures_settings_and_baselines_and_goes_on_where_it_was_cut_short() {
    let scene = orrery(1);
    let mut plan = SweepPlan::grid(&Settings::default(), &axes(), &scene.capture).unwrap();
    let whole = sweep::run(&scene.capture, &plan, &scene.truth, &Job::new(), |_, _| ()).unwrap().points;

    let job = Job::new();
    let mut told = Vec::new();
    let cut = sweep::run(&scene.capture, &plan, &scene.truth, &job, |point, _| {
        told.push(point.clone());
        if told.len() == 7 {
            job.cancel();
        }
    });
    assert!(cut.is_err() && told.len() == 7);
    plan.done = told;
    let mut counts = Vec::new();
    let again = sweep::run(&scene.capture, &plan, &scene.truth, &Job::new(), |_, count| counts.push(count))
        .unwrap()
        .points;
    assert_eq!(counts.first(), Some(&8), "what is known is not measured again");
    assert_eq!(without_times(&again), without_times(&whole));

    let of = |series| whole.iter().filter(move |point| point.series == series);
    let reference = of(Series::Reference).next().unwrap();
    assert_eq!(of(Series::Variation).count(), 4);
    for series in [Series::Random, Series::VoxelGrid] {
        assert_eq!(of(series).count(), 3, "{series:?}");
        for point in of(series) {
            assert_eq!(point.samples, reference.samples, "{}", point.label);
        }
    }
    assert!(of(Series::FirstCameraAtCount).all(|point| point.samples <= reference.samples));
    assert_eq!(of(Series::SingleCamera).count(), 1, "the best stands for all");
    assert_eq!(of(Series::Paper).next().unwrap().settings.render.kernel, Kernel::Block);
    let unpruned = of(Series::NoPruning).next().unwrap();
    assert!(unpruned.samples > reference.samples);
    for point in &whole {
        let beaten = whole.iter().any(|other| {
            other.bytes_of_samples() < point.bytes_of_samples() && other.psnr_filled_db > point.psnr_filled_db
        });
        assert!(point.psnr_filled_db.is_finite() && point.bytes > 0 && !(point.pareto && beaten));
    }
    assert!(reference.pareto, "{reference:?}");
    the_front_holds_what_nothing_beats_in_both_respects(reference);
    what_was_scored_at_fewer_vantages_is_not_compared(reference);
}

fn what_was_scored_at_fewer_vantages_is_not_compared(whole: &Point) {
    let easier = Point { vantages: whole.vantages - 1, psnr_filled_db: 99.0, ..whole.clone() };
    let mut points = [easier, whole.clone()];
    sweep::mark_pareto_of_stores(&mut points);
    assert_eq!(points.map(|point| point.pareto), [false, true]);
}

#[test]
fn a_camera_that_is_held_out_in_turn_is_scored_at_fewer_vantages_alone() {
    let scene = still(2);
    let recorded = Recorded::undisturbed(&scene.capture);
    let settings = Settings::default();
    let mut workbench = Workbench::new(&recorded, &scene.truth, &settings, &Job::new()).unwrap();
    let all = Trial::new("all", settings);
    let one = Trial { cameras: Some(vec![scene.capture.cameras[0].name.clone()]), ..all.clone() };
    let [all, one] = [all, one].map(|trial| {
        Point::new(&trial, Series::Variation, &workbench.measure(&trial, &Job::new()).unwrap()).vantages
    });
    assert_eq!((all, one), (3, 2));
}

fn the_front_holds_what_nothing_beats_in_both_respects(measured: &Point) {
    let point = |bytes, db| Point { bytes, psnr_filled_db: measured.psnr_filled_db + db, ..measured.clone() };
    let half = measured.bytes / 2;
    let mut points = [measured.clone(), point(half, -0.1), point(half + 1, -0.1), point(half + 2, 0.0)];
    sweep::mark_pareto(&mut points, |point| point.bytes as f64, |point| point.psnr_filled_db);
    assert_eq!(points.each_ref().map(|point| point.pareto), [false, true, false, true]);
}

#[test]
fn what_keeps_as_many_samples_as_another_reference_is_not_known() {
    let scene = orrery(1);
    let with = |method: PruningMethod| {
        let mut settings = Settings::default();
        settings.pruning.method = method;
        let mut plan = SweepPlan::list(&settings, Vec::new(), &scene.capture);
        plan.trials.retain(|planned| {
            let kernel = planned.trial.settings.render.kernel;
            kernel == Kernel::Gather && matches!(planned.series, Series::Reference | Series::Random)
        });
        plan
    };
    let (one, mut other) = (with(Settings::default().pruning.method), with(PruningMethod::FirstCamera));
    assert_eq!(other.trials[1], one.trials[1], "settings do not tell the references apart");
    let run = |plan: &SweepPlan| {
        let mut measured = 0;
        let points =
            sweep::run(&scene.capture, plan, &scene.truth, &Job::new(), |_, _| measured += 1).unwrap().points;
        (points, measured)
    };
    let (first, _) = run(&one);
    other.done = first.clone();
    let (second, measured) = run(&other);
    assert_eq!(measured, 2, "the reference and what keeps as many samples");
    assert_eq!(second[1].samples, second[0].samples);
    assert_ne!(second[1].samples, first[1].samples);

    // In one journal, each goes with its own reference.
    for (mut plan, points) in [(one, &first), (other, &second)] {
        plan.done = [first.clone(), second.clone()].concat();
        let (again, measured) = run(&plan);
        assert_eq!((measured, again[1].samples), (0, points[1].samples));
    }
}

#[test]
fn a_spent_budget_leaves_one_point_at_least_and_the_rest_gives_what_a_whole_run_gives() {
    let scene = orrery(1);
    let axes = [("pruning.depth_tolerance".to_owned(), ["0.5", "2", "8"].map(str::to_owned).to_vec())];
    let mut plan = SweepPlan::grid(&Settings::default(), &axes, &scene.capture).unwrap();
    plan.choose(Fineness::Fine, |planned| planned.series == Series::Variation);
    let run = |plan: &SweepPlan| {
        let mut labels = Vec::new();
        let tell = |point: &Point, _| labels.push(point.label.clone());
        let measured = sweep::run(&scene.capture, plan, &scene.truth, &Job::new(), tell).unwrap();
        (measured, labels)
    };
    let (whole, labels) = run(&plan);
    let values: Vec<_> = whole.points.iter().map(|point| point.label.as_str()).collect();
    let [half, two, eight] = [0.5, 2.0, 8.0].map(|value| format!("pruning.depth_tolerance = {value}"));
    assert_eq!(values, ["default", &half, &two, &eight], "results are in the order of the plan");
    assert_eq!(labels, ["default", &half, &eight, &two], "measured ends first");
    plan.budget = Some(Duration::ZERO);
    for left in [3, 2, 1, 0] {
        let (measured, labels) = run(&plan);
        assert_eq!((measured.left, labels.len()), (left, 1));
        plan.done = measured.points;
    }
    assert_eq!(without_times(&plan.done), without_times(&whole.points));
    plan.choose(Fineness::Coarse, |_| true);
    let coarse = plan.trials.iter().map(|planned| planned.trial.label.as_str());
    assert!(coarse.eq(["default", &half, &eight]));
}

#[test]
fn the_standard_sweep_has_sixty_settings_and_every_baseline() {
    let scene = orrery(2);
    let plan = SweepPlan::standard(&Settings::default(), &scene.capture);
    assert!(plan.trials.len() >= 60 + 7);
    // Figures of other programs are given, not planned.
    for series in Series::ALL.into_iter().filter(|series| *series != Series::External) {
        assert!(plan.trials.iter().any(|planned| planned.series == series), "{series:?}");
    }
    for path in ["spans.levels", "pruning.rate", "pruning.overlap"] {
        assert!(plan.trials.iter().any(|planned| planned.trial.label.starts_with(path)), "{path}");
    }
}
