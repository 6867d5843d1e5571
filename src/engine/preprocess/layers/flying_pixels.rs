//! Pixels that belong to no surface: those between two surfaces in depth, and those whose color blends two.
//!
//! How far the inverse depths of neighboring pixels may differ on one surface.
//!
//! Purpose: the one rule of what is a step in depth, for everything that looks at one picture. Source: none; a number of footprints, which
//! in perspective is a share of the depth, and of an orthographic camera a distance.
//!
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
//!
//! Blended pixels: silhouette pixels whose color is mixed of both sides while their depth belongs to one.
//!
//! Purpose: an anti-aliased silhouette carries a color that belongs to no surface; left alone it is painted as a bright or
//! dark fringe wherever it lands. Source: none in the paper, which reports that anti-aliased input looked worse (§4).
//! Rule: across a depth step the pixel's color is between its own side's and the other side's, away from its own. A pixel of the sky
//! beside anything else is blended as well if its color differs from that of the nearest clean sky: the surface that it is blended
//! with may be too thin to be seen beside it, or move and live in a shorter span.
//!
//! Limit: a sample of a surface is tested when its span is decided, before samples of shorter spans are there. If the other side lives in a
//! shorter span, as a thing that passes behind one at rest does, blending is not detected and the sample counts as clean. This concerns 5 to
//! 9 % of the blended pixels of the built-in scene `nine-cameras`, and 31 % where no noise is granted, as spans are short there.

use glam::Vec3;

use super::layer::CameraLayer;
use crate::capture::Camera;
use crate::capture::overlap::relative_side;
use crate::color;

/// The step in depth that parts two surfaces.
#[derive(Clone, Copy, Debug)]
pub(super) struct SurfaceEdge {
    /// In perspective as a share of the depth, else in world units.
    size: f32,
    is_orthographic: bool,
}

impl SurfaceEdge {
    /// A step of more than so many footprints of `camera`.
    pub(super) fn new(camera: &Camera, footprints: f32) -> Self {
        let k = camera.intrinsics;
        Self { size: footprints / ((k.fx * k.fy).sqrt() as f32), is_orthographic: k.is_orthographic() }
    }

    /// The step as a share of the depth at an inverse depth.
    #[inline(always)]
    pub(super) fn relative(self, inverse_depth: f32) -> f32 {
        relative_side(self.size, self.is_orthographic, inverse_depth)
    }

    /// By how much two inverse depths of one surface may differ.
    #[inline(always)]
    pub(super) fn between(self, a: f32, b: f32) -> f32 {
        // As |z − z'| = |w − w'| / (w w').
        if self.is_orthographic { a * b * self.size } else { a.max(b) * self.size }
    }
}

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

/// The two sides must differ by this much, 8-bit sRGB steps, for blending to show.
const MIN_CONTRAST_STEPS: f32 = 12.0;

/// Share of the other side's color from which a pixel counts as blended.
const MIN_SHARE: f32 = 0.12;

/// Columns and rows around a pixel of the sky in which clean sky is looked for, until some is found: a narrow gap shows none.
const CLEAN_SKY_REACHES: [usize; 3] = [5, 15, 45];

/// How far the color may be off the line between the two sides, as a share of their distance.
const MAX_OFF_LINE: f32 = 0.35;

/// Tells blended pixels of a layer.
pub(super) struct BlendedTest<'a> {
    layer: &'a CameraLayer,
    edge: SurfaceEdge,
}

impl<'a> BlendedTest<'a> {
    /// For a layer of `camera`. A step in depth of more than `edge_footprints` parts two surfaces.
    pub(super) fn new(layer: &'a CameraLayer, camera: &Camera, edge_footprints: f32) -> Self {
        Self { layer, edge: SurfaceEdge::new(camera, edge_footprints) }
    }

    /// Whether pixel `(x, y)` is blended with one of its neighbors.
    pub(super) fn is_blended(&self, x: usize, y: usize) -> bool {
        NEIGHBORS.iter().any(|&toward| self.is_blended_toward(x, y, toward)) || self.is_blended_sky(x, y)
    }

