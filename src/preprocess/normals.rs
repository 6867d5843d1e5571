//! Surface normals (the paper, §3.2): given, or estimated from depth.
//!
//! Purpose: the sampling rate needs the angle at which a camera sees a surface. Estimates never reach across a
//! silhouette, and each carries a confidence; a sample whose normal is not trusted counts as seen at grazing incidence and
//! loses to every one whose normal is known. Neighbors of shorter spans are decided later and take no part, so that beside
//! what moves there may be too few to trust.
//!
//! Source: the paper leaves the estimator open. *Cross* is the usual cross product of neighboring differences, one-sided
//! toward the flatter neighbor. *Plane* uses that a plane `n·X = d` seen by a pinhole camera is linear in the image in
//! **inverse** depth, `1/z = (nx u + ny v + nz) / d` with `u, v` on the normalized image plane, so that a linear
//! least-squares fit over a window is exact on planes at any slant. What differs: the window is cut at depth steps.

use glam::Vec3;
use rayon::prelude::*;

use super::normal_lanes::FitPlanes;
use crate::capture::Camera;
use crate::grid::Grid;
use crate::settings::{NormalEstimator, NormalSettings};
use crate::simd;

/// Estimates below this confidence are not used.
pub const MIN_CONFIDENCE: f32 = 0.5;

/// One estimated normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Unit, in camera space, toward the camera; zero where nothing can be said.
    pub normal_in_camera: Vec3,
    /// 0 (a guess) to 1 (all neighbors agree).
    pub confidence: f32,
}

const NOTHING: Estimate = Estimate { normal_in_camera: Vec3::ZERO, confidence: 0.0 };

/// Depth seen by a pinhole camera, with what an estimator needs to know about it.
pub struct DepthView<'a> {
    pub(super) inverse_depth: &'a [f32],
    pub(super) width: i32,
    pub(super) height: i32,
    pub(super) focal: [f32; 2],
    pub(super) center: [f32; 2],
    /// Largest step in depth to a direct neighbor on the same surface, as a share of the depth.
    pub(super) edge_relative: f32,
}

impl<'a> DepthView<'a> {
    /// Inverse depth of `camera`, row-major, with the edge threshold of `settings`.
    #[must_use]
    pub fn new(inverse_depth: &'a [f32], camera: &Camera, settings: &NormalSettings) -> Self {
        let k = camera.intrinsics;
        let focal = [k.fx as f32, k.fy as f32];
        Self {
            inverse_depth,
            width: k.width as i32,
            height: k.height as i32,
            focal,
            center: [k.cx as f32, k.cy as f32],
            edge_relative: settings.edge / (focal[0] * focal[1]).sqrt(),
        }
    }

    /// Inverse depth at `(x, y)` if it belongs to the same surface as `center` (an inverse depth above 0), `reach`
    /// pixels away.
    fn same_surface(&self, x: i32, y: i32, center: f32, reach: i32) -> Option<f32> {
        if x < 0 || y < 0 || x >= self.width || y >= self.height {
            return None;
        }
        let w = self.inverse_depth[(y * self.width + x) as usize];
        // |z − z₀| / z₀ = |w₀ − w| / w
        (w > 0.0 && (w - center).abs() <= w.max(center) * self.edge_relative * reach as f32).then_some(w)
    }

    fn point(&self, x: i32, y: i32, w: f32) -> Vec3 {
        Vec3::new(
            (x as f32 + 0.5 - self.center[0]) / self.focal[0],
            (y as f32 + 0.5 - self.center[1]) / self.focal[1],
            1.0,
        ) / w
    }

    /// The estimate at pixel `(x, y)`.
    #[must_use]
    pub fn estimate(&self, estimator: NormalEstimator, x: usize, y: usize) -> Estimate {
        let (x, y) = (x as i32, y as i32);
        let center = self.inverse_depth[(y * self.width + x) as usize];
        if center <= 0.0 {
            return NOTHING;
        }
        match estimator {
            NormalEstimator::Cross => self.cross(x, y, center),
            NormalEstimator::Plane => self.plane(x, y, center),
        }
    }

    /// The estimates at some pixels (`y * width + x`), one for each.
    #[must_use]
    pub fn estimate_at(&self, estimator: NormalEstimator, pixels: &[u32]) -> Vec<Estimate> {
        let width = self.width.max(1) as usize;
        match estimator {
            NormalEstimator::Cross => {
                let at =
                    |&pixel: &u32| self.estimate(estimator, pixel as usize % width, pixel as usize / width);
                pixels.iter().map(at).collect()
            }
            NormalEstimator::Plane => {
                let mut estimates = vec![NOTHING; pixels.len()];
                simd::run(FitPlanes { view: self, pixels, estimates: &mut estimates });
                estimates
            }
        }
    }

    fn cross(&self, x: i32, y: i32, center: f32) -> Estimate {
        let here = self.point(x, y, center);
        let side = |dx: i32, dy: i32| {
            let w = self.same_surface(x + dx, y + dy, center, 1)?;
            Some((self.point(x + dx, y + dy, w) - here, (w - center).abs()))
        };
        // Of the two one-sided differences the flatter one is less likely to reach over a crease or an edge.
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
        let normal = toward_camera(right.cross(down).normalize_or_zero(), here);
        Estimate { normal_in_camera: normal, confidence: trust_x.min(trust_y) }
    }

