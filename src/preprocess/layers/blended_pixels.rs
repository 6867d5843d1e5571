//! Blended pixels: silhouette pixels whose color is mixed of both sides while their depth belongs to one.
//!
//! Purpose: an anti-aliased silhouette carries a color that belongs to no surface; left alone it is painted as a bright or
//! dark fringe wherever it lands. Source: none in the paper, which reports that anti-aliased input looked worse (§4).
//! Rule: across a depth step the pixel's color lies between its own side's and the other side's, away from its own.
//!
//! Limit: a sample is looked at when its span is decided, and samples of shorter spans are not there yet. Where the other
//! side, or the neighbor on the pixel's own, lives in a shorter span, as what passes behind a thing at rest does, blending
//! goes unseen, and the sample counts as a clean one: 5 to 9 % of the blended pixels of the built-in scene `nine-cameras`, and
//! 31 % where no noise is granted, as spans are short there.

use super::layer::CameraLayer;
use crate::capture::Camera;
use crate::color;

/// The two sides must differ by this much, 8-bit sRGB steps, for blending to show.
const MIN_CONTRAST_STEPS: f32 = 12.0;

/// Share of the other side's color from which a pixel counts as blended.
const MIN_SHARE: f32 = 0.12;

/// How far the color may lie off the line between the two sides, as a share of their distance.
const MAX_OFF_LINE: f32 = 0.35;

/// Tells blended pixels of a layer.
pub(super) struct BlendedTest<'a> {
    layer: &'a CameraLayer,
    edge_relative: f32,
}

impl<'a> BlendedTest<'a> {
    /// For a layer of `camera`. A step in depth of more than `edge_footprints` parts two surfaces.
    pub(super) fn new(layer: &'a CameraLayer, camera: &Camera, edge_footprints: f32) -> Self {
        let k = camera.intrinsics;
        Self { layer, edge_relative: edge_footprints / ((k.fx * k.fy).sqrt() as f32) }
    }

    /// Whether pixel `(x, y)` is blended with one of its neighbors.
    pub(super) fn is_blended(&self, x: usize, y: usize) -> bool {
        DIRECTIONS.iter().any(|&toward| self.is_blended_toward(x, y, toward))
    }

    /// The pixel `steps` steps from `(x, y)` in a direction; `None` outside the picture.
    fn pixel(&self, x: usize, y: usize, (dx, dy): (isize, isize), steps: isize) -> Option<usize> {
        let x = x.checked_add_signed(dx * steps).filter(|x| *x < self.layer.width)?;
        let y = y.checked_add_signed(dy * steps).filter(|y| *y < self.layer.height())?;
        Some(y * self.layer.width + x)
    }

    fn is_one_surface(&self, a: usize, b: usize) -> bool {
        let (a, b) = (self.layer.inverse_depth[a], self.layer.inverse_depth[b]);
        a >= 0.0 && b >= 0.0 && (a - b).abs() <= a.max(b) * self.edge_relative
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
        let [c_here, c_other, c_own] =
            [here, other, own].map(|i| glam::Vec3::from(self.layer.color[i].map(color::steps_from_linear)));
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
}
