//! What is written is read again: captures, vantages, and the small real one that others wrote.

use crate::small_capture;
use std::sync::Arc;

use glam::{DVec2, DVec3};
use half::f16;
use overlook_engine::capture::transforms::{self, write_capture};
use overlook_engine::capture::{
    Camera, Capture, CaptureParts, Frame, FrameSource, Intrinsics, TruthView, Values,
};
use overlook_engine::error::{Error, Result};
use overlook_engine::grid::Grid;
use overlook_engine::job::Job;
use overlook_engine::settings::CaptureSettings;

struct Numbers;

fn numbered_frame(camera: usize, frame: usize) -> Frame {
    let (width, height) = (5 + camera, 3);
    let value = move |x: usize, y: usize| (x + 10 * y + 100 * frame + 1000 * camera) as f32;
    Frame {
        color: Grid::from_fn(width, height, |x, y| [value(x, y), -1.0, 0.25].map(f16::from_f32)),
        // Powers of two are their own reciprocals' reciprocals.
        inverse_depth: Grid::from_fn(width, height, |x, y| match x + y {
            0 => -1.0,
            1 => 0.0,
            sum => 0.5_f32.powi(sum as i32),
        }),
        normal_in_world: Some(Grid::from_fn(width, height, |x, y| {
            if x + y < 2 { [0.0; 3] } else { [0.0, -1.0, 0.0] }
        })),
        depth_step_relative: 0.0,
        values: Values::default(),
    }
}

impl FrameSource for Numbers {
    fn load(&self, camera: usize, frame: usize) -> Result<Frame> {
        Ok(numbered_frame(camera, frame))
    }

    fn place(&self, camera: usize, frame: usize) -> String {
        format!("{camera}/{frame}")
    }
}

fn numbers() -> (Capture, Vec<TruthView>) {
    let camera = |index: usize| {
        let intrinsics = Intrinsics { fy: 4.5, cx: 2.25, ..Intrinsics::centered(5 + index as u32, 3, 4.0) };
        let eye = DVec3::new(0.25 * index as f64, -4.0, 0.125);
        Camera::look_at(format!("cam {index}"), intrinsics, eye, DVec3::ZERO, DVec3::Z)
    };
    let parts = CaptureParts {
        name: "numbers".into(),
        cameras: (0..2).map(camera).collect(),
        frame_numbers: vec![3, 5, 12],
        up_in_world: DVec3::Y,
        has_normals: true,
        antialiased_color: false,
        warnings: vec![],
        source: Arc::new(Numbers),
    };
    let view = |index: usize, with_truth: bool| {
        let truth = with_truth.then(|| Arc::new(move || Ok(numbered_frame(index, 1))) as _);
        TruthView::new(format!("v/{index}.png"), camera(index), 5, truth)
    };
    (Capture::new(parts, 1 << 20), vec![view(0, true), view(1, false)])
}

#[test]
fn a_written_capture_reads_as_it_was() {
    let folder = tempfile::tempdir().unwrap();
    let (capture, views) = numbers();
    let job = Job::new();
    write_capture(folder.path(), &capture, &views, &job).unwrap();
    assert_eq!(job.progress().fraction(), 1.0);
    let read = transforms::open(folder.path(), &CaptureSettings::default()).unwrap();
    assert_eq!(read.frame_numbers, capture.frame_numbers);
    assert_eq!((read.up_in_world, read.has_normals, read.antialiased_color), (DVec3::Y, true, false));
    assert_eq!(read.warnings, Vec::<String>::new());
    for (index, camera) in read.cameras.iter().enumerate() {
        assert_eq!(
            (&camera.name, camera.intrinsics),
            (&capture.cameras[index].name, capture.cameras[index].intrinsics)
        );
        assert!(camera.world_from_camera.abs_diff_eq(capture.cameras[index].world_from_camera, 1e-12));
        for frame in 0..3 {
            assert_eq!(*read.frame(index, frame).unwrap(), numbered_frame(index, frame));
        }
    }
    let read_views = transforms::open_views(&folder.path().join("novel/transforms.json")).unwrap();
    assert_eq!(read_views.len(), 2);
    assert_eq!((read_views[0].file_path.as_str(), read_views[0].frame_number), ("v/0.exr", 5));
    let truth = read_views[0].truth.as_ref().unwrap()().unwrap();
    assert_eq!(truth.color, numbered_frame(0, 1).color);
    assert!(read_views[1].truth.is_none());
}

#[test]
fn a_cancelled_export_leaves_no_manifest_not_even_that_of_an_earlier_one() {
    let folder = tempfile::tempdir().unwrap();
    let (capture, views) = numbers();
    let job = Job::new();
    write_capture(folder.path(), &capture, &views, &job).unwrap();
    job.cancel();
    assert!(matches!(write_capture(folder.path(), &capture, &views, &job), Err(Error::Cancelled)));
    assert!(transforms::open(folder.path(), &CaptureSettings::default()).is_err());
    assert!(!folder.path().join("novel/transforms.json").exists());
}

#[test]
fn names_that_lead_out_of_the_folder_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let capture = numbers().0.with_changed_cameras(|index, camera| {
        if index == 1 {
            camera.name = "../elsewhere".into();
        }
    });
    let error = write_capture(&folder.path().join("in"), &capture, &[], &Job::new()).unwrap_err();
    assert!(error.to_string().contains("../elsewhere"));
    assert!(!folder.path().join("elsewhere").exists());
}

#[test]
fn the_small_real_capture_holds_together() {
    let capture = small_capture::capture();
    assert_eq!((capture.cameras.len(), capture.has_normals), (4, true));
    assert_eq!(capture.frame_numbers, [0, 6, 12, 18]);
    let (left, front) = (capture.frame(0, 0).unwrap(), capture.frame(1, 0).unwrap());
    assert_eq!((left.invalid_pixels(), front.invalid_pixels()), (0, 0));
    // Points that the left camera saw lie, unless something stands before them, where the front camera saw them.
    let (mut seen, mut agreeing) = (0, 0);
    for y in 0..left.size().1 {
        for x in 0..left.size().0 {
            let inverse = f64::from(left.inverse_depth[(x, y)]);
            if inverse <= 0.0 {
                continue;
            }
            let point =
                capture.cameras[0].unproject(DVec2::new(x as f64 + 0.5, y as f64 + 0.5), 1.0 / inverse);
            let Some((pixel, depth_z)) = capture.cameras[1].project(point) else { continue };
            if pixel.min_element() < 0.0 {
                continue;
            }
            let Some(there) = front.inverse_depth.get(pixel.x as usize, pixel.y as usize) else { continue };
            seen += 1;
            agreeing += i32::from((f64::from(*there) * depth_z - 1.0).abs() < 0.02);
        }
    }
    assert!(seen > 2000 && agreeing * 10 > seen * 7, "{agreeing} of {seen}");
    let views = small_capture::views();
    assert_eq!(views.len(), 12);
    let truth = views[0].truth.as_ref().unwrap()().unwrap();
    assert_eq!((truth.size(), truth.invalid_pixels()), ((86, 64), 0));
}
