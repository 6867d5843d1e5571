//! Estimated normals, by the estimator of the settings.

use glam::Vec3;
use rayon::prelude::*;

use super::depth_view::{DepthView, Estimate, NOTHING};
use super::plane_fit::FitPlanes;
use crate::grid::Grid;
use crate::settings::NormalEstimator;

/// Estimates below this confidence are not used.
pub(crate) const MIN_CONFIDENCE: f32 = 0.5;

/// The estimates at some pixels (`y * width + x`), one for each.
pub(crate) fn estimate_at(view: &DepthView<'_>, estimator: NormalEstimator, pixels: &[u32]) -> Vec<Estimate> {
    match estimator {
        NormalEstimator::Cross => pixels.iter().map(|&pixel| cross(view, pixel)).collect(),
        NormalEstimator::Plane => {
            let mut estimates = vec![NOTHING; pixels.len()];
            crate::simd::run(FitPlanes { view, pixels, estimates: &mut estimates });
            estimates
        }
    }
}

/// Estimates for every pixel of the picture.
#[must_use]
pub fn estimate_all(view: &DepthView<'_>, estimator: NormalEstimator) -> Grid<Estimate> {
    let (width, height) = (view.width as usize, view.height as usize);
    let row = |y: usize| {
        let pixels: Vec<u32> = (y * width..(y + 1) * width).map(|pixel| pixel as u32).collect();
        estimate_at(view, estimator, &pixels)
    };
    Grid::from_vec(width, height, (0..height).into_par_iter().flat_map_iter(row).collect())
}

fn cross(view: &DepthView<'_>, pixel: u32) -> Estimate {
    let (x, y) = (pixel as i32 % view.width, pixel as i32 / view.width);
    let center = view.inverse_depth[pixel as usize];
    if center <= 0.0 {
        return NOTHING;
    }
    let here = view.point(x, y, center);
    let side = |dx: i32, dy: i32| {
        let w = view.same_surface(x + dx, y + dy, center, 1)?;
        Some((view.point(x + dx, y + dy, w) - here, (w - center).abs()))
    };
    // The flatter of two one-sided differences is less likely to reach over a crease or an edge.
    let axis = |dx: i32, dy: i32| match (side(-dx, -dy), side(dx, dy)) {
        (Some((back, step_back)), Some((ahead, step_ahead))) => {
            let best = if step_back < step_ahead { -back } else { ahead };
            let agreement = (-back).normalize_or_zero().dot(ahead.normalize_or_zero());
            Some((best, agreement.max(0.0)))
        }
        (Some((back, _)), None) => Some((-back, 0.6)),
        (None, Some((ahead, _))) => Some((ahead, 0.6)),
        (None, None) => None,
    };
    let (Some((right, trust_x)), Some((down, trust_y))) = (axis(1, 0), axis(0, 1)) else {
        return NOTHING;
    };
    // Sides are as long as pixels are wide in capture units: squared twice, they leave what `f32` holds in tiny and huge
    // scenes. The power of two next to 1/z changes no bit of the result.
    let near_inverse_depth = f32::from_bits(center.to_bits() & f32::INFINITY.to_bits());
    let (right, down) = (right * near_inverse_depth, down * near_inverse_depth);
    // Right × down points away from the camera (z forward).
    let line_of_sight = if view.is_orthographic { Vec3::Z } else { here };
    let normal = toward_camera(right.cross(down).normalize_or_zero(), line_of_sight);
    Estimate { normal_in_camera: normal, confidence: trust_x.min(trust_y) }
}

