//! On real renderer output: pruning by sampling rate keeps the picture, first camera wins does not.

use std::path::Path;

use overlook::capture::transforms::{open, open_views};
use overlook::capture::{Capture, View};
use overlook::evaluate::{Compared, compare, evaluate};
use overlook::job::Job;
use overlook::preprocess::{preprocess, scan};
use overlook::settings::{CaptureSettings, Kernel, RenderSettings, Settings};

#[test]
fn pruning_by_rate_costs_little_and_first_camera_wins_costs_clearly_more() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/small_capture");
    let capture = open(&folder, &CaptureSettings::default()).unwrap();
    let views = open_views(&folder.join("novel/transforms.json")).unwrap();
    assert_eq!((capture.cameras.len(), capture.frame_count()), (4, 4));

    // First camera wins loses three times the coverage of blocks. Footprints close many of its gaps as well: twice.
    compare_rules(&capture, &views, Kernel::Block, 3.0);
    compare_rules(&capture, &views, Kernel::Gather, 2.0);
}

fn compare_rules(capture: &Capture, views: &[View], kernel: Kernel, coverage_ratio: f64) {
    let mut settings = Settings::default();
    settings.render.kernel = kernel;
    let comparison = compare(capture, views, &settings, &Job::new()).unwrap();
    let mean = |compared: &Compared| compared.evaluation.mean.clone();
    let all = mean(&comparison.no_pruning);
    let lost = |compared: &Compared| {
        let mean = mean(compared);
        (
            all.psnr_db.unwrap() - mean.psnr_db.unwrap(),
            all.psnr_all_db.unwrap() - mean.psnr_all_db.unwrap(),
            all.coverage.unwrap() - mean.coverage.unwrap(),
        )
    };
    let (ours, first) = (lost(&comparison.as_set), lost(&comparison.first_camera));
    println!(
        "{kernel} lost (dB where sampled, dB everywhere, coverage): by rate {ours:?}, first camera wins {first:?}"
    );
    assert!(ours.0 <= 0.15, "pruning by rate loses {} dB", ours.0);
    assert!(first.0 > 1.5 * ours.0, "first camera wins loses {} dB, by rate {}", first.0, ours.0);
    assert!(first.1 > 2.0 * ours.1, "with holes black: {} dB, by rate {}", first.1, ours.1);
    assert!(
        ours.2 < 0.005 && first.2 > coverage_ratio * ours.2,
        "coverage lost: {} by rate, {}",
        ours.2,
        first.2
    );
    let (ours, all) = (&comparison.as_set, &comparison.no_pruning);
    assert!(ours.samples_kept * 10 < all.samples_kept * 8, "{} of {}", ours.samples_kept, all.samples_kept);
}

#[test]
fn gathering_comes_closer_to_a_renderer_s_truth_than_blocks_and_surfels_do() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/small_capture");
    let capture = open(&folder, &CaptureSettings::default()).unwrap();
    let views = open_views(&folder.join("novel/transforms.json")).unwrap();
    let samples = preprocess(&capture, &Settings::default(), &Job::new()).unwrap().samples;
    let score = |kernel| {
        let settings = RenderSettings { kernel, ..RenderSettings::default() };
        let mean = evaluate(&samples, &views, &settings, &Job::new()).unwrap().mean;
        println!("{kernel}: {:?} dB, SSIM {:?}", mean.psnr_db, mean.ssim);
        (mean.psnr_db.unwrap(), mean.ssim.unwrap())
    };
    let (block, surfel, gather) = (score(Kernel::Block), score(Kernel::Surfel), score(Kernel::Gather));
    assert!(gather.0 > block.0 + 1.5 && gather.1 > block.1, "gather {gather:?}, block {block:?}");
    assert!(surfel.0 > block.0 + 0.7 && gather.0 > surfel.0, "surfel {surfel:?}");
}

#[test]
fn both_estimators_come_close_to_the_normals_that_the_renderer_gave() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/small_capture");
    let capture = open(&folder, &CaptureSettings::default()).unwrap();
    let scan = scan(&capture, &Settings::default(), &Job::new()).unwrap();
    for camera in &scan.cameras {
        assert_eq!(camera.normal_errors.len(), 2);
        for errors in &camera.normal_errors {
            println!("{errors:?}");
            assert!(errors.median_degrees < 10.0 && errors.trusted > 0.4, "{errors:?}");
        }
    }
}
