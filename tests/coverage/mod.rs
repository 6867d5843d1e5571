//! The coverage guarantee, checked from cameras and frames alone.

use glam::{DVec2, DVec3};
use overlook::capture::Capture;
use overlook::preprocess::inspect::FrameInspection;
use overlook::preprocess::pruning::Rule;
use overlook::settings::Settings;

use super::scene::Scene;

/// Checks, in double precision and from cameras and frames alone, that every dropped sample has a kept witness that shows
/// its surface point.
pub(crate) fn assert_covered(
    scene: &Scene,
    capture: &Capture,
    inspection: &FrameInspection,
    settings: &Settings,
) {
    let exact = Scene { normals: true, ..scene.clone() };
    let true_normals: Vec<_> = capture
        .cameras
        .iter()
        .map(|camera| exact.trace(camera, inspection.frame, 0).normal_in_world.unwrap())
        .collect();
    for (index, seen) in inspection.cameras.iter().enumerate() {
        let camera = &capture.cameras[index];
        for (pixel, verdict) in seen.verdict.as_slice().iter().enumerate() {
            if verdict.is_kept() || verdict.rule == Rule::NoSample {
                continue;
            }
            if verdict.rule == Rule::MixedDropped {
                continue;
            }
            let witness = &inspection.cameras[verdict.witness_camera as usize];
            let witness_verdict = witness.verdict.as_slice()[verdict.witness_pixel as usize];
            assert!(witness_verdict.is_kept(), "dropped for {verdict:?}, which is {witness_verdict:?}");
            assert_ne!(verdict.witness_camera as usize, index);
            let (width, _) = seen.verdict.size();
            let center = DVec2::new((pixel % width) as f64 + 0.5, (pixel / width) as f64 + 0.5);
            let inverse_depth = f64::from(seen.frame.inverse_depth.as_slice()[pixel]);
            let witness_camera = &capture.cameras[verdict.witness_camera as usize];
            let k = witness_camera.intrinsics;
            let at = (f64::from(verdict.witness_pixel % k.width), f64::from(verdict.witness_pixel / k.width));
            if inverse_depth == 0.0 {
                let w = witness.frame.inverse_depth.as_slice()[verdict.witness_pixel as usize];
                assert_eq!(w, 0.0);
                let ray = camera.world_from_camera.matrix3 * camera.intrinsics.ray_in_camera(center);
                // Of what is at infinity, the direction is all there is.
                let (found, _) = witness_camera
                    .project(witness_camera.position_in_world() + ray)
                    .expect("the witness looks that way");
                assert!(
                    (found.x - at.0 - 0.5).abs() < 0.51 && (found.y - at.1 - 0.5).abs() < 0.51,
                    "{found} is not in {at:?} of the sky"
                );
                continue;
            }
            let point = camera.unproject(center, 1.0 / inverse_depth);
            let (found, z) = witness_camera.project(point).expect("the witness has the point before it");
            // A sample has the mean depth of its span, and positions are carried in single precision.
            let reach = |axis: usize| {
                let moved = [0.997, 1.003].map(|share| {
                    let moved = witness_camera.project(camera.unproject(center, share / inverse_depth));
                    moved.map_or(f64::INFINITY, |(moved, _)| (moved[axis] - found[axis]).abs())
                });
                0.51 + moved[0].max(moved[1])
            };
            assert!(
                (found.x - at.0 - 0.5).abs() < reach(0) && (found.y - at.1 - 0.5).abs() < reach(1),
                "{found} is not in {at:?}"
            );
            let seen_z =
                1.0 / f64::from(witness.frame.inverse_depth.as_slice()[verdict.witness_pixel as usize]);
            let seen = witness_camera.unproject(DVec2::new(at.0 + 0.5, at.1 + 0.5), seen_z);
            let normal =
                true_normals[verdict.witness_camera as usize].as_slice()[verdict.witness_pixel as usize];
            let distance = DVec3::from(normal.map(f64::from)).dot(point - seen).abs();
            let footprint = (seen_z / (k.fx * k.fy).sqrt()).max(1.0 / inverse_depth / camera.intrinsics.fx);
            // Rounding, and depth as half floats.
            let rounding = 2e-3 * (z + seen_z);
            // Estimated normals are off by some degrees, and a pixel without any is compared along its depth.
            let estimated = if scene.normals { 0.0 } else { footprint + 0.8 * (point - seen).length() };
            let slack = f64::from(settings.pruning.depth_tolerance) * footprint + rounding + estimated;
            assert!(distance < slack, "the point lies {distance} off the witness's surface, {slack} at most");
        }
    }
}
