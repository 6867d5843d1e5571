//! What truth says: a view of which nothing is known takes no part.

use std::sync::Arc;

use overlook::capture::{INVALID_INVERSE_DEPTH, View};
use overlook::evaluate::evaluate;
use overlook::evaluate::truth::Truth;
use overlook::job::Job;
use overlook::preprocess::preprocess;
use overlook::settings::Settings;

use crate::scenes::orrery;

#[test]
fn a_view_whose_true_picture_knows_no_pixel_is_left_out_of_the_means_and_told() {
    let scene = orrery(1);
    let Truth::Views(views) = &scene.truth else { panic!("the orrery has views") };
    let settings = Settings::default();
    let samples = preprocess(&scene.capture, &settings, &Job::new()).unwrap().samples;
    let mut truth = views[0].truth.as_ref().unwrap()().unwrap();
    truth.inverse_depth.as_mut_slice().fill(INVALID_INVERSE_DEPTH);
    let blank = View {
        file_path: "blank.exr".to_owned(),
        truth: Some(Arc::new(move || Ok(truth.clone()))),
        ..views[0].clone()
    };
    let score = |views: &[View]| {
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
