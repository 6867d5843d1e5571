//! The plane fit of [`normals`](super) for sixteen pixels at a time, wherever they lie.

use super::depth_view::{DepthView, Estimate, NOTHING};
use crate::simd::{LANES, VectorLoop};
use glam::Vec3;

/// Reach of the window, pixels.
const RADIUS: i32 = 2;

type FitLanes = [f32; LANES];

/// Fits planes at some pixels (`y * width + x`), one estimate each; those without finite depth are left as they are.
pub(crate) struct FitPlanes<'a> {
    pub(crate) view: &'a DepthView<'a>,
    pub(crate) pixels: &'a [u32],
    pub(crate) estimates: &'a mut [Estimate],
}

/// Normal equations of `value ≈ a·x + b·y + c`, one plane per lane.
#[derive(Default)]
struct Sums {
    count: FitLanes,
    x: FitLanes,
    y: FitLanes,
    xx: FitLanes,
    xy: FitLanes,
    yy: FitLanes,
    v: FitLanes,
    xv: FitLanes,
    yv: FitLanes,
    vv: FitLanes,
}

impl VectorLoop for FitPlanes<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { view, pixels, estimates } = self;
        if view.is_orthographic {
            for (&pixel, estimate) in pixels.iter().zip(estimates) {
                *estimate = fit_orthographic(view, pixel);
            }
            return;
        }
        for (pixels, estimates) in pixels.chunks(LANES).zip(estimates.chunks_mut(LANES)) {
            fit(view, pixels, estimates);
        }
    }
}

#[inline(always)]
fn fit(view: &DepthView<'_>, pixels: &[u32], estimates: &mut [Estimate]) {
    let (width, height) = (view.width, view.height);
    let (mut columns, mut rows, mut center) = ([0_i32; LANES], [0_i32; LANES], [-1.0_f32; LANES]);
    let mut is_inside = true;
    for (lane, &pixel) in pixels.iter().enumerate() {
        let (x, y) = (pixel as i32 % width, pixel as i32 / width);
        (columns[lane], rows[lane]) = (x, y);
        center[lane] = view.inverse_depth[pixel as usize];
        is_inside &= x >= RADIUS && y >= RADIUS && x + RADIUS < width && y + RADIUS < height;
    }
    let mut sums = Sums::default();
    for dy in -RADIUS..=RADIUS {
        for dx in -RADIUS..=RADIUS {
            let mut w = [-1.0_f32; LANES];
            for (lane, &pixel) in pixels.iter().enumerate() {
                let (x, y) = (columns[lane] + dx, rows[lane] + dy);
                if is_inside || (x >= 0 && y >= 0 && x < width && y < height) {
                    w[lane] = view.inverse_depth[(pixel as i32 + dy * width + dx) as usize];
                }
            }
            let reach = dx.abs().max(dy.abs()).max(1) as f32;
            sums.add(dx as f32, dy as f32, &w, &center, view.edge_relative, reach);
        }
    }
    let (normals, confidence) = sums.solve(view, &columns, &rows, &center);
    for (lane, estimate) in estimates.iter_mut().enumerate() {
        if center[lane] > 0.0 {
            *estimate = Estimate {
                normal_in_camera: Vec3::new(normals[0][lane], normals[1][lane], normals[2][lane]),
                confidence: confidence[lane],
            };
        }
    }
}

/// The plane through what an orthographic camera sees around a pixel: depth itself is linear over it, not its inverse.
#[cold]
#[inline(never)]
fn fit_orthographic(view: &DepthView<'_>, pixel: u32) -> Estimate {
    let (column, row) = (pixel as i32 % view.width, pixel as i32 / view.width);
    let center = view.inverse_depth[pixel as usize];
    if center <= 0.0 {
        return NOTHING;
    }
    let [fx, fy] = view.focal;
    let per_footprint = (fx * fy).sqrt();
    let mut points = [[0.0_f32; 3]; 25];
    let mut count = 0;
    for (dy, dx) in (-RADIUS..=RADIUS).flat_map(|dy| (-RADIUS..=RADIUS).map(move |dx| (dy, dx))) {
        if let Some(w) = view.same_surface(column + dx, row + dy, center, dx.abs().max(dy.abs()).max(1)) {
            points[count] = [dx as f32, dy as f32, (w.recip() - center.recip()) * per_footprint];
            count += 1;
        }
    }
    let points = &points[..count];
    let n = count as f32;
    let mean = |axis: usize| points.iter().map(|point| point[axis]).sum::<f32>() / n;
    let means = [mean(0), mean(1), mean(2)];
    let sum = |a: usize, b: usize| {
        points.iter().map(|point| (point[a] - means[a]) * (point[b] - means[b])).sum::<f32>()
    };
    let (xx, xy, yy, xz, yz) = (sum(0, 0), sum(0, 1), sum(1, 1), sum(0, 2), sum(1, 2));
    let determinant = xx * yy - xy * xy;
    if count < 3 || determinant < 0.5 {
        return NOTHING;
    }
    // Footprints of depth a column and a row.
    let (a, b) = ((xz * yy - yz * xy) / determinant, (yz * xx - xz * xy) / determinant);
    let residual = ((sum(2, 2) - a * xz - b * yz).max(0.0) / n).sqrt();
    Estimate {
        normal_in_camera: Vec3::new(a * fx / per_footprint, b * fy / per_footprint, -1.0).normalize_or_zero(),
        confidence: (n / 25.0 * 1.6).min(1.0) / (1.0 + 2.0 * residual),
    }
}