    /// Whether the pixel shows the sky beside a surface, in a color that the sky around has not.
    fn is_blended_sky(&self, x: usize, y: usize) -> bool {
        let here = y * self.layer.width + x;
        self.is_rim_of_sky(here)
            && self
                .clean_sky_around(x, y)
                .is_some_and(|clean| (self.color(here) - clean).length() >= MIN_CONTRAST_STEPS)
    }

    /// Whether a pixel shows the sky, and one of its neighbors something else: a surface, or what a layer of several frames has not,
    /// such as one that moves.
    fn is_rim_of_sky(&self, pixel: usize) -> bool {
        let depths = &self.layer.inverse_depth;
        let (x, y) = (pixel % self.layer.width, pixel / self.layer.width);
        depths[pixel] == 0.0 && self.around(x, y, 1).any(|neighbor| depths[neighbor] != 0.0)
    }

    /// The mean color of the sky around a pixel, without its rim; `None` where there is no other.
    fn clean_sky_around(&self, x: usize, y: usize) -> Option<Vec3> {
        let depths = &self.layer.inverse_depth;
        let is_clean = |pixel: &usize| depths[*pixel] == 0.0 && !self.is_rim_of_sky(*pixel);
        let within = |reach: usize| {
            let clean = self.around(x, y, reach).filter(is_clean);
            let (sum, count) =
                clean.fold((Vec3::ZERO, 0.0), |(sum, count), pixel| (sum + self.color(pixel), count + 1.0));
            (count > 0.0).then(|| sum / count)
        };
        CLEAN_SKY_REACHES.into_iter().find_map(within)
    }

    /// The pixels at most this many columns and rows from `(x, y)`.
    fn around(&self, x: usize, y: usize, reach: usize) -> impl Iterator<Item = usize> {
        let (width, height) = (self.layer.width, self.layer.height());
        let columns = x.saturating_sub(reach)..(x + reach + 1).min(width);
        let rows = y.saturating_sub(reach)..(y + reach + 1).min(height);
        rows.flat_map(move |y| columns.clone().map(move |x| y * width + x))
    }

    /// The color of a pixel, 8-bit sRGB steps.
    fn color(&self, pixel: usize) -> Vec3 {
        Vec3::from(self.layer.color[pixel].map(color::steps_from_linear))
    }

    /// The pixel `steps` steps from `(x, y)` in a direction; `None` outside the picture.
    fn pixel(&self, x: usize, y: usize, (dx, dy): (isize, isize), steps: isize) -> Option<usize> {
        let x = x.checked_add_signed(dx * steps).filter(|x| *x < self.layer.width)?;
        let y = y.checked_add_signed(dy * steps).filter(|y| *y < self.layer.height())?;
        Some(y * self.layer.width + x)
    }

    fn is_one_surface(&self, a: usize, b: usize) -> bool {
        let (a, b) = (self.layer.inverse_depth[a], self.layer.inverse_depth[b]);
        a >= 0.0 && b >= 0.0 && (a - b).abs() <= self.edge.between(a, b)
    }

    /// Whether the pixel is blended with its neighbor in that direction; the opposite neighbor shows its own color.
    fn is_blended_toward(&self, x: usize, y: usize, toward: (isize, isize)) -> bool {
        let here = y * self.layer.width + x;
        let (Some(other), Some(own)) = (self.pixel(x, y, toward, 1), self.pixel(x, y, toward, -1)) else {
            return false;
        };
        let has_depth = |pixel: usize| self.layer.inverse_depth[pixel] >= 0.0;
        if !has_depth(here) || !has_depth(other) || self.is_one_surface(here, other) {
            return false;
        }
        if !self.is_one_surface(here, own) {
            return false;
        }
        let [c_here, c_other, c_own] = [here, other, own].map(|pixel| self.color(pixel));
        let across = c_other - c_own;
        let contrast = across.length();
        if contrast < MIN_CONTRAST_STEPS {
            return false;
        }
        let share = (c_here - c_own).dot(across) / (contrast * contrast);
        let off_line = (c_here - c_own - across * share).length() / contrast;
        share > MIN_SHARE && off_line < MAX_OFF_LINE
    }
}

