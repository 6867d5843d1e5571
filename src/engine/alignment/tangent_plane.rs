//! The plane that touches a surface at a pixel.
//!
//! Purpose: the position and direction of a sample that is carried into other cameras. Source: inverse depth is linear in image
//! position on a plane, and on a curved surface close to a polynomial of second degree, which is fitted by linear least squares in the
//! picture itself. A plane through the pixels would lie behind a convex surface: by half a footprint on a ball 24 pixels wide. To make
//! up for half a footprint, cameras around the ball would be moved by ten times as much.

use glam::{DVec2, DVec3};

use super::normal_equations::NormalEquations;
use crate::capture::Intrinsics;
use crate::grid::Grid;

/// No plane where pixels are off by more than this, relative to depth, or where the surface bends by more within the window: an edge.
const EDGE_RELATIVE: f64 = 0.02;
const BENT_RELATIVE: f64 = 0.05;
/// Pixels that differ by more from the one in the middle are of another surface, relative.
const OTHER_RELATIVE: f64 = 0.15;
/// Surfaces seen more from the side are left out: cosine of incidence.
const LEAST_COSINE: f64 = 0.15;
/// Powers of the horizontal and the vertical position in each term of the polynomial.
const TERMS: [[usize; 2]; 6] = [[0, 0], [1, 0], [0, 1], [2, 0], [1, 1], [0, 2]];
/// Weight that pulls the curvature to 0, beside a weight of 1 for each pixel. It only counts where pixels do not determine the curvature.
const PULL: f64 = 1e-6;

/// Inverse depth around a pixel: `inverse_depth + slope · (pixel − its center)` on the plane.
pub(super) struct TangentPlane {
    pub(super) inverse_depth: f64,
    pub(super) slope: DVec2,
    pub(super) bend: SurfaceBend,
    /// Standard deviation of the pixels around the curved surface, relative.
    pub(super) deviation_relative: f64,
}

impl TangentPlane {
    /// `n·p = 1` for all points `p` of the plane, made unit length; `None` where the plane is seen from the side.
    pub(super) fn normal_in_camera(&self, lens: &Intrinsics, pixel: DVec2) -> Option<DVec3> {
        let at_axis = self.inverse_depth + self.slope.dot(DVec2::new(lens.cx, lens.cy) - pixel);
        let normal = DVec3::new(self.slope.x * lens.fx, self.slope.y * lens.fy, at_axis).try_normalize()?;
        let ray = lens.ray_in_camera(pixel).normalize_or_zero();
        (normal.dot(ray) >= LEAST_COSINE).then_some(normal)
    }
}

/// How a surface bends away from the plane that touches it.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct SurfaceBend {
    /// Factors of the terms of second degree, of positions in pixels.
    factors: [f64; 3],
    /// Mean over the pixels of the window, 1/unit: how far a plane through them lies beside the plane that touches.
    pub(crate) mean: f64,
}

/// Farther off than this, in pixels, the surface is taken to bend no more.
const REACH: f64 = 4.0;

impl SurfaceBend {
    /// What is to be added to the inverse depth of the plane at this distance from the pixel that it touches, 1/unit.
    pub(crate) fn at(&self, offset_px: DVec2) -> f64 {
        let DVec2 { x, y } = offset_px.clamp(DVec2::splat(-REACH), DVec2::splat(REACH));
        let [across, both, down] = self.factors;
        across * x * x + both * x * y + down * y * y
    }
}

/// Sums over the pixels of a window. Positions count in radii, so that all terms are of one size.
#[derive(Default)]
struct WindowSums {
    count: f64,
    /// Sums of products of powers of positions.
    powers: [[f64; 5]; 5],
    /// Sums of the values times each term.
    values: [f64; TERMS.len()],
    squares: f64,
}

impl WindowSums {
    fn add(&mut self, u: f64, v: f64, value: f64) {
        let [mut us, mut vs] = [[1.0; 5]; 2];
        for power in 1..5 {
            us[power] = us[power - 1] * u;
            vs[power] = vs[power - 1] * v;
        }
        for (p, row) in self.powers.iter_mut().enumerate() {
            for (q, sum) in row.iter_mut().enumerate().take(5 - p) {
                *sum += us[p] * vs[q];
            }
        }
        for (sum, [p, q]) in self.values.iter_mut().zip(TERMS) {
            *sum += value * us[p] * vs[q];
        }
        self.count += 1.0;
        self.squares += value * value;
    }

