//! Depth in 16-bit PNG files, which know nothing finer than their unit: an analytic scene at rest, rounded anew in every frame.

use std::path::Path;

use crate::scene::{Scene, arc, normal_draw};
use glam::{DVec2, DVec3};
use image::{ImageBuffer, Luma, Rgb};
use overlook_engine::capture::{Camera, Capture, transforms};
use overlook_engine::job::Job;
use overlook_engine::preprocess::temporal::PixelClass;
use overlook_engine::preprocess::{inspect_frame, preprocess, scan};
use overlook_engine::settings::{CaptureSettings, Settings};
use serde_json::json;

const FRAMES: usize = 5;

/// What lies farther, m, is not known: the finest unit reaches no farther.
const REACH_M: f64 = 6.5;

fn srgb(linear: f32) -> u16 {
    let encoded = if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 };
    (encoded * 65535.0).round() as u16
}

/// Writes what a camera records as nerfstudio has it: depth in whole multiples of `unit`, rounded up or down as it falls.
fn record(folder: &Path, scene: &Scene, cameras: &[Camera], unit: f64) -> Capture {
    let mut entries = Vec::new();
    for (index, camera) in cameras.iter().enumerate() {
        let (width, height) = camera.intrinsics.size();
        let size = (width as u32, height as u32);
        for number in 0..FRAMES {
            let frame = scene.trace(camera, 0, 0);
            let color = ImageBuffer::from_fn(size.0, size.1, |x, y| {
                Rgb(frame.color[(x as usize, y as usize)].map(|c| srgb(c.to_f32())))
            });
            let depth = ImageBuffer::from_fn(size.0, size.1, |x, y| {
                let w = f64::from(frame.inverse_depth[(x as usize, y as usize)]);
                let key = (x as usize + 1000 * y as usize, number, index);
                let dither = f64::from(normal_draw(key).abs()).fract();
                let known = w > 1.0 / REACH_M;
                Luma([if known { (1.0 / (w * unit) + dither) as u16 } else { 0 }])
            });
            let (color_name, depth_name) =
                (format!("c{index}-{number}.png"), format!("d{index}-{number}.png"));
            color.save(folder.join(&color_name)).unwrap();
            depth.save(folder.join(&depth_name)).unwrap();
            let axes = camera.world_from_camera.matrix3;
            let (x, y, z, t) =
                (axes.x_axis, -axes.y_axis, -axes.z_axis, camera.world_from_camera.translation);
            let row = |i: usize| [x[i], y[i], z[i], t[i]];
            entries.push(json!({
                "file_path": color_name, "depth_file_path": depth_name, "camera": camera.name, "time": number,
                "transform_matrix": [row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]],
            }));
        }
    }
    let k = cameras[0].intrinsics;
    let manifest = json!({
        "fl_x": k.fx, "fl_y": k.fy, "cx": k.cx, "cy": k.cy, "w": k.width, "h": k.height,
        "depth_unit_scale_factor": unit, "frames": entries,
    });
    let path = folder.join("transforms.json");
    std::fs::write(&path, manifest.to_string()).unwrap();
    transforms::open(&path, &CaptureSettings::default()).unwrap()
}

fn still_life() -> Scene {
    Scene { normals: false, ..Scene::still_life() }
}

#[test]
fn rounding_to_the_files_unit_is_no_motion() {
    let folder = tempfile::tempdir().unwrap();
    let (scene, unit) = (still_life(), 0.005);
    let capture = record(folder.path(), &scene, &arc(1, 48), unit);
    let mut settings = Settings::default();
    settings.spans.noise = 0.0;
    // The right answer: nothing moves, and a step of the unit is no motion whatever the tolerance, but perhaps for the
    // nearest pixels in a hundred.
    let frames: Vec<_> = (0..FRAMES).map(|frame| capture.frame(0, frame).unwrap()).collect();
    let depths = |pixel: usize| frames.iter().map(move |frame| frame.inverse_depth.as_slice()[pixel]);
    let scanned = scan(&capture, &settings, &Job::new()).unwrap();
    let inspection = inspect_frame(&capture, Some(&scanned), &settings, 2, &Job::new()).unwrap();
    let mut known: Vec<f32> =
        frames[0].inverse_depth.as_slice().iter().copied().filter(|w| *w > 0.0).collect();
    known.sort_by(f32::total_cmp);
    let nearest = known[known.len() * 99 / 100];
    let (mut flickering, mut checked) = (0, 0);
    for (pixel, class) in inspection.cameras[0].class.as_slice().iter().enumerate() {
        let (low, high) = depths(pixel).fold((f32::MAX, 0.0_f32), |(low, high), w| (low.min(w), high.max(w)));
        if low <= 0.0 || high > 0.995 * nearest {
            continue;
        }
        checked += 1;
        flickering += usize::from((high - low) / high > 0.5 * settings.spans.depth_tolerance);
        assert_eq!(*class, PixelClass::Background, "pixel {pixel}: {low} to {high}");
    }
    assert!(checked > 800 && 2 * flickering > checked, "{flickering} of {checked} flicker");
    // With the noise that is measured the nearer ones are at rest as well.
    let settings = Settings::default();
    let scanned = scan(&capture, &settings, &Job::new()).unwrap();
    let inspection = inspect_frame(&capture, Some(&scanned), &settings, 2, &Job::new()).unwrap();
    let classes = inspection.cameras[0].class.as_slice();
    let moving = classes.iter().filter(|class| matches!(class, PixelClass::Foreground | PixelClass::Lasting));
    assert_eq!(moving.count(), 0);
}

#[test]
fn coarse_depth_prunes_nearly_as_well_as_fine_depth() {
    let kept = |unit| {
        let folder = tempfile::tempdir().unwrap();
        let capture = record(folder.path(), &still_life(), &arc(3, 48), unit);
        preprocess(&capture, &Settings::default(), &Job::new()).unwrap().report
    };
    let (coarse, fine) = (kept(0.005), kept(0.0001));
    assert!(coarse.cameras[0].depth_step_relative > 40.0 * fine.cameras[0].depth_step_relative);
    let [coarse, fine] = [coarse, fine].map(|report| report.samples_kept as f64);
    assert!(coarse < 1.15 * fine && fine < 1.15 * coarse, "{coarse} against {fine}");
}

#[test]
fn a_depth_image_of_a_wall_lies_within_half_a_unit_of_the_wall() {
    let folder = tempfile::tempdir().unwrap();
    let (scene, unit) = (still_life(), 0.005);
    let cameras = arc(1, 32);
    let capture = record(folder.path(), &scene, &cameras, unit);
    let exact = scene.record(cameras.clone(), 1).frame(0, 0).unwrap();
    let frame = capture.frame(0, 0).unwrap();
    let mut on_ground = 0;
    for y in 0..32 {
        for x in 0..32 {
            let w = frame.inverse_depth[(x, y)];
            let position = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
            if w <= 0.0 {
                continue;
            }
            let apart = 1.0 / f64::from(w) - 1.0 / f64::from(exact.inverse_depth[(x, y)]);
            assert!(apart.abs() <= 1.001 * unit, "{position}: {apart} m");
            let point = cameras[0].unproject(position, 1.0 / f64::from(w));
            on_ground += usize::from(point.z.abs() < unit && DVec3::is_finite(point));
        }
    }
    assert!(on_ground > 100, "{on_ground}");
}