    fn plane(&self, x: i32, y: i32, center: f32) -> Estimate {
        const RADIUS: i32 = 2;
        let mut sums = PlaneSums::default();
        for dy in -RADIUS..=RADIUS {
            for dx in -RADIUS..=RADIUS {
                let reach = dx.abs().max(dy.abs()).max(1);
                if let Some(w) = self.same_surface(x + dx, y + dy, center, reach) {
                    sums.add(dx as f32, dy as f32, w / center - 1.0);
                }
            }
        }
        let Some((per_column, per_row, offset, residual)) = sums.solve() else {
            return NOTHING;
        };
        // w/center = 1 + offset + per_column·(column − x) + per_row·(row − y), column = cx + fx·u − 0.5
        let (u0, v0) = (x as f32 + 0.5 - self.center[0], y as f32 + 0.5 - self.center[1]);
        let normal = -Vec3::new(
            per_column * self.focal[0],
            per_row * self.focal[1],
            1.0 + offset - per_column * u0 - per_row * v0,
        );
        let normal = toward_camera(normal.normalize_or_zero(), self.point(x, y, center));
        let filled = sums.count / 25.0;
        // A residual of half a pixel footprint halves the trust.
        let flatness = 1.0 / (1.0 + residual * 2.0 * (self.focal[0] * self.focal[1]).sqrt());
        Estimate { normal_in_camera: normal, confidence: (filled * 1.6).min(1.0) * flatness }
    }

    /// Estimates for every pixel of the picture.
    #[must_use]
    pub fn estimate_all(&self, estimator: NormalEstimator) -> Grid<Estimate> {
        let (width, height) = (self.width as usize, self.height as usize);
        let values = (0..height)
            .into_par_iter()
            .flat_map_iter(|y| (0..width).map(move |x| self.estimate(estimator, x, y)))
            .collect();
        Grid::from_vec(width, height, values)
    }
}

fn toward_camera(normal: Vec3, point_in_camera: Vec3) -> Vec3 {
    if normal.dot(point_in_camera) > 0.0 { -normal } else { normal }
}

/// Normal equations of `value ≈ a·x + b·y + c`.
#[derive(Default)]
struct PlaneSums {
    count: f32,
    x: f32,
    y: f32,
    xx: f32,
    xy: f32,
    yy: f32,
    v: f32,
    xv: f32,
    yv: f32,
    vv: f32,
}

impl PlaneSums {
    fn add(&mut self, x: f32, y: f32, value: f32) {
        self.count += 1.0;
        self.x += x;
        self.y += y;
        self.xx += x * x;
        self.xy += x * y;
        self.yy += y * y;
        self.v += value;
        self.xv += x * value;
        self.yv += y * value;
        self.vv += value * value;
    }

    /// `(a, b, c, root mean square residual)`, or `None` where the pixels lie on one line.
    fn solve(&self) -> Option<(f32, f32, f32, f32)> {
        let n = self.count;
        if n < 3.0 {
            return None;
        }
        let (mx, my, mv) = (self.x / n, self.y / n, self.v / n);
        let (xx, xy, yy) = (self.xx - n * mx * mx, self.xy - n * mx * my, self.yy - n * my * my);
        let (xv, yv) = (self.xv - n * mx * mv, self.yv - n * my * mv);
        let determinant = xx * yy - xy * xy;
        // Coordinates are small integers: anything below one is a line, whatever the rounding.
        if determinant < 0.5 {
            return None;
        }
        let a = (xv * yy - yv * xy) / determinant;
        let b = (yv * xx - xv * xy) / determinant;
        let c = mv - a * mx - b * my;
        let squares = self.vv - n * mv * mv - a * xv - b * yv;
        Some((a, b, c, (squares.max(0.0) / n).sqrt()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capture::Intrinsics;
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
        let mut errors: Vec<f32> = view
            .estimate_all(estimator)
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
            let expected = DepthView::new(&depth, &camera, &settings).estimate_all(estimator);
            for exponent in [-44, -30, 30, 44] {
                let depth: Vec<f32> = depth.iter().map(|w| w * 2_f32.powi(exponent)).collect();
                let found = DepthView::new(&depth, &camera, &settings).estimate_all(estimator);
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
            let grid = view.estimate_all(estimator);
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
    fn planes_fitted_sixteen_at_a_time_are_those_fitted_one_by_one() {
        let (mut depth, _) = plane_and_sphere(DVec3::new(0.3, -0.5, -0.8).normalize_or_zero());
        for (i, w) in depth.iter_mut().enumerate() {
            match i % 31 {
                0 => *w = -1.0,
                1 => *w = 0.0,
                _ => *w *= 1.0 + 1e-4 * ((i * 7919) % 13) as f32,
            }
        }
        let camera = camera();
        let view = DepthView::new(&depth, &camera, &NormalSettings::default());
        let pixels: Vec<u32> = (0..96 * 72).filter(|i| i % 3 != 1).collect();
        let together = view.estimate_at(NormalEstimator::Plane, &pixels);
        for (&pixel, found) in pixels.iter().zip(together) {
            let alone = view.estimate(NormalEstimator::Plane, pixel as usize % 96, pixel as usize / 96);
            assert!((found.confidence - alone.confidence).abs() < 1e-5, "{found:?} {alone:?}");
            assert!(found.normal_in_camera.distance(alone.normal_in_camera) < 1e-5, "{found:?} {alone:?}");
        }
    }

    #[test]
    fn a_lonely_pixel_and_the_sky_have_no_normal() {
        let camera = camera();
        let mut depth = vec![0.0_f32; camera.intrinsics.pixel_count()];
        depth[96 * 10 + 10] = 0.5;
        let view = DepthView::new(&depth, &camera, &NormalSettings::default());
        for estimator in [NormalEstimator::Cross, NormalEstimator::Plane] {
            assert_eq!(view.estimate(estimator, 10, 10), NOTHING);
            assert_eq!(view.estimate(estimator, 50, 50), NOTHING);
        }
    }
}
