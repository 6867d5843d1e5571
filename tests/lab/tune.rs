//! Tuning: the same answer every time, no camera too many, and nothing claimed that is not so.

use std::collections::BTreeSet;

use overlook_engine::edits::{Action, Edit, EditList, Region};
use overlook_engine::job::Job;
use overlook_engine::preprocess::preprocess;
use overlook_engine::settings::{Settings, SpanLevels};
use overlook_lab::sweep::Point;
use overlook_lab::trial::Fineness;
use overlook_lab::truth::Truth;
use overlook_lab::tune::{self, CameraWorth, RankPlan, TuneBudget, TunePlan, Tuned};

use crate::scenes::{Scene, flashing, one_too_many, orrery, still};

fn plan() -> TunePlan {
    TunePlan { drop_cameras: true, ..TunePlan::of(Settings::default()) }
}

fn tuned(scene: &Scene, plan: &TunePlan) -> Tuned {
    let tuned = tune::run(&scene.capture, plan, &scene.truth, &Job::new(), |_| ()).unwrap();
    println!("{}", tuned.words.join("\n"));
    tuned
}

#[test]
fn a_redundant_camera_is_dropped_and_no_other_and_the_answer_is_the_same_every_time() {
    let scene = one_too_many(2);
    let first = tuned(&scene, &plan());
    let names: Vec<_> = scene.capture.cameras[..3].iter().map(|camera| camera.name.clone()).collect();
    assert_eq!(first.cameras, names, "exactly the added camera goes");
    assert_eq!(first.at_most_db, Some(tune::AT_MOST_DB));
    let (best, chosen) = (&first.best, &first.chosen);
    assert!(chosen.psnr_filled_db >= best.psnr_filled_db - tune::AT_MOST_DB);
    assert!(chosen.bytes_of_samples() <= best.bytes_of_samples());
    // Nothing simpler was passed over that is as accurate as the best at every viewpoint.
    let is_as_good = |point: &Point| {
        point.views.iter().zip(&best.views).all(|(own, best)| own.psnr_filled_db >= best.psnr_filled_db)
    };
    let simpler = |point: &&Point| {
        point.bytes_of_samples() < chosen.bytes_of_samples()
            && point.views.len() == best.views.len()
            && is_as_good(point)
    };
    assert!(first.points.iter().filter(|point| !point.label.starts_with("without")).find(simpler).is_none());

    let second = tuned(&scene, &plan());
    assert_eq!(
        (first.settings, first.cameras, first.camera_costs, first.words),
        (second.settings, second.cameras, second.camera_costs, second.words)
    );
}

fn ranked(scene: &Scene, truth: &Truth, plan: &RankPlan) -> Vec<CameraWorth> {
    let mut cameras = Vec::new();
    let add = |camera: &CameraWorth, (known, of): (usize, usize)| {
        assert!(known <= of);
        cameras.push(camera.clone());
    };
    tune::rank_cameras(&scene.capture, plan, truth, &Job::new(), add).unwrap();
    CameraWorth::sort(&mut cameras);
    cameras
}

#[test]
fn the_camera_that_others_make_needless_comes_first_and_its_figures_are_those_without_it() {
    let scene = one_too_many(2);
    let added = scene.capture.cameras.last().unwrap().name.clone();
    for truth in [&scene.truth, &Truth::HoldOut] {
        let (settings, edits) = (Settings::default(), EditList::default());
        let mut plan = RankPlan { settings, edits, done: Vec::new() };
        let cameras = ranked(&scene, truth, &plan);
        println!("{cameras:#?}");
        assert_eq!(cameras.len(), scene.capture.cameras.len());
        let (first, last) = (&cameras[0], cameras.last().unwrap());
        assert_eq!(first.name, added);
        assert!(first.seen_alone < 0.01 && last.seen_alone > first.seen_alone);
        assert!(first.psnr_filled_db > last.psnr_filled_db);
        assert_eq!(first.loss_db.is_some(), matches!(truth, Truth::Views(_)));
        let kept = |without: Option<&str>| {
            let capture = scene.capture.with_cameras(|_, camera| Some(camera.name.as_str()) != without);
            preprocess(&capture, &Settings::default(), &Job::new()).unwrap().samples.sample_count() as i64
        };
        assert_eq!(last.samples_less, kept(None) - kept(Some(&last.name)));
        // What is known is not measured again.
        plan.done = cameras[1..].to_vec();
        assert_eq!(ranked(&scene, truth, &plan), std::slice::from_ref(first));
        // What edits leave out is not there.
        plan.done.clear();
        let names = Region::Cameras(vec![added.clone()]);
        plan.edits.edits.push(Edit::new("needless", Action::LeaveOut, names));
        let names = |cameras: &[CameraWorth]| -> BTreeSet<String> {
            cameras.iter().map(|camera| camera.name.clone()).collect()
        };
        assert_eq!(names(&ranked(&scene, truth, &plan)), names(&cameras[1..]));
    }
}

