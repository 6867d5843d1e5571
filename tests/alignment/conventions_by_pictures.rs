//! Where depth cannot tell, pictures tell the unit of depth and the lens: of cameras that stand close together.

use std::sync::Arc;

use glam::DVec3;
use overlook_engine::alignment::align;
use overlook_engine::capture::conventions::{DepthMeasure, Evidence, Finding, PoseConvention, check};
use overlook_engine::capture::{Camera, Capture, Frame, Intrinsics};
use overlook_engine::job::Job;
use overlook_engine::settings::AlignSettings;

use crate::conventions::{Export, corner, read_as_nerfstudio};

/// Six cameras some centimeters apart that look this way and that.
fn close_together() -> Vec<Camera> {
    let intrinsics = Intrinsics::from_horizontal_angle(240, 180, 1.0);
    let camera = |index: usize| {
        let step = index as f64;
        let eye = DVec3::new(-0.3 + 0.06 * step, -3.2, 1.5 + 0.03 * (step * 2.0).sin());
        let target = DVec3::new(0.5 * (step * 1.7).sin(), 0.3, 0.4 + 0.3 * (step * 1.1).cos());
        Camera::look_at(format!("c{index}"), intrinsics, eye, target, DVec3::new(0.05 * step, 0.0, 1.0))
    };
    (0..6).map(camera).collect()
}

fn traced(cameras: &[Camera], depth_noise: f32) -> Vec<Frame> {
    let scene = corner(depth_noise);
    cameras.iter().enumerate().map(|(seed, camera)| scene.trace(camera, 0, seed)).collect()
}

fn recorded(depth_noise: f32) -> (Vec<Camera>, Arc<Vec<Frame>>) {
    let cameras = close_together();
    let frames = traced(&cameras, depth_noise);
    (cameras, Arc::new(frames))
}

/// The cameras with focal lengths times `factor`.
fn with_focal(cameras: &[Camera], factor: f64) -> Vec<Camera> {
    let mut cameras = cameras.to_vec();
    for camera in &mut cameras {
        camera.intrinsics.fx *= factor;
        camera.intrinsics.fy *= factor;
    }
    cameras
}

fn as_meant(cameras: &[Camera], frames: &Arc<Vec<Frame>>, unit: f64) -> Capture {
    let export = Export { pose: PoseConvention::default(), measure: DepthMeasure::PlanarZ, unit };
    read_as_nerfstudio(cameras, frames, export)
}

fn found(cameras: &[Camera], frames: &Arc<Vec<Frame>>, unit: f64) -> Finding {
    check(&as_meant(cameras, frames, unit)).unwrap()
}

/// The value of a key that a finding says to write.
fn value(finding: &Finding, key: &str) -> f64 {
    let keys = &finding.alternative().unwrap_or_else(|| panic!("{}", finding.sentence())).keys;
    let (_, value) = keys.iter().find(|(name, _)| name == key).unwrap_or_else(|| panic!("{keys:?}"));
    value.parse().unwrap()
}

fn is_by_pictures(finding: &Finding) -> bool {
    matches!(finding.alternative().unwrap().evidence, Evidence::Pictures { as_read } if as_read < 0.7)
}

#[test]
fn a_capture_that_is_read_as_meant_is_accused_of_nothing() {
    for noise in [0.0, 0.01] {
        let (cameras, frames) = recorded(noise);
        let finding = found(&cameras, &frames, 1.0);
        assert_eq!(finding.warning(), None);
    }
}

#[test]
fn a_unit_of_depth_that_depth_cannot_tell_is_told_by_pictures() {
    for noise in [0.0, 0.01] {
        let (cameras, frames) = recorded(noise);
        for unit in [0.1, 1e-3] {
            // The file's unit, where it is read as one world unit.
            let finding = found(&cameras, &frames, unit);
            let said = value(&finding, "depth_unit_scale_factor");
            assert!((said / unit - 1.0).abs() < 0.3, "{unit}: {}", finding.sentence());
        }
    }
}

#[test]
fn a_focal_length_and_a_principal_point_that_are_none_of_the_lens_are_told_by_pictures() {
    let (cameras, frames) = recorded(0.01);
    let focal = cameras[0].intrinsics.fx;
    for factor in [0.6, 1.3, 2.0] {
        let finding = found(&with_focal(&cameras, factor), &frames, 1.0);
        let said = value(&finding, "fl_x");
        assert!(is_by_pictures(&finding) && (said / focal - 1.0).abs() < 0.05, "{}", finding.sentence());
        assert_eq!(said, value(&finding, "fl_y"));
    }
    let mut wrong = cameras.clone();
    for camera in &mut wrong {
        (camera.intrinsics.cx, camera.intrinsics.cy) = (60.0, 45.0);
    }
    let finding = found(&wrong, &frames, 1.0);
    let (x, y) = (value(&finding, "cx"), value(&finding, "cy"));
    assert!((x - 120.0).abs() < 20.0 && (y - 90.0).abs() < 20.0, "{}", finding.sentence());
}

#[test]
fn a_lens_that_differs_from_camera_to_camera_is_told_of_without_a_key() {
    let (mut cameras, frames) = recorded(0.0);
    for (index, camera) in cameras.iter_mut().enumerate() {
        let focal = (1.4 + 0.001 * index as f64) * camera.intrinsics.fx;
        (camera.intrinsics.fx, camera.intrinsics.fy) = (focal, focal);
    }
    let finding = found(&cameras, &frames, 1.0);
    let other = finding.alternative().unwrap();
    assert!(other.keys.is_empty() && !other.can_be_written(&finding.claimed));
    assert!(finding.warning().unwrap().contains("focal lengths are 0.7"), "{}", finding.sentence());
}

#[test]
fn a_color_lens_other_than_that_of_depth_is_found_whether_pictures_doubt_the_lens_or_exact_depth_holds_it() {
    for noise in [0.01, 0.0] {
        let (cameras, depth) = recorded(noise);
        let color = traced(&with_focal(&cameras, 0.88), noise);
        let seen =
            depth.iter().zip(color).map(|(depth, Frame { color, .. })| Frame { color, ..depth.clone() });
        let capture = as_meant(&cameras, &Arc::new(seen.collect()), 1.0);
        let finding = check(&capture).unwrap();
        // Exact depth shows that its own lens is right.
        assert_eq!(finding.alternative().is_some(), noise > 0.0, "{}", finding.sentence());
        let found = align(&capture, &AlignSettings::default(), &Job::new()).unwrap().alignment.unwrap();
        let focals: Vec<f64> = found.lenses.iter().map(|lens| lens.color.fx / lens.claimed.fx).collect();
        assert!(focals.len() == 1 && (focals[0] - 0.88).abs() < 0.01, "{:?}", found.sentences());
    }
}
