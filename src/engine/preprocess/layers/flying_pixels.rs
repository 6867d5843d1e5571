//! Flying pixels: samples in the air between the foreground and the background of a depth step.
//!
//! Purpose: a depth sensor whose pixel sees two surfaces gives a depth between them, where nothing is. Seen from elsewhere such
//! samples float beside every silhouette. Source: a surface through them would be nearly parallel to the ray, as in the jump-edge
//! filter of S. May et al., *Three-dimensional mapping with time-of-flight cameras*, Journal of Field Robotics 2009. What differs:
//! the angle alone also finds surfaces seen at a grazing angle, and thin things beside others. So the rule needs two surfaces on
//! opposite sides, one nearer and one farther, and neither may run through the sample. A sample that continues its neighbors straight
//! on, in whatever direction, is part of a thing.
//!
//! ```text
//!   depth   ┊        B B      beyond the sample there is a surface B that is farther,
//!           ┊      ∘          the sample lies off both,
//!           ┊ A A             before it a surface A that is nearer
//!           └─────────────▶ pixels of a row, column or diagonal
//! ```
//!
//! A surface is two neighbors whose depths differ by less than an edge. The distance between these two separates noise from flight.
//! On exact depth 0.02 to 0.15 % of the samples are taken for flying ones. Without the test for continuing neighbors there are several
//! times as many where stems are in front of each other.

use super::layer::CameraLayer;
use super::surface_edge::SurfaceEdge;
use crate::capture::Camera;

/// A surface begins within this many pixels of the sample: next to it, or behind another flying pixel.
const REACH: isize = 2;

/// A sample flies if its distance from a surface is at least this many times the distance between two neighbors on the surface.
const BEYOND_ROUGHNESS: f32 = 3.0;

/// A sample is off a surface by more than this share of an edge. With a whole edge, of the flights by more than 3 % of the depth in
/// `nine-cameras` 32 % are found, with half of one 43 %.
const OFF: f32 = 0.5;

/// A sample continues its neighbors if it is off their line by no more than this share of an edge.
const CONTINUED: f32 = 0.25;

/// Half of the directions; the others are opposite.
const DIRECTIONS: [(isize, isize); 4] = [(1, 0), (0, 1), (1, 1), (1, -1)];

/// Tells flying pixels of a layer.
pub(super) struct FlyingTest<'a> {
    layer: &'a CameraLayer,
    edge: SurfaceEdge,
}

/// What is beside a sample in one direction, inverse depths.
#[derive(Clone, Copy)]
struct SurfaceBeside {
    nearest_pixel: f32,
    /// What the surface would be at the sample if it went on straight: inverse depth is linear over a plane.
    continued: f32,
    /// How far its two pixels are apart.
    roughness: f32,
}

impl<'a> FlyingTest<'a> {
    /// For a layer of `camera`. A step in depth of more than `edge_footprints` parts two surfaces.
    pub(super) fn new(layer: &'a CameraLayer, camera: &Camera, edge_footprints: f32) -> Self {
        Self { layer, edge: SurfaceEdge::new(camera, edge_footprints) }
    }

    /// Whether the sample at pixel `(x, y)` flies. One at infinity does not.
    pub(super) fn is_flying(&self, x: usize, y: usize) -> bool {
        let here = self.layer.inverse_depth[y * self.layer.width + x];
        here > 0.0
            && DIRECTIONS.iter().any(|&along| self.is_between(x, y, here, along))
            && !DIRECTIONS.iter().any(|&along| self.is_continued(x, y, here, along))
    }

    /// Whether the sample is on the line through its neighbors on both sides, or through the two on one side.
    fn is_continued(&self, x: usize, y: usize, here: f32, (dx, dy): (isize, isize)) -> bool {
        let at = |steps: isize| self.inverse_depth(x, y, (dx * steps, dy * steps));
        let beside = |steps| at(steps).filter(|there| self.is_one_surface(here, *there));
        let is_close = |expected: f32| (expected - here).abs() <= CONTINUED * self.edge.relative(here) * here;
        let on_one_side = |steps: isize| {
            let (Some(first), Some(second)) = (beside(steps), at(2 * steps)) else { return false };
            self.is_one_surface(first, second) && is_close(2.0 * first - second)
        };
        let between = || beside(1).zip(beside(-1)).is_some_and(|(a, b)| is_close(0.5 * (a + b)));
        on_one_side(1) || on_one_side(-1) || between()
    }

    /// Whether of the surfaces on both sides one is nearer, one is farther, and the sample is off both.
    fn is_between(&self, x: usize, y: usize, here: f32, (dx, dy): (isize, isize)) -> bool {
        let at = |steps: isize| self.inverse_depth(x, y, (dx * steps, dy * steps));
        // Nearly all samples have their own surface on either side.
        let is_beside = |steps| at(steps).is_some_and(|there| !self.is_apart(here, there));
        if is_beside(1) || is_beside(-1) {
            return false;
        }
        let (Some(before), Some(behind)) = (self.surface(&at, 1), self.surface(&at, -1)) else {
            return false;
        };
        let (near, far) =
            if before.nearest_pixel > behind.nearest_pixel { (before, behind) } else { (behind, before) };
        let rough = BEYOND_ROUGHNESS * near.roughness.max(far.roughness);
        let is_off = |surface: &SurfaceBeside| {
            let apart = |there: f32| (there - here).abs() > rough && self.is_apart(here, there);
            apart(surface.nearest_pixel) && apart(surface.continued)
        };
        near.nearest_pixel > here && here > far.nearest_pixel && is_off(&near) && is_off(&far)
    }

