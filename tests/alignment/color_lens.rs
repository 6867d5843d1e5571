//! Color that is seen by a sensor beside the depth sensor, where the capture claims one lens and one place for both.

use std::sync::Arc;

use glam::{DAffine3, DQuat, DVec3};
use overlook_engine::alignment::{AlignedLens, align};
use overlook_engine::capture::{Camera, Capture, CaptureParts, Frame, FrameSource, TruthView};
use overlook_engine::demo::{Demo, DemoSpec};
use overlook_engine::error::Result;
use overlook_engine::job::Job;
use overlook_engine::settings::{AlignSettings, CaptureSettings, Correction, Settings};
use overlook_lab::compare;

/// A demo whose color is seen through another lens and from another place than its depth.
struct TwoSensors {
    demo: Demo,
    depth_cameras: Vec<Camera>,
    color_cameras: Vec<Camera>,
}

impl FrameSource for TwoSensors {
    fn load(&self, camera: usize, frame: usize) -> Result<Frame> {
        let color = self.demo.render(&self.color_cameras[camera], frame).color;
        Ok(Frame { color, ..self.demo.render(&self.depth_cameras[camera], frame) })
    }

    fn place(&self, camera: usize, frame: usize) -> String {
        format!("camera {camera}, frame {frame}")
    }
}

/// The sensors of a Kinect: the color lens is shorter, and 25 mm to the side.
const FOCAL_RATIO: f64 = 0.894;

fn color_from_depth() -> DAffine3 {
    DAffine3::from_rotation_translation(
        DQuat::from_scaled_axis(DVec3::new(0.004, -0.006, 0.002)),
        DVec3::new(-0.025, 0.002, 0.001),
    )
}

fn color_camera(depth: &Camera) -> Camera {
    let mut color = depth.clone();
    color.intrinsics.fx *= FOCAL_RATIO;
    color.intrinsics.fy *= FOCAL_RATIO;
    color.world_from_camera *= color_from_depth().inverse();
    color
}

/// Eight cameras of one lens around the room.
fn demo() -> Demo {
    Demo::new(&DemoSpec::new("nine-cameras").frames(1).size((320, 240)).noise(0.0)).unwrap()
}

/// What the demo's first eight cameras record, and what its file claims: depth's lens and place, for color too.
fn recorded_by_two_sensors(demo: &Demo) -> Capture {
    let capture = demo.capture(&CaptureSettings::default()).with_cameras(|index, _| index < 8);
    let depth_cameras = capture.cameras.clone();
    let color_cameras = depth_cameras.iter().map(color_camera).collect();
    let source = Arc::new(TwoSensors { demo: demo.clone(), depth_cameras, color_cameras });
    let parts: CaptureParts = (*capture).clone();
    Capture::new(CaptureParts { source, ..parts }, 1 << 28)
}

fn lens_alone() -> AlignSettings {
    AlignSettings { lens: Correction::Auto, ..AlignSettings::OFF }
}

#[test]
fn the_lens_of_color_is_found_and_its_place_within_half_a_pixel() {
    let capture = recorded_by_two_sensors(&demo());
    let found = align(&capture, &lens_alone(), &Job::new()).unwrap();
    let alignment = found.alignment.unwrap();
    let [lens]: &[AlignedLens; 1] = alignment.lenses.as_slice().try_into().unwrap();
    let truth = color_camera(&capture.cameras[0]);
    let off = lens.color.fx / truth.intrinsics.fx - 1.0;
    assert!(off.abs() < 0.003, "the focal length is off by {off}: {}", lens.sentence());
    let shift = (lens.color_from_depth.translation - color_from_depth().translation).length();
    // A pixel is 12 mm wide where these cameras look: less than half of that.
    assert!(shift < 0.005, "the place is off by {shift} m: {}", lens.sentence());
    assert!(lens.loss_after < 0.5 * lens.loss_before, "{lens:?}");
    let degrees_se = lens.degrees_se.unwrap();
    assert!(lens.focal_se > 0.0 && lens.focal_se < 2.0 && degrees_se > 0.0, "{lens:?}");
    // What is seen of one surface point is then the same in color and depth.
    for (now, then) in found.capture.cameras.iter().zip(&capture.cameras) {
        assert_eq!(now.intrinsics, lens.color);
        let expected = color_camera(then).position_in_world();
        assert!(now.position_in_world().distance(expected) < 0.005);
    }
    let frame = found.capture.frame(0, 0).unwrap();
    let truth = demo().render(&truth, 0);
    let pixels = frame.inverse_depth.as_slice().iter().zip(truth.inverse_depth.as_slice());
    let (mut right, mut all) = (0, 0);
    for (found, truth) in pixels.filter(|(found, _)| **found > 0.0) {
        all += 1;
        right += usize::from((found / truth - 1.0).abs() < 0.01);
    }
    // Beside silhouettes half a pixel decides which surface is seen.
    assert!(
        all > 40_000 && right * 100 > all * 90,
        "{right} of {all} pixels have the depth of what they show"
    );
}

#[test]
fn pictures_of_the_same_sensor_fit_once_its_color_lens_is_found() {
    let demo = demo();
    let capture = recorded_by_two_sensors(&demo);
    let [front, right] = [0, 2].map(|camera: usize| capture.cameras[camera].world_from_camera);
    let mut claimed = capture.cameras[0].clone();
    let middle = front.translation.lerp(right.translation, 0.5);
    claimed.world_from_camera = DAffine3 { translation: middle, ..front };
    let truth_camera = color_camera(&claimed);
    let truth = Arc::new(move || Ok(demo.render(&truth_camera, 0)));
    let view = TruthView::new("held_out.png".to_owned(), claimed, capture.frame_numbers[0], Some(truth));
    let [off, auto] = [AlignSettings::OFF, lens_alone()].map(|align| {
        let settings = Settings { align, ..Settings::default() };
        let scores = compare(&capture, std::slice::from_ref(&view), &settings, false, &Job::new()).unwrap();
        scores.as_set.evaluation.mean.psnr_db.unwrap()
    });
    assert!(auto > off + 4.0, "{auto} dB with the color lens, {off} dB without");
}

#[test]
fn color_that_has_the_lens_of_depth_keeps_every_bit() {
    for noise in [0.0, 0.03] {
        let spec = DemoSpec::new("nine-cameras").frames(1).size((320, 240)).noise(noise);
        let capture = Demo::new(&spec).unwrap().capture(&CaptureSettings::default());
        let found = align(&capture, &lens_alone(), &Job::new()).unwrap();
        assert!(found.alignment.is_none(), "noise {noise}: {:?}", found.alignment);
        assert_eq!(found.capture.cameras, capture.cameras);
        assert!(Arc::ptr_eq(&found.capture.frame(0, 0).unwrap(), &capture.frame(0, 0).unwrap()));
    }
}

#[test]
fn too_few_cameras_do_not_tell_a_lens_and_nothing_is_changed() {
    let capture = recorded_by_two_sensors(&demo()).with_cameras(|index, _| index < 3);
    let found = align(&capture, &lens_alone(), &Job::new()).unwrap();
    assert!(found.alignment.is_none());
    assert_eq!(found.capture.cameras, capture.cameras);
}
