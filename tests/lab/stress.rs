//! Disturbances: each does nothing at the start of its dial and something at the end, and shows where methods fail.

use std::time::Duration;

use overlook_engine::job::Job;
use overlook_engine::settings::Settings;
use overlook_lab::stress::{self, Disturbance, StressPlan, StressPoint};
use overlook_lab::sweep::Point;
use overlook_lab::trial::Fineness;
use overlook_lab::truth::Truth;

use crate::scenes::{Scene, orrery, still};

#[test]
fn every_disturbance_leaves_the_capture_alone_at_the_start_of_its_dial_and_not_at_its_end() {
    let scene = orrery(4);
    for disturbance in Disturbance::ALL {
        let dial = disturbance.dial(&scene.capture, &scene.truth);
        let under = |value| disturbance.apply(&scene.capture, value).unwrap();
        let (start, end) = (under(dial[0]), under(dial[dial.len() - 1]));
        let differs = |recorded: &overlook_lab::truth::Recorded| {
            recorded.capture.cameras != scene.capture.cameras
                || recorded.capture.cameras.iter().enumerate().any(|(camera, _)| {
                    (0..4).any(|frame| {
                        *recorded.capture.frame(camera, frame).unwrap()
                            != *scene.capture.frame(camera, frame).unwrap()
                    })
                })
        };
        let inserts = matches!(disturbance, Disturbance::ThinStructures | Disturbance::GrazingViews);
        assert!(inserts || !differs(&start), "{} disturbs at {}", disturbance.name(), dial[0]);
        assert!(differs(&end), "{} does nothing at its end", disturbance.name());
        let again = under(dial[dial.len() - 1]);
        assert_eq!(*end.capture.frame(0, 2).unwrap(), *again.capture.frame(0, 2).unwrap());
    }
}

#[test]
fn a_pose_error_costs_accuracy_and_the_point_of_failure_lies_on_the_dial() {
    let scene = orrery(2);
    let plan = StressPlan {
        disturbances: vec![Disturbance::CameraPose],
        ..StressPlan::standard(&Settings::default())
    };
    let mut told = 0;
    let points = stress::run(&scene.capture, &plan, &scene.truth, &Job::new(), |_, (known, total)| {
        told += 1;
        assert_eq!((known, total), (told, 15));
    })
    .unwrap()
    .points;
    let failures = stress::failures(&points);
    assert_eq!(failures.len(), 3);
    for failure in &failures {
        let dial = failure.dial.unwrap();
        assert!(dial > 0.0 && dial < 1.0 && failure.worst_loss_db > 1.0, "{failure:?}");
    }
    for point in &points {
        let beats = |other: &StressPoint| {
            other.dial == point.dial
                && other.point.bytes_of_samples() <= point.point.bytes_of_samples()
                && other.point.psnr_filled_db >= point.point.psnr_filled_db
                && (other.point.bytes_of_samples(), other.point.psnr_filled_db)
                    != (point.point.bytes_of_samples(), point.point.psnr_filled_db)
        };
        assert_eq!(point.point.pareto, !points.iter().any(beats), "{}", point.point.label);
    }
    assert!(points.iter().any(|point| !point.point.pareto), "some method is beaten somewhere");
    let again = StressPlan { done: points.clone(), ..plan };
    let job = Job::new();
    job.cancel();
    let told_anew = |_: &StressPoint, _| panic!("what is known is told again");
    let known = stress::run(&scene.capture, &again, &scene.truth, &job, told_anew).unwrap().points;
    assert_eq!(known, points, "all is known: nothing is measured, nothing can be cancelled");
}