impl Sums {
    /// Adds the neighbor at `(x, y)` where it is on the surface of the center.
    #[inline(always)]
    fn add(&mut self, x: f32, y: f32, w: &FitLanes, center: &FitLanes, edge_relative: f32, reach: f32) {
        for lane in 0..LANES {
            let (w, center) = (w[lane], center[lane]);
            let larger = if w > center { w } else { center };
            let same = (w > 0.0) & ((w - center).abs() <= larger * edge_relative * reach);
            let one = if same { 1.0 } else { 0.0 };
            let value = if same { w / center - 1.0 } else { 0.0 };
            self.count[lane] += one;
            self.x[lane] += x * one;
            self.y[lane] += y * one;
            self.xx[lane] += x * x * one;
            self.xy[lane] += x * y * one;
            self.yy[lane] += y * y * one;
            self.v[lane] += value;
            self.xv[lane] += x * value;
            self.yv[lane] += y * value;
            self.vv[lane] += value * value;
        }
    }

    /// Unit normals in camera space, toward the camera, by axis, and confidences; zero where there is no plane.
    #[inline(always)]
    fn solve(
        &self,
        view: &DepthView<'_>,
        columns: &[i32; LANES],
        rows: &[i32; LANES],
        center: &FitLanes,
    ) -> ([FitLanes; 3], FitLanes) {
        let (focal, middle) = (view.focal, view.center);
        let focal_mean = (focal[0] * focal[1]).sqrt();
        let mut normals = [[0.0; LANES]; 3];
        let mut confidence = [0.0; LANES];
        for lane in 0..LANES {
            let n = self.count[lane];
            let (mx, my, mv) = (self.x[lane] / n, self.y[lane] / n, self.v[lane] / n);
            let xx = self.xx[lane] - n * mx * mx;
            let xy = self.xy[lane] - n * mx * my;
            let yy = self.yy[lane] - n * my * my;
            let xv = self.xv[lane] - n * mx * mv;
            let yv = self.yv[lane] - n * my * mv;
            let determinant = xx * yy - xy * xy;
            let found = (n >= 3.0) & (determinant >= 0.5);
            let a = (xv * yy - yv * xy) / determinant;
            let b = (yv * xx - xv * xy) / determinant;
            let c = mv - a * mx - b * my;
            let squares = self.vv[lane] - n * mv * mv - a * xv - b * yv;
            let residual = ((if squares > 0.0 { squares } else { 0.0 }) / n).sqrt();
            let (u0, v0) = (columns[lane] as f32 + 0.5 - middle[0], rows[lane] as f32 + 0.5 - middle[1]);
            let (x, y, z) = (-(a * focal[0]), -(b * focal[1]), -(1.0 + c - a * u0 - b * v0));
            let scale = 1.0 / (x * x + y * y + z * z).sqrt();
            let usable = found & (scale > 0.0) & (scale < f32::INFINITY);
            let (x, y, z) = (x * scale, y * scale, z * scale);
            let away = x * (u0 / focal[0] / center[lane])
                + y * (v0 / focal[1] / center[lane])
                + z * (1.0 / center[lane])
                > 0.0;
            for (axis, value) in [x, y, z].into_iter().enumerate() {
                let toward = if away { -value } else { value };
                normals[axis][lane] = if usable { toward } else { 0.0 };
            }
            let filled = n / 25.0 * 1.6;
            let filled = if filled < 1.0 { filled } else { 1.0 };
            let flatness = 1.0 / (1.0 + residual * 2.0 * focal_mean);
            confidence[lane] = if found { filled * flatness } else { 0.0 };
        }
        (normals, confidence)
    }
}