fn toward_camera(normal: Vec3, point_in_camera: Vec3) -> Vec3 {
    if normal.dot(point_in_camera) > 0.0 { -normal } else { normal }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capture::{Camera, Intrinsics};
    use crate::settings::NormalSettings;
    use glam::{DVec2, DVec3};

    fn camera() -> Camera {
        Camera::look_at("c", Intrinsics::from_horizontal_angle(96, 72, 0.9), DVec3::ZERO, DVec3::Y, DVec3::Z)
    }

    /// Inverse depth of a plane `n·X = d` and of a sphere before it, in camera space, with true normals.
    fn plane_and_sphere(normal: DVec3) -> (Vec<f32>, Vec<Vec3>) {
        let k = camera().intrinsics;
        let (center, radius) = (DVec3::new(0.2, 0.1, 3.0), 0.7);
        let mut depth = Vec::new();
        let mut normals = Vec::new();
        for y in 0..k.height {
            for x in 0..k.width {
                let ray = k.ray_in_camera(DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5));
                let plane_z = normal.dot(DVec3::Z * 5.0) / normal.dot(ray);
                let (b, c) = (ray.dot(center), center.length_squared() - radius * radius);
                let discriminant = b * b - ray.length_squared() * c;
                if discriminant > 0.0 {
                    let z = (b - discriminant.sqrt()) / ray.length_squared();
                    depth.push((1.0 / z) as f32);
                    normals.push(((ray * z - center) / radius).as_vec3());
                } else {
                    depth.push((1.0 / plane_z) as f32);
                    normals.push(normal.as_vec3());
                }
            }
        }
        (depth, normals)
    }

    fn errors_degrees(estimator: NormalEstimator) -> Vec<f32> {
        let plane = DVec3::new(0.3, -0.5, -0.8).normalize_or_zero();
        let (depth, truth) = plane_and_sphere(plane);
        let view = DepthView::new(&depth, &camera(), &NormalSettings::default());
        let mut errors: Vec<f32> = estimate_all(&view, estimator)
            .as_slice()
            .iter()
            .zip(&truth)
            .filter(|(estimate, _)| estimate.confidence >= MIN_CONFIDENCE)
            .map(|(estimate, truth)| {
                estimate.normal_in_camera.dot(*truth).clamp(-1.0, 1.0).acos().to_degrees()
            })
            .collect();
        errors.sort_by(f32::total_cmp);
        errors
    }

    #[test]
    fn both_estimators_find_planes_exactly_and_a_sphere_closely_up_to_its_silhouette() {
        for estimator in [NormalEstimator::Cross, NormalEstimator::Plane] {
            let errors = errors_degrees(estimator);
            assert!(errors.len() > 96 * 72 * 9 / 10, "{estimator}: trusted {}", errors.len());
            assert!(errors[errors.len() / 2] < 0.1, "{estimator}: median {}", errors[errors.len() / 2]);
            let p95 = errors[errors.len() * 95 / 100];
            assert!(p95 < 4.0, "{estimator}: 95th percentile {p95}");
        }
    }

    #[test]
    fn the_size_of_the_unit_changes_no_normal() {
        let (depth, _) = plane_and_sphere(DVec3::new(0.3, -0.5, -0.8).normalize_or_zero());
        let (camera, settings) = (camera(), NormalSettings::default());
        for estimator in [NormalEstimator::Cross, NormalEstimator::Plane] {
            let expected = estimate_all(&DepthView::new(&depth, &camera, &settings), estimator);
            for exponent in [-44, -30, 30, 44] {
                let depth: Vec<f32> = depth.iter().map(|w| w * 2_f32.powi(exponent)).collect();
                let found = estimate_all(&DepthView::new(&depth, &camera, &settings), estimator);
                assert!(found.as_slice() == expected.as_slice(), "{estimator}: unit of 2^{exponent}");
            }
        }
    }

    #[test]
    fn noise_disturbs_the_plane_fit_less_than_the_cross_product() {
        let plane = DVec3::new(0.3, -0.5, -0.8).normalize_or_zero();
        let (mut depth, truth) = plane_and_sphere(plane);
        let mut state = 7_u32;
        for w in &mut depth {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            *w *= 1.0 + ((state >> 8) as f32 / (1 << 24) as f32 - 0.5) * 2e-3;
        }
        let view_camera = camera();
        let view = DepthView::new(&depth, &view_camera, &NormalSettings::default());
        let mean = |estimator| {
            let grid = estimate_all(&view, estimator);
            let angles = grid
                .as_slice()
                .iter()
                .zip(&truth)
                .filter(|(estimate, _)| estimate.normal_in_camera != Vec3::ZERO);
            let angles: Vec<f32> =
                angles.map(|(e, t)| e.normal_in_camera.dot(*t).clamp(-1.0, 1.0).acos()).collect();
            angles.iter().sum::<f32>() / angles.len() as f32
        };
        assert!(mean(NormalEstimator::Plane) < 0.5 * mean(NormalEstimator::Cross));
    }

    #[test]
    fn a_lonely_pixel_and_the_sky_have_no_normal() {
        let camera = camera();
        let mut depth = vec![0.0_f32; camera.intrinsics.pixel_count()];
        depth[96 * 10 + 10] = 0.5;
        let view = DepthView::new(&depth, &camera, &NormalSettings::default());
        for estimator in [NormalEstimator::Cross, NormalEstimator::Plane] {
            let estimates = estimate_at(&view, estimator, &[96 * 10 + 10, 96 * 50 + 50]);
            assert_eq!(estimates, [NOTHING; 2]);
        }
    }
}