#[test]
fn a_value_that_leaves_nothing_to_compare_has_no_points_and_only_a_plan_of_such_values_fails() {
    let scene = orrery(2);
    let alone = scene.capture.with_cameras(|index, _| index == 0);
    let disturbances = vec![Disturbance::MissingCamera, Disturbance::FewerCameras];
    let mut plan = StressPlan { disturbances, ..StressPlan::standard(&Settings::default()) };
    plan.methods.truncate(2);
    let (job, mut told) = (Job::new(), Vec::new());
    let points = stress::run(&alone, &plan, &scene.truth, &job, |_, known| told.push(known)).unwrap().points;
    let dials: Vec<_> = points.iter().map(|point| (point.disturbance.as_str(), point.dial)).collect();
    let missing = [0.0, 25.0, 50.0].map(|dial| ("missing camera", dial));
    let expected: Vec<_> = missing.into_iter().chain([("fewer cameras", 0.0)]).collect();
    assert!(dials.chunks(2).all(|methods| methods[0] == methods[1]), "{dials:?}");
    assert_eq!(dials.iter().step_by(2).copied().collect::<Vec<_>>(), expected);
    assert_eq!((told[0], told[7]), ((1, 10), (8, 8)), "what is left out is not waited for");
    let left_out = job.warnings().into_iter().filter(|line| line.contains("100 % of frames is left out"));
    assert_eq!(left_out.count(), 1);

    let (nothing, job) = (Truth::Views(Vec::new()), Job::new());
    let error = stress::run(&alone, &plan, &nothing, &job, |_, _| ()).unwrap_err().to_string();
    assert!(error.contains("no view has a true picture") && job.warnings().is_empty(), "{error}");
}

#[test]
fn the_ends_of_every_dial_come_first_and_what_a_spent_budget_left_is_measured_later() {
    let scene = orrery(2);
    let disturbances = vec![Disturbance::Exposure, Disturbance::CameraPose];
    let mut plan = StressPlan { disturbances, ..StressPlan::standard(&Settings::default()) };
    plan.methods.truncate(1);
    let run = |plan: &StressPlan| {
        let mut dials = Vec::new();
        let tell = |point: &StressPoint, _| dials.push((point.disturbance.clone(), point.dial));
        let measured = stress::run(&scene.capture, plan, &scene.truth, &Job::new(), tell).unwrap();
        (measured, dials)
    };
    let (whole, dials) = run(&plan);
    let mut ends = Vec::new();
    for disturbance in &plan.disturbances {
        let dial = disturbance.dial(&scene.capture, &scene.truth);
        ends.extend([dial[0], dial[dial.len() - 1]].map(|end| (disturbance.name().to_owned(), end)));
    }
    assert_eq!(dials[..4], ends);
    assert!(whole.points.is_sorted_by_key(|point| point.disturbance != "exposure"));
    plan.budget = Some(Duration::ZERO);
    let (cut, told) = run(&plan);
    assert_eq!((cut.left, &told[..]), (dials.len() - 1, &ends[..1]));
    (plan.budget, plan.done) = (None, cut.points);
    assert_eq!(plan.open(&scene.capture, &scene.truth), dials.len() - 1);
    let timeless = |points: &[StressPoint]| -> Vec<StressPoint> {
        let timeless = |of: &StressPoint| {
            let point = Point {
                milliseconds: 0.0,
                load_of_others: None,
                seconds_preprocess: 0.0,
                ..of.point.clone()
            };
            StressPoint { point, ..of.clone() }
        };
        points.iter().map(timeless).collect()
    };
    let (rest, told) = run(&plan);
    assert_eq!(told, dials[1..]);
    assert_eq!(timeless(&rest.points), timeless(&whole.points));
    (plan.done, plan.fineness) = (Vec::new(), Fineness::Coarse);
    assert_eq!(plan.open(&scene.capture, &scene.truth), 4);
}

#[test]
fn one_decibel_is_interpolated_between_values_of_the_dial() {
    let scene = orrery(2);
    let Truth::Views(views) = &scene.truth else { panic!("the orrery has views") };
    let truth = Truth::Views(views[..2].to_vec());
    let mut plan = StressPlan {
        disturbances: vec![Disturbance::Exposure],
        ..StressPlan::standard(&Settings::default())
    };
    plan.methods.truncate(1);
    let mut points = stress::run(&scene.capture, &plan, &truth, &Job::new(), |_, _| ()).unwrap().points;
    for (point, loss_db) in points.iter_mut().zip([0.0, 0.5, 1.5, 9.0]) {
        *point = StressPoint { loss_db, ..point.clone() };
    }
    let failures = stress::failures(&points);
    assert!((failures[0].dial.unwrap() - 0.2).abs() < 1e-9 && failures[0].worst_loss_db == 9.0);
    assert_eq!(stress::failures(&points[..2])[0].dial, None);
}

