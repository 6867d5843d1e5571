//! Pixels carried forward one by one, each as a square as wide as it appears, nearest first.
//!
//! The nearest camera, warped.
//!
//! Purpose: the simplest baseline.
//!
//! Source: L. `McMillan` and G. Bishop, *Plenoptic Modeling: An Image-Based Rendering System*, SIGGRAPH 1995, §3.3: every pixel of a
//! picture with depth is carried forward to the new viewpoint by its generalized disparity, and drawn as large as it appears there.
//!
//! What differs: pictures are planar, not cylindrical; a z-buffer decides instead of the order in which pixels are visited, with the
//! same result; a pixel is a square of whole pixels.

use glam::{DAffine3, DMat3, DVec2, DVec3};

use super::model::{RecordedView, RivalModel};
use super::sky::by_distance;
use overlook_engine::capture::Camera;
use overlook_engine::grid::Grid;
use overlook_engine::render::{NO_IMAGE, Picture};

/// Widest square, pixels: as wide as the largest splat of the layered depth images.
const MAX_WIDTH: f64 = 7.0;

/// A picture that pixels of one camera, or several, are carried to.
pub(super) struct Splatter {
    target: Camera,
    target_from_world: DAffine3,
    nearest: Grid<f32>,
    color: Grid<[f32; 3]>,
}

/// The map from the pixels of a camera to those of the target.
pub(super) struct PixelMap {
    source: Camera,
    target_from_source: DMat3,
    /// In the target's space, what a pixel moves by for each unit of inverse depth.
    shift: DVec3,
    /// A pixel's width in the target for equal depths.
    focal_ratio: f64,
}

impl Splatter {
    pub(super) fn new(target: &Camera) -> Self {
        let (width, height) = target.intrinsics.size();
        Self {
            target: target.clone(),
            target_from_world: target.camera_from_world(),
            nearest: Grid::filled(width, height, -1.0),
            color: Grid::filled(width, height, [0.0; 3]),
        }
    }

    pub(super) fn map_from(&self, source: &Camera) -> PixelMap {
        let target_from_world = self.target_from_world;
        let (from, to) = (source.intrinsics, self.target.intrinsics);
        PixelMap {
            source: source.clone(),
            target_from_source: target_from_world.matrix3 * source.world_from_camera.matrix3,
            shift: target_from_world.transform_point3(source.position_in_world()),
            focal_ratio: ((to.fx * to.fy) / (from.fx * from.fy)).sqrt(),
        }
    }

    /// Carries the pixel at `position` of the map's camera here, as a square over everything that is not nearer. An inverse depth of 0 is
    /// at infinity.
    pub(super) fn add(&mut self, map: &PixelMap, position: DVec2, inverse_depth: f32, color: [f32; 3]) {
        let ray = map.source.intrinsics.ray_in_camera(position);
        // The point times its inverse depth, so that infinity needs no case of its own.
        let point = map.target_from_source * ray + f64::from(inverse_depth) * map.shift;
        let inverse_here = (f64::from(inverse_depth) / point.z) as f32;
        let Some(at) = self.target.intrinsics.project(point) else { return };
        let width = (map.focal_ratio / point.z).clamp(1.0, MAX_WIDTH);
        let (columns, rows) = self.color.size();
        let covered = |center: f64, end: usize| {
            let first = (center - 0.5 * width + 0.5).floor().max(0.0) as usize;
            let last = (center + 0.5 * width + 0.5).floor().clamp(0.0, end as f64) as usize;
            first..last
        };
        if !(at.x > -MAX_WIDTH && at.y > -MAX_WIDTH) {
            return;
        }
        for y in covered(at.y, rows) {
            for x in covered(at.x, columns) {
                if inverse_here > self.nearest[(x, y)] {
                    self.nearest[(x, y)] = inverse_here;
                    self.color[(x, y)] = color;
                }
            }
        }
    }

    pub(super) fn finish(self) -> Picture {
        let image = self.nearest.map(|nearest| if *nearest >= 0.0 { 0 } else { NO_IMAGE });
        let (width, height) = self.color.size();
        Picture { color: self.color, inverse_depth: self.nearest, image, ..Picture::empty(width, height) }
    }
}

/// All views; each viewpoint is shown from one of them.
pub(super) struct NearestCamera(Vec<RecordedView>);

impl NearestCamera {
    pub(super) fn new(views: &[RecordedView]) -> Self {
        Self(views.to_vec())
    }
}

impl RivalModel for NearestCamera {
    fn render(&self, target: &Camera) -> Picture {
        let view = by_distance(&self.0, target)[0];
        let mut splatter = Splatter::new(target);
        let map = splatter.map_from(&view.camera);
        let width = view.frame.size().0;
        let pixels = view.frame.inverse_depth.as_slice().iter().zip(view.frame.color.as_slice()).enumerate();
        for (pixel, (inverse_depth, color)) in pixels {
            if *inverse_depth >= 0.0 {
                let center = DVec2::new((pixel % width) as f64 + 0.5, (pixel / width) as f64 + 0.5);
                splatter.add(&map, center, *inverse_depth, color.map(half::f16::to_f32));
            }
        }
        splatter.finish()
    }

    fn bytes(&self) -> Option<u64> {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rivals::tests::slope;

    #[test]
    fn from_a_camera_of_its_own_the_picture_is_that_cameras_and_from_beside_it_has_no_cracks() {
        let (left, right) = (slope(-0.3), slope(0.3));
        let both = NearestCamera::new(&[left.clone(), right.clone()]);
        for view in [&left, &right] {
            let picture = both.render(&view.camera);
            let same = picture.color.as_slice().iter().zip(view.frame.color.as_slice());
            assert!(same.clone().all(|(shown, known)| shown[0] == known[0].to_f32()));
        }
        let beside = both.render(&slope(0.2).camera);
        assert!((4..28).all(|y| (8..40).all(|x| beside.image[(x, y)] == 0)));
    }
}