    /// The mean of the terms of second degree, with these factors.
    fn mean(&self, bends: [f64; 3]) -> f64 {
        let sums = TERMS[3..].iter().map(|[p, q]| self.powers[*p][*q]);
        bends.iter().zip(sums).map(|(bend, sum)| bend * sum).sum::<f64>() / self.count
    }

    /// The factors of the terms, and the sum of the squares that is left.
    fn fitted(&self) -> Option<([f64; TERMS.len()], f64)> {
        let mut equations = NormalEquations::new(TERMS.len());
        for (row, [p, q]) in TERMS.into_iter().enumerate() {
            for (column, [other_p, other_q]) in TERMS.into_iter().enumerate().take(row + 1) {
                equations.add(row, column, self.powers[p + other_p][q + other_q]);
            }
            equations.right[row] = self.values[row];
            if p + q == 2 {
                equations.add(row, row, PULL);
            }
        }
        let found = equations.factor()?.solve(&equations.right);
        let mut factors = [0.0; TERMS.len()];
        factors.copy_from_slice(&found);
        let known: f64 = factors.iter().zip(self.values).map(|(factor, sum)| factor * sum).sum();
        Some((factors, (self.squares - known).max(0.0)))
    }
}

/// The plane at a pixel of inverse depths, fitted to what lies up to `radius` pixels around it. `None` without depth, at edges, and where
/// less than `least_valid` of the window, as a share, has depth. The window lies within the picture.
pub(super) fn tangent_plane(
    inverse_depth: &Grid<f32>,
    x: usize,
    y: usize,
    radius: usize,
    least_valid: f64,
) -> Option<TangentPlane> {
    let here = f64::from(inverse_depth[(x, y)]);
    if here <= 0.0 {
        return None;
    }
    let width = inverse_depth.width();
    let side = 2 * radius + 1;
    let place = |at: usize| (at as f64 - radius as f64) / radius as f64;
    let mut sums = WindowSums::default();
    for dy in 0..side {
        let row = &inverse_depth.as_slice()[(y + dy - radius) * width + x - radius..][..side];
        for (dx, value) in row.iter().enumerate() {
            let beyond = f64::from(*value) - here;
            if *value > 0.0 && beyond.abs() <= OTHER_RELATIVE * here {
                sums.add(place(dx), place(dy), beyond);
            }
        }
    }
    let free = sums.count - TERMS.len() as f64;
    if sums.count < least_valid * (side * side) as f64 || free < 1.0 {
        return None;
    }
    let ([beyond, across, down, bends @ ..], off) = sums.fitted()?;
    let bent = bends.iter().map(|bend| bend.abs()).sum::<f64>() / here;
    let deviation_relative = (off / free).sqrt() / here;
    let inverse_depth = here + beyond;
    let is_edge = bent > BENT_RELATIVE || deviation_relative > EDGE_RELATIVE;
    (inverse_depth > 0.0 && !is_edge).then_some(TangentPlane {
        inverse_depth,
        slope: DVec2::new(across, down) / radius as f64,
        bend: SurfaceBend {
            factors: bends.map(|bend| bend / (radius * radius) as f64),
            mean: sums.mean(bends),
        },
        deviation_relative,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_plane_touches_a_ball_and_a_plane_is_itself_though_pixels_are_missing() {
        // A ball 24 pixels wide at two units, seen from its front: inverse depth falls off around the middle.
        let radius = 12.0 * 2.0 / 100.0;
        let ball = |x: f64, y: f64| {
            let beside = (x * x + y * y) * (0.02 * 0.02);
            1.0 / (2.0 + radius - (radius * radius - beside).max(0.0).sqrt())
        };
        for (name, surface) in
            [("ball", &ball as &dyn Fn(f64, f64) -> f64), ("plane", &|x, y| 0.5 + 0.002 * x - 0.001 * y)]
        {
            let mut depth = Grid::from_fn(11, 11, |x, y| surface(x as f64 - 5.0, y as f64 - 5.0) as f32);
            for gap in [(2, 3), (7, 7), (8, 2)] {
                depth[gap] = crate::capture::INVALID_INVERSE_DEPTH;
            }
            let plane = tangent_plane(&depth, 5, 5, 4, 0.35).unwrap();
            let off_footprints = (plane.inverse_depth / 0.5 - 1.0) * 100.0;
            assert!(off_footprints.abs() < 0.03, "{name}: {off_footprints}");
            let slope = if name == "ball" { DVec2::ZERO } else { DVec2::new(0.002, -0.001) };
            assert!(plane.slope.distance(slope) < 2e-5, "{name}: {}", plane.slope);
        }
    }
}