#[test]
fn little_time_is_enough_for_an_answer_and_what_is_left_out_is_not_varied() {
    let scene = orrery(2);
    let time = Some(std::time::Duration::ZERO);
    let hurried = tuned(&scene, &TunePlan { drop_cameras: false, time, ..plan() });
    assert!(hurried.points.iter().all(|point| !point.label.contains(" = ")), "nothing was varied");
    let left_out = |paths: &[&str]| paths.iter().map(|path| (*path).to_owned()).collect();
    let of = |plan: &TunePlan| plan.first_trials().len();
    let (all, fewer) = (plan(), TunePlan { left_out: left_out(&["pruning.depth_tolerance"]), ..plan() });
    let coarse = TunePlan { fineness: Fineness::Coarse, ..plan() };
    assert!(
        of(&fewer) + 5 == of(&all) && of(&coarse) < of(&all),
        "{} {} {}",
        of(&fewer),
        of(&all),
        of(&coarse)
    );
}

#[test]
fn what_changes_nothing_is_not_turned() {
    let scene = orrery(2);
    let one = Scene { capture: scene.capture.with_cameras(|index, _| index == 0), truth: scene.truth };
    let pruning = tuned(&one, &TunePlan { drop_cameras: false, ..plan() }).settings.pruning;
    let default = Settings::default().pruning;
    // A camera alone has nothing to prune, by whatever rule.
    assert_eq!(
        (pruning.method, pruning.rate, pruning.depth_tolerance, pruning.normal_tolerance),
        (default.method, default.rate, default.depth_tolerance, default.normal_tolerance)
    );
    assert_eq!((pruning.color_tolerance, pruning.overlap), (default.color_tolerance, default.overlap));
}

#[test]
fn a_scene_at_rest_ends_with_one_span() {
    let tuned = tuned(&still(4), &TunePlan { drop_cameras: false, ..plan() });
    assert_ne!(tuned.settings.spans.levels, SpanLevels::Off);
    assert_eq!((tuned.chosen.spans, tuned.chosen.samples_shared), (1, tuned.chosen.samples));
    assert!(tuned.words.iter().any(|line| line.contains("single span")), "{:?}", tuned.words);
}

#[test]
fn a_scene_that_changes_everywhere_is_not_called_still() {
    let tuned = tuned(&flashing(4), &TunePlan { drop_cameras: false, ..plan() });
    let shared = tuned.chosen.samples_shared as f64 / tuned.chosen.samples as f64;
    assert!(shared < 0.01 && tuned.chosen.spans >= 4, "{shared} of the samples are said to stay the same");
    assert!(!tuned.words.iter().any(|line| line.contains("single span")), "{:?}", tuned.words);
}

#[test]
fn a_budget_is_kept_and_one_that_cannot_be_kept_is_refused() {
    let scene = orrery(2);
    let free = tuned(&scene, &TunePlan { drop_cameras: false, ..plan() });
    let folder = tempfile::tempdir().unwrap();
    let size = |settings: &Settings| {
        let made = preprocess(&scene.capture, settings, &Job::new()).unwrap();
        overlook_engine::store::file::write(
            &folder.path().join("t.ovl"),
            &made.samples,
            &made.report.to_json().unwrap(),
            &Job::new(),
        )
        .unwrap()
    };
    let bytes = size(&Settings::default()) * 9 / 10;
    let within =
        TunePlan { budget: Some(TuneBudget::Bytes(bytes)), drop_cameras: false, done: free.points, ..plan() };
    let kept = tuned(&scene, &within);
    assert!(kept.at_most_db.is_none());
    let whole = kept.bytes_whole.unwrap();
    assert!(size(&kept.settings) <= whole && whole <= bytes, "{whole} of {bytes}");
    // The record of where a store comes from, and of the settings of painting, is a few hundred bytes at most.
    let best = kept.points.iter().filter(|point| point.bytes + 1000 <= bytes);
    let best = best.map(|point| point.psnr_filled_db).fold(0.0, f64::max);
    assert!(kept.chosen.psnr_filled_db >= best);

    let absurd = TunePlan { budget: Some(TuneBudget::Bytes(10)), ..within };
    let error = tune::run(&scene.capture, &absurd, &scene.truth, &Job::new(), |_| ()).unwrap_err();
    assert!(error.to_string().contains("10 bytes"), "{error}");
}
