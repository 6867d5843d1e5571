//! What became of every pixel of a capture adds up, whatever the scene and the settings.

use overlook_engine::demo::{Demo, DemoSpec, SCENES};
use overlook_engine::job::Job;
use overlook_engine::preprocess::preprocess;
use overlook_engine::settings::{CaptureSettings, MixedPixels, PruningMethod, Settings, SpanLevels};

use crate::small_capture;

#[test]
fn kept_redundant_empty_mixed_and_contradicted_pixels_are_all_pixels() {
    let mut captures = vec![small_capture::capture()];
    for (scene, _) in SCENES {
        let spec = DemoSpec::new(*scene).cameras(3).frames(3).size((48, 36));
        captures.push(Demo::new(&spec).unwrap().capture(&CaptureSettings::default()));
    }
    let mut drops = Settings::default();
    drops.pruning.mixed_pixels = MixedPixels::Drop;
    drops.spans.levels = SpanLevels::Paper;
    let mut first = Settings::default();
    first.pruning.method = PruningMethod::FirstCamera;
    for capture in &captures {
        for settings in [&Settings::default(), &drops, &first] {
            let report = preprocess(capture, settings, &Job::new()).unwrap().report;
            let account = report.pixel_account();
            assert_eq!(account.sum(), capture.pixel_count(), "{}: {account:?}", capture.name);
            assert_eq!(account.pixels, capture.pixel_count());
            assert!(account.represented() > 0 && account.cut == 0, "{}: {account:?}", capture.name);
        }
    }
}
