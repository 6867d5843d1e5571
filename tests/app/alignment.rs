//! What was corrected of the cameras, seen in the window and compared with the capture as it claims to be.

use std::path::Path;

use egui_kittest::kittest::{NodeT, Queryable};
use glam::{DAffine3, DQuat};
use overlook::app::Start;
use overlook_engine::capture::transforms::write_capture;
use overlook_engine::demo::{Demo, DemoSpec};
use overlook_engine::job::Job;
use overlook_engine::settings::CaptureSettings;

use super::driver::{SIZE, click, open, open_view, settle, shows, small_demo};

/// Writes the orrery with one camera that claims to be turned by half a degree.
fn write_misplaced(folder: &Path) {
    let demo = Demo::new(&DemoSpec::new("orrery").frames(1).size((240, 180))).unwrap();
    let turn = DQuat::from_rotation_y(0.5_f64.to_radians());
    let capture = demo.capture(&CaptureSettings::default()).with_changed_cameras(|index, camera| {
        if index == 2 {
            camera.world_from_camera *= DAffine3::from_quat(turn);
        }
    });
    write_capture(folder, &capture, &demo.truth_views(), &Job::new()).unwrap();
}

#[test]
fn a_camera_that_was_moved_is_told_and_compared_with_what_it_claimed() {
    let folder = tempfile::tempdir().unwrap();
    write_misplaced(folder.path());
    let mut window = open(Start::Path(folder.path().to_path_buf()), SIZE);
    settle(&mut window);
    open_view(&mut window, "Report");
    assert!(shows(&window, "What was corrected") && shows(&window, "footprints"));
    let moved = window.query_all_by_label_contains("0.50°").count();
    assert_eq!(moved, 1, "one camera was turned");
    for heading in ["Angle", "Moved, m", "Footprints"] {
        assert!(window.query_all_by_label(heading).next().is_some(), "{heading} is a column");
    }
    click(&mut window, "Compare before and after");
    settle(&mut window);
    for (side, shown) in [("Left side", "Uncorrected poses and exposure"), ("Right side", "Kept samples")] {
        let value = window.get_by_label(side).accesskit_node().value();
        assert_eq!(value.as_deref(), Some(shown), "{side}");
    }
}

#[test]
fn a_capture_that_is_right_has_nothing_to_compare() {
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    open_view(&mut window, "Report");
    assert!(!shows(&window, "What was corrected"));
    assert!(window.query_by_label("Compare before and after").is_none());
}
