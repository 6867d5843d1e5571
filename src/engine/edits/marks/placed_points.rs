//! Samples of an image as points in space.

use glam::DVec3;

use super::point_tree::Point;
use crate::capture::{Camera, PixelSide};
use crate::edits::seen::PixelRays;
use crate::samples::{SampleImage, SampleSet};

/// What coordinates count from: near the scene, so that single precision is enough.
#[derive(Clone, Copy, Debug)]
pub(super) struct Origin(pub(super) DVec3);

impl Origin {
    /// In the middle of the cameras.
    pub(super) fn of(outline: &SampleSet) -> Self {
        let sum: DVec3 = outline.cameras.iter().map(Camera::position_in_world).sum();
        Self(sum / outline.cameras.len().max(1) as f64)
    }

    pub(super) fn to_point(self, point_in_world: DVec3) -> [f32; 3] {
        (point_in_world - self.0).as_vec3().to_array()
    }
}

/// All samples of an image that are not at infinity; each reaches so many widths of its pixel.
pub(super) fn points_of(
    image: &SampleImage,
    index: usize,
    camera: &Camera,
    origin: Origin,
    footprints: f64,
) -> Vec<Point> {
    let (rays, inverse_depths) = (PixelRays::of(camera), image.inverse_depths());
    let width = camera.intrinsics.pixel_width(1.0, PixelSide::Longer);
    let points = image.samples().filter(|sample| inverse_depths[sample.index] > 0.0).map(|sample| {
        let seen = rays.seen(sample.x, sample.y, inverse_depths[sample.index]);
        let reach = (footprints * width * camera.intrinsics.spread_at(seen.depth)) as f32;
        Point {
            at: origin.to_point(seen.point_in_world),
            reach,
            head_on: reach,
            image: index as u32,
            index: sample.index as u32,
        }
    });
    points.collect()
}
