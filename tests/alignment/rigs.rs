//! What the rig got wrong is found to a hundredth of a degree and a tenth of a footprint, and what is right keeps every bit.

use glam::{DAffine3, DQuat, DVec3};
use half::f16;
use overlook_engine::alignment::{Aligned, align};
use overlook_engine::capture::{
    Camera, Capture, CaptureParts, Frame, FrameSource, INVALID_INVERSE_DEPTH, ValueChannel, Values,
};
use overlook_engine::demo::{Demo, DemoSpec};
use overlook_engine::error::Result;
use overlook_engine::job::Job;
use overlook_engine::settings::{AlignSettings, CaptureSettings, Correction, Settings};
use std::sync::Arc;

fn capture(scene: &str, noise: f32) -> Capture {
    let spec = DemoSpec::new(scene).frames(1).size((240, 180)).noise(noise);
    Demo::new(&spec).unwrap().capture(&CaptureSettings::default())
}

/// The capture whose manifest says that a camera is turned by `degrees` and moved by `distance`.
fn misplaced(capture: &Capture, of: impl Fn(usize) -> bool, degrees: f64, distance: f64) -> Capture {
    capture.clone().with_changed_cameras(|index, camera| {
        if !of(index) {
            return;
        }
        let seed = index as f64;
        let axis = DVec3::new((7.0 * seed + 1.0).sin(), (3.0 * seed + 2.0).cos(), (5.0 * seed + 3.0).sin());
        let turn = DQuat::from_axis_angle(axis.normalize_or_zero(), degrees.to_radians());
        let shift = distance * DVec3::new(axis.y, axis.z, axis.x).normalize_or_zero();
        camera.world_from_camera *= DAffine3::from_rotation_translation(turn, shift);
    })
}

/// Everything that can be corrected.
fn everything() -> AlignSettings {
    AlignSettings {
        poses: Correction::Auto,
        lens: Correction::Auto,
        exposure: Correction::Auto,
        clock: Correction::Auto,
    }
}

fn aligned(capture: &Capture) -> Aligned {
    align(capture, &everything(), &Job::new()).unwrap()
}

/// How far cameras are off, seen from the first one: degrees, and footprints at the distance of 4 m.
fn off(truth: &[Camera], found: &[Camera]) -> (f64, f64) {
    let from_first =
        |cameras: &[Camera], index: usize| cameras[0].camera_from_world() * cameras[index].world_from_camera;
    (1..truth.len()).fold((0.0, 0.0), |(degrees, footprints): (f64, f64), index| {
        let change = from_first(truth, index).inverse() * from_first(found, index);
        let turn = DQuat::from_mat3(&change.matrix3).to_scaled_axis().length().to_degrees();
        let moved = change.translation.length() * truth[index].intrinsics.fx / 4.0;
        (degrees.max(turn), footprints.max(moved))
    })
}

#[test]
fn one_wrong_pose_is_found_and_the_right_ones_keep_every_bit() {
    for noise in [0.0, 0.03] {
        let right = capture("orrery", noise);
        for (degrees, distance) in [(0.1, 0.0), (0.5, 0.01), (2.0, 0.0)] {
            let wrong = misplaced(&right, |index| index == 2, degrees, distance);
            let found = aligned(&wrong);
            let (angle, footprints) = off(&right.cameras, &found.capture.cameras);
            assert!(angle < 0.01, "{degrees}°, noise {noise}: still off by {angle}°");
            assert!(footprints < 0.1, "{degrees}°, noise {noise}: still off by {footprints} footprints");
            let alignment = found.alignment.unwrap();
            for (index, camera) in alignment.cameras.iter().enumerate() {
                assert_eq!(camera.pose.is_some(), index == 2, "camera {index} at {degrees}°");
                if index != 2 {
                    assert_eq!(found.capture.cameras[index], right.cameras[index]);
                }
            }
        }
    }
}