    /// The first surface in a direction.
    fn surface(&self, at: &impl Fn(isize) -> Option<f32>, direction: isize) -> Option<SurfaceBeside> {
        (1..=REACH).find_map(|steps| {
            let (first, second) = (at(direction * steps)?, at(direction * (steps + 1))?);
            let slope = first - second;
            self.is_one_surface(first, second).then(|| SurfaceBeside {
                nearest_pixel: first,
                continued: first + slope * steps as f32,
                roughness: slope.abs(),
            })
        })
    }

    fn is_one_surface(&self, a: f32, b: f32) -> bool {
        (a - b).abs() <= self.edge.between(a, b)
    }

    fn is_apart(&self, a: f32, b: f32) -> bool {
        (a - b).abs() > OFF * self.edge.between(a, b)
    }

    /// Inverse depth at an offset from a pixel; `None` outside the picture and where there is no sample.
    fn inverse_depth(&self, x: usize, y: usize, (dx, dy): (isize, isize)) -> Option<f32> {
        let x = x.checked_add_signed(dx).filter(|x| *x < self.layer.width)?;
        let y = y.checked_add_signed(dy).filter(|y| *y < self.layer.height())?;
        Some(self.layer.inverse_depth[y * self.layer.width + x]).filter(|there| *there >= 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capture::Intrinsics;
    use glam::DVec3;

    /// Columns of the samples that fly in a row with these depths, between rows with the depths of `around`.
    fn flying(depths: &[f32], around: &[f32]) -> Vec<usize> {
        let (width, height) = (depths.len(), 5);
        // Eight footprints are a tenth of the depth.
        let lens =
            Intrinsics { fx: 80.0, fy: 80.0, ..Intrinsics::from_horizontal_angle(width as u32, 5, 0.2) };
        let camera = Camera::look_at("c", lens, DVec3::ZERO, DVec3::Y, DVec3::Z);
        let mut layer = CameraLayer::empty(width, height);
        for pixel in 0..width * height {
            let depth = if pixel / width == 2 { depths } else { around }[pixel % width];
            layer.inverse_depth[pixel] = if depth < 0.0 { -1.0 } else { 1.0 / depth };
        }
        let test = FlyingTest::new(&layer, &camera, 8.0);
        (0..width).filter(|x| test.is_flying(*x, 2)).collect()
    }

    const STEP: [f32; 8] = [2.0, 2.0, 2.0, 2.0, 5.0, 5.0, 5.0, 5.0];

    #[test]
    fn a_sample_between_foreground_and_background_flies_and_both_edges_do_not() {
        assert_eq!(flying(&[2.0, 2.0, 2.0, 3.0, 5.0, 5.0, 5.0, 5.0], &STEP), [3]);
        assert_eq!(flying(&STEP, &STEP), [0; 0]);
        let sky = STEP.map(|depth| if depth > 2.0 { f32::INFINITY } else { depth });
        assert_eq!(
            flying(&[2.0, 2.0, 2.0, 3.5, sky[4], sky[4], sky[4], sky[4]], &sky),
            [3],
            "before the sky"
        );
    }

    #[test]
    fn two_samples_in_the_air_beside_each_other_fly_in_either_order() {
        for pair in [[2.6, 3.8], [3.8, 2.6]] {
            assert_eq!(flying(&[2.0, 2.0, 2.0, pair[0], pair[1], 5.0, 5.0, 5.0], &STEP), [3, 4]);
        }
    }

    #[test]
    fn a_plane_at_a_grazing_angle_does_not_fly_to_its_very_edge() {
        let [first, second, third, fourth] = [1.0_f32, 0.905, 0.81, 0.715].map(f32::recip);
        assert_eq!(flying(&[first, second, third, fourth, 9.0, 9.0, 9.0], &[9.0; 7]), [0; 0]);
        // Off its line it flies.
        assert_eq!(flying(&[first, second, third, 2.5, 9.0, 9.0, 9.0], &[9.0; 7]), [3]);
    }

    #[test]
    fn thin_things_and_what_lies_beside_a_hole_do_not_fly() {
        let before = [5.0, 5.0, 5.0, 3.0, 5.0, 5.0, 5.0];
        assert_eq!(flying(&before, &[5.0; 7]), [0; 0], "nothing is nearer");
        let between = [2.0, 2.0, 2.0, 3.0, 5.0, 5.0, 5.0];
        assert_eq!(flying(&between, &between), [0; 0], "it goes on above and below");
        let hole = [2.0, 2.0, 2.0, 3.0, -1.0, -1.0, -1.0];
        assert_eq!(
            flying(&hole, &[2.0, 2.0, 2.0, 2.0, -1.0, -1.0, -1.0]),
            [0; 0],
            "nobody knows what is behind"
        );
    }
}