const NEIGHBORS: [(isize, isize); 4] = [(1, 0), (-1, 0), (0, 1), (0, -1)];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capture::{INVALID_INVERSE_DEPTH, Intrinsics};
    use glam::DVec3;
    use half::f16;

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

    #[test]
    fn a_blended_silhouette_is_found_and_a_clean_one_is_not() {
        let camera = Camera::look_at(
            "c",
            Intrinsics::from_horizontal_angle(8, 3, 0.9),
            DVec3::ZERO,
            DVec3::Y,
            DVec3::Z,
        );
        let mut layer = CameraLayer::empty(8, 3);
        for y in 0..3 {
            for x in 0..8 {
                let i = y * 8 + x;
                layer.inverse_depth[i] = if x < 4 { 1.0 } else { 0.1 };
                let linear = match (x, y) {
                    (3, 1) => 0.45,
                    (0..4, _) => 0.8,
                    _ => 0.1,
                };
                layer.color[i] = [f16::from_f32(linear); 3];
            }
        }
        let test = BlendedTest::new(&layer, &camera, 1.0);
        let found: Vec<usize> = (0..24).filter(|pixel| test.is_blended(pixel % 8, pixel / 8)).collect();
        assert_eq!(found, [8 + 3]);
    }

    #[test]
    fn sky_of_another_color_than_around_is_blended_beside_a_surface_at_its_corner_and_between_two() {
        let lens = Intrinsics::from_horizontal_angle(16, 9, 0.9);
        let camera = Camera::look_at("c", lens, DVec3::ZERO, DVec3::Y, DVec3::Z);
        let mut layer = CameraLayer::empty(16, 9);
        layer.inverse_depth.fill(0.0);
        layer.color.fill([f16::from_f32(0.8); 3]);
        let mut set = |x: usize, y: usize, inverse_depth: f32, linear: f32| {
            (layer.inverse_depth[y * 16 + x], layer.color[y * 16 + x]) =
                (inverse_depth, [f16::from_f32(linear); 3]);
        };
        set(2, 2, 1.0, 0.1);
        set(3, 3, 0.0, 0.4);
        for y in 0..9 {
            set(8, y, 1.0, 0.1);
            set(9, y, 0.0, if y == 4 { 0.5 } else { 0.8 });
            set(10, y, 1.0, 0.1);
        }
        // Not beside a surface, so it is the sky's own.
        set(14, 7, 0.0, 0.4);
        // What moves is not in the layer.
        set(13, 2, INVALID_INVERSE_DEPTH, 0.0);
        set(14, 2, 0.0, 0.4);
        let test = BlendedTest::new(&layer, &camera, 1.0);
        let found: Vec<usize> = (0..16 * 9).filter(|pixel| test.is_blended(pixel % 16, pixel / 16)).collect();
        assert_eq!(found, [2 * 16 + 14, 3 * 16 + 3, 4 * 16 + 9]);
    }

    #[test]
    fn in_a_gap_that_is_too_narrow_for_clean_sky_the_sky_farther_off_tells_what_is_blended() {
        let lens = Intrinsics::from_horizontal_angle(40, 9, 0.9);
        let camera = Camera::look_at("c", lens, DVec3::ZERO, DVec3::Y, DVec3::Z);
        let mut layer = CameraLayer::empty(40, 9);
        let of_column = |x: usize| match x {
            8 => (0.0, 0.8),
            9 => (0.0, 0.4),
            0..20 => (1.0, 0.1),
            _ => (0.0, 0.8),
        };
        for pixel in 0..40 * 9 {
            let (inverse_depth, linear) = of_column(pixel % 40);
            (layer.inverse_depth[pixel], layer.color[pixel]) = (inverse_depth, [f16::from_f32(linear); 3]);
        }
        let test = BlendedTest::new(&layer, &camera, 1.0);
        let found: Vec<usize> = (0..40).filter(|x| test.is_blended_sky(*x, 4)).collect();
        assert_eq!(found, [9]);
    }
}
