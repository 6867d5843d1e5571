//! Samples of smooth surfaces on a lattice, with the plane through each.
//!
//! Purpose: a sample that is carried into other cameras needs the position and the direction of its surface. Source: inverse depth
//! is linear in image position on a plane, so that a plane is fitted by linear least squares in the picture itself. What differs
//! from the normals of preprocessing: the window grows with the noise, and samples that do not fit are dropped.

use glam::{DVec2, DVec3};

use super::reference_view::{LEVELS, ReferenceView};
use crate::median::median;

/// A point of a surface that one camera saw.
#[derive(Clone, Debug)]
pub(crate) struct SurfaceSample {
    /// Image position, pixels.
    pub(crate) pixel: DVec2,
    /// Of the plane at the sample, 1/unit.
    pub(crate) inverse_depth: f64,
    /// Unit length, in camera space, away from the camera.
    pub(crate) normal_in_camera: DVec3,
    /// At each resolution.
    pub(crate) brightness: [f64; LEVELS],
    /// How many resolutions, the finest first, show nothing but the surface around the sample.
    pub(crate) pure_levels: usize,
    /// The region of space that it lies in, by number; the same in all cameras.
    pub(crate) region: usize,
    /// Whether the sample judges corrections rather than taking part in finding them.
    pub(crate) judges: bool,
}

/// How far from a sample the plane is fitted, pixels: with exact depth and with noise.
const RADII: [usize; 2] = [1, 4];
/// Depth is noisy where most planes through 3×3 pixels are off by more, in footprints.
const NOISY_FOOTPRINTS: f64 = 0.1;
/// No plane where pixels are off by more than this, relative to depth: an edge.
const EDGE_RELATIVE: f64 = 0.02;
/// No plane where fewer of the pixels have depth.
const LEAST_VALID: [f64; 2] = [0.8, 0.35];
/// Surfaces seen more from the side are left out: cosine of incidence.
const LEAST_COSINE: f64 = 0.15;

/// About `count` samples of a view.
pub(crate) fn surface_samples(view: &ReferenceView, count: usize) -> Vec<SurfaceSample> {
    let (width, height) = view.frame.size();
    let step = (width * height / count.max(1)).isqrt().max(2);
    let places = |radius: usize| {
        let margin = radius + 2;
        let rows = (step / 2..height).step_by(step).enumerate();
        let places = rows.flat_map(move |(row, y)| {
            let columns = (step / 2..width).step_by(step).enumerate();
            columns.map(move |(column, x)| (x, y, (row + column) % 2 == 1))
        });
        places.filter(move |&(x, y, _)| {
            x >= margin && y >= margin && x + margin < width && y + margin < height && view.is_still(x, y)
        })
    };
    let focal = view.camera.intrinsics.fx;
    let exact = places(RADII[0]).filter_map(|(x, y, _)| plane_at(view, x, y, 0));
    let mut off: Vec<f64> = exact.map(|plane| plane.deviation_relative * focal).collect();
    let is_noisy = median(&mut off).is_none_or(|off| off > NOISY_FOOTPRINTS);
    let window = usize::from(is_noisy);
    let samples = places(RADII[window]).filter_map(|(x, y, judges)| {
        let plane = plane_at(view, x, y, window)?;
        let pixel = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
        let mut brightness = [0.0; LEVELS];
        for (level, value) in brightness.iter_mut().enumerate() {
            *value = view.brightness_at(level, pixel.x, pixel.y)?[0];
        }
        let normal_in_camera = plane.normal_in_camera(view, pixel)?;
        Some(SurfaceSample {
            pixel,
            inverse_depth: plane.inverse_depth,
            normal_in_camera,
            brightness,
            pure_levels: view.pure_levels_at(pixel),
            region: 0,
            judges,
        })
    });
    samples.collect()
}

/// Inverse depth around a pixel: `inverse_depth + slope · (pixel − its center)`.
struct Plane {
    inverse_depth: f64,
    slope: DVec2,
    /// Root mean square of the deviations, relative.
    deviation_relative: f64,
}

impl Plane {
    /// `n·p = 1` for all points `p` of the plane, made unit length; `None` where the plane is seen from the side.
    fn normal_in_camera(&self, view: &ReferenceView, pixel: DVec2) -> Option<DVec3> {
        let lens = &view.camera.intrinsics;
        let at_axis = self.inverse_depth + self.slope.dot(DVec2::new(lens.cx, lens.cy) - pixel);
        let normal = DVec3::new(self.slope.x * lens.fx, self.slope.y * lens.fy, at_axis).try_normalize()?;
        let ray = lens.ray_in_camera(pixel).normalize_or_zero();
        (normal.dot(ray) >= LEAST_COSINE).then_some(normal)
    }
}

fn plane_at(view: &ReferenceView, x: usize, y: usize, window: usize) -> Option<Plane> {
    let (depth, radius) = (&view.frame.inverse_depth, RADII[window]);
    let here = f64::from(depth[(x, y)]);
    if here <= 0.0 {
        return None;
    }
    // Sums of a symmetric window would be diagonal; pixels without depth break the symmetry.
    let (mut n, mut su, mut sv, mut suu, mut suv, mut svv) = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    let (mut sw, mut suw, mut svw, mut sww) = (0.0, 0.0, 0.0, 0.0);
    let width = depth.width();
    let values = depth.as_slice();
    let side = 2 * radius + 1;
    for dy in 0..side {
        let row = &values[(y + dy - radius) * width + x - radius..][..side];
        for (dx, value) in row.iter().enumerate() {
            let w = f64::from(*value) - here;
            if *value <= 0.0 || w.abs() > 0.15 * here {
                continue;
            }
            let (u, v) = (dx as f64 - radius as f64, dy as f64 - radius as f64);
            n += 1.0;
            su += u;
            sv += v;
            suu += u * u;
            suv += u * v;
            svv += v * v;
            sw += w;
            suw += u * w;
            svw += v * w;
            sww += w * w;
        }
    }
    if n < LEAST_VALID[window] * (side * side) as f64 {
        return None;
    }
    let (mu, mv, mw) = (su / n, sv / n, sw / n);
    let (cuu, cuv, cvv) = (suu - su * mu, suv - su * mv, svv - sv * mv);
    let (cuw, cvw, cww) = (suw - su * mw, svw - sv * mw, sww - sw * mw);
    let determinant = cuu * cvv - cuv * cuv;
    if determinant < 1e-6 * cuu * cvv {
        return None;
    }
    let slope = DVec2::new(cuw * cvv - cvw * cuv, cvw * cuu - cuw * cuv) / determinant;
    let inverse_depth = here + mw - slope.x * mu - slope.y * mv;
    let off = (cww - slope.x * cuw - slope.y * cvw).max(0.0) / n;
    let deviation_relative = off.sqrt() / here;
    (inverse_depth > 0.0 && deviation_relative <= EDGE_RELATIVE).then_some(Plane {
        inverse_depth,
        slope,
        deviation_relative,
    })
}
