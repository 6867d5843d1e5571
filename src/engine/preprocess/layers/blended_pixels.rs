//! Blended pixels: silhouette pixels whose color is mixed of both sides while their depth belongs to one.
//!
//! Purpose: an anti-aliased silhouette carries a color that belongs to no surface; left alone it is painted as a bright or
//! dark fringe wherever it lands. Source: none in the paper, which reports that anti-aliased input looked worse (§4).
//! Rule: across a depth step the pixel's color is between its own side's and the other side's, away from its own. A pixel of the sky
//! beside any surface is blended as well if its color differs from that of the sky around: the surface that it is blended
//! with may be too thin to be seen beside it.
//!
//! Limit: a sample is tested when its span is decided, before samples of shorter spans are there. If either side lives in a shorter
//! span, as a thing that passes behind one at rest does, blending is not detected and the sample counts as clean. This concerns 5 to
//! 9 % of the blended pixels of the built-in scene `nine-cameras`, and 31 % where no noise is granted, as spans are short there.

use glam::Vec3;

use super::layer::CameraLayer;
use super::surface_edge::SurfaceEdge;
use crate::capture::Camera;
use crate::color;

/// The two sides must differ by this much, 8-bit sRGB steps, for blending to show.
const MIN_CONTRAST_STEPS: f32 = 12.0;

/// Share of the other side's color from which a pixel counts as blended.
const MIN_SHARE: f32 = 0.12;

/// Columns and rows around a pixel of the sky in which clean sky is looked for.
const CLEAN_SKY_REACH: usize = 5;

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
        DIRECTIONS.iter().any(|&toward| self.is_blended_toward(x, y, toward)) || self.is_blended_sky(x, y)
    }

    /// Whether the pixel shows the sky beside a surface, in a color that the sky around has not.
    fn is_blended_sky(&self, x: usize, y: usize) -> bool {
        let here = y * self.layer.width + x;
        self.is_beside_surface(here)
            && self
                .clean_sky_around(x, y)
                .is_some_and(|clean| (self.color(here) - clean).length() >= MIN_CONTRAST_STEPS)
    }

    /// Whether a pixel shows the sky, and one of its neighbors a surface.
    fn is_beside_surface(&self, pixel: usize) -> bool {
        let depths = &self.layer.inverse_depth;
        let (x, y) = (pixel % self.layer.width, pixel / self.layer.width);
        depths[pixel] == 0.0 && self.around(x, y, 1).any(|neighbor| depths[neighbor] > 0.0)
    }

    /// The mean color of the sky around a pixel, without what is beside a surface; `None` where there is no other.
    fn clean_sky_around(&self, x: usize, y: usize) -> Option<Vec3> {
        let depths = &self.layer.inverse_depth;
        let is_clean = |pixel: &usize| depths[*pixel] == 0.0 && !self.is_beside_surface(*pixel);
        let (sum, count) = self
            .around(x, y, CLEAN_SKY_REACH)
            .filter(is_clean)
            .fold((Vec3::ZERO, 0.0), |(sum, count), pixel| (sum + self.color(pixel), count + 1.0));
        (count > 0.0).then(|| sum / count)
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

const DIRECTIONS: [(isize, isize); 4] = [(1, 0), (-1, 0), (0, 1), (0, -1)];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capture::Intrinsics;
    use glam::DVec3;
    use half::f16;

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
        let test = BlendedTest::new(&layer, &camera, 1.0);
        let found: Vec<usize> = (0..16 * 9).filter(|pixel| test.is_blended(pixel % 16, pixel / 16)).collect();
        assert_eq!(found, [3 * 16 + 3, 4 * 16 + 9]);
    }
}
