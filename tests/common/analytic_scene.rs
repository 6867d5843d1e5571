//! A scene of three planes and a ball whose surface is known exactly, seen by a camera that walks along.

use glam::{DAffine3, DVec2, DVec3};
use overlook_engine::capture::{Camera, Capture, Intrinsics};

const BALL: (DVec3, f64) = (DVec3::new(0.2, 2.2, 0.3), 0.5);

/// How far the nearest surface is from a point, and the next one: the wall y = 3, the floor z = −1, the side x = 1.5, the ball.
fn distances(point: DVec3) -> [f64; 2] {
    let ball = point.distance(BALL.0) - BALL.1;
    let mut all = [3.0 - point.y, point.z + 1.0, 1.5 - point.x, ball].map(f64::abs);
    all.sort_by(f64::total_cmp);
    [all[0], all[1]]
}

/// How far a straight line between two pixels of this width, as they lie on the ball, runs from it; 0 on the planes.
fn sagitta(point: DVec3, camera: &Camera, width: f64) -> f64 {
    let outward = point - BALL.0;
    if (outward.length() - BALL.1).abs() > 0.1 * BALL.1 {
        return 0.0;
    }
    let sight = camera.position_in_world() - point;
    let cosine = (outward.dot(sight) / (outward.length() * sight.length())).max(0.1);
    (width / cosine).powi(2) / (8.0 * BALL.1)
}

/// Planar z along the ray of the camera through a position in its picture.
pub(crate) fn depth(camera: &Camera, pixel: DVec2) -> f64 {
    let eye = camera.position_in_world();
    let ray = camera.unproject(pixel, 1.0) - eye;
    let to = |gap: f64, speed: f64| if speed > 1e-9 { gap / speed } else { f64::INFINITY };
    let mut nearest = to(3.0 - eye.y, ray.y).min(to(eye.z + 1.0, -ray.z)).min(to(1.5 - eye.x, ray.x));
    let (a, b) = (ray.length_squared(), ray.dot(eye - BALL.0));
    let c = (eye - BALL.0).length_squared() - BALL.1 * BALL.1;
    let root = b * b - a * c;
    if root > 0.0 {
        nearest = nearest.min((-b - root.sqrt()) / a);
    }
    nearest
}

/// Planar z of every pixel, row by row.
pub(crate) fn depths(camera: &Camera) -> Vec<f64> {
    let (width, height) = camera.intrinsics.size();
    let at = |i: usize| DVec2::new((i % width) as f64 + 0.5, (i / width) as f64 + 0.5);
    (0..width * height).map(|i| depth(camera, at(i))).collect()
}

/// The unit normals of every pixel's surface in world space, toward the camera, row by row.
pub(crate) fn normals(camera: &Camera) -> Vec<DVec3> {
    let (width, height) = camera.intrinsics.size();
    let normal = |i: usize| {
        let pixel = DVec2::new((i % width) as f64 + 0.5, (i / width) as f64 + 0.5);
        let point = camera.unproject(pixel, depth(camera, pixel));
        let outward = point - BALL.0;
        let planes =
            [(3.0 - point.y, DVec3::NEG_Y), (point.z + 1.0, DVec3::Z), (1.5 - point.x, DVec3::NEG_X)];
        let ball = (outward.length() - BALL.1, outward.normalize_or_zero());
        let all = planes.into_iter().chain([ball]);
        all.min_by(|a, b| a.0.abs().total_cmp(&b.0.abs())).unwrap().1
    };
    (0..width * height).map(normal).collect()
}

/// 8-bit color of every pixel: a pattern that follows the surface.
pub(crate) fn colors(camera: &Camera) -> Vec<u8> {
    let (width, height) = camera.intrinsics.size();
    let color = |i: usize| {
        let pixel = DVec2::new((i % width) as f64 + 0.5, (i / width) as f64 + 0.5);
        let point = camera.unproject(pixel, depth(camera, pixel));
        (point * 3.0).to_array().map(|value| (127.0 + 90.0 * value.sin()) as u8)
    };
    (0..width * height).flat_map(color).collect()
}

/// The camera at step `step` of its walk.
pub(crate) fn camera(step: usize, intrinsics: Intrinsics) -> Camera {
    let s = step as f64;
    let (eye, target) = (DVec3::new(-0.3 + 0.25 * s, -0.5 + 0.05 * s, 0.1 * s), DVec3::new(0.1, 2.5, 0.0));
    Camera::look_at(format!("step{step}"), intrinsics, eye, target, DVec3::Z)
}

/// The pose row by row, camera to world, x right, y down, z forward.
pub(crate) fn rows(pose: &DAffine3) -> Vec<f64> {
    let m = pose.matrix3;
    let row = |i: usize| [m.x_axis[i], m.y_axis[i], m.z_axis[i], pose.translation[i]];
    [row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]].concat()
}

/// Checks that a capture shows the scene: samples lie on its surfaces within a tenth of a footprint, so that those of any two views
/// meet, and nearly every pixel has one. Pixels at silhouettes, where depth of other pixels has to stay empty, are the rest. Where two
/// surfaces meet within a pixel of depth, which is `depth_pixel` pixels of color wide, depth between the pixels cuts the corner, and on
/// the ball it follows the chord.
pub(crate) fn check(capture: &Capture, views: usize, depth_pixel: f64) {
    check_elsewhere(capture, views, depth_pixel, &DAffine3::IDENTITY);
}

/// The same of a capture in another world than the scene's: turned, mirrored, shifted, and scaled alike along all axes.
pub(crate) fn check_elsewhere(
    capture: &Capture,
    views: usize,
    depth_pixel: f64,
    scene_from_world: &DAffine3,
) {
    let scale = scene_from_world.matrix3.determinant().abs().cbrt();
    assert_eq!((capture.cameras.len(), capture.frame_count()), (views, 1));
    for (index, camera) in capture.cameras.iter().enumerate() {
        let frame = capture.frame(index, 0).unwrap();
        let (width, height) = camera.intrinsics.size();
        let (mut on, mut off) = (0, 0);
        for y in 0..height {
            for x in 0..width {
                let inverse = f64::from(frame.inverse_depth[(x, y)]);
                if inverse <= 0.0 {
                    continue;
                }
                let point = camera.unproject(DVec2::new(x as f64 + 0.5, y as f64 + 0.5), 1.0 / inverse);
                let point = scene_from_world.transform_point3(point);
                let footprint = scale / inverse / camera.intrinsics.fx;
                let [nearest, next] = distances(point);
                let is_at_crease = depth_pixel > 1.0 && next < 1.5 * depth_pixel * footprint;
                let chord =
                    if depth_pixel > 1.0 { sagitta(point, camera, depth_pixel * footprint) } else { 0.0 };
                if nearest < 0.1 * footprint + chord || is_at_crease { on += 1 } else { off += 1 }
            }
        }
        assert!(
            on * 100 > 88 * width * height,
            "{}: {on} on the surface and {off} off it of {}",
            camera.name,
            width * height
        );
        // Silhouettes are as many pixels wide as a pixel of depth.
        let most = 0.03 * depth_pixel * (width * height) as f64;
        assert!(f64::from(off) < most, "{}: {off} off the surface", camera.name);
    }
}
