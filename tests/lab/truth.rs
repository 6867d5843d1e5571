//! Truth: a view without a known pixel takes no part.

use std::sync::Arc;

use overlook_engine::capture::transforms::{open_views, write_capture};
use overlook_engine::capture::{INVALID_INVERSE_DEPTH, TruthView};
use overlook_engine::job::Job;
use overlook_engine::preprocess::preprocess;
use overlook_engine::settings::Settings;
use overlook_lab::truth::Truth;
use overlook_lab::{evaluate, vantage_order};

use crate::scenes::orrery;

#[test]
fn a_view_whose_true_picture_knows_no_pixel_is_left_out_of_the_means_and_told() {
    let scene = orrery(1);
    let Truth::Views(views) = &scene.truth else { panic!("the orrery has views") };
    let settings = Settings::default();
    let samples = preprocess(&scene.capture, &settings, &Job::new()).unwrap().samples;
    let mut truth = views[0].truth.as_ref().unwrap()().unwrap();
    truth.inverse_depth.as_mut_slice().fill(INVALID_INVERSE_DEPTH);
    let blank = TruthView {
        file_path: "blank.exr".to_owned(),
        truth: Some(Arc::new(move || Ok(truth.clone()))),
        ..views[0].clone()
    };
    let score = |views: &[TruthView]| {
        let job = Job::new();
        let evaluation = evaluate(&samples, views, &settings.render, &job).unwrap();
        (evaluation, job.warnings())
    };
    let (known, nothing_told) = score(&views[1..]);
    let (with_blank, told) = score(&[&[blank], &views[1..]].concat());
    assert_eq!(with_blank.views[0].scores, None);
    assert_eq!(with_blank.mean.psnr_all_db, known.mean.psnr_all_db);
    assert_eq!(with_blank.mean.coverage, known.mean.coverage);
    assert!(nothing_told.is_empty());
    assert!(told.len() == 1 && told[0].contains("'blank.exr' is left out of the scores"), "{told:?}");
}

#[test]
fn views_of_one_camera_whose_poses_went_through_text_are_one_vantage_and_show_flicker() {
    let scene = orrery(2);
    let Truth::Views(views) = &scene.truth else { panic!("the orrery has views") };
    let folder = tempfile::tempdir().unwrap();
    write_capture(folder.path(), &scene.capture, views, &Job::new()).unwrap();
    let path = folder.path().join("novel/transforms.json");
    let exact: serde_json::Value = serde_json::from_slice(&std::fs::read(&path).unwrap()).unwrap();
    let settings = Settings::default();
    let samples = preprocess(&scene.capture, &settings, &Job::new()).unwrap().samples;
    let evaluated = |off: f64| {
        let mut manifest = exact.clone();
        for (index, entry) in manifest["frames"].as_array_mut().unwrap().iter_mut().enumerate() {
            for row in 0..3 {
                let number = &mut entry["transform_matrix"][row][3];
                *number = (number.as_f64().unwrap() + off * (index % 2) as f64).into();
            }
        }
        std::fs::write(&path, manifest.to_string()).unwrap();
        let views = open_views(&path).unwrap();
        let order = vantage_order(&views.iter().collect::<Vec<_>>());
        let at_hand = |pair: &[usize]| views[pair[0]].camera == views[pair[1]].camera;
        let followed = order.windows(2).filter(|pair| at_hand(pair)).count();
        (followed, evaluate(&samples, &views, &settings.render, &Job::new()).unwrap().mean.flicker_steps)
    };
    let as_written = evaluated(0.0);
    assert!(as_written.0 == 3 && as_written.1.is_some(), "{as_written:?}");
    assert_eq!(evaluated(5e-7), as_written);
    assert_eq!(evaluated(0.01), (0, None), "what moves is no vantage");
}