#[test]
fn a_camera_that_slid_along_floor_and_wall_is_found_though_most_distances_stay_as_they_are() {
    let right = capture("nine-cameras", 0.0);
    let shifted = right.clone().with_changed_cameras(|index, camera| {
        if index == 0 {
            camera.world_from_camera.translation.x += 0.05;
        }
    });
    let found = aligned(&shifted);
    let alignment = found.alignment.unwrap();
    for (index, camera) in alignment.cameras.iter().enumerate() {
        assert_eq!(camera.pose.is_some(), index == 0, "camera {index}");
    }
    let off = found.capture.cameras[0].world_from_camera.translation
        - right.cameras[0].world_from_camera.translation;
    assert!(off.length() < 0.002, "still off by {off}");
}

#[test]
fn the_farther_apart_cameras_were_the_more_their_pairs_say() {
    let right = capture("orrery", 0.0);
    let apart = |distance: f64| {
        let found = aligned(&misplaced(&right, |index| index == 2, 0.0, distance)).alignment.unwrap();
        let of_camera = found.pairs.iter().filter(|pair| [pair.source, pair.target].contains(&2));
        of_camera.fold([0.0_f64; 2], |most, pair| [0, 1].map(|when| most[when].max(pair.footprints[when])))
    };
    let [few, many] = [0.05, 0.2].map(apart);
    assert!(many[0] > 2.0 * few[0] && few[0] > 0.5, "before: {few:?}, {many:?} footprints");
    assert!(few[1] < 0.1 && many[1] < 0.1, "after: {few:?}, {many:?} footprints");
}

#[test]
fn poses_that_are_all_wrong_are_found_relative_to_each_other() {
    let right = capture("orrery", 0.0);
    // The last camera sees one globe and little else. Turning about it changes only its fine texture, which is found again from half a
    // degree away, but not from a whole one.
    for (degrees, cameras) in [(0.1, 5), (0.5, 5), (1.0, 4)] {
        let wrong = misplaced(&right, |_| true, degrees, 0.0);
        let found = aligned(&wrong).capture;
        let (angle, footprints) = off(&right.cameras[..cameras], &found.cameras[..cameras]);
        assert!(angle < 0.01 && footprints < 0.1, "{degrees}°: still {angle}°, {footprints} footprints");
        // None is taken for right: all together stand turned by less than each of them did.
        let [then, now] = [&right, &found].map(|capture| capture.cameras[0].world_from_camera.matrix3);
        let turn = DQuat::from_mat3(&(now * then.transpose())).to_scaled_axis().length().to_degrees();
        println!("poses {degrees}° off: all together {turn:.3}° off");
        assert!(turn < 0.6 * degrees, "{degrees}°: all together {turn}°");
    }
}

#[test]
fn a_capture_that_is_right_is_left_alone_and_gives_the_samples_of_alignment_switched_off() {
    for scene in ["orrery", "four-cameras"] {
        let right = capture(scene, 0.0);
        assert!(aligned(&right).alignment.is_none(), "{scene}");
        let on = Settings { align: everything(), ..Settings::default() };
        let [on, off] = [on, Settings { align: AlignSettings::OFF, ..Settings::default() }]
            .map(|settings| overlook_engine::preprocess::preprocess(&right, &settings, &Job::new()).unwrap());
        assert_eq!(on.samples.settings, off.samples.settings);
        assert_eq!(on.samples.cameras, off.samples.cameras);
        assert!(on.samples.images == off.samples.images, "{scene}: other samples");
    }
}

/// Cameras whose pictures are too bright, each by its own number of stops.
struct Exposed {
    right: Capture,
    stops: Vec<f64>,
    /// Pixels without depth, as a share of ten.
    holes: usize,
    values: ValueChannel,
}