#[test]
fn cameras_go_one_by_one_until_as_few_are_left_as_the_truth_needs() {
    let scene = still(1);
    let mut plan = StressPlan {
        disturbances: vec![Disturbance::FewerCameras],
        ..StressPlan::standard(&Settings::default())
    };
    plan.methods.truncate(1);
    let points = stress::run(&scene.capture, &plan, &scene.truth, &Job::new(), |_, _| ()).unwrap().points;
    let gone: Vec<f64> = points.iter().map(|point| point.dial).collect();
    assert_eq!(gone, [0.0, 1.0], "of three cameras two stay, so that one can be left out");
    for gone in gone {
        let recorded = Disturbance::FewerCameras.apply(&scene.capture, gone).unwrap();
        let folds = scene.truth.folds(&recorded, &Job::new()).unwrap();
        let places: Vec<_> = folds.iter().filter_map(|fold| fold.held_out.as_ref()).collect();
        let names: Vec<_> = scene.capture.cameras.iter().map(|camera| &camera.name).collect();
        assert_eq!(places, names, "every place is looked from, however many cameras are gone");
        let left = 3 - gone as usize;
        for (index, fold) in folds.iter().enumerate() {
            assert_eq!(fold.capture.cameras.len(), left - usize::from(index < left));
        }
    }

    let views = Truth::Views(Vec::new());
    assert_eq!(Disturbance::FewerCameras.dial(&scene.capture, &views), [0.0, 1.0, 2.0]);
    let pair = scene.capture.with_cameras(|index, _| index < 2);
    assert_eq!(Disturbance::FewerCameras.dial(&pair, &Truth::HoldOut), [0.0]);
}

#[test]
fn loss_is_over_the_views_that_are_left_and_the_warning_names_the_dial_at_which_others_are_not() {
    let scene = orrery(2);
    let alone = scene.capture.with_cameras(|index, _| index == 0);
    let mut plan = StressPlan {
        disturbances: vec![Disturbance::MissingCamera],
        ..StressPlan::standard(&Settings::default())
    };
    plan.methods.truncate(1);
    let job = Job::new();
    let points = stress::run(&alone, &plan, &scene.truth, &job, |_, _| ()).unwrap().points;
    let [all, half] = [0.0, 50.0].map(|dial| points.iter().find(|point| point.dial == dial).unwrap());
    assert!(
        !half.point.views.is_empty() && half.point.views.len() < all.point.views.len(),
        "frame 1 is gone"
    );
    // Of each vantage one frame is left.
    let mean = |point: &StressPoint| {
        let of = point
            .point
            .views
            .iter()
            .filter(|view| half.point.views.iter().any(|left| left.file_path == view.file_path));
        of.map(|view| view.psnr_filled_db).sum::<f64>() / half.point.views.len() as f64
    };
    assert!((half.loss_db - (mean(all) - mean(half))).abs() < 1e-9);
    assert!((half.loss_db - (all.point.psnr_filled_db - half.point.psnr_filled_db)).abs() > 1e-6);
    let warnings = job.warnings();
    let named = warnings.iter().filter(|line| line.contains("'missing camera' at 50 % of frames: view '"));
    assert_eq!(named.count(), all.point.views.len() - half.point.views.len(), "{warnings:?}");
}

#[test]
fn what_cannot_disturb_a_capture_is_left_out_with_a_word_and_nothing_else_is_no_stress() {
    let Scene { capture, truth } = orrery(1);
    let capture = capture.without_normals();
    let idle = vec![Disturbance::NormalsMissing, Disturbance::NormalsNoisy, Disturbance::OutOfSync];
    let mut plan = StressPlan { disturbances: idle, ..StressPlan::standard(&Settings::default()) };
    plan.methods.truncate(1);
    let job = Job::new();
    let error = stress::run(&capture, &plan, &truth, &job, |_, _| ()).unwrap_err().to_string();
    assert!(error.contains("is not changed by any of the chosen disturbances"), "{error}");
    let [missing, _, late] = job.warnings().try_into().unwrap();
    assert!(missing.contains("'normals missing' is left out") && missing.contains("no recorded normals"));
    assert!(late.contains("'camera out of sync' is left out") && late.contains("a single frame"), "{late}");
    plan.disturbances.push(Disturbance::Exposure);
    let points = stress::run(&capture, &plan, &truth, &job, |_, _| ()).unwrap().points;
    assert!(points.iter().all(|point| point.disturbance == "exposure") && points.len() == 5);
}