impl FrameSource for Exposed {
    fn load(&self, camera: usize, frame: usize) -> Result<Frame> {
        let mut exposed = Frame::clone(&*self.right.frame(camera, frame)?);
        let gain = self.stops[camera].exp2() as f32;
        for color in exposed.color.as_mut_slice() {
            *color = color.map(|value| f16::from_f32(f32::from(value) * gain));
        }
        for (pixel, inverse_depth) in exposed.inverse_depth.as_mut_slice().iter_mut().enumerate() {
            if pixel.wrapping_mul(0x9e37_79b9) / 1024 % 10 < self.holes {
                *inverse_depth = INVALID_INVERSE_DEPTH;
            }
        }
        exposed.values = numbered(exposed.color.len());
        Ok(exposed)
    }

    fn place(&self, camera: usize, frame: usize) -> String {
        self.right.place(camera, frame)
    }

    fn value_channels(&self) -> &[ValueChannel] {
        std::slice::from_ref(&self.values)
    }
}

/// Each pixel's number as its value.
fn numbered(pixels: usize) -> Values {
    Values::from_planes(&[(0..pixels).map(|pixel| pixel as f32).collect()])
}

/// A capture whose cameras were exposed by other stops, and what was found of it.
fn exposed(stops: &[f64], holes: usize) -> (Capture, Aligned) {
    let right = capture("orrery", 0.02);
    let parts: CaptureParts = (*right).clone();
    let (name, unit) = ("pixel".to_owned(), String::new());
    let values = ValueChannel { name, unit, range: [0.0, 1e5], tolerance: 0.0, is_exact: true };
    let source = Arc::new(Exposed { right: right.clone(), stops: stops.to_vec(), holes, values });
    let found = aligned(&Capture::new(CaptureParts { source, ..parts }, 1 << 28));
    (right, found)
}

#[test]
fn exposures_are_found_where_a_sensor_has_no_depth_of_a_third_of_the_pixels() {
    let stops = [0.3, -0.2, 0.0, -0.4, 0.3];
    let (_, found) = exposed(&stops, 3);
    for (camera, (found, stops)) in found.alignment.unwrap().cameras.iter().zip(&stops).enumerate() {
        let undone = found.exposure.map_or([0.0; 3], |exposure| exposure.stops);
        for channel in undone {
            assert!((channel + stops).abs() < 0.03, "camera {camera}: {undone:?} for {stops}");
        }
    }
}

#[test]
fn exposures_are_found_and_undone() {
    let stops = [0.3, -0.2, 0.0, -0.4, 0.3];
    let (right, found) = exposed(&stops, 0);
    for (camera, (found, stops)) in found.alignment.unwrap().cameras.iter().zip(&stops).enumerate() {
        let undone = found.exposure.map_or([0.0; 3], |exposure| exposure.stops);
        for channel in undone {
            assert!((channel + stops).abs() < 0.02, "camera {camera}: {undone:?} for {stops}");
        }
    }
    let [before, after] = [&right, &found.capture].map(|capture| capture.frame(1, 0).unwrap());
    assert!(after.values == numbered(after.color.len()), "values are no colors");
    let mean = |frame: &Frame| {
        frame.color.as_slice().iter().map(|color| f32::from(color[1])).sum::<f32>() / frame.color.len() as f32
    };
    assert!((mean(&before) / mean(&after) - 1.0).abs() < 0.02);
}

/// One plane with one color: nothing tells how cameras shift along it.
struct Plane(Vec<Camera>);

impl FrameSource for Plane {
    fn load(&self, camera: usize, _frame: usize) -> Result<Frame> {
        let camera = &self.0[camera];
        let (width, height) = camera.intrinsics.size();
        let inverse_depth = overlook_engine::grid::Grid::from_fn(width, height, |x, y| {
            let ray = camera.intrinsics.ray_in_camera(glam::DVec2::new(x as f64 + 0.5, y as f64 + 0.5));
            let down = -(camera.world_from_camera.matrix3 * ray).z;
            (down / camera.position_in_world().z).max(0.0) as f32
        });
        Ok(Frame {
            color: overlook_engine::grid::Grid::filled(width, height, [f16::from_f32(0.5); 3]),
            inverse_depth,
            normal_in_world: None,
            depth_step_relative: 0.0,
            values: Values::default(),
        })
    }

    fn place(&self, camera: usize, _frame: usize) -> String {
        format!("camera {camera}")
    }
}

#[test]
fn where_geometry_does_not_tell_a_pose_it_is_said_and_nothing_is_changed() {
    let demo = capture("orrery", 0.0);
    let camera = |name: &str, eye: DVec3| {
        Camera::look_at(name, demo.cameras[0].intrinsics, eye, DVec3::ZERO, DVec3::Y)
    };
    let truth = vec![
        camera("a", DVec3::new(0.5, 0.0, 3.0)),
        camera("b", DVec3::new(-0.5, 0.0, 3.0)),
        camera("c", DVec3::new(0.0, 0.5, 3.0)),
    ];
    let parts: CaptureParts = (*demo).clone();
    let source = Arc::new(Plane(truth.clone()));
    let right = Capture::new(CaptureParts { cameras: truth, source, has_normals: false, ..parts }, 1 << 28);
    let wrong = misplaced(&right, |index| index == 1, 0.5, 0.0);
    let found = aligned(&wrong);
    assert_eq!(found.capture.cameras, wrong.cameras);
}

/// Every tenth frame of a faster recording. One camera is late by some of the fast frames.
struct Late {
    demo: Demo,
    cameras: Vec<Camera>,
    camera: usize,
    by: i64,
}

impl FrameSource for Late {
    fn load(&self, camera: usize, frame: usize) -> Result<Frame> {
        let late = if camera == self.camera { self.by } else { 0 };
        let at = (FAST * frame as i64 + late).max(0);
        Ok(self.demo.render(&self.cameras[camera], at as usize))
    }

    fn place(&self, camera: usize, frame: usize) -> String {
        format!("camera {camera}, frame {frame}")
    }
}

/// Fast frames to one that is recorded.
const FAST: i64 = 10;

fn late_by(fast_frames: i64) -> Capture {
    const FRAMES: usize = 16;
    let spec = DemoSpec::new("orrery").frames(48 * FAST as usize).size((240, 180));
    let demo = Demo::new(&spec).unwrap();
    let parts: CaptureParts = (*demo.capture(&CaptureSettings::default())).clone();
    let (cameras, camera) = (parts.cameras.clone(), 1);
    let source = Arc::new(Late { demo, cameras, camera, by: fast_frames });
    let frame_numbers = (0..FRAMES as i64).collect();
    Capture::new(CaptureParts { source, frame_numbers, ..parts }, 1 << 28)
}

#[test]
fn clocks_are_found_to_a_tenth_of_a_frame_and_whole_frames_are_moved() {
    let clock_alone = AlignSettings { clock: Correction::Auto, ..AlignSettings::OFF };
    for fast_frames in [4, 10, -14, 20] {
        let capture = late_by(fast_frames);
        let found = align(&capture, &clock_alone, &Job::new()).unwrap();
        let expected = fast_frames as f64 / FAST as f64;
        let alignment = found.alignment.unwrap_or_else(|| panic!("{expected} frames: nothing was found"));
        for (index, camera) in alignment.cameras.iter().enumerate() {
            let told = camera.clock.map_or(0.0, |clock| clock.frames);
            let right = if index == 1 { expected } else { 0.0 };
            assert!((told - right).abs() < 0.1, "camera {index}: {told} frames for {right}");
        }
        let clock = alignment.cameras[1].clock.unwrap();
        assert_eq!(clock.shifted, expected.round() as i64, "{expected} frames late");
        if fast_frames % FAST == 0 {
            let right = late_by(0);
            assert!(found.capture.frame(1, 8).unwrap().color == right.frame(1, 8).unwrap().color);
        }
    }
    assert!(align(&late_by(0), &clock_alone, &Job::new()).unwrap().alignment.is_none());
}
